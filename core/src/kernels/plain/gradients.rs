//! Plain loops for cells of gradient orientations (HOG, Dalal and Triggs).
//!
//! A cell has 4x4 pixels. The gradient of a pixel is (x, y) = (right - left, below - above). It votes for the nearest
//! two of nine directions, 20 degrees apart; opposite directions are the same. The votes are the components of the
//! gradient along the two directions: g = a u + b v. That is linear, so it needs no root, no angle and no division.

use super::super::layout::{CELL, CHANNELS, SIDE};
use super::super::unrolling::rolled;

const BINS: usize = 9;

/// (cos, sin) of the directions 0, 20, ... 100 degrees, times 256 / sin(20 degrees). The directions 120, 140 and 160
/// degrees are 60, 40 and 20 degrees mirrored at the y axis.
pub(crate) const DIRECTIONS: [(i32, i32); 6] = [(748, 0), (703, 256), (573, 481), (374, 648), (130, 737), (-130, 737)];

/// Channel sums of a cell: votes for nine directions in units of 1/4 gray level, and the sum of gray levels.
pub(crate) struct Sums(pub(crate) [u16; CHANNELS]);

impl Sums {
    /// The sum of the squares of the nine votes, with each vote rounded down to whole gray levels: at most 5,900^2.
    pub(crate) fn energy(&self) -> u32 {
        self.0.iter().take(BINS).map(|&sum| u32::from(sum >> 2).pow(2)).sum()
    }
}

/// Sums of a cell's gradients (x, y) by sector: `[0]` has the five sectors of 20 degrees each from 0 to 100 degrees,
/// `[1]` their mirror images at the y axis. A number holds the sum of |x| in its high 16 bits and the sum of |y| in its
/// low 16 bits, each at most 4,080.
pub(crate) struct Sectors(pub(crate) [[u32; 5]; 2]);

impl Sectors {
    #[inline(always)]
    fn add(&mut self, [left, right]: [u8; 2], [above, below]: [u8; 2]) {
        let (x, y) = (i32::from(right) - i32::from(left), i32::from(below) - i32::from(above));
        // Opposite gradients are equivalent. If x * y < 0, the direction is between 90 and 180 degrees: the gradient
        // then counts in the mirrored sector of (|x|, |y|).
        let [whole, mirrored] = &mut self.0;
        let sectors = if x * y < 0 { mirrored } else { whole };
        let (right, up) = (x.abs(), y.abs());
        // The angle of (|x|, |y|) is 0 to 90 degrees, so its sector needs no comparison with 0 and 100 degrees.
        let beyond = |(cos, sin): (i32, i32)| cos * up >= sin * right;
        let [_, one, two, three, four, _] = DIRECTIONS;
        let number = if !beyond(two) {
            usize::from(beyond(one))
        } else if !beyond(three) {
            2
        } else {
            3 + usize::from(beyond(four))
        };
        if let Some(sector) = sectors.get_mut(number) {
            *sector += up.cast_unsigned() | right.cast_unsigned() << 16;
        }
    }

    #[inline(always)]
    pub(crate) fn sums(&self, gray: u16) -> Sums {
        // A gradient between two directions votes for the upper one with its distance beyond the lower one, and for the
        // lower one with its distance short of the upper one. Names with a or b are distances beyond, with c or d
        // negated distances short. a and c come from the sectors `[0]`, b and d from the mirrored ones. The digit is
        // the direction voted for, in steps of 20 degrees.
        let beyond = |number: usize, direction| {
            self.0.map(|sectors| distance(sectors.get(number).copied().unwrap_or(0), direction))
        };
        let [zero, one, two, three, four, five] = DIRECTIONS;
        let ([a1, b8], [a2, b7], [a3, b6], [a4, b5], [a5, b4]) =
            (beyond(0, zero), beyond(1, one), beyond(2, two), beyond(3, three), beyond(4, four));
        let ([c0, d0], [c1, d8], [c2, d7], [c3, d6], [c4, d5]) =
            (beyond(0, one), beyond(1, two), beyond(2, three), beyond(3, four), beyond(4, five));
        // Sums are in units of 1/4 gray level, below 2^16.
        let quarters = |sum: i32| low(sum.cast_unsigned() >> 6);
        Sums([
            quarters(-c0 - d0),
            quarters(a1 - c1),
            quarters(a2 - c2),
            quarters(a3 - c3),
            quarters(a4 + b4 - c4),
            quarters(a5 + b5 - d5),
            quarters(b6 - d6),
            quarters(b7 - d7),
            quarters(b8 - d8),
            gray,
        ])
    }
}

