//! The memory of a target from frame to frame.

use super::constants::WEIGHTS;
use super::refiner::First;
use super::template::Template;
use super::track::Track;
use crate::correlation::Filter;
use crate::track::update::Owner;

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

    /// Adds all numbers that the rest of an update or of a lock under way depends on: those that are saved.
    pub(super) fn identify(&self, owner: &mut Owner) {
        if let Some(track) = &self.track {
            track.identify(owner);
        }
        self.filter.weights().iter().for_each(|&weight| owner.add(weight.cast_unsigned()));
        if self.track.is_none() {
            return;
        }
        let (pairs, odd) = self.template.mean().as_chunks();
        pairs.iter().for_each(|&[first, second]| owner.add(u32::from(first) << 16 | u32::from(second)));
        odd.iter().for_each(|&pixel| owner.add(pixel.into()));
        self.first.identify(owner);
    }
}
