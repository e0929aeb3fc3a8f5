//! The search: scores or excludes every offset of the window, in steps of bounded work.
//!
//! 1. A descent of the SAD from the last position, then the score where it ends: a good score early excludes more.
//! 2. For the runner-up: the scores of nine offsets far apart, the scouts.
//! 3. Tile by tile, pass by pass: groups of 4x4 offsets are excluded by ranges (`exclusion.rs`).
//! 4. The offsets of the remaining groups are scored. Some backends first bound four offsets at a time. Scoring stops
//!    as soon as an offset cannot reach the needed score.
//!
//! The result depends neither on the order nor on the steps.

use super::progress::{Descent, Place, Scene, Search, Stage, maxima_count};
use super::window::{Wanted, Window};
use crate::image::Rect;

impl<const PIXELS: usize, const SPAN: usize> Search<PIXELS, SPAN> {
    /// Starts a search. Without pruning every offset is scored to its last pixel.
    pub(crate) fn begin(&mut self, window: &Window, pruning: bool, wanted: Wanted) {
        self.leaders.reset(window, wanted);
        self.pruning = pruning;
        self.place = Place::tile(0, 0);
        self.stage = if pruning { Stage::LastPosition } else { Stage::Offsets };
    }

    /// Starts a second search of the window, for the runner-up, with the known peak.
    pub(crate) fn begin_runner_up(&mut self, scene: &Scene<'_>, neighbourhood: u16) {
        let peak = self.leaders.best();
        self.leaders.reset(&scene.window, Wanted::RunnerUp(neighbourhood));
        if let Some(peak) = peak {
            self.leaders.note(&scene.window, peak);
        }
        self.begin_scouts();
    }

    /// Continues for about `work` comparisons (at least 1) and returns their number, counted as follows:
    ///
    /// - 1 for each template pixel at each offset or group, even if it was skipped;
    /// - 2 for each range;
    /// - 1 for each word of working memory read in a pass over groups or maxima.
    ///
    /// A step exceeds `work` by at most one offset, group or row of ranges, and 7 * `SPAN` words: a pass over the
    /// groups (3), over the maxima to raise the floor (2), and over the maxima for the runner-up (2).
    #[inline(never)]
    pub(crate) fn step(&mut self, scene: &Scene<'_>, work: u32) -> u32 {
        self.since_floor = self.since_floor.wrapping_add(self.work);
        (self.work, self.granted) = (0, work.max(1));
        while !self.is_done() && !self.is_spent() {
            match self.stage {
                Stage::LastPosition => self.last_position(scene),
                Stage::Descent => self.descend(scene),
                Stage::Scouts => self.scout(scene),
                Stage::Ranges => self.compute_ranges(scene),
                Stage::Exclude => self.exclude(scene),
                Stage::Refine => self.refine(scene),
                Stage::Offsets => self.next_offset(scene),
                Stage::Done => {}
            }
            if self.is_done() && self.leaders.looks_for_runner_up() {
                self.spend(maxima_count(scene)); // `peaks` reads the maxima
            }
        }
        self.work
    }

    pub(super) fn begin_scouts(&mut self) {
        self.place.next = 0;
        self.stage = Stage::Scouts;
    }

    /// Scores the next of nine scouts: corners, edge middles and centre of the window. Two scouts far enough apart set
    /// a floor for the runner-up. Windows of fewer than 288 offsets have no scouts, so the nine are at most 1/32 of the
    /// offsets.
    fn scout(&mut self, scene: &Scene<'_>) {
        let (columns, rows) = scene.window.size();
        let number = self.place.next;
        if number >= 9 || !self.leaders.looks_for_runner_up() || columns * rows < 288 {
            self.raise_floor(scene);
            return self.first_tile(scene);
        }
        let (x, y) = scene.window.position((columns - 1) * (number % 3) / 2, (rows - 1) * (number / 3) / 2);
        self.score(scene, x, y);
        self.place.next += 1;
    }

