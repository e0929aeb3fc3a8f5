//! The state of a search (progress, budget), and operations that stages share: scoring an offset, raising the floor.

use super::exclusion::{Ranges, Tile};
use super::floor::Leaders;
use super::window::{Peak, Peaks, Window};
use crate::image::{Frame, Image};
use crate::similarity::{self, Scorer};

/// The inputs of a search; the same in every step.
pub(crate) struct Scene<'a> {
    pub(crate) frame: Frame<'a>,
    pub(crate) template: Image<'a>,
    pub(crate) window: Window,
    pub(crate) scorer: &'a Scorer<'a>,
}

/// The progress of a search, and its working memory.
pub(crate) struct Search<const PIXELS: usize, const SPAN: usize> {
    pub(super) leaders: Leaders<SPAN>,
    pub(super) ranges: Ranges<PIXELS, SPAN>,
    pub(super) tile: Tile,
    pub(super) stage: Stage,
    pub(super) place: Place,
    pub(super) descent: Descent,
    pub(super) pruning: bool,
    /// Bit mask of the 4 offsets in a group's present row: set if the offset can change the result. See
    /// [`Scorer::candidates`].
    pub(super) candidates: u8,
    /// The budget of the present step, in comparisons.
    pub(super) granted: u32,
    /// Comparisons made in the present step.
    pub(super) work: u32,
    /// Comparisons since the floor was raised last, without those of the present step (modulo 2^32).
    pub(super) since_floor: u32,
}

#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u8)] // `Done` is 0, so that a workspace in a `static` begins as zeroes
pub(super) enum Stage {
    Done,
    /// Computes the SAD at the box's last position, the centre of the window.
    LastPosition,
    Descent,
    Scouts,
    /// Computes rows of ranges: the minimum and the maximum of each block of 4x4 pixels.
    Ranges,
    /// Computes bounds of groups of 4x4 offsets, and excludes groups.
    Exclude,
    /// Scores the offsets of the groups that were not excluded.
    Refine,
    /// Scores every offset, if the window is not divided into groups.
    Offsets,
}

/// The position of a search within its present stage.
pub(super) struct Place {
    /// The present tile's first offset that no earlier tile contains; without tiles, the present offset.
    pub(super) column: usize,
    pub(super) row: usize,
    /// Index of the next item of the present stage: a neighbour, a scout, a row of the table of ranges, or a group.
    pub(super) next: usize,
    /// Index of the next offset in the present group.
    pub(super) offset: u8,
    pub(super) pass: u8,
}

impl Place {
    /// The place at offset (`column`, `row`) of the window, with all indices 0: the start of a tile, or, if the window
    /// has no tiles, an offset to be scored.
    pub(super) const fn tile(column: usize, row: usize) -> Self {
        Self { column, row, next: 0, offset: 0, pass: 0 }
    }
}

/// The descent: moves to the least SAD of the present position and its 8 neighbours `step` away, then halves `step`.
#[derive(Clone, Copy)]
pub(super) struct Descent {
    /// The position whose neighbours are compared.
    pub(super) x: i32,
    pub(super) y: i32,
    /// The position with the least SAD so far, and that SAD.
    pub(super) best: (i32, i32),
    pub(super) best_sad: u32,
    pub(super) step: u8,
}

impl<const PIXELS: usize, const SPAN: usize> Search<PIXELS, SPAN> {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self {
            leaders: Leaders::new(),
            ranges: const { Ranges::new() },
            tile: Tile { column: 0, row: 0, columns: 0, rows: 0 },
            stage: Stage::Done,
            place: Place::tile(0, 0),
            descent: Descent { x: 0, y: 0, best: (0, 0), best_sad: 0, step: 0 },
            pruning: false,
            candidates: 0,
            granted: 0,
            work: 0,
            since_floor: 0,
        }
    }

    pub(super) fn is_spent(&self) -> bool {
        self.work >= self.granted
    }

    pub(crate) fn is_done(&self) -> bool {
        self.stage == Stage::Done
    }

    #[cfg_attr(smr_small, inline(never))]
    pub(super) fn spend(&mut self, comparisons: u32) {
        self.work = self.work.saturating_add(comparisons);
    }

    pub(crate) fn peaks(&self, window: &Window) -> Option<Peaks> {
        if self.is_done() { self.leaders.peaks(window) } else { None }
    }

    pub(super) fn raise_floor(&mut self, scene: &Scene<'_>) {
        if self.leaders.looks_for_runner_up() {
            self.leaders.raise_floor();
            self.spend(maxima_count(scene));
            self.since_floor = self.work.wrapping_neg();
        }
    }

    #[cfg_attr(smr_small, inline(never))]
    pub(super) fn score(&mut self, scene: &Scene<'_>, x: i32, y: i32) {
        if self.leaders.best().is_some_and(|best| (best.x, best.y) == (x, y)) {
            return; // noted already
        }
        self.spend(area(scene));
        let needed = if self.pruning { self.leaders.needed_at(&scene.window, x, y) } else { 0 };
        let score = similarity::score_at_least(&scene.frame, scene.template, x, y, scene.scorer, needed);
        if let Some(score) = score {
            self.leaders.note(&scene.window, Peak { x, y, score });
        }
    }
}

pub(super) fn area(scene: &Scene<'_>) -> u32 {
    u32::from(scene.template.width()) * u32::from(scene.template.height())
}

pub(super) fn maxima_count(scene: &Scene<'_>) -> u32 {
    let (columns, rows) = scene.window.size();
    words(columns + rows)
}

pub(super) fn words(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
