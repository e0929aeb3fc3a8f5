//! Sums of products by SIMD128: an instruction multiplies eight pairs of 16-bit numbers and adds neighbouring products.

use crate::kernels::layout::{Layout, Packed};
use crate::kernels::plain::products as plain;
use core::arch::wasm32::*;
use core::ops::Range;

pub(crate) use plain::{GATHER_PIECES, TAKES_ROWS_OF_CELLS};

/// Number of 16-bit lanes in a vector.
const LANES: usize = 8;

/// Filter offsets computed at a time, which share the loads of the weights.
const AT_ONCE: usize = 4;

/// Start and mask of each vector of a row. The last ends with the row; its mask omits the overlap with the one before.
fn vectors(row: usize) -> impl Iterator<Item = (usize, v128)> {
    let whole = (0..row / LANES).map(|number| (number * LANES, u8x16_splat(u8::MAX)));
    let rest = row % LANES;
    whole.chain((rest > 0).then(|| (row - LANES, last_lanes(rest))))
}

fn last_lanes(count: usize) -> v128 {
    const LAST: [i16; 2 * LANES] = [0, 0, 0, 0, 0, 0, 0, 0, -1, -1, -1, -1, -1, -1, -1, -1];
    // SAFETY: the vector begins at most at the ninth number of sixteen.
    unsafe { v128_load(LAST.as_ptr().wrapping_add(count % LANES).cast()) }
}

pub(crate) fn responses<const N: usize>(
    pieces: Range<usize>,
    room: &mut Packed,
    spare: &mut [i32],
    cells: &[i8],
    layout: Layout,
    weights: &[i16],
    out: &mut [[i32; N]],
) {
    if layout.checked_height(cells.len(), weights.len()).is_none() {
        return plain::responses(pieces, room, spare, cells, layout, weights, out);
    }
    let Layout { stride, step, span, .. } = layout;
    for y in pieces.start..pieces.end.min(span) {
        let Some(out) = out.get_mut(y) else { return };
        let out = out.get_mut(..span.min(N)).unwrap_or_default();
        let at = |x: usize| cells.as_ptr().wrapping_add(y * stride + x * step);
        let (groups, rest) = out.as_chunks_mut::<AT_ONCE>();
        for (number, group) in groups.iter_mut().enumerate() {
            // SAFETY: y and the x of the group are below the span, where all cells exist (`checked_height`).
            *group = unsafe { responses_at(at(number * AT_ONCE), layout, weights) };
        }
        for (response, x) in rest.iter_mut().zip(groups.len() * AT_ONCE..) {
            // SAFETY: y and x are below the span, where all cells exist (`checked_height`).
            [*response] = unsafe { responses_at(at(x), layout, weights) };
        }
    }
}

/// Filter responses at `COUNT` neighbouring offsets. `first` is the top left cell under the filter at the first offset.
///
/// # Safety
/// `weights` has whole rows of `layout.row` weights, at least a vector each. For each of these rows, `layout.row` bytes
/// can be read at each of the `COUNT` offsets, `layout.stride` after those of the row before. Offsets are `layout.step`
/// bytes apart, and begin at `first`.
#[inline(always)]
unsafe fn responses_at<const COUNT: usize>(first: *const i8, layout: Layout, weights: &[i16]) -> [i32; COUNT] {
    let Layout { row, stride, step, .. } = layout;
    let mut sums = [i32x4_splat(0); COUNT];
    for (down, weights) in weights.chunks_exact(row).enumerate() {
        let first = first.wrapping_add(down * stride);
        for (at, mask) in vectors(row) {
            // SAFETY: no vector ends beyond the `row` weights, or beyond the `row` cells under them at each offset.
            unsafe {
                let weights = v128_and(v128_load(weights.as_ptr().wrapping_add(at).cast()), mask);
                for (x, sum) in sums.iter_mut().enumerate() {
                    let cells = i16x8_load_extend_i8x8(first.wrapping_add(x * step + at));
                    *sum = i32x4_add(*sum, i32x4_dot_i16x8(cells, weights));
                }
            }
        }
    }
    sums.map(across)
}

fn across(sum: v128) -> i32 {
    let halves = i32x4_add(sum, i32x4_shuffle::<2, 3, 0, 1>(sum, sum));
    i32x4_extract_lane::<0>(halves) + i32x4_extract_lane::<1>(halves)
}

pub(crate) fn gather<const N: usize>(
    pieces: Range<usize>,
    room: &mut Packed,
    spare: &mut [i32],
    cells: &[i8],
    layout: Layout,
    errors: &[[i16; N]],
    sums: &mut [i32],
) {
    if layout.checked_height(cells.len(), sums.len()).is_none() || layout.span > N {
        return plain::gather(pieces, room, spare, cells, layout, errors, sums);
    }
    let Layout { row, stride, step, span } = layout;
    for y in pieces.start..pieces.end.min(span) {
        let Some(errors) = errors.get(y) else { return };
        for (down, sums) in sums.chunks_exact_mut(row).enumerate() {
            let cells = cells.as_ptr().wrapping_add((y + down) * stride);
            for (at, mask) in vectors(row) {
                let sums = sums.as_mut_ptr().wrapping_add(at);
                // SAFETY: y and all x are below the span, where all cells exist. No vector ends beyond its row.
                unsafe { gather_at(cells.wrapping_add(at), step, mask, errors.get(..span).unwrap_or_default(), sums) }
            }
        }
    }
}

/// Adds products of errors and cells to eight neighbouring sums of a gradient; lanes outside `mask` stay unchanged.
/// `first` is the cell that the first error is multiplied by for the first sum.
///
/// # Safety
/// Eight bytes can be read at `first` and at every `step` bytes after it, once for each error. Eight numbers can be
/// read and written at `sums`.
#[inline(always)]
unsafe fn gather_at(first: *const i8, step: usize, mask: v128, errors: &[i16], sums: *mut i32) {
    // SAFETY: both halves lie in the eight sums, and eight cells are loaded at each offset.
    unsafe {
        let (low, high): (*mut v128, *mut v128) = (sums.cast(), sums.wrapping_add(LANES / 2).cast());
        let mut total = (v128_load(low), v128_load(high));
        let cells = |x: usize| i16x8_load_extend_i8x8(first.wrapping_add(x * step));
        let (pairs, last) = errors.as_chunks::<2>();
        for (number, pair) in pairs.iter().enumerate() {
            // Two offsets at once: their cells alternate in the lanes, and so do their errors.
            let errors = v128_load32_splat(pair.as_ptr().cast());
            total = add_products(total, cells(2 * number), cells(2 * number + 1), errors, mask);
        }
        if let [error] = last {
            total = add_products(total, cells(errors.len() - 1), i16x8_splat(0), i16x8_splat(*error), mask);
        }
        v128_store(low, total.0);
        v128_store(high, total.1);
    }
}

#[inline(always)]
fn add_products(total: (v128, v128), one: v128, other: v128, errors: v128, mask: v128) -> (v128, v128) {
    let (one, other) = (v128_and(one, mask), v128_and(other, mask));
    let low = i16x8_shuffle::<0, 8, 1, 9, 2, 10, 3, 11>(one, other);
    let high = i16x8_shuffle::<4, 12, 5, 13, 6, 14, 7, 15>(one, other);
    (i32x4_add(total.0, i32x4_dot_i16x8(low, errors)), i32x4_add(total.1, i32x4_dot_i16x8(high, errors)))
}
