//! Distances, ranges and bounds by SSE2, 16 pixels at a time; a score is the plain loop's: what every x86-64 has.
//!
//! SSE2 has no instruction that looks a byte up, so the score itself is left to the plain loop. But most scores that are
//! asked for are asked with a floor, and most do not reach it: with N pixels that count and the sum S of their
//! differences, which are two additions, a score is at most N * 65535 - c * S. (A pixel that counts and has the
//! difference d adds p(d), and c is at most (65535 - p(d)) / d for every such d; see [`CutTable::chord`].) Where even that
//! is below the floor the plain loop is not begun; where it is begun nevertheless, the bound has cost 8 to 15 % of it: 16
//! instructions for 16 pixels, of which each takes the plain loop eight or more. Of a patch that lies between two
//! pictures the bound is the answer.

use super::super::{CutTable, Table, scalar};
use super::{Kernels, rows::Rows};
use crate::image::Image;
use core::arch::x86_64::*;

/// Pixels in a register.
const LANES: usize = 16;

/// Of rows that are no wider the bound looks only at the first register: at a second for no more than half of what it holds
/// it would cost a fifth of the plain loop. What it does not look at it takes to be fully similar.
const NARROW: usize = 24;

/// So many rows are added before it is looked whether the end is already certain.
const ROWS_A_LOOK: usize = 4;

/// A table, and what bounds a score without it.
pub(super) struct Bound<'a> {
    table: &'a CutTable,
    /// The largest difference that counts; there is one.
    last: u8,
    chord: u32,
}

pub(super) const fn is_available() -> bool {
    cfg!(target_feature = "sse2")
}

impl Kernels for Bound<'_> {
    #[inline(always)] // what `Rows` takes of the pictures is then in registers; through memory it waits for halves of words
    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let rows = Rows::of(patch, template);
        let looked_at = rows.first(if rows.width <= NARROW { LANES } else { rows.width });
        let floor_there = floor.saturating_sub(rows.full_after(0) - looked_at.full_after(0));
        if floor_there > 0 && rows.width >= LANES {
            // SAFETY: a `Bound` exists only where SSE2 does, both pictures are borrowed, and a register's width is there.
            unsafe { self.reach::<false>(&looked_at, floor_there) }?;
        }
        scalar::score_at_least(patch, template, self.table, floor)
    }

    #[inline(always)]
    fn score_between_at_least(&self, low: Image<'_>, high: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let rows = Rows::between(low, high, template);
        if rows.width < LANES {
            return scalar::score_between_at_least(low, high, template, self.table, floor);
        }
        // SAFETY: a `Bound` exists only where SSE2 does, the pictures are borrowed, and a register's width is there.
        unsafe { self.reach::<true>(&rows, floor) }
    }

    #[inline(always)]
    fn spread(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
        // SAFETY: a `Bound` exists only where SSE2 does.
        unsafe { spread(rows, low, high) }
    }

    #[inline(always)]
    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
        let rows = Rows::of(patch, template);
        if rows.width < LANES {
            return scalar::distance(patch, template, enough);
        }
        // SAFETY: a `Bound` exists only where SSE2 does, and both pictures are borrowed.
        unsafe { distance(&rows, enough) }
    }
}

impl<'a> Bound<'a> {
    /// `None` where nothing counts, and where there is no SSE2: that there is a `Bound` is the proof that there is.
    pub(super) fn new(table: &'a CutTable) -> Option<Self> {
        let last = u8::try_from(table.threshold().checked_sub(1)?).ok()?;
        is_available().then_some(Self { table, last, chord: table.chord() })
    }

