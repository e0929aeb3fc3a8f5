//! The methods of both trackers in f64, each written from its description. Checks compare `smr-core` with them.
//!
//! It depends on nothing of this project, and so can take no number, no table and no arithmetic from `smr-core`: pixels, sizes and boxes
//! come as plain numbers. The crate root has the paper's tracker, [`robust`] the other one. It is slow, and meant to be checked
//! against the description by eye. `host-sim check` compares.

mod paper;
pub mod robust;

pub use paper::{Decision, GateNumbers, Numbers, Reference, Scores, Step, Sums};
