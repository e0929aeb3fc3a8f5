//! Distances, ranges and bounds of scores by SSE2, which every x86-64 has: 16 pixels at a time.
//!
//! SSE2 cannot look up bytes in a table, so the plain loop computes the score. But the search asks for most scores with
//! a floor, which most of them do not reach. Let N pixels count and S be the sum of their differences. Then
//!
//! ```text
//! score <= N * 65535 - c * S        with c from CutTable::chord
//! ```
//!
//! If this bound is below the floor, the plain loop does not run. The bound costs 8 to 15 % of the plain loop: 16
//! instructions for 16 pixels, instead of eight or more for each. For a patch between two pictures the bound is the
//! answer.
//!
//! Groups, and four offsets at a time, are excluded by N alone: `generic.rs` counts pixels in a third of the
//! instructions.

use crate::image::Image;
use crate::kernels::cut_table::{CutTable, ONE};
use crate::kernels::effort::Effort;
use crate::kernels::generic::{self, Neighbours, Vector, by_width, intrinsics, outside, ranges};
use crate::kernels::plain::scores as plain;
use crate::kernels::rows::Rows;
use crate::kernels::scores::{Blocks, RowsOfRanges, Scores};
use core::arch::x86_64::*;

impl Vector for __m128i {
    const LANES: usize = 16;
    type Total = Self;

    intrinsics! {
        fn splat(byte: u8) -> Self { _mm_set1_epi8(byte.cast_signed()) }
        fn load(from: *const u8) -> Self { _mm_loadu_si128(from.cast()) }
        fn or(a: Self, b: Self) -> Self { _mm_or_si128(a, b) }
        fn beyond(a: Self, b: Self) -> Self { _mm_subs_epu8(a, b) }
        fn minus(a: Self, b: Self) -> Self { _mm_sub_epi8(a, b) }
        fn at_most(a: Self, b: Self) -> Self { _mm_cmpeq_epi8(_mm_subs_epu8(a, b), _mm_setzero_si128()) }
        fn is_above(a: Self, b: Self) -> Self { _mm_cmpgt_epi8(a, b) }
        fn nothing() -> Self { _mm_setzero_si128() }
        fn add(total: Self, bytes: Self) -> Self { _mm_add_epi64(total, _mm_sad_epu8(bytes, _mm_setzero_si128())) }
        fn add_distance(total: Self, f: Self, g: Self) -> Self { _mm_add_epi64(total, _mm_sad_epu8(f, g)) }
        fn plus(a: Self, b: Self) -> Self { _mm_add_epi64(a, b) }
        fn times_256(total: Self) -> Self { _mm_slli_epi64(total, 8) }
        fn across(total: Self) -> u32 {
            _mm_cvtsi128_si32(_mm_add_epi64(total, _mm_unpackhi_epi64(total, total))).cast_unsigned()
        }
        fn end<const WHOLE: usize>(width: usize) -> Self { generic::last_lanes(width) }
        fn load_end<const WHOLE: usize>(row: *const u8, width: usize, _end: Self) -> Self {
            generic::last::<Self, WHOLE>(row, width)
        }
        fn keep(bytes: Self, end: Self) -> Self { _mm_and_si128(bytes, end) }
    }
}

impl Neighbours for __m128i {
    intrinsics! {
        fn store(bytes: Self, to: *mut u8) { _mm_storeu_si128(to.cast(), bytes) }
        fn min(a: Self, b: Self) -> Self { _mm_min_epu8(a, b) }
        fn max(a: Self, b: Self) -> Self { _mm_max_epu8(a, b) }
        fn raised(a: Self, b: Self) -> Self { _mm_adds_epu8(a, b) }
        fn further<const BY: i32>(bytes: Self) -> Self { _mm_srli_si128::<BY>(bytes) }
    }
}

/// Up to this width the bound reads only the first vector of a row and takes the rest as fully similar. A second
/// vector, at most half full, would cost a fifth of the plain loop.
const NARROW: usize = 24;

