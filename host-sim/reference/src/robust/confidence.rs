//! Evidence of the target in a frame, the running mean of the evidence, and the state that follows from the mean.
//! Evidence and mean are multiples of 1/65536, rounded down.

use super::Numbers;
use super::gaussian::ONE;

/// State of the target, ordered from the best to the worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Decision {
    Tracking,
    Uncertain,
    Lost,
}

/// Evidence of a frame, 0 to 1.5, returned in units of 1/65536: the template's agreement (0 to 1), plus the filter's
/// response clamped to 0 to 1/2.
pub fn evidence(agreement: f64, response: f64) -> f64 {
    agreement + 65536.0 * (response / ONE).clamp(0.0, 0.5)
}

/// Evidence that remains after a veto by the logit for showing the target.
pub fn vetoed(numbers: &Numbers, evidence: f64, logit: f64) -> f64 {
    (evidence - (numbers.veto * (numbers.same_from - logit)).clamp(0.0, numbers.most_veto)).max(0.0)
}

/// Largest evidence (1.5), with which the running mean begins.
pub const FULL: f64 = 98304.0;

/// Running mean of the evidence after a frame, at most [`Numbers::most_lead`] above the frame's evidence.
pub fn running_mean(numbers: &Numbers, mean: f64, evidence: f64) -> f64 {
    let mean = mean + ((evidence - mean) * numbers.confidence_rate / 256.0).floor();
    mean.min(evidence + numbers.most_lead)
}

/// Mean evidence after the target was found again: the frame's evidence, clamped to the range of the state *uncertain*.
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

/// Confidence, 0 to 65535: two thirds of the mean evidence.
pub fn confidence(mean: f64) -> f64 {
    (mean.max(0.0) * 2.0 / 3.0).floor().min(65535.0)
}
