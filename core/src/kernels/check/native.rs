//! Compares the kernels that are selected at compile time with formulas.

use super::areas::{Areas, Noise, STEP, fill, part, part_mut};
use crate::kernels::layout::{CELL, CHANNELS, SIDE};
use crate::kernels::native::{GradientStep, Interpolation, ScaledSums, deviation, features, gradients, norms, replace};
use crate::kernels::plain;
use crate::kernels::plain::levels::{BIAS, MixedRow};

#[inline(never)]
pub(in crate::kernels) fn native(areas: &mut Areas<'_>) {
    weights();
    columns();
    cells();
    norms_of_rows();
    gray_levels(areas);
}

/// Compares the kernels on filter weights with formulas, for 0 to 20 weights, which fill the last vector differently.
fn weights() {
    // Values at the limits of an `i32`, and near other powers of 2.
    const EXTREMES: [i32; 12] =
        [0, 1, -1, 1023, -1024, 65_536, -65_537, 1 << 30, -(1 << 30), i32::MAX, -i32::MAX, i32::MIN];
    let mut noise = Noise(7);
    for count in 0..21 {
        let mut weights = [(); 20].map(|()| EXTREMES[noise.bits() as usize % EXTREMES.len()]);
        let weights = &mut weights[..count.min(20)];
        scaled(ScaledSums::of(weights));
        for (unit, left) in [(14, 2), (14, 5), (16, 0), (17, 0), (19, 0)] {
            // Numbers within +-2^(30 - left), so that no value overflows, then numbers of -1 to 1, for which a product
            // with `factor / 2^32` rounds to 0 or -1.
            for most in [(1 << 30) >> left, 1] {
                let sums: [i32; 20] = core::array::from_fn(|_| noise.next(most));
                let mut reversed = sums;
                reversed.reverse();
                let (weights, sums) = (&reversed[..weights.len()], &sums[..weights.len()]);
                scaled(ScaledSums { weights, factor: 5056 << (32 - unit), sums, left });
            }
        }
        let slopes: [i16; 20] =
            core::array::from_fn(|at| if at % 3 == 0 { i16::MIN } else { noise.next(i16::MAX as u32) as i16 });
        for length in [0, 1, -1, (1 << 32) - 1, 1 << 40, (1 << 47) - 1, -(1 << 46), 0x1234_5678_9ABC] {
            for back in 0..63 {
                let mut moved = [5; 20];
                let moved = &mut moved[..weights.len()];
                moved.copy_from_slice(weights);
                GradientStep { length, back }.apply(moved, &slopes);
                for ((&moved, &weight), &slope) in moved.iter().zip(&*weights).zip(&slopes) {
                    let change = (i64::from(slope) * length + (1 << back >> 1)) >> back;
                    let expected = i32::try_from(i64::from(weight) - change).unwrap_or(weight);
                    assert_eq!(moved, expected, "{weight} less {slope} * {length} >> {back}");
                }
            }
        }
    }
}

/// Compares the largest absolute value of `numbers` with the formula, and their quantised values for every shift up to
/// 31 that takes this largest value below 8191.
fn scaled(numbers: ScaledSums<'_>) {
    let ScaledSums { weights, factor, sums, left } = numbers;
    let number = |factor, (&weight, &sum): (&i32, &i32)| {
        ((i128::from(weight) * i128::from(factor)) >> 32) as i64 + (i64::from(sum) << left)
    };
    // The absolute value, rounded toward zero. `number` rounds down, so for a negative value the product is negated.
    let size = |pair: (&i32, &i32)| match number(factor, pair) {
        number @ 0.. => number,
        _ => number(-factor, pair) - 2 * (i64::from(*pair.1) << left),
    };
    let largest = numbers.largest();
    let expected = weights.iter().zip(sums).map(size).max().unwrap_or(0);
    assert_eq!(i64::from(largest), expected, "the largest of {weights:?}, {sums:?} << {left}, factor {factor}");
    for shift in (0..32).skip_while(|shift| largest >> shift >= 8191) {
        let mut coded = [7; 21];
        numbers.code(shift, &mut coded);
        for (pair, &coded) in weights.iter().zip(sums).zip(&coded) {
            let expected = (number(factor, pair) + (1 << shift >> 1)) >> shift;
            assert_eq!(i64::from(coded), expected, "{pair:?} << {left}, factor {factor}, coded by {shift}");
        }
        assert!(coded[weights.len()..].iter().all(|&coded| coded == 7), "{} numbers are coded", weights.len());
    }
}

