//! Scores by AVX-512 BW, VBMI and VNNI: 64 pixels at a time, for thresholds of up to 128.
//!
//! 1. One permutation looks up 64 entries of a byte plane, one of two registers 128; the test d < threshold is the mask
//!    that it is done under.
//! 2. `vpdpbusd` with ones adds bytes to four-byte lanes in one step; a plane's sum over 65537 pixels is below 2^25.
//! 3. Masked loads touch no byte outside a row, so the end of a row is a register like all others.

use super::super::{CutTable, Table};
use super::{Kernels, avx2, rows::Rows};
use crate::image::Image;
use core::arch::x86_64::*;

/// Pixels in a register.
const LANES: usize = 64;

/// So many rows are added before it is looked whether the end is already certain.
const ROWS_A_LOOK: usize = 8;

/// The first 128 entries of a table, low bytes and high bytes apart.
pub(super) struct Lookup {
    low: [u8; 128],
    high: [u8; 128],
    threshold: u8,
}

pub(super) fn is_available() -> bool {
    #[cfg(feature = "std")]
    return std::is_x86_feature_detected!("avx512bw")
        && std::is_x86_feature_detected!("avx512vbmi")
        && std::is_x86_feature_detected!("avx512vnni");
    #[cfg(not(feature = "std"))]
    return cfg!(all(target_feature = "avx512bw", target_feature = "avx512vbmi", target_feature = "avx512vnni"));
}

impl Kernels for Lookup {
    #[inline(always)] // what `Rows` takes of the pictures is then in registers; through memory it waits for halves of words
    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        self.sum(&Rows::of(patch, template), floor)
    }

    #[inline(always)]
    fn score_between_at_least(&self, low: Image<'_>, high: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let rows = Rows::between(low, high, template);
        // SAFETY: a `Lookup` exists only where these instructions do, and the pictures are borrowed.
        unsafe {
            match rows.width / LANES {
                0 => self.count_at_least::<0>(&rows, floor),
                1 => self.count_at_least::<1>(&rows, floor),
                _ => self.count_at_least::<ANY>(&rows, floor),
            }
        }
    }

    #[inline(always)]
    fn spread(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
        // By the narrower registers: a row of ranges is one or two of the wide ones and a part, which would cost as much.
        // SAFETY: a `Lookup` exists only where these instructions do, which are none without AVX2.
        unsafe { avx2::spread(rows, low, high) }
    }

    #[inline(always)]
    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
        let rows = Rows::of(patch, template);
        // SAFETY: a `Lookup` exists only where these instructions do, and both pictures are borrowed.
        unsafe {
            match rows.width / LANES {
                0 => distance::<0>(&rows, enough),
                1 => distance::<1>(&rows, enough),
                _ => distance::<ANY>(&rows, enough),
            }
        }
    }
}

impl Lookup {
    /// `None` for a threshold beyond 128, or where the machine has not all that is needed: that there is a `Lookup` is the
    /// proof that it has.
    pub(super) fn new(table: &CutTable) -> Option<Self> {
        let threshold = u8::try_from(table.threshold()).ok().filter(|&threshold| threshold <= 128)?;
        if !is_available() {
            return None;
        }
        let mut lookup = Self { low: [0; 128], high: [0; 128], threshold };
        for ((low, high), entry) in lookup.low.iter_mut().zip(&mut lookup.high).zip(table.entries()) {
            [*low, *high] = entry.to_le_bytes();
        }
        Some(lookup)
    }

    /// The score of rows whose pictures are borrowed.
    #[inline]
    fn sum(&self, rows: &Rows, floor: u32) -> Option<u32> {
        // SAFETY: a `Lookup` exists only where these instructions do, and the pictures are borrowed.
        unsafe {
            match (self.threshold <= 64, rows.width / LANES) {
                (true, 0) => self.sum_at_least::<false, 0>(rows, floor),
                (true, 1) => self.sum_at_least::<false, 1>(rows, floor),
                (true, _) => self.sum_at_least::<false, ANY>(rows, floor),
                (false, _) => self.sum_at_least::<true, ANY>(rows, floor),
            }
        }
    }

