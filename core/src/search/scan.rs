//! The search: every offset of the window scored or excluded, in steps of as little work as is asked for.
//!
//! First the last position and a descent from it, to have a good score early, and for the runner-up a few far apart; then
//! tile by tile, pass by pass (see `ranges.rs`). An offset is excluded together with its group, or scored until it cannot
//! reach what is needed; the answer does not depend on the order.

use super::leaders::Leaders;
use super::ranges::{Ranges, SIDE, Tile};
use super::{Found, Peak, Wanted, Window};
use crate::image::{Frame, Image, Rect};
use crate::similarity::{self, Scorer};

/// What a search is about; the same in every step of it.
pub(crate) struct Scene<'a> {
    pub(crate) frame: Frame<'a>,
    pub(crate) template: Image<'a>,
    pub(crate) window: Window,
    pub(crate) scorer: &'a Scorer<'a>,
}

/// How far a search is, and its working memory.
pub(crate) struct Search<const PIXELS: usize, const SPAN: usize> {
    leaders: Leaders<SPAN>,
    ranges: Ranges<PIXELS, SPAN>,
    /// The tile that is gone through.
    tile: Tile,
    stage: Stage,
    pruning: bool,
    /// Comparisons in the present step.
    work: u32,
    /// Comparisons since pairs were looked for.
    since_pairs: u32,
}

#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u8)] // `Done` is 0, so that a workspace in a `static` begins as zeroes
enum Stage {
    Done,
    /// The last position itself.
    Start,
    /// Its SAD.
    Measure,
    Descent(Descent),
    /// The next of nine offsets spread over the window.
    Scout(i32),
    /// The next row of ranges of a pass.
    Spread(TilePass, usize),
    /// The next group.
    Exclude(TilePass, usize),
    /// The next offset of a group that is left.
    Refine(TilePass, usize, usize),
    /// Without groups: the next offset.
    Offsets(usize, usize),
}

/// First offset of the tile, and the pass.
#[derive(Clone, Copy, PartialEq, Eq)]
struct TilePass {
    column: usize,
    row: usize,
    pass: usize,
}

/// The way down the SAD, from the last position: the best of nine, then of nine half as far away.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Descent {
    /// The middle of the nine.
    x: i32,
    y: i32,
    /// The best of them so far.
    best: (i32, i32),
    distance: u32,
    step: i32,
    /// Which of those around the middle comes next.
    next: usize,
}

/// How far the first step of the descent goes. Each step costs half of eight offsets: no more of them than a 32nd of the
/// window.
fn first_step(window: &Window) -> i32 {
    first_step_of(window.size())
}

pub(super) fn first_step_of((columns, rows): (usize, usize)) -> i32 {
    match columns * rows / 128 {
        0 => 0,
        steps => 1 << (steps - 1).min(MOST_STEPS - 1),
    }
}

/// It sets out with 8 pixels at most: what lies farther away than that and twice as far is left to the ranges.
pub(super) const MOST_STEPS: usize = 4;

impl<const PIXELS: usize, const SPAN: usize> Search<PIXELS, SPAN> {
    #[inline(always)] // made where it stays
    pub(crate) const fn new() -> Self {
        let tile = Tile { column: 0, row: 0, columns: 0, rows: 0 };
        Self {
            leaders: Leaders::new(),
            ranges: Ranges::new(),
            tile,
            stage: Stage::Done,
            pruning: false,
            work: 0,
            since_pairs: 0,
        }
    }

    /// Starts anew. Without pruning every offset is scored to its last pixel.
    pub(crate) fn begin(&mut self, window: &Window, pruning: bool, wanted: Wanted) {
        self.leaders.reset(window, wanted);
        self.ranges.reserve();
        self.pruning = pruning;
        self.stage = if pruning { Stage::Start } else { Stage::Offsets(0, 0) };
    }

    /// Goes through the window once more, for the runner-up; the peak is known.
    pub(crate) fn begin_runner_up(&mut self, scene: &Scene<'_>, neighbourhood: u16) {
        let peak = self.leaders.best();
        self.leaders.reset(&scene.window, Wanted::RunnerUp(neighbourhood));
        if let Some(peak) = peak {
            self.leaders.note(&scene.window, peak);
        }
        self.stage = Stage::Scout(0);
    }

