//! Scores by AVX2: 32 pixels at a time, for any threshold.
//!
//! 1. The low and the high bytes of the table are two planes of 256 bytes. A shuffle looks up 16 bytes, so the loop
//!    goes through the entries below the threshold in segments of 16. The usual threshold is at most 16: one segment.
//! 2. A shuffle gives zero if the top bit of the index is set. A saturating addition sets that bit for differences that
//!    belong to other segments. So the lookup is also the test d < threshold.
//! 3. `psadbw` against zero adds eight bytes exactly.
//! 4. The end of a row that fills no vector is loaded together with the pixels before it, which are then masked. So no
//!    byte outside of a row is read, whatever its width.

use crate::image::Image;
use crate::kernels::cut_table::CutTable;
use crate::kernels::effort::Effort;
use crate::kernels::generic::{self, LookUp, Neighbours, Vector, by_width, intrinsics, ranges, scores};
use crate::kernels::plain::scores as plain;
use crate::kernels::rows::Rows;
use crate::kernels::scores::{Blocks, RowsOfRanges, Scores};
use core::arch::x86_64::*;
use core::slice;

impl Vector for __m256i {
    const LANES: usize = 32;
    type Total = Self;

    intrinsics! {
        fn splat(byte: u8) -> Self { _mm256_set1_epi8(byte.cast_signed()) }
        fn load(from: *const u8) -> Self { _mm256_loadu_si256(from.cast()) }
        fn or(a: Self, b: Self) -> Self { _mm256_or_si256(a, b) }
        fn beyond(a: Self, b: Self) -> Self { _mm256_subs_epu8(a, b) }
        fn minus(a: Self, b: Self) -> Self { _mm256_sub_epi8(a, b) }
        fn at_most(a: Self, b: Self) -> Self { _mm256_cmpeq_epi8(_mm256_min_epu8(a, b), a) }
        fn is_above(a: Self, b: Self) -> Self { _mm256_cmpgt_epi8(a, b) }
        fn nothing() -> Self { _mm256_setzero_si256() }
        fn add(total: Self, bytes: Self) -> Self { Self::add_distance(total, bytes, _mm256_setzero_si256()) }
        fn add_distance(total: Self, f: Self, g: Self) -> Self { _mm256_add_epi64(total, _mm256_sad_epu8(f, g)) }
        fn plus(a: Self, b: Self) -> Self { _mm256_add_epi64(a, b) }
        fn times_256(total: Self) -> Self { _mm256_slli_epi64(total, 8) }
        fn across(total: Self) -> u32 {
            __m128i::across(_mm_add_epi64(_mm256_castsi256_si128(total), _mm256_extracti128_si256(total, 1)))
        }
        fn end<const WHOLE: usize>(width: usize) -> Self {
            if WHOLE > 0 { generic::last_lanes(width) } else { narrow_lanes(width) }
        }
        fn load_end<const WHOLE: usize>(row: *const u8, width: usize, _end: Self) -> Self {
            if WHOLE > 0 { generic::last::<Self, WHOLE>(row, width) } else { narrow(slice::from_raw_parts(row, width)) }
        }
        fn keep(bytes: Self, end: Self) -> Self { _mm256_and_si256(bytes, end) }
    }
}

impl Neighbours for __m256i {
    intrinsics! {
        fn store(bytes: Self, to: *mut u8) { _mm256_storeu_si256(to.cast(), bytes) }
        fn min(a: Self, b: Self) -> Self { _mm256_min_epu8(a, b) }
        fn max(a: Self, b: Self) -> Self { _mm256_max_epu8(a, b) }
        fn raised(a: Self, b: Self) -> Self { _mm256_adds_epu8(a, b) }
        // 0x81: moves the upper half down, and zeroes follow.
        fn further<const BY: i32>(bytes: Self) -> Self {
            _mm256_alignr_epi8::<BY>(_mm256_permute2x128_si256::<0x81>(bytes, bytes), bytes)
        }
    }
}

