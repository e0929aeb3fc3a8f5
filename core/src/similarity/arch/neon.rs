//! Scores by NEON, which every AArch64 with floating point has: 16 pixels at a time, for any threshold.
//!
//! 1. `tbl` looks up 64 entries of a byte plane and gives zero for a larger index; entries at the threshold and beyond are
//!    stored as zero. So the lookup is the test d < threshold, too. Larger thresholds take up to four of them.
//! 2. Bytes are added in pairs, and these to four-byte lanes; a plane's sum over 65537 pixels is below 2^25.
//! 3. Of a patch that lies between two pictures the pixels that count are counted, each taken to be fully similar: a bound,
//!    without a lookup.
//! 4. The end of a row that fills no register is loaded together with pixels before it, which are then masked away.

use super::super::{CutTable, Table, scalar};
use super::{Kernels, rows::Rows};
use crate::image::Image;
use core::arch::aarch64::*;
use core::slice;

/// Pixels in a register.
const LANES: usize = 16;

/// Entries that one instruction looks up.
const SEGMENT: usize = 64;

/// So many rows are added before it is looked whether the end is already certain.
const ROWS_A_LOOK: usize = 4;

/// The live part of a table, low bytes and high bytes apart.
pub(super) struct Lookup {
    low: [[u8; SEGMENT]; 4],
    high: [[u8; SEGMENT]; 4],
    segments: usize,
    /// The largest difference that counts, if there is one.
    last: Option<u8>,
}

impl Kernels for Lookup {
    #[inline]
    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let rows = Rows::of(patch, template);
        // SAFETY: this file is compiled only where all has NEON, and both pictures are borrowed.
        unsafe {
            match self.segments {
                0..=1 => self.sum_at_least::<1>(&rows, floor),
                2 => self.sum_at_least::<2>(&rows, floor),
                _ => self.sum_at_least::<4>(&rows, floor),
            }
        }
    }

    #[inline]
    fn score_between_at_least(&self, low: Image<'_>, high: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let rows = Rows::between(low, high, template);
        // SAFETY: this file is compiled only where all has NEON, and the pictures are borrowed.
        unsafe { self.count_at_least(&rows, floor) }
    }

    #[inline]
    fn spread(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
        // SAFETY: this file is compiled only where all has NEON.
        unsafe { spread(rows, low, high) }
    }

    #[inline]
    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
        let rows = Rows::of(patch, template);
        // SAFETY: this file is compiled only where all has NEON, and both pictures are borrowed.
        unsafe { distance(&rows, enough) }
    }
}

impl Lookup {
    pub(super) fn new(table: &CutTable) -> Self {
        let threshold = table.threshold();
        let segments = usize::from(threshold).div_ceil(SEGMENT);
        let last = threshold.checked_sub(1).and_then(|last| u8::try_from(last).ok());
        let mut lookup = Self { low: [[0; SEGMENT]; 4], high: [[0; SEGMENT]; 4], segments, last };
        let places = lookup.low.as_flattened_mut().iter_mut().zip(lookup.high.as_flattened_mut());
        for ((low, high), entry) in places.zip(table.entries()).take(usize::from(threshold)) {
            [*low, *high] = entry.to_le_bytes();
        }
        lookup
    }

    /// The number of pixels that count, each fully similar.
    ///
    /// # Safety
    /// The pictures that `rows` were made of are borrowed.
    #[target_feature(enable = "neon")]
    unsafe fn count_at_least(&self, rows: &Rows, floor: u32) -> Option<u32> {
        let Some(last) = self.last else { return Some(0).filter(|_| floor == 0) };
        let (end, last) = (End::of(rows.width), vdupq_n_u8(last));
        let mut count = Count { bytes: vdupq_n_u8(0), registers: 0, flushed: 0 };
        let mut y = 0;
        while y < rows.height {
            let ((f, g), h) = (rows.row(y), rows.high_row(y));
            let mut at = 0;
            while at + LANES <= rows.width {
                // SAFETY: at + 16 is at most the width.
                let (f, h, g) =
                    unsafe { (load(f.wrapping_add(at)), load(h.wrapping_add(at)), load(g.wrapping_add(at))) };
                count.add(vcleq_u8(outside(f, h, g), last));
                at += LANES;
            }
            if end.exists() {
                // SAFETY: the row is as wide as `end` was made for.
                let (f, h, g) = unsafe { (end.load(f), end.load(h), end.load(g)) };
                count.add(vandq_u8(vcleq_u8(outside(f, h, g), last), end.valid));
            }
            y += 1;
            if y.is_multiple_of(ROWS_A_LOOK) && rows.full_after(y) < floor && count.score() + rows.full_after(y) < floor
            {
                return None;
            }
        }
        Some(count.score()).filter(|&score| score >= floor)
    }

