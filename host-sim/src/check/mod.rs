//! `smr-core` against the references, score by score, through a recording: one file for each tracker.

mod paper;
pub mod robust;

pub use paper::{Check, OtherPeak, Report};

use serde::Serialize;

/// What did not hold, where.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Violation {
    /// The frame, counted from 1.
    pub frame: usize,
    /// What was compared.
    pub what: String,
    /// What smr-core says.
    pub core: String,
    /// What the reference says, or the bound.
    pub reference: String,
}

/// The most that a score of `pixels` pixels can differ from the exact sum, in units of 1/65535.
fn bound(pixels: u32) -> f64 {
    let n = f64::from(pixels);
    // Half a unit for each table entry. f64 adds n numbers of at most 65535, each off by 2^-52 of itself, and rounds
    // each partial sum of at most n * 65535 by another 2^-53 of itself.
    n * 0.5 + n * (n + 2.0) * 65535.0 * f64::EPSILON
}

/// Something compared, and the two values that differ.
struct Mismatch {
    what: String,
    core: String,
    reference: String,
}

impl Mismatch {
    fn new(what: String, core: impl ToString, reference: impl ToString) -> Self {
        Self { what, core: core.to_string(), reference: reference.to_string() }
    }

    fn in_frame(self, frame: usize) -> Violation {
        Violation { frame, what: self.what, core: self.core, reference: self.reference }
    }
}

fn differs<T: PartialEq + std::fmt::Debug>(what: &str, core: T, reference: T) -> Option<Mismatch> {
    (core != reference).then(|| Mismatch::new(what.into(), format!("{core:?}"), format!("{reference:?}")))
}
