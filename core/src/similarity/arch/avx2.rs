//! Scores by AVX2: 32 pixels at a time, for any threshold.
//!
//! 1. The table's two bytes are two planes of 256 entries; a shuffle looks up 16 of them, so the live entries are gone
//!    through in segments of 16: one for a threshold of up to 16, which is the usual case.
//! 2. A shuffle gives zero where the top bit of the index is set. The differences are moved up, with saturation, so that
//!    those of other segments have it: the lookup is the test d < threshold, too.
//! 3. `psadbw` against zero adds eight bytes exactly; a plane's sum over 65537 pixels is below 2^25.
//! 4. Of a patch that lies between two pictures the pixels that count are counted, without a lookup: a bound.
//! 5. The end of a row that fills no register is loaded together with pixels before it, which are then masked away. So no
//!    byte outside a row is read, whatever its width.

use super::super::{CutTable, Table};
use super::{Kernels, rows::Rows, sse2};
use crate::image::Image;
use core::arch::x86_64::*;
use core::slice;

/// Pixels in a register.
const LANES: usize = 32;

/// So many rows are added before it is looked whether the end is already certain.
const ROWS_A_LOOK: usize = 8;

/// Entries that one shuffle looks up.
const SEGMENT: usize = 16;

/// Segments among which the top bit of an index can tell.
const SEGMENTS_A_HALF: usize = 8;

/// The live part of a table in segments, low bytes and high bytes apart.
///
/// Each segment but the first of a half is stored as what differs (xor) from the one before it: the shuffles of a pixel
/// in segment k give something for all segments up to k, and what they give adds up (xor) to the entry.
pub(super) struct Lookup {
    low: [[u8; SEGMENT]; 16],
    high: [[u8; SEGMENT]; 16],
    segments: usize,
    /// The largest difference that counts, if there is one.
    last: Option<u8>,
}

pub(super) fn is_available() -> bool {
    #[cfg(feature = "std")]
    return std::is_x86_feature_detected!("avx2");
    #[cfg(not(feature = "std"))]
    return cfg!(target_feature = "avx2");
}

impl Kernels for Lookup {
    #[inline(always)] // what `Rows` takes of the pictures is then in registers; through memory it waits for halves of words
    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        self.sum(&Rows::of(patch, template), floor)
    }

    #[inline(always)]
    fn score_between_at_least(&self, low: Image<'_>, high: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let rows = Rows::between(low, high, template);
        // SAFETY: a `Lookup` exists only where AVX2 does, and the pictures are borrowed.
        unsafe {
            match (rows.width / LANES, rows.width.is_multiple_of(LANES)) {
                (0, _) => self.count_at_least::<0, true>(&rows, floor),
                (1, true) => self.count_at_least::<1, false>(&rows, floor),
                (1, false) => self.count_at_least::<1, true>(&rows, floor),
                (2, true) => self.count_at_least::<2, false>(&rows, floor),
                (_, true) => self.count_at_least::<ANY, false>(&rows, floor),
                (_, false) => self.count_at_least::<ANY, true>(&rows, floor),
            }
        }
    }

    #[inline(always)]
    fn spread(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
        // SAFETY: a `Lookup` exists only where AVX2 does.
        unsafe { spread(rows, low, high) }
    }

    #[inline(always)]
    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
        let rows = Rows::of(patch, template);
        // SAFETY: a `Lookup` exists only where AVX2 does, and both pictures are borrowed.
        unsafe {
            match (rows.width / LANES, rows.width.is_multiple_of(LANES)) {
                (0, _) => distance::<0, true>(&rows, enough),
                (1, true) => distance::<1, false>(&rows, enough),
                (1, false) => distance::<1, true>(&rows, enough),
                (2, true) => distance::<2, false>(&rows, enough),
                (_, true) => distance::<ANY, false>(&rows, enough),
                (_, false) => distance::<ANY, true>(&rows, enough),
            }
        }
    }
}

