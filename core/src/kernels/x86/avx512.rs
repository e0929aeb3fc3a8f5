//! Scores by AVX-512 BW, VBMI and VNNI: 64 pixels at a time, for thresholds of up to 128.
//!
//! 1. One permutation looks up 64 entries of a byte plane, one of two registers 128; the test d < threshold is the mask
//!    that it is done under.
//! 2. `vpdpbusd` with ones adds bytes to four-byte lanes in one step.
//! 3. Masked loads touch no byte outside a row, so the end of a row is a register like all others.

use super::avx2::scores as avx2;
use crate::image::Image;
use crate::kernels::cut_table::CutTable;
use crate::kernels::generic::{self, LookUp, Vector, by_width, intrinsics, scores};
use crate::kernels::rows::Rows;
use crate::kernels::scores::Scores;
use core::arch::x86_64::*;

impl Vector for __m512i {
    const LANES: usize = 64;
    /// In 16 parts; those of a distance are the even ones, and the others zero.
    type Total = Self;
    /// A bit for each lane.
    type End = u64;

    intrinsics! {
        fn splat(byte: u8) -> Self { _mm512_set1_epi8(byte.cast_signed()) }
        fn load(from: *const u8) -> Self { _mm512_loadu_epi8(from.cast()) }
        fn or(a: Self, b: Self) -> Self { _mm512_or_si512(a, b) }
        fn beyond(a: Self, b: Self) -> Self { _mm512_subs_epu8(a, b) }
        fn minus(a: Self, b: Self) -> Self { _mm512_sub_epi8(a, b) }
        fn at_most(a: Self, b: Self) -> Self { _mm512_movm_epi8(_mm512_cmple_epu8_mask(a, b)) }
        fn nothing() -> Self { _mm512_setzero_si512() }
        fn add(total: Self, bytes: Self) -> Self { _mm512_dpbusd_epi32(total, bytes, _mm512_set1_epi8(1)) }
        fn add_distance(total: Self, f: Self, g: Self) -> Self { _mm512_add_epi64(total, _mm512_sad_epu8(f, g)) }
        fn plus(a: Self, b: Self) -> Self { _mm512_add_epi32(a, b) }
        fn times_256(total: Self) -> Self { _mm512_slli_epi32(total, 8) }
        fn across(total: Self) -> u32 { _mm512_reduce_add_epi32(total).cast_unsigned() }
        fn end<const WHOLE: usize>(width: usize) -> u64 { (1 << (width % Self::LANES)) - 1 }
        fn load_end<const WHOLE: usize>(row: *const u8, width: usize, end: u64) -> Self {
            _mm512_maskz_loadu_epi8(end, row.wrapping_add(width - width % Self::LANES).cast())
        }
        fn keep(bytes: Self, end: u64) -> Self { _mm512_maskz_mov_epi8(end, bytes) }
        fn keep_loaded(bytes: Self, _end: u64) -> Self { bytes }
    }
}

/// The first 128 entries of a table, low bytes and high bytes apart.
pub(crate) struct Lookup {
    low: [u8; 128],
    high: [u8; 128],
    /// Of 64 entries: 1 or 2.
    segments: usize,
    threshold: u8,
    /// The largest difference that counts, if there is one.
    last: Option<u8>,
}

pub(crate) fn is_available() -> bool {
    #[cfg(feature = "std")]
    return std::is_x86_feature_detected!("avx512bw")
        && std::is_x86_feature_detected!("avx512vbmi")
        && std::is_x86_feature_detected!("avx512vnni");
    #[cfg(not(feature = "std"))]
    return cfg!(all(target_feature = "avx512bw", target_feature = "avx512vbmi", target_feature = "avx512vnni"));
}

scores!(Lookup, Planes, __m512i, "avx512bw,avx512vbmi,avx512vnni", segments: 1 or 2);

impl Lookup {
    /// `None` for a threshold beyond 128, or where the machine has not all that is needed: that there is a `Lookup` is the
    /// proof that it has.
    pub(crate) fn new(table: &CutTable) -> Option<Self> {
        let threshold = u8::try_from(table.threshold()).ok().filter(|&threshold| threshold <= 128)?;
        if !is_available() {
            return None;
        }
        let segments = if threshold <= 64 { 1 } else { 2 };
        let mut lookup = Self { low: [0; 128], high: [0; 128], segments, threshold, last: threshold.checked_sub(1) };
        for ((low, high), entry) in lookup.low.iter_mut().zip(&mut lookup.high).zip(table.entries()) {
            [*low, *high] = entry.to_le_bytes();
        }
        Some(lookup)
    }
}

/// By the narrower registers: a row of ranges is one or two of the wide ones and a part, which would cost as much.
#[target_feature(enable = "avx2")]
fn spread(rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
    avx2::spread(rows, low, high);
}

/// The entries of both byte planes; of the second halves nothing is looked up for one segment.
struct Planes<const SEGMENTS: usize> {
    low: [__m512i; 2],
    high: [__m512i; 2],
    threshold: __m512i,
}

impl<const SEGMENTS: usize> Planes<SEGMENTS> {
    #[inline]
    #[target_feature(enable = "avx512bw")]
    fn of(lookup: &Lookup) -> Self {
        // SAFETY: these are the two halves of 128 readable bytes, and the instructions are there.
        let [low, high] = unsafe {
            let (low, high) = (lookup.low.as_ptr(), lookup.high.as_ptr());
            [[__m512i::load(low), __m512i::load(low.add(64))], [__m512i::load(high), __m512i::load(high.add(64))]]
        };
        let threshold = _mm512_set1_epi8(lookup.threshold.cast_signed());
        Self { low, high, threshold }
    }
}

impl<const SEGMENTS: usize> LookUp for Planes<SEGMENTS> {
    type Vector = __m512i;

    #[inline(always)]
    unsafe fn look_up(&self, difference: __m512i) -> (__m512i, __m512i) {
        // SAFETY: as the caller has seen to.
        unsafe {
            let counts = _mm512_cmplt_epu8_mask(difference, self.threshold);
            let ([low, next_low], [high, next_high]) = (self.low, self.high);
            if SEGMENTS > 1 {
                (
                    _mm512_maskz_permutex2var_epi8(counts, low, difference, next_low),
                    _mm512_maskz_permutex2var_epi8(counts, high, difference, next_high),
                )
            } else {
                (
                    _mm512_maskz_permutexvar_epi8(counts, difference, low),
                    _mm512_maskz_permutexvar_epi8(counts, difference, high),
                )
            }
        }
    }
}