fn columns() {
    let mut noise = Noise(11);
    let mut places = [(0, 0); 40];
    let mut columns = Interpolation::<40>::new();
    for (column, place) in (0..).zip(&mut places) {
        *place = ((noise.bits() % 512) as u16, 255 - column * 6);
        columns.push(place.0, place.1);
    }
    let mut row: MixedRow = [0; Interpolation::<40>::LEFT_SAMPLES + 4];
    for extreme in [true, false] {
        row.fill_with(|| {
            let level = noise.bits() % (255 * 256 + 1);
            ((if extreme { level % 2 * 255 * 256 } else { level }) as u16).wrapping_sub(BIAS)
        });
        for count in 0..=40 {
            let mut out = [7; 40];
            columns.mix(&row, &mut out[..count]);
            let expected = |number: usize| {
                let (place, part) = places[number];
                let [first, second] = [0, 1].map(|next| u32::from(row[usize::from(place) + next].wrapping_add(BIAS)));
                ((first * (256 - u32::from(part)) + second * u32::from(part) + (1 << 15)) >> 16) as u8
            };
            assert_eq!(out, core::array::from_fn(|at| if at < count { expected(at) } else { 7 }), "{count} columns");
        }
    }
}

fn cells() {
    /// Cells in the longest row of the robust tracker.
    const ROW: usize = 48;
    let mut noise = Noise(13);
    for (across, most) in (0..=ROW).flat_map(|across| [2, 30, 255].map(|most| (across, most))) {
        let mut lines = [[0; ROW * CELL as usize + 2]; SIDE];
        lines.as_flattened_mut().fill_with(|| match most {
            2 => ((noise.bits() >> 9) as u8 & 1).wrapping_neg(),
            most => noise.near(0, most),
        });
        let (mut sums, mut energies) = ([[7; ROW]; CHANNELS], [7; ROW]);
        gradients(&lines, &mut sums, &mut energies, across);
        for (number, &energy) in energies[..across].iter().enumerate() {
            let wanted = plain::gradients::cell(&lines, number * usize::from(CELL));
            assert_eq!((energy, sums.map(|row| row[number])), (wanted.energy(), wanted.0), "cell {number} of {across}");
        }
        let inverses = [(); ROW].map(|()| noise.bits() % 162_561);
        let (mut given, mut expected) = ([[0; CHANNELS]; ROW], [[0; CHANNELS]; ROW]);
        features(&sums, &inverses, &mut given[..across]);
        plain::gradients::features(&sums, &inverses, &mut expected[..across]);
        assert_eq!(given, expected, "features of {across} cells");
    }
}

/// Compares norms with the formula: for random energies, for the smallest mean energy whose norm is at least `case`,
/// and for that energy less 1.
fn norms_of_rows() {
    let mut noise = Noise(17);
    for (case, kind) in (0..47_200_u32).step_by(STEP).flat_map(|case| [0, 1, 2].map(|kind| (case, kind))) {
        let (across, rows, shift) = (2 + case as usize % 20, 1 + case % 3, noise.bits() % 32);
        let energies: [u32; 22] = core::array::from_fn(|_| match kind {
            0 => (noise.bits() >> shift) % (rows * 5900 * 5900),
            kind => rows * ((case * case).div_ceil(64) + 1).saturating_sub(kind).min(5900 * 5900),
        });
        let mut given = energies;
        norms(&mut given[..across], rows, |norm| 3 * norm);
        for (at, &norm) in given[..across].iter().enumerate() {
            let around = &energies[at.saturating_sub(1)..across.min(at + 2)];
            let mean = around.iter().sum::<u32>() / (rows * around.len() as u32);
            assert_eq!(norm, 3 * (64 * mean).isqrt(), "norm {at} of {across} in {rows} rows");
        }
        assert_eq!(given[across..], energies[across..], "norms of {across} columns");
    }
}

fn gray_levels(areas: &mut Areas<'_>) {
    fill(areas);
    for (length, level) in (0..=300).chain([1024, 4099, 65_535]).zip([0, 255, 1, 100, 254].into_iter().cycle()) {
        if length == 65_535 {
            areas.end.fill(!level);
        }
        let last = length % 3 > 0;
        let (old, new) = (part_mut(areas.end, last, length), part(areas.other_end, last, length));
        let sum = old.iter().map(|&pixel| u32::from(pixel.abs_diff(level))).sum();
        let clipped = old.iter().filter(|&&pixel| pixel == 0 || pixel == 255).count() as u32;
        assert_eq!(deviation(old, level), [sum, clipped], "{length} pixels at {level}");
        let largest = old.iter().zip(new).map(|(old, &new)| old.abs_diff(new)).fold(level % 7, u8::max);
        assert_eq!(replace(old, new, level % 7), largest, "the largest difference of {length} pixels");
        assert!(old == new, "{length} pixels are replaced");
        old.iter_mut().for_each(|pixel| *pixel = pixel.wrapping_mul(31).wrapping_add(level));
    }
}