    /// Goes on until `work` comparisons have been made, or a few more; with 0 as with 1. Their count is returned: a byte of
    /// the template against a byte of the frame, also if it could be left out; two for each range; and one for each word of
    /// the working memory that is looked at for anything but a single offset or group.
    ///
    /// Between two looks at the count there is at most an offset, a group or a row of ranges, and beside it seven words for
    /// each of `SPAN`: a pass over the groups (3), one for pairs (2), one for the runner-up (2).
    #[inline(never)] // one copy in flash
    pub(crate) fn step(&mut self, scene: &Scene<'_>, work: u32) -> u32 {
        self.work = 0;
        let work = work.max(1);
        while self.stage != Stage::Done && self.work < work {
            self.stage = match self.stage {
                Stage::Start => self.start(scene),
                Stage::Measure => self.measure(scene),
                Stage::Descent(descent) => self.descend(scene, descent, work),
                Stage::Scout(number) => self.scout(scene, number),
                Stage::Spread(place, row) => self.spread(scene, place, row, work),
                Stage::Exclude(place, group) => self.exclude(scene, place, group, work),
                Stage::Refine(place, group, offset) => self.refine(scene, place, group, offset, work),
                Stage::Offsets(column, row) => self.offsets(scene, column, row, work),
                Stage::Done => Stage::Done,
            };
            if self.is_done() && self.leaders.looks_for_runner_up() {
                self.spend(axes(scene)); // what `found` will look at
            }
        }
        self.work
    }

    /// True when the whole window has been gone through.
    pub(crate) fn is_done(&self) -> bool {
        self.stage == Stage::Done
    }

    fn spend(&mut self, comparisons: u32) {
        self.work = self.work.saturating_add(comparisons);
        self.since_pairs = self.since_pairs.saturating_add(comparisons);
    }

    /// What was found; `None` before the search is done.
    pub(crate) fn found(&self, window: &Window) -> Option<Found> {
        if self.is_done() { self.leaders.found(window) } else { None }
    }

    fn start(&mut self, scene: &Scene<'_>) -> Stage {
        let (x, y) = scene.window.centre();
        self.score(scene, x, y);
        if first_step(&scene.window) > 0 { Stage::Measure } else { Stage::Scout(0) }
    }

