//! The track of a target: its box and state, and its search window (step 1 of the method).

use super::config::Config;
use super::search::{Peak, Radius, Window};
use crate::image::Rect;
use crate::track::{LockError, Quality, State};

/// The state of a target apart from its template.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Track {
    pub(super) target: Rect,
    pub(super) bounds: Rect,
    pub(super) state: State,
    /// Set when the box at the peak of a target that is not lost is partly outside the frame; cleared when a lost
    /// target is found again. While set, `gate_returning` replaces `gate_tracking`.
    pub(super) edge: bool,
    /// Frames since a peak was last accepted.
    pub(super) lost_for: u16,
    pub(super) quality: Quality,
}

impl Track {
    pub(super) const fn new(bounds: Rect, target: Rect) -> Self {
        Self { target, bounds, state: State::Tracking, edge: false, lost_for: 0, quality: Quality::NONE }
    }

    /// Refuses a target that needs more than `pixels` pixels of template or `span` offsets on an axis.
    #[inline(always)] // two copies with known numbers are smaller than one without
    pub(super) fn check_room(&self, pixels: usize, span: usize, config: &Config) -> Result<(), LockError> {
        if !usize::try_from(self.target.area()).is_ok_and(|area| area <= pixels) {
            return Err(LockError::BoxTooLarge);
        }
        let (columns, rows) = Window::largest_size(self.target, config.window_limit, self.bounds, config.padding);
        if columns.max(rows) > span { Err(LockError::WindowTooLarge) } else { Ok(()) }
    }

    /// The window of the next search. Its radius is `window` + `growth` * `lost_for`, at most `window_limit`.
    #[cfg_attr(smr_small, inline(never))]
    pub(super) fn search_window(&self, config: &Config) -> Window {
        let grown =
            |radius: u16, limit: u16| radius.saturating_add(config.growth.saturating_mul(self.lost_for)).min(limit);
        let (radius, limit) = (config.window, config.window_limit);
        let radius = Radius { x: grown(radius.x, limit.x), y: grown(radius.y, limit.y) };
        Window::new(self.target, radius, self.bounds, config.padding)
    }

    #[cfg_attr(smr_small, inline(never))]
    pub(super) fn pixels(&self, config: &Config) -> Rect {
        self.search_window(config).pixels(self.target.width, self.target.height, self.bounds)
    }

    /// Moves the box by `right` and `down` (in 1/256 pixel, rounded to whole pixels), but not out of the padded frame.
    pub(super) fn moved(&mut self, right: i32, down: i32, padding: u16) {
        let by = |units: i32| units.saturating_add(128) >> 8;
        let (x, y) = (self.target.x.saturating_add(by(right)), self.target.y.saturating_add(by(down)));
        self.target = Rect { x, y, ..self.target };
        self.target = self.nearest_on(padding);
    }

    pub(super) fn nearest_on(&self, padding: u16) -> Rect {
        let into = |at: i32, frame: u16, size: u16| {
            let first = -i32::from(padding);
            // Not `clamp`: it can panic.
            at.min(i32::from(frame) + i32::from(padding) - i32::from(size)).max(first)
        };
        let Rect { x, y, width, height } = self.target;
        Rect { x: into(x, self.bounds.width, width), y: into(y, self.bounds.height, height), ..self.target }
    }

    /// The track after a search that found `peak`, which the gate accepted or refused.
    #[cfg_attr(smr_small, inline(never))]
    pub(super) fn after(&self, peak: &Peak, accepted: bool) -> Self {
        let (target, state) = self.at(peak);
        let was_lost = self.state == State::Lost;
        let edge = self.edge || (!was_lost && state == State::Leaving);
        if accepted {
            Self { target, state, edge: edge && !was_lost, lost_for: 0, ..*self }
        } else {
            Self { state: State::Lost, edge, lost_for: self.lost_for.saturating_add(1), ..*self }
        }
    }

    #[cfg_attr(smr_small, inline(never))]
    pub(super) fn at(&self, peak: &Peak) -> (Rect, State) {
        let target = Rect { x: peak.x, y: peak.y, ..self.target };
        (target, if self.bounds.contains(target) { State::Tracking } else { State::Leaving })
    }
}
