//! Box means: the window and the template at an eighth of their pixels, to exclude offsets without scoring them.
//!
//! 1. A pixel of difference d loses at least s * d of its 65535 (`Scorer::loss_per_level`), so an offset's score is at
//!    most 65535 * n - s * SAD.
//! 2. A box is a column of eight pixels. The SAD within a box is at least 8 * |mean of F - mean of G|.
//! 3. The means are rounded down by 0 to 1.5 (`scalar::means`), so two of them differ by at most 1.5 less than it seems:
//!    SAD >= 8 * (SAD of the means) - 12 * (number of boxes).
//!
//! Rows of the template below its last whole box are taken to lose nothing.
//!
//! The window is gone through in tiles, and a tile in eight phases: the offsets of a phase lie eight rows apart, so its
//! boxes do not overlap, and one buffer of the template's own capacity holds them.

use super::Window;
use crate::image::{Frame, Image, Rect};
use crate::similarity::Scorer;

/// Rows of a box.
pub(super) const HEIGHT: u16 = 8;

const ROWS: [u16; HEIGHT as usize] = [0, 1, 2, 3, 4, 5, 6, 7];

/// The means of the template's boxes, then those of a tile's boxes in one phase.
pub(super) struct Boxes<const PIXELS: usize> {
    means: [u8; PIXELS],
    shape: Shape,
}

/// How the template and the tiles are divided. In offsets (tile) and in boxes (the rest).
#[derive(Clone, Copy, Default)]
struct Shape {
    /// Of the template: boxes in a row, which is pixels, and rows of boxes.
    width: u16,
    rows: u16,
    tile_columns: usize,
    tile_rows: usize,
}

/// Offsets that are gone through together, counted from the window's first.
#[derive(Clone, Copy, Default)]
pub(super) struct Tile {
    pub(super) column: usize,
    pub(super) row: usize,
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl Tile {
    /// The rows of offsets in a phase.
    pub(super) const fn rows_in(&self, phase: u16) -> usize {
        self.rows.saturating_sub(phase as usize).div_ceil(HEIGHT as usize)
    }
}

impl<const PIXELS: usize> Boxes<PIXELS> {
    pub(super) const fn new() -> Self {
        let shape = Shape { width: 0, rows: 0, tile_columns: 0, tile_rows: 0 };
        Self { means: [0; PIXELS], shape }
    }

    /// Divides a window for templates of this size. Without boxes (`None`) the window is one tile.
    pub(super) fn reset(&mut self, window: &Window, template: Option<Image<'_>>) {
        let (columns, rows) = window.size();
        self.shape = Shape { tile_columns: columns, tile_rows: rows, ..Shape::default() };
        if let Some(template) = template.filter(|template| template.height() >= HEIGHT) {
            self.shape = Shape::of(template, columns, rows, PIXELS);
        }
    }

    /// Rows of boxes in the template; 0 if there are no boxes.
    pub(super) const fn rows(&self) -> u16 {
        self.shape.rows
    }

    /// Boxes of the template.
    pub(super) fn boxes(&self) -> u32 {
        u32::from(self.shape.width) * u32::from(self.shape.rows)
    }

    /// The tile whose first offset is (`column`, `row`).
    pub(super) fn tile(&self, window: &Window, column: usize, row: usize) -> Tile {
        let (columns, rows) = window.size();
        let Shape { tile_columns, tile_rows, .. } = self.shape;
        Tile {
            column,
            row,
            columns: tile_columns.min(columns.saturating_sub(column)),
            rows: tile_rows.min(rows.saturating_sub(row)),
        }
    }

    /// Rows of boxes that a phase of `tile` needs.
    pub(super) fn rows_of(&self, tile: &Tile, phase: u16) -> u16 {
        match tile.rows_in(phase) {
            0 => 0,
            rows => u16::try_from(rows).unwrap_or(u16::MAX).saturating_add(self.shape.rows - 1),
        }
    }

    /// Shrinks a row of the template's boxes.
    pub(super) fn shrink_template(&mut self, template: Image<'_>, row: u16, scorer: &Scorer) {
        let width = usize::from(self.shape.width);
        let means = self.means.get_mut(usize::from(row) * width..).and_then(|rest| rest.get_mut(..width));
        let rows = ROWS.map(|i| template.row(row * HEIGHT + i));
        scorer.means(&rows, means.unwrap_or_default());
    }

