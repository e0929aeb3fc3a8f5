//! Traits of a vector register of pixels, and its loads at the end of a row.

use core::slice;

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

pub(crate) use intrinsics;

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
