//! The decision: the target's state (`confidence`), giving up (`giving_up`), the search for a lost target
//! (`redetection`), the size of the search window (`calm`), and the memory of a target from frame to frame (`track`, `saved`).

mod calm;
mod confidence;
mod giving_up;
pub(super) mod memory;
mod redetection;
mod track;

pub(super) use calm::Calm;
pub(super) use confidence::{Confidence, Evidence};
pub(super) use giving_up::Doubt;
pub(super) use memory::{Memory, MemoryMut};
pub(super) use redetection::Sweep;
pub(super) use track::Track;
