//! Excludes whole groups of 4x4 offsets by the gray ranges (minimum and maximum) of the frame's blocks of 4x4 pixels.
//!
//! 1. Over the offsets of a group, template pixel t is compared with the pixels of one 4x4 block of the frame. Each of
//!    its differences is at least d(t) = max(low - t, t - high, 0), where low..=high is the range of the block.
//! 2. The similarity p does not rise with the difference, so sum p(d(t)) is an upper bound of the score of every offset
//!    of the group. The bound stays valid if rows of the template are left out and counted as p = 1.
//!
//! Memory: the ranges fill a buffer of `PIXELS` bytes. The window is divided into tiles whose ranges fit. A tile is
//! done in 1, 2 or 4 passes, each over every (second, fourth) row of the frame. A group whose bound falls below the
//! needed score is excluded. A group whose bound falls too slowly is not bounded any further: its offsets are scored.
//! Each pass computes only the ranges under the rectangle around the groups that are still being bounded.

use super::window::Window;
use crate::image::{Frame, Image, Rect};
use crate::kernels::{Blocks, RowsOfRanges, rolled};
use crate::similarity::{Scorer, Table};
use core::ops::Range;

/// The number of offsets of a group on each axis.
pub(super) const SIDE: usize = 4;

/// The size in bytes of a word, to which each row of ranges is aligned.
const WORD: usize = 4;

pub(super) struct Ranges<const PIXELS: usize, const SPAN: usize> {
    /// The ranges of the frame's blocks, row by row: minima in the first half of the buffer, maxima in the second.
    bytes: Aligned4<PIXELS>,
    /// The upper bound of the scores in each group of the present tile; 0 if the group is excluded.
    bounds: [[u32; 3]; SPAN],
    shape: Shape,
    remaining: Remaining,
}

#[repr(align(4))]
struct Aligned4<const BYTES: usize>([u8; BYTES]);

/// The division of a window into tiles, and the number of passes over each tile, for one size of template and window.
#[derive(Clone, Copy)]
struct Shape {
    /// Size of the template in pixels.
    width: usize,
    height: usize,
    /// Columns and rows of the largest tile, in offsets.
    columns: usize,
    rows: usize,
    /// Log2 of the passes over a tile: 0 if a pass covers every row of ranges, 1 for every second, 2 for every fourth.
    log2_passes: u32,
}

/// The rectangle around the groups that are still to be bounded: index of the first and the last one on each axis.
#[derive(Clone, Copy)]
struct Remaining {
    columns: [u16; 2],
    rows: [u16; 2],
}

impl Remaining {
    const NONE: Self = Self { columns: [u16::MAX, 0], rows: [u16::MAX, 0] };
    /// All groups of a tile: [`Ranges::remaining_part`] clips the rectangle to the tile.
    const ALL: Self = Self { columns: [0, u16::MAX], rows: [0, u16::MAX] };

    /// Extends the rectangle to include the group that begins at offset (`column`, `row`) of the tile.
    #[allow(clippy::cast_possible_truncation)] // a window has at most 131071 offsets on an axis
    #[cfg_attr(smr_small, inline(never))] // keeps its registers out of its caller
    fn add(&mut self, (column, row): (usize, usize)) {
        for ([first, last], at) in [(&mut self.columns, column), (&mut self.rows, row)] {
            *first = (*first).min((at / SIDE) as u16);
            *last = (*last).max(at.div_ceil(SIDE) as u16);
        }
    }
}

/// A rectangle of offsets; its `column` and `row` are relative to the first offset of the window.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Tile {
    pub(super) column: usize,
    pub(super) row: usize,
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl Tile {
    #[cfg_attr(smr_small, inline(never))]
    pub(super) const fn groups(&self) -> usize {
        self.columns.div_ceil(SIDE) * self.rows.div_ceil(SIDE)
    }

    /// The first offset, relative to the tile, that belongs to the group but to no earlier group.
    #[cfg_attr(smr_small, inline(never))]
    pub(super) fn first_unshared(&self, group: usize) -> (usize, usize) {
        let across = self.columns.div_ceil(SIDE).max(1);
        (group % across * SIDE, group / across * SIDE)
    }

    /// The first offset of a group, relative to the tile. The last group of a row or column may overlap its neighbour.
    pub(super) fn group(&self, group: usize) -> (usize, usize) {
        let (column, row) = self.first_unshared(group);
        (column.min(self.columns.saturating_sub(SIDE)), row.min(self.rows.saturating_sub(SIDE)))
    }
}

