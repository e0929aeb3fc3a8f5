//! The decision: the state (`confidence`), a lost target (`redetection`), and what is remembered (`track`, `saved`).

mod confidence;
mod redetection;
pub(super) mod saved;
mod track;

pub(super) use confidence::{Confidence, Evidence};
pub(super) use redetection::Sweep;
pub(super) use saved::Memory;
pub(super) use track::Track;