    /// A bound of a score: every pixel that counts is taken to be fully similar. It reads three pictures for about the price
    /// that the score of two has.
    ///
    /// # Safety
    /// The pictures that `rows` were made of are borrowed.
    #[target_feature(enable = "avx512bw,popcnt")]
    unsafe fn count_at_least<const WHOLE: usize>(&self, rows: &Rows, floor: u32) -> Option<u32> {
        let whole = if WHOLE == ANY { rows.width / LANES } else { WHOLE };
        let end = lanes(rows.width % LANES);
        let threshold = _mm512_set1_epi8(self.threshold.cast_signed());
        let count = |difference, valid| _mm512_mask_cmplt_epu8_mask(valid, difference, threshold).count_ones();
        let needed = Rows::pixels_of(floor);
        let mut counted = 0;
        let mut y = 0;
        while y < rows.height {
            let ((f, g), h) = (rows.row(y), rows.high_row(y));
            let mut at = 0;
            while at < whole * LANES {
                // SAFETY: at + 64 is at most the width.
                let [f, h, g] = unsafe { [f, h, g].map(|row| load(row.wrapping_add(at), u64::MAX)) };
                counted += count(outside(f, h, g), u64::MAX);
                at += LANES;
            }
            if end > 0 {
                // SAFETY: `end` has no lane that is not below the width.
                let [f, h, g] = unsafe { [f, h, g].map(|row| load(row.wrapping_add(at), end)) };
                counted += count(outside(f, h, g), end);
            }
            y += 1;
            if (y.is_multiple_of(ROWS_A_LOOK) || y == rows.height) && counted + rows.pixels_after(y) < needed {
                return None;
            }
        }
        Some(counted * u32::from(Table::ONE))
    }

    /// `WIDE`: for thresholds beyond 64. `WHOLE` is the number of registers that a row fills, or [`ANY`].
    ///
    /// # Safety
    /// The pictures that `rows` were made of are borrowed.
    #[target_feature(enable = "avx512bw,avx512vbmi,avx512vnni")]
    unsafe fn sum_at_least<const WIDE: bool, const WHOLE: usize>(&self, rows: &Rows, floor: u32) -> Option<u32> {
        let walk = Walk {
            rows,
            whole: if WHOLE == ANY { rows.width / LANES } else { WHOLE },
            end: lanes(rows.width % LANES),
            low: Plane::of(&self.low),
            high: Plane::of(&self.high),
            threshold: _mm512_set1_epi8(self.threshold.cast_signed()),
        };
        // Two sums, so that a row need not wait for the one before it.
        let (mut even, mut odd) = (Sums::zero(), Sums::zero());
        let mut y = 0;
        while y < rows.height {
            walk.add_row::<WIDE>(y, &mut even);
            if y + 1 < rows.height {
                walk.add_row::<WIDE>(y + 1, &mut odd);
                let left = rows.full_after(y + 2);
                if left < floor && y % ROWS_A_LOOK == ROWS_A_LOOK - 2 && score(&even, &odd) + left < floor {
                    return None;
                }
            }
            y += 2;
        }
        Some(score(&even, &odd)).filter(|&score| score >= floor)
    }
}

/// Whatever number of registers a row fills.
const ANY: usize = usize::MAX;

/// A [`Lookup`] in registers, and what it is to look up.
struct Walk<'a> {
    rows: &'a Rows,
    whole: usize,
    end: u64,
    low: Plane,
    high: Plane,
    threshold: __m512i,
}

impl Walk<'_> {
    /// Adds the similarities of row `y`, which is below the height.
    #[inline]
    #[target_feature(enable = "avx512bw,avx512vbmi,avx512vnni")]
    fn add_row<const WIDE: bool>(&self, y: usize, sums: &mut Sums) {
        let (f, g) = self.rows.row(y);
        let mut at = 0;
        while at < self.whole * LANES {
            // SAFETY: at + 64 is at most the width.
            let (f, g) = unsafe { (load(f.wrapping_add(at), u64::MAX), load(g.wrapping_add(at), u64::MAX)) };
            self.add::<WIDE>(outside(f, f, g), u64::MAX, sums);
            at += LANES;
        }
        if self.end > 0 {
            // SAFETY: `end` has no lane that is not below the width.
            let (f, g) = unsafe { (load(f.wrapping_add(at), self.end), load(g.wrapping_add(at), self.end)) };
            self.add::<WIDE>(outside(f, f, g), self.end, sums);
        }
    }

    /// Adds the similarities in the lanes of `valid`.
    #[inline]
    #[target_feature(enable = "avx512bw,avx512vbmi,avx512vnni")]
    fn add<const WIDE: bool>(&self, difference: __m512i, valid: u64, sums: &mut Sums) {
        let counts = _mm512_mask_cmplt_epu8_mask(valid, difference, self.threshold);
        let (low, high) = (self.low.look_up::<WIDE>(counts, difference), self.high.look_up::<WIDE>(counts, difference));
        sums.low = _mm512_dpbusd_epi32(sums.low, low, _mm512_set1_epi8(1));
        sums.high = _mm512_dpbusd_epi32(sums.high, high, _mm512_set1_epi8(1));
    }
}