/// A mask of the lanes in which [`narrow`] loads a row of up to 31 pixels, each pixel once.
///
/// Two loads of the same size, one at the start and one at the end of the row, cover up to twice that size. Where they
/// overlap, only the first is valid.
///
/// # Safety
/// The processor has AVX2.
#[inline(always)]
unsafe fn narrow_lanes(width: usize) -> __m256i {
    let (lanes, new) = match width {
        0..4 => (&const { lanes(0, 4) }, width % 4),
        4..8 => (&const { lanes(4, 4) }, width % 4),
        8..16 => (&const { lanes(8, 8) }, width % 8),
        _ => (&const { lanes(16, 16) }, width % 16),
    };
    let new = i8::try_from(new).unwrap_or(0);
    // SAFETY: as the caller guarantees; `lanes` is 32 bytes.
    unsafe { _mm256_cmpgt_epi8(__m256i::load(lanes.as_ptr()), _mm256_set1_epi8(31 - new)) }
}

/// The numbers that [`narrow_lanes`] compares: `first` lanes that are always valid, `second` lanes that end with 31,
/// and lanes that are never valid.
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

/// Loads a row of up to 31 pixels.
///
/// # Safety
/// The processor has AVX2.
#[inline(always)]
unsafe fn narrow(row: &[u8]) -> __m256i {
    // SAFETY: as the caller guarantees; 16 bytes are loaded only if the row has them.
    unsafe {
        if let (Some(first), Some(last)) = (row.first_chunk::<16>(), row.last_chunk::<16>()) {
            return _mm256_set_m128i(__m128i::load(last.as_ptr()), __m128i::load(first.as_ptr()));
        }
        if let (Some(&first), Some(&last)) = (row.first_chunk(), row.last_chunk()) {
            return _mm256_set_epi64x(0, 0, i64::from_le_bytes(last), i64::from_le_bytes(first));
        }
        let both = match (row.first_chunk(), row.last_chunk()) {
            (Some(&first), Some(&last)) => {
                i64::from(u32::from_le_bytes(first)) | i64::from(u32::from_le_bytes(last)) << 32
            }
            // Shifts pixels in from the top of four bytes, so that the last pixel is included.
            _ => i64::from(row.iter().fold(0, |all, &pixel| all >> 8 | u32::from(pixel) << 24)),
        };
        _mm256_set_epi64x(0, 0, 0, both)
    }
}

/// Entries that one shuffle looks up.
const SEGMENT: usize = 16;

/// Segments that a half of the table has: as many as the top bit of an index can tell from the rest.
const SEGMENTS_A_HALF: usize = 8;

/// The entries below the threshold in segments, low bytes and high bytes apart.
///
/// The first segment of a half is stored as it is, each other one as its xor with the one before it. A pixel in segment
/// k gets a value from each shuffle up to k, and their xor is the entry.
pub(crate) struct Lookup {
    low: [[u8; SEGMENT]; 16],
    high: [[u8; SEGMENT]; 16],
    segments: usize,
    /// The largest difference that counts, if there is one.
    last: Option<u8>,
    /// Decides how often bounding candidates is worth its time.
    candidates: Effort,
}

scores!(Lookup, Planes, __m256i, "avx2", segments: 1 2 3 4 8 or 16);
ranges!("avx2", __m256i __m128i);

impl Lookup {
    /// `None` if the machine has no AVX2. So a `Lookup` proves that it has.
    pub(crate) fn new(table: &CutTable) -> Option<Self> {
        if !super::is_available() {
            return None;
        }
        let threshold = table.threshold();
        let mut planes = ([[0; SEGMENT]; 16], [[0; SEGMENT]; 16]);
        let places = planes.0.as_flattened_mut().iter_mut().zip(planes.1.as_flattened_mut());
        for ((low, high), entry) in places.zip(table.entries()).take(usize::from(threshold)) {
            [*low, *high] = entry.to_le_bytes();
        }
        // From five on, the loop goes through eight or all segments, also through those beyond the threshold.
        let segments = match usize::from(threshold).div_ceil(SEGMENT) {
            live @ 0..=4 => live.max(1),
            5..=8 => 8,
            _ => 16,
        };
        planes.0.get_mut(..segments).map(xor_within_halves);
        planes.1.get_mut(..segments).map(xor_within_halves);
        let last = threshold.checked_sub(1).and_then(|last| u8::try_from(last).ok());
        Some(Self { low: planes.0, high: planes.1, segments, last, candidates: Effort::NEW })
    }
}

