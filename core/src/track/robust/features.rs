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
use crate::similarity::{ROOM, Room};
#[cfg(any(smr_dsp, smr_helium))]
use crate::similarity::{pair, sectors};
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

/// A gradient of 2 gray levels a pixel, all over a cell, in units of 1/8: cells with less are not lifted to full contrast.
const FLOOR: u32 = 2 * 16 * 8;
/// 0.4 of the gradient around is 127, the most that a byte holds: 2 * 127 / 0.4, because sums are in 1/4 and norms in 1/8.
const GAIN: u32 = 635;

/// Sums over the pixels of a cell: gradients by direction in units of 1/4 gray level (at most 16 * 361 * 1.02 * 4 = 23,600), and
/// gray levels (at most 4,080).
struct Sums([u16; CHANNELS]);

/// The same, two in a number.
type Pairs = [u32; CHANNELS / 2];
/// Numbers of a row of cells.
const ROW_PAIRS: usize = ROW * CHANNELS / 2;
const _: () = assert!(2 * ROW_PAIRS <= ROOM);

impl Sums {
    /// The gradient that there is, squared, in gray levels: at most 5,900^2.
    fn energy(&self) -> u32 {
        self.0.iter().take(BINS).map(|&sum| u32::from(sum >> 2).pow(2)).sum()
    }

    fn pairs(&self) -> Pairs {
        let [a, b, c, d, e, f, g, h, i, j] = self.0;
        [(a, b), (c, d), (e, f), (g, h), (i, j)].map(|(low, high)| u32::from(low) | u32::from(high) << 16)
    }

    fn of(&[a, b, c, d, e]: &Pairs) -> Self {
        let high = |pair: u32| low(pair >> 16);
        Self([low(a), high(a), low(b), high(b), low(c), high(c), low(d), high(d), low(e), high(e)])
    }
}

/// A half of [`Votes`]: the sectors up to 100 degrees, or those that mirror them; as many as make a power of two.
const HALF: usize = 8;
const SECTORS: usize = HALF + 6;

/// Such sums in the making, by the sector between two directions: what the first one gets, and, 16 bits higher, what the second
/// one does. No index can be out of bounds.
struct Votes([u32; SECTORS]);

impl Votes {
    /// Adds a pixel, by its four neighbours. `similarity/arch/sectors.rs` does the same.
    #[cfg(not(any(smr_dsp, smr_helium)))]
    #[inline(always)]
    fn add(&mut self, [left, right]: [u8; 2], [above, below]: [u8; 2]) {
        let (x, y) = (i32::from(right) - i32::from(left), i32::from(below) - i32::from(above));
        // Light to dark and dark to light alike; the directions beyond 90 degrees mirror the others.
        let mirrored = if x * y < 0 { HALF } else { 0 };
        let (right, up) = (x.abs(), y.abs());
        // How far it is beyond a direction, at most 361 * 256 / sin 20 degrees: what the next direction gets of it, if it is
        // between the two. It is beyond that at 0 degrees and not beyond that at 100.
        let beyond = |(cos, sin): (i32, i32)| cos * up - sin * right;
        let [zero, one, two, three, four, five] = DIRECTIONS;
        let (number, short, over);
        let two = beyond(two);
        if two < 0 {
            let one = beyond(one);
            (number, short, over) = if one < 0 { (0, one, beyond(zero)) } else { (1, two, one) };
        } else {
            let three = beyond(three);
            if three < 0 {
                (number, short, over) = (2, three, two);
            } else {
                let four = beyond(four);
                (number, short, over) = if four < 0 { (3, four, three) } else { (4, beyond(five), four) };
            }
        }
        // In units of 1/4; no sum of a cell reaches 2^16.
        if let Some(sector) = self.0.get_mut(mirrored + number) {
            *sector += (short.wrapping_neg().cast_unsigned() >> 6) + (over.cast_unsigned() >> 6 << 16);
        }
    }

    fn sums(&self, gray: u16) -> Sums {
        let [a0, a1, a2, a3, a4, _, _, _, b0, b1, b2, b3, b4, ..] = self.0;
        let high = |pair: u32| low(pair >> 16);
        Sums([
            low(a0) + low(b0),
            high(a0) + low(a1),
            high(a1) + low(a2),
            high(a2) + low(a3),
            high(a3) + low(a4) + high(b4),
            high(a4) + high(b3) + low(b4),
            high(b2) + low(b3),
            high(b1) + low(b2),
            high(b0) + low(b1),
            gray,
        ])
    }
}

/// The sums of a cell, of its pixels and their neighbours.
#[inline(never)] // one copy in flash
fn cell(lines: &[[u8; COLUMNS]; SIDE], at: usize) -> Sums {
    let mut gray = 0;
    for line in lines.iter().skip(1).take(CELL.into()) {
        let pixels = line.get(at + 1..).and_then(|line| line.first_chunk());
        let pixels = u32::from_le_bytes(pixels.copied().unwrap_or_default());
        // Two at a time.
        gray += (pixels & 0x00FF_00FF) + (pixels >> 8 & 0x00FF_00FF);
    }
    votes(lines, at).sums(low(gray) + low(gray >> 16))
}

#[cfg(any(smr_dsp, smr_helium))]
fn votes(lines: &[[u8; COLUMNS]; SIDE], at: usize) -> Votes {
    const PAIRS: [u32; DIRECTIONS.len()] = {
        let [zero, one, two, three, four, five] = DIRECTIONS;
        [pair(zero), pair(one), pair(two), pair(three), pair(four), pair(five)]
    };
    Votes(sectors(lines, at, &PAIRS).unwrap_or_default())
}

