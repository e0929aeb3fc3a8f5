//! AVX2: 32 pixels in a vector. The plain loops of products are compiled for AVX2: eight products in an instruction.

use super::scores::{self, SEGMENT, Shuffle, narrow, narrow_lanes};
use crate::kernels::generic::{self, Neighbours, Vector, intrinsics, scores};
use core::arch::x86_64::*;
use core::slice;

pub(crate) type Lookup = scores::Lookup<__m256i>;
type Planes<const SEGMENTS: usize> = scores::Planes<__m256i, SEGMENTS>;

scores!(Lookup, Planes, __m256i, or __m128i, "avx2", segments: 1 2 3 4 8 or 16);

impl Vector for __m256i {
    const LANES: usize = 32;
    type Total = Self;

    intrinsics! {
        unsafe fn splat(byte: u8) -> Self { _mm256_set1_epi8(byte.cast_signed()) }
        unsafe fn load(from: *const u8) -> Self { _mm256_loadu_si256(from.cast()) }
        unsafe fn nothing() -> Self { _mm256_setzero_si256() }
        unsafe fn end<const WHOLE: usize>(width: usize) -> Self {
            if WHOLE > 0 { generic::last_lanes(width) } else { narrow_lanes(width) }
        }
        unsafe fn load_end<const WHOLE: usize>(row: *const u8, width: usize) -> Self {
            if WHOLE > 0 { generic::last::<Self, WHOLE>(row, width) } else { halves(slice::from_raw_parts(row, width)) }
        }
        fn or(a: Self, b: Self) -> Self { _mm256_or_si256(a, b) }
        fn saturating_sub(a: Self, b: Self) -> Self { _mm256_subs_epu8(a, b) }
        fn minus(a: Self, b: Self) -> Self { _mm256_sub_epi8(a, b) }
        fn is_above(a: Self, b: Self) -> Self { _mm256_cmpgt_epi8(a, b) }
        fn add(total: Self, bytes: Self) -> Self { Self::add_distance(total, bytes, _mm256_setzero_si256()) }
        fn add_distance(total: Self, f: Self, g: Self) -> Self { _mm256_add_epi64(total, _mm256_sad_epu8(f, g)) }
        fn plus(a: Self, b: Self) -> Self { _mm256_add_epi64(a, b) }
        fn times_256(total: Self) -> Self { _mm256_slli_epi64(total, 8) }
        fn across(total: Self) -> u32 {
            __m128i::across(_mm_add_epi64(_mm256_castsi256_si128(total), _mm256_extracti128_si256(total, 1)))
        }
        fn keep(bytes: Self, end: Self) -> Self { _mm256_and_si256(bytes, end) }
    }
}

impl Neighbours for __m256i {
    intrinsics! {
        unsafe fn store(bytes: Self, to: *mut u8) { _mm256_storeu_si256(to.cast(), bytes) }
        fn min(a: Self, b: Self) -> Self { _mm256_min_epu8(a, b) }
        fn max(a: Self, b: Self) -> Self { _mm256_max_epu8(a, b) }
        fn raised(a: Self, b: Self) -> Self { _mm256_adds_epu8(a, b) }
        // 0x81 copies the upper half to the lower half and zeroes the upper half.
        fn shift_down<const BY: i32>(bytes: Self) -> Self {
            _mm256_alignr_epi8::<BY>(_mm256_permute2x128_si256::<0x81>(bytes, bytes), bytes)
        }
    }
}

impl Shuffle for __m256i {
    intrinsics! {
        unsafe fn segment(entries: &[u8; SEGMENT]) -> Self { _mm256_broadcastsi128_si256(__m128i::load(entries.as_ptr())) }
        unsafe fn shuffle(entries: Self, index: Self) -> Self { _mm256_shuffle_epi8(entries, index) }
        fn lowered(a: Self, b: Self) -> Self { _mm256_subs_epi8(a, b) }
        fn xor(a: Self, b: Self) -> Self { _mm256_xor_si256(a, b) }
    }
}

/// Loads a row of up to 31 pixels into the lanes that the mask [`narrow_lanes`] marks.
///
/// # Safety
/// The processor has AVX2.
#[inline(always)]
unsafe fn halves(row: &[u8]) -> __m256i {
    // SAFETY: the processor has AVX2; 16 bytes are loaded only if the row has them.
    unsafe {
        match (row.first_chunk::<16>(), row.last_chunk::<16>()) {
            (Some(first), Some(last)) => _mm256_set_m128i(__m128i::load(last.as_ptr()), __m128i::load(first.as_ptr())),
            _ => _mm256_zextsi128_si256(narrow(row)),
        }
    }
}

pub(crate) mod products {
    use crate::kernels::layout::{Layout, Packed};
    use crate::kernels::plain::products as plain;
    use core::ops::Range;

    pub(crate) use plain::{GATHER_PIECES, TAKES_ROWS_OF_CELLS};

    /// # Safety
    /// The processor has AVX2.
    #[target_feature(enable = "avx2")]
    pub(crate) fn responses<const N: usize>(
        pieces: Range<usize>,
        _: &mut Packed,
        _: &mut [i32],
        cells: &[i8],
        layout: Layout,
        weights: &[i16],
        out: &mut [[i32; N]],
    ) {
        plain::responses_inline(pieces, cells, layout, weights, out);
    }

    /// # Safety
    /// The processor has AVX2.
    #[target_feature(enable = "avx2")]
    pub(crate) fn gather<const N: usize>(
        pieces: Range<usize>,
        _: &mut Packed,
        _: &mut [i32],
        cells: &[i8],
        layout: Layout,
        errors: &[[i16; N]],
        sums: &mut [i32],
    ) {
        plain::gather_inline(pieces, cells, layout, errors, sums);
    }
}

#[cfg(feature = "refiner")]
pub(crate) mod dense {
    use crate::kernels::plain::dense as plain;

    /// # Safety
    /// The processor has AVX2.
    #[target_feature(enable = "avx2")]
    pub(crate) fn outputs(layer: plain::Layer<'_>, patches: &[i8], _: &mut [i8], out: &mut [i8]) {
        plain::outputs_inline(layer, patches, out);
    }
}
