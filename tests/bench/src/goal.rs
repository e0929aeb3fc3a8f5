//! One goal for the speed of smr-core: a figure and its upper limit.

use serde::Serialize;

/// What the goals are stated for.
pub const STATED_FOR: &str = "templates of 64x64 in the six TLD recordings (../shared/sequences/tld)";

/// One goal: a figure and its upper limit.
#[derive(Clone, Debug, Serialize)]
pub struct Goal {
    pub work: String,
    pub at_most: f64,
    /// Nothing for ratios.
    pub unit: &'static str,
    pub measured: Option<f64>,
    /// Whether the measured figure is within the limit, whatever the recordings were.
    pub within: Option<bool>,
}

impl Goal {
    /// What was measured, if it was, against what is wanted.
    pub fn new(work: String, at_most: f64, unit: &'static str, measured: Option<f64>) -> Self {
        let within = measured.map(|measured| measured <= at_most);
        Self { work, at_most, unit, measured, within }
    }

    /// The comparison in words.
    pub fn compared(&self) -> String {
        let share = self.measured.unwrap_or(0.0) / self.at_most;
        match self.within {
            None => "not measured".to_owned(),
            Some(true) => format!("within: {share:.2} of it"),
            Some(false) => format!("beyond: {share:.2} times as much"),
        }
    }
}
