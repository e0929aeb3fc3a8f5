//! Compares the filter's sums of products and the layers of the network with the plain loops.

use super::areas::{Areas, Noise, STEP, check, fill, part, signed};
use crate::kernels::backend::Backend;
use crate::kernels::layout::{Layout, Packed};
use crate::kernels::plain;
#[cfg(feature = "refiner")]
use crate::kernels::plain::dense::Layer;
use crate::kernels::products::Products;
#[cfg(feature = "refiner")]
use crate::kernels::products::{Dense, SPARE};

/// Compares filter responses and gradients: many filter shapes, the largest sums, and invalid layouts.
#[inline(never)]
pub(in crate::kernels) fn products(backend: Backend, areas: &mut Areas<'_>) {
    let odd = [(4, 4), (5, 40), (6, 32), (4, 50), (14, 14), (32, 6), (1, 1), (7, 9), (13, 15)];
    let shapes = (4..=32).map(|across| (across, (1 + across * 5 % 13).min(200 / across)));
    let shapes = odd.into_iter().chain(shapes).enumerate().step_by(STEP);
    // Cells and weights of the largest absolute values, with equal and with opposite signs, then noise.
    for (cell, sign, count) in [(128, Some(-1), 6), (128, Some(1), 6), (127, Some(1), 6), (0, None, usize::MAX)] {
        areas.end.fill(cell);
        if sign.is_none() {
            fill(areas);
        }
        let spans = |number| [1 + number % 17, 2, 13, 17].map(|span| (number, span));
        for ((across, down), (number, span)) in
            shapes.clone().take(count).flat_map(|(number, shape)| spans(number).map(|span| (shape, span)))
        {
            let layout = Layout { row: across * 10, stride: (across + span - 1) * 10, step: 10, span };
            let cells = signed(part(areas.end, number % 3 > 0, layout.stride * (down + span - 1)));
            if span <= 13 && number % 2 > 0 {
                sums::<13>(backend, cells, layout, down, sign);
            } else {
                sums::<17>(backend, cells, layout, down, sign);
            }
        }
    }
    for (row, step, cut, stride) in [(35, 10, 0, 90), (40, 7, 0, 90), (40, 10, 25, 70), (30, 10, 0, 30), (0, 10, 0, 0)]
    {
        let layout = Layout { row, stride, step, span: 5 };
        let cells = signed(part(areas.end, true, (stride * 9usize).saturating_sub(cut)));
        sums::<13>(backend, cells, layout, 5, None);
    }
}

/// Compares responses and gradients, computed piece by piece, with those of the plain loops. Weights are noise within
/// +-8191 and errors noise within +-16383, or all are `sign` times these limits.
fn sums<const N: usize>(backend: Backend, cells: &[i8], layout: Layout, down: usize, sign: Option<i16>) {
    let products = Products::new(backend);
    let mut noise = Noise(5);
    let mut number = |most: i16| sign.map_or_else(|| noise.next(most as u32) as i16, |sign| sign * most);
    let mut weights = [0; 2000];
    let weights = &mut weights[..layout.row * down];
    weights.fill_with(|| number(8191));
    let errors: [[i16; N]; N] = core::array::from_fn(|_| core::array::from_fn(|_| number(16_383)));
    for spare in [0, 2000] {
        let (mut room, mut scratch) = (Packed::new(), [7; 2000]);
        let spare = &mut scratch[..spare];
        let (mut given, mut expected) = ([[7; N]; N], [[7; N]; N]);
        for piece in 0..products.pieces(layout, weights.len()) {
            products.responses(piece..piece + 1, &mut room, spare, cells, layout, weights, &mut given);
        }
        plain::products::responses(0..layout.span, &mut Packed::new(), &mut [], cells, layout, weights, &mut expected);
        let row = ..layout.span;
        let right = given[row].iter().zip(&expected[row]).all(|(given, expected)| given[row] == expected[row]);
        check(right, "responses", backend, (layout, down, sign));
        let (mut given, mut expected) = ([9000; 2000], [9000; 2000]);
        let [given, expected] = [&mut given, &mut expected].map(|sums| &mut sums[..weights.len()]);
        for piece in 0..products.gather_pieces(layout, weights.len()) {
            products.gather(piece..piece + 1, &mut room, spare, cells, layout, &errors, given);
        }
        plain::products::gather(0..layout.span, &mut Packed::new(), &mut [], cells, layout, &errors, expected);
        check(given == expected, "gathered errors", backend, (layout, down, sign));
    }
}