impl<const PIXELS: usize, const SPAN: usize> Ranges<PIXELS, SPAN> {
    #[inline(always)]
    pub(super) const fn new() -> Self {
        let shape = Shape { width: 0, height: 0, columns: 0, rows: 0, log2_passes: 0 };
        Self {
            bytes: Aligned4([0; PIXELS]),
            bounds: [[0; 3]; SPAN],
            shape,
            remaining: Remaining { columns: [0; 2], rows: [0; 2] },
        }
    }

    /// Divides `window` into tiles. False if no tile of 4x4 offsets or more fits, or its ranges cost too much (`pays`).
    pub(super) fn divide(&mut self, window: &Window, template: Image<'_>) -> bool {
        let shape = Shape::of((template.width(), template.height()), window.size(), PIXELS, 3 * SPAN);
        self.shape = shape.unwrap_or(self.shape);
        shape.is_some()
    }

    pub(super) const fn passes(&self) -> usize {
        1 << self.shape.log2_passes
    }

    /// The largest tile that begins at offset (`column`, `row`), or earlier if less than 4 columns or rows are left.
    pub(super) fn tile(&self, window: &Window, column: usize, row: usize) -> Tile {
        let (columns, rows) = window.size();
        let ((column, columns), (row, rows)) =
            (tile_extent(column, self.shape.columns, columns), tile_extent(row, self.shape.rows, rows));
        Tile { column, row, columns, rows }
    }

    /// Upper bound of the comparisons for bounding all groups of a window: 2 for each range of each tile; for each
    /// group, 1 for each template pixel and 1 for each of the 2 + (number of passes) words of working memory read.
    pub(super) fn most(window: (usize, usize), (width, height): (u16, u16)) -> u64 {
        let Some(shape) = Shape::of((width, height), window, PIXELS, 3 * SPAN) else { return 0 };
        let pixels = usize::from(width) * usize::from(height);
        let per_group = pixels + 2 + (1 << shape.log2_passes);
        let (across, down) = (shape.sides(shape.columns, window.0), shape.sides(shape.rows, window.1));
        let tiles = down.flat_map(|rows| across.clone().map(move |columns| (columns, rows)));
        let most = tiles.map(|(columns, rows)| {
            let tile = Tile { column: 0, row: 0, columns, rows };
            let ranges = 2 * shape.columns_of(columns) * shape.rows_of(rows);
            u64::try_from(ranges + tile.groups() * per_group).unwrap_or(u64::MAX)
        });
        most.sum()
    }

    /// Sets the bound of every group of `tile` to the score of `pixels` fully similar pixels. No group is excluded yet.
    pub(super) fn begin_tile(&mut self, tile: &Tile, pixels: u32) {
        let bounds = self.bounds.as_flattened_mut();
        rolled(bounds.iter_mut().take(tile.groups())).for_each(|bound| *bound = pixels * u32::from(Table::ONE));
        self.remaining = Remaining::ALL;
    }

    /// Empties the rectangle of the remaining groups. In each pass, [`Self::bound_group`] adds the groups that remain.
    pub(super) const fn begin_groups(&mut self) {
        self.remaining = Remaining::NONE;
    }

    /// The part of `tile` around the groups that remain to be bounded; `None` if no such group remains.
    pub(super) fn remaining_part(&self, tile: &Tile) -> Option<Tile> {
        let side = |[first, last]: [u16; 2], all: usize| {
            let (from, end) = (SIDE * usize::from(first), SIDE * usize::from(last) + SIDE);
            Some((from, end.min(all).checked_sub(from)?))
        };
        let (column, columns) = side(self.remaining.columns, tile.columns)?;
        let (row, rows) = side(self.remaining.rows, tile.rows)?;
        Some(Tile { column: tile.column + column, row: tile.row + row, columns, rows })
    }

    /// Indices of the rows of ranges that a pass needs for `rest`, a part of `tile`. Of all rows of ranges of the tile,
    /// index i stands for row `pass` + i * `passes()`.
    pub(super) fn rows(&self, tile: &Tile, rest: &Tile, pass: usize) -> Range<usize> {
        let first = rest.row - tile.row;
        let [first, end] = [first, first + self.shape.rows_of(rest.rows)]
            .map(|rows| (rows + self.passes() - 1).saturating_sub(pass) >> self.shape.log2_passes);
        first..end
    }

