//! The kernels of a filter at extreme values and in all shapes (feature `verify`): sums of products, weights, bilinear
//! sampling.
//!
//! The unit tests of the crate do not run on a microcontroller. There `examples/conformance` calls this.

use super::noise::Noise;
use crate::kernels::backend::Backend;
use crate::kernels::bilinear::Interpolation;
use crate::kernels::layout::{Layout, Packed};
use crate::kernels::plain::bilinear::{BIAS, MixedRow};
use crate::kernels::products::Products;
use crate::kernels::weights::{GradientStep, ScaledSums, scale_by};

/// Features of a cell.
const STEP: usize = 10;
/// The most offsets on an axis.
const SPAN: usize = 17;
/// The most weights.
const WEIGHTS: usize = 2000;
/// Numbers at and beside the bounds of all types.
const EXTREMES: [i32; 12] =
    [0, 1, -1, 1023, -1024, 65_536, -65_537, 1 << 30, -(1 << 30), i32::MAX, -i32::MAX, i32::MIN];

/// Compares the kernels of a filter with the plain loops.
///
/// # Panics
/// If they differ.
///
/// ```
/// smr_core::similarity::verify_filter();
/// ```
#[inline(never)]
pub fn verify_filter() {
    let mut noise = Noise::new(1);
    for (across, down) in [(4, 4), (5, 40), (6, 32), (7, 9), (13, 15), (14, 14), (15, 13), (32, 6)] {
        for span in (1..=SPAN).step_by(2) {
            for extreme in [false, true] {
                products(across, down, span, extreme, &mut noise);
            }
        }
    }
    weights(&mut noise);
    columns(&mut noise);
    #[cfg(feature = "refiner")]
    super::layers::layers(&mut noise);
}

/// Compares sums of products; with the largest possible ones if `extreme`.
#[inline(never)] // keeps its stack out of the caller's frame
fn products(across: usize, down: usize, span: usize, extreme: bool, noise: &mut Noise) {
    let products = Products::new(Backend::best());
    let stride = (across + span - 1) * STEP;
    let layout = Layout { row: across * STEP, stride, step: STEP, span };
    let mut small = |most: u32, least: i16| if extreme { least } else { i16::try_from(noise.next(most)).unwrap_or(0) };
    let mut room = Packed::new();
    let cells: heapless::Vec<i8, 12_000> =
        (0..stride * (down + span - 1)).map(|_| i8::try_from(small(127, -128)).unwrap_or(0)).collect();
    let filter: heapless::Vec<i16, WEIGHTS> = (0..across * down * STEP).map(|_| small(8191, -8191)).collect();
    let (mut out, mut spare) = ([[0; SPAN]; SPAN], [0; WEIGHTS]);
    for part in 0..products.parts(layout, filter.len()) {
        products.responses(part..part + 1, &mut room, &mut spare, &cells, layout, &filter, &mut out);
    }
    let errors = [(); SPAN].map(|()| [(); SPAN].map(|()| small(16_383, 16_383)));
    let mut sums: heapless::Vec<i32, WEIGHTS> = filter.iter().map(|_| small(9000, -9000).into()).collect();
    let parts = products.gather_parts(layout, sums.len());
    products.gather(0..parts, &mut room, &mut spare, &cells, layout, &errors, &mut sums);
}

/// Compares weights, in counts that fill the last vector differently.
#[inline(never)] // keeps its stack out of the caller's frame
fn weights(noise: &mut Noise) {
    for count in 0..21 {
        let any = |noise: &mut Noise| *EXTREMES.get(noise.next(11).unsigned_abs() as usize).unwrap_or(&0);
        let weights: heapless::Vec<i32, 20> = (0..count).map(|_| any(noise)).collect();
        let mut out = [0; 21];
        let mut code = |numbers: ScaledSums<'_>| {
            let largest = numbers.largest();
            let least = (0..32).find(|shift| largest >> shift < 8191).unwrap_or(0);
            (least..32).for_each(|shift| numbers.code(shift, &mut out));
        };
        code(ScaledSums::of(&weights));
        for (unit, left) in [(14, 2), (14, 5), (16, 0), (17, 0), (19, 0)] {
            // The largest sums that fit after a shift by `left`, and sums so small that rounding drops them.
            for most in [(1 << 30) >> left, 1] {
                let sums: heapless::Vec<i32, 20> = (0..count).map(|_| noise.next(most)).collect();
                let weights: heapless::Vec<i32, 20> = sums.iter().rev().copied().collect();
                code(ScaledSums { weights: &weights, factor: 5056 << (32 - unit), sums: &sums, left });
            }
        }
        let slopes: heapless::Vec<i16, 20> =
            (0..count).map(|at| if at % 3 == 0 { i16::MIN } else { low(noise.next(i16::MAX as u32)) }).collect();
        for length in [0, 1, -1, (1 << 32) - 1, 1 << 40, (1 << 47) - 1, -(1 << 46), 0x1234_5678_9ABC] {
            for back in 0..48 {
                GradientStep { length, back }.apply(&mut weights.clone(), &slopes);
            }
        }
        let mut slopes: heapless::Vec<i16, 20> = (0..count.min(16)).map(|_| low(noise.next(8191))).collect();
        for part in [16_384, 16_383, 8192, 1, 0] {
            scale_by(&mut slopes, part);
            slopes.iter_mut().for_each(|slope| *slope = if *slope % 2 == 0 { 8191 } else { -8191 });
        }
    }
}

fn low(number: i32) -> i16 {
    i16::try_from(number).unwrap_or(0)
}

/// Compares columns of a resampled row.
#[inline(never)] // keeps its stack out of the caller's frame
fn columns(noise: &mut Noise) {
    let mut columns = Interpolation::<40>::new();
    for column in 0..40 {
        columns.push(u16::try_from(noise.next(255).unsigned_abs()).unwrap_or(0), 255 - column * 6);
    }
    let mut row: MixedRow = [0; Interpolation::<40>::PLACES + 4];
    for extreme in [true, false] {
        for level in &mut row {
            let noise = u16::try_from(noise.next(255 * 256).unsigned_abs()).unwrap_or(0);
            *level = (if extreme { noise % 2 * 255 * 256 } else { noise }).wrapping_sub(BIAS);
        }
        (0..41).for_each(|count| columns.mix(&row, [0; 40].get_mut(..count.min(40)).unwrap_or_default()));
    }
}
