//! The score loops of x86-64, AArch64 and WebAssembly, written once over a vector trait.
//!
//! The file of an instruction set defines [`Vector`], [`Neighbours`] and [`LookUp`]; `scores!` compiles its loops.
//!
//! The score of a patch f and a template g ([`sum_at_least`]):
//!
//! ```text
//! for each row of f and g
//!     for each whole vector of the row, then for the end of the row
//!         d = |f - g|
//!         total_low  += low_bytes[d]       both are 0 from the threshold on
//!         total_high += high_bytes[d]      at the end of a row only the lanes of its pixels are added
//!     every 8 rows: return None if the score so far + 65535 * (pixels in the rows left) < floor
//! score = total_low + 256 * total_high
//! return score if it is at least floor, else None
//! ```
//!
//! [`distance`] adds d without a table. The search excludes most offsets by loops that are cheaper than the score. They
//! count pixels: a score of at least `floor` needs at least `floor / 65535` pixels with d below the threshold.
//!
//! | loop | excludes | instructions for a vector |
//! |---|---|---|
//! | [`inside_at_least`] | a 4x4 group of offsets, by pixel ranges that are widened by the threshold | 4 |
//! | [`candidates`] | each of four neighbouring offsets | 4, of them 1 to prepare the template |
//!
//! Why the loops are written like this:
//!
//! 1. **Low and high bytes apart.** Entries have 16 bits, but a lookup gives one byte for each lane. Both byte planes
//!    have their own totals, which are joined once, at the end. No lane of a total overflows ([`Vector::Total`]).
//! 2. **No comparison with the threshold.** The entries from the threshold on are 0, so the lookup does it.
//! 3. **Two sets of totals in the score**, for even and odd rows, so that additions need not wait for the row before.
//! 4. **A check every 8 rows** ([`ROWS_A_LOOK`]). It adds the lanes of the totals, which is too slow for each row. The
//!    score skips the check while the remaining rows alone could reach the floor.
//! 5. **Counts in bytes.** A comparison gives 255, which is -1, in each lane where it holds, so one subtraction counts.
//!    A lane holds at most 255, so [`Count::flush`] empties the lanes: after 8 rows of up to two vectors and an end,
//!    else after each row and after 128 vectors.
//! 6. **A range in one comparison.** low <= g <= high takes one subtraction and one comparison ([`widen`], [`around`]).
//! 7. **The width as a constant.** Rows of up to two vectors get loops in which the number of vectors (`WHOLE`) and
//!    whether an end follows (`END`) are constants (`by_width!`). If code must be small, only rows below one vector do.
//! 8. **No byte beyond a row is read.** The end of a row is loaded as the last vector that fits; lanes that overlap the
//!    vector before are masked. Rows narrower than a vector are copied ([`last`]) or loaded in parts (x86-64).
//! 9. **The last vector of ranges overlaps the one before** ([`spread`], [`ranges_of_rows`]), with the same values.
//! 10. **No closures.** A closure is a function of its own, without the `#[target_feature]` that it needs.

use super::cut_table::CutTable;
use super::rows::Rows;
use super::scores::{Effort, ONE, RowsOfRanges};
use crate::image::Image;
use core::marker::PhantomData;
use core::slice;

/// Rows between two checks whether the score can still reach the floor.
const ROWS_A_LOOK: usize = 8;

/// A vector register of pixels, and its operations. A value exists only if the processor has the instruction set, so
/// only the methods that create one are unsafe.
pub(crate) trait Vector: Copy {
    const LANES: usize;

    /// A sum of bytes, spread over several lanes. No lane overflows: even the sum of 65537 bytes is below 2^25.
    type Total: Copy;

    /// # Safety
    /// The processor has the instruction set of the vector.
    unsafe fn splat(byte: u8) -> Self;
    /// Loads bytes from any address.
    ///
    /// # Safety
    /// The processor has the instruction set of the vector. [`Vector::LANES`] bytes can be read at `from`.
    unsafe fn load(from: *const u8) -> Self;
    /// # Safety
    /// The processor has the instruction set of the vector.
    unsafe fn nothing() -> Self::Total;
    /// Mask that is 255 in the lanes of the end of a row (the pixels after its last whole vector), else 0. `WHOLE` is 0
    /// if the row has no whole vector.
    ///
    /// # Safety
    /// The processor has the instruction set of the vector.
    unsafe fn end<const WHOLE: usize>(width: usize) -> Self;
    /// Loads the end of the row that begins at `row`. Lanes outside the mask [`Vector::end`] may hold anything.
    ///
    /// # Safety
    /// The processor has the instruction set of the vector. `width` bytes can be read at `row`: more than
    /// [`Vector::LANES`] if `WHOLE` is not 0, else fewer.
    unsafe fn load_end<const WHOLE: usize>(row: *const u8, width: usize) -> Self;

