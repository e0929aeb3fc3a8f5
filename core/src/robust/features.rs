//! Features: what the filter sees of the grid, ten bytes for each cell of 4x4 pixels.
//!
//! Nine tell how much of the gradient points each way, by 20 degrees, light to dark and dark to light alike; they are divided
//! by what there is of it in the 3x3 cells around, so that light and contrast hardly matter. The tenth is the mean gray.
//!
//! A gradient is split between the two directions next to it, as a vector is into two others: g = a u + b v. That is linear,
//! so it takes no root, no angle and no division.

use super::REACH;
use super::grid::{COLUMNS, Lattice, MOST_SIDE};
use crate::image::Frame;
use heapless::Vec;

/// Pixels of the grid on a side of a cell.
pub const CELL: u16 = 4;
/// Bytes of a cell.
pub const CHANNELS: usize = 10;
const BINS: usize = 9;
/// Cells in a row, at most.
const ROW: usize = (MOST_SIDE + 2 * REACH) as usize;

/// cos and sin of 0, 20, ... 100 degrees over sin 20 degrees, in units of 1/256. Those beyond mirror them.
const DIRECTIONS: [(i32, i32); 6] = [(748, 0), (703, 256), (573, 481), (374, 648), (130, 737), (-130, 737)];

/// Between two directions that follow each other, and the numbers of their sums.
#[derive(Clone, Copy)]
struct Sector {
    from: (i32, i32),
    to: (i32, i32),
    bins: [u8; 2],
}

/// The number of the last sector: no direction from 20 to 80 degrees lies beyond a gradient there.
const BEYOND_NONE: u32 = 4;

const fn sector(from: (i32, i32), to: (i32, i32), bins: [u8; 2]) -> Sector {
    Sector { from, to, bins }
}

const SECTORS: [Sector; 5] = sectors([0, 1, 2, 3, 4, 5]);
const MIRRORED: [Sector; 5] = sectors([0, 8, 7, 6, 5, 4]);

const fn sectors([b0, b1, b2, b3, b4, b5]: [u8; 6]) -> [Sector; 5] {
    let [d0, d1, d2, d3, d4, d5] = DIRECTIONS;
    [
        sector(d0, d1, [b0, b1]),
        sector(d1, d2, [b1, b2]),
        sector(d2, d3, [b2, b3]),
        sector(d3, d4, [b3, b4]),
        sector(d4, d5, [b4, b5]),
    ]
}

/// A gradient of 2 gray levels a pixel, all over a cell, in units of 1/8: cells with less are not lifted to full contrast.
const FLOOR: u32 = 2 * 16 * 8;
/// 0.4 of the gradient around is 127, the most that a byte holds: 2 * 127 / 0.4, because sums are in 1/4 and norms in 1/8.
const GAIN: u32 = 635;

/// Sums over the pixels of a cell: gradients by direction in units of 1/4 gray level (at most 16 * 361 * 1.02 * 4 = 23,600), and
/// gray levels (at most 4,080).
#[derive(Clone, Copy, Default)]
struct Sums([u16; CHANNELS]);

impl Sums {
    /// Adds a pixel and the gradient there.
    #[inline]
    fn add(&mut self, x: i32, y: i32, pixel: u8) {
        // Light to dark and dark to light alike: upwards, or to the right.
        let (x, y) = if (y, x) < (0, 0) { (-x, -y) } else { (x, y) };
        // The directions beyond 90 degrees mirror the others.
        let (right, mirrored) = (x.abs(), x < 0);
        let beyond = |&(cos, sin): &(i32, i32)| (cos * y - sin * right).cast_unsigned() >> 31;
        let [_, one, two, three, four, _] = &DIRECTIONS;
        let sector = BEYOND_NONE - (beyond(one) + beyond(two) + beyond(three) + beyond(four));
        let sectors = if mirrored { &MIRRORED } else { &SECTORS };
        let Some(&Sector { from, to, bins: [bin, next] }) = sectors.get(sector as usize) else { return };
        let before = |(cos, sin): (i32, i32)| cos * y - sin * right;
        // Both are at most 361 * 256 / sin 20 degrees; in units of 1/4.
        let part = |value: i32| u16::try_from(value.max(0) >> 6).unwrap_or(0);
        if let Some(sum) = self.0.get_mut(usize::from(bin)) {
            *sum += part(-before(to));
        }
        if let Some(sum) = self.0.get_mut(usize::from(next)) {
            *sum += part(before(from));
        }
        let [.., gray] = &mut self.0;
        *gray += u16::from(pixel);
    }

    /// The gradient that there is, squared, in gray levels: at most 5,900^2.
    fn energy(&self) -> u32 {
        self.0.iter().take(BINS).map(|&sum| u32::from(sum >> 2).pow(2)).sum()
    }
}

/// A row of cells.
#[derive(Clone, Default)]
struct CellRow {
    sums: Vec<Sums, ROW>,
    energies: Vec<u32, ROW>,
}

/// Scratch: rows of the grid and rows of cells, as many as are needed at a time.
pub(super) struct Strip {
    pixels: [Vec<u8, COLUMNS>; 3],
    cells: [CellRow; 3],
}

