//! Sampling: resamples the target and its surroundings to a lattice. Bilinear interpolation; weights in units of 1/256.
//!
//! For a lattice step of two pixels or more, the frame is first reduced to means of blocks of 2x2 pixels (4x4, 8x8,
//! ...), until a step is less than two blocks. Beyond the frame its edge pixels are repeated.
//!
//! The mean of a larger block is approximated by four of its pixels: two in each of two rows, a quarter of its side
//! from its edges. These pixels are evenly spaced over the whole frame, and a sample reads at most 16 of them.
//!
//! | value | unit | bound |
//! |---|---|---|
//! | position | 1/4096 pixel of the reduced frame | 2^29 |
//! | sum of a block | gray level | 4 * 255 |
//! | row interpolated from two | 1/256 gray level | 256 * 255 |

use super::super::constants::{CELL, MARGIN, MAX_SIDE, PIXEL, PIXEL_BITS, REACH};
use super::grid::Grid;
use super::motion::Place;
use crate::image::{Frame, Image, Rect};
use crate::kernels::{BIAS, Interpolation, MixedRow, rolled};
use heapless::{Vec, VecView};

/// Columns of the largest lattice: a search window, and a pixel on each side for the gradients.
pub(super) const COLUMNS: usize = ((MAX_SIDE + 2 * REACH) * CELL + 2) as usize;
/// Units of work for each sample, in addition to one for each pixel that is read.
pub(crate) const SAMPLED: u32 = 32;
/// The largest number of frame pixels, or of blocks of pixels, that a row of the largest lattice covers.
const ROW: usize = 2 * COLUMNS + 2;

/// Upper bound of the frame pixels that a lattice reads: four of each block, if samples are less than two blocks apart.
pub(crate) const fn most_read(columns: u32, rows: u32) -> u32 {
    4 * (2 * columns + 1) * (2 * rows + 1)
}

/// Sample positions: `step` and `step_down` apart around the centre (`x`, `y`), in units of 1/4096 pixel of the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Lattice {
    pub(crate) x: i64,
    pub(crate) y: i64,
    pub(crate) step: i64,
    pub(crate) step_down: i64,
    pub(crate) columns: u16,
    pub(crate) rows: u16,
}

/// One axis of a lattice, in units of 1/4096 block (2^`halvings` pixels). Positions are below 2^29: a frame has at most
/// 65,535 pixels on a side, and a lattice reaches less than twice `COLUMNS` blocks beyond it.
#[derive(Clone, Copy)]
struct Axis {
    first: i32,
    step: i32,
    /// The position of the last block, at least 0.
    end: i32,
}

impl Axis {
    #[inline(never)]
    fn new(centre: i64, step: i64, count: u16, halvings: u32, size: u16) -> Self {
        let first = centre - (i64::from(count) - 1) * step / 2;
        // The middle of the first block, halfway between the two of its columns (or rows) that are read.
        let middle = pair(halvings).map(i64::from).iter().sum::<i64>() * PIXEL / 2;
        let blocks = i32::from((size >> halvings).max(1));
        let small = |number: i64| i32::try_from(number >> halvings).unwrap_or(0);
        Self { first: small(first - middle), step: small(step), end: (blocks - 1) << PIXEL_BITS }
    }

    /// The index of the block at a sample, and the weight of the next block in units of 1/256.
    #[inline(always)] // a few instructions, once for each column
    fn block_at(&self, number: u16) -> (u16, u8) {
        // Nothing overflows (see `Axis`). Does not use `clamp`, because the compiler would link the code of its panic.
        let position = self.first.wrapping_add(i32::from(number).wrapping_mul(self.step)).min(self.end).max(0);
        let position = position.unsigned_abs();
        let [fraction, ..] = (position >> (PIXEL_BITS - 8)).to_le_bytes();
        (low(position >> PIXEL_BITS), fraction)
    }

    /// The indices of the block at a sample and of the next block, and the weight of the latter in units of 1/256.
    #[inline(never)]
    fn at(&self, number: u16) -> (u16, u16, u8) {
        let (block, fraction) = self.block_at(number);
        (block, block.saturating_add(1).min(low(self.end.unsigned_abs() >> PIXEL_BITS)), fraction)
    }
}