    fn or(a: Self, b: Self) -> Self;
    /// Saturating subtraction: max(a - b, 0).
    fn saturating_sub(a: Self, b: Self) -> Self;
    /// Wrapping subtraction: a - b.
    fn minus(a: Self, b: Self) -> Self;
    /// 255 where a > b as signed numbers, else 0.
    fn is_above(a: Self, b: Self) -> Self;
    /// Zeroes the lanes outside the mask `end`.
    fn keep(bytes: Self, end: Self) -> Self;
    #[inline(always)]
    fn difference(f: Self, g: Self) -> Self {
        Self::or(Self::saturating_sub(f, g), Self::saturating_sub(g, f))
    }

    fn add(total: Self::Total, bytes: Self) -> Self::Total;
    fn add_distance(total: Self::Total, f: Self, g: Self) -> Self::Total;
    fn plus(a: Self::Total, b: Self::Total) -> Self::Total;
    fn times_256(total: Self::Total) -> Self::Total;
    /// The sum of the lanes.
    fn across(total: Self::Total) -> u32;
}

/// Operations for the minimum and the maximum of neighbouring pixels.
pub(crate) trait Neighbours: Vector {
    /// # Safety
    /// [`Vector::LANES`] bytes can be written at `to`.
    unsafe fn store(bytes: Self, to: *mut u8);
    fn min(a: Self, b: Self) -> Self;
    fn max(a: Self, b: Self) -> Self;
    /// Saturating addition: min(a + b, 255).
    fn raised(a: Self, b: Self) -> Self;
    /// Shifts the bytes down by `BY` lanes; zeroes fill the top.
    fn shift_down<const BY: i32>(bytes: Self) -> Self;
}

/// A similarity table in registers, with zeroes from the threshold on.
pub(crate) trait LookUp {
    type Vector: Vector;

    /// Returns the low bytes and the high bytes of the table entries for the lanes of `difference`.
    fn look_up(&self, difference: Self::Vector) -> (Self::Vector, Self::Vector);
}

/// Defines methods of the vector traits, each by an expression of intrinsics.
macro_rules! intrinsics {
    (
        $(unsafe fn $new:ident $(<const $m:ident: $from:ty>)? ($($given:ident: $in:ty),*) $(-> $out:ty)? { $made:expr })*
        $(fn $name:ident $(<const $n:ident: $of:ty>)? ($($argument:ident: $type:ty),*) -> $to:ty { $value:expr })*
    ) => {
        $(
            /// # Safety
            /// The processor has the instruction set of the vector. A vector of bytes can be read at `from` and written
            /// at `to`. `width` bytes can be read at `row`: more than a vector if `WHOLE` is not 0, else fewer.
            #[inline(always)]
            #[allow(unused_unsafe)] // some are plain expressions
            unsafe fn $new $(<const $m: $from>)? ($($given: $in),*) $(-> $out)? {
                // SAFETY: the processor has the instructions, none of which needs alignment. A vector can be read or
                // written at an address, and a row has its `width` bytes.
                unsafe { $made }
            }
        )*
        $(
            #[inline(always)]
            #[allow(unused_unsafe)]
            fn $name $(<const $n: $of>)? ($($argument: $type),*) -> $to {
                // SAFETY: an argument is a vector, which exists only if the processor has the instructions.
                unsafe { $value }
            }
        )*
    };
}

/// Value of the const parameter `WHOLE` (whole vectors in a row) in a loop that supports every number of vectors but 0.
pub(crate) const ANY: usize = usize::MAX;

/// Evaluates `$call` with two constants for rows of `$width` pixels: `WHOLE`, the number of whole vectors in a row, and
/// `END`, true if pixels follow after the whole vectors.
macro_rules! by_width {
    ($width:expr, $vector:ty, $call:expr) => {{
        use $crate::kernels::generic::{ANY, Vector};
        let width = $width;
        match (width / <$vector>::LANES, width.is_multiple_of(<$vector>::LANES)) {
            (0, _) => by_width!(@ 0, true, $call),
            #[cfg(not(smr_small))]
            (1, true) => by_width!(@ 1, false, $call),
            #[cfg(not(smr_small))]
            (1, false) => by_width!(@ 1, true, $call),
            #[cfg(not(smr_small))]
            (2, true) => by_width!(@ 2, false, $call),
            (_, true) => by_width!(@ ANY, false, $call),
            (_, false) => by_width!(@ ANY, true, $call),
        }
    }};
    (@ $whole:expr, $end:expr, $call:expr) => {{
        const WHOLE: usize = $whole;
        const END: bool = $end;
        $call
    }};
}

/// Table entries below the threshold as two byte planes (low, high). Each plane consists of segments of `SEGMENT`
/// entries, because a lookup instruction covers no more.
pub(crate) struct Lookup<V, const SEGMENT: usize, const SEGMENTS: usize> {
    pub(crate) low: [[u8; SEGMENT]; SEGMENTS],
    pub(crate) high: [[u8; SEGMENT]; SEGMENTS],
    pub(crate) segments: usize,
    /// The largest difference below the threshold, if there is one.
    pub(crate) last: Option<u8>,
    pub(crate) candidates: Effort,
    vector: PhantomData<V>,
}

