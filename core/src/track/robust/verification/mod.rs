//! Verification by the early `template`: finds its best `alignment`, adapts it to the `lighting`, computes its
//! `agreement` tile by tile, and finds the target's exact place and size (`refinement`).

pub(super) mod agreement;
mod coarse_alignment;
pub(super) mod lighting;
mod refinement;
mod template;

pub(super) use agreement::{COPIED, Candidate, Comparison, Early, Measures, Verification, Verified};
pub(super) use coarse_alignment::Alignment;
pub(super) use lighting::{Light, measuring, window_contrast};
pub(super) use refinement::{REFINED, Refined, refine};
pub(super) use template::Template;
