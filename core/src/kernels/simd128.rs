//! SIMD128, the vectors of WebAssembly: 16 pixels in a vector. A score takes two steps:
//!
//! 1. A swizzle looks up 16 bytes, or zero for a larger index. Entries from the threshold on are zero, so the lookup is
//!    also the test d < threshold. Thresholds up to 16 (usual) take one lookup for each plane, others up to 16.
//! 2. Bytes are added in pairs, and the pairs to four-byte lanes.

pub(crate) mod products;

use crate::kernels::generic::{self, LookUp, Neighbours, Vector, intrinsics, scores};
use core::arch::wasm32::*;

#[cfg(feature = "refiner")]
pub(crate) use crate::kernels::plain::dense;

impl Vector for v128 {
    const LANES: usize = 16;
    type Total = Self;

    intrinsics! {
        unsafe fn splat(byte: u8) -> Self { u8x16_splat(byte) }
        unsafe fn load(from: *const u8) -> Self { v128_load(from.cast()) }
        unsafe fn nothing() -> Self { u32x4_splat(0) }
        unsafe fn end<const WHOLE: usize>(width: usize) -> Self { generic::last_lanes(width) }
        unsafe fn load_end<const WHOLE: usize>(row: *const u8, width: usize) -> Self {
            generic::last::<Self, WHOLE>(row, width)
        }
        fn or(a: Self, b: Self) -> Self { v128_or(a, b) }
        fn saturating_sub(a: Self, b: Self) -> Self { u8x16_sub_sat(a, b) }
        fn minus(a: Self, b: Self) -> Self { u8x16_sub(a, b) }
        fn is_above(a: Self, b: Self) -> Self { i8x16_gt(a, b) }
        fn add(total: Self, bytes: Self) -> Self {
            u32x4_add(total, u32x4_extadd_pairwise_u16x8(u16x8_extadd_pairwise_u8x16(bytes)))
        }
        fn add_distance(total: Self, f: Self, g: Self) -> Self { Self::add(total, Self::difference(f, g)) }
        fn plus(a: Self, b: Self) -> Self { u32x4_add(a, b) }
        fn times_256(total: Self) -> Self { u32x4_shl(total, 8) }
        fn across(total: Self) -> u32 { across(total) }
        fn keep(bytes: Self, end: Self) -> Self { v128_and(bytes, end) }
    }
}

impl Neighbours for v128 {
    intrinsics! {
        unsafe fn store(bytes: Self, to: *mut u8) { v128_store(to.cast(), bytes) }
        fn min(a: Self, b: Self) -> Self { u8x16_min(a, b) }
        fn max(a: Self, b: Self) -> Self { u8x16_max(a, b) }
        fn raised(a: Self, b: Self) -> Self { u8x16_add_sat(a, b) }
        fn shift_down<const BY: i32>(bytes: Self) -> Self { shift_down::<BY>(bytes) }
    }
}

#[inline(always)]
fn across(total: v128) -> u32 {
    let halves = u32x4_add(total, u32x4_shuffle::<2, 3, 0, 1>(total, total));
    u32x4_extract_lane::<0>(halves) + u32x4_extract_lane::<1>(halves)
}

/// Shifts the bytes down by `BY` lanes, 1 or 2; zeroes fill the top. The indices of a shuffle must be literals.
#[inline(always)]
fn shift_down<const BY: i32>(bytes: v128) -> v128 {
    const { assert!(BY == 1 || BY == 2) };
    let zero = u8x16_splat(0);
    match BY {
        1 => u8x16_shuffle::<1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16>(bytes, zero),
        _ => u8x16_shuffle::<2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17>(bytes, zero),
    }
}

const SEGMENT: usize = 16;

/// Value of `SEGMENTS` for two or more segments. All counts above one share a loop, because separate loops would make
/// the module a third larger.
const MANY: usize = 16;

pub(crate) type Lookup = generic::Lookup<v128, SEGMENT, MANY>;

scores!(Lookup, Planes, v128, "simd128", segments: 1 or 16);

/// The table, low and high bytes of its entries apart: the first `SEGMENTS` segments of both, or all in use if
/// [`MANY`].
struct Planes<'a, const SEGMENTS: usize> {
    first: (v128, v128),
    /// The segments after the first.
    low: &'a [[u8; SEGMENT]],
    high: &'a [[u8; SEGMENT]],
}

impl<'a, const SEGMENTS: usize> Planes<'a, SEGMENTS> {
    /// # Safety
    /// The machine has SIMD128.
    #[inline]
    #[target_feature(enable = "simd128")]
    unsafe fn of(lookup: &'a Lookup) -> Self {
        let Lookup { low: [low, lows @ ..], high: [high, highs @ ..], segments, .. } = lookup;
        let others = if SEGMENTS == MANY { segments.saturating_sub(1) } else { SEGMENTS - 1 };
        let others = |segments: &'a [[u8; SEGMENT]; MANY - 1]| segments.get(..others).unwrap_or(segments);
        Self { first: (segment(low), segment(high)), low: others(lows), high: others(highs) }
    }
}

#[inline(always)]
fn segment(entries: &[u8; SEGMENT]) -> v128 {
    // SAFETY: the segment has 16 bytes, and a load needs no alignment.
    unsafe { v128_load(entries.as_ptr().cast()) }
}

impl<const SEGMENTS: usize> LookUp for Planes<'_, SEGMENTS> {
    type Vector = v128;

    #[inline(always)]
    fn look_up(&self, difference: v128) -> (v128, v128) {
        let mut index = difference;
        let mut planes = (u8x16_swizzle(self.first.0, index), u8x16_swizzle(self.first.1, index));
        for (low, high) in self.low.iter().zip(self.high) {
            // An index outside of this segment is 16 or more (perhaps by wrapping), and gives zero.
            index = u8x16_sub(index, u8x16_splat(16));
            planes.0 = v128_or(planes.0, u8x16_swizzle(segment(low), index));
            planes.1 = v128_or(planes.1, u8x16_swizzle(segment(high), index));
        }
        planes
    }
}
