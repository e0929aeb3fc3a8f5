//! Compares sums of products.

use crate::kernels::layout::{Layout, Packed};
use crate::kernels::plain::products as plain;

/// Checks all responses.
#[track_caller]
pub(crate) fn responses<const N: usize>(out: &[[i32; N]], cells: &[i8], layout: Layout, weights: &[i16]) {
    let mut expected = [[0; N]; N];
    plain::responses(0..layout.span, &mut Packed::new(), &mut [], cells, layout, weights, &mut expected);
    for (given, expected) in out.iter().zip(&expected).take(layout.span) {
        let row = ..layout.span.min(N);
        assert_eq!(given.get(row), expected.get(row), "responses, given and expected");
    }
}

/// Checks sums to which the whole gradient was added.
#[track_caller]
pub(crate) fn gather<const N: usize>(
    sums: &[i32],
    before: &mut heapless::Vec<i32, 4096>,
    cells: &[i8],
    layout: Layout,
    errors: &[[i16; N]],
) {
    plain::gather(0..layout.span, &mut Packed::new(), &mut [], cells, layout, errors, before);
    assert_eq!(sums, &**before, "gathered errors, given and expected");
}