impl<V, const SEGMENT: usize, const SEGMENTS: usize> Lookup<V, SEGMENT, SEGMENTS> {
    /// # Safety
    /// The processor has the instruction set of `V`.
    pub(crate) unsafe fn new(table: &CutTable) -> Self {
        let threshold = table.threshold();
        let (mut low, mut high) = ([[0; SEGMENT]; SEGMENTS], [[0; SEGMENT]; SEGMENTS]);
        let places = low.as_flattened_mut().iter_mut().zip(high.as_flattened_mut());
        // Entries from the threshold on are 0.
        let filled = if cfg!(smr_small) { table.entries().len() } else { threshold.into() };
        for ((low, high), entry) in places.zip(table.entries()).take(filled) {
            [*low, *high] = entry.to_le_bytes();
        }
        let segments = usize::from(threshold).div_ceil(SEGMENT).max(1);
        let last = threshold.checked_sub(1).and_then(|last| u8::try_from(last).ok());
        Self { low, high, segments, last, candidates: Effort::NEW, vector: PhantomData }
    }
}

/// Implements `Scores` for a [`Lookup`]. Each listed segment count gets a loop of its own, which also serves smaller
/// counts. Pixel ranges use the first listed vector type that fits in a row.
macro_rules! scores {
    (
        $backend:ty, $planes:ident, $vector:ty $(, or $shorter:ty)?, $features:literal,
        segments: $($segments:literal)* or $most:literal
    ) => {const _: () = {
        use $crate::image::Image;
        use $crate::kernels::generic::{self, by_width, compiled};
        use $crate::kernels::plain::scores as plain;
        use $crate::kernels::rows::Rows;
        use $crate::kernels::scores::{Blocks, RowsOfRanges, Scores};

        impl Scores for $backend {
            #[inline(always)]
            fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
                let rows = Rows::of(patch, template);
                // SAFETY: a backend exists only if the machine has its instructions, and the pictures are borrowed.
                unsafe {
                    match self.segments {
                        $(..=$segments => self.sum_by_width::<$segments>(&rows, floor),)*
                        _ => self.sum_by_width::<$most>(&rows, floor),
                    }
                }
            }

            #[inline(always)]
            fn ranges(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
                // SAFETY: a backend exists only if the machine has its instructions.
                unsafe { ranges(rows, self.last.unwrap_or(0), low, high) }
            }

            #[inline(always)]
            fn ranges_of_rows(&self, pixels: Image<'_>, step: usize, to: &mut RowsOfRanges<'_>) -> bool {
                // SAFETY: a backend exists only if the machine has its instructions.
                unsafe { ranges_of_rows(pixels, step, self.last.unwrap_or(0), to) }
            }

            #[inline(always)]
            fn bound(&self, blocks: &Blocks<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
                let Some(rows) = Rows::of_blocks(blocks, template) else { return Some(plain::most(template, template)) };
                if self.last.is_none() {
                    return Some(0).filter(|_| floor == 0);
                }
                // SAFETY: the backend exists, so the machine has its instructions. `of_blocks` found a range for each
                // pixel of the template, and both are borrowed.
                unsafe { by_width!(rows.width, $vector, inside_at_least::<WHOLE, END>(&rows, floor)) }
            }

            /// # Safety
            /// The patch has at least as many rows as the template, and three more columns.
            #[inline(always)]
            unsafe fn candidates(&self, patch: Image<'_>, template: Image<'_>, floor: u32, wanted: u8) -> u8 {
                if !self.candidates.is_worth_it() {
                    return wanted;
                }
                let (rows, last) = (Rows::of(patch, template), self.last.unwrap_or(0));
                // SAFETY: the backend exists, so the machine has its instructions. The pictures are borrowed, and the
                // patch has three more columns than the template.
                let candidates = unsafe { by_width!(rows.width, $vector, candidates::<WHOLE, END>(&rows, last, floor)) } & wanted;
                self.candidates.note(candidates != wanted);
                candidates
            }

            #[inline(always)]
            fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
                let rows = Rows::of(patch, template);
                // SAFETY: the backend exists, so the machine has its instructions, and the pictures are borrowed.
                unsafe { by_width!(rows.width, $vector, distance::<WHOLE, END>(&rows, enough)) }
            }
        }

        impl $backend {
            /// # Safety
            /// The processor has the features. `rows.width` pixels can be read in each row of the patch and the
            /// template.
            #[target_feature(enable = $features)]
            unsafe fn sum_by_width<const SEGMENTS: usize>(&self, rows: &Rows, floor: u32) -> Option<u32> {
                // SAFETY: the processor has the features, and each row its pixels; `by_width!` counts their vectors.
                unsafe { by_width!(rows.width, $vector, self.sum_at_least::<SEGMENTS, WHOLE, END>(rows, floor)) }
            }

            /// # Safety
            /// The processor has the features. `rows.width` pixels can be read in each row of the patch and the
            /// template. `WHOLE` and `END` are those of `by_width!` for `rows.width`.
            #[target_feature(enable = $features)]
            unsafe fn sum_at_least<const SEGMENTS: usize, const WHOLE: usize, const END: bool>(
                &self,
                rows: &Rows,
                floor: u32,
            ) -> Option<u32> {
                // SAFETY: the processor has the features, and each row its pixels, in vectors as `WHOLE` and `END` say.
                unsafe { generic::sum_at_least::<_, WHOLE, END>(&$planes::<SEGMENTS>::of(self), rows, floor) }
            }
        }

        compiled! { $features, $vector:
            fn inside_at_least(rows: &Rows, floor: u32) -> Option<u32>;
            fn candidates(rows: &Rows, last: u8, floor: u32) -> u8;
            fn distance(rows: &Rows, enough: u32) -> u32;
        }

        /// # Safety
        /// The processor has the features.
        #[target_feature(enable = $features)]
        unsafe fn ranges_of_rows(pixels: Image<'_>, step: usize, last: u8, to: &mut RowsOfRanges<'_>) -> bool {
            // SAFETY: the processor has the features, and with them the instruction sets of both vectors.
            unsafe {
                generic::ranges_of_rows::<$vector>(pixels, step, last, to)
                    $(|| generic::ranges_of_rows::<$shorter>(pixels, step, last, to))?
            }
        }

        /// # Safety
        /// The processor has the features.
        #[target_feature(enable = $features)]
        unsafe fn ranges(rows: &[&[u8]; 4], last: u8, low: &mut [u8], high: &mut [u8]) {
            // SAFETY: the processor has the features, and with them the instruction sets of both vectors.
            if !unsafe {
                generic::spread::<$vector>(rows, low, high) $(|| generic::spread::<$shorter>(rows, low, high))?
            } {
                plain::spread(rows, low, high);
            }
            generic::widen_all(low, high, last);
        }
    };};
}

