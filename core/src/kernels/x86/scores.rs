//! Scores by byte shuffles, for any threshold: the common code of AVX2 and SSSE3.
//!
//! 1. The low and the high bytes of the table are two planes of 256 bytes. A shuffle looks up 16 bytes, so the loop
//!    processes the entries below the threshold in segments of 16. The usual threshold is at most 16: one segment.
//! 2. A shuffle gives zero if the top bit of the index is set. A saturating addition sets that bit for differences that
//!    belong to other segments, so the lookup is also the test d < threshold.
//! 3. `psadbw` against zero adds eight bytes exactly.

use crate::kernels::cut_table::CutTable;
use crate::kernels::generic::{self, LookUp, Neighbours, Vector, half};
use core::arch::x86_64::*;

/// A vector register that shuffles bytes within each of its 16-byte parts.
pub(super) trait Shuffle: Neighbours {
    /// Loads the same 16 bytes into each part.
    ///
    /// # Safety
    /// The processor has the instruction set of the vector.
    unsafe fn segment(entries: &[u8; SEGMENT]) -> Self;
    /// Looks up each index in the 16 `entries` of the same 16-byte part; zero if the index has its top bit set.
    ///
    /// # Safety
    /// The processor has a byte shuffle: SSSE3 for 16 bytes, AVX2 for 32.
    unsafe fn shuffle(entries: Self, index: Self) -> Self;
    /// Signed saturating subtraction: max(a - b, -128).
    fn lowered(a: Self, b: Self) -> Self;
    fn xor(a: Self, b: Self) -> Self;
}

/// Table entries that one shuffle looks up.
pub(super) const SEGMENT: usize = 16;

/// Segments in each half of the table. The top bit of an index selects one of the halves, which have 128 entries.
const SEGMENTS_A_HALF: usize = 8;

/// Table segments for shuffles. In each half of the table, every segment after the first is stored as its xor with the
/// segment before. For an index in segment k of a half, the entry is the xor of the results of shuffles 0 to k.
pub(crate) type Lookup<V> = generic::Lookup<V, SEGMENT, 16>;

impl<V> Lookup<V> {
    /// # Safety
    /// The processor has the instruction set of `V`.
    pub(crate) unsafe fn shuffled(table: &CutTable) -> Self {
        // SAFETY: the processor has the instruction set of `V`.
        let mut lookup = unsafe { Self::new(table) };
        if lookup.segments > 1 {
            xor_within_halves(&mut lookup.low);
            xor_within_halves(&mut lookup.high);
        }
        lookup
    }
}

fn xor_within_halves(plane: &mut [[u8; SEGMENT]]) {
    for half in plane.chunks_mut(SEGMENTS_A_HALF) {
        // Starts at the last segment, so that the segment before each is still unchanged.
        let mut rest = half;
        while let Some((last, before)) = rest.split_last_mut() {
            last.iter_mut().zip(before.last().into_iter().flatten()).for_each(|(byte, before)| *byte ^= before);
            rest = before;
        }
    }
}

/// The first `SEGMENTS` segments of the table in registers, low bytes and high bytes apart. Made only for processors
/// with a byte shuffle.
pub(super) struct Planes<V, const SEGMENTS: usize> {
    low: [V; 16],
    high: [V; 16],
}

impl<V: Shuffle, const SEGMENTS: usize> Planes<V, SEGMENTS> {
    /// # Safety
    /// The processor has the instruction set of `V`.
    #[inline(always)]
    pub(super) unsafe fn of(lookup: &Lookup<V>) -> Self {
        // SAFETY: the processor has the instruction set of `V`.
        unsafe {
            let mut planes = Self { low: [V::splat(0); 16], high: [V::splat(0); 16] };
            for (registers, segments) in [(&mut planes.low, &lookup.low), (&mut planes.high, &lookup.high)] {
                for (register, segment) in registers.iter_mut().zip(segments).take(SEGMENTS) {
                    *register = V::segment(segment);
                }
            }
            planes
        }
    }

