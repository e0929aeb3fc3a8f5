//! Ten features for each cell of 4x4 samples: nine gradient orientations (HOG; Dalal and Triggs, 2005) and gray.
//!
//! ```text
//! x[c, k] = gain * h[c, k] / (norm(c) + floor),   k = 0 to 8: gradients at 20 k or 20 k + 180 degrees
//! x[c, 9] = mean gray of the cell - 128
//! ```
//!
//! `norm` is the root of the mean energy of the 3x3 cells around c, so features hardly depend on brightness and
//! contrast. A gradient g is split between its two neighbouring orientations u and v: g = a u + b v,
//! linearly, so without root, angle or division.
//!
//! | symbol | what | unit | bound |
//! |---|---|---|---|
//! | `h` | sum of gradients over a cell | 1/4 gray level | 16 * 361 * 1.02 * 4 = 23,600 |
//! | energy | sum of squared gradients | gray level^2 | 5,900^2 |
//! | `norm`, `floor` | norm of the gradients | 1/8 gray level | 2^16 |
//! | `x` | feature | 1/127 of 0.4 `norm` | -128 to 127 |
//!
//! `kernels` computes the sums of a cell. Cost on the Cortex-M4, with sampling: about 64 instructions for each sample.

use super::super::constants::{CELL, CHANNELS, MAX_SIDE, REACH};
use super::grid::Extent;
use super::sampling::{COLUMNS, Lattice, Sampling, most_read};
use crate::image::{Frame, Rect};
use crate::kernels::{PACKED, Packed, SIDE, features, gradients, norms, rolled};
use crate::track::update::Budget;
use heapless::VecView;

/// The floor that is added to the norm of the gradients around a cell, in units of 1/8 gray level: 2 gray levels for
/// each pixel of a cell. Without it, noise in flat cells would be amplified to full contrast. A floor near 0 lowers the
/// success rate R by 0.067 +- 0.021, a doubled floor by 0.038 +- 0.018.
const NORM_FLOOR: u32 = 2 * 16 * 8;
/// The gain in feature = gain * gradient / norm, with gradients in 1/4 and norms in 1/8 gray level. A gradient of 0.4
/// times the norm becomes 127, so gain = 2 * 127 / 0.4, where the 2 converts the units.
const NORM_GAIN: u32 = 635;

/// Cells in the longest row of a search window.
pub(super) const ROW: usize = (MAX_SIDE + 2 * REACH) as usize;

/// Units of work for each sample: for sampling it, and 1/16 of the work on its cell's features.
const FEATURED: u32 = 64;
/// Lines of samples that a row of cells needs: `CELL` in the cells, and for the gradients one above and one below them.
const LINES: u32 = CELL as u32 + 2;

pub(crate) const fn most_work(extent: Extent) -> u32 {
    let (columns, rows) = (columns(extent), (extent.down + 2 * extent.reach) * CELL as u32 + 2);
    columns * rows * FEATURED + most_read(columns, rows)
}

pub(crate) const fn most_work_of_a_piece(extent: Extent) -> u32 {
    LINES * columns(extent) * FEATURED + most_read(columns(extent), LINES)
}

const fn columns(extent: Extent) -> u32 {
    (extent.across + 2 * extent.reach) * CELL as u32 + 2
}

/// Sums over each cell's samples, `[channel][cell]`: gradients by orientation, then gray levels (a sum up to 4,080).
pub(super) type Row = [[u16; ROW]];
const _: () = assert!(2 * ROW * CHANNELS <= PACKED);

/// Computes features row by row. It holds only the samples and the cells that the present row needs.
pub(crate) struct Extractor {
    sampling: Sampling,
    lines: [[u8; COLUMNS]; SIDE],
    /// Sums of the last two rows of cells. Once a window's features are complete, the filter borrows this memory.
    sums: Packed,
    /// Gradient energies of the last three rows of cells.
    energies: [[u32; ROW]; 3],
    /// Columns and rows of the window, in cells.
    across: u16,
    down: u16,
    /// Index of the next row of cells.
    next: u16,
}

