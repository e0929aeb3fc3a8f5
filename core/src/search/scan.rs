//! The search: scores or excludes every offset of the window, in steps of bounded work.
//!
//! 1. A descent of the SAD from the last position, then the score where it ends: a good score early excludes more.
//! 2. For the runner-up: the scores of nine offsets far apart, the scouts.
//! 3. Tile by tile, pass by pass: groups of 4x4 offsets are excluded by ranges (`ranges.rs`).
//! 4. The offsets of the remaining groups are scored. Where a backend can, four at a time are bounded first. Scoring
//!    stops as soon as an offset cannot reach the needed score.
//!
//! The result does not depend on the order, nor on how the work is divided into steps.

use super::floor::Leaders;
use super::peak::{Found, Peak, Wanted};
use super::ranges::{Ranges, SIDE, Tile};
use super::window::Window;
use crate::image::{Frame, Image, Rect};
use crate::kernels::ALL_FOUR;
use crate::similarity::{self, Scorer, Table};

/// The inputs of a search; the same in every step.
pub(crate) struct Scene<'a> {
    pub(crate) frame: Frame<'a>,
    pub(crate) template: Image<'a>,
    pub(crate) window: Window,
    pub(crate) scorer: &'a Scorer<'a>,
}

/// The progress of a search, and its working memory.
pub(crate) struct Search<const PIXELS: usize, const SPAN: usize> {
    leaders: Leaders<SPAN>,
    ranges: Ranges<PIXELS, SPAN>,
    /// The present tile.
    tile: Tile,
    stage: Stage,
    place: Place,
    descent: Descent,
    pruning: bool,
    /// The offsets of the present row of a group that may matter: see [`Scorer::candidates`].
    candidates: u8,
    /// Comparisons that the present step may make.
    granted: u32,
    /// Comparisons in the present step.
    work: u32,
    /// Comparisons since the floor was raised last, without those of the present step (modulo 2^32).
    since_floor: u32,
}

/// The next stage.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u8)] // `Done` is 0, so that a workspace in a `static` begins as zeroes
enum Stage {
    Done,
    /// The SAD of the last position.
    LastPosition,
    Descent,
    Scouts,
    /// Rows of ranges.
    Ranges,
    /// The bounds of groups.
    Exclude,
    /// The offsets of groups that were not excluded.
    Refine,
    /// All offsets, where there are no groups.
    Offsets,
}

/// The place that the present stage has reached.
struct Place {
    /// The first offset of the tile, or the present offset where there are no groups.
    column: usize,
    row: usize,
    /// The next neighbour, scout, row of ranges, or group.
    next: usize,
    /// The next offset of the present group.
    offset: u8,
    /// The pass over the tile.
    pass: u8,
}

impl Place {
    /// The place at the start of a tile.
    const fn tile(column: usize, row: usize) -> Self {
        Self { column, row, next: 0, offset: 0, pass: 0 }
    }
}

/// The descent: moves to the least SAD among the centre and its 8 neighbours at distance `step`, then halves `step`.
#[derive(Clone, Copy)]
struct Descent {
    /// The position around which the descent looks.
    x: i32,
    y: i32,
    /// The position with the least SAD so far, and that SAD.
    best: (i32, i32),
    distance: u32,
    step: u8,
}

/// The first step of the descent in pixels: 0, 1, 2, 4 or 8. A step costs as much as 2 offsets (8 SADs of every fourth
/// row). All steps together cost at most 1/64 of the window.
fn first_step(window: &Window) -> u8 {
    first_step_of(window.size())
}

pub(super) fn first_step_of((columns, rows): (usize, usize)) -> u8 {
    match columns * rows / 128 {
        0 => 0,
        steps => 1 << (steps - 1).min(MOST_STEPS - 1),
    }
}

/// Rows from one row that a SAD reads to the next.
pub(super) const SAD_STEP: u16 = 4;

/// The most steps of a descent. The first one is at most 2^(4 - 1) = 8 pixels, so the descent reaches 15. Beyond that
/// the ranges are faster.
pub(super) const MOST_STEPS: usize = 4;