/// Compiles loops of this file with the features of an instruction set.
macro_rules! compiled {
    ($features:literal, $vector:ty: $(fn $name:ident($rows:ident: &Rows $(, $argument:ident: $of:ty)*) -> $to:ty;)*) => {$(
        /// # Safety
        /// The processor has the features. `rows.width` pixels can be read in each row of the pictures, and for
        /// `candidates` three more in each row of the patch. `WHOLE` and `END` are those of `by_width!` for the width.
        #[target_feature(enable = $features)]
        unsafe fn $name<const WHOLE: usize, const END: bool>($rows: &Rows $(, $argument: $of)*) -> $to {
            // SAFETY: the processor has the features, and each row its pixels, in vectors as `WHOLE` and `END` say.
            unsafe { generic::$name::<$vector, WHOLE, END>($rows $(, $argument)*) }
        }
    )*};
}

pub(crate) use {by_width, compiled, intrinsics, scores};

/// Number of pixels in the whole vectors of a row.
#[inline(always)]
fn whole<V: Vector, const WHOLE: usize>(width: usize) -> usize {
    if WHOLE == ANY { width / V::LANES * V::LANES } else { WHOLE * V::LANES }
}

struct Sums<V: Vector> {
    low: V::Total,
    high: V::Total,
}

/// The score if it is at least `floor`, else `None`: see the pseudo-code at the top of this file.
///
/// # Safety
/// The processor has the instruction set of the vector. `rows.width` pixels can be read in each row of the patch and
/// the template. `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
pub(crate) unsafe fn sum_at_least<L: LookUp, const WHOLE: usize, const END: bool>(
    table: &L,
    rows: &Rows,
    floor: u32,
) -> Option<u32> {
    // SAFETY: the processor has the instruction set, and y is below the height, so the row has its `width` pixels.
    unsafe {
        let end = L::Vector::end::<WHOLE>(rows.width);
        // Two sets of totals, so that the additions of a row need not wait for those of the row before.
        let nothing = L::Vector::nothing();
        let mut even = Sums::<L::Vector> { low: nothing, high: nothing };
        let mut odd = Sums { low: nothing, high: nothing };
        let mut y = 0;
        while y < rows.height {
            add_row::<L, WHOLE, END>(table, rows, y, end, &mut even);
            if y + 1 < rows.height {
                add_row::<L, WHOLE, END>(table, rows, y + 1, end, &mut odd);
                let left = rows.full_after(y + 2);
                if left < floor && y % ROWS_A_LOOK == ROWS_A_LOOK - 2 && score(&even, &odd) + left < floor {
                    return None;
                }
            }
            y += 2;
        }
        Some(score(&even, &odd)).filter(|&score| score >= floor)
    }
}

