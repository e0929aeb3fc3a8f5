//! Sums of products: bytes, as the filter sees a picture, times numbers of 16 bits. The plain loops; they specify what a backend
//! computes.

/// How a filter lies on bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    /// Bytes under a row of the filter.
    pub(crate) row: usize,
    /// Bytes from there to those under its next row; also from an offset to the next one below.
    pub(crate) stride: usize,
    /// Bytes from an offset to the next one to the right.
    pub(crate) step: usize,
    /// Offsets on each axis.
    pub(crate) span: usize,
}

/// `out[y][x]` is the sum over all weights of `weight * byte` at the offset (x, y).
///
/// No sum may leave an `i32`: at most 2000 weights of at most 8191 reach 2000 * 8191 * 128 < 2^31.
#[inline(always)] // a backend compiles it for its own instruction set
pub(crate) fn responses<const N: usize>(cells: &[i8], layout: Layout, weights: &[i16], out: &mut [[i32; N]]) {
    let Layout { row, stride, step, span } = layout;
    for (y, out) in out.iter_mut().take(span).enumerate() {
        for (x, out) in out.iter_mut().take(span).enumerate() {
            let rows = weights.chunks(row.max(1)).zip((y * stride + x * step..).step_by(stride.max(1)));
            *out = rows.map(|(weights, from)| dot(cells.get(from..).unwrap_or_default(), weights)).sum();
        }
    }
}

#[inline(always)]
fn dot(cells: &[i8], weights: &[i16]) -> i32 {
    cells.iter().zip(weights).map(|(&cell, &weight)| i32::from(cell) * i32::from(weight)).sum()
}

/// The other way round: to each weight's sum the products of all `errors` with the byte that the weight lies on at that offset.
///
/// No sum may leave an `i32`: 4 samples of 13 * 13 errors of at most 16383 reach 4 * 169 * 16383 * 128 < 2^31.
#[inline(always)]
pub(crate) fn gather<const N: usize>(cells: &[i8], layout: Layout, errors: &[[i16; N]], sums: &mut [i32]) {
    let Layout { row, stride, step, span } = layout;
    for (y, errors) in errors.iter().take(span).enumerate() {
        for (sums, from) in sums.chunks_mut(row.max(1)).zip((y * stride..).step_by(stride.max(1))) {
            for (x, &error) in errors.iter().take(span).enumerate() {
                let cells = cells.get(from + x * step..).unwrap_or_default();
                for (sum, &cell) in sums.iter_mut().zip(cells) {
                    *sum += i32::from(error) * i32::from(cell);
                }
            }
        }
    }
}
