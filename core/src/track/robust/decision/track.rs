//! The track of a target: its place, size and state from frame to frame.

use super::super::config::Config;
use super::super::constants::{Limits, PIXEL, SCALE};
use super::super::features::{Grid, Motion, Place};
use super::super::refiner::Review;
use super::super::verification::Light;
use super::calm::Calm;
use super::confidence::Confidence;
use super::giving_up::Doubt;
use super::redetection::Sweep;
use crate::image::{FineRect, Rect};
use crate::track::{Quality, State};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Track {
    pub(crate) bounds: Rect,
    pub(crate) grid: Grid,
    /// Width and height of the locked box, in pixels.
    pub(crate) size: [u16; 2],
    pub(crate) motion: Motion,
    /// The scale when the state was last *tracking*, in units of 1/65536.
    pub(crate) tracked_scale: u32,
    pub(crate) confidence: Confidence,
    pub(crate) sweep: Sweep,
    pub(crate) quality: Quality,
    pub(crate) review: Review,
    pub(crate) doubt: Doubt,
    pub(crate) light: Light,
    pub(crate) calm: Calm,
}

impl Track {
    pub(crate) fn new(bounds: Rect, target: Rect, limits: Limits) -> Self {
        Self {
            bounds,
            grid: Grid::within(limits, target),
            size: [target.width, target.height],
            motion: Motion::at(Place::of(target)),
            tracked_scale: SCALE,
            confidence: Confidence::FULL,
            sweep: Sweep::new(),
            quality: Quality::NONE,
            review: Review::NONE,
            doubt: Doubt::NONE,
            light: Light::NONE,
            calm: Calm::NEW,
        }
    }

    /// The state of the answer: the worse of the state by confidence and, if the refiner is on, the refiner's opinion.
    #[inline(never)]
    pub(crate) fn state(&self, config: &Config) -> State {
        let (state, opinion) = (self.confidence.state(config), self.review.state());
        if config.refines() && opinion.code() > state.code() { opinion } else { state }
    }

    /// The radius of the search window in the next frame, in cells: smaller while the target is calm.
    pub(crate) fn reach(&self, config: &Config) -> u16 {
        let is_tracked = self.confidence.state(config) == State::Tracking && !self.is_given_up(config);
        if is_tracked { self.calm.reach(config.reach()) } else { config.reach() }
    }

    /// True if the target is given up. False without redetection, because nothing else could find
    /// the target again, and false if the settings exclude the state *lost*.
    pub(crate) fn is_given_up(&self, config: &Config) -> bool {
        config.refines() && config.sweep > 0 && config.lost_below > 0 && self.doubt.gives_up()
    }

    /// The box of the answer: the tracked box, corrected by the refiner.
    #[inline(never)]
    pub(crate) fn bbox(&self) -> FineRect {
        self.corrected(self.motion.place)
    }

    #[cfg_attr(feature = "refiner", inline(never))] // without the refiner its one caller is `bbox`
    pub(crate) fn corrected(&self, place: Place) -> FineRect {
        self.review.correct(self.box_at(place))
    }

    /// The box of the target at a place, without the refiner's correction.
    pub(crate) fn box_at(&self, Place { x, y, scale }: Place) -> FineRect {
        let size = |size: u16| u32::try_from((u64::from(size) * u64::from(scale) + (1 << 7)) >> 8).unwrap_or(u32::MAX);
        let [width, height] = self.size.map(size);
        let corner = |middle: i64, size: u32| {
            let corner = ((middle + PIXEL / 2) >> 4) - i64::from(size / 2);
            i32::try_from(corner).unwrap_or(0)
        };
        FineRect { x: corner(x, width), y: corner(y, height), width, height }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_grows_around_its_middle() {
        let mut track = Track::new(Rect::new(0, 0, 100, 80), Rect::new(20, 30, 10, 20), Limits::STANDARD);
        assert_eq!(track.bbox().whole(), Rect::new(20, 30, 10, 20));
        track.motion.place.scale = 2 * SCALE;
        assert_eq!(track.bbox().whole(), Rect::new(15, 20, 20, 40));
    }
}
