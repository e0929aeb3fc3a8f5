//! Exact position and size: the best alignment of the early template in whole pixels, then a Gauss-Newton step.

use super::Numbers;
use super::lighting::{gain, relit, threshold};
use super::rounding::{SCALE, SUB, to_f64, to_zero};
use super::sampling::Patch;
use super::verification::Similarity;

pub struct Aligned {
    /// Offset of the best alignment from the view's middle, in template pixels.
    pub x: i64,
    pub y: i64,
    pub seen: Patch,
}

/// Scores nine offsets `coarse_step` pixels apart, then the eight around the best offset, with the template adapted to
/// the lighting of the middle patch. Ties keep the earlier offset: the middle, then row by row.
pub fn aligned(numbers: &Numbers, similarity: &Similarity, view: &Patch, early: &Patch, expected: f64) -> Aligned {
    let margin = numbers.margin;
    let cut =
        |x: i64, y: i64| view.cut(margin + x, margin + y, early.columns, early.rows).expect("it lies in the view");
    let middle = cut(0, 0);
    let gain = gain(numbers, early, &middle, expected);
    let (lit, alpha) = (relit(early, &middle, gain), threshold(numbers, early, &middle, gain));
    let (mut best, mut highest) = ((0, 0), similarity.score(&middle, &lit, alpha));
    for step in [numbers.coarse_step, 1] {
        let (x, y) = best;
        for (right, down) in (-1..=1).flat_map(|down| (-1..=1).map(move |right| (right, down))) {
            let place = (x + step * right, y + step * down);
            let score = similarity.score(&cut(place.0, place.1), &lit, alpha);
            if score > highest {
                (best, highest) = (place, score);
            }
        }
    }
    Aligned { x: best.0, y: best.1, seen: cut(best.0, best.1) }
}

/// Move right and down in template pixels, multiples of 1/64; relative growth of the target, a multiple of 1/65536.
pub struct Step {
    pub x: f64,
    pub y: f64,
    pub growth: f64,
}

/// Gauss-Newton step from the early template to the patch: minimises the sum of (error + slope * (x, y) + outward *
/// growth)^2 over the inner pixels. Here `error` is patch minus adapted template, clamped to +-alpha; `slope` is the
/// gradient of the mean of the two; `outward` is the dot product of `slope` and the pixel's offset from the middle.
pub fn step(numbers: &Numbers, early: &Patch, seen: &Patch, gain: f64) -> Step {
    let (lit, alpha) = (relit(early, seen, gain), threshold(numbers, early, seen, gain));
    let mut sums = [[0.0; 4]; 3];
    for (y, x) in (1..seen.rows - 1).flat_map(|y| (1..seen.columns - 1).map(move |x| (y, x))) {
        let both = |x: i64, y: i64| seen.row(x, y, 1)[0] + lit.row(x, y, 1)[0];
        let (across, down) = (both(x + 1, y) - both(x - 1, y), both(x, y + 1) - both(x, y - 1));
        let from_middle = |at: i64, size: i64| to_f64(2 * at + 1 - size);
        let outward = across * from_middle(x, seen.columns) + down * from_middle(y, seen.rows);
        let error = (seen.row(x, y, 1)[0] - lit.row(x, y, 1)[0]).clamp(-alpha, alpha);
        let row = [across, down, (outward / 64.0).floor(), error];
        for (sums, slope) in sums.iter_mut().zip(row) {
            sums.iter_mut().zip(row).for_each(|(sum, other)| *sum += slope * other);
        }
    }
    solve(numbers, sums)
}

/// Solves the normal equations. A row of `sums` has three coefficients and the right side.
fn solve(numbers: &Numbers, sums: [[f64; 4]; 3]) -> Step {
    let square = |at: usize| sums[at][at] + (sums[at][at] / numbers.damping).floor();
    let largest = (0..3).map(square).fold(0.0, f64::max);
    let mut unit = 1.0;
    while (largest / unit).floor() >= numbers.most_sum {
        unit *= 2.0;
    }
    let number = |row: usize, column: usize| {
        if row == column { (square(row) / unit).floor() + 1.0 } else { to_zero(sums[row][column] / unit, 1.0) }
    };
    let wanted = [0, 1, 2].map(|row: usize| to_zero(256.0 * sums[row][3] / unit, 1.0));
    // Minors of the matrix, for Cramer's rule.
    let minor = |row: usize, column: usize| {
        let ((a, b), (c, d)) = (((row + 1) % 3, (row + 2) % 3), ((column + 1) % 3, (column + 2) % 3));
        number(a, c) * number(b, d) - number(a, d) * number(b, c)
    };
    let determinant: f64 = (0..3).map(|column| number(0, column) * minor(0, column)).sum();
    let part = |row: usize, by: f64, most: f64| {
        let sum: f64 = (0..3).map(|column| minor(row, column) * wanted[column]).sum();
        let part = if determinant > 0.0 { by * to_zero(sum / determinant, 1.0) } else { 0.0 };
        part.clamp(-most, most)
    };
    let (most_move, most_growth) = (numbers.most_move * SUB, numbers.most_growth);
    Step {
        x: part(0, -1.0, most_move) / SUB,
        y: part(1, -1.0, most_move) / SUB,
        growth: part(2, -32.0, most_growth) / SCALE,
    }
}
