//! Features: what the filter sees of the grid, ten bytes for each cell of 4x4 pixels.
//!
//! Nine tell how much of the gradient points each way, by 20 degrees, light to dark and dark to light alike; they are divided
//! by what there is of it in the 3x3 cells around, so that light and contrast hardly matter. The tenth is the mean gray.
//!
//! A gradient is split between the two directions next to it, as a vector is into two others: g = a u + b v. That is linear,
//! so it takes no root, no angle and no division.

use super::REACH;
use super::grid::{COLUMNS, Lattice, MOST_SIDE, Scratch};
use crate::image::{Frame, Rect};
pub use crate::kernels::{CELL, CHANNELS};
use crate::kernels::{ROOM, Room, SIDE, gradients, rolled, scale};
use core::cell::Cell;
use heapless::Vec;

/// Cells in a row, at most.
pub(super) const ROW: usize = (MOST_SIDE + 2 * REACH) as usize;

/// A gradient of 2 gray levels a pixel, all over a cell, in units of 1/8: cells with less are not lifted to full contrast.
const FLOOR: u32 = 2 * 16 * 8;
/// 0.4 of the gradient around is 127, the most that a byte holds: 2 * 127 / 0.4, because sums are in 1/4 and norms in 1/8.
const GAIN: u32 = 635;

/// Sums over the pixels of each cell in a row, channel by channel: gradients by direction in units of 1/4 gray level (at most 16 * 361 *
/// 1.02 * 4 = 23,600), and gray levels (at most 4,080).
pub(super) type Row = [[u16; ROW]];
const _: () = assert!(2 * ROW * CHANNELS <= ROOM);

/// Scratch: lines of the grid and rows of cells, as many as are needed at a time.
pub(super) struct Strip {
    scratch: Scratch,
    lines: [[u8; COLUMNS]; SIDE],
    /// The sums of the row of cells that was seen last, and of the one before; those who multiply cells have the room meanwhile.
    room: Room,
    /// Of these, and of the one before those.
    energies: [[u32; ROW]; 3],
    /// The row of cells that comes next.
    next: u16,
}

impl Strip {
    #[inline(always)] // made where it stays
    pub(super) const fn new() -> Self {
        Self { scratch: Scratch::new(), lines: [[0; COLUMNS]; SIDE], room: [0; ROOM], energies: [[0; ROW]; 3], next: 0 }
    }

    /// Room for those who multiply cells.
    pub(super) fn room(&mut self) -> &mut Room {
        &mut self.room
    }

    /// What it takes to sample.
    pub(super) fn scratch(&mut self) -> &mut Scratch {
        &mut self.scratch
    }

    /// Begins the features of `lattice`, cell by cell, row by row. Its columns and rows are whole cells and one pixel more on each
    /// side. False, and no cells, if there is no room for them.
    pub(super) fn begin<const N: usize>(&mut self, bounds: Rect, lattice: &Lattice, out: &mut Vec<i8, N>) -> bool {
        self.next = 0;
        self.energies = [[0; ROW]; 3];
        lattice.prepare(bounds, &mut self.scratch);
        let cells = usize::from(lattice.columns / CELL) * usize::from(lattice.rows / CELL);
        // What is there already need not be cleared: every byte is written.
        let fits = out.resize_default(cells * CHANNELS).is_ok();
        if !fits {
            out.clear();
        }
        fits
    }

    /// Goes on with a row of cells; true when all are known. Also if pixels that are read are not in memory.
    #[inline(never)] // one copy in flash
    pub(super) fn row(&mut self, frame: &Frame<'_>, lattice: &Lattice, out: &mut [i8]) -> bool {
        let Self { scratch, lines, room, energies, next } = self;
        let Some(mut sampler) = scratch.sampler(frame) else { return true };
        let (across, down) = (usize::from(lattice.columns / CELL).min(ROW), lattice.rows / CELL);
        let row = *next;
        *next += 1;
        let (even, odd) = room.as_chunks_mut().0.split_at_mut(CHANNELS);
        let (last, before) = if row.is_multiple_of(2) { (even, odd) } else { (odd, even) };
        let [above, at, below] = &mut *energies;
        // Only as many as there are cells.
        for (above, (at, below)) in rolled(above.iter_mut().zip(at.iter_mut().zip(below.iter_mut())).take(across)) {
            (*above, *at, *below) = (*at, *below, 0);
        }
        if row < down {
            let first = if row == 0 { 0 } else { 2 };
            for (number, line) in (CELL * row..).zip(&mut *lines).skip(first) {
                sampler.row(number, line);
            }
            gradients(lines, last, below, across);
            let [first, second, _, _, fifth, sixth] = &mut *lines;
            // Not by assignment, which goes by way of the stack.
            for (to, from) in [(first, fifth), (second, sixth)] {
                let columns = usize::from(lattice.columns).min(COLUMNS);
                if let (Some(to), Some(from)) = (to.get_mut(..columns), from.get(..columns)) {
                    to.copy_from_slice(from);
                }
            }
        }
        // A row of cells takes the one below it, too.
        let of_row = across * CHANNELS;
        // By its place: chunks of so many could be a panic where they are folded.
        let finished = row.checked_sub(1).map(|row| usize::from(row) * of_row);
        if let Some(out) = finished.and_then(|from| out.get_mut(from..from + of_row)) {
            normalise(before, energies, 1 + u32::from(row > 1) + u32::from(row < down), out);
        }
        row >= down
    }

