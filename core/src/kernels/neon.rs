//! NEON, which every AArch64 processor with floating point has: 16 pixels in a vector. The compiler vectorizes the
//! plain loops of all kernels but scores. A score takes two steps:
//!
//! 1. `tbl` looks up 64 bytes and gives zero for a larger index. Entries from the threshold on are zero, so the lookup
//!    is also the test d < threshold. Thresholds above 64 take up to four lookups.
//! 2. Bytes are added in pairs, and the pairs to four-byte lanes.

use crate::kernels::generic::{self, LookUp, Neighbours, Vector, intrinsics, scores};
use core::arch::aarch64::*;

#[cfg(feature = "refiner")]
pub(crate) use crate::kernels::plain::dense;
pub(crate) use crate::kernels::plain::products;

impl Vector for uint8x16_t {
    const LANES: usize = 16;
    type Total = uint32x4_t;

    intrinsics! {
        unsafe fn splat(byte: u8) -> Self { vdupq_n_u8(byte) }
        unsafe fn load(from: *const u8) -> Self { vld1q_u8(from) }
        unsafe fn nothing() -> uint32x4_t { vdupq_n_u32(0) }
        unsafe fn end<const WHOLE: usize>(width: usize) -> Self { generic::last_lanes(width) }
        unsafe fn load_end<const WHOLE: usize>(row: *const u8, width: usize) -> Self {
            generic::last::<Self, WHOLE>(row, width)
        }
        fn or(a: Self, b: Self) -> Self { vorrq_u8(a, b) }
        fn saturating_sub(a: Self, b: Self) -> Self { vqsubq_u8(a, b) }
        fn minus(a: Self, b: Self) -> Self { vsubq_u8(a, b) }
        fn is_above(a: Self, b: Self) -> Self { vcgtq_s8(vreinterpretq_s8_u8(a), vreinterpretq_s8_u8(b)) }
        fn add(total: uint32x4_t, bytes: Self) -> uint32x4_t { vpadalq_u16(total, vpaddlq_u8(bytes)) }
        fn add_distance(total: uint32x4_t, f: Self, g: Self) -> uint32x4_t { Self::add(total, vabdq_u8(f, g)) }
        fn plus(a: uint32x4_t, b: uint32x4_t) -> uint32x4_t { vaddq_u32(a, b) }
        fn times_256(total: uint32x4_t) -> uint32x4_t { vshlq_n_u32::<8>(total) }
        fn across(total: uint32x4_t) -> u32 { vaddvq_u32(total) }
        fn keep(bytes: Self, end: Self) -> Self { vandq_u8(bytes, end) }
        fn difference(f: Self, g: Self) -> Self { vabdq_u8(f, g) }
    }
}

impl Neighbours for uint8x16_t {
    intrinsics! {
        unsafe fn store(bytes: Self, to: *mut u8) { vst1q_u8(to, bytes) }
        fn min(a: Self, b: Self) -> Self { vminq_u8(a, b) }
        fn max(a: Self, b: Self) -> Self { vmaxq_u8(a, b) }
        fn raised(a: Self, b: Self) -> Self { vqaddq_u8(a, b) }
        fn shift_down<const BY: i32>(bytes: Self) -> Self { vextq_u8::<BY>(bytes, vdupq_n_u8(0)) }
    }
}

const SEGMENT: usize = 64;

pub(crate) type Lookup = generic::Lookup<uint8x16_t, SEGMENT, 4>;

scores!(Lookup, Planes, uint8x16_t, "neon", segments: 1 2 or 4);

/// The first `SEGMENTS` table segments of both byte planes (low and high bytes), in registers.
struct Planes<const SEGMENTS: usize> {
    low: [uint8x16x4_t; 4],
    high: [uint8x16x4_t; 4],
}

impl<const SEGMENTS: usize> Planes<SEGMENTS> {
    /// # Safety
    /// The processor has NEON.
    #[inline]
    #[target_feature(enable = "neon")]
    fn of(lookup: &Lookup) -> Self {
        let nothing = vdupq_n_u8(0);
        let nothing = [uint8x16x4_t(nothing, nothing, nothing, nothing); 4];
        let mut planes = Self { low: nothing, high: nothing };
        for (registers, segments) in [(&mut planes.low, &lookup.low), (&mut planes.high, &lookup.high)] {
            for (register, segment) in registers.iter_mut().zip(segments).take(SEGMENTS) {
                // SAFETY: a segment has 64 bytes.
                *register = unsafe { vld1q_u8_x4(segment.as_ptr()) };
            }
        }
        planes
    }
}

impl<const SEGMENTS: usize> LookUp for Planes<SEGMENTS> {
    type Vector = uint8x16_t;

    #[inline(always)]
    fn look_up(&self, difference: uint8x16_t) -> (uint8x16_t, uint8x16_t) {
        (entries::<SEGMENTS>(&self.low, difference), entries::<SEGMENTS>(&self.high, difference))
    }
}

/// Looks up the entries of one byte plane (low or high bytes).
#[inline(always)]
fn entries<const SEGMENTS: usize>([first, others @ ..]: &[uint8x16x4_t; 4], difference: uint8x16_t) -> uint8x16_t {
    // SAFETY: this file is compiled only if the target has NEON.
    unsafe {
        let mut index = difference;
        let mut entries = vqtbl4q_u8(*first, index);
        for segment in others.iter().take(SEGMENTS - 1) {
            // An index outside of this segment is 64 or more (perhaps by wrapping), and keeps the previous result.
            index = vsubq_u8(index, vdupq_n_u8(64));
            entries = vqtbx4q_u8(entries, *segment, index);
        }
        entries
    }
}
