//! The search: scores or excludes every offset of the window, in steps of bounded work.
//!
//! 1. The last position, then a descent of the SAD from there: a good score early excludes more.
//! 2. For the runner-up nine offsets far apart, the scouts.
//! 3. Tile by tile, pass by pass: groups of 4x4 offsets are excluded by ranges (`ranges.rs`).
//! 4. The offsets of the remaining groups are scored. Scoring stops as soon as an offset cannot reach the needed score.
//!
//! The result does not depend on the order, nor on how the work is divided into steps.

use super::floor::Leaders;
use super::peak::{Found, Peak, Wanted};
use super::ranges::{Ranges, SIDE, Tile};
use super::window::Window;
use crate::image::{Frame, Image, Rect};
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
    leaders: Leaders<SPAN>,
    ranges: Ranges<PIXELS, SPAN>,
    /// The present tile.
    tile: Tile,
    stage: Stage,
    pruning: bool,
    /// Comparisons in the present step.
    work: u32,
    /// Comparisons since the floor was raised last.
    since_floor: u32,
}

/// The next stage.

#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u8)] // `Done` is 0, so that a workspace in a `static` begins as zeroes
enum Stage {
    Done,
    /// The score of the last position.
    LastPosition,
    /// Its SAD.
    FirstSad,
    Descent(Descent),
    /// One of nine offsets: the corners, the middles of the edges and the centre.
    Scout(i32),
    /// A row of ranges.
    Ranges(TilePass, usize),
    /// The bound of a group.
    Exclude(TilePass, usize),
    /// An offset of a group that was not excluded.
    Refine(TilePass, usize, usize),
    /// An offset (column, row), where there are no groups.
    Offsets(usize, usize),
}

/// The first offset of a tile, and the pass.
#[derive(Clone, Copy, PartialEq, Eq)]
struct TilePass {
    column: usize,
    row: usize,
    pass: usize,
}

/// The descent: moves to the least SAD among the centre and its 8 neighbours at distance `step`, then halves `step`.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Descent {
    /// The centre.
    x: i32,
    y: i32,
    /// The position with the least SAD so far, and that SAD.
    best: (i32, i32),
    distance: u32,
    step: i32,
    /// The next neighbour, an index into `AROUND`.
    next: usize,
}

/// The first step of the descent in pixels: 0, 1, 2, 4 or 8. A step costs as much as 4 offsets (8 SADs of every other row). All
/// steps together cost at most 1/32 of the window.
fn first_step(window: &Window) -> i32 {
    first_step_of(window.size())
}

pub(super) fn first_step_of((columns, rows): (usize, usize)) -> i32 {
    match columns * rows / 128 {
        0 => 0,
        steps => 1 << (steps - 1).min(MOST_STEPS - 1),
    }
}

/// The first step is at most 2^(4 - 1) = 8 pixels, so the descent reaches 15. Beyond that the ranges are faster.
pub(super) const MOST_STEPS: usize = 4;

impl<const PIXELS: usize, const SPAN: usize> Search<PIXELS, SPAN> {
    #[inline(always)] // built in place
    pub(crate) const fn new() -> Self {
        let tile = Tile { column: 0, row: 0, columns: 0, rows: 0 };
        Self {
            leaders: Leaders::new(),
            ranges: Ranges::new(),
            tile,
            stage: Stage::Done,
            pruning: false,
            work: 0,
            since_floor: 0,
        }
    }

    /// Starts a search. Without pruning every offset is scored to its last pixel.
    pub(crate) fn begin(&mut self, window: &Window, pruning: bool, wanted: Wanted) {
        self.leaders.reset(window, wanted);
        self.pruning = pruning;
        self.stage = if pruning { Stage::LastPosition } else { Stage::Offsets(0, 0) };
    }

    /// Searches the window again for the runner-up. The peak is known.
    pub(crate) fn begin_runner_up(&mut self, scene: &Scene<'_>, neighbourhood: u16) {
        let peak = self.leaders.best();
        self.leaders.reset(&scene.window, Wanted::RunnerUp(neighbourhood));
        if let Some(peak) = peak {
            self.leaders.note(&scene.window, peak);
        }
        self.stage = Stage::Scout(0);
    }