/// Compares layers of a network with the formula, for noise and for the largest sums. If a layer's slices are too
/// short, compares it with the plain loop.
#[cfg(feature = "refiner")]
#[inline(never)]
pub(in crate::kernels) fn dense(backend: Backend, areas: &mut Areas<'_>) {
    // (patches, inputs, outputs) of the refiner's layers but the last, and of two unusual layers.
    let known = [(16, 20, 8), (8, 72, 16), (8, 144, 24), (4, 216, 24), (1, 384, 24), (1, 4, 1), (2, 17, 5)];
    let odd = [(1, 1), (2, 1), (3, 2), (2, 3), (5, 5), (7, 4)];
    let odd = (4..=80).step_by(4).chain([220, 380]).zip(odd.into_iter().cycle()).map(|(inputs, (n, o))| (n, inputs, o));
    fill(areas);
    // Noise, then the largest numbers.
    for sign in [0, 1, -1] {
        let mut noise = Noise(9);
        let biases = [(); 24].map(|()| if sign == 0 { noise.next(200_000) } else { sign << 27 }.to_le_bytes());
        for (weight, x) in areas.end.iter_mut().zip(&mut *areas.other_end) {
            let (any, most) = ((*weight).cast_signed().max(-127), 127 * sign as i8);
            *weight = if sign == 0 { any } else { most }.cast_unsigned();
            *x = if sign == 0 { *x & 127 } else { 127 };
        }
        for (number, (count, inputs, outputs)) in known.into_iter().chain(odd.clone()).enumerate().step_by(STEP) {
            let last = number % 3 > 0;
            let weights = signed(part(areas.end, last, inputs * outputs));
            let patches = signed(part(areas.other_end, last, count * inputs));
            // With biases of 0, the products alone determine the result.
            let none = [[0; 4]; 24];
            for (biases, shift) in [(&biases, 20), (&biases, 21), (&biases, 22), (&none, 0), (&none, 9), (&none, 13)] {
                let layer = Layer { inputs, weights, biases: &biases[..outputs], shift };
                // Scratch memory at different alignments, or none.
                for room in [0..SPARE, 1..SPARE + 1, 0..0] {
                    let (mut spare, mut out) = ([77; SPARE + 1], [55; 256]);
                    Dense::new(backend).outputs(layer, patches, &mut spare[room], &mut out[..count * outputs]);
                    let right = patches.chunks(inputs).zip(out.chunks(outputs)).all(|(patch, out)| {
                        let sums = weights.chunks(inputs).zip(biases).map(|(weights, &bias)| {
                            let products = patch.iter().zip(weights).map(|(&x, &w)| i64::from(x) * i64::from(w));
                            (i64::from(i32::from_le_bytes(bias)) + products.sum::<i64>()) >> shift
                        });
                        out.iter().zip(sums).all(|(&out, sum)| i64::from(out) == sum.clamp(0, 127))
                    });
                    check(right, "layer", backend, (count, inputs, outputs, shift, sign));
                }
            }
        }
    }
    areas.end.fill(100);
    for (inputs, weights, patches) in [(16, 31, 32), (16, 32, 33), (16, 0, 16), (0, 32, 32), (15, 30, 30), (16, 32, 0)]
    {
        let weights = signed(part(areas.end, true, weights));
        let layer = Layer { inputs, weights, biases: &[[1, 0, 0, 0]; 2], shift: 11 };
        let (mut given, mut wanted) = ([9; 7], [9; 7]);
        Dense::new(backend).outputs(layer, &[100; 33][..patches], &mut [0; SPARE], &mut given);
        plain::dense::outputs(layer, &[100; 33][..patches], &mut [], &mut wanted);
        check(given == wanted, "layer with missing numbers", backend, (inputs, weights.len(), patches));
    }
}
