//! Sums of products: bytes, as the filter sees a picture, times numbers of 16 bits. The plain loops; they specify what a backend
//! computes.
//!
//! A *row* of weights lies on a row of bytes; `stride` bytes on, the next row of weights lies. Offsets side by side are
//! `step` bytes apart.

use super::Backend;

/// How sums of products are computed. All ways give the same integers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Products(Backend);

impl Products {
    /// By `backend`; by the plain loops where the machine does not have it.
    pub(crate) fn new(backend: Backend) -> Self {
        Self(backend)
    }

    /// See [`responses`].
    pub(crate) fn responses(
        self,
        cells: &[i8],
        stride: usize,
        step: usize,
        weights: &[i16],
        row: usize,
        out: &mut [i32],
    ) {
        let _ = self.0;
        responses(cells, stride, step, weights, row, out);
    }

    /// See [`gather`].
    pub(crate) fn gather(self, cells: &[i8], stride: usize, step: usize, errors: &[i16], row: usize, sums: &mut [i32]) {
        gather(cells, stride, step, errors, row, sums);
    }
}

/// `out[k]` is the sum over all weights of `weight * byte`, the weights' first byte being `k * step`.
///
/// No sum may leave an `i32`: at most 2000 weights of at most 8191 reach 2000 * 8191 * 128 < 2^31.
pub(crate) fn responses(cells: &[i8], stride: usize, step: usize, weights: &[i16], row: usize, out: &mut [i32]) {
    for (offset, out) in out.iter_mut().enumerate() {
        let rows = weights.chunks(row.max(1)).zip((offset * step..).step_by(stride.max(1)));
        *out = rows.map(|(weights, from)| dot(cells.get(from..).unwrap_or_default(), weights)).sum();
    }
}

#[inline]
fn dot(cells: &[i8], weights: &[i16]) -> i32 {
    cells.iter().zip(weights).map(|(&cell, &weight)| i32::from(cell) * i32::from(weight)).sum()
}

/// The other way round: to each weight's sum the products of all `errors` with the byte that the weight lies on at that offset.
///
/// No sum may leave an `i32`: 4 samples of 13 * 13 errors of at most 16383 reach 4 * 169 * 16383 * 128 < 2^31.
pub(crate) fn gather(cells: &[i8], stride: usize, step: usize, errors: &[i16], row: usize, sums: &mut [i32]) {
    for (sums, from) in sums.chunks_mut(row.max(1)).zip((0..).step_by(stride.max(1))) {
        for (offset, &error) in errors.iter().enumerate() {
            let cells = cells.get(from + offset * step..).unwrap_or_default();
            for (sum, &cell) in sums.iter_mut().zip(cells) {
                *sum += i32::from(error) * i32::from(cell);
            }
        }
    }
}
