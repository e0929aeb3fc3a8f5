//! The grid: target and surroundings, resampled so that the target has about 1600 pixels, whatever its size in the frame.
//!
//! Where a step of the grid is two pixels or more, the frame is first reduced by 2x2 means (4x4, 8x8, ...) until it is less
//! than two; then the four neighbours are mixed by fractions of 1/256. Beyond the frame its edge goes on. Only the pixels
//! that are sampled are read, and each row of means is made once.

use super::features::CELL;
use super::{MOST_CELLS, MOST_PIXELS, REACH};
use crate::image::{Frame, Image, Rect};
use heapless::Vec;

/// One pixel, as positions have it.
pub(super) const PIXEL: i64 = 1 << 12;
/// 1.0, as scales have it.
pub(super) const SCALE: u32 = 1 << 16;
/// The least and the most cells of the filter on a side.
const LEAST_SIDE: u64 = 4;
pub(super) const MOST_SIDE: u16 = 32;
/// The most columns that a row of the grid can have: a search window, and the pixel on each side that gradients need.
pub(super) const COLUMNS: usize = ((MOST_SIDE + 2 * REACH) * CELL + 2) as usize;
/// The most pixels, or means, that such a row lies on.
const ROW: usize = 2 * COLUMNS + 2;

/// Shapes of the template and of the filter, and the grid's step at scale 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Grid {
    /// Columns of the template, in pixels of the grid.
    pub columns: u16,
    /// Rows of the template, in pixels of the grid.
    pub rows: u16,
    /// Columns of the filter, in cells of 4x4 pixels of the grid. It covers 1.4 times the target.
    pub across: u16,
    /// Rows of the filter, in cells.
    pub down: u16,
    /// Frame pixels from one pixel of the grid to the next at scale 1, in units of 1/4096.
    pub step: u32,
}

impl Grid {
    /// The grid for a box of this size.
    ///
    /// The step is sqrt(area / 1600), at least half a pixel. Sides are rounded; the longer one is cut until template and filter
    /// have room: of a very long box only the middle is looked at.
    #[must_use]
    pub fn new(target: Rect) -> Self {
        let area = u64::from(target.area()) << 24;
        let step = (area / MOST_PIXELS as u64).isqrt().max(2048);
        // 1.4 times the side, in cells: 1.4 / 4 = 7 / 20.
        let cells =
            |size: u16| ((7 * (u64::from(size) << 12) + 10 * step) / (20 * step)).clamp(LEAST_SIDE, MOST_SIDE.into());
        let (across, down) = fitting(cells(target.width), cells(target.height), MOST_CELLS as u64);
        // Even, so that the template's middle is the window's.
        let pixels = |size: u16, cells: u16| {
            let side = 2 * (((u64::from(size) << 12) + step) / (2 * step));
            // Not clamp, which could be a panic where it is folded.
            side.min((cells * CELL).into()).max(4)
        };
        let (columns, rows) =
            fitting(pixels(target.width, across) / 2, pixels(target.height, down) / 2, MOST_PIXELS as u64 / 4);
        Self { columns: 2 * columns, rows: 2 * rows, across, down, step: u32::try_from(step).unwrap_or(u32::MAX) }
    }

    /// Pixels of the template.
    pub(super) fn pixels(&self) -> u32 {
        u32::from(self.columns) * u32::from(self.rows)
    }

    /// The step at `scale`, in units of 1/4096 pixel.
    pub(super) fn step_at(&self, scale: u32) -> i64 {
        ((i64::from(self.step) * i64::from(scale)) >> 16).max(1)
    }
}

/// Two sides, the longer one cut until their product is at most `most`.
fn fitting(mut across: u64, mut down: u64, most: u64) -> (u16, u16) {
    while across * down > most {
        *(if across > down { &mut across } else { &mut down }) -= 1;
    }
    let small = |side: u64| u16::try_from(side).unwrap_or(u16::MAX);
    (small(across), small(down))
}

/// Where samples are taken: columns and rows `step` apart, around a centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Lattice {
    pub(super) x: i64,
    pub(super) y: i64,
    pub(super) step: i64,
    pub(super) columns: u16,
    pub(super) rows: u16,
}

/// One axis of a lattice on the reduced frame.
#[derive(Clone, Copy)]
struct Axis {
    first: i64,
    step: i64,
    /// The last position that there is.
    end: i64,
}

impl Axis {
    fn new(centre: i64, step: i64, count: u16, halvings: u32, size: u16) -> Self {
        let first = centre - (i64::from(count) - 1) * step / 2;
        // The middle of the first block of means lies half a block from the first pixel's.
        let middle = ((1 << halvings) - 1) * PIXEL / 2;
        let blocks = i64::from((size >> halvings).max(1));
        Self { first: (first - middle) >> halvings, step: step >> halvings, end: (blocks - 1) * PIXEL }
    }

