//! Gradients of a cell: how much of them points each way, the plain loop and what the DSP extension does of it. Helium takes
//! eight cells at a time: `similarity/arch/arm/cells.rs`.

use super::features::{CELL, CHANNELS, ROW, Row, SIDE};
use super::grid::COLUMNS;
#[cfg(smr_dsp)]
use crate::similarity::{Directions, sectors};

const BINS: usize = 9;

/// cos and sin of 0, 20, ... 100 degrees over sin 20 degrees, in units of 1/256. Those beyond mirror them.
const DIRECTIONS: [(i32, i32); 6] = [(748, 0), (703, 256), (573, 481), (374, 648), (130, 737), (-130, 737)];

/// Those of a cell.
struct Sums([u16; CHANNELS]);

impl Sums {
    /// The gradient that there is, squared, in gray levels: at most 5,900^2.
    fn energy(&self) -> u32 {
        self.0.iter().take(BINS).map(|&sum| u32::from(sum >> 2).pow(2)).sum()
    }
}

/// Such sums in the making, by the sector between two directions up to 100 degrees, and by those that mirror them: what the first one
/// gets, and, 16 bits higher, what the second one does.
struct Votes([[u32; 5]; 2]);

impl Votes {
    /// Adds a pixel, by its four neighbours. `similarity/arch/sectors.rs` does the same.
    #[cfg(any(not(smr_dsp), feature = "verify"))]
    #[inline(always)]
    fn add(&mut self, [left, right]: [u8; 2], [above, below]: [u8; 2]) {
        let (x, y) = (i32::from(right) - i32::from(left), i32::from(below) - i32::from(above));
        // Light to dark and dark to light alike; the directions beyond 90 degrees mirror the others.
        let [whole, mirrored] = &mut self.0;
        let sectors = if x * y < 0 { mirrored } else { whole };
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
        if let Some(sector) = sectors.get_mut(number) {
            *sector += (short.wrapping_neg().cast_unsigned() >> 6) + (over.cast_unsigned() >> 6 << 16);
        }
    }

    fn sums(&self, gray: u16) -> Sums {
        let [[a0, a1, a2, a3, a4], [b0, b1, b2, b3, b4]] = self.0;
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
#[inline(always)] // into its one caller
fn cell(lines: &[[u8; COLUMNS]; SIDE], at: usize) -> Sums {
    let mut gray = 0;
    for line in lines.iter().skip(1).take(CELL.into()) {
        let pixels = line.get(at + 1..).and_then(|line| line.first_chunk());
        let pixels = u32::from_le_bytes(pixels.copied().unwrap_or_default());
        // Two at a time.
        gray += (pixels & 0x00FF_00FF) + (pixels >> 8 & 0x00FF_00FF);
    }
    let gray = low(gray) + low(gray >> 16);
    #[cfg(smr_dsp)]
    {
        static SECTORS: Directions = Directions::new(DIRECTIONS);
        let sums = Votes(sectors(lines, at, &SECTORS)).sums(gray);
        #[cfg(feature = "verify")]
        assert_eq!(sums.0, votes(lines, at).sums(gray).0, "sums of a cell, given and expected");
        sums
    }
    #[cfg(not(smr_dsp))]
    votes(lines, at).sums(gray)
}

/// Of all pixels of a cell.
#[cfg(any(not(smr_dsp), feature = "verify"))]
fn votes(lines: &[[u8; COLUMNS]; SIDE], at: usize) -> Votes {
    let mut votes = Votes([[0; 5]; 2]);
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

/// The sums of a row of cells, and their energies.
#[inline(never)] // one copy in flash
pub(super) fn gradients(lines: &[[u8; COLUMNS]; SIDE], sums: &mut Row, energies: &mut [u32; ROW], across: usize) {
    for (number, energy) in energies.iter_mut().enumerate().take(across) {
        let cell = cell(lines, number * usize::from(CELL));
        *energy = cell.energy();
        for (row, sum) in sums.iter_mut().zip(cell.0) {
            if let Some(of_cell) = row.get_mut(number) {
                *of_cell = sum;
            }
        }
    }
}