    /// What the score is at most, if that is at least `floor`. `BETWEEN`: the patch is between two pictures.
    ///
    /// # Safety
    /// The pictures that `rows` were made of are borrowed, and at least 16 pixels wide.
    #[target_feature(enable = "sse2")]
    unsafe fn reach<const BETWEEN: bool>(&self, rows: &Rows, floor: u32) -> Option<u32> {
        let end = End::of(rows.width);
        let last = _mm_set1_epi8(self.last.cast_signed());
        let mut sums = Sums { counted: _mm_setzero_si128(), differences: _mm_setzero_si128() };
        let mut y = 0;
        loop {
            let ((f, g), h) = (rows.row(y), rows.high_row(y));
            let mut at = 0;
            while at + LANES <= rows.width {
                // SAFETY: at + 16 is at most the width.
                let difference = unsafe { outside::<BETWEEN>([f, h, g].map(|row| row.wrapping_add(at))) };
                sums.add(difference, last, _mm_set1_epi8(-1));
                at += LANES;
            }
            if end.exists() {
                // SAFETY: the row is as wide as `end` was made for.
                let difference = unsafe { outside::<BETWEEN>([f, h, g].map(|row| end.place(row))) };
                sums.add(difference, last, end.valid);
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

/// The sums that bound a score, in two parts each.
struct Sums {
    /// 255 for each pixel that counts, so that a comparison need not be made a number first.
    counted: __m128i,
    differences: __m128i,
}

impl Sums {
    /// Adds the differences of the pixels that are `valid` and differ by no more than `last`.
    #[inline]
    #[target_feature(enable = "sse2")]
    fn add(&mut self, difference: __m128i, last: __m128i, valid: __m128i) {
        let beyond = _mm_subs_epu8(difference, last);
        let counts = _mm_and_si128(_mm_cmpeq_epi8(beyond, _mm_setzero_si128()), valid);
        self.counted = _mm_add_epi64(self.counted, total(counts));
        self.differences = _mm_add_epi64(self.differences, total(_mm_and_si128(counts, difference)));
    }

    /// What the pixels score at most; it fits a `u32` for as many pixels as a template may have.
    #[inline]
    #[target_feature(enable = "sse2")]
    fn most(&self, chord: u32) -> u32 {
        const COUNTED: u32 = Table::ONE as u32 / 255;
        // Never below zero: the part that each pixel adds is at least its similarity.
        across(self.counted) * COUNTED - across(self.differences) * chord
    }
}

/// By how much 16 pixels lie outside their ranges, lowest and highest; where they are not `BETWEEN` two pictures, |f - g|.
///
/// # Safety
/// There are 16 readable bytes at each address.
#[inline]
#[target_feature(enable = "sse2")]
unsafe fn outside<const BETWEEN: bool>([low, high, g]: [*const u8; 3]) -> __m128i {
    // SAFETY: the caller has seen to it.
    let (low, high, g) = unsafe { (load(low), if BETWEEN { load(high) } else { load(low) }, load(g)) };
    _mm_or_si128(_mm_subs_epu8(low, g), _mm_subs_epu8(g, high))
}

/// See [`scalar::spread`].
#[target_feature(enable = "sse2")]
pub(super) fn spread(rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
    let columns = rows.iter().map(|row| row.len().saturating_sub(3)).min().unwrap_or(0).min(low.len()).min(high.len());
    let Some(last) = columns.checked_sub(LANES) else {
        return scalar::spread(rows, low, high);
    };
    let mut at = 0;
    loop {
        let (mut lowest, mut highest) = (_mm_set1_epi8(-1), _mm_setzero_si128());
        for row in rows {
            for column in 0..4 {
                // SAFETY: at + 16 is at most `columns`, and no row is shorter than that and three.
                let pixels = unsafe { load(row.as_ptr().wrapping_add(at + column)) };
                lowest = _mm_min_epu8(lowest, pixels);
                highest = _mm_max_epu8(highest, pixels);
            }
        }
        // SAFETY: at + 16 is at most `columns`, and neither of the two is shorter than that.
        unsafe {
            _mm_storeu_si128(low.as_mut_ptr().wrapping_add(at).cast(), lowest);
            _mm_storeu_si128(high.as_mut_ptr().wrapping_add(at).cast(), highest);
        }
        if at >= last {
            return;
        }
        // The last columns are done together with some before them, which come out the same again.
        at = last.min(at + LANES);
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
            let (f, g) = unsafe { (load(end.place(f)), load(end.place(g))) };
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

    /// Where 16 pixels begin that end with the row that begins at `row`.
    #[inline]
    fn place(&self, row: *const u8) -> *const u8 {
        row.wrapping_add(self.width).wrapping_sub(LANES)
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