    /// The frame's pixels for the ranges of `rest`, a part of a tile; `None` if some are not in the frame or in memory.
    pub(super) fn pixels<'a>(&self, frame: &Frame<'a>, window: &Window, rest: &Tile) -> Option<Image<'a>> {
        if cfg!(all(target_os = "none", not(smr_helium))) {
            return None; // each row finds its own pixels, which takes little time and less flash
        }
        let (x, y) = window.position(rest.column, rest.row);
        let side = |blocks: usize| u16::try_from(blocks + SIDE - 1).unwrap_or(u16::MAX);
        let (width, height) = (self.shape.columns_of(rest.columns), self.shape.rows_of(rest.rows));
        frame.patch(Rect::new(x, y, side(width), side(height)))
    }

    /// Computes up to `most` rows of ranges for `rest`, the remaining part of `tile`, from row `row` on. Returns their
    /// number; 0 if the backend computes only single rows. `pixels` are the result of [`Self::pixels`].
    pub(super) fn compute_rows(
        &mut self,
        pixels: Image<'_>,
        (tile, rest): (&Tile, &Tile),
        pass: usize,
        row: usize,
        most: usize,
        scorer: &Scorer<'_>,
    ) -> usize {
        let (stride, passes) = (self.shape.stride_of(tile.columns), self.passes());
        let rows = self.rows(tile, rest, pass).end.saturating_sub(row).min(most);
        let pixels_down = rows.saturating_sub(1) * passes + SIDE;
        let down = tile.row + pass + row * passes - rest.row;
        let pixels = pixels.every(down, 1).and_then(|rest| rest.first(pixels_down));
        let start = row * stride + rest.column - tile.column;
        let (low, high) = self.bytes.0.split_at_mut_checked(half(PIXELS)).unwrap_or_default();
        let (low, high) = (low.get_mut(start..), high.get_mut(start..));
        let (Some(pixels), Some(low), Some(high)) = (pixels, low, high) else { return 0 };
        let to = RowsOfRanges { low, high, stride };
        if scorer.ranges_of_rows(pixels, passes, to) { rows } else { 0 }
    }

    pub(super) fn ranges_in_row(&self, rest: &Tile) -> u32 {
        u32::try_from(self.shape.columns_of(rest.columns)).unwrap_or(u32::MAX / 2)
    }

    /// Computes a row of ranges (minima, maxima) for `rest`, the remaining part of `tile`. Returns the number of
    /// ranges.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn compute_row(
        &mut self,
        frame: &Frame<'_>,
        pixels: Option<Image<'_>>,
        window: &Window,
        (tile, rest): (&Tile, &Tile),
        pass: usize,
        row: usize,
        scorer: &Scorer<'_>,
    ) -> u32 {
        let width = self.shape.columns_of(rest.columns);
        let start = row * self.shape.stride_of(tile.columns) + rest.column - tile.column;
        let down = tile.row + pass + row * self.passes();
        let place = window.position(rest.column, down);
        let pixels = pixels.and_then(|pixels| pixels.every(down - rest.row, 1));
        let (low, high) = self.bytes.0.split_at_mut_checked(half(PIXELS)).unwrap_or_default();
        let [low, high] = [low, high].map(|ranges| {
            ranges.get_mut(start..).and_then(|rest| rest.get_mut(..width.next_multiple_of(WORD))).unwrap_or_default()
        });
        ranges_at(frame, pixels, place, width, scorer, low, high);
        u32::try_from(width).unwrap_or(u32::MAX / 2)
    }

    /// Compares the template rows of this pass with the ranges and lowers the group's bound accordingly; sets it to 0
    /// if it falls below `needed`, which is at least 1. Returns an upper bound of the number of compared pixels.
    #[inline(always)]
    pub(super) fn bound_group(
        &mut self,
        template: Image<'_>,
        tile: &Tile,
        pass: usize,
        group: usize,
        needed: u32,
        scorer: &Scorer<'_>,
    ) -> u32 {
        let (column, row) = tile.group(group);
        // This pass's first row of the template, and the index at which the ranges for that row start.
        let passes = self.passes();
        let first = pass.wrapping_sub(row) & (passes - 1);
        let stride = self.shape.stride_of(tile.columns);
        let start = ((row + first) >> self.shape.log2_passes) * stride + column;
        let (low, high) = self.bytes.0.split_at_checked(half(PIXELS)).unwrap_or_default();
        let blocks = Blocks { low, high, start, stride };
        let area = u32::from(template.width()) * u32::from(template.height());
        let remaining = &mut self.remaining;
        let lower = |bound: &mut u32| {
            let is_whole = cfg!(not(smr_small)) && passes == 1; // saves a division
            let template = if is_whole { template } else { template.every(first, passes)? };
            let pixels = u32::from(template.width()) * u32::from(template.height());
            // `bound` still counts this pass's rows as fully similar: replaces their share by an upper bound of it.
            let others = *bound - pixels * u32::from(Table::ONE);
            let score = scorer.bound(&blocks, template, needed.saturating_sub(others));
            *bound = score.map_or(0, |score| others + score);
            if is_promising(*bound, needed, area, pass + 1, passes) {
                remaining.add((column, row));
            }
            Some(pixels)
        };
        self.bounds.as_flattened_mut().get_mut(group).and_then(lower).unwrap_or(0)
    }

    pub(super) fn is_worth_bounding(&self, group: usize, needed: u32, area: u32, pass: usize) -> bool {
        let bound = self.bounds.as_flattened().get(group);
        bound.is_some_and(|&bound| is_promising(bound, needed, area, pass, self.passes()))
    }

    pub(super) fn reaches(&self, group: usize, needed: u32) -> bool {
        self.bounds.as_flattened().get(group).is_some_and(|&bound| bound >= needed)
    }

    /// Index of the first group, `group` or a later one, that has a bound of at least `needed` and not 0.
    pub(super) fn next_group(&self, tile: &Tile, group: usize, needed: u32) -> Option<usize> {
        let bounds = self.bounds.as_flattened().get(..tile.groups())?.get(group..)?;
        Some(group + rolled(bounds.iter()).position(|&bound| bound >= needed.max(1))?)
    }
}

