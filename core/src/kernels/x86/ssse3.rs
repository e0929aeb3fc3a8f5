//! SSSE3 (Intel since 2006, AMD since 2011): 16 pixels in a vector. The compiler vectorizes all other kernels by SSE2.

use super::scores::{self, SEGMENT, Shuffle, narrow, narrow_lanes};
use crate::kernels::generic::{self, Neighbours, Vector, intrinsics, scores};
use core::arch::x86_64::*;
use core::slice;

#[cfg(feature = "refiner")]
pub(crate) use crate::kernels::plain::dense;
pub(crate) use crate::kernels::plain::products;

pub(crate) type Lookup = scores::Lookup<__m128i>;
type Planes<const SEGMENTS: usize> = scores::Planes<__m128i, SEGMENTS>;

scores!(Lookup, Planes, __m128i, "ssse3", segments: 1 2 3 4 8 or 16);

impl Vector for __m128i {
    const LANES: usize = 16;
    type Total = Self;

    intrinsics! {
        unsafe fn splat(byte: u8) -> Self { _mm_set1_epi8(byte.cast_signed()) }
        unsafe fn load(from: *const u8) -> Self { _mm_loadu_si128(from.cast()) }
        unsafe fn nothing() -> Self { _mm_setzero_si128() }
        unsafe fn end<const WHOLE: usize>(width: usize) -> Self {
            if WHOLE > 0 { generic::last_lanes(width) } else { narrow_lanes(width) }
        }
        unsafe fn load_end<const WHOLE: usize>(row: *const u8, width: usize) -> Self {
            if WHOLE > 0 { generic::last::<Self, WHOLE>(row, width) } else { narrow(slice::from_raw_parts(row, width)) }
        }
        fn or(a: Self, b: Self) -> Self { _mm_or_si128(a, b) }
        fn saturating_sub(a: Self, b: Self) -> Self { _mm_subs_epu8(a, b) }
        fn minus(a: Self, b: Self) -> Self { _mm_sub_epi8(a, b) }
        fn is_above(a: Self, b: Self) -> Self { _mm_cmpgt_epi8(a, b) }
        fn add(total: Self, bytes: Self) -> Self { Self::add_distance(total, bytes, _mm_setzero_si128()) }
        fn add_distance(total: Self, f: Self, g: Self) -> Self { _mm_add_epi64(total, _mm_sad_epu8(f, g)) }
        fn plus(a: Self, b: Self) -> Self { _mm_add_epi64(a, b) }
        fn times_256(total: Self) -> Self { _mm_slli_epi64(total, 8) }
        fn across(total: Self) -> u32 {
            _mm_cvtsi128_si32(_mm_add_epi64(total, _mm_unpackhi_epi64(total, total))).cast_unsigned()
        }
        fn keep(bytes: Self, end: Self) -> Self { _mm_and_si128(bytes, end) }
    }
}

impl Neighbours for __m128i {
    intrinsics! {
        unsafe fn store(bytes: Self, to: *mut u8) { _mm_storeu_si128(to.cast(), bytes) }
        fn min(a: Self, b: Self) -> Self { _mm_min_epu8(a, b) }
        fn max(a: Self, b: Self) -> Self { _mm_max_epu8(a, b) }
        fn raised(a: Self, b: Self) -> Self { _mm_adds_epu8(a, b) }
        fn shift_down<const BY: i32>(bytes: Self) -> Self { _mm_srli_si128::<BY>(bytes) }
    }
}

impl Shuffle for __m128i {
    intrinsics! {
        unsafe fn segment(entries: &[u8; SEGMENT]) -> Self { Self::load(entries.as_ptr()) }
        unsafe fn shuffle(entries: Self, index: Self) -> Self { _mm_shuffle_epi8(entries, index) }
        fn lowered(a: Self, b: Self) -> Self { _mm_subs_epi8(a, b) }
        fn xor(a: Self, b: Self) -> Self { _mm_xor_si128(a, b) }
    }
}