    fn measure(&mut self, scene: &Scene<'_>) -> Stage {
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

    /// The SAD of every other row of a box wholly inside the frame; any part of it that is more than `enough`, once it is more.
    #[inline(never)] // one copy in flash
    fn sad(&mut self, scene: &Scene<'_>, x: i32, y: i32, enough: u32) -> Option<u32> {
        let patch = scene.frame.patch(Rect::new(x, y, scene.template.width(), scene.template.height()))?;
        self.spend(u32::from(scene.template.width()) * u32::from(scene.template.height().div_ceil(2)));
        scene.scorer.distance(patch.every(0, 2)?, scene.template.every(0, 2)?, enough)
    }

    /// Scores the window's corners, the middles of its edges and its middle: where the runner-up is looked for, two of them
    /// tell how much it is at least. Nine scores are a 32nd of 288.
    fn scout(&mut self, scene: &Scene<'_>, number: i32) -> Stage {
        let (columns, rows) = scene.window.size();
        if number >= 9 || !self.leaders.looks_for_runner_up() || columns * rows < 288 {
            self.look_for_pairs(scene);
            return self.first(scene);
        }
        let part = |of: usize, number: i32| (of - 1) * number.unsigned_abs() as usize / 2;
        let (x, y) = scene.window.position(part(columns, number % 3), part(rows, number / 3));
        self.score(scene, x, y);
        Stage::Scout(number + 1)
    }

    fn look_for_pairs(&mut self, scene: &Scene<'_>) {
        if self.leaders.looks_for_runner_up() {
            self.leaders.look_for_pairs();
            self.spend(axes(scene));
            self.since_pairs = 0;
        }
    }

    /// What the window begins with.
    #[inline(never)] // one copy in flash
    fn first(&mut self, scene: &Scene<'_>) -> Stage {
        if self.pruning && self.ranges.divide(&scene.window, scene.template) {
            Stage::Spread(TilePass { column: 0, row: 0, pass: 0 }, 0)
        } else {
            Stage::Offsets(0, 0)
        }
    }

    #[inline(never)] // one copy in flash
    fn spread(&mut self, scene: &Scene<'_>, place: TilePass, row: usize, work: u32) -> Stage {
        if row == 0 && place.pass == 0 {
            self.tile = self.ranges.tile(&scene.window, place.column, place.row);
            self.ranges.start(&self.tile, area(scene));
        }
        let tile = self.tile;
        for row in row..self.ranges.rows(&tile, place.pass) {
            if self.work >= work {
                return Stage::Spread(place, row);
            }
            let ranges = self.ranges.spread(&scene.frame, &scene.window, &tile, place.pass, row, scene.scorer);
            self.spend(2 * ranges);
        }
        if place.pass == 0 {
            self.spend(words(tile.groups())); // set when the tile was begun
        }
        Stage::Exclude(place, 0)
    }

    #[inline(never)] // one copy in flash
    fn exclude(&mut self, scene: &Scene<'_>, place: TilePass, group: usize, work: u32) -> Stage {
        let (tile, needed) = (self.tile, self.leaders.needed());
        let mut from = group;
        while let Some(group) = self.ranges.next(&tile, from, needed) {
            if self.work >= work {
                return Stage::Exclude(place, group);
            }
            let compared = self.ranges.look(scene.template, &tile, place.pass, group, needed, scene.scorer);
            self.spend(compared + words(group - from));
            from = group + 1;
        }
        self.spend(words(tile.groups().saturating_sub(from)));
        if place.pass + 1 < self.ranges.passes() {
            Stage::Spread(TilePass { pass: place.pass + 1, ..place }, 0)
        } else {
            Stage::Refine(place, 0, 0)
        }
    }

    #[inline(never)] // one copy in flash
    fn refine(&mut self, scene: &Scene<'_>, place: TilePass, group: usize, offset: usize, work: u32) -> Stage {
        let tile = self.tile;
        let (mut from, mut offset) = (group, offset);
        while let Some(group) = self.ranges.next(&tile, from, self.leaders.needed()) {
            if self.work >= work {
                return Stage::Refine(place, group, if group == from { offset } else { 0 });
            }
            if group != from {
                offset = 0;
            }
            let new = tile.new_in_group(group);
            // At the first group that is left of each row: often enough to learn from what was scored since. But not where
            // it would cost more than a 32nd of that.
            let new_row = offset == 0 && (from == 0 || new.1 != tile.new_in_group(from - 1).1);
            if new_row && self.since_pairs / 32 >= axes(scene) {
                self.look_for_pairs(scene);
            }
            self.spend(words(group - from));
            self.score_in_group(scene, place, tile.group(group), new, offset);
            offset += 1;
            from = group + offset / (SIDE * SIDE);
            offset %= SIDE * SIDE;
        }
        self.spend(words(tile.groups().saturating_sub(from)));
        self.next(scene, place)
    }

    /// Scores an offset of a group, unless it is also one of a group or of a tile before.
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

    /// The next tile.
    fn next(&self, scene: &Scene<'_>, place: TilePass) -> Stage {
        let (columns, rows) = scene.window.size();
        let tile = self.tile;
        if tile.column + tile.columns < columns {
            Stage::Spread(TilePass { column: tile.column + tile.columns, row: place.row, pass: 0 }, 0)
        } else if tile.row + tile.rows < rows {
            Stage::Spread(TilePass { column: 0, row: tile.row + tile.rows, pass: 0 }, 0)
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

/// Columns and rows of the window.
fn axes(scene: &Scene<'_>) -> u32 {
    let (columns, rows) = scene.window.size();
    words(columns + rows)
}

fn words(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