impl Lookup {
    /// `None` where the machine has no AVX2: that there is a `Lookup` is the proof that it has.
    pub(super) fn new(table: &CutTable) -> Option<Self> {
        if !is_available() {
            return None;
        }
        let threshold = table.threshold();
        let mut planes = ([[0; SEGMENT]; 16], [[0; SEGMENT]; 16]);
        let places = planes.0.as_flattened_mut().iter_mut().zip(planes.1.as_flattened_mut());
        for ((low, high), entry) in places.zip(table.entries()).take(usize::from(threshold)) {
            [*low, *high] = entry.to_le_bytes();
        }
        // Of more than four either a half or all are gone through, those beyond the threshold too.
        let segments = match usize::from(threshold).div_ceil(SEGMENT) {
            live @ 0..=4 => live,
            5..=8 => 8,
            _ => 16,
        };
        planes.0.get_mut(..segments).map(xor_within_halves);
        planes.1.get_mut(..segments).map(xor_within_halves);
        let last = threshold.checked_sub(1).and_then(|last| u8::try_from(last).ok());
        Some(Self { low: planes.0, high: planes.1, segments, last })
    }

    /// The score of rows whose pictures are borrowed.
    #[inline]
    fn sum(&self, rows: &Rows, floor: u32) -> Option<u32> {
        // SAFETY: a `Lookup` exists only where AVX2 does, and the pictures are borrowed.
        unsafe {
            match self.segments {
                0..=1 => self.sum_by_width::<1>(rows, floor),
                2 => self.sum_by_width::<2>(rows, floor),
                3 => self.sum_by_width::<3>(rows, floor),
                4 => self.sum_by_width::<4>(rows, floor),
                8 => self.sum_by_width::<8>(rows, floor),
                _ => self.sum_by_width::<16>(rows, floor),
            }
        }
    }

    /// A bound of a score: every pixel that counts is taken to be fully similar. It reads three pictures for about the price
    /// that the score of two has. `WHOLE` and `END` are as for [`Lookup::sum_at_least`].
    ///
    /// # Safety
    /// The pictures that `rows` were made of are borrowed.
    #[target_feature(enable = "avx2")]
    unsafe fn count_at_least<const WHOLE: usize, const END: bool>(&self, rows: &Rows, floor: u32) -> Option<u32> {
        let Some(last) = self.last else { return Some(0).filter(|_| floor == 0) };
        let (whole, end) = (if WHOLE == ANY { rows.width / LANES } else { WHOLE }, End::of(rows.width));
        let mut count = Count { last: _mm256_set1_epi8(last.cast_signed()), bytes: _mm256_setzero_si256(), flushed: 0 };
        let needed = Rows::pixels_of(floor);
        let mut y = 0;
        while y < rows.height {
            let until = rows.height.min(y + ROWS_A_LOOK);
            while y < until {
                let ((f, g), h) = (rows.row(y), rows.high_row(y));
                let mut at = 0;
                while at < whole * LANES {
                    // SAFETY: at + 32 is at most the width.
                    let (f, h, g) =
                        unsafe { (load(f.wrapping_add(at)), load(h.wrapping_add(at)), load(g.wrapping_add(at))) };
                    count.add(outside(f, h, g), _mm256_set1_epi8(-1));
                    at += LANES;
                    if WHOLE == ANY && at.is_multiple_of(Count::MOST * LANES) {
                        count.flush();
                    }
                }
                if END {
                    // SAFETY: the row is as wide as `end` was made for.
                    let (f, h, g) = unsafe { (end.load::<WHOLE>(f), end.load::<WHOLE>(h), end.load::<WHOLE>(g)) };
                    count.add(outside(f, h, g), end.valid);
                }
                if WHOLE == ANY {
                    count.flush();
                }
                y += 1;
            }
            count.flush();
            if count.flushed + rows.pixels_after(y) < needed {
                return None;
            }
        }
        Some(count.flushed * u32::from(Table::ONE))
    }

    /// The usual widths have a loop of their own.
    ///
    /// # Safety
    /// The pictures that `rows` were made of are borrowed.
    #[target_feature(enable = "avx2")]
    unsafe fn sum_by_width<const SEGMENTS: usize>(&self, rows: &Rows, floor: u32) -> Option<u32> {
        // SAFETY: as the caller has seen to.
        unsafe {
            match (rows.width / LANES, rows.width.is_multiple_of(LANES)) {
                (0, _) => self.sum_at_least::<SEGMENTS, 0, true>(rows, floor),
                (1, true) => self.sum_at_least::<SEGMENTS, 1, false>(rows, floor),
                (1, false) => self.sum_at_least::<SEGMENTS, 1, true>(rows, floor),
                (2, true) => self.sum_at_least::<SEGMENTS, 2, false>(rows, floor),
                (_, true) => self.sum_at_least::<SEGMENTS, ANY, false>(rows, floor),
                (_, false) => self.sum_at_least::<SEGMENTS, ANY, true>(rows, floor),
            }
        }
    }

