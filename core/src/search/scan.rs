//! The search: every offset of the window scored or excluded, in steps of as little work as is asked for.
//!
//! First the last position and a descent from it, to have a good score early; then tile by tile, phase by phase (see
//! `boxes.rs`), row by row. An offset is excluded by its boxes, or scored until it cannot reach what is needed; the
//! answer does not depend on the order.

use super::boxes::{Boxes, HEIGHT, Tile};
use super::leaders::Leaders;
use super::{Found, Peak, Window};
use crate::image::{Frame, Image, Rect};
use crate::similarity::{self, Scorer};

/// What a search is about; the same in every step of it.
pub(crate) struct Scene<'a> {
    pub(crate) frame: Frame<'a>,
    pub(crate) template: Image<'a>,
    pub(crate) window: Window,
    pub(crate) scorer: &'a Scorer,
}

/// How far a search is, and its working memory.
pub(crate) struct Search<const PIXELS: usize, const SPAN: usize> {
    leaders: Leaders<SPAN>,
    boxes: Boxes<PIXELS>,
    stage: Stage,
    pruning: bool,
    /// The largest distance of the boxes with which an offset can still matter.
    enough: u32,
    work: u64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// The next row of the template's boxes.
    Template(u16),
    /// The last position itself.
    Start,
    Descent(Descent),
    /// The next row of a phase's boxes.
    Shrink(Place, u16),
    /// The next offset: row in the phase, and column.
    Offsets(Place, usize, usize),
    Done,
}

/// First offset of the tile, and the phase.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Place {
    column: usize,
    row: usize,
    phase: u16,
}

/// The way down the SAD, from the last position: the best of nine, then of nine half as far away.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Descent {
    x: i32,
    y: i32,
    distance: u32,
    step: i32,
}

/// How far the first step of the descent goes.
const FIRST_STEP: i32 = 8;

impl<const PIXELS: usize, const SPAN: usize> Search<PIXELS, SPAN> {
    pub(crate) const fn new() -> Self {
        Self {
            leaders: Leaders::new(),
            boxes: Boxes::new(),
            stage: Stage::Done,
            pruning: false,
            enough: u32::MAX,
            work: 0,
        }
    }

    /// Starts anew. Without pruning every offset is scored to its last pixel; with a neighbourhood the runner-up is
    /// looked for, too.
    pub(crate) fn begin(&mut self, scene: &Scene<'_>, pruning: bool, neighbourhood: Option<u16>) {
        self.leaders.reset(&scene.window, neighbourhood);
        self.boxes.reset(&scene.window, Some(scene.template).filter(|_| pruning));
        self.pruning = pruning;
        self.enough = u32::MAX;
        self.work = 0;
        self.stage = if pruning { Stage::Template(0) } else { FIRST_PLACE };
    }

    /// Goes through the window once more, for the runner-up; the peak is known.
    pub(crate) fn begin_runner_up(&mut self, scene: &Scene<'_>, neighbourhood: u16) {
        let peak = self.leaders.best();
        self.leaders.reset(&scene.window, Some(neighbourhood));
        self.enough = u32::MAX;
        if let Some(peak) = peak {
            self.note(scene, peak);
        }
        self.stage = FIRST_PLACE;
    }

    /// Goes on until `work` comparisons have been made, or a few more: those of a row of boxes or of an offset. True when
    /// the whole window has been gone through.
    pub(crate) fn step(&mut self, scene: &Scene<'_>, work: u64) -> bool {
        let end = self.work.saturating_add(work);
        while self.stage != Stage::Done && self.work < end {
            self.stage = match self.stage {
                Stage::Template(row) => self.template(scene, row),
                Stage::Start => self.start(scene),
                Stage::Descent(descent) => self.descend(scene, descent),
                Stage::Shrink(place, row) => self.shrink(scene, place, row),
                Stage::Offsets(place, row, column) => self.offsets(scene, place, row, column, end),
                Stage::Done => Stage::Done,
            };
        }
        self.stage == Stage::Done
    }

    /// Comparisons of pixels or of boxes since the search began, at most: what scoring left out is counted, too.
    pub(crate) const fn work(&self) -> u64 {
        self.work
    }

    pub(crate) fn is_done(&self) -> bool {
        self.stage == Stage::Done
    }

    /// What was found; `None` before the search is done.
    pub(crate) fn found(&self, window: &Window) -> Option<Found> {
        if self.is_done() { self.leaders.found(window) } else { None }
    }

    fn template(&mut self, scene: &Scene<'_>, row: u16) -> Stage {
        if row >= self.boxes.rows() {
            return Stage::Start;
        }
        self.boxes.shrink_template(scene.template, row, scene.scorer);
        self.work += u64::from(scene.template.width());
        Stage::Template(row + 1)
    }

