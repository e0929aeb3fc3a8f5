//! Groups of 4x4 offsets, excluded together by the ranges of the pixels that they meet.
//!
//! 1. Over the offsets of a group a pixel of the template meets a block of 4x4 pixels of the frame, and differs from each
//!    of them by at least its distance from their range, from the lowest to the highest.
//! 2. p does not rise with the difference. So the score that these distances give is at least that of every offset of the
//!    group, and with any rows left out, if these are taken to be fully similar, it is so all the more.
//!
//! Only a part of the ranges is in memory at a time, in a buffer of the template's own capacity: the window is gone through
//! in tiles, and a tile in up to four passes, each over every fourth (second, single) row of the frame and so of the
//! template. A group that cannot reach what is needed any more takes no part in the passes that follow.

use super::Window;
use crate::image::{Frame, Image, Rect};
use crate::similarity::{Scorer, Table};
use heapless::Vec;

/// Offsets of a group in a row, and in a column.
pub(super) const SIDE: usize = 4;

pub(super) struct Ranges<const PIXELS: usize, const SPAN: usize> {
    /// The lowest of each block, row by row, then the highest.
    bytes: Vec<u8, PIXELS>,
    /// The most that the offsets of each group can still score; 0 if that is not enough.
    reach: Vec<[u32; 3], SPAN>,
    shape: Shape,
}

/// How templates and windows of some size are divided.
#[derive(Clone, Copy)]
struct Shape {
    /// Pixels of the template.
    width: usize,
    height: usize,
    /// Offsets of the largest tile.
    columns: usize,
    rows: usize,
    /// There are 2 to the power of this many passes: 1, 2 or 4.
    halvings: u32,
}

/// Offsets that are gone through together, counted from the window's first.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Tile {
    pub(super) column: usize,
    pub(super) row: usize,
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl Tile {
    pub(super) const fn groups(&self) -> usize {
        self.columns.div_ceil(SIDE) * self.rows.div_ceil(SIDE)
    }

    /// The first offset of a group that is in no group before it, counted from the tile's.
    pub(super) fn new_in_group(&self, group: usize) -> (usize, usize) {
        let across = self.columns.div_ceil(SIDE).max(1);
        (group % across * SIDE, group / across * SIDE)
    }

    /// The first offset of a group. The last groups of a row or column begin earlier than they would, so as to end with the
    /// tile.
    pub(super) fn group(&self, group: usize) -> (usize, usize) {
        let (column, row) = self.new_in_group(group);
        (column.min(self.columns.saturating_sub(SIDE)), row.min(self.rows.saturating_sub(SIDE)))
    }
}

impl<const PIXELS: usize, const SPAN: usize> Ranges<PIXELS, SPAN> {
    #[inline(always)] // made where it stays
    pub(super) const fn new() -> Self {
        let shape = Shape { width: 0, height: 0, columns: 0, rows: 0, halvings: 0 };
        Self { bytes: Vec::new(), reach: Vec::new(), shape }
    }

    /// Clears the memory. Not in `new`, which would move so many zeroes about; after the first time there is nothing to do.
    pub(super) fn reserve(&mut self) {
        // Neither can fail.
        let _ = (self.bytes.resize(PIXELS, 0), self.reach.resize(SPAN, [0; 3]));
    }

    /// Divides a window for a template. False if it cannot be: a window of less than four rows or columns has no groups.
    pub(super) fn divide(&mut self, window: &Window, template: Image<'_>) -> bool {
        let shape = Shape::of((template.width(), template.height()), window.size(), PIXELS, 3 * SPAN);
        self.shape = shape.unwrap_or(self.shape);
        shape.is_some()
    }

    pub(super) const fn passes(&self) -> usize {
        1 << self.shape.halvings
    }

    /// The tile that holds the offset at (`column`, `row`) and all that follow it, as far as it reaches.
    pub(super) fn tile(&self, window: &Window, column: usize, row: usize) -> Tile {
        let (columns, rows) = window.size();
        let part = |from: usize, most: usize, all: usize| {
            let size = most.min(all.saturating_sub(from)).max(SIDE.min(all));
            (from.min(all.saturating_sub(size)), size)
        };
        let ((column, columns), (row, rows)) =
            (part(column, self.shape.columns, columns), part(row, self.shape.rows, rows));
        Tile { column, row, columns, rows }
    }