    /// `WHOLE` is the number of registers that a row fills, or [`ANY`]; `END`: there are pixels that fill none.
    ///
    /// # Safety
    /// The pictures that `rows` were made of are borrowed.
    #[target_feature(enable = "avx2")]
    unsafe fn sum_at_least<const SEGMENTS: usize, const WHOLE: usize, const END: bool>(
        &self,
        rows: &Rows,
        floor: u32,
    ) -> Option<u32> {
        let walk = Walk {
            rows,
            whole: if WHOLE == ANY { rows.width / LANES } else { WHOLE },
            end: End::of(rows.width),
            low: plane::<SEGMENTS>(&self.low),
            high: plane::<SEGMENTS>(&self.high),
        };
        let mut sums = Sums { low: _mm256_setzero_si256(), high: _mm256_setzero_si256() };
        let mut y = 0;
        while y < rows.height {
            walk.add_row::<SEGMENTS, WHOLE, END>(y, &mut sums);
            if y + 1 < rows.height {
                walk.add_row::<SEGMENTS, WHOLE, END>(y + 1, &mut sums);
                let left = rows.full_after(y + 2);
                if left < floor && y % ROWS_A_LOOK == ROWS_A_LOOK - 2 && sums.score() + left < floor {
                    return None;
                }
            }
            y += 2;
        }
        Some(sums.score()).filter(|&score| score >= floor)
    }
}

/// A [`Lookup`] in registers, and what it is to look up.
struct Walk<'a> {
    rows: &'a Rows,
    whole: usize,
    end: End,
    low: Plane,
    high: Plane,
}

impl Walk<'_> {
    /// Adds the similarities of row `y`, which is below the height.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn add_row<const SEGMENTS: usize, const WHOLE: usize, const END: bool>(&self, y: usize, sums: &mut Sums) {
        let (f, g) = self.rows.row(y);
        let mut at = 0;
        while at < self.whole * LANES {
            // SAFETY: at + 32 is at most the width.
            let (f, g) = unsafe { (load(f.wrapping_add(at)), load(g.wrapping_add(at))) };
            sums.add(look_up::<SEGMENTS>(&self.low, &self.high, outside(f, f, g)));
            at += LANES;
        }
        if END {
            // SAFETY: the row is as wide as `end` was made for.
            let (f, g) = unsafe { (self.end.load::<WHOLE>(f), self.end.load::<WHOLE>(g)) };
            let difference = outside(f, f, g);
            let planes = look_up::<SEGMENTS>(&self.low, &self.high, difference);
            sums.add((_mm256_and_si256(planes.0, self.end.valid), _mm256_and_si256(planes.1, self.end.valid)));
        }
    }
}

/// Whatever number of registers a row fills, but at least one.
const ANY: usize = usize::MAX;

/// Makes each segment of a half what differs from the one before it.
fn xor_within_halves(plane: &mut [[u8; SEGMENT]]) {
    for half in plane.chunks_mut(SEGMENTS_A_HALF) {
        // From the last on, so that each meets the one before it unchanged.
        let mut rest = half;
        while let Some((last, before)) = rest.split_last_mut() {
            last.iter_mut().zip(before.last().into_iter().flatten()).for_each(|(byte, before)| *byte ^= before);
            rest = before;
        }
    }
}

/// The similarities of 32 pairs of pixels, low bytes and high bytes, by the first `SEGMENTS` segments.
#[inline]
#[target_feature(enable = "avx2")]
fn look_up<const SEGMENTS: usize>(low: &Plane, high: &Plane, difference: __m256i) -> (__m256i, __m256i) {
    if SEGMENTS <= SEGMENTS_A_HALF {
        return look_up_half::<SEGMENTS>(low, high, 0, difference);
    }
    // The top bit says that a difference is one of the other half.
    let first = look_up_half::<SEGMENTS_A_HALF>(low, high, 0, difference);
    let other = _mm256_xor_si256(difference, _mm256_set1_epi8(i8::MIN));
    let second = look_up_half::<SEGMENTS_A_HALF>(low, high, SEGMENTS_A_HALF, other);
    (_mm256_or_si256(first.0, second.0), _mm256_or_si256(first.1, second.1))
}