    /// Continues for about `work` comparisons (at least 1) and returns how many were made. Counted are:
    ///
    /// - 1 for a byte of the template against a byte of the frame, even if scoring stopped before it;
    /// - 2 for each range;
    /// - 1 for each word of working memory read in a pass over groups or maxima.
    ///
    /// A step exceeds `work` by at most one offset, group or row of ranges, and 7 * `SPAN` words: a pass over the groups (3), one
    /// over the maxima to raise the floor (2), one for the runner-up (2).
    #[inline(never)] // one copy in flash
    pub(crate) fn step(&mut self, scene: &Scene<'_>, work: u32) -> u32 {
        self.work = 0;
        let work = work.max(1);
        while self.stage != Stage::Done && self.work < work {
            self.stage = match self.stage {
                Stage::LastPosition => self.last_position(scene),
                Stage::FirstSad => self.first_sad(scene),
                Stage::Descent(descent) => self.descend(scene, descent, work),
                Stage::Scout(number) => self.scout(scene, number),
                Stage::Ranges(place, row) => self.compute_ranges(scene, place, row, work),
                Stage::Exclude(place, group) => self.exclude(scene, place, group, work),
                Stage::Refine(place, group, offset) => self.refine(scene, place, group, offset, work),
                Stage::Offsets(column, row) => self.offsets(scene, column, row, work),
                Stage::Done => Stage::Done,
            };
            if self.is_done() && self.leaders.looks_for_runner_up() {
                self.spend(axes(scene)); // `found` reads the maxima
            }
        }
        self.work
    }

    pub(crate) fn is_done(&self) -> bool {
        self.stage == Stage::Done
    }

    #[inline(never)] // one copy in flash
    fn spend(&mut self, comparisons: u32) {
        self.work = self.work.saturating_add(comparisons);
        self.since_floor = self.since_floor.saturating_add(comparisons);
    }

    /// The result; `None` until the search is done.
    pub(crate) fn found(&self, window: &Window) -> Option<Found> {
        if self.is_done() { self.leaders.found(window) } else { None }
    }

    fn last_position(&mut self, scene: &Scene<'_>) -> Stage {
        let (x, y) = scene.window.centre();
        self.score(scene, x, y);
        if first_step(&scene.window) > 0 { Stage::FirstSad } else { Stage::Scout(0) }
    }

    fn first_sad(&mut self, scene: &Scene<'_>) -> Stage {
        let (x, y) = scene.window.centre();
        let step = first_step(&scene.window);
        self.sad(scene, x, y, u32::MAX)
            .map_or(Stage::Scout(0), |distance| Stage::Descent(Descent { x, y, best: (x, y), distance, step, next: 0 }))
    }

    #[inline(never)] // one copy in flash
    fn descend(&mut self, scene: &Scene<'_>, descent: Descent, work: u32) -> Stage {
        let mut at = descent;
        while at.step > 0 {
            for (number, (dx, dy)) in AROUND.into_iter().enumerate().skip(at.next) {
                if self.work >= work {
                    return Stage::Descent(Descent { next: number, ..at });
                }
                let (x, y) = (at.x + dx * at.step, at.y + dy * at.step);
                if scene.window.contains(x, y)
                    && let Some(distance) = self.sad(scene, x, y, at.distance)
                    && distance < at.distance
                {
                    (at.best, at.distance) = ((x, y), distance);
                }
            }
            at = Descent { x: at.best.0, y: at.best.1, step: at.step / 2, next: 0, ..at };
        }
        if self.work >= work {
            return Stage::Descent(at);
        }
        self.score(scene, at.x, at.y);
        Stage::Scout(0)
    }

    /// The SAD of every other row; `None` if the box is not wholly inside the frame. Stops early once the sum exceeds `enough`.
    #[inline(never)] // one copy in flash
    fn sad(&mut self, scene: &Scene<'_>, x: i32, y: i32, enough: u32) -> Option<u32> {
        let patch = scene.frame.patch(Rect::new(x, y, scene.template.width(), scene.template.height()))?;
        self.spend(u32::from(scene.template.width()) * u32::from(scene.template.height().div_ceil(2)));
        scene.scorer.distance(patch.every(0, 2)?, scene.template.every(0, 2)?, enough)
    }

    /// Scores the scouts: if two of them are far enough apart, they give the runner-up a floor. Only in windows of at least 288
    /// offsets: nine scouts are 1/32 of them.
    fn scout(&mut self, scene: &Scene<'_>, number: i32) -> Stage {
        let (columns, rows) = scene.window.size();
        if number >= 9 || !self.leaders.looks_for_runner_up() || columns * rows < 288 {
            self.raise_floor(scene);
            return self.first_tile(scene);
        }
        let part = |of: usize, number: i32| (of - 1) * number.unsigned_abs() as usize / 2;
        let (x, y) = scene.window.position(part(columns, number % 3), part(rows, number / 3));
        self.score(scene, x, y);
        Stage::Scout(number + 1)
    }

    fn raise_floor(&mut self, scene: &Scene<'_>) {
        if self.leaders.looks_for_runner_up() {
            self.leaders.raise_floor();
            self.spend(axes(scene));
            self.since_floor = 0;
        }
    }

    #[inline(never)] // one copy in flash
    fn first_tile(&mut self, scene: &Scene<'_>) -> Stage {
        if self.pruning && self.ranges.divide(&scene.window, scene.template) {
            Stage::Ranges(TilePass { column: 0, row: 0, pass: 0 }, 0)
        } else {
            Stage::Offsets(0, 0)
        }
    }

