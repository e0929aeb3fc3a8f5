//! Reference implementations of both trackers in f64, which `host-sim check` compares with `smr-core`.
//!
//! The crate shares no constant, table or arithmetic with `smr-core`. Its code is slow, but easy to check against the
//! descriptions by eye. The crate root has the paper tracker, [`robust`] the robust one.

mod paper;
pub mod robust;

pub use paper::{Decision, GateNumbers, Numbers, Reference, Scores, Step, Sums};
