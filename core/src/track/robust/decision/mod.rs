//! The decision: the state (`confidence`), the search for a lost target (`redetection`), the memory (`track`, `saved`).

mod confidence;
mod redetection;
pub(super) mod saved;
mod track;

pub(super) use confidence::{Confidence, Evidence};
pub(super) use redetection::Sweep;
pub(super) use saved::Memory;
pub(super) use track::Track;