/// The same by the `SEGMENTS` segments, 8 at most, from `first` on.
#[inline]
#[target_feature(enable = "avx2")]
#[allow(clippy::indexing_slicing, clippy::cast_possible_truncation, clippy::cast_possible_wrap)] // all below 16 * 8
fn look_up_half<const SEGMENTS: usize>(
    low: &Plane,
    high: &Plane,
    first: usize,
    difference: __m256i,
) -> (__m256i, __m256i) {
    // Of what is moved up by this, the last segment ends at 127, and whatever lies beyond it has the top bit.
    let up = SEGMENT * (SEGMENTS_A_HALF - SEGMENTS);
    let moved = _mm256_adds_epu8(difference, _mm256_set1_epi8(up as i8));
    let mut planes = (_mm256_shuffle_epi8(low[first], moved), _mm256_shuffle_epi8(high[first], moved));
    let mut segment = 1;
    while segment < SEGMENTS {
        // Signed and saturating: what has the top bit keeps it, and what lies before this segment gets it.
        let index = _mm256_subs_epi8(moved, _mm256_set1_epi8((up + SEGMENT * segment) as i8));
        planes.0 = _mm256_xor_si256(planes.0, _mm256_shuffle_epi8(low[first + segment], index));
        planes.1 = _mm256_xor_si256(planes.1, _mm256_shuffle_epi8(high[first + segment], index));
        segment += 1;
    }
    planes
}

/// One byte plane of a table: each segment in both halves of a register.
type Plane = [__m256i; 16];

/// The first `SEGMENTS` of a plane; the rest is not looked up.
#[inline]
#[target_feature(enable = "avx2")]
fn plane<const SEGMENTS: usize>(segments: &[[u8; SEGMENT]; 16]) -> Plane {
    let mut plane = [_mm256_setzero_si256(); 16];
    for (register, segment) in plane.iter_mut().zip(segments).take(SEGMENTS) {
        *register = _mm256_broadcastsi128_si256(load_half(segment));
    }
    plane
}

/// The sums of the two byte planes, in four parts each.
struct Sums {
    low: __m256i,
    high: __m256i,
}

impl Sums {
    #[inline]
    #[target_feature(enable = "avx2")]
    fn add(&mut self, planes: (__m256i, __m256i)) {
        let zero = _mm256_setzero_si256();
        self.low = _mm256_add_epi64(self.low, _mm256_sad_epu8(planes.0, zero));
        self.high = _mm256_add_epi64(self.high, _mm256_sad_epu8(planes.1, zero));
    }

    /// The sum of the similarities, which fits a `u32` for as many pixels as a template may have.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn score(&self) -> u32 {
        across(_mm256_add_epi64(self.low, _mm256_slli_epi64(self.high, 8)))
    }
}

/// How many pixels count.
struct Count {
    /// The largest difference that does.
    last: __m256i,
    /// In 32 parts, of up to 255 registers.
    bytes: __m256i,
    /// And of those before.
    flushed: u32,
}

impl Count {
    /// So many registers can be counted before the next [`Count::flush`], and 127 more.
    const MOST: usize = 128;

