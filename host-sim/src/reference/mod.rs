//! Both trackers' methods in f64, each written from its description, so that `smr-core` can be held against them.

mod paper;
pub mod robust;

pub use paper::{Decision, GateNumbers, Numbers, Reference, Scores, Step, Sums};