/// Replaces each segment of a half but the first by its xor with the one before it.
fn xor_within_halves(plane: &mut [[u8; SEGMENT]]) {
    for half in plane.chunks_mut(SEGMENTS_A_HALF) {
        // Starts at the last segment: each segment then meets the one before it unchanged.
        let mut rest = half;
        while let Some((last, before)) = rest.split_last_mut() {
            last.iter_mut().zip(before.last().into_iter().flatten()).for_each(|(byte, before)| *byte ^= before);
            rest = before;
        }
    }
}

/// The first `SEGMENTS` segments of both byte planes, each in both halves of a vector. The others are not looked up.
struct Planes<const SEGMENTS: usize> {
    low: [__m256i; 16],
    high: [__m256i; 16],
}

impl<const SEGMENTS: usize> Planes<SEGMENTS> {
    #[inline]
    #[target_feature(enable = "avx2")]
    fn of(lookup: &Lookup) -> Self {
        let mut planes = Self { low: [_mm256_setzero_si256(); 16], high: [_mm256_setzero_si256(); 16] };
        for (registers, segments) in [(&mut planes.low, &lookup.low), (&mut planes.high, &lookup.high)] {
            for (register, segment) in registers.iter_mut().zip(segments).take(SEGMENTS) {
                // SAFETY: 16 bytes can be read at `segment`.
                *register = _mm256_broadcastsi128_si256(unsafe { _mm_loadu_si128(segment.as_ptr().cast()) });
            }
        }
        planes
    }

    /// Looks up the entries in `COUNT` segments (at most 8) from `first` on.
    ///
    /// # Safety
    /// The processor has AVX2.
    #[inline(always)]
    #[allow(clippy::indexing_slicing, clippy::cast_possible_truncation, clippy::cast_possible_wrap)] // all below 16 * 8
    unsafe fn look_up_half<const COUNT: usize>(&self, first: usize, difference: __m256i) -> (__m256i, __m256i) {
        // With this added, the last segment ends at 127. Differences beyond it have the top bit.
        let up = SEGMENT * (SEGMENTS_A_HALF - COUNT);
        // SAFETY: as the caller guarantees.
        unsafe {
            let moved = _mm256_adds_epu8(difference, _mm256_set1_epi8(up as i8));
            let mut planes =
                (_mm256_shuffle_epi8(self.low[first], moved), _mm256_shuffle_epi8(self.high[first], moved));
            let mut segment = 1;
            while segment < COUNT {
                // A signed and saturating subtraction: the top bit stays where it is set, and is set for differences
                // below this segment.
                let index = _mm256_subs_epi8(moved, _mm256_set1_epi8((up + SEGMENT * segment) as i8));
                planes.0 = _mm256_xor_si256(planes.0, _mm256_shuffle_epi8(self.low[first + segment], index));
                planes.1 = _mm256_xor_si256(planes.1, _mm256_shuffle_epi8(self.high[first + segment], index));
                segment += 1;
            }
            planes
        }
    }
}

impl<const SEGMENTS: usize> LookUp for Planes<SEGMENTS> {
    type Vector = __m256i;

    #[inline(always)]
    unsafe fn look_up(&self, difference: __m256i) -> (__m256i, __m256i) {
        // SAFETY: as the caller guarantees.
        unsafe {
            if SEGMENTS <= SEGMENTS_A_HALF {
                return self.look_up_half::<SEGMENTS>(0, difference);
            }
            // The top bit tells the halves apart.
            let first = self.look_up_half::<SEGMENTS_A_HALF>(0, difference);
            let other = _mm256_xor_si256(difference, _mm256_set1_epi8(i8::MIN));
            let second = self.look_up_half::<SEGMENTS_A_HALF>(SEGMENTS_A_HALF, other);
            (_mm256_or_si256(first.0, second.0), _mm256_or_si256(first.1, second.1))
        }
    }
}