    #[inline]
    #[target_feature(enable = "avx2")]
    fn add(&mut self, difference: __m256i, valid: __m256i) {
        let counts = _mm256_cmpeq_epi8(_mm256_min_epu8(difference, self.last), difference);
        // All bits are -1.
        self.bytes = _mm256_sub_epi8(self.bytes, _mm256_and_si256(counts, valid));
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn flush(&mut self) {
        self.flushed += across(_mm256_sad_epu8(self.bytes, _mm256_setzero_si256()));
        self.bytes = _mm256_setzero_si256();
    }
}

/// See [`scalar::distance`](super::super::scalar::distance); the parameters are those of [`Lookup::sum_at_least`].
///
/// # Safety
/// The pictures that `rows` were made of are borrowed.
#[target_feature(enable = "avx2")]
unsafe fn distance<const WHOLE: usize, const END: bool>(rows: &Rows, enough: u32) -> u32 {
    let whole = if WHOLE == ANY { rows.width / LANES } else { WHOLE };
    let end = End::of(rows.width);
    let mut sum = _mm256_setzero_si256();
    for y in 0..rows.height {
        let (f, g) = rows.row(y);
        let mut at = 0;
        while at < whole * LANES {
            // SAFETY: at + 32 is at most the width.
            let (f, g) = unsafe { (load(f.wrapping_add(at)), load(g.wrapping_add(at))) };
            sum = _mm256_add_epi64(sum, _mm256_sad_epu8(f, g));
            at += LANES;
        }
        if END {
            // SAFETY: the row is as wide as `end` was made for.
            let (f, g) = unsafe { (end.load::<WHOLE>(f), end.load::<WHOLE>(g)) };
            let (f, g) = (_mm256_and_si256(f, end.valid), _mm256_and_si256(g, end.valid));
            sum = _mm256_add_epi64(sum, _mm256_sad_epu8(f, g));
        }
        if y % ROWS_A_LOOK == ROWS_A_LOOK - 1 && across(sum) > enough {
            break;
        }
    }
    across(sum)
}

/// See [`scalar::spread`](super::super::scalar::spread).
#[target_feature(enable = "avx2")]
pub(super) fn spread(rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
    let columns = rows.iter().map(|row| row.len().saturating_sub(3)).min().unwrap_or(0).min(low.len()).min(high.len());
    let Some(last) = columns.checked_sub(LANES) else {
        return sse2::spread(rows, low, high);
    };
    let rows = rows.each_ref().map(|row| row.as_ptr());
    let mut at = 0;
    while at < last {
        // SAFETY: at + 32 is less than `columns`, and no row is shorter than that.
        let (lowest, highest) = unsafe { column_ranges(&rows, at) };
        let lowest = _mm256_min_epu8(lowest, further::<1>(lowest));
        let highest = _mm256_max_epu8(highest, further::<1>(highest));
        let lowest = _mm256_min_epu8(lowest, further::<2>(lowest));
        let highest = _mm256_max_epu8(highest, further::<2>(highest));
        // SAFETY: neither of the two is shorter than `columns`.
        unsafe { (store(low, at, lowest), store(high, at, highest)) };
        // The last three are not whole; they come out again.
        at += LANES - 3;
    }
    // The last columns are done together with some before them, which come out the same, and with three loads more a row,
    // as there is no register to the right of them.
    let (mut lowest, mut highest) = (_mm256_set1_epi8(-1), _mm256_setzero_si256());
    for column in 0..4 {
        // SAFETY: last + 32 is `columns`, and no row is shorter than that and three.
        let ranges = unsafe { column_ranges(&rows, last + column) };
        (lowest, highest) = (_mm256_min_epu8(lowest, ranges.0), _mm256_max_epu8(highest, ranges.1));
    }
    // SAFETY: neither of the two is shorter than `columns`.
    unsafe { (store(low, last, lowest), store(high, last, highest)) };
}

/// The lowest and the highest of four rows in 32 columns from `at` on.
///
/// # Safety
/// There are so many readable bytes in each row.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn column_ranges(rows: &[*const u8; 4], at: usize) -> (__m256i, __m256i) {
    // SAFETY: the caller has seen to it.
    let [a, b, c, d] = rows.map(|row| unsafe { load(row.wrapping_add(at)) });
    let lowest = _mm256_min_epu8(_mm256_min_epu8(a, b), _mm256_min_epu8(c, d));
    let highest = _mm256_max_epu8(_mm256_max_epu8(a, b), _mm256_max_epu8(c, d));
    (lowest, highest)
}

/// What is so many bytes further on; at the end zeroes.
#[inline]
#[target_feature(enable = "avx2")]
fn further<const BY: i32>(bytes: __m256i) -> __m256i {
    const UPPER_HALF: i32 = 0x81; // and zeroes above it
    _mm256_alignr_epi8::<BY>(_mm256_permute2x128_si256::<UPPER_HALF>(bytes, bytes), bytes)
}

/// # Safety
/// There are 32 bytes from `at` on.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn store(row: &mut [u8], at: usize, bytes: __m256i) {
    // SAFETY: the caller has seen to it; the store needs no alignment.
    unsafe { _mm256_storeu_si256(row.as_mut_ptr().wrapping_add(at).cast(), bytes) };
}

/// The end of a row: the 1 to 31 pixels that are left where whole registers have been taken off.
///
/// Two loads of the same size, one from the first and one to the last pixel, hold a row of up to twice that size; of the
/// second only what the first has not is valid. A row of more than 32 pixels needs only the second.
struct End {
    width: usize,
    /// All bits of the lanes that hold a pixel of the end, each pixel once.
    valid: __m256i,
}