    /// The most that the groups of a window cost, beside its offsets: of each tile two comparisons for each range, the template once for
    /// each group, and a word for each group when the tile is begun, in each pass, and while its offsets are scored.
    pub(super) fn most(window: (usize, usize), (width, height): (u16, u16)) -> u64 {
        let Some(shape) = Shape::of((width, height), window, PIXELS, 3 * SPAN) else { return 0 };
        let pixels = usize::from(width) * usize::from(height);
        let per_group = pixels + 2 + (1 << shape.halvings);
        let (across, down) = (shape.parts(shape.columns, window.0), shape.parts(shape.rows, window.1));
        let tiles = down.flat_map(|rows| across.clone().map(move |columns| (columns, rows)));
        let most = tiles.map(|(columns, rows)| {
            let tile = Tile { column: 0, row: 0, columns, rows };
            let ranges = 2 * shape.columns_of(columns) * shape.rows_of(rows);
            u64::try_from(ranges + tile.groups() * per_group).unwrap_or(u64::MAX)
        });
        most.sum()
    }

    /// Lets every group of `tile` reach the score of `pixels` fully similar pixels.
    pub(super) fn start(&mut self, tile: &Tile, pixels: u32) {
        let reach = self.reach.as_flattened_mut();
        reach.iter_mut().take(tile.groups()).for_each(|reach| *reach = pixels * u32::from(Table::ONE));
    }

    /// Rows of ranges that a pass of `tile` needs.
    pub(super) fn rows(&self, tile: &Tile, pass: usize) -> usize {
        (self.shape.rows_of(tile.rows) + self.passes() - 1).saturating_sub(pass) >> self.shape.halvings
    }

    /// Computes a row of ranges; returns how many there are in it.
    pub(super) fn spread(
        &mut self,
        frame: &Frame<'_>,
        window: &Window,
        tile: &Tile,
        pass: usize,
        row: usize,
        scorer: &Scorer<'_>,
    ) -> u32 {
        let width = self.shape.columns_of(tile.columns);
        let (x, y) = window.position(tile.column, tile.row + pass + row * self.passes());
        let (low, high) = self.bytes.split_at_mut_checked(PIXELS / 2).unwrap_or_default();
        let low = low.get_mut(row * width..).and_then(|rest| rest.get_mut(..width)).unwrap_or_default();
        let high = high.get_mut(row * width..).and_then(|rest| rest.get_mut(..width)).unwrap_or_default();
        spread(frame, x, y, scorer, low, high);
        u32::try_from(width).unwrap_or(u32::MAX / 2)
    }

    /// Adds a pass to what is known of a group, which must then still be able to reach `needed`. Returns how many pixels were
    /// compared, at most.
    pub(super) fn look(
        &mut self,
        template: Image<'_>,
        tile: &Tile,
        pass: usize,
        group: usize,
        needed: u32,
        scorer: &Scorer<'_>,
    ) -> u32 {
        let (column, row) = tile.group(group);
        // The rows of the template that meet the rows of this pass, and the first row of ranges that they meet.
        let passes = self.passes();
        let first = pass.wrapping_sub(row) & (passes - 1);
        let stride = self.shape.columns_of(tile.columns);
        let start = ((row + first) >> self.shape.halvings) * stride + column;
        let (low, high) = self.bytes.split_at_checked(PIXELS / 2).unwrap_or_default();
        let look = |reach: &mut u32| {
            let template = template.every(first, passes)?;
            let size = (template.width(), template.height());
            let low = Image::with_stride(low.get(start..)?, size.0, size.1, stride).ok()?;
            let high = low.like(high.get(start..)?)?;
            let pixels = u32::from(template.width()) * u32::from(template.height());
            // Of what the group can reach, the similarities of these rows are replaced by what their ranges allow.
            let others = *reach - pixels * u32::from(Table::ONE);
            let score = scorer.score_between_at_least(low, high, template, needed.max(1).saturating_sub(others));
            *reach = score.map_or(0, |score| others + score);
            Some(pixels)
        };
        self.reach.as_flattened_mut().get_mut(group).and_then(look).unwrap_or(0)
    }

    /// The first group from `group` on of which an offset could reach `needed`, and more than nothing, as far as has been
    /// looked.
    pub(super) fn next(&self, tile: &Tile, group: usize, needed: u32) -> Option<usize> {
        let reach = self.reach.as_flattened().get(..tile.groups())?.get(group..)?;
        Some(group + reach.iter().position(|&reach| reach >= needed.max(1))?)
    }
}