    fn start(&mut self, scene: &Scene<'_>) -> Stage {
        let (x, y) = scene.window.centre();
        self.score(scene, x, y);
        match sad(scene, x, y, u32::MAX) {
            Some(distance) => Stage::Descent(Descent { x, y, distance, step: FIRST_STEP }),
            None => FIRST_PLACE,
        }
    }

    fn descend(&mut self, scene: &Scene<'_>, from: Descent) -> Stage {
        let mut best = from;
        for (dx, dy) in AROUND {
            let (x, y) = (from.x + dx * from.step, from.y + dy * from.step);
            if scene.window.contains(x, y)
                && let Some(distance) = sad(scene, x, y, best.distance)
                && distance < best.distance
            {
                best = Descent { x, y, distance, ..best };
            }
        }
        self.work += 8 * u64::from(area(scene));
        best.step = from.step / 2;
        if best.step > 0 {
            return Stage::Descent(best);
        }
        self.score(scene, best.x, best.y);
        FIRST_PLACE
    }

    fn shrink(&mut self, scene: &Scene<'_>, place: Place, row: u16) -> Stage {
        let tile = self.boxes.tile(&scene.window, place.column, place.row);
        if self.boxes.rows() == 0 || row >= self.boxes.rows_of(&tile, place.phase) {
            return Stage::Offsets(place, 0, 0);
        }
        let boxes = self.boxes.shrink_window(&scene.frame, &scene.window, &tile, place.phase, row, scene.scorer);
        self.work += boxes as u64;
        Stage::Shrink(place, row + 1)
    }

    /// The offsets of one row, from `column` on.
    fn offsets(&mut self, scene: &Scene<'_>, place: Place, row: usize, column: usize, end: u64) -> Stage {
        let tile = self.boxes.tile(&scene.window, place.column, place.row);
        if row >= tile.rows_in(place.phase) {
            return self.next(scene, &tile, place);
        }
        let first_row = tile.row + usize::from(place.phase) + row * usize::from(HEIGHT);
        for column in column..tile.columns {
            if self.work >= end {
                return Stage::Offsets(place, row, column);
            }
            if !self.is_excluded(scene, &tile, column, row) {
                let (x, y) = scene.window.position(tile.column + column, first_row);
                self.score(scene, x, y);
            }
        }
        Stage::Offsets(place, row + 1, 0)
    }

    /// The next phase, or the next tile.
    fn next(&self, scene: &Scene<'_>, tile: &Tile, place: Place) -> Stage {
        let (columns, rows) = scene.window.size();
        let next = if place.phase + 1 < HEIGHT {
            Place { phase: place.phase + 1, ..place }
        } else if tile.column + tile.columns < columns {
            Place { column: tile.column + tile.columns, row: place.row, phase: 0 }
        } else {
            Place { column: 0, row: tile.row + tile.rows, phase: 0 }
        };
        if next.row < rows { Stage::Shrink(next, 0) } else { Stage::Done }
    }

    fn is_excluded(&mut self, scene: &Scene<'_>, tile: &Tile, column: usize, row: usize) -> bool {
        if self.enough >= self.boxes.largest_distance() {
            return false;
        }
        self.work += u64::from(self.boxes.boxes());
        self.boxes.distance(tile, column, row, self.enough, scene.scorer) > self.enough
    }

    fn score(&mut self, scene: &Scene<'_>, x: i32, y: i32) {
        self.work += u64::from(area(scene));
        let needed = if self.pruning { self.leaders.needed_at(&scene.window, x, y) } else { 0 };
        let score = similarity::score_at_least(&scene.frame, scene.template, x, y, scene.scorer, needed);
        if let Some(score) = score {
            self.note(scene, Peak { x, y, score });
        }
    }

    fn note(&mut self, scene: &Scene<'_>, candidate: Peak) {
        if self.leaders.note(&scene.window, candidate) {
            let loss_per_level = scene.scorer.loss_per_level();
            self.enough = self.boxes.enough(area(scene), self.leaders.needed(), loss_per_level);
        }
    }
}

const FIRST_PLACE: Stage = Stage::Shrink(Place { column: 0, row: 0, phase: 0 }, 0);

const AROUND: [(i32, i32); 8] = [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)];

/// The SAD of a box wholly inside the frame; any part of it that is more than `enough`, once it is more.
fn sad(scene: &Scene<'_>, x: i32, y: i32, enough: u32) -> Option<u32> {
    let patch = scene.frame.patch(Rect::new(x, y, scene.template.width(), scene.template.height()))?;
    Some(scene.scorer.distance(patch, scene.template, enough))
}

fn area(scene: &Scene<'_>) -> u32 {
    u32::from(scene.template.width()) * u32::from(scene.template.height())
}
