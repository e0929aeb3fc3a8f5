//! Trust: evidence of a look, its running mean, and what is believed by it. All in units of 1/65536, rounded down.

use super::Numbers;
use super::label::ONE;

/// What the reference believes after a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Belief {
    Tracking,
    Uncertain,
    Lost,
}

/// The agreement counts 1, a response of 1/2 or more counts 1/2.
pub fn evidence(agreement: f64, response: f64) -> f64 {
    agreement + 65536.0 * (response / ONE).clamp(0.0, 0.5)
}

/// All evidence that there can be: of a target that was pointed at.
pub const CLEAR: f64 = 98304.0;

/// A running mean, at most [`Numbers::beyond`] more than what the frame says.
pub fn after(numbers: &Numbers, mean: f64, evidence: f64) -> f64 {
    let mean = mean + ((evidence - mean) * numbers.trust_rate / 256.0).floor();
    mean.min(evidence + numbers.beyond)
}

pub fn belief(numbers: &Numbers, mean: f64) -> Belief {
    let confidence = confidence(mean);
    if confidence < numbers.lost_below {
        Belief::Lost
    } else if confidence < numbers.uncertain_below {
        Belief::Uncertain
    } else {
        Belief::Tracking
    }
}

/// Two thirds of the mean: 0 to 65535.
pub fn confidence(mean: f64) -> f64 {
    (mean.max(0.0) * 2.0 / 3.0).floor().min(65535.0)
}
