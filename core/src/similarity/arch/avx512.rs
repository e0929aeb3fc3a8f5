//! Scores by AVX-512 BW and VBMI: 64 pixels at a time, for thresholds of up to 128.
//!
//! One permutation looks up 64 entries of a byte plane, one of two registers 128; the test d < threshold is the mask that
//! it is done under. Masked loads touch no byte outside a row.

use super::super::{Table, scalar};
use super::Kernels;
use crate::image::Image;
use core::arch::x86_64::*;

/// Pixels in a register.
const LANES: usize = 64;

/// So many rows are added before it is looked whether the floor can still be reached.
const ROWS_A_LOOK: usize = 4;

/// The first 128 entries of a table, low bytes and high bytes apart.
pub(super) struct Lookup {
    low: [u8; 128],
    high: [u8; 128],
    threshold: u8,
}

pub(super) fn is_available() -> bool {
    #[cfg(feature = "std")]
    return std::is_x86_feature_detected!("avx512bw") && std::is_x86_feature_detected!("avx512vbmi");
    #[cfg(not(feature = "std"))]
    return cfg!(all(target_feature = "avx512bw", target_feature = "avx512vbmi"));
}

impl Kernels for Lookup {
    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        // SAFETY: a `Lookup` exists only where AVX-512 BW and VBMI do.
        unsafe {
            if self.threshold <= 64 {
                self.sum_at_least::<false>(patch, template, floor)
            } else {
                self.sum_at_least::<true>(patch, template, floor)
            }
        }
    }
}

impl Lookup {
    /// `None` for a threshold beyond 128, or where the machine has no AVX-512 VBMI: that there is a `Lookup` is the proof
    /// that it has.
    pub(super) fn new(table: &Table, threshold: u16) -> Option<Self> {
        let threshold = u8::try_from(threshold).ok().filter(|&threshold| threshold <= 128)?;
        if !is_available() {
            return None;
        }
        let mut lookup = Self { low: [0; 128], high: [0; 128], threshold };
        for ((low, high), entry) in lookup.low.iter_mut().zip(&mut lookup.high).zip(table.entries()) {
            [*low, *high] = entry.to_le_bytes();
        }
        Some(lookup)
    }

    #[target_feature(enable = "avx512bw,avx512vbmi")]
    fn sum_at_least<const WIDE: bool>(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let (low, high) = (halves(&self.low), halves(&self.high));
        let threshold = _mm512_set1_epi8(self.threshold.cast_signed());
        let zero = _mm512_setzero_si512();
        let (mut low_sum, mut high_sum) = (zero, zero);
        let mut left = scalar::most(patch, template);
        for (row, (f, g)) in patch.rows().zip(template.rows()).enumerate() {
            left -= scalar::full(f.len().min(g.len()));
            for (f, g) in f.chunks(LANES).zip(g.chunks(LANES)) {
                let valid = u64::MAX >> (LANES - f.len().min(g.len()));
                let (f, g) = (load(f, valid), load(g, valid));
                let difference = _mm512_sub_epi8(_mm512_max_epu8(f, g), _mm512_min_epu8(f, g));
                let counts = _mm512_mask_cmplt_epu8_mask(valid, difference, threshold);
                let look_up = |plane: (__m512i, __m512i)| {
                    if WIDE {
                        _mm512_maskz_permutex2var_epi8(counts, plane.0, difference, plane.1)
                    } else {
                        _mm512_maskz_permutexvar_epi8(counts, difference, plane.0)
                    }
                };
                low_sum = _mm512_add_epi64(low_sum, _mm512_sad_epu8(look_up(low), zero));
                high_sum = _mm512_add_epi64(high_sum, _mm512_sad_epu8(look_up(high), zero));
            }
            if row % ROWS_A_LOOK == ROWS_A_LOOK - 1 && across(low_sum, high_sum) + left < floor {
                return None;
            }
        }
        Some(across(low_sum, high_sum)).filter(|&score| score >= floor)
    }
}

/// The sum of both planes, which fits a `u32` for as many pixels as a template may have.
#[inline]
#[target_feature(enable = "avx512bw")]
fn across(low: __m512i, high: __m512i) -> u32 {
    let sum = _mm512_reduce_add_epi64(_mm512_add_epi64(low, _mm512_slli_epi64(high, 8)));
    u32::try_from(sum).unwrap_or(u32::MAX)
}

/// The pixels that `valid` names, which are those of `row`; zero in the other lanes.
#[inline]
#[target_feature(enable = "avx512bw")]
fn load(row: &[u8], valid: u64) -> __m512i {
    debug_assert!(row.len() >= LANES - valid.leading_zeros() as usize);
    // SAFETY: `valid` has no bit beyond the end of `row`, and lanes without a bit are not read.
    unsafe { _mm512_maskz_loadu_epi8(valid, row.as_ptr().cast()) }
}

#[inline]
#[target_feature(enable = "avx512bw")]
fn halves(plane: &[u8; 128]) -> (__m512i, __m512i) {
    let (first, second) = plane.split_at(LANES);
    (load(first, u64::MAX), load(second, u64::MAX))
}