    /// Block, the one that follows it, and the latter's part in units of 1/256.
    fn at(&self, number: u16) -> (u16, u16, u32) {
        // The end is never below 0; said here, the clamp has no path to a panic.
        let position = (self.first + i64::from(number) * self.step).clamp(0, self.end.max(0));
        let block = position / PIXEL;
        let next = (block + 1).min(self.end / PIXEL);
        let part = position % PIXEL / (PIXEL / 256);
        // No block lies beyond the frame's 65535 pixels.
        let small = |block: i64| u16::try_from(block).unwrap_or(u16::MAX);
        (small(block), small(next), u32::try_from(part).unwrap_or(0))
    }
}

impl Lattice {
    fn halvings(&self) -> u32 {
        let mut halvings = 0;
        while self.step >> halvings >= 2 * PIXEL {
            halvings += 1;
        }
        halvings
    }

    fn axes(&self, bounds: Rect) -> (Axis, Axis) {
        let halvings = self.halvings();
        let x = Axis::new(self.x, self.step, self.columns, halvings, bounds.width);
        (x, Axis::new(self.y, self.step, self.rows, halvings, bounds.height))
    }

    /// The pixels that are read, in a frame with these bounds.
    pub(super) fn pixels(&self, bounds: Rect) -> Rect {
        let (x, y) = self.axes(bounds);
        let side = 1 << self.halvings();
        let extent = |axis: &Axis, count: u16, size: u16| {
            let from = i32::from(axis.at(0).0) * side;
            (from, ((i32::from(axis.at(count.saturating_sub(1)).1) + 1) * side).min(i32::from(size)) - from)
        };
        let ((left, width), (top, height)) =
            (extent(&x, self.columns, bounds.width), extent(&y, self.rows, bounds.height));
        Rect::new(left, top, u16::try_from(width).unwrap_or(u16::MAX), u16::try_from(height).unwrap_or(u16::MAX))
    }

    /// Samples `frame`, row by row from the top; false, and no row, if pixels that are read are not in memory.
    pub(super) fn rows(&self, frame: &Frame<'_>, mut each: impl FnMut(&[u8])) -> bool {
        let bounds = frame.bounds();
        let (across, down) = self.axes(bounds);
        let Some(pixels) = frame.patch(self.pixels(bounds)) else { return false };
        let mut means = Means::new(pixels, across.at(0).0, down.at(0).0, self.halvings());
        // Cannot fail: a lattice has at most COLUMNS columns.
        let mut columns = Vec::<(u16, u16), COLUMNS>::new();
        for column in 0..self.columns {
            let (left, _, part) = across.at(column);
            let _ = columns.push((left - means.left, u16::try_from(part).unwrap_or(0)));
        }
        let mut out = Vec::<u8, COLUMNS>::new();
        let _ = out.resize_default(columns.len());
        for row in 0..self.rows {
            let (upper, lower, part) = down.at(row);
            means.make(upper);
            means.make(lower);
            let mixed = means.mix(upper, lower, part);
            for (&(left, across), out) in columns.iter().zip(&mut out) {
                let across = u32::from(across);
                let at = |column: u16| u32::from(mixed.get(usize::from(column)).copied().unwrap_or(0));
                // After the last block comes none, and the part of that is 0.
                let value = (at(left) * (256 - across) + at(left + 1) * across + (1 << 15)) >> 16;
                *out = u8::try_from(value).unwrap_or(u8::MAX);
            }
            each(&out);
        }
        true
    }

    /// Samples `frame` into `out`; false, and nothing of use in `out`, if pixels that are read are not in memory or there is
    /// no room.
    #[inline(never)] // one copy in flash
    pub(super) fn sample<const N: usize>(&self, frame: &Frame<'_>, out: &mut Vec<u8, N>) -> bool {
        out.clear();
        let mut fits = true;
        self.rows(frame, |row| fits &= out.extend_from_slice(row).is_ok()) && fits
    }
}

/// Two rows of block means, the ones that are being mixed.
struct Means<'a> {
    pixels: Image<'a>,
    /// Block of the first column and of the first row that there are.
    left: u16,
    top: u16,
    halvings: u32,
    rows: [(Option<u16>, Vec<u8, ROW>); 2],
    /// Sums of blocks while a row of means is made; then a row that is mixed of two, in units of 1/256 gray level.
    scratch: Vec<u16, ROW>,
}

impl<'a> Means<'a> {
    fn new(pixels: Image<'a>, left: u16, top: u16, halvings: u32) -> Self {
        Self { pixels, left, top, halvings, rows: [(None, Vec::new()), (None, Vec::new())], scratch: Vec::new() }
    }

    /// Between two rows, the lower having a part of so many 256ths.
    fn mix(&mut self, upper: u16, lower: u16, part: u32) -> &[u16] {
        let Self { pixels, top, halvings, rows, scratch, .. } = self;
        let (upper, lower) = (row(*pixels, rows, *halvings, *top, upper), row(*pixels, rows, *halvings, *top, lower));
        // Cannot fail: there is room for a row. Written over, not pushed: that takes half the instructions.
        let _ = scratch.resize_default(upper.len());
        for ((mixed, &upper), &lower) in scratch.iter_mut().zip(upper).zip(lower) {
            // At most 255 * 256.
            *mixed = u16::try_from(u32::from(upper) * (256 - part) + u32::from(lower) * part).unwrap_or(u16::MAX);
        }
        scratch
    }