impl Lattice {
    /// The search window: the filter's cells, `reach` cells on each side, and a border of one pixel for the gradients.
    #[inline(never)]
    pub(crate) fn search_window(place: &Place, grid: &Grid, reach: u16) -> Self {
        let side = |cells: u16| (cells + 2 * reach) * CELL + 2;
        Self::around(place, grid, side(grid.across), side(grid.down))
    }

    /// The view for verification: the template's pixels, and `MARGIN` pixels on each side.
    pub(crate) fn view(place: &Place, grid: &Grid) -> Self {
        Self::around(place, grid, grid.columns + 2 * MARGIN, grid.rows + 2 * MARGIN)
    }

    #[inline(never)]
    fn around(&Place { x, y, scale }: &Place, grid: &Grid, columns: u16, rows: u16) -> Self {
        let step = grid.step_at(scale);
        Self { x, y, step, step_down: step, columns, rows }
    }

    /// The least number of halvings of the frame with which the mean of `step` and `step_down` is less than twice the
    /// side length of a block.
    #[inline(never)]
    fn halvings(&self) -> u32 {
        // The least number h of halvings with which `sum` is below 2^(h + BITS).
        const BITS: u32 = PIXEL_BITS + 2;
        let sum = self.step + self.step_down;
        sum.checked_ilog2().map_or(0, |log| (log + 1).saturating_sub(BITS))
    }

    #[inline(never)]
    fn axes(&self, bounds: Rect) -> (Axis, Axis) {
        let halvings = self.halvings();
        let x = Axis::new(self.x, self.step, self.columns, halvings, bounds.width);
        (x, Axis::new(self.y, self.step_down, self.rows, halvings, bounds.height))
    }

    #[inline(never)]
    pub(crate) fn pixels(&self, bounds: Rect) -> Rect {
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

    /// Begins to sample: computes the block and the interpolation weight of each column.
    #[inline(never)]
    pub(crate) fn prepare(&self, bounds: Rect, sampling: &mut Sampling) {
        let (across, down) = self.axes(bounds);
        sampling.pixels = self.pixels(bounds);
        (sampling.down, sampling.halvings) = (down, self.halvings());
        let (left, _) = across.block_at(0);
        sampling.columns.clear();
        // Cannot fail: the capacity is `COLUMNS`, the most columns of a lattice.
        for column in 0..self.columns {
            let (block, fraction) = across.block_at(column);
            sampling.columns.push(block.wrapping_sub(left), fraction);
        }
        (sampling.rows_in_means, sampling.read, sampling.sampled) = ([None; 2], 0, 0);
        (sampling.next, sampling.rows) = (0, self.rows);
    }

    /// Begins to sample into `out`. False if its capacity is too small.
    pub(crate) fn begin(&self, bounds: Rect, sampling: &mut Sampling, out: &mut VecView<u8>) -> bool {
        out.clear();
        self.prepare(bounds, sampling);
        out.resize_default(usize::from(self.columns) * usize::from(self.rows)).is_ok()
    }

    #[cfg(test)]
    pub(crate) fn sample(&self, frame: &Frame<'_>, sampling: &mut Sampling, out: &mut VecView<u8>) -> bool {
        let possible = self.begin(frame.bounds(), sampling, out) && frame.covers(self.pixels(frame.bounds()));
        while possible && !sampling.next_row(frame, out) {}
        possible
    }
}

const _: () = assert!(ROW < Interpolation::<COLUMNS>::LEFT_SAMPLES);

/// The state of sampling: the lattice on the frame reduced by `halvings`, and two rows of the reduced frame.
pub(crate) struct Sampling {
    columns: Interpolation<COLUMNS>,
    down: Axis,
    halvings: u32,
    pixels: Rect,
    /// The block means of one even and one odd row of blocks; unused if the frame is not halved.
    means: [Vec<u8, ROW>; 2],
    /// Indices of the two rows of blocks whose means are in `means`.
    rows_in_means: [Option<u16>; 2],
    /// Index of the next row of the lattice, and the number of rows.
    next: u16,
    rows: u16,
    /// Counts since the last `take_work`: pixels read from the frame, and samples computed.
    read: u32,
    sampled: u32,
    /// Scratch memory: first the sums of blocks for a row of `means`, then the interpolation between two rows.
    mixed: MixedRow,
}

impl Sampling {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self {
            columns: Interpolation::new(),
            down: Axis { first: 0, step: 0, end: 0 },
            halvings: 0,
            pixels: Rect::new(0, 0, 0, 0),
            means: [const { Vec::new() }; 2],
            rows_in_means: [None; 2],
            next: 0,
            rows: 0,
            read: 0,
            sampled: 0,
            mixed: [0; Interpolation::<COLUMNS>::LEFT_SAMPLES + 4],
        }
    }