    /// All features at once. False if pixels that are read are not in memory or there is no room.
    pub(super) fn features<const N: usize>(
        &mut self,
        frame: &Frame<'_>,
        lattice: &Lattice,
        out: &mut Vec<i8, N>,
    ) -> bool {
        if !self.begin(frame.bounds(), lattice, out) || !frame.covers(lattice.pixels(frame.bounds())) {
            out.clear();
            return false;
        }
        while !self.row(frame, lattice, out) {}
        true
    }
}

/// A row of cells as bytes, by their energies and those in the rows above and below, of which so many are in the lattice; the others
/// are 0. What is above is not needed again: its place is used.
#[inline(never)] // one copy in flash
fn normalise(sums: &Row, [above, at, below]: &mut [[u32; ROW]; 3], rows: u32, out: &mut [i8]) {
    let (out, _) = out.as_chunks_mut::<CHANNELS>();
    let Some(inverses) = above.get_mut(..out.len()) else { return };
    rolled(inverses.iter_mut().zip(at.iter().zip(below))).for_each(|(sum, (at, below))| *sum += *at + *below);
    invert(inverses, rows);
    scale(sums, above, out);
}

/// Makes sums of columns of three cells, of which so many are there, what the sums of cells are multiplied by.
fn invert(columns: &mut [u32], rows: u32) {
    let columns = Cell::from_mut(columns).as_slice_of_cells();
    let (mut left, mut here) = (0, 0);
    let mut right = columns.iter().skip(1);
    for column in rolled(columns.iter()) {
        let middle = column.get();
        // Without the cells that are beyond the edge.
        let (next, cells) = right.next().map_or((0, here + rows), |next| (next.get(), here + 2 * rows));
        column.set(inverse(left + middle + next, cells));
        (left, here) = (middle, rows);
    }
}

/// What the sums of a cell are multiplied by where so many cells have this energy together.
#[cfg_attr(smr_dsp, inline(never))] // one copy in flash
fn inverse(energy: u32, cells: u32) -> u32 {
    // Nine energies are below 2^29; 64 times their mean is below 2^32.
    (GAIN << 16) / (root(64 * (energy / cells.max(1))) + FLOOR)
}

/// The square root, rounded down, of a number below 2^32 - 2^17. Two steps of Newton's, which take fewer instructions than `isqrt` where
/// division is one.
pub(super) fn root(number: u32) -> u32 {
    let places = (number | 1).leading_zeros() & !1;
    let scaled = (number | 1) << places;
    // Of a number from 2^30 on, within 6 %; a step squares that and halves it, and is never too small.
    let mut root = (scaled >> 17) + (scaled >> 18) + 20_400;
    root = (root + scaled / root) / 2;
    root = (root + scaled / root) / 2;
    root >>= places / 2;
    // 0 is taken for 1, and what is a little too large may be the next number.
    root - u32::from(root * root > number)
}

#[cfg(test)]
mod tests {
    use super::super::grid::PIXEL;
    use super::*;
    use crate::image::Image;

    /// FNV-1a of all bytes.
    fn hash(bytes: impl Iterator<Item = u8>) -> u64 {
        bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
    }

    fn noise(count: usize, spread: u32) -> std::vec::Vec<u8> {
        let mut state = 7u32;
        let next = || {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            u8::try_from((state >> 16) % spread).unwrap()
        };
        core::iter::repeat_with(next).take(count).collect()
    }

    fn features(pixels: &[u8], step: i64, cells: (u16, u16)) -> std::vec::Vec<i8> {
        let frame = Frame::whole(Image::new(pixels, 120, 90).unwrap());
        let lattice = Lattice {
            x: 57 * PIXEL,
            y: 40 * PIXEL + 1234,
            step,
            columns: cells.0 * CELL + 2,
            rows: cells.1 * CELL + 2,
        };
        let mut out = Vec::<i8, 20_000>::new();
        assert!(Strip::new().features(&frame, &lattice, &mut out));
        assert_eq!(out.len(), usize::from(cells.0) * usize::from(cells.1) * CHANNELS);
        out.to_vec()
    }

    #[test]
    fn a_root_is_rounded_down() {
        for root_of in 0..=46_341 {
            let square: u32 = root_of * root_of;
            for number in [square.saturating_sub(1), square, square + 1, square + root_of] {
                assert_eq!(root(number), number.isqrt(), "{number}");
            }
        }
        for number in (0..(u32::MAX - (1 << 17))).step_by(997) {
            assert_eq!(root(number), number.isqrt(), "{number}");
        }
    }

    #[test]
    fn features_of_noise_stay_what_they_are() {
        let of = |spread, step, cells| {
            hash(features(&noise(120 * 90, spread), step, cells).into_iter().map(i8::cast_unsigned))
        };
        let hashes = [
            of(256, PIXEL, (30, 30)),
            of(256, 5 * PIXEL / 2, (9, 20)),
            of(3, PIXEL / 2, (48, 22)),
            of(30, 17 * PIXEL / 3, (4, 5)),
        ];
        assert_eq!(
            hashes,
            [6880912278910408271, 12147416471690805507, 3213091790189083990, 15582275044360090699],
            "the numbers that the plainest code gave"
        );
    }
}