    /// # Safety
    /// The pictures that `rows` were made of are borrowed.
    #[target_feature(enable = "neon")]
    unsafe fn sum_at_least<const SEGMENTS: usize>(&self, rows: &Rows, floor: u32) -> Option<u32> {
        let end = End::of(rows.width);
        let (low, high) = (plane::<SEGMENTS>(&self.low), plane::<SEGMENTS>(&self.high));
        let mut sums = Sums { low: vdupq_n_u32(0), high: vdupq_n_u32(0) };
        for y in 0..rows.height {
            let (f, g) = rows.row(y);
            for at in (0..rows.width / LANES).map(|register| register * LANES) {
                // SAFETY: at + 16 is at most the width.
                let difference = unsafe { vabdq_u8(load(f.wrapping_add(at)), load(g.wrapping_add(at))) };
                sums.add(look_up::<SEGMENTS>(&low, difference), look_up::<SEGMENTS>(&high, difference));
            }
            if end.exists() {
                // SAFETY: the row is as wide as `end` was made for.
                let difference = unsafe { vabdq_u8(end.load(f), end.load(g)) };
                sums.add(
                    vandq_u8(look_up::<SEGMENTS>(&low, difference), end.valid),
                    vandq_u8(look_up::<SEGMENTS>(&high, difference), end.valid),
                );
            }
            let left = rows.full_after(y + 1);
            if left < floor && y % ROWS_A_LOOK == ROWS_A_LOOK - 1 && sums.score() + left < floor {
                return None;
            }
        }
        Some(sums.score()).filter(|&score| score >= floor)
    }
}

/// One byte plane of a table.
type Plane = [uint8x16x4_t; 4];

/// The first `SEGMENTS` of a plane; the rest is not looked up.
#[inline]
#[target_feature(enable = "neon")]
fn plane<const SEGMENTS: usize>(segments: &[[u8; SEGMENT]; 4]) -> Plane {
    let nothing = vdupq_n_u8(0);
    let mut plane = [uint8x16x4_t(nothing, nothing, nothing, nothing); 4];
    for (registers, segment) in plane.iter_mut().zip(segments).take(SEGMENTS) {
        // SAFETY: `segment` is 64 readable bytes.
        *registers = unsafe { vld1q_u8_x4(segment.as_ptr()) };
    }
    plane
}

/// The entries of 16 differences; zero beyond the last of `SEGMENTS` segments.
#[inline]
#[target_feature(enable = "neon")]
fn look_up<const SEGMENTS: usize>(plane: &Plane, difference: uint8x16_t) -> uint8x16_t {
    let [first, others @ ..] = plane;
    let mut index = difference;
    let mut entries = vqtbl4q_u8(*first, index);
    for segment in others.iter().take(SEGMENTS - 1) {
        // What lies in another segment has an index that is too large, be it by wrapping, and keeps what it has.
        index = vsubq_u8(index, vdupq_n_u8(64));
        entries = vqtbx4q_u8(entries, *segment, index);
    }
    entries
}

/// The sums of the two byte planes, in four parts each.
struct Sums {
    low: uint32x4_t,
    high: uint32x4_t,
}

impl Sums {
    #[inline]
    #[target_feature(enable = "neon")]
    fn add(&mut self, low: uint8x16_t, high: uint8x16_t) {
        self.low = vpadalq_u16(self.low, vpaddlq_u8(low));
        self.high = vpadalq_u16(self.high, vpaddlq_u8(high));
    }

    /// The sum of the similarities, which fits a `u32` for as many pixels as a template may have.
    #[inline]
    #[target_feature(enable = "neon")]
    fn score(&self) -> u32 {
        vaddvq_u32(vaddq_u32(self.low, vshlq_n_u32::<8>(self.high)))
    }
}

/// How many pixels count.
struct Count {
    /// In 16 parts, of so many registers.
    bytes: uint8x16_t,
    registers: u8,
    /// And of those before.
    flushed: u32,
}

impl Count {
    /// Counts the lanes of which all bits are set.
    #[inline]
    #[target_feature(enable = "neon")]
    fn add(&mut self, counts: uint8x16_t) {
        self.bytes = vsubq_u8(self.bytes, counts); // all bits are -1
        self.registers += 1;
        if self.registers == u8::MAX {
            self.flush();
        }
    }

    #[inline]
    #[target_feature(enable = "neon")]
    fn flush(&mut self) {
        self.flushed += u32::from(vaddlvq_u8(self.bytes));
        (self.bytes, self.registers) = (vdupq_n_u8(0), 0);
    }

    #[inline]
    #[target_feature(enable = "neon")]
    fn score(&mut self) -> u32 {
        self.flush();
        self.flushed * u32::from(Table::ONE)
    }
}