impl End {
    #[inline]
    #[target_feature(enable = "avx2")]
    fn of(width: usize) -> Self {
        let (lanes, new) = match width {
            0..4 => (&const { lanes(0, 4) }, width % 4),
            4..8 => (&const { lanes(4, 4) }, width % 4),
            8..16 => (&const { lanes(8, 8) }, width % 8),
            16..32 => (&const { lanes(16, 16) }, width % 16),
            _ => (&const { lanes(0, 32) }, width % 32),
        };
        let new = i8::try_from(new).unwrap_or(0);
        // SAFETY: `lanes` is 32 bytes.
        let lanes = unsafe { load(lanes.as_ptr()) };
        Self { width, valid: _mm256_cmpgt_epi8(lanes, _mm256_set1_epi8(31 - new)) }
    }

    /// The end of the row that begins at `row`. `WHOLE` is 0 where no register is filled.
    ///
    /// # Safety
    /// There are as many readable bytes as this was made for, and at least 32 if `WHOLE` is not 0.
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn load<const WHOLE: usize>(&self, row: *const u8) -> __m256i {
        if WHOLE > 0 {
            // SAFETY: the width is at least 32.
            return unsafe { load(row.wrapping_add(self.width).wrapping_sub(LANES)) };
        }
        // SAFETY: the caller has seen to it.
        narrow(unsafe { slice::from_raw_parts(row, self.width) })
    }
}

/// A row of up to 31 pixels.
#[inline]
#[target_feature(enable = "avx2")]
fn narrow(row: &[u8]) -> __m256i {
    if let (Some(first), Some(last)) = (row.first_chunk(), row.last_chunk()) {
        return _mm256_set_m128i(load_half(last), load_half(first));
    }
    if let (Some(&first), Some(&last)) = (row.first_chunk(), row.last_chunk()) {
        return _mm256_set_epi64x(0, 0, i64::from_le_bytes(last), i64::from_le_bytes(first));
    }
    let both = match (row.first_chunk(), row.last_chunk()) {
        (Some(&first), Some(&last)) => i64::from(u32::from_le_bytes(first)) | i64::from(u32::from_le_bytes(last)) << 32,
        // Moved in from the top of four bytes, so that they end there.
        _ => i64::from(row.iter().fold(0, |all, &pixel| all >> 8 | u32::from(pixel) << 24)),
    };
    _mm256_set_epi64x(0, 0, 0, both)
}

/// The numbers of lanes: of `first` lanes so large that they are always valid, of `second` lanes those up to 31, and of the
/// rest such that they never are.
#[allow(clippy::indexing_slicing, clippy::cast_possible_truncation)] // all below 32
const fn lanes(first: usize, second: usize) -> [u8; LANES] {
    let mut lanes = [0; LANES];
    let mut lane = 0;
    while lane < first + second {
        lanes[lane] = if lane < first { 127 } else { (LANES - second + lane - first) as u8 };
        lane += 1;
    }
    lanes
}

/// # Safety
/// There are 32 readable bytes.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn load(pixels: *const u8) -> __m256i {
    // SAFETY: the caller has seen to it; the load needs no alignment.
    unsafe { _mm256_loadu_si256(pixels.cast()) }
}

#[inline]
#[target_feature(enable = "avx2")]
fn load_half(pixels: &[u8; 16]) -> __m128i {
    // SAFETY: `pixels` is 16 readable bytes; the load needs no alignment.
    unsafe { _mm_loadu_si128(pixels.as_ptr().cast()) }
}

/// By how much 32 pixels lie outside their ranges: |f - g| where a range is one pixel.
#[inline]
#[target_feature(enable = "avx2")]
fn outside(low: __m256i, high: __m256i, g: __m256i) -> __m256i {
    _mm256_or_si256(_mm256_subs_epu8(low, g), _mm256_subs_epu8(g, high))
}

/// The sum of the four parts.
#[inline]
#[target_feature(enable = "avx2")]
fn across(parts: __m256i) -> u32 {
    let two = _mm_add_epi64(_mm256_castsi256_si128(parts), _mm256_extracti128_si256(parts, 1));
    let one = _mm_add_epi64(two, _mm_unpackhi_epi64(two, two));
    _mm_cvtsi128_si32(one).cast_unsigned()
}