impl Shape {
    /// The division into the largest tiles, found by halving, that have at most `groups` groups and `capacity` bytes of
    /// ranges. `None` if no tile fits or the ranges of the fitting one cost too much (`pays`).
    fn of(template: (u16, u16), (columns, rows): (usize, usize), capacity: usize, groups: usize) -> Option<Self> {
        let (width, height) = (usize::from(template.0), usize::from(template.1));
        let mut shape = Self { width, height, columns, rows, log2_passes: 0 };
        while shape.columns >= SIDE && shape.rows >= SIDE {
            if shape.fits(capacity, groups) {
                return Some(shape).filter(Self::pays);
            }
            if shape.log2_passes < 2 {
                shape.log2_passes += 1;
            } else if shape.columns > shape.rows {
                shape.columns = (shape.columns - 1) / 2 + 1;
            } else {
                shape.rows = (shape.rows - 1) / 2 + 1;
            }
        }
        None
    }

    /// Sizes of the tiles along an axis of `all` offsets, in offsets; `most` is the largest size: see [`Ranges::tile`].
    fn sides(&self, most: usize, all: usize) -> impl Iterator<Item = usize> + Clone {
        (0..all).step_by(most.max(1)).map(move |from| most.min(all - from).max(SIDE.min(all)))
    }

    fn fits(&self, capacity: usize, groups: usize) -> bool {
        let tile = Tile { column: 0, row: 0, columns: self.columns, rows: self.rows };
        let ranges = self.stride_of(self.columns) * ((self.rows_of(self.rows) >> self.log2_passes) + 1);
        ranges <= half(capacity) && tile.groups() <= groups
    }

    /// True if a tile's ranges cost at most 1/16 of scoring its offsets: a small loss if they exclude no group.
    fn pays(&self) -> bool {
        let ranges = 2 * self.columns_of(self.columns) * self.rows_of(self.rows);
        16 * ranges <= self.columns * self.rows * self.width * self.height
    }

    /// The number of ranges in a row of a tile that is `columns` offsets wide.
    const fn columns_of(&self, columns: usize) -> usize {
        (self.width + columns).saturating_sub(SIDE)
    }

    /// The bytes of a row of ranges, rounded up to whole words.
    const fn stride_of(&self, columns: usize) -> usize {
        self.columns_of(columns).next_multiple_of(WORD)
    }

    const fn rows_of(&self, rows: usize) -> usize {
        (self.height + rows).saturating_sub(SIDE)
    }
}

/// First offset and size of a tile on an axis of `all` offsets. A tile begins before `from` if fewer than 4 are left.
#[cfg_attr(smr_small, inline(never))]
fn tile_extent(from: usize, most: usize, all: usize) -> (usize, usize) {
    let size = most.min(all.saturating_sub(from)).max(SIDE.min(all));
    (from.min(all.saturating_sub(size)), size)
}

