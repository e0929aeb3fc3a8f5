//! Tests every backend against `plain/products.rs`.

use super::backends::for_each_backend;
use super::guard::{Guarded, Side};
use super::noise::noise;
use crate::kernels::backend::Backend;
use crate::kernels::layout::{Layout, Packed};
use crate::kernels::plain::products::{gather, responses};
use crate::kernels::products::Products;
use std::vec::Vec;

fn same<const N: usize>(backend: Backend, cells: &[i8], layout: Layout, down: usize) {
    let products = Products::new(backend);
    let weights: Vec<i16> = noise(layout.row * down, 5, 8191).collect();
    let (mut given, mut expected) = ([[7; N]; N], [[7; N]; N]);
    let (mut room, mut spare) = (Packed::new(), [0; 2000]);
    for part in 0..products.parts(layout, weights.len()) {
        products.responses(part..part + 1, &mut room, &mut spare, cells, layout, &weights, &mut given);
    }
    responses(0..layout.span, &mut Packed::new(), &mut [], cells, layout, &weights, &mut expected);
    for (given, expected) in given.iter().zip(&expected).take(layout.span) {
        assert_eq!(given[..layout.span], expected[..layout.span], "{backend:?}: {layout:?}, {down} rows");
    }
    let mut errors = [[0; N]; N];
    errors.as_flattened_mut().iter_mut().zip(noise(N * N, 9, 16_383)).for_each(|(to, from)| *to = from);
    let mut sums: Vec<i32> = noise(layout.row * down, 3, 9000).collect();
    let mut wanted = sums.clone();
    for part in 0..products.gather_parts(layout, sums.len()) {
        products.gather(part..part + 1, &mut room, &mut spare, cells, layout, &errors, &mut sums);
    }
    gather(0..layout.span, &mut Packed::new(), &mut [], cells, layout, &errors, &mut wanted);
    assert_eq!(sums, wanted, "{backend:?}: {layout:?}, {down} rows");
}

/// Tests filters of all shapes, with no more cells than they need.
fn all_shapes(backend: Backend) {
    let mut memory = Guarded::with_room(1 << 14);
    for (across, down) in (4..=32).map(|across| (across, 200 / across)).chain([(1, 1), (4, 4), (5, 7), (14, 14)]) {
        for span in [1, 2, 3, 13, 17] {
            let layout = Layout { row: across * 10, stride: (across + span - 1) * 10, step: 10, span };
            let count = layout.stride * (down + span - 1);
            for side in [Side::After, Side::Before] {
                let cells = memory.copy_signed(&noise(count, 77, 127).collect::<Vec<_>>(), side);
                if span <= 13 {
                    same::<13>(backend, cells, layout, down);
                }
                same::<17>(backend, cells, layout, down);
            }
        }
    }
}

/// With odd layouts and missing cells the results equal those of the plain loops, and nothing else is read.
fn odd_shapes(backend: Backend) {
    let mut memory = Guarded::with_room(1 << 14);
    for (row, step, cut, stride) in [(35, 10, 0, 90), (40, 7, 0, 90), (40, 10, 25, 70), (30, 10, 0, 30), (0, 10, 0, 0)]
    {
        let layout = Layout { row, stride, step, span: 5 };
        let cells: Vec<i8> = noise((stride * 9).saturating_sub(cut), 3, 127).collect();
        let cells = memory.copy_signed(&cells, Side::After);
        same::<13>(backend, cells, layout, 5);
    }
}

/// The largest possible sums.
fn extremes(backend: Backend) {
    let products = Products::new(backend);
    for (cell, sign) in [(-128i8, 1i16), (-128, -1), (127, 1)] {
        let cells = std::vec![cell; 26 * 36 * 10];
        let layout = Layout { row: 200, stride: 360, step: 10, span: 17 };
        let mut out = [[0; 17]; 17];
        products.responses(0..17, &mut Packed::new(), &mut [0; 2000], &cells, layout, &[sign * 8191; 2000], &mut out);
        assert_eq!(out, [[2000 * 8191 * i32::from(sign) * i32::from(cell); 17]; 17], "{backend:?}");
        let mut sums = [0; 2000];
        products.gather(
            0..17,
            &mut Packed::new(),
            &mut [0; 2000],
            &cells,
            layout,
            &[[sign * 16_383; 17]; 17],
            &mut sums,
        );
        assert_eq!(sums, [289 * 16_383 * i32::from(sign) * i32::from(cell); 2000], "{backend:?}");
    }
}

for_each_backend!(all_shapes, odd_shapes, extremes);