impl Shape {
    /// The largest tiles whose ranges take no more than `capacity` bytes, and of no more than `groups` groups. `None` if
    /// there are none, or if they could cost more than they save.
    fn of(template: (u16, u16), (columns, rows): (usize, usize), capacity: usize, groups: usize) -> Option<Self> {
        let (width, height) = (usize::from(template.0), usize::from(template.1));
        let mut shape = Self { width, height, columns, rows, halvings: 0 };
        while shape.columns >= SIDE && shape.rows >= SIDE {
            if shape.fits(capacity, groups) {
                return Some(shape).filter(Self::pays);
            }
            if shape.halvings < 2 {
                shape.halvings += 1;
            } else if shape.columns > shape.rows {
                shape.columns = (shape.columns - 1) / 2 + 1;
            } else {
                shape.rows = (shape.rows - 1) / 2 + 1;
            }
        }
        None
    }

    /// The sizes of the tiles on an axis of so many offsets, of which the largest has `most`: see [`Ranges::tile`].
    fn parts(&self, most: usize, all: usize) -> impl Iterator<Item = usize> + Clone {
        (0..all).step_by(most.max(1)).map(move |from| most.min(all - from).max(SIDE.min(all)))
    }

    fn fits(&self, capacity: usize, groups: usize) -> bool {
        let tile = Tile { column: 0, row: 0, columns: self.columns, rows: self.rows };
        let ranges = self.columns_of(self.columns) * ((self.rows_of(self.rows) >> self.halvings) + 1);
        ranges <= capacity / 2 && tile.groups() <= groups
    }

    /// Whether the ranges of a tile cost no more than a sixteenth of the offsets: where nothing can be excluded that is lost.
    fn pays(&self) -> bool {
        let ranges = 2 * self.columns_of(self.columns) * self.rows_of(self.rows);
        16 * ranges <= self.columns * self.rows * self.width * self.height
    }

    /// Ranges in a row of a tile of so many columns of offsets: one for each pixel that is the first of a block.
    const fn columns_of(&self, columns: usize) -> usize {
        (self.width + columns).saturating_sub(SIDE)
    }

    const fn rows_of(&self, rows: usize) -> usize {
        (self.height + rows).saturating_sub(SIDE)
    }
}

/// The ranges of the blocks whose first pixels are at (`x`..., `y`) of the frame; what lies outside it is zeroes.
fn spread(frame: &Frame<'_>, x: i32, y: i32, scorer: &Scorer<'_>, low: &mut [u8], high: &mut [u8]) {
    let columns = u16::try_from(low.len() + SIDE - 1).unwrap_or(u16::MAX);
    match frame.patch(Rect::new(x, y, columns, 4)) {
        Some(pixels) => scorer.spread(&[0, 1, 2, 3].map(|row| pixels.row(row)), low, high),
        None => spread_at_border(frame, x, y, scorer, low, high),
    }
}

/// The same where some of the pixels lie outside the frame: of a copy of them, part by part.
#[cold]
#[inline(never)] // no part of the usual case, which is inlined
fn spread_at_border(frame: &Frame<'_>, x: i32, y: i32, scorer: &Scorer<'_>, low: &mut [u8], high: &mut [u8]) {
    const PART: u16 = 16; // the copy is on the stack
    let mut x = x;
    for (low, high) in low.chunks_mut(PART.into()).zip(high.chunks_mut(PART.into())) {
        let mut copy = [[0; PART as usize + SIDE - 1]; SIDE];
        // No pixel more than needed: others may not be in memory.
        let columns = u16::try_from(low.len() + SIDE - 1).unwrap_or(u16::MAX);
        let seen = Rect::new(x, y, columns, 4).intersection(frame.bounds());
        if let Some(pixels) = frame.patch(seen) {
            let right = usize::try_from(seen.x.saturating_sub(x)).unwrap_or(0);
            let down = usize::try_from(seen.y.saturating_sub(y)).unwrap_or(0);
            for (to, from) in copy.iter_mut().skip(down).zip(pixels.rows()) {
                to.iter_mut().skip(right).zip(from).for_each(|(to, &from)| *to = from);
            }
        }
        scorer.spread(&copy.each_ref().map(<[u8; PART as usize + SIDE - 1]>::as_slice), low, high);
        x = x.saturating_add(PART.into());
    }
}