/// Rows between two checks whether the floor can still be reached.
const ROWS_A_LOOK: usize = 4;

/// A table, and the numbers that bound a score without it.
pub(crate) struct Bound<'a> {
    table: &'a CutTable,
    /// The largest difference that counts.
    last: u8,
    chord: u32,
    /// Decides how often bounding candidates is worth its time.
    candidates: Effort,
}

impl Scores for Bound<'_> {
    #[inline(always)] // keeps `Rows` in registers; reading it back from memory would stall
    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let rows = Rows::of(patch, template);
        let looked_at = rows.first(if rows.width <= NARROW { __m128i::LANES } else { rows.width });
        let floor_there = floor.saturating_sub(rows.full_after(0) - looked_at.full_after(0));
        if floor_there > 0 && rows.width >= __m128i::LANES {
            // SAFETY: a `Bound` exists only if SSE2 does, the pictures are borrowed, and rows are at least a vector
            // wide.
            unsafe { self.reach::<false>(&looked_at, floor_there) }?;
        }
        plain::score_at_least(patch, template, self.table, floor)
    }

    #[inline(always)]
    fn score_between_at_least(&self, low: Image<'_>, high: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let rows = Rows::between(low, high, template);
        if rows.width < __m128i::LANES {
            return plain::score_between_at_least(low, high, template, self.table, floor);
        }
        // SAFETY: a `Bound` exists only if SSE2 does, the pictures are borrowed, and rows are at least a vector wide.
        unsafe { self.reach::<true>(&rows, floor) }
    }

    #[inline(always)]
    fn ranges(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
        // SAFETY: a `Bound` exists only if SSE2 does.
        unsafe { spread(rows, low, high) };
        generic::widen_all(low, high, self.last);
    }

    #[inline(always)]
    fn ranges_of_rows(&self, pixels: Image<'_>, step: usize, to: &mut RowsOfRanges<'_>) -> bool {
        // SAFETY: a `Bound` exists only if SSE2 does.
        unsafe { ranges_of_rows(pixels, step, self.last, to) }
    }

    #[inline(always)]
    fn bound(&self, blocks: &Blocks<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let Some(rows) = Rows::of_blocks(blocks, template) else { return Some(plain::most(template, template)) };
        // SAFETY: a `Bound` exists only if SSE2 does, and the pictures are borrowed.
        unsafe { inside_at_least(&rows, floor) }
    }

    #[inline(always)]
    fn candidates(&self, patch: Image<'_>, template: Image<'_>, floor: u32, wanted: u8) -> u8 {
        if !self.candidates.is_worth_it() {
            return wanted;
        }
        // SAFETY: a `Bound` exists only if SSE2 does, and the pictures are borrowed.
        let candidates = unsafe { candidates(&Rows::of(patch, template), self.last, floor) } & wanted;
        self.candidates.note(candidates != wanted);
        candidates
    }

    #[inline(always)]
    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
        let rows = Rows::of(patch, template);
        if rows.width < __m128i::LANES {
            return plain::distance(patch, template, enough);
        }
        // SAFETY: a `Bound` exists only if SSE2 does, and both pictures are borrowed.
        unsafe { distance(&rows, enough) }
    }
}

ranges!("sse2", __m128i);

#[target_feature(enable = "sse2")]
unsafe fn distance(rows: &Rows, enough: u32) -> u32 {
    // SAFETY: as the caller guarantees.
    unsafe { by_width!(rows.width, __m128i, generic::distance::<__m128i, WHOLE, END>(rows, enough)) }
}

/// See [`generic::inside_at_least`].
///
/// # Safety
/// The processor has SSE2, and the pictures are borrowed.
#[target_feature(enable = "sse2")]
unsafe fn inside_at_least(rows: &Rows, floor: u32) -> Option<u32> {
    // SAFETY: as the caller guarantees.
    unsafe { by_width!(rows.width, __m128i, generic::inside_at_least::<__m128i, WHOLE, END>(rows, floor)) }
}