/// 128 entries of one byte plane of a table.
struct Plane {
    first: __m512i,
    second: __m512i,
}

impl Plane {
    #[inline]
    #[target_feature(enable = "avx512bw")]
    fn of(entries: &[u8; 128]) -> Self {
        // SAFETY: these are the two halves of 128 readable bytes.
        unsafe { Self { first: load(entries.as_ptr(), u64::MAX), second: load(entries.as_ptr().add(LANES), u64::MAX) } }
    }

    /// The bytes of those differences that count; of others zero.
    #[inline]
    #[target_feature(enable = "avx512vbmi")]
    fn look_up<const WIDE: bool>(&self, counts: u64, difference: __m512i) -> __m512i {
        if WIDE {
            _mm512_maskz_permutex2var_epi8(counts, self.first, difference, self.second)
        } else {
            _mm512_maskz_permutexvar_epi8(counts, difference, self.first)
        }
    }
}

/// The sums of the two byte planes, in 16 parts each.
struct Sums {
    low: __m512i,
    high: __m512i,
}

impl Sums {
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn zero() -> Self {
        Self { low: _mm512_setzero_si512(), high: _mm512_setzero_si512() }
    }
}

/// The sum of the similarities, which fits a `u32` for as many pixels as a template may have.
#[inline]
#[target_feature(enable = "avx512bw")]
fn score(even: &Sums, odd: &Sums) -> u32 {
    let low = _mm512_add_epi32(even.low, odd.low);
    let high = _mm512_slli_epi32(_mm512_add_epi32(even.high, odd.high), 8);
    _mm512_reduce_add_epi32(_mm512_add_epi32(low, high)).cast_unsigned()
}

/// See [`scalar::distance`](super::super::scalar::distance); `WHOLE` is as for [`Lookup::sum_at_least`].
///
/// # Safety
/// The pictures that `rows` were made of are borrowed.
#[target_feature(enable = "avx512bw")]
unsafe fn distance<const WHOLE: usize>(rows: &Rows, enough: u32) -> u32 {
    let whole = if WHOLE == ANY { rows.width / LANES } else { WHOLE };
    let end = lanes(rows.width % LANES);
    let mut sum = _mm512_setzero_si512();
    for y in 0..rows.height {
        let (f, g) = rows.row(y);
        let mut at = 0;
        while at < whole * LANES {
            // SAFETY: at + 64 is at most the width.
            let (f, g) = unsafe { (load(f.wrapping_add(at), u64::MAX), load(g.wrapping_add(at), u64::MAX)) };
            sum = _mm512_add_epi64(sum, _mm512_sad_epu8(f, g));
            at += LANES;
        }
        if end > 0 {
            // SAFETY: `end` has no lane that is not below the width.
            let (f, g) = unsafe { (load(f.wrapping_add(at), end), load(g.wrapping_add(at), end)) };
            sum = _mm512_add_epi64(sum, _mm512_sad_epu8(f, g));
        }
        if y % ROWS_A_LOOK == ROWS_A_LOOK - 1 && across(sum) > enough {
            break;
        }
    }
    across(sum)
}

/// By how much 64 pixels lie outside their ranges: |f - g| where a range is one pixel.
#[inline]
#[target_feature(enable = "avx512bw")]
fn outside(low: __m512i, high: __m512i, g: __m512i) -> __m512i {
    _mm512_or_si512(_mm512_subs_epu8(low, g), _mm512_subs_epu8(g, high))
}

/// The first `count` lanes, 64 at most.
#[inline]
fn lanes(count: usize) -> u64 {
    if count < LANES { (1 << count) - 1 } else { u64::MAX }
}

/// The pixels in the lanes of `valid`; zero in the others, which are not read.
///
/// # Safety
/// Of the lanes of `valid` there are readable bytes.
#[inline]
#[target_feature(enable = "avx512bw")]
unsafe fn load(pixels: *const u8, valid: u64) -> __m512i {
    // SAFETY: the caller has seen to it; the load needs no alignment.
    unsafe { _mm512_maskz_loadu_epi8(valid, pixels.cast()) }
}

/// The sum of the eight parts.
#[inline]
#[target_feature(enable = "avx512bw")]
fn across(parts: __m512i) -> u32 {
    // The upper half of every part is zero.
    _mm512_reduce_add_epi32(parts).cast_unsigned()
}
