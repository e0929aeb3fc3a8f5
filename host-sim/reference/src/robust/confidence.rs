//! Confidence: the evidence of a frame, its running mean, and the decision that follows. All in units of 1/65536, rounded down.

use super::Numbers;
use super::gaussian::ONE;

/// The decisions, from the best to the worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Decision {
    Tracking,
    Uncertain,
    Lost,
}

/// Evidence: the agreement plus the response, of which at most 1/2 counts.
pub fn evidence(agreement: f64, response: f64) -> f64 {
    agreement + 65536.0 * (response / ONE).clamp(0.0, 0.5)
}

/// The largest evidence, with which the mean begins.
pub const FULL: f64 = 98304.0;

/// The running mean after a frame. It may be at most [`Numbers::most_lead`] above the evidence of that frame.
pub fn running_mean(numbers: &Numbers, mean: f64, evidence: f64) -> f64 {
    let mean = mean + ((evidence - mean) * numbers.confidence_rate / 256.0).floor();
    mean.min(evidence + numbers.most_lead)
}

/// The mean after the target was found again: its evidence, but too small for *tracking*.
pub fn found_mean(numbers: &Numbers, evidence: f64) -> f64 {
    let least = |confidence: f64| (confidence * 1.5).ceil();
    evidence.min(least(numbers.uncertain_below) - 1.0).max(least(numbers.lost_below))
}

pub fn decision(numbers: &Numbers, mean: f64) -> Decision {
    decided(confidence(mean), numbers.lost_below, numbers.uncertain_below)
}

pub fn decided(trust: f64, lost_below: f64, uncertain_below: f64) -> Decision {
    if trust < lost_below {
        Decision::Lost
    } else if trust < uncertain_below {
        Decision::Uncertain
    } else {
        Decision::Tracking
    }
}

/// Two thirds of the mean: 0 to 65535.
pub fn confidence(mean: f64) -> f64 {
    (mean.max(0.0) * 2.0 / 3.0).floor().min(65535.0)
}