/// See [`Scores::candidates`].
///
/// # Safety
/// The processor has SSE2, the pictures are borrowed, and the patch has three more columns than the template.
#[target_feature(enable = "sse2")]
unsafe fn candidates(rows: &Rows, last: u8, floor: u32) -> u8 {
    // SAFETY: as the caller guarantees.
    unsafe { by_width!(rows.width, __m128i, generic::candidates::<__m128i, WHOLE, END>(rows, last, floor)) }
}

impl<'a> Bound<'a> {
    /// `None` if no pixel counts, or if there is no SSE2. So a `Bound` proves that there is.
    pub(crate) fn new(table: &'a CutTable) -> Option<Self> {
        let last = u8::try_from(table.threshold().checked_sub(1)?).ok()?;
        super::is_available().then_some(Self { table, last, chord: table.chord(), candidates: Effort::NEW })
    }

    /// An upper bound of the score, if it is at least `floor`. `BETWEEN`: the patch lies between two pictures.
    ///
    /// # Safety
    /// The pictures that `rows` were made of are borrowed, and at least 16 pixels wide.
    #[target_feature(enable = "sse2")]
    unsafe fn reach<const BETWEEN: bool>(&self, rows: &Rows, floor: u32) -> Option<u32> {
        const FILLED: usize = 1; // at least
        // SAFETY: this is compiled for SSE2; no vector ends beyond the width, for which `end` was made.
        unsafe {
            let end = __m128i::end::<FILLED>(rows.width);
            let mut sums =
                Sums { last: __m128i::splat(self.last), counted: __m128i::nothing(), differences: __m128i::nothing() };
            let mut y = 0;
            loop {
                let ((f, g), h) = (rows.row(y), rows.high_row(y));
                let h = if BETWEEN { h } else { f };
                let mut at = 0;
                while at + __m128i::LANES <= rows.width {
                    let (f, h) = (__m128i::load(f.wrapping_add(at)), __m128i::load(h.wrapping_add(at)));
                    sums.add(outside(f, h, __m128i::load(g.wrapping_add(at))), __m128i::splat(u8::MAX));
                    at += __m128i::LANES;
                }
                if at < rows.width {
                    let f = __m128i::load_end::<FILLED>(f, rows.width, end);
                    let h = __m128i::load_end::<FILLED>(h, rows.width, end);
                    sums.add(outside(f, h, __m128i::load_end::<FILLED>(g, rows.width, end)), end);
                }
                y += 1;
                if y.is_multiple_of(ROWS_A_LOOK) || y >= rows.height {
                    let most = sums.most(self.chord);
                    if most + rows.full_after(y) < floor {
                        return None;
                    }
                    if y >= rows.height {
                        return Some(most);
                    }
                }
            }
        }
    }
}

/// The sums that bound a score, in two lanes each.
struct Sums {
    /// The largest difference that counts.
    last: __m128i,
    /// 255 for each pixel that counts: the result of a comparison is added as it is.
    counted: __m128i,
    differences: __m128i,
}

impl Sums {
    /// Adds the differences of the `valid` pixels that count.
    ///
    /// # Safety
    /// The processor has SSE2.
    #[inline(always)]
    unsafe fn add(&mut self, difference: __m128i, valid: __m128i) {
        // SAFETY: as the caller guarantees.
        unsafe {
            let counts = __m128i::keep(__m128i::at_most(difference, self.last), valid);
            self.counted = __m128i::add(self.counted, counts);
            self.differences = __m128i::add(self.differences, _mm_and_si128(counts, difference));
        }
    }

    /// An upper bound of the score. It fits in a `u32` for every template.
    ///
    /// # Safety
    /// The processor has SSE2.
    #[inline(always)]
    unsafe fn most(&self, chord: u32) -> u32 {
        const COUNTED: u32 = ONE as u32 / 255;
        // The result is not negative: each pixel contributes at least its similarity.
        // SAFETY: as the caller guarantees.
        unsafe { __m128i::across(self.counted) * COUNTED - __m128i::across(self.differences) * chord }
    }
}