/// The distance of a sum (|x|, |y|) of `Sectors` beyond a direction (cos, sin): cos * |y| - sin * |x|.
fn distance(sum: u32, (cos, sin): (i32, i32)) -> i32 {
    cos * (sum & 0xFFFF).cast_signed() - sin * (sum >> 16).cast_signed()
}

/// The channel sums (votes and gray levels) of the cell whose pixels begin in column `at + 1`.
#[inline(always)]
pub(crate) fn cell<const COLUMNS: usize>(lines: &[[u8; COLUMNS]; SIDE], at: usize) -> Sums {
    sectors(lines, at).sums(gray(lines, at))
}

/// Computes the channel sums and the energy of each cell of a row.
#[inline(never)]
pub(crate) fn gradients<const COLUMNS: usize, const ROW: usize>(
    lines: &[[u8; COLUMNS]; SIDE],
    sums: &mut [[u16; ROW]],
    energies: &mut [u32; ROW],
    across: usize,
) {
    by_cells(lines, sums, energies, across, cell);
}

/// [`gradients`] with a given function for the channel sums of one cell.
#[inline(always)]
pub(crate) fn by_cells<const COLUMNS: usize, const ROW: usize>(
    lines: &[[u8; COLUMNS]; SIDE],
    sums: &mut [[u16; ROW]],
    energies: &mut [u32; ROW],
    across: usize,
    cell: impl Fn(&[[u8; COLUMNS]; SIDE], usize) -> Sums,
) {
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

#[inline(always)]
pub(crate) fn gray<const COLUMNS: usize>(lines: &[[u8; COLUMNS]; SIDE], at: usize) -> u16 {
    let mut gray = 0;
    for line in lines.iter().skip(1).take(CELL.into()) {
        let pixels = line.get(at + 1..).and_then(|line| line.first_chunk());
        let pixels = u32::from_le_bytes(pixels.copied().unwrap_or_default());
        gray += (pixels & 0x00FF_00FF) + (pixels >> 8 & 0x00FF_00FF);
    }
    low(gray) + low(gray >> 16)
}

fn sectors<const COLUMNS: usize>(lines: &[[u8; COLUMNS]; SIDE], at: usize) -> Sectors {
    let mut sectors = Sectors([[0; 5]; 2]);
    let part = |line: &'_ [u8; COLUMNS]| line.get(at..).and_then(|line| line.first_chunk::<SIDE>()).copied();
    for window in lines.windows(3) {
        let [above, middle, below] = window else { continue };
        let (Some(above), Some(middle), Some(below)) = (part(above), part(middle), part(below)) else { continue };
        let [_, above_a, above_b, above_c, above_d, _] = above;
        let [left, a, b, c, d, right] = middle;
        let [_, below_a, below_b, below_c, below_d, _] = below;
        sectors.add([left, b], [above_a, below_a]);
        sectors.add([a, c], [above_b, below_b]);
        sectors.add([b, d], [above_c, below_c]);
        sectors.add([c, right], [above_d, below_d]);
    }
    sectors
}

#[allow(clippy::cast_possible_truncation)]
fn low(number: u32) -> u16 {
    number as u16
}

/// Computes the features of a row of cells: nine votes times `inverses` / 2^16, at most 127, and mean gray level - 128.
#[inline(always)]
pub(crate) fn features<const ROW: usize>(sums: &[[u16; ROW]], inverses: &[u32; ROW], out: &mut [[i8; CHANNELS]]) {
    for ((number, out), &inverse) in rolled(out.iter_mut().enumerate().zip(inverses)) {
        let [parts @ .., level] = out;
        let mut of_cell = sums.iter().map(|row| row.get(number).copied().unwrap_or(0));
        for (part, sum) in parts.iter_mut().zip(&mut of_cell) {
            // The product is below 23,600 * 162,560 < 2^32.
            let value = (u32::from(sum) * inverse) >> 16;
            *part = i8::try_from(value).unwrap_or(i8::MAX);
        }
        // The mean is 0..=255, so the feature is -128..=127.
        let [gray, _] = (of_cell.next().unwrap_or(0) >> 4).to_le_bytes();
        *level = (gray ^ 128).cast_signed();
    }
}

/// Replaces each sum in `columns` (energy of a cell and of its neighbours above and below) by `of(norm)`. The norm is
/// the root of 64 times the mean energy of the 3x3 cells around the cell. `rows` counts those of the three rows of
/// cells that lie in the window. The number of columns is not 1.
#[inline(always)]
pub(crate) fn norms(columns: &mut [u32], rows: u32, of: impl Fn(u32) -> u32) {
    debug_assert!(columns.len() != 1);
    let (mut left, mut here) = (0, 0);
    for at in rolled(0..columns.len()) {
        // The mean excludes cells beyond the edge.
        let (next, cells) = columns.get(at + 1).map_or((0, here + rows), |&next| (next, here + 2 * rows));
        let Some(column) = columns.get_mut(at) else { return };
        // The sum of nine energies is below 2^29; 64 times their mean is below 2^32.
        let norm = root(64 * mean(left + *column + next, cells));
        (left, here, *column) = (*column, rows, of(norm));
    }
}

/// `energy / cells`, without a division on Armv6-M, which has no such instruction.
fn mean(energy: u32, cells: u32) -> u32 {
    if cfg!(all(smr_swar, target_arch = "arm")) { mean_by_parts(energy, cells) } else { energy / cells.max(1) }
}

/// `energy / cells` for up to nine cells and an energy below 2^30, ten bits at a time.
pub(crate) fn mean_by_parts(energy: u32, cells: u32) -> u32 {
    // Constants 2^16 / cells, rounded up. Each round appends the next ten bits of the energy to the last remainder,
    // multiplies by the constant and shifts right by 16: an exact division.
    const INVERSES: [u32; 10] = [0, 65_536, 32_768, 21_846, 16_384, 13_108, 10_923, 9363, 8192, 7282];
    let inverse = usize::try_from(cells).ok().and_then(|cells| INVERSES.get(cells)).copied().unwrap_or(0);
    let (mut rest, mut mean) = (0, 0);
    for places in [20, 10, 0] {
        let part = rest << 10 | (energy >> places & 1023);
        let digit = (part * inverse) >> 16;
        (rest, mean) = (part - digit * cells, mean << 10 | digit);
    }
    mean
}

/// The square root, rounded down, bit by bit, because Armv6-M has no division.
#[cfg(all(smr_swar, target_arch = "arm"))]
pub(crate) fn root(number: u32) -> u32 {
    let (mut rest, mut root, mut bit) = (number, 0, 1 << 30);
    while bit > 0 {
        let subtracted = root + bit;
        root >>= 1;
        if rest >= subtracted {
            rest -= subtracted;
            root += bit;
        }
        bit >>= 2;
    }
    root
}

/// The square root, rounded down, of a number below 2^32 - 2^17, by Newton: faster than `isqrt` with hardware division.
#[cfg(not(all(smr_swar, target_arch = "arm")))]
#[cfg_attr(all(smr_small, not(smr_helium)), inline(never))]
pub(crate) fn root(number: u32) -> u32 {
    let places = (number | 1).leading_zeros() & !1;
    let scaled = (number | 1) << places;
    // The first guess is within 6 % for numbers from 2^30 on. A Newton step turns a relative error e into about e^2/2,
    // and never gives too small a root.
    let mut root = (scaled >> 17) + (scaled >> 18) + 20_400;
    root = (root + scaled / root) / 2;
    root = (root + scaled / root) / 2;
    root >>= places / 2;
    // Corrects both a root that is too large by 1, and the root of 0, which was computed as that of 1.
    root - u32::from(root * root > number)
}