/// Adds the table entries of row `y`. `end` is the mask [`Vector::end`] of the row.
///
/// # Safety
/// `y` is below `rows.height`. `rows.width` pixels can be read in this row of the patch and the template.
/// `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
unsafe fn add_row<L: LookUp, const WHOLE: usize, const END: bool>(
    table: &L,
    rows: &Rows,
    y: usize,
    end: L::Vector,
    sums: &mut Sums<L::Vector>,
) {
    // SAFETY: `end` exists, so the processor has the instruction set. No vector ends beyond the `width` of the row.
    unsafe {
        let (f, g) = rows.row(y);
        let mut at = 0;
        while at < whole::<L::Vector, WHOLE>(rows.width) {
            let (f, g) = (L::Vector::load(f.wrapping_add(at)), L::Vector::load(g.wrapping_add(at)));
            let (low, high) = table.look_up(L::Vector::difference(f, g));
            sums.low = L::Vector::add(sums.low, low);
            sums.high = L::Vector::add(sums.high, high);
            at += L::Vector::LANES;
        }
        if END {
            let f = L::Vector::load_end::<WHOLE>(f, rows.width);
            let g = L::Vector::load_end::<WHOLE>(g, rows.width);
            let (low, high) = table.look_up(L::Vector::difference(f, g));
            sums.low = L::Vector::add(sums.low, L::Vector::keep(low, end));
            sums.high = L::Vector::add(sums.high, L::Vector::keep(high, end));
        }
    }
}

/// The score: the total of low bytes plus 256 times the total of high bytes. It fits in a `u32` for every template.
#[inline(always)]
fn score<V: Vector>(even: &Sums<V>, odd: &Sums<V>) -> u32 {
    V::across(V::plus(V::plus(even.low, odd.low), V::times_256(V::plus(even.high, odd.high))))
}

/// Upper bound of a score: 65535 for each pixel inside its range (as [`widen`] encodes it). `None` once too many pixels
/// are outside to reach `floor`.
///
/// # Safety
/// The processor has the instruction set of the vector. `rows.width` bytes can be read in each row of the patch, of its
/// upper bound (`rows.high`) and of the template. `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
pub(crate) unsafe fn inside_at_least<V: Vector, const WHOLE: usize, const END: bool>(
    rows: &Rows,
    floor: u32,
) -> Option<u32> {
    // SAFETY: the processor has the instruction set, and y is below the height, so the row has its `width` pixels.
    unsafe {
        let end = V::end::<WHOLE>(rows.width);
        let pixels = rows.pixels_after(0);
        let allowed = pixels.checked_sub(Rows::pixels_of(floor))?;
        let mut count = Count { bytes: V::splat(0), flushed: 0 };
        let mut y = 0;
        while y + ROWS_A_LOOK <= rows.height {
            for row in y..y + ROWS_A_LOOK {
                count_outside::<V, WHOLE, END>(rows, row, end, &mut count);
            }
            count.flush();
            if count.flushed > allowed {
                return None;
            }
            y += ROWS_A_LOOK;
        }
        while y < rows.height {
            count_outside::<V, WHOLE, END>(rows, y, end, &mut count);
            y += 1;
        }
        count.flush();
        if count.flushed > allowed { None } else { Some((pixels - count.flushed) * u32::from(ONE)) }
    }
}

/// Counts the pixels of row `y` that are outside their ranges. `end` is the mask [`Vector::end`] of the row.
///
/// # Safety
/// `y` is below `rows.height`. `rows.width` bytes can be read in this row of the patch, of its upper bound
/// (`rows.high`) and of the template. `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
unsafe fn count_outside<V: Vector, const WHOLE: usize, const END: bool>(
    rows: &Rows,
    y: usize,
    end: V,
    count: &mut Count<V>,
) {
    // SAFETY: `end` exists, so the processor has the instruction set. No vector ends beyond the `width` of the row.
    unsafe {
        let ((low, g), span) = (rows.row(y), rows.high_row(y));
        let mut at = 0;
        while at < whole::<V, WHOLE>(rows.width) {
            let above = V::minus(V::load(g.wrapping_add(at)), V::load(low.wrapping_add(at)));
            count.add(V::is_above(above, V::load(span.wrapping_add(at))));
            at += V::LANES;
            if WHOLE == ANY && at.is_multiple_of(Count::<V>::MAX * V::LANES) {
                count.flush();
            }
        }
        if END {
            let low = V::load_end::<WHOLE>(low, rows.width);
            let span = V::load_end::<WHOLE>(span, rows.width);
            let above = V::minus(V::load_end::<WHOLE>(g, rows.width), low);
            count.add(V::keep(V::is_above(above, span), end));
        }
        if WHOLE == ANY {
            count.flush();
        }
    }
}

/// Bit mask of four neighbouring offsets: a bit is set if the score at its offset may reach `floor`. Counts the pixels
/// beyond the threshold at each offset. Each vector of the template is loaded and converted to ranges once.
///
/// # Safety
/// The processor has the instruction set of the vector. `rows.width` pixels can be read in each row of the template,
/// and three more in each row of the patch. `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
pub(crate) unsafe fn candidates<V: Neighbours, const WHOLE: usize, const END: bool>(
    rows: &Rows,
    last: u8,
    floor: u32,
) -> u8 {
    // SAFETY: the processor has the instruction set, and y is below the height, so the row has its `width` pixels.
    unsafe {
        let (end, last) = (V::end::<WHOLE>(rows.width), V::splat(last));
        let Some(allowed) = rows.pixels_after(0).checked_sub(Rows::pixels_of(floor)) else { return 0 };
        let mut counts = [Count { bytes: V::splat(0), flushed: 0 }; 4];
        let mut y = 0;
        while y < rows.height {
            let until = rows.height.min(y + ROWS_A_LOOK);
            while y < until {
                count_of_four::<V, WHOLE, END>(rows, y, end, last, &mut counts);
                y += 1;
            }
            if within(&mut counts, allowed) == 0 {
                return 0;
            }
        }
        within(&mut counts, allowed)
    }
}