/// True if further passes over a group are worthwhile after `done` of `passes` passes: its `bound` still reaches
/// `needed`, but would end at `needed` or below if each of the `passes` passes lost 5/4 of the mean loss of the passes
/// done. Other groups get no more passes, so a search that can exclude nothing stops bounding after the first pass.
fn is_promising(bound: u32, needed: u32, area: u32, done: usize, passes: usize) -> bool {
    // The loss from the full score to `score`, divided by 32 so that 20 times a loss fits a `u32`.
    let lost = |score: u32| (area * u32::from(Table::ONE)).saturating_sub(score) >> 5;
    #[allow(clippy::cast_possible_truncation)] // at most 4 passes
    let (taken, allowed) = (lost(bound) * 5 * passes as u32, lost(needed) * 4 * done as u32);
    bound >= needed && taken >= allowed
}

/// Half of a buffer of `capacity` bytes, in whole words: one half is for minima, one for maxima.
const fn half(capacity: usize) -> usize {
    capacity / 2 / WORD * WORD
}

/// Computes the ranges of `width` blocks with the top left pixels (`x`, `y`), (`x` + 1, `y`), and so on. `pixels`, if
/// given, begin at (`x`, `y`). Pixels outside the frame are 0.
#[inline(always)]
fn ranges_at(
    frame: &Frame<'_>,
    pixels: Option<Image<'_>>,
    (x, y): (i32, i32),
    width: usize,
    scorer: &Scorer<'_>,
    low: &mut [u8],
    high: &mut [u8],
) {
    let columns = u16::try_from(width + SIDE - 1).unwrap_or(u16::MAX);
    match pixels.or_else(|| frame.patch(Rect::new(x, y, columns, 4))) {
        Some(pixels) => ranges_of(pixels, width, scorer, low, high),
        None => ranges_at_border(frame, (x, y), width, scorer, low, high),
    }
}

/// Computes the ranges of the first `width` blocks of 4x4 pixels in the first four rows of `pixels`.
#[cfg_attr(smr_small, inline(never))]
fn ranges_of(pixels: Image<'_>, width: usize, scorer: &Scorer<'_>, low: &mut [u8], high: &mut [u8]) {
    let (pixels, stride) = pixels.parts();
    let mut rows = [&[][..]; SIDE];
    let mut rest = pixels;
    for row in &mut rows {
        *row = rest.get(..width + SIDE - 1).unwrap_or_default();
        rest = rest.get(stride..).unwrap_or_default();
    }
    scorer.ranges(&rows, low, high);
}

/// Computes the ranges if some pixels lie outside the frame: from a padded copy, 16 blocks at a time.
#[cold]
#[inline(never)] // keeps it out of the usual case, which is inlined
fn ranges_at_border(
    frame: &Frame<'_>,
    (x, y): (i32, i32),
    width: usize,
    scorer: &Scorer<'_>,
    low: &mut [u8],
    high: &mut [u8],
) {
    const AT_ONCE: u16 = 16; // the copy is on the stack
    const COLUMNS: u16 = AT_ONCE + 3;
    let (mut x, mut at) = (x, 0);
    while at < width {
        let mut copy = [[0; COLUMNS as usize]; SIDE];
        // Reads only the pixels that are needed: others may not be in memory.
        let columns = u16::try_from((width - at).min(AT_ONCE.into()) + SIDE - 1).unwrap_or(u16::MAX);
        let seen = Rect::new(x, y, columns, 4).intersection(frame.bounds());
        if let Some(pixels) = frame.patch(seen) {
            let right = usize::try_from(seen.x.saturating_sub(x)).unwrap_or(0);
            let down = usize::try_from(seen.y.saturating_sub(y)).unwrap_or(0);
            for row in 0..pixels.height() {
                let to = copy.get_mut(down + usize::from(row)).and_then(|to| to.get_mut(right..)).unwrap_or_default();
                rolled(to.iter_mut().zip(pixels.row(row))).for_each(|(to, &from)| *to = from);
            }
        }
        if let Ok(copy) = Image::new(copy.as_flattened(), COLUMNS, 4) {
            let blocks = at..low.len().min(at + usize::from(AT_ONCE));
            let (low, high) = (low.get_mut(blocks.clone()), high.get_mut(blocks));
            ranges_of(copy, AT_ONCE.into(), scorer, low.unwrap_or_default(), high.unwrap_or_default());
        }
        x = x.saturating_add(AT_ONCE.into());
        at += usize::from(AT_ONCE);
    }
}