/// By how much 16 pixels lie outside their ranges.
#[inline]
#[target_feature(enable = "neon")]
fn outside(low: uint8x16_t, high: uint8x16_t, g: uint8x16_t) -> uint8x16_t {
    vorrq_u8(vqsubq_u8(low, g), vqsubq_u8(g, high))
}

/// See [`scalar::spread`].
#[target_feature(enable = "neon")]
fn spread(rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
    let columns = rows.iter().map(|row| row.len().saturating_sub(3)).min().unwrap_or(0).min(low.len()).min(high.len());
    let Some(last) = columns.checked_sub(LANES) else {
        return scalar::spread(rows, low, high);
    };
    let mut at = 0;
    loop {
        let (mut lowest, mut highest) = (vdupq_n_u8(u8::MAX), vdupq_n_u8(0));
        for row in rows {
            for column in 0..4 {
                // SAFETY: at + 16 is at most `columns`, and no row is shorter than that and three.
                let pixels = unsafe { load(row.as_ptr().wrapping_add(at + column)) };
                (lowest, highest) = (vminq_u8(lowest, pixels), vmaxq_u8(highest, pixels));
            }
        }
        // SAFETY: at + 16 is at most `columns`, and neither of the two is shorter than that.
        unsafe {
            vst1q_u8(low.as_mut_ptr().wrapping_add(at), lowest);
            vst1q_u8(high.as_mut_ptr().wrapping_add(at), highest);
        }
        if at >= last {
            return;
        }
        // The last columns are done together with some before them, which come out the same again.
        at = last.min(at + LANES);
    }
}

/// See [`scalar::distance`].
///
/// # Safety
/// The pictures that `rows` were made of are borrowed.
#[target_feature(enable = "neon")]
unsafe fn distance(rows: &Rows, enough: u32) -> u32 {
    let end = End::of(rows.width);
    let mut sum = vdupq_n_u32(0);
    for y in 0..rows.height {
        let (f, g) = rows.row(y);
        for at in (0..rows.width / LANES).map(|register| register * LANES) {
            // SAFETY: at + 16 is at most the width.
            let difference = unsafe { vabdq_u8(load(f.wrapping_add(at)), load(g.wrapping_add(at))) };
            sum = vpadalq_u16(sum, vpaddlq_u8(difference));
        }
        if end.exists() {
            // SAFETY: the row is as wide as `end` was made for.
            let difference = unsafe { vabdq_u8(end.load(f), end.load(g)) };
            sum = vpadalq_u16(sum, vpaddlq_u8(vandq_u8(difference, end.valid)));
        }
        if y % ROWS_A_LOOK == ROWS_A_LOOK - 1 && vaddvq_u32(sum) > enough {
            break;
        }
    }
    vaddvq_u32(sum)
}

/// The end of a row: the 1 to 15 pixels that are left where whole registers have been taken off.
struct End {
    width: usize,
    /// All bits of the lanes that hold a pixel of the end: the last ones.
    valid: uint8x16_t,
}

impl End {
    #[inline]
    #[target_feature(enable = "neon")]
    fn of(width: usize) -> Self {
        const LANE: [u8; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
        // SAFETY: these are 16 bytes.
        let lane = unsafe { load(LANE.as_ptr()) };
        let before = u8::try_from(LANES - width % LANES).unwrap_or(0);
        Self { width, valid: vcgeq_u8(lane, vdupq_n_u8(before)) }
    }

    #[inline]
    fn exists(&self) -> bool {
        !self.width.is_multiple_of(LANES)
    }

    /// The end of the row that begins at `row`, after pixels that have been taken off, or after nothing.
    ///
    /// # Safety
    /// There are as many readable bytes as this was made for.
    #[inline]
    #[target_feature(enable = "neon")]
    unsafe fn load(&self, row: *const u8) -> uint8x16_t {
        if self.width >= LANES {
            // SAFETY: there are at least 16.
            return unsafe { load(row.wrapping_add(self.width).wrapping_sub(LANES)) };
        }
        // SAFETY: the caller has seen to it.
        let row = unsafe { slice::from_raw_parts(row, self.width) };
        let mut pixels = [0; LANES];
        for (to, from) in pixels.iter_mut().rev().zip(row.iter().rev()) {
            *to = *from;
        }
        // SAFETY: these are 16 bytes.
        unsafe { load(pixels.as_ptr()) }
    }
}

/// # Safety
/// There are 16 readable bytes.
#[inline]
#[target_feature(enable = "neon")]
unsafe fn load(pixels: *const u8) -> uint8x16_t {
    // SAFETY: the caller has seen to it; the load needs no alignment.
    unsafe { vld1q_u8(pixels) }
}