    /// A sampler of `frame`, after [`Lattice::prepare`]. `None` if a needed pixel is not in memory.
    #[inline(never)]
    pub(super) fn sampler<'a>(&'a mut self, frame: &Frame<'a>) -> Option<Sampler<'a>> {
        Some(Sampler { pixels: frame.patch(self.pixels)?, sampling: self })
    }

    pub(crate) fn next(&self) -> u16 {
        self.next
    }

    /// Samples the next row into its place in `out`, if all needed pixels are in memory. Returns true at the last row.
    #[inline(never)]
    pub(crate) fn next_row(&mut self, frame: &Frame<'_>, out: &mut [u8]) -> bool {
        let columns = self.columns.count();
        let from = usize::from(self.next()) * columns;
        self.next_row_alone(frame, out.get_mut(from..from + columns).unwrap_or_default())
    }

    /// Samples the next row as [`Sampling::next_row`] does, but to the beginning of `out`.
    pub(crate) fn next_row_alone(&mut self, frame: &Frame<'_>, out: &mut [u8]) -> bool {
        let row = self.next;
        if let Some(mut sampler) = self.sampler(frame) {
            sampler.row(row, out);
        }
        self.next += 1;
        self.next >= self.rows
    }

    /// Returns and resets the work since the last call: 1 for each pixel read, and `each` for each sample.
    pub(crate) fn take_work(&mut self, each: u32) -> u32 {
        core::mem::take(&mut self.read) + each * core::mem::take(&mut self.sampled)
    }
}

pub(super) struct Sampler<'a> {
    pixels: Image<'a>,
    sampling: &'a mut Sampling,
}

impl Sampler<'_> {
    /// Samples row `number` of the lattice. Callers go from the top to the bottom, so that each row of block means is
    /// computed only once, although only two rows of means are kept.
    #[inline(never)]
    pub(crate) fn row(&mut self, number: u16, out: &mut [u8]) {
        let (upper, lower, fraction) = self.sampling.down.at(number);
        // From here on, block indices count from the first block that is read, not from the frame's edge.
        let (top, _) = self.sampling.down.block_at(0);
        let (upper, lower) = (upper.wrapping_sub(top), lower.wrapping_sub(top));
        self.make(upper);
        self.make(lower);
        let Self { pixels, sampling: Sampling { columns, means, mixed, halvings, sampled, .. } } = self;
        mix(row(*pixels, means, *halvings, upper), row(*pixels, means, *halvings, lower), fraction, mixed);
        // A sample at the last block has no next block, but the next block's weight is 0 there.
        columns.mix(mixed, out);
        *sampled += u32::try_from(columns.count()).unwrap_or(0);
    }

    /// Computes the means of block row `block`, unless `means` contains them.
    #[inline(never)]
    fn make(&mut self, block: u16) {
        let Self { pixels, sampling: Sampling { means: [even, odd], rows_in_means, read, mixed, halvings, .. } } = self;
        let [even_row, odd_row] = rows_in_means;
        let (row_in_means, means) = if block.is_multiple_of(2) { (even_row, even) } else { (odd_row, odd) };
        if *row_in_means == Some(block) {
            return;
        }
        *row_in_means = Some(block);
        // Reads at most 4 * ROW pixels for a row of blocks, and at most two rows of blocks for each row of the lattice.
        *read += if *halvings == 0 {
            pixels.width().into()
        } else {
            make_means(*pixels, block << *halvings, *halvings, mixed, means)
        };
    }
}