impl Extractor {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self {
            sampling: Sampling::new(),
            lines: [[0; COLUMNS]; SIDE],
            sums: Packed::new(),
            energies: [[0; ROW]; 3],
            across: 0,
            down: 0,
            next: 0,
        }
    }

    pub(crate) fn lend_sums(&mut self) -> &mut Packed {
        &mut self.sums
    }

    pub(crate) fn sampling(&mut self) -> &mut Sampling {
        &mut self.sampling
    }

    /// Begins the features of a window. False if `out` is too small for them. `lattice` has a border of one sample.
    #[inline(never)]
    pub(crate) fn begin(&mut self, bounds: Rect, lattice: &Lattice, out: &mut VecView<i8>) -> bool {
        self.begin_rows(bounds, lattice);
        let cells = usize::from(lattice.columns / CELL) * usize::from(lattice.rows / CELL);
        // Old features need not be cleared, because every byte is overwritten.
        let fits = out.resize_default(cells * CHANNELS).is_ok();
        if !fits {
            out.clear();
        }
        fits
    }

    #[inline(never)]
    fn begin_rows(&mut self, bounds: Rect, lattice: &Lattice) {
        (self.across, self.down) = (lattice.columns / CELL, lattice.rows / CELL);
        self.next = 0;
        self.energies = [[0; ROW]; 3];
        lattice.prepare(bounds, &mut self.sampling);
    }

    /// Computes the next row of cells. True when done: after the last row, or if a needed pixel is not in memory.
    #[cfg_attr(smr_small, inline(never))]
    pub(crate) fn next_row(&mut self, frame: &Frame<'_>, out: &mut [i8], budget: &mut Budget) -> bool {
        let done = self.row(frame, out);
        budget.spend(self.sampling.take_work(FEATURED));
        done
    }

    #[inline(never)]
    fn row(&mut self, frame: &Frame<'_>, out: &mut [i8]) -> bool {
        let Self { sampling, lines, sums, energies, across, down, next } = self;
        let Some(mut sampler) = sampling.sampler(frame) else { return true };
        let (across, down, row) = (usize::from(*across).min(ROW), *down, *next);
        *next += 1;
        // Computes sums and energies of `row`. Then normalises the row above it, which needs the energies below.
        let (even, odd) = sums.0.as_chunks_mut().0.split_at_mut(CHANNELS);
        let (computed, finished) = if row.is_multiple_of(2) { (even, odd) } else { (odd, even) };
        let [above, at, below] = &mut *energies; // around the row to normalise; `below` is `row`
        for (above, (at, below)) in rolled(above.iter_mut().zip(at.iter_mut().zip(below.iter_mut())).take(across)) {
            (*above, *at, *below) = (*at, *below, 0);
        }
        if row < down {
            let first = if row == 0 { 0 } else { 2 };
            for (number, line) in (CELL * row..).zip(&mut *lines).skip(first) {
                sampler.row(number, line);
            }
            gradients(lines, computed, below, across);
            // Copies the last two lines, which begin the next row of cells. Assigning the arrays would use the stack.
            let [first, second, _, _, fifth, sixth] = &mut *lines;
            for (to, from) in [(first, fifth), (second, sixth)] {
                let columns = (across * usize::from(CELL) + 2).min(COLUMNS);
                if let (Some(to), Some(from)) = (to.get_mut(..columns), from.get(..columns)) {
                    to.copy_from_slice(from);
                }
            }
        }
        let of_row = across * CHANNELS;
        // Does not use `chunks`, because the compiler would link the code of its panic.
        let from = row.checked_sub(1).map(|row| usize::from(row) * of_row);
        if let Some(out) = from.and_then(|from| out.get_mut(from..from + of_row)) {
            normalise(finished, energies, 1 + u32::from(row > 1) + u32::from(row < down), out);
        }
        row >= down
    }

    #[cfg(feature = "unstable")]
    /// Computes all features at once. False if a needed pixel is not in memory, or if `out` is too small.
    pub(crate) fn features(&mut self, frame: &Frame<'_>, lattice: &Lattice, out: &mut VecView<i8>) -> bool {
        if !self.begin(frame.bounds(), lattice, out) || !frame.covers(lattice.pixels(frame.bounds())) {
            out.clear();
            return false;
        }
        while !self.row(frame, out) {}
        true
    }
}

/// Normalises a row of cells by the energies of three rows. `rows` is the count of these rows that lie in the window;
/// the energies of rows outside are 0. Overwrites the energies `above` as scratch memory.
#[inline(never)]
fn normalise(sums: &Row, [above, at, below]: &mut [[u32; ROW]; 3], rows: u32, out: &mut [i8]) {
    let (out, _) = out.as_chunks_mut::<CHANNELS>();
    let Some(inverses) = above.get_mut(..out.len()) else { return };
    rolled(inverses.iter_mut().zip(at.iter().zip(below))).for_each(|(sum, (at, below))| *sum += *at + *below);
    // Factors of the sums, in units of 2^-16. A saturating sum is no zero for any compiler, so no division can panic.
    norms(inverses, rows, |norm| (NORM_GAIN << 16) / norm.saturating_add(NORM_FLOOR));
    features(sums, above, out);
}