    /// Shrinks a row of boxes of a tile. `row` counts within the phase; returns how many boxes there are.
    pub(super) fn shrink_window(
        &mut self,
        frame: &Frame<'_>,
        window: &Window,
        tile: &Tile,
        phase: u16,
        row: u16,
        scorer: &Scorer,
    ) -> usize {
        let width = self.shape.width_of(tile);
        let start = self.shape.boxes() + usize::from(row) * width;
        let Some(means) = self.means.get_mut(start..).and_then(|rest| rest.get_mut(..width)) else { return 0 };
        let (x, y) = window.position(tile.column, tile.row + usize::from(phase) + usize::from(row * HEIGHT));
        shrink(frame, x, y, scorer, means);
        width
    }

    /// The SAD of the means at an offset, `column` in the tile and `row` in the phase; any part of it that is more than
    /// `enough` once it is more.
    #[inline]
    pub(super) fn distance(&self, tile: &Tile, column: usize, row: usize, enough: u32, scorer: &Scorer) -> u32 {
        let Shape { width, rows, .. } = self.shape;
        let stride = self.shape.width_of(tile);
        let patch = self.means.get(self.shape.boxes() + row * stride + column..).unwrap_or_default();
        match (Image::with_stride(patch, width, rows, stride), Image::new(&self.means, width, rows)) {
            (Ok(patch), Ok(template)) => scorer.distance(patch, template, enough),
            _ => 0,
        }
    }

    /// The largest SAD of the means with which a score of `needed` is still possible for a template of `pixels`.
    pub(super) fn enough(&self, pixels: u32, needed: u32, loss_per_level: u32) -> u32 {
        let may_lose = (pixels * u32::from(crate::similarity::Table::ONE)).saturating_sub(needed);
        // At most 2^32 / 1 + 12 * 2^13: no overflow but for a loss of 0, with which nothing can be excluded.
        let levels = may_lose.checked_div(loss_per_level).unwrap_or(u32::MAX);
        levels.saturating_add(12 * self.boxes()) / u32::from(HEIGHT)
    }

    /// The largest SAD of the means that there can be.
    pub(super) fn largest_distance(&self) -> u32 {
        self.boxes() * 255
    }
}

impl Shape {
    /// The largest tiles whose boxes, with those of the template, take no more than `capacity` bytes.
    ///
    /// There is always one: with a single row of offsets in a phase a tile needs as many rows of boxes as the template,
    /// and the template's boxes are an eighth of its pixels, of which there are at most `capacity`.
    fn of(template: Image<'_>, columns: usize, rows: usize, capacity: usize) -> Self {
        let (width, box_rows) = (template.width(), template.height() / HEIGHT);
        let (wide, high) = (usize::from(width), usize::from(box_rows));
        let room = capacity.saturating_sub(wide * high);
        let mut rows_in_phase = rows.div_ceil(usize::from(HEIGHT));
        loop {
            let stride = room / (rows_in_phase + high - 1);
            let tile_columns = (stride + 1).saturating_sub(wide).min(columns);
            if tile_columns >= columns.min(wide) || rows_in_phase == 1 {
                let tile_rows = (rows_in_phase * usize::from(HEIGHT)).min(rows);
                return Self { width, rows: box_rows, tile_columns: tile_columns.max(1), tile_rows };
            }
            rows_in_phase = rows_in_phase.div_ceil(2);
        }
    }

    /// Boxes of the template.
    fn boxes(&self) -> usize {
        usize::from(self.width) * usize::from(self.rows)
    }

    /// Boxes in a row of a tile.
    fn width_of(&self, tile: &Tile) -> usize {
        (usize::from(self.width) + tile.columns).saturating_sub(1)
    }
}

/// The means of the boxes whose first pixels are at (`x`..., `y`) of the frame; what lies outside it is zeroes.
fn shrink(frame: &Frame<'_>, x: i32, y: i32, scorer: &Scorer, means: &mut [u8]) {
    const ZEROES: [u8; 128] = [0; 128];
    let mut x = x;
    for means in means.chunks_mut(ZEROES.len()) {
        let width = u16::try_from(means.len()).unwrap_or(0);
        let seen = Rect::new(x, y, width, HEIGHT).intersection(frame.bounds());
        if seen.width < width {
            means.fill(0);
        }
        if let Some(pixels) = frame.patch(seen) {
            let first = usize::try_from(seen.x.saturating_sub(x)).unwrap_or(0);
            let above = u16::try_from(seen.y.saturating_sub(y)).unwrap_or(0);
            let zeroes = ZEROES.get(..usize::from(seen.width)).unwrap_or_default();
            let rows = ROWS.map(|i| match i.checked_sub(above) {
                Some(row) if row < seen.height => pixels.row(row),
                _ => zeroes,
            });
            scorer.means(&rows, means.get_mut(first..).unwrap_or_default());
        } else {
            means.fill(0);
        }
        x = x.saturating_add(i32::from(width));
    }
}