/// Counts the pixels of row `y` that are beyond the threshold, at each of four offsets. `end` is the mask
/// [`Vector::end`] of the row.
///
/// # Safety
/// `y` is below `rows.height`. `rows.width` pixels can be read in this row of the template, and three more in that of
/// the patch. `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
unsafe fn count_of_four<V: Neighbours, const WHOLE: usize, const END: bool>(
    rows: &Rows,
    y: usize,
    end: V,
    last: V,
    counts: &mut [Count<V>; 4],
) {
    // SAFETY: `end` exists, so the processor has the instruction set. No vector ends beyond the `width` of the row, or
    // in the patch three columns further.
    unsafe {
        let (f, g) = rows.row(y);
        let mut at = 0;
        while at < whole::<V, WHOLE>(rows.width) {
            let (highest, span) = around(V::load(g.wrapping_add(at)), last);
            for (column, count) in counts.iter_mut().enumerate() {
                let below = V::minus(highest, V::load(f.wrapping_add(at + column)));
                count.add(V::is_above(below, span));
            }
            at += V::LANES;
            if WHOLE == ANY && at.is_multiple_of(Count::<V>::MAX * V::LANES) {
                flush_all(counts);
            }
        }
        if END {
            let (highest, span) = around(V::load_end::<WHOLE>(g, rows.width), last);
            for (column, count) in counts.iter_mut().enumerate() {
                let f = V::load_end::<WHOLE>(f.wrapping_add(column), rows.width);
                count.add(V::keep(V::is_above(V::minus(highest, f), span), end));
            }
        }
        if WHOLE == ANY {
            flush_all(counts);
        }
    }
}

/// Encodes the range of all pixels f within the threshold of `g`: f is inside if the first result minus f, as a signed
/// byte, is at most the second result.
#[inline(always)]
fn around<V: Neighbours>(g: V, last: V) -> (V, V) {
    let highest = V::minus(V::raised(g, last), half(g));
    (highest, V::minus(highest, V::saturating_sub(g, last)))
}

#[inline(always)]
fn flush_all<V: Vector>(counts: &mut [Count<V>; 4]) {
    for count in counts {
        count.flush();
    }
}

/// One bit for each count, set if the count is at most `allowed`.
#[inline(always)]
fn within<V: Vector>(counts: &mut [Count<V>; 4], allowed: u32) -> u8 {
    flush_all(counts);
    let mut within = 0;
    for (column, count) in counts.iter().enumerate() {
        within |= u8::from(count.flushed <= allowed) << column;
    }
    within
}

/// Number of pixels that passed a comparison.
#[derive(Clone, Copy)]
struct Count<V> {
    /// Count of each lane since the last flush, at most 255.
    bytes: V,
    flushed: u32,
}

impl<V: Vector> Count<V> {
    /// Number of vectors of a row between two flushes: a power of two, below the 255 that a lane can count.
    const MAX: usize = 128;

    /// Adds 1 in each lane that is 255 in `counts`. The other lanes of `counts` are 0.
    #[inline(always)]
    fn add(&mut self, counts: V) {
        self.bytes = V::minus(self.bytes, counts); // 255 is -1
    }

    #[inline(always)]
    fn flush(&mut self) {
        // SAFETY: `bytes` exists, so the processor has the instruction set.
        unsafe {
            self.flushed += V::across(V::add(V::nothing(), self.bytes));
            self.bytes = V::splat(0);
        }
    }
}

/// The sum of absolute differences. Stops once it exceeds `enough`.
///
/// # Safety
/// The processor has the instruction set of the vector. `rows.width` pixels can be read in each row of the patch and
/// the template. `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
pub(crate) unsafe fn distance<V: Vector, const WHOLE: usize, const END: bool>(rows: &Rows, enough: u32) -> u32 {
    // SAFETY: the processor has the instruction set, and y is below the height, so the row has its `width` pixels.
    unsafe {
        let (end, mut sum) = (V::end::<WHOLE>(rows.width), V::nothing());
        let mut y = 0;
        while y + ROWS_A_LOOK <= rows.height {
            for row in y..y + ROWS_A_LOOK {
                sum = add_row_distance::<V, WHOLE, END>(rows, row, end, sum);
            }
            if V::across(sum) > enough {
                return V::across(sum);
            }
            y += ROWS_A_LOOK;
        }
        while y < rows.height {
            sum = add_row_distance::<V, WHOLE, END>(rows, y, end, sum);
            y += 1;
        }
        V::across(sum)
    }
}

