//! Distances by SSE2, 16 pixels at a time, and scores by the plain loop after a bound: what every x86-64 has.
//!
//! SSE2 has no instruction that looks a byte up, so the score itself is left to the plain loop. But most scores that are
//! asked for are asked with a floor, and most do not reach it: with N pixels that count and the sum S of their
//! differences, which are two additions, a score is at most N * 65535 - c * S. (A pixel that counts and has the
//! difference d adds p(d), and c is at most (65535 - p(d)) / d for every such d; see [`scalar::chord`].) Where even that
//! is below the floor the plain loop is not begun.

use super::super::{Table, scalar};
use super::{Kernels, rows::Rows};
use crate::image::Image;
use core::arch::x86_64::*;

/// Pixels in a register.
const LANES: usize = 16;

/// So many rows are added before it is looked whether the end is already certain.
const ROWS_A_LOOK: usize = 4;

/// A table, and what bounds a score without it.
pub(super) struct Bound {
    table: &'static Table,
    threshold: u16,
    /// The largest difference that counts; there is one.
    last: u8,
    chord: u32,
}

pub(super) const fn is_available() -> bool {
    cfg!(target_feature = "sse2")
}

impl Kernels for Bound {
    #[inline]
    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let rows = Rows::of(patch, template);
        // SAFETY: a `Bound` exists only where SSE2 does, and both pictures are borrowed.
        if floor > 0 && rows.width >= LANES && !unsafe { self.may_reach(&rows, floor) } {
            return None;
        }
        scalar::score_at_least(patch, template, self.table, self.threshold, floor)
    }

    #[inline]
    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
        let rows = Rows::of(patch, template);
        if rows.width < LANES {
            return scalar::distance(patch, template, enough);
        }
        // SAFETY: a `Bound` exists only where SSE2 does, and both pictures are borrowed.
        unsafe { distance(&rows, enough) }
    }
}

impl Bound {
    /// `None` where nothing counts, and where there is no SSE2: that there is a `Bound` is the proof that there is.
    pub(super) fn new(table: &'static Table, threshold: u16) -> Option<Self> {
        let last = u8::try_from(threshold.checked_sub(1)?).ok()?;
        let chord = scalar::chord(table, threshold);
        is_available().then_some(Self { table, threshold, last, chord })
    }

    /// False only if the score is below `floor`. The rows are of at least 16 pixels.
    ///
    /// # Safety
    /// The pictures that `rows` were made of are borrowed.
    #[target_feature(enable = "sse2")]
    unsafe fn may_reach(&self, rows: &Rows, floor: u32) -> bool {
        let end = End::of(rows.width);
        let last = _mm_set1_epi8(self.last.cast_signed());
        let (mut number, mut sum) = (_mm_setzero_si128(), _mm_setzero_si128());
        let mut add = |f, g, valid| {
            let difference = _mm_or_si128(_mm_subs_epu8(f, g), _mm_subs_epu8(g, f));
            let beyond = _mm_subs_epu8(difference, last);
            let counts = _mm_and_si128(_mm_cmpeq_epi8(beyond, _mm_setzero_si128()), valid);
            number = _mm_add_epi64(number, total(_mm_and_si128(counts, _mm_set1_epi8(1))));
            sum = _mm_add_epi64(sum, total(_mm_and_si128(counts, difference)));
            (number, sum)
        };
        let mut sums = (_mm_setzero_si128(), _mm_setzero_si128());
        for y in 0..rows.height {
            let (f, g) = rows.row(y);
            for at in (0..rows.width / LANES).map(|register| register * LANES) {
                // SAFETY: at + 16 is at most the width.
                let (f, g) = unsafe { (load(f.wrapping_add(at)), load(g.wrapping_add(at))) };
                sums = add(f, g, _mm_set1_epi8(-1));
            }
            if end.exists() {
                // SAFETY: the row is as wide as `end` was made for.
                let (f, g) = unsafe { (end.load(f), end.load(g)) };
                sums = add(f, g, end.valid);
            }
            if y % ROWS_A_LOOK == ROWS_A_LOOK - 1 || y + 1 == rows.height {
                // Never below zero: the part that each pixel adds is at least its similarity.
                let most = across(sums.0) * u32::from(Table::ONE) - across(sums.1) * self.chord;
                if most + rows.full_after(y + 1) < floor {
                    return false;
                }
            }
        }
        true
    }
}

/// See [`scalar::distance`]. The rows are of at least 16 pixels.
///
/// # Safety
/// The pictures that `rows` were made of are borrowed.
#[target_feature(enable = "sse2")]
unsafe fn distance(rows: &Rows, enough: u32) -> u32 {
    let end = End::of(rows.width);
    let mut sum = _mm_setzero_si128();
    for y in 0..rows.height {
        let (f, g) = rows.row(y);
        for at in (0..rows.width / LANES).map(|register| register * LANES) {
            // SAFETY: at + 16 is at most the width.
            let (f, g) = unsafe { (load(f.wrapping_add(at)), load(g.wrapping_add(at))) };
            sum = _mm_add_epi64(sum, _mm_sad_epu8(f, g));
        }
        if end.exists() {
            // SAFETY: the row is as wide as `end` was made for.
            let (f, g) = unsafe { (end.load(f), end.load(g)) };
            let (f, g) = (_mm_and_si128(f, end.valid), _mm_and_si128(g, end.valid));
            sum = _mm_add_epi64(sum, _mm_sad_epu8(f, g));
        }
        if y % ROWS_A_LOOK == ROWS_A_LOOK - 1 && across(sum) > enough {
            break;
        }
    }
    across(sum)
}

/// The end of a row of at least 16 pixels: the 1 to 15 that are left where whole registers have been taken off. They are
/// loaded with those before them.
struct End {
    width: usize,
    /// All bits of the lanes that hold a pixel of the end.
    valid: __m128i,
}

impl End {
    #[inline]
    #[target_feature(enable = "sse2")]
    fn of(width: usize) -> Self {
        const LANE: [u8; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
        // SAFETY: these are 16 bytes.
        let lane = unsafe { load(LANE.as_ptr()) };
        let before = i8::try_from(LANES - width % LANES).unwrap_or(0);
        Self { width, valid: _mm_cmpgt_epi8(lane, _mm_set1_epi8(before - 1)) }
    }

    #[inline]
    fn exists(&self) -> bool {
        !self.width.is_multiple_of(LANES)
    }

    /// The end of the row that begins at `row`.
    ///
    /// # Safety
    /// There are as many readable bytes as this was made for, and that is at least 16.
    #[inline]
    #[target_feature(enable = "sse2")]
    unsafe fn load(&self, row: *const u8) -> __m128i {
        // SAFETY: the caller has seen to it.
        unsafe { load(row.wrapping_add(self.width).wrapping_sub(LANES)) }
    }
}

/// # Safety
/// There are 16 readable bytes.
#[inline]
#[target_feature(enable = "sse2")]
unsafe fn load(pixels: *const u8) -> __m128i {
    // SAFETY: the caller has seen to it; the load needs no alignment.
    unsafe { _mm_loadu_si128(pixels.cast()) }
}

/// The sum of the bytes, in two parts.
#[inline]
#[target_feature(enable = "sse2")]
fn total(bytes: __m128i) -> __m128i {
    _mm_sad_epu8(bytes, _mm_setzero_si128())
}

/// The sum of the two parts.
#[inline]
#[target_feature(enable = "sse2")]
fn across(parts: __m128i) -> u32 {
    _mm_cvtsi128_si32(_mm_add_epi64(parts, _mm_unpackhi_epi64(parts, parts))).cast_unsigned()
}
