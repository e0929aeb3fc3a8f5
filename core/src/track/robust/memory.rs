//! The memory of a target from frame to frame.

use super::constants::WEIGHTS;
use super::refiner::First;
use super::template::Template;
use super::track::Track;
use crate::correlation::Filter;

/// Everything that the tracker remembers of a target.
pub(super) struct Memory {
    /// `None` before the first lock.
    pub(super) track: Option<Track>,
    pub(super) filter: Filter<WEIGHTS>,
    pub(super) template: Template,
    /// The first frame's target, as the refiner sees it.
    pub(super) first: First,
}

impl Memory {
    #[inline(always)]
    pub(super) const fn new() -> Self {
        Self { track: None, filter: Filter::new(), template: Template::new(), first: First::new() }
    }
}