/// Adds the absolute differences in row `y` to `sum`. `end` is the mask [`Vector::end`] of the row.
///
/// # Safety
/// `y` is below `rows.height`. `rows.width` pixels can be read in this row of the patch and the template.
/// `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
unsafe fn add_row_distance<V: Vector, const WHOLE: usize, const END: bool>(
    rows: &Rows,
    y: usize,
    end: V,
    mut sum: V::Total,
) -> V::Total {
    // SAFETY: `end` exists, so the processor has the instruction set. No vector ends beyond the `width` of the row.
    unsafe {
        let (f, g) = rows.row(y);
        let mut at = 0;
        while at < whole::<V, WHOLE>(rows.width) {
            sum = V::add_distance(sum, V::load(f.wrapping_add(at)), V::load(g.wrapping_add(at)));
            at += V::LANES;
        }
        if END {
            let f = V::keep(V::load_end::<WHOLE>(f, rows.width), end);
            let g = V::keep(V::load_end::<WHOLE>(g, rows.width), end);
            sum = V::add_distance(sum, f, g);
        }
        sum
    }
}

/// Lowest and highest pixel of 4x4 blocks. Returns false, and does nothing, if there are fewer blocks than lanes.
///
/// # Safety
/// The processor has the instruction set of the vector.
#[inline(always)]
pub(crate) unsafe fn spread<V: Neighbours>(rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) -> bool {
    let columns = rows.iter().map(|row| row.len().saturating_sub(3)).min().unwrap_or(0).min(low.len()).min(high.len());
    let Some(last) = columns.checked_sub(V::LANES) else { return false };
    let rows = rows.each_ref().map(|row| row.as_ptr());
    let (low, high) = (low.as_mut_ptr(), high.as_mut_ptr());
    let mut at = 0;
    // SAFETY: the processor has the instruction set. Every row has `columns` bytes and three more, `low` and `high`
    // have `columns`; at + LANES is less than `columns`, last + LANES equals it.
    unsafe {
        while at < last {
            let (lowest, highest) = column_ranges::<V>(&rows, at);
            let lowest = V::min(lowest, V::shift_down::<1>(lowest));
            let highest = V::max(highest, V::shift_down::<1>(highest));
            V::store(V::min(lowest, V::shift_down::<2>(lowest)), low.wrapping_add(at));
            V::store(V::max(highest, V::shift_down::<2>(highest)), high.wrapping_add(at));
            // The last three lanes are incomplete. The next round computes them again.
            at += V::LANES - 3;
        }
        // The last vector overlaps the one before. To complete all lanes, loads at four columns replace shifts.
        let (mut lowest, mut highest) = (V::splat(u8::MAX), V::splat(0));
        for column in 0..4 {
            let ranges = column_ranges::<V>(&rows, last + column);
            (lowest, highest) = (V::min(lowest, ranges.0), V::max(highest, ranges.1));
        }
        V::store(lowest, low.wrapping_add(last));
        V::store(highest, high.wrapping_add(last));
    }
    true
}

/// Half the number of byte values. Subtracting it from bytes, modulo 256, gives signed numbers in the same order.
const HALF: u8 = 128;

#[inline(always)]
pub(crate) fn half<V: Vector>(_: V) -> V {
    // SAFETY: the argument exists, so the processor has the instruction set.
    unsafe { V::splat(HALF) }
}

/// Widens ranges by `last` and encodes them for [`inside_at_least`]: g is inside if low - last <= g <= high + last,
/// that is, if g - (low - last), modulo 256, is at most (high + last) - (low - last). Vectors compare signed numbers,
/// so both sides have [`HALF`] subtracted: the results are low - last - HALF, and high + last minus the first result.
#[inline(always)]
fn widen<V: Neighbours>(low: V, high: V, last: V) -> (V, V) {
    let low_less_half = V::minus(V::saturating_sub(low, last), half(low));
    (low_less_half, V::minus(V::raised(high, last), low_less_half))
}

#[inline(always)]
pub(crate) fn widen_all(low: &mut [u8], high: &mut [u8], last: u8) {
    for (low, high) in low.iter_mut().zip(high) {
        let (least, most) = (low.saturating_sub(last), high.saturating_add(last));
        *low = least.wrapping_sub(HALF);
        *high = most.wrapping_sub(*low);
    }
}