    /// Scores the next offset of the window, taken row by row.
    fn next_offset(&mut self, scene: &Scene<'_>) {
        let (columns, rows) = scene.window.size();
        let (x, y) = scene.window.position(self.place.column, self.place.row);
        self.score(scene, x, y);
        self.place.column += 1;
        if self.place.column == columns {
            self.place = Place::tile(0, self.place.row + 1);
        }
        if self.place.row == rows {
            self.stage = Stage::Done;
        }
    }

    /// Begins the descent at the last position. In a small window or for a box partly off the frame, it ends at once.
    pub(super) fn last_position(&mut self, scene: &Scene<'_>) {
        let (x, y) = scene.window.centre();
        self.descent = Descent { x, y, best: (x, y), best_sad: u32::MAX, step: 0 };
        self.stage = Stage::Descent;
        let step = first_step(&scene.window);
        if step > 0
            && let Some(sad) = self.sad(scene, x, y, u32::MAX)
        {
            (self.descent.best_sad, self.descent.step) = (sad, step);
        }
    }

    /// Compares the SAD of the next neighbour with the least SAD so far. After the last one, moves to the position of
    /// the least SAD and halves the step. Once the step is 0, scores that position and ends the descent.
    #[cfg_attr(smr_small, inline(never))]
    pub(super) fn descend(&mut self, scene: &Scene<'_>) {
        let Descent { x, y, best, best_sad, step } = self.descent;
        if step == 0 {
            self.score(scene, x, y);
            if self.leaders.needed() == 0 {
                // If all offsets score 0, the box's last position must be the peak, so scores it before any exclusion.
                let (x, y) = scene.window.centre();
                self.score(scene, x, y);
            }
            return self.begin_scouts();
        }
        let next = self.place.next;
        self.place.next += 1;
        if next == 9 {
            self.place.next = 0;
            (self.descent.x, self.descent.y) = best;
            self.descent.step = step / 2;
        } else if next != 4 {
            let (x, y) = (x + step_offset(next % 3, step), y + step_offset(next / 3, step));
            if scene.window.contains(x, y)
                && let Some(sad) = self.sad(scene, x, y, best_sad)
                && sad < best_sad
            {
                (self.descent.best, self.descent.best_sad) = ((x, y), sad);
            }
        }
    }

    /// The SAD of every fourth row; may stop once it exceeds `enough`. `None` unless the box is wholly in the frame.
    #[cfg_attr(smr_small, inline(never))]
    fn sad(&mut self, scene: &Scene<'_>, x: i32, y: i32, enough: u32) -> Option<u32> {
        let patch = scene.frame.patch(Rect::new(x, y, scene.template.width(), scene.template.height()))?;
        self.spend(u32::from(scene.template.width()) * u32::from(scene.template.height().div_ceil(SAD_STEP)));
        scene.scorer.distance(patch.every(0, SAD_STEP.into())?, scene.template.every(0, SAD_STEP.into())?, enough)
    }
}

/// The first step of the descent in pixels: 0, 1, 2, 4 or 8. The 8 SADs of a step, each of every fourth row, cost as
/// much as scoring 2 offsets; the SADs of all steps together cost at most 1/64 of scoring the window.
fn first_step(window: &Window) -> u8 {
    first_step_of(window.size())
}

pub(super) fn first_step_of((columns, rows): (usize, usize)) -> u8 {
    match columns * rows / 128 {
        0 => 0,
        steps => 1 << (steps - 1).min(MAX_STEPS - 1),
    }
}

/// The row step of a SAD: it reads every fourth row.
pub(super) const SAD_STEP: u16 = 4;

/// The largest number of steps of a descent, which reaches 15 pixels. Farther away, exclusion by ranges is faster.
pub(super) const MAX_STEPS: usize = 4;

/// Element `number` of (-`step`, 0, `step`).
fn step_offset(number: usize, step: u8) -> i32 {
    match number {
        0 => -i32::from(step),
        1 => 0,
        _ => step.into(),
    }
}