    #[inline(never)] // one copy in flash
    fn compute_ranges(&mut self, scene: &Scene<'_>, place: TilePass, row: usize, work: u32) -> Stage {
        if row == 0 && place.pass == 0 {
            self.tile = self.ranges.tile(&scene.window, place.column, place.row);
            self.ranges.begin_tile(&self.tile, area(scene));
        }
        let tile = self.tile;
        for row in row..self.ranges.rows(&tile, place.pass) {
            if self.work >= work {
                return Stage::Ranges(place, row);
            }
            let ranges = self.ranges.compute_row(&scene.frame, &scene.window, &tile, place.pass, row, scene.scorer);
            self.spend(2 * ranges);
        }
        if place.pass == 0 {
            self.spend(words(tile.groups())); // by `begin_tile`
        }
        Stage::Exclude(place, 0)
    }

    #[inline(never)] // one copy in flash
    fn exclude(&mut self, scene: &Scene<'_>, place: TilePass, group: usize, work: u32) -> Stage {
        let (tile, needed) = (self.tile, self.leaders.needed());
        let mut from = group;
        while let Some(group) = self.ranges.next_group(&tile, from, needed) {
            if self.work >= work {
                return Stage::Exclude(place, group);
            }
            let compared = self.ranges.bound_group(scene.template, &tile, place.pass, group, needed, scene.scorer);
            self.spend(compared + words(group - from));
            from = group + 1;
        }
        self.spend(words(tile.groups().saturating_sub(from)));
        if place.pass + 1 < self.ranges.passes() {
            Stage::Ranges(TilePass { pass: place.pass + 1, ..place }, 0)
        } else {
            Stage::Refine(place, 0, 0)
        }
    }

    #[inline(never)] // one copy in flash
    fn refine(&mut self, scene: &Scene<'_>, place: TilePass, group: usize, offset: usize, work: u32) -> Stage {
        let tile = self.tile;
        let (mut from, mut offset) = (group, offset);
        while let Some(group) = self.ranges.next_group(&tile, from, self.leaders.needed()) {
            if self.work >= work {
                return Stage::Refine(place, group, if group == from { offset } else { 0 });
            }
            if group != from {
                offset = 0;
            }
            let new = tile.new_in_group(group);
            // Raise the floor at the first remaining group of each row, unless that costs more than 1/32 of the work since.
            let new_row = offset == 0 && (from == 0 || new.1 != tile.new_in_group(from - 1).1);
            if new_row && self.since_floor / 32 >= axes(scene) {
                self.raise_floor(scene);
            }
            self.spend(words(group - from));
            self.score_in_group(scene, place, tile.group(group), new, offset);
            offset += 1;
            from = group + offset / (SIDE * SIDE);
            offset %= SIDE * SIDE;
        }
        self.spend(words(tile.groups().saturating_sub(from)));
        self.next_tile(scene, place)
    }

    /// Scores an offset of a group, unless an earlier group or tile contains it.
    fn score_in_group(
        &mut self,
        scene: &Scene<'_>,
        place: TilePass,
        group: (usize, usize),
        new: (usize, usize),
        offset: usize,
    ) {
        let (column, row) = (group.0 + offset % SIDE, group.1 + offset / SIDE);
        let is_new = column >= new.0 && row >= new.1;
        let (column, row) = (self.tile.column + column, self.tile.row + row);
        if is_new && column >= place.column && row >= place.row {
            let (x, y) = scene.window.position(column, row);
            self.score(scene, x, y);
        }
    }

    fn next_tile(&self, scene: &Scene<'_>, place: TilePass) -> Stage {
        let (columns, rows) = scene.window.size();
        let tile = self.tile;
        if tile.column + tile.columns < columns {
            Stage::Ranges(TilePass { column: tile.column + tile.columns, row: place.row, pass: 0 }, 0)
        } else if tile.row + tile.rows < rows {
            Stage::Ranges(TilePass { column: 0, row: tile.row + tile.rows, pass: 0 }, 0)
        } else {
            Stage::Done
        }
    }

    #[inline(never)] // one copy in flash
    fn offsets(&mut self, scene: &Scene<'_>, column: usize, row: usize, work: u32) -> Stage {
        let (columns, rows) = scene.window.size();
        let mut column = column;
        for row in row..rows {
            while column < columns {
                if self.work >= work {
                    return Stage::Offsets(column, row);
                }
                let (x, y) = scene.window.position(column, row);
                self.score(scene, x, y);
                column += 1;
            }
            column = 0;
        }
        Stage::Done
    }

    #[inline(never)] // one copy in flash
    fn score(&mut self, scene: &Scene<'_>, x: i32, y: i32) {
        self.spend(area(scene));
        let needed = if self.pruning { self.leaders.needed_at(&scene.window, x, y) } else { 0 };
        let score = similarity::score_at_least(&scene.frame, scene.template, x, y, scene.scorer, needed);
        if let Some(score) = score {
            self.leaders.note(&scene.window, Peak { x, y, score });
        }
    }
}

const AROUND: [(i32, i32); 8] = [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)];

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