/// Interpolates two rows: sum - `BIAS`, where sum = upper * (256 - fraction) + lower * fraction <= 255 * 256.
#[cfg(not(any(smr_helium, smr_swar)))]
fn mix(upper: &[u8], lower: &[u8], fraction: u8, mixed: &mut MixedRow) {
    // Computes two 16-bit values at a time. Inverting the highest bit subtracts a `BIAS` of 2^15.
    const EVEN: u32 = 0x00FF_00FF;
    const BOTH: u32 = (BIAS as u32) << 16 | BIAS as u32;
    let fraction = u32::from(fraction);
    let rest = 256 - fraction;
    let [(uppers, _), (lowers, _)] = [upper, lower].map(<[u8]>::as_chunks::<4>);
    for ((mixed, &upper), &lower) in rolled(mixed.as_chunks_mut::<4>().0.iter_mut().zip(uppers).zip(lowers)) {
        let (upper, lower) = (u32::from_le_bytes(upper), u32::from_le_bytes(lower));
        let even = ((upper & EVEN) * rest + (lower & EVEN) * fraction) ^ BOTH;
        let odd = ((upper >> 8 & EVEN) * rest + (lower >> 8 & EVEN) * fraction) ^ BOTH;
        *mixed = [low(even), low(odd), low(even >> 16), low(odd >> 16)];
    }
    for at in rolled(4 * uppers.len()..upper.len()) {
        let (Some(mixed), Some(&upper), Some(&lower)) = (mixed.get_mut(at), upper.get(at), lower.get(at)) else {
            return;
        };
        *mixed = low(u32::from(upper) * rest + u32::from(lower) * fraction) ^ BIAS;
    }
}

/// Interpolates two rows in a plain loop. For Helium the compiler vectorizes it by eight. For `smr_swar`, where access
/// to words is slow, it is the fastest.
#[cfg(any(smr_helium, smr_swar))]
#[inline(never)] // inlined, it would not be vectorized
fn mix(upper: &[u8], lower: &[u8], fraction: u8, mixed: &mut MixedRow) {
    let fraction = u16::from(fraction);
    for ((mixed, &upper), &lower) in mixed.iter_mut().zip(upper).zip(lower) {
        *mixed = (u16::from(upper) * (256 - fraction)).wrapping_add(u16::from(lower) * fraction) ^ BIAS;
    }
}

#[allow(clippy::cast_possible_truncation)] // keeps the lower 16 bits
fn low(number: u32) -> u16 {
    number as u16
}

/// The two indices at which a block's columns and rows are read: 0 and 1 in blocks of 2x2 pixels, a quarter and three
/// quarters of the side in larger blocks.
fn pair(halvings: u32) -> [u16; 2] {
    let side = 1_u16 << halvings;
    [side >> 2, (side >> 2) + (side >> 1)]
}

/// Computes the block means from pixel row `first` on. Returns the count of pixels read. `sums` is scratch memory.
#[inline(never)]
fn make_means(pixels: Image<'_>, first: u16, halvings: u32, sums: &mut [u16], means: &mut Vec<u8, ROW>) -> u32 {
    let blocks = pixels.width().div_ceil(1 << halvings);
    // Cannot fail: a lattice with equal steps spans fewer than 2 * `COLUMNS` blocks (at most `COLUMNS` columns, less
    // than two blocks apart), and the refiner's crop fewer than 128 (32 columns, less than four blocks apart).
    let _ = means.resize_default(blocks.into());
    let sums = sums.get_mut(..means.len()).unwrap_or_default();
    sums.fill(0);
    for row in pair(halvings) {
        add_row(sums, row_of(pixels, first, row), halvings);
    }
    for (mean, &mut sum) in rolled(means.iter_mut().zip(sums)) {
        // The mean of four pixels: the sum is at most 255 * 4.
        *mean = u8::try_from((sum + 2) >> 2).unwrap_or(u8::MAX);
    }
    4 * u32::from(blocks)
}