/// Of all pixels of a cell.
#[cfg(not(any(smr_dsp, smr_helium)))]
fn votes(lines: &[[u8; COLUMNS]; SIDE], at: usize) -> Votes {
    let mut votes = Votes([0; SECTORS]);
    let part = |line: &'_ [u8; COLUMNS]| line.get(at..).and_then(|line| line.first_chunk::<SIDE>()).copied();
    for [above, middle, below] in lines.array_windows() {
        let (Some(above), Some(middle), Some(below)) = (part(above), part(middle), part(below)) else { continue };
        let [_, above_a, above_b, above_c, above_d, _] = above;
        let [left, a, b, c, d, right] = middle;
        let [_, below_a, below_b, below_c, below_d, _] = below;
        votes.add([left, b], [above_a, below_a]);
        votes.add([a, c], [above_b, below_b]);
        votes.add([b, d], [above_c, below_c]);
        votes.add([c, right], [above_d, below_d]);
    }
    votes
}

/// The lower 16 bits.
#[allow(clippy::cast_possible_truncation)] // they are what is asked for
fn low(number: u32) -> u16 {
    number as u16
}

/// Pixels on a side of a cell with its neighbours.
const SIDE: usize = CELL as usize + 2;

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
        out.clear();
        self.next = 0;
        self.energies = [[0; ROW]; 3];
        lattice.prepare(bounds, &mut self.scratch);
        let cells = usize::from(lattice.columns / CELL) * usize::from(lattice.rows / CELL);
        out.resize_default(cells * CHANNELS).is_ok()
    }

    /// Goes on with a row of cells; true when all are known. Also if pixels that are read are not in memory.
    #[inline(never)] // one copy in flash
    pub(super) fn row(&mut self, frame: &Frame<'_>, lattice: &Lattice, out: &mut [i8]) -> bool {
        let Self { scratch, lines, room, energies, next } = self;
        let Some(mut sampler) = lattice.sampler(frame, scratch) else { return true };
        let (across, down) = (usize::from(lattice.columns / CELL).min(ROW), lattice.rows / CELL);
        let row = *next;
        *next += 1;
        let (even, odd) = room.split_at_mut(ROW_PAIRS);
        let (last, before) = if row.is_multiple_of(2) { (even, odd) } else { (odd, even) };
        let [above, at, below] = &mut *energies;
        above.copy_from_slice(at);
        at.copy_from_slice(below);
        below.fill(0);
        if row < down {
            let first = if row == 0 { 0 } else { 2 };
            for (number, line) in (CELL * row..).zip(&mut *lines).skip(first) {
                sampler.row(number, line);
            }
            gradients(lines, last.as_chunks_mut().0, below, across);
            let [first, second, _, _, fifth, sixth] = &mut *lines;
            // Not by assignment, which goes by way of the stack.
            first.copy_from_slice(fifth);
            second.copy_from_slice(sixth);
        }
        // A row of cells takes the one below it, too.
        let of_row = across * CHANNELS;
        // By its place: chunks of so many could be a panic where they are folded.
        let finished = row.checked_sub(1).map(|row| usize::from(row) * of_row);
        if let Some(out) = finished.and_then(|from| out.get_mut(from..from + of_row)) {
            normalise(before.as_chunks().0, energies, 1 + u32::from(row > 1) + u32::from(row < down), out);
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

/// The sums of a row of cells, and their energies.
#[inline(never)] // one copy in flash
fn gradients(lines: &[[u8; COLUMNS]; SIDE], sums: &mut [Pairs], energies: &mut [u32; ROW], across: usize) {
    for (number, (sums, energy)) in sums.iter_mut().zip(energies).enumerate().take(across) {
        let cell = cell(lines, number * usize::from(CELL));
        *energy = cell.energy();
        *sums = cell.pairs();
    }
}

/// A row of cells as bytes, by their energies and those in the rows above and below, of which so many are in the lattice; the others
/// are 0.
#[inline(never)] // one copy in flash
fn normalise(sums: &[Pairs], [above, at, below]: &[[u32; ROW]; 3], rows: u32, out: &mut [i8]) {
    let (out, _) = out.as_chunks_mut::<CHANNELS>();
    let across = out.len();
    let mut columns = above.iter().zip(at).zip(below).take(across).map(|((above, at), below)| above + at + below);
    let (mut left, mut middle) = (None, columns.next());
    for (out, pairs) in out.iter_mut().zip(sums) {
        let [sums @ .., gray] = Sums::of(pairs).0;
        let right = columns.next();
        // Nine energies are below 2^29.
        let energy = left.unwrap_or(0) + middle.unwrap_or(0) + right.unwrap_or(0);
        let cells = rows * (1 + u32::from(left.is_some()) + u32::from(right.is_some()));
        // 64 times the mean energy is below 2^32.
        let norm = (64 * (energy / cells.max(1))).isqrt() + FLOOR;
        let inverse = (GAIN << 16) / norm;
        let [parts @ .., level] = out;
        for (part, sum) in parts.iter_mut().zip(sums) {
            // Below 23,600 * 162,560 < 2^32.
            let value = (u32::from(sum) * inverse) >> 16;
            *part = i8::try_from(value).unwrap_or(i8::MAX);
        }
        // 0..=255, so -128..=127.
        *level = i8::try_from(i32::from(gray >> 4) - 128).unwrap_or(0);
        (left, middle) = (middle, right);
    }
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
