//! Scores by AVX2: 32 pixels at a time, for any threshold.
//!
//! 1. The table's two bytes are two planes of 256 entries; a shuffle looks up 16 of them, so the live entries are gone
//!    through in segments of 16: one for a threshold of up to 16, which is the usual case.
//! 2. Entries at the threshold and beyond are stored as zero, so the lookup is the test d < threshold, too.
//! 3. `psadbw` against zero adds eight bytes exactly; a plane's sum over 65537 pixels is below 2^25.

use super::super::{Table, scalar};
use super::Kernels;
use crate::image::Image;
use core::arch::x86_64::*;

/// Pixels in a register.
const LANES: usize = 32;

/// So many rows are added before it is looked whether the floor can still be reached.
const ROWS_A_LOOK: usize = 4;

/// The live part of a table in segments of 16 entries, low bytes and high bytes apart.
pub(super) struct Lookup {
    low: [[u8; 16]; 16],
    high: [[u8; 16]; 16],
    segments: usize,
}

pub(super) fn is_available() -> bool {
    #[cfg(feature = "std")]
    return std::is_x86_feature_detected!("avx2");
    #[cfg(not(feature = "std"))]
    return cfg!(target_feature = "avx2");
}

impl Kernels for Lookup {
    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        // SAFETY: a `Lookup` exists only where AVX2 does.
        unsafe { self.sum_at_least(patch, template, floor) }
    }
}

impl Lookup {
    /// `None` where the machine has no AVX2: that there is a `Lookup` is the proof that it has.
    pub(super) fn new(table: &Table, threshold: u16) -> Option<Self> {
        if !is_available() {
            return None;
        }
        let mut lookup =
            Self { low: [[0; 16]; 16], high: [[0; 16]; 16], segments: usize::from(threshold).div_ceil(16) };
        let places = lookup.low.as_flattened_mut().iter_mut().zip(lookup.high.as_flattened_mut());
        for ((low, high), entry) in places.zip(table.entries()).take(usize::from(threshold)) {
            [*low, *high] = entry.to_le_bytes();
        }
        Some(lookup)
    }

    #[target_feature(enable = "avx2")]
    fn sum_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let width = usize::from(patch.width().min(template.width()));
        let mut low = _mm256_setzero_si256();
        let mut high = _mm256_setzero_si256();
        let mut left = scalar::most(patch, template);
        let of_a_row = scalar::full(width);
        for (row, (f, g)) in patch.rows_and_rest().zip(template.rows_and_rest()).enumerate() {
            let mut at = 0;
            while at < width {
                let planes = self.similarities(load(f, at), load(g, at));
                let valid = first_lanes(width - at);
                low = _mm256_add_epi64(low, total(_mm256_and_si256(planes.0, valid)));
                high = _mm256_add_epi64(high, total(_mm256_and_si256(planes.1, valid)));
                at += LANES;
            }
            left -= of_a_row;
            if row % ROWS_A_LOOK == ROWS_A_LOOK - 1 && across(low) + (across(high) << 8) + left < floor {
                return None;
            }
        }
        Some(across(low) + (across(high) << 8)).filter(|&score| score >= floor)
    }

    /// The similarities of 32 pairs of pixels, low bytes and high bytes.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn similarities(&self, f: __m256i, g: __m256i) -> (__m256i, __m256i) {
        let difference = _mm256_sub_epi8(_mm256_max_epu8(f, g), _mm256_min_epu8(f, g));
        let mut planes = (_mm256_setzero_si256(), _mm256_setzero_si256());
        let mut first = _mm256_setzero_si256();
        for (low, high) in self.low.iter().zip(&self.high).take(self.segments) {
            // The index within the segment, with the top bit set if it is in another one: the shuffle then gives zero.
            let index = _mm256_adds_epu8(_mm256_sub_epi8(difference, first), _mm256_set1_epi8(0x70));
            planes.0 = _mm256_or_si256(planes.0, _mm256_shuffle_epi8(broadcast(low), index));
            planes.1 = _mm256_or_si256(planes.1, _mm256_shuffle_epi8(broadcast(high), index));
            first = _mm256_add_epi8(first, _mm256_set1_epi8(16));
        }
        planes
    }
}

/// 32 pixels of `row` from `at` on; what lies beyond the end of the slice is zero.
#[inline]
#[target_feature(enable = "avx2")]
fn load(row: &[u8], at: usize) -> __m256i {
    let rest = row.get(at..).unwrap_or_default();
    if let Some(pixels) = rest.first_chunk::<LANES>() {
        // SAFETY: `pixels` is 32 readable bytes; the load needs no alignment.
        return unsafe { _mm256_loadu_si256(pixels.as_ptr().cast()) };
    }
    let mut pixels = [0; LANES];
    for (to, &from) in pixels.iter_mut().zip(rest) {
        *to = from;
    }
    // SAFETY: as above.
    unsafe { _mm256_loadu_si256(pixels.as_ptr().cast()) }
}

#[inline]
#[target_feature(enable = "avx2")]
fn broadcast(segment: &[u8; 16]) -> __m256i {
    // SAFETY: `segment` is 16 readable bytes; the load needs no alignment.
    _mm256_broadcastsi128_si256(unsafe { _mm_loadu_si128(segment.as_ptr().cast()) })
}

/// All bits of the first `count` lanes.
#[inline]
#[target_feature(enable = "avx2")]
fn first_lanes(count: usize) -> __m256i {
    const LANE: [u8; LANES] = *b"\x00\x01\x02\x03\x04\x05\x06\x07\x08\x09\x0a\x0b\x0c\x0d\x0e\x0f\
        \x10\x11\x12\x13\x14\x15\x16\x17\x18\x19\x1a\x1b\x1c\x1d\x1e\x1f";
    // SAFETY: `LANE` is 32 readable bytes; the load needs no alignment.
    let lane = unsafe { _mm256_loadu_si256(LANE.as_ptr().cast()) };
    _mm256_cmpgt_epi8(_mm256_set1_epi8(i8::try_from(count).unwrap_or(i8::MAX)), lane)
}

/// The sum of the bytes, in four parts.
#[inline]
#[target_feature(enable = "avx2")]
fn total(bytes: __m256i) -> __m256i {
    _mm256_sad_epu8(bytes, _mm256_setzero_si256())
}

/// The sum of the four parts, which fits a `u32` for as many pixels as a template may have.
#[inline]
#[target_feature(enable = "avx2")]
fn across(parts: __m256i) -> u32 {
    let two = _mm_add_epi64(_mm256_castsi256_si128(parts), _mm256_extracti128_si256(parts, 1));
    let one = _mm_add_epi64(two, _mm_unpackhi_epi64(two, two));
    _mm_cvtsi128_si32(one).cast_unsigned()
}