/// A row of block means, or of pixels if the frame is not halved.
#[cfg_attr(smr_dsp, inline(never))]
fn row<'a>(pixels: Image<'a>, [even, odd]: &'a [Vec<u8, ROW>; 2], halvings: u32, block: u16) -> &'a [u8] {
    if halvings == 0 {
        return row_of(pixels, block, 0);
    }
    if block.is_multiple_of(2) { even } else { odd }
}

/// Row `first` + `row` of `pixels`. Below the last row, repeats it, because the frame's edge may cut a block.
#[cfg_attr(smr_dsp, inline(never))]
pub(crate) fn row_of<'a>(pixels: Image<'a>, first: u16, row: u16) -> &'a [u8] {
    pixels.row(first.saturating_add(row).min(pixels.height() - 1))
}

/// Adds two pixels of each block in a row to the block's sum. Beyond the frame's edge, repeats the last pixel.
fn add_row(sums: &mut [u16], row: &[u8], halvings: u32) {
    let (pairs, _) = row.as_chunks::<2>();
    let whole = if halvings == 1 { pairs } else { &[] };
    for (sum, &[left, right]) in rolled(sums.iter_mut().zip(whole)) {
        *sum += u16::from(left) + u16::from(right);
    }
    let [left, right] = pair(halvings).map(usize::from);
    let at = |column: usize| u16::from(row.get(column).or(row.last()).copied().unwrap_or(0));
    for (block, sum) in rolled(sums.iter_mut().enumerate().skip(whole.len())) {
        let first = block << halvings;
        *sum += at(first + left) + at(first + right);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(width: u16, height: u16) -> std::vec::Vec<u8> {
        let pixels = u32::from(width) * u32::from(height);
        (0..pixels).map(|at| (at.wrapping_mul(2_654_435_761) ^ at >> 7).to_be_bytes()[1]).collect()
    }

    /// The samples and the number of pixels read, computed independently in plain 64-bit arithmetic.
    fn plainly(lattice: &Lattice, pixels: &[u8], width: u16, height: u16) -> (std::vec::Vec<u8>, usize) {
        let side = (0..).map(|places| 1_i64 << places).find(|side| lattice.step < 2 * PIXEL * side).unwrap();
        let read = match side {
            1 => std::vec![0],
            2 => std::vec![0, 1],
            _ => std::vec![side / 4, side * 3 / 4],
        };
        let places = |centre: i64, count: u16, size: u16| -> std::vec::Vec<(i64, i64, i64)> {
            let first = centre - (i64::from(count) - 1) * lattice.step / 2;
            let middle = read.iter().sum::<i64>() * PIXEL / i64::try_from(read.len()).unwrap();
            let last = (i64::from(size) / side).max(1) - 1;
            let place = |number: i64| {
                let at = (first - middle).div_euclid(side) + number * lattice.step.div_euclid(side);
                let at = at.clamp(0, last * PIXEL);
                (at / PIXEL, (at / PIXEL + 1).min(last), at % PIXEL / 16)
            };
            (0..count.into()).map(place).collect()
        };
        let pixel = |x: i64, y: i64| {
            let (x, y) = (x.min(i64::from(width) - 1), y.min(i64::from(height) - 1));
            i64::from(pixels[usize::try_from(y * i64::from(width) + x).unwrap()])
        };
        let mean = |column: i64, row: i64| {
            let all = read.iter().flat_map(|y| read.iter().map(move |x| (side * column + x, side * row + y)));
            let (sum, count) = all.fold((0, 0), |(sum, count), (x, y)| (sum + pixel(x, y), count + 1));
            (sum + count / 2) / count
        };
        let (across, down) = (places(lattice.x, lattice.columns, width), places(lattice.y, lattice.rows, height));
        let mixed = |&(upper, lower, below): &(i64, i64, i64), &(left, right, after): &(i64, i64, i64)| {
            let mix = |column| mean(column, upper) * (256 - below) + mean(column, lower) * below;
            u8::try_from((mix(left) * (256 - after) + mix(right) * after + (1 << 15)) >> 16).unwrap()
        };
        let sampled = down.iter().flat_map(|row| across.iter().map(move |column| mixed(row, column))).collect();
        let rows: std::collections::BTreeSet<i64> = down.iter().flat_map(|&(upper, lower, _)| [upper, lower]).collect();
        let columns = usize::try_from(across.last().unwrap().1 - across[0].0 + 1).unwrap();
        (sampled, columns * rows.len() * read.len() * read.len())
    }

    fn samples_as_plainly(
        pixels: &[u8],
        (width, height): (u16, u16),
        (x, y): (i64, i64),
        step: i64,
        columns: u16,
        rows: u16,
    ) {
        let lattice = Lattice { x, y, step, step_down: step, columns, rows };
        let frame = Frame::whole(Image::new(pixels, width, height).unwrap());
        let (mut sampling, mut sampled) = (Sampling::new(), Vec::<u8, 40_000>::new());
        assert!(lattice.sample(&frame, &mut sampling, &mut sampled));
        let read = usize::try_from(sampling.take_work(0)).unwrap();
        let (wanted, of) = plainly(&lattice, pixels, width, height);
        assert!(sampled[..] == wanted[..], "{lattice:?} on {width}x{height}");
        assert_eq!(read, of, "{lattice:?} on {width}x{height}");
    }

    #[test]
    fn blocks_of_all_sides_are_mixed_as_by_plain_arithmetic() {
        let small = [PIXEL / 2, PIXEL + 1, 2 * PIXEL - 1, 2 * PIXEL, 3 * PIXEL + 7, 4 * PIXEL - 1];
        let large = (2..8).map(|places| PIXEL << places).flat_map(|step| [step, 3 * step / 2 + 5, 2 * step - 1]);
        for (width, height) in [(83, 50), (64, 64), (16, 200), (7, 3), (1, 1)] {
            let pixels = noise(width, height);
            let end = |size: u16| i64::from(size - 1) * PIXEL;
            let middle = (i64::from(width) * PIXEL / 2, i64::from(height) * PIXEL / 3);
            for step in small.into_iter().chain(large.clone()) {
                for (x, y) in [(0, 0), middle, (12_345, 543_210)] {
                    samples_as_plainly(&pixels, (width, height), (x.min(end(width)), y.min(end(height))), step, 14, 9);
                }
            }
        }
    }

    #[test]
    fn blocks_of_1024x1024_pixels() {
        let pixels = noise(5000, 3100);
        for step in [1024 * PIXEL, 1777 * PIXEL + 99, 2048 * PIXEL - 1] {
            samples_as_plainly(&pixels, (5000, 3100), (2400 * PIXEL, 1500 * PIXEL), step, 6, 5);
        }
    }

    /// Tries the longest rows and columns of a lattice, with steps of up to 8192 pixels. A box of 65535x65535 pixels,
    /// grown fivefold, has a step just below 8192 pixels.
    #[test]
    fn the_farthest_positions() {
        let (pixels, most) = (noise(65_535, 1), u16::try_from(COLUMNS).unwrap());
        for step in
            [PIXEL / 2, PIXEL, 2 * PIXEL - 1, 3 * PIXEL, 511 * PIXEL, 1024 * PIXEL, 8192 * PIXEL - 1, 8192 * PIXEL]
        {
            for middle in [0, 32_767 * PIXEL, 65_534 * PIXEL] {
                samples_as_plainly(&pixels, (65_535, 1), (middle, 0), step, most, 6);
                samples_as_plainly(&pixels, (1, 65_535), (0, middle), step, 6, most);
            }
        }
    }

    #[test]
    fn the_largest_sums() {
        let (white, mut sums, mut means) = ([255; 8 * 8], [7; ROW], Vec::new());
        let image = Image::new(&white, 8, 8).unwrap();
        for halvings in 1..16 {
            let read = make_means(image, 0, halvings, &mut sums, &mut means);
            let blocks = 8_usize.div_ceil(1 << halvings);
            assert!(sums[..blocks] == [4 * 255; 4][..blocks] && means[..] == [255; 4][..blocks], "{halvings}");
            assert_eq!(usize::try_from(read).unwrap(), 4 * blocks);
        }
    }
}