    /// Looks up each difference in `COUNT` segments of the table (at most 8), from segment `first` on.
    #[inline(always)]
    #[allow(clippy::indexing_slicing, clippy::cast_possible_truncation)] // all below 16 * 8
    fn look_up_half<const COUNT: usize>(&self, first: usize, difference: V) -> (V, V) {
        // Added to each difference: the last of `COUNT` segments then ends at 127; larger differences get the top bit.
        let up = SEGMENT * (SEGMENTS_A_HALF - COUNT);
        // SAFETY: `of` has made `self`, so the processor has the instruction set of `V`, with its byte shuffle.
        unsafe {
            let moved = V::raised(difference, V::splat(up as u8));
            let mut planes = (V::shuffle(self.low[first], moved), V::shuffle(self.high[first], moved));
            let mut segment = 1;
            while segment < COUNT {
                // Signed saturating subtraction keeps a set top bit, and sets it for differences below this segment.
                let index = V::lowered(moved, V::splat((up + SEGMENT * segment) as u8));
                planes.0 = V::xor(planes.0, V::shuffle(self.low[first + segment], index));
                planes.1 = V::xor(planes.1, V::shuffle(self.high[first + segment], index));
                segment += 1;
            }
            planes
        }
    }
}

impl<V: Shuffle, const SEGMENTS: usize> LookUp for Planes<V, SEGMENTS> {
    type Vector = V;

    #[inline(always)]
    fn look_up(&self, difference: V) -> (V, V) {
        if SEGMENTS <= SEGMENTS_A_HALF {
            return self.look_up_half::<SEGMENTS>(0, difference);
        }
        // The top bit of a difference selects the half of the table.
        let first = self.look_up_half::<SEGMENTS_A_HALF>(0, difference);
        let second = self.look_up_half::<SEGMENTS_A_HALF>(SEGMENTS_A_HALF, V::xor(difference, half(difference)));
        (V::or(first.0, second.0), V::or(first.1, second.1))
    }
}

/// Mask for a row narrower than a vector. Two loads of the row may overlap; the mask includes each pixel once.
///
/// # Safety
/// The processor has the instruction set of `V`.
#[inline(always)]
pub(super) unsafe fn narrow_lanes<V: Vector>(width: usize) -> V {
    let (lanes, new) = match width {
        0..4 => (&const { lanes(0, 4) }, width % 4),
        4..8 => (&const { lanes(4, 4) }, width % 4),
        8..16 => (&const { lanes(8, 8) }, width % 8),
        _ => (&const { lanes(16, 16) }, width % 16),
    };
    let new = u8::try_from(new).unwrap_or(0);
    // SAFETY: the processor has the instruction set; a vector is at most the 32 bytes of `lanes`.
    unsafe { V::is_above(V::load(lanes.as_ptr()), V::splat(31 - new)) }
}

/// Lanes that [`narrow_lanes`] compares with a limit: `first` lanes of 127 (always in the mask), `second` lanes that
/// rise in steps of 1 and end at 31 (the last ones may be in the mask), then zeroes (never in the mask).
#[allow(clippy::indexing_slicing, clippy::cast_possible_truncation)] // all below 32
const fn lanes(first: usize, second: usize) -> [u8; 32] {
    let mut lanes = [0; 32];
    let mut lane = 0;
    while lane < first + second {
        lanes[lane] = if lane < first { 127 } else { (32 - second + lane - first) as u8 };
        lane += 1;
    }
    lanes
}

/// Loads a row of up to 15 pixels into the lanes that the mask [`narrow_lanes`] marks.
#[inline(always)]
pub(super) fn narrow(row: &[u8]) -> __m128i {
    // SAFETY: every x86-64 has SSE2.
    unsafe {
        if let (Some(&first), Some(&last)) = (row.first_chunk(), row.last_chunk()) {
            return _mm_set_epi64x(i64::from_le_bytes(last), i64::from_le_bytes(first));
        }
        let both = match (row.first_chunk(), row.last_chunk()) {
            (Some(&first), Some(&last)) => {
                i64::from(u32::from_le_bytes(first)) | i64::from(u32::from_le_bytes(last)) << 32
            }
            // Fewer than four pixels: aligns them with the end of four bytes, where the mask marks them.
            _ => i64::from(row.iter().fold(0, |all, &pixel| all >> 8 | u32::from(pixel) << 24)),
        };
        _mm_set_epi64x(0, both)
    }
}