impl<const PIXELS: usize, const SPAN: usize> Search<PIXELS, SPAN> {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self {
            leaders: Leaders::new(),
            ranges: const { Ranges::new() },
            tile: Tile { column: 0, row: 0, columns: 0, rows: 0 },
            stage: Stage::Done,
            place: Place::tile(0, 0),
            descent: Descent { x: 0, y: 0, best: (0, 0), distance: 0, step: 0 },
            pruning: false,
            candidates: 0,
            granted: 0,
            work: 0,
            since_floor: 0,
        }
    }

    /// Starts a search. Without pruning every offset is scored to its last pixel.
    pub(crate) fn begin(&mut self, window: &Window, pruning: bool, wanted: Wanted) {
        self.leaders.reset(window, wanted);
        self.pruning = pruning;
        self.place = Place::tile(0, 0);
        self.stage = if pruning { Stage::LastPosition } else { Stage::Offsets };
    }

    /// Starts a second search of the window, for the runner-up. The peak is known.
    pub(crate) fn begin_runner_up(&mut self, scene: &Scene<'_>, neighbourhood: u16) {
        let peak = self.leaders.best();
        self.leaders.reset(&scene.window, Wanted::RunnerUp(neighbourhood));
        if let Some(peak) = peak {
            self.leaders.note(&scene.window, peak);
        }
        self.begin_scouts();
    }

    /// Continues for about `work` comparisons (at least 1) and returns how many were made. These are counted:
    ///
    /// - 1 for a byte of the template against a byte of the frame, even if scoring stopped before it, or a bound
    ///   excluded the offset;
    /// - 2 for each range;
    /// - 1 for each word of working memory read in a pass over groups or maxima.
    ///
    /// A step exceeds `work` by at most one offset, group or row of ranges, and 7 * `SPAN` words: a pass over the
    /// groups (3), one over the maxima to raise the floor (2), one for the runner-up (2).
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
                self.spend(axes(scene)); // `found` reads the maxima
            }
        }
        self.work
    }

    /// True if the step ends here.
    fn is_spent(&self) -> bool {
        self.work >= self.granted
    }

    pub(crate) fn is_done(&self) -> bool {
        self.stage == Stage::Done
    }

    #[cfg_attr(smr_small, inline(never))]
    fn spend(&mut self, comparisons: u32) {
        self.work = self.work.saturating_add(comparisons);
    }

    /// The result; `None` until the search is done.
    pub(crate) fn found(&self, window: &Window) -> Option<Found> {
        if self.is_done() { self.leaders.found(window) } else { None }
    }

    /// Begins the descent at the last position. If there is no descent, it ends at the last position at once.
    fn last_position(&mut self, scene: &Scene<'_>) {
        let (x, y) = scene.window.centre();
        self.descent = Descent { x, y, best: (x, y), distance: u32::MAX, step: 0 };
        self.stage = Stage::Descent;
        let step = first_step(&scene.window);
        if step > 0
            && let Some(distance) = self.sad(scene, x, y, u32::MAX)
        {
            (self.descent.distance, self.descent.step) = (distance, step);
        }
    }

    /// Compares the next neighbour, row by row. After the last one the next step of the descent begins, or the descent
    /// ends.
    #[cfg_attr(smr_small, inline(never))]
    fn descend(&mut self, scene: &Scene<'_>) {
        let Descent { x, y, best, distance: least, step } = self.descent;
        if step == 0 {
            self.score(scene, x, y);
            if self.leaders.needed() == 0 {
                // If all offsets score 0, the last position is the peak. Groups that cannot score more are excluded
                // below.
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
            let (x, y) = (x + third(next % 3, step), y + third(next / 3, step));
            if scene.window.contains(x, y)
                && let Some(distance) = self.sad(scene, x, y, least)
                && distance < least
            {
                (self.descent.best, self.descent.distance) = ((x, y), distance);
            }
        }
    }

    /// The SAD of every fourth row; `None` if the box is not wholly inside the frame. Stops early once the sum exceeds
    /// `enough`.
    #[cfg_attr(smr_small, inline(never))]
    fn sad(&mut self, scene: &Scene<'_>, x: i32, y: i32, enough: u32) -> Option<u32> {
        let patch = scene.frame.patch(Rect::new(x, y, scene.template.width(), scene.template.height()))?;
        self.spend(u32::from(scene.template.width()) * u32::from(scene.template.height().div_ceil(SAD_STEP)));
        scene.scorer.distance(patch.every(0, SAD_STEP.into())?, scene.template.every(0, SAD_STEP.into())?, enough)
    }

    fn begin_scouts(&mut self) {
        self.place.next = 0;
        self.stage = Stage::Scouts;
    }

    /// Scores a scout: one of nine offsets, the corners, the middles of the edges and the centre. If two of them are
    /// far enough apart, they give the runner-up a floor. Only in windows of at least 288 offsets: nine scouts are 1/32
    /// of them.
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

    fn raise_floor(&mut self, scene: &Scene<'_>) {
        if self.leaders.looks_for_runner_up() {
            self.leaders.raise_floor();
            self.spend(axes(scene));
            self.since_floor = self.work.wrapping_neg();
        }
    }

    fn first_tile(&mut self, scene: &Scene<'_>) {
        self.place = Place::tile(0, 0);
        self.stage = if self.pruning && self.ranges.divide(&scene.window, scene.template) {
            Stage::Ranges
        } else {
            Stage::Offsets
        };
    }

    #[inline(never)]
    fn compute_ranges(&mut self, scene: &Scene<'_>) {
        let Place { column, row, next, .. } = self.place;
        let pass = self.place.pass.into();
        if next == 0 && pass == 0 {
            self.tile = self.ranges.tile(&scene.window, column, row);
            self.ranges.begin_tile(&self.tile, area(scene));
        }
        if let Some(rest) = self.ranges.rest(&self.tile) {
            let pixels = self.ranges.pixels(&scene.frame, &scene.window, &rest);
            let rows = self.ranges.rows(&self.tile, &rest, pass);
            let next = next.max(rows.start);
            let next = next + self.compute_several(scene, pixels, &rest, pass, next);
            for next in next..rows.end {
                if self.is_spent() {
                    self.place.next = next;
                    return;
                }
                let Scene { frame, window, scorer, .. } = scene;
                let ranges = self.ranges.compute_row(frame, pixels, window, (&self.tile, &rest), pass, next, scorer);
                self.spend(2 * ranges);
            }
        }
        if pass == 0 {
            self.spend(words(self.tile.groups())); // by `begin_tile`
        }
        self.place.next = 0;
        self.ranges.begin_groups();
        self.stage = Stage::Exclude;
    }

    /// Computes several rows of ranges at once, as many as the grant allows, if the backend can. Returns their number.
    fn compute_several(
        &mut self,
        scene: &Scene<'_>,
        pixels: Option<Image<'_>>,
        rest: &Tile,
        pass: usize,
        next: usize,
    ) -> usize {
        let Some(pixels) = pixels.filter(|_| Scorer::RANGES_OF_ROWS) else { return 0 };
        let a_row = 2 * self.ranges.ranges_in_row(rest);
        let most = self.granted.saturating_sub(self.work).div_ceil(a_row.max(1));
        let most = usize::try_from(most).unwrap_or(usize::MAX);
        let rows = self.ranges.compute_rows(pixels, (&self.tile, rest), pass, next, most, scene.scorer);
        self.spend(a_row * words(rows));
        rows
    }

    #[inline(never)]
    fn exclude(&mut self, scene: &Scene<'_>) {
        let needed = self.leaders.needed().max(1);
        let (pass, groups) = (self.place.pass.into(), self.tile.groups());
        for group in self.place.next..groups {
            if !self.ranges.may_fall_below(group, needed, area(scene), pass) {
                continue;
            }
            if self.is_spent() {
                return;
            }
            let compared = self.ranges.bound_group(scene.template, &self.tile, pass, group, needed, scene.scorer);
            self.spend(compared + words(group - self.place.next));
            self.place.next = group + 1;
        }
        self.spend(words(groups.saturating_sub(self.place.next)));
        self.place.next = 0;
        self.place.pass += 1;
        self.stage = if usize::from(self.place.pass) < self.ranges.passes() { Stage::Ranges } else { Stage::Refine };
    }

    /// The next group of the tile that is not excluded.
    fn next_group(&mut self, needed: u32) -> Option<usize> {
        let group = self.ranges.next_group(&self.tile, self.place.next, needed);
        if group.is_none() {
            self.spend(words(self.tile.groups().saturating_sub(self.place.next)));
        }
        group
    }

    #[inline(never)]
    fn refine(&mut self, scene: &Scene<'_>) {
        while let Some(group) = self.next_group(self.leaders.needed()) {
            let from = self.place.next;
            if group != from {
                (self.place.next, self.place.offset) = (group, 0);
            }
            let new = self.tile.new_in_group(group);
            // Raise the floor at the first remaining group of each row, unless that costs more than 1/32 of the work
            // since.
            let is_first = self.place.offset == 0 && (from == 0 || new.1 != self.tile.new_in_group(from - 1).1);
            if is_first && self.since_floor.wrapping_add(self.work) / 32 >= axes(scene) {
                self.raise_floor(scene);
            }
            self.spend(words(group - from));
            let first = self.tile.group(group);
            while self.place.offset < OFFSETS && self.ranges.reaches(group, self.leaders.needed()) {
                if self.is_spent() {
                    return;
                }
                self.score_in_group(scene, first, new);
                self.place.offset += 1;
            }
            (self.place.next, self.place.offset) = (group + 1, 0);
        }
        self.next_tile(scene);
    }

    /// Scores the present offset of a group, unless an earlier group or tile contains it. At the first offset of each
    /// row of four, finds out which of them may matter.
    fn score_in_group(&mut self, scene: &Scene<'_>, group: (usize, usize), new: (usize, usize)) {
        let Place { column: first_column, row: first_row, offset, .. } = self.place;
        let new = (
            new.0.max(first_column.saturating_sub(self.tile.column)),
            new.1.max(first_row.saturating_sub(self.tile.row)),
        );
        let offset = usize::from(offset);
        let (column, row) = (group.0 + offset % SIDE, group.1 + offset / SIDE);
        let (x, y) = scene.window.position(self.tile.column + column, self.tile.row + row);
        if offset.is_multiple_of(SIDE) {
            let wanted = if row < new.1 { 0 } else { ALL_FOUR << new.0.saturating_sub(column) & ALL_FOUR };
            self.candidates = self.candidates(scene, (x, y), wanted);
        }
        if column < new.0 || row < new.1 {
            return;
        }
        if self.candidates >> (offset % SIDE) & 1 == 0 {
            self.spend(area(scene));
        } else {
            self.score(scene, x, y);
        }
    }

    /// The offsets among the `wanted` from (`x`, `y`) to the right that may matter: see [`Scorer::candidates`]. The
    /// best offset so far is known and left out.
    fn candidates(&self, scene: &Scene<'_>, (x, y): (i32, i32), mut wanted: u8) -> u8 {
        if let Some(best) = self.leaders.best()
            && best.y == y
        {
            wanted &= !1u8.checked_shl(best.x.wrapping_sub(x).cast_unsigned()).unwrap_or(0);
        }
        // Scoring one offset is faster than bounding four.
        if Scorer::BOUNDS_FOUR && wanted & wanted.wrapping_sub(1) != 0 {
            wanted = candidates(scene, (x, y), self.leaders.needed(), wanted).unwrap_or(wanted);
        }
        wanted
    }

    fn next_tile(&mut self, scene: &Scene<'_>) {
        let (columns, rows) = scene.window.size();
        let Tile { column, row, columns: wide, rows: high } = self.tile;
        self.stage = Stage::Ranges;
        if column + wide < columns {
            self.place = Place::tile(column + wide, self.place.row);
        } else if row + high < rows {
            self.place = Place::tile(0, row + high);
        } else {
            self.stage = Stage::Done;
        }
    }

    /// Scores the next offset, row by row.
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

    #[cfg_attr(smr_small, inline(never))]
    fn score(&mut self, scene: &Scene<'_>, x: i32, y: i32) {
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

/// The offsets among the `wanted` from (`x`, `y`) to the right that may score `needed`. The pixels inside the frame at
/// each of the four are bounded. Those outside at each are compared with the padding. The others count as fully
/// similar. `None` if there is nothing to bound.
fn candidates(scene: &Scene<'_>, (x, y): (i32, i32), needed: u32, wanted: u8) -> Option<u8> {
    let Scene { frame, template, scorer, .. } = scene;
    let four = Rect::new(x, y, template.width().saturating_add(3), template.height());
    let seen = four.intersection(frame.bounds());
    let (left, top) = (seen.x.wrapping_sub(x), seen.y.wrapping_sub(y));
    let at_all = Rect::new(left, top, seen.width.checked_sub(3)?, seen.height);
    let mut others = 0;
    if seen != four {
        let at_any = Rect::new(left.saturating_sub(3), top, seen.width.saturating_add(3), seen.height);
        let at_any = at_any.intersection(Rect::new(0, 0, template.width(), template.height()));
        others = at_any.area().saturating_sub(at_all.area()) * u32::from(Table::ONE);
        others = others.saturating_add(scorer.score_on_padding(*template, at_any));
    }
    let needed = needed.checked_sub(others).filter(|&needed| needed > 0)?;
    Some(scorer.candidates(frame.patch(seen)?, template.crop(at_all)?, needed, wanted))
}

/// Offsets of a group.
const OFFSETS: u8 = 16;

/// The `number`-th of -`step`, 0 and `step`.
fn third(number: usize, step: u8) -> i32 {
    match number {
        0 => -i32::from(step),
        1 => 0,
        _ => step.into(),
    }
}

fn area(scene: &Scene<'_>) -> u32 {
    u32::from(scene.template.width()) * u32::from(scene.template.height())
}

/// The number of maxima: one per column and one per row of the window.
fn axes(scene: &Scene<'_>) -> u32 {
    let (columns, rows) = scene.window.size();
    words(columns + rows)
}

fn words(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