/// Computes rows of pixel ranges, as [`widen`] encodes them. Returns false, and does nothing, if a row has fewer ranges
/// than a vector has lanes, or if `to` is too small. Reads strips as wide as a vector, each from top to bottom. The
/// minima and maxima of each pair of rows serve two ranges.
///
/// # Safety
/// The processor has the instruction set of the vector.
#[inline(always)]
pub(crate) unsafe fn ranges_of_rows<V: Neighbours>(
    pixels: Image<'_>,
    step: usize,
    last: u8,
    to: &mut RowsOfRanges<'_>,
) -> bool {
    let (columns, height) = (usize::from(pixels.width()).saturating_sub(3), usize::from(pixels.height()));
    let Some(last_strip) = columns.checked_sub(V::LANES) else { return false };
    let rows = height.saturating_sub(3).div_ceil(step.max(1));
    let needed = rows.saturating_sub(1).saturating_mul(to.stride).saturating_add(columns);
    if columns > to.stride || rows == 0 || needed > to.low.len().min(to.high.len()) {
        return false;
    }
    let (pixels, stride) = pixels.parts();
    let mut at = 0;
    loop {
        let (low, high) = (to.low.as_mut_ptr().wrapping_add(at), to.high.as_mut_ptr().wrapping_add(at));
        let mut row = pixels.as_ptr().wrapping_add(at);
        let mut place = 0;
        // SAFETY: the processor has the instruction set. Every row has `columns` pixels and three more, at + LANES is
        // at most `columns`. The last store ends with the ranges of row `rows` - 1 of `to`, whose `needed` bytes exist.
        unsafe {
            let last = V::splat(last);
            let (mut before, mut pairs) = (fours::<V>(row), [(V::splat(0), V::splat(0)); 2]);
            for y in 1..height {
                row = row.wrapping_add(stride);
                let present = fours::<V>(row);
                let pair = (V::min(before.0, present.0), V::max(before.1, present.1));
                if y >= 3 && (step == 1 || (y - 3).is_multiple_of(step)) {
                    let lowest = V::min(pairs[1].0, pair.0);
                    let highest = V::max(pairs[1].1, pair.1);
                    let (lowest, span) = widen(lowest, highest, last);
                    V::store(lowest, low.wrapping_add(place));
                    V::store(span, high.wrapping_add(place));
                    place += to.stride;
                }
                (before, pairs) = (present, [pair, pairs[0]]);
            }
        }
        if at == last_strip {
            return true;
        }
        // The last strip overlaps the strip before it, and stores the same values there again.
        at = last_strip.min(at + V::LANES);
    }
}

/// For each pixel of a vector, the minimum and the maximum of that pixel and the next three.
///
/// # Safety
/// The processor has the instruction set of the vector. A vector and three more pixels can be read at `row`.
#[inline(always)]
unsafe fn fours<V: Neighbours>(row: *const u8) -> (V, V) {
    // SAFETY: the processor has the instruction set. No load ends beyond the three pixels after the vector.
    unsafe { column_ranges(&[row, row.wrapping_add(1), row.wrapping_add(2), row.wrapping_add(3)], 0) }
}

/// The lowest and the highest pixel of four rows in each column from `at` on.
///
/// # Safety
/// The processor has the instruction set of the vector. A vector can be read in each of the rows, from `at` on.
#[inline(always)]
unsafe fn column_ranges<V: Neighbours>(rows: &[*const u8; 4], at: usize) -> (V, V) {
    let [a, b, c, d] = *rows;
    // SAFETY: the processor has the instruction set, and each of the rows has a vector from `at` on.
    let ([a, b], [c, d]) = unsafe {
        let load = [V::load(a.wrapping_add(at)), V::load(b.wrapping_add(at))];
        (load, [V::load(c.wrapping_add(at)), V::load(d.wrapping_add(at))])
    };
    (V::min(V::min(a, b), V::min(c, d)), V::max(V::max(a, b), V::max(c, d)))
}

/// Maximum number of lanes that [`last_lanes`] and [`last`] support.
const MAX_LANES: usize = 32;

/// Mask (255) of the last `width % LANES` lanes, into which [`last`] loads the end of a row.
///
/// # Safety
/// The processor has the instruction set of the vector.
#[inline(always)]
pub(crate) unsafe fn last_lanes<V: Vector>(width: usize) -> V {
    const BYTES: [[u8; MAX_LANES]; 2] = [[0; MAX_LANES], [u8::MAX; MAX_LANES]];
    // SAFETY: the processor has the instruction set. The vector ends in the second half of the bytes.
    unsafe { V::load(BYTES.as_flattened().as_ptr().wrapping_add(MAX_LANES - V::LANES + width % V::LANES)) }
}

/// Loads the end of a row into the last lanes. Earlier lanes hold earlier pixels of the row, or zeroes if `WHOLE` is 0.
///
/// # Safety
/// The processor has the instruction set of the vector. `width` bytes can be read at `row`: more than LANES if `WHOLE`
/// is not 0, else fewer.
#[inline(always)]
pub(crate) unsafe fn last<V: Vector, const WHOLE: usize>(row: *const u8, width: usize) -> V {
    // SAFETY: the processor has the instruction set. The row is longer than the vector that ends with it; the copy of a
    // shorter row ends with its vector.
    unsafe {
        if WHOLE > 0 {
            return V::load(row.wrapping_add(width).wrapping_sub(V::LANES));
        }
        let mut pixels = [0; MAX_LANES];
        let row = slice::from_raw_parts(row, width);
        pixels.iter_mut().rev().zip(row.iter().rev()).for_each(|(to, &from)| *to = from);
        V::load(pixels.as_ptr().wrapping_add(MAX_LANES - V::LANES))
    }
}