impl Strip {
    pub(super) const fn new() -> Self {
        const CELLS: CellRow = CellRow { sums: Vec::new(), energies: Vec::new() };
        Self { pixels: [const { Vec::new() }; 3], cells: [CELLS; 3] }
    }

    /// The features of `lattice`, cell by cell, row by row. Its columns and rows are whole cells and one pixel more on each side.
    /// False if pixels that are read are not in memory or there is no room.
    #[inline(never)] // one copy in flash
    pub(super) fn features<const N: usize>(
        &mut self,
        frame: &Frame<'_>,
        lattice: &Lattice,
        out: &mut Vec<i8, N>,
    ) -> bool {
        let (across, down) = (usize::from((lattice.columns - 2) / CELL), usize::from((lattice.rows - 2) / CELL));
        out.clear();
        let mut number = 0;
        let sampled = lattice.rows(frame, |row| {
            self.take(number, row, across);
            number += 1;
            // Two rows of the grid more than cells have, and a row of cells more, for those around.
            if number > 2 && (number - 2).is_multiple_of(CELL.into()) {
                let cells = (number - 2) / usize::from(CELL);
                self.close(cells - 1, across);
                if cells > 1 {
                    self.normalise(cells - 2, cells, out);
                }
            }
        });
        if !sampled {
            return false;
        }
        self.normalise(down - 1, down, out);
        out.len() == across * down * CHANNELS
    }

    /// Row `number` of the grid; the gradients of the row above it are known then.
    fn take(&mut self, number: usize, row: &[u8], across: usize) {
        let Self { pixels, cells } = self;
        let [first, second, third] = pixels;
        core::mem::swap(first, second);
        core::mem::swap(second, third);
        third.clear();
        // Cannot fail: a lattice has at most so many columns.
        let _ = third.extend_from_slice(row);
        let Some(line) = number.checked_sub(2) else { return };
        let Some(CellRow { sums, .. }) = cells.get_mut(line / usize::from(CELL) % 3) else { return };
        if line.is_multiple_of(CELL.into()) {
            sums.clear();
            let _ = sums.resize_default(across);
        }
        let middle = second.array_windows::<6>().step_by(CELL.into());
        let above = first.get(1..).unwrap_or_default().array_windows::<4>().step_by(CELL.into());
        let below = third.get(1..).unwrap_or_default().array_windows::<4>().step_by(CELL.into());
        for (((sums, middle), above), below) in sums.iter_mut().zip(middle).zip(above).zip(below) {
            for ((&[left, pixel, right], &above), &below) in middle.array_windows().zip(above).zip(below) {
                sums.add(i32::from(right) - i32::from(left), i32::from(below) - i32::from(above), pixel);
            }
        }
    }

    /// The energies of row `number` of cells.
    fn close(&mut self, number: usize, across: usize) {
        let Some(CellRow { sums, energies }) = self.cells.get_mut(number % 3) else { return };
        let _ = energies.resize_default(across);
        energies.iter_mut().zip(sums).for_each(|(energy, sums)| *energy = sums.energy());
    }

    /// Row `number` of cells, of which there are `known`, as bytes.
    fn normalise<const N: usize>(&self, number: usize, known: usize, out: &mut Vec<i8, N>) {
        let Some(CellRow { sums, .. }) = self.cells.get(number % 3) else { return };
        let rows = number.saturating_sub(1)..(number + 2).min(known);
        for (column, sums) in sums.iter().enumerate() {
            let (mut energy, mut cells) = (0, 0);
            for row in rows.clone() {
                let Some(CellRow { energies, .. }) = self.cells.get(row % 3) else { continue };
                let around = energies.get(column.saturating_sub(1)..(column + 2).min(energies.len()));
                // Nine energies are below 2^29.
                for &more in around.unwrap_or_default() {
                    (energy, cells) = (energy + more, cells + 1);
                }
            }
            // 64 times the mean energy is below 2^32.
            let norm = (64 * (energy / cells.max(1))).isqrt() + FLOOR;
            let inverse = (GAIN << 16) / norm;
            for &sum in sums.0.iter().take(BINS) {
                // Below 23,600 * 162,560 < 2^32.
                let part = (u32::from(sum) * inverse) >> 16;
                let _ = out.push(i8::try_from(part).unwrap_or(i8::MAX));
            }
            let [.., gray] = sums.0;
            // 0..=255, so -128..=127.
            let _ = out.push(i8::try_from(i32::from(gray >> 4) - 128).unwrap_or(0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;
    use crate::robust::grid::PIXEL;

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
        let lattice =
            Lattice { x: 57 * PIXEL, y: 40 * PIXEL + 1234, step, columns: cells.0 * CELL + 2, rows: cells.1 * CELL + 2 };
        let mut out = Vec::<i8, 20_000>::new();
        assert!(Strip::new().features(&frame, &lattice, &mut out));
        assert_eq!(out.len(), usize::from(cells.0) * usize::from(cells.1) * CHANNELS);
        out.to_vec()
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
            [6880912278910408271, 12147416471690805507, 3213091790189083990, 17259954616752554114],
            "the numbers that the plainest code gave"
        );
    }
}