    /// Rows that follow each other are kept in turns.
    fn make(&mut self, block: u16) {
        let Self { pixels, top, halvings, rows: [even, odd], scratch: whole, .. } = self;
        let (made, means) = if block.is_multiple_of(2) { even } else { odd };
        if *halvings == 0 || *made == Some(block) {
            return;
        }
        *made = Some(block);
        let first = block.saturating_sub(*top) << *halvings;
        sum_whole_blocks(*pixels, first, *halvings, whole);
        let shift = 2 * *halvings;
        // Cannot fail: a lattice has at most COLUMNS columns, less than two blocks apart.
        let _ = means.resize_default(usize::from(pixels.width()).div_ceil(1 << *halvings));
        for (mean, &sum) in means.iter_mut().zip(&*whole) {
            *mean = u8::try_from((u32::from(sum) + (1 << (shift - 1))) >> shift).unwrap_or(u8::MAX);
        }
        for (column, mean) in means.iter_mut().enumerate().skip(whole.len()) {
            *mean = mean_of(*pixels, first, column, *halvings);
        }
    }
}

/// A row of means that was made, or of pixels where nothing is halved.
fn row<'a>(
    pixels: Image<'a>,
    [even, odd]: &'a [(Option<u16>, Vec<u8, ROW>); 2],
    halvings: u32,
    top: u16,
    block: u16,
) -> &'a [u8] {
    if halvings == 0 {
        return pixels.row(block.saturating_sub(top));
    }
    if block.is_multiple_of(2) { &even.1 } else { &odd.1 }
}

/// The row of `pixels` that a block has at `row`: the frame's last row goes on where it is cut before a block is whole.
fn row_of<'a>(pixels: Image<'a>, first: u16, row: u16) -> &'a [u8] {
    pixels.row(first.saturating_add(row).min(pixels.height() - 1))
}

/// The sums of the blocks in a row that are not cut, for sides of 2 and 4: few targets have larger ones. None for
/// those.
fn sum_whole_blocks(pixels: Image<'_>, first: u16, halvings: u32, sums: &mut Vec<u16, ROW>) {
    let add: fn(&mut [u16], &[u8]) = match halvings {
        1 => add_row::<2>,
        2 => add_row::<4>,
        _ => return sums.clear(),
    };
    sums.clear();
    let _ = sums.resize_default(usize::from(pixels.width() >> halvings));
    for row in 0..1 << halvings {
        add(sums, row_of(pixels, first, row));
    }
}

fn add_row<const SIDE: usize>(sums: &mut [u16], row: &[u8]) {
    let (blocks, _) = row.as_chunks::<SIDE>();
    for (sum, block) in sums.iter_mut().zip(blocks) {
        *sum += block.iter().map(|&pixel| u16::from(pixel)).sum::<u16>();
    }
}

/// The mean of a block of any size, of which a part may be beyond the frame's right edge.
fn mean_of(pixels: Image<'_>, first: u16, column: usize, halvings: u32) -> u8 {
    let side = 1usize << halvings;
    // A step is below 2^17 pixels, so a block's side is at most 2^16 and the sum below 2^40.
    let mut sum = 0u64;
    for row in 0..side {
        let row = row_of(pixels, first, u16::try_from(row).unwrap_or(u16::MAX));
        let block = row.get(column * side..(column * side + side).min(row.len())).unwrap_or_default();
        let missing = u32::try_from(side - block.len()).unwrap_or(0);
        let edge = missing * u32::from(row.last().copied().unwrap_or(0));
        sum += u64::from(block.iter().map(|&pixel| u32::from(pixel)).sum::<u32>() + edge);
    }
    u8::try_from((sum + (1 << (2 * halvings - 1))) >> (2 * halvings)).unwrap_or(u8::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_blocks_have_the_mean_that_any_block_has() {
        let pixels: std::vec::Vec<u8> =
            (0..83 * 50u32).map(|at| (at.wrapping_mul(2_654_435_761) >> 20) as u8).collect();
        let image = Image::new(&pixels, 83, 50).unwrap();
        for halvings in 1..=6 {
            let mut means = Means::new(image, 0, 0, halvings);
            for block in 0..50u16.div_ceil(1 << halvings) {
                means.make(block);
                let one_by_one = (0..83usize.div_ceil(1 << halvings))
                    .map(|column| mean_of(image, block << halvings, column, halvings));
                let made = row(image, &means.rows, halvings, 0, block);
                assert_eq!(made, one_by_one.collect::<std::vec::Vec<_>>(), "{halvings} halvings");
            }
        }
    }

    #[test]
    fn the_largest_sums_of_whole_blocks() {
        let white = [255; 8 * 4];
        let mut sums = Vec::new();
        sum_whole_blocks(Image::new(&white, 8, 4).unwrap(), 0, 2, &mut sums);
        assert_eq!(sums, [255 * 16; 2]);
    }
}
