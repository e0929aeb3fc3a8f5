//! Refinement: the early template gives place and size to a fraction of a pixel. From the best alignment, one
//! Gauss-Newton step (Lucas and Kanade, 1981; Baker and Matthews, 2004) gives the target's move (right and down) and
//! growth.
//!
//! ```text
//! minimise  sum over pixels p of  (e(p) + s(p) . (x, y, g))^2,    e = seen - template, clamped to +-alpha
//! (x, y, g) = -(S + D)^-1 * sum s(p) e(p),    S = sum s(p) s(p)^T,    D = diagonal of S / 64
//! ```
//!
//! | symbol | what | unit | bound |
//! |---|---|---|---|
//! | `s` | right, down: 4 m, where m is the mean slope of both pictures; outward: m . place / 8 | gray level | 510, 1130 |
//! | `S` | their products, summed over at most 1600 pixels | | 2^31 |
//! | `x`, `y` | move | 1/64 pixel of the grid | +-64 |
//! | `g` | growth | 1/65536 | +-1310 |
//!
//! The step is taken only if the early template agrees well. Cost: 40 instructions of a Cortex-M4 for each pixel.

use super::super::arithmetic::quotient;
use super::super::features::row_of;
use super::agreement::REFINED_FROM;
use super::coarse_alignment::Alignment;
use crate::image::Image;
use crate::kernels::rolled;

/// The largest move by the Gauss-Newton step of refinement on each axis, in units of 1/64 pixel of the grid: one pixel.
const MAX_MOVE: i64 = 64;
/// The largest growth or shrinkage of the target by the Gauss-Newton step of refinement, in units of 1/65536: 2 %.
const MAX_GROWTH: i32 = 1310;
/// The exponent of the damping (Levenberg) of refinement: each diagonal element of the normal equations grows by 2^-6
/// of itself. Without damping, a target with a single edge could slide along that edge.
const DAMPING: u32 = 6;

/// Units of work for each pixel of the template in refinement.
pub(crate) const REFINED: u32 = 40;
/// The largest number of bits of a sum of squares when the normal equations are solved.
const BITS_OF_SUMS: u32 = 12;

/// The target's offset from the view's middle, in units of 1/64 pixel of the grid, and its growth, in units of 1/65536.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Refined {
    pub(crate) x: i32,
    pub(crate) y: i32,
    pub(crate) growth: i32,
}

/// Refines an alignment by comparing `seen`, the patch there, with `relit`, the relit template. Returns `None` if
/// `agreement` is below `REFINED_FROM`. `alpha` is at most 100 gray levels.
pub(crate) fn refine(
    agreement: u16,
    (right, down): Alignment,
    seen: Image<'_>,
    relit: Image<'_>,
    alpha: u16,
) -> Option<Refined> {
    if agreement < REFINED_FROM {
        return None;
    }
    let (x, y, growth) = NormalEquations::of(seen, relit, alpha.into()).step();
    Some(Refined { x: 64 * i32::from(right) + x, y: 64 * i32::from(down) + y, growth })
}

/// The normal equations: sums over all pixels except those at the edge. The slopes `across` (to the right) and `down`
/// are four times those of the mean of patch and template, so at most 510. If (u, v) is twice the pixel's offset from
/// the middle, the slope `outward` is `(across * u + down * v) / 64`: at most 510 * (columns + rows) / 64 < 1130.
#[derive(Clone, Copy, Default)]
struct NormalEquations {
    /// Sums of squared slopes to the right, down and outward: the diagonal of the matrix S.
    squares: [i32; 3],
    /// Sums of products of two slopes (right and down, right and outward, down and outward): the elements of S off the
    /// diagonal.
    products: [i32; 3],
    /// For each slope, the sum of its products with the pixels' differences `seen` - `relit`, clamped to +-`alpha`.
    errors: [i32; 3],
}

impl NormalEquations {
    #[inline(never)] // keeps its stack out of the tracker's `step`
    fn of(seen: Image<'_>, relit: Image<'_>, alpha: i32) -> Self {
        let mut equations = Self::default();
        let from_middle = |at: usize, size: u16| 2 * i32::try_from(at).unwrap_or(0) + 3 - i32::from(size);
        for y in 1..seen.height().saturating_sub(1) {
            let v = from_middle(usize::from(y) - 1, seen.height());
            let three = |image| [y - 1, y, y + 1].map(|y| row_of(image, y, 0));
            let ([above, here, below], [relit_above, relit_here, relit_below]) = (three(seen), three(relit));
            let vertical = above.iter().zip(below).zip(relit_above.iter().zip(relit_below)).skip(1);
            let horizontal = here.windows(3).zip(relit_here.windows(3));
            for (x, ((seen, relit), ((above, below), (relit_above, relit_below)))) in
                rolled(horizontal.zip(vertical).enumerate())
            {
                let ([left, seen, right], [relit_left, relit, relit_right]) = (seen, relit) else { continue };
                let slope = |from: u8, to: u8, relit_from: u8, relit_to: u8| {
                    i32::from(to) - i32::from(from) + i32::from(relit_to) - i32::from(relit_from)
                };
                let across = slope(*left, *right, *relit_left, *relit_right);
                let down = slope(*above, *below, *relit_above, *relit_below);
                let outward = (across * from_middle(x, relit_here.len().try_into().unwrap_or(0)) + down * v) >> 6;
                equations.add([across, down, outward], (i32::from(*seen) - i32::from(*relit)).clamp(-alpha, alpha));
            }
        }
        equations
    }

    fn add(&mut self, [across, down, outward]: [i32; 3], error: i32) {
        let Self { squares, products, errors } = self;
        let add = |to: &mut [i32; 3], what: [i32; 3]| to.iter_mut().zip(what).for_each(|(to, what)| *to += what);
        add(squares, [across * across, down * down, outward * outward]);
        add(products, [across * down, across * outward, down * outward]);
        add(errors, [across * error, down * error, outward * error]);
    }

    /// Solves (S + D) * (x, y, growth) = -`errors` by Cramer's rule. S is `squares` and `products`, D the damping.
    ///
    /// All sums are shifted until the largest square is below 2^12, so the minors are at most 2^25. The sum of squared
    /// differences is below 2^24, so by the Cauchy-Schwarz inequality 256 times a sum in `errors` is at most 2^26. Sums
    /// of products of minors and errors stay below 2^53.
    #[inline(never)] // gives it registers of its own
    fn step(&self) -> (i32, i32, i32) {
        let squares = self.squares.map(|square| square.unsigned_abs() + (square.unsigned_abs() >> DAMPING));
        let largest = squares.into_iter().max().unwrap_or(0);
        let shift = (u32::BITS - largest.leading_zeros()).saturating_sub(BITS_OF_SUMS).cast_signed();
        // x: across, y: down, g: outward. The matrix and its minors are symmetric.
        let [xx, yy, gg] = squares.map(|square| i32::try_from(square >> shift).unwrap_or(0) + 1);
        let [xy, xg, yg] = self.products.map(|product| toward_zero(product, shift));
        // Multiplies `errors` by 256: a move is in units of 1/64 pixel, and slopes are stored four times as steep.
        let errors = self.errors.map(|error| toward_zero(error, shift - 8));
        let (minor_xx, minor_yy, minor_gg) = (yy * gg - yg * yg, xx * gg - xg * xg, xx * yy - xy * xy);
        let (minor_xy, minor_xg, minor_yg) = (xg * yg - xy * gg, xy * yg - xg * yy, xy * xg - yg * xx);
        let determinant = products([minor_xx, minor_xy, minor_xg], [xx, xy, xg]);
        let solve = |minors| solution(products(minors, errors), determinant);
        let growth = -32 * solve([minor_xg, minor_yg, minor_gg]);
        let (x, y) = (-solve([minor_xx, minor_xy, minor_xg]), -solve([minor_xy, minor_yy, minor_yg]));
        (x, y, growth.clamp(-MAX_GROWTH, MAX_GROWTH))
    }
}

fn toward_zero(number: i32, power: i32) -> i32 {
    if power < 0 { number << -power } else { number / (1 << power) }
}

#[inline(never)]
fn products(some: [i32; 3], others: [i32; 3]) -> i64 {
    some.iter().zip(others).map(|(&some, other)| i64::from(some) * i64::from(other)).sum()
}

/// `sum` / `determinant`, clamped to +-`MAX_MOVE`; 0 if the determinant is not positive.
#[inline(never)]
fn solution(sum: i64, determinant: i64) -> i32 {
    let times = if determinant > 0 { quotient(sum, determinant) } else { 0 };
    i32::try_from(times.clamp(-MAX_MOVE, MAX_MOVE)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn waves((columns, rows): (u16, u16), (right, down, growth): (f64, f64, f64)) -> Vec<u8> {
        let pixel = |x: u16, y: u16| {
            let from_middle = |at: u16, size: u16| f64::from(at) - (f64::from(size) - 1.0) / 2.0;
            let (u, v) = (from_middle(x, columns) - right, from_middle(y, rows) - down);
            let (u, v) = (u / (1.0 + growth), v / (1.0 + growth));
            128.0 + 50.0 * (0.4 * u + 0.1 * v).sin() + 40.0 * (0.5 * v - 0.2 * u).cos()
        };
        (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))).map(|(x, y)| pixel(x, y).round() as u8).collect()
    }

    fn step(seen: &[u8], relit: &[u8], (columns, rows): (u16, u16)) -> (i32, i32, i32) {
        let image = |pixels| Image::new(pixels, columns, rows).unwrap();
        NormalEquations::of(image(seen), image(relit), 100).step()
    }

    #[test]
    fn an_exact_match_stays_and_others_come_near() {
        let size = (40, 40);
        let relit = waves(size, (0.0, 0.0, 0.0));
        assert_eq!(step(&relit, &relit, size), (0, 0, 0));
        for by in [(0.5, 0.0, 0.0), (0.0, -0.5, 0.0), (0.0, 0.0, 0.01), (-0.3, 0.4, -0.015)] {
            let (x, y, growth) = step(&waves(size, by), &relit, size);
            let found = (f64::from(x) / 64.0, f64::from(y) / 64.0, f64::from(growth) / 65_536.0);
            let near = |found: f64, by: f64, most: f64| (found - by).abs() < most;
            assert!(
                near(found.0, by.0, 0.06) && near(found.1, by.1, 0.06) && near(found.2, by.2, 0.003),
                "{by:?}: {found:?}"
            );
        }
    }

    #[test]
    fn steps_have_bounds() {
        let size = (40, 40);
        let relit = waves(size, (0.0, 0.0, 0.0));
        for by in [(0.0, 0.0, 0.1), (0.0, 0.0, -0.1), (2.0, 2.0, 0.0), (-2.0, -2.0, 0.0)] {
            let (x, y, growth) = step(&waves(size, by), &relit, size);
            assert!(x.abs() <= 64 && y.abs() <= 64 && growth.abs() <= 1310, "{by:?}: {x} {y} {growth}");
        }
    }

    /// Chessboards and their inverses have the largest slopes and differences. Overflow would panic.
    #[test]
    fn the_largest_sums() {
        for (columns, rows) in [(40, 40), (128, 12), (12, 128), (4, 4), (126, 4)] {
            for side in [1, 2, 3] {
                let board = |turn: u16| -> Vec<u8> {
                    let white = |x: u16, y: u16| (x / side + y / side + turn).is_multiple_of(2);
                    (0..rows).flat_map(|y| (0..columns).map(move |x| if white(x, y) { 255 } else { 0 })).collect()
                };
                for (seen, relit) in [(0, 0), (0, 1), (1, 0)] {
                    let (x, y, growth) = step(&board(seen), &board(relit), (columns, rows));
                    assert!(x.abs() <= 64 && y.abs() <= 64 && growth.abs() <= 1310);
                }
            }
        }
    }

    /// A single edge does not show motion along itself, and a plain picture shows no motion.
    #[test]
    fn nothing_moves_along_an_edge() {
        let edge = |from: u16| -> Vec<u8> { (0..1600).map(|at: u16| if at % 40 < from { 50 } else { 150 }).collect() };
        let (x, y, growth) = step(&edge(13), &edge(12), (40, 40));
        assert!(x != 0 && y == 0, "{x} {y} {growth}");
        assert_eq!(step(&[90; 1600], &[80; 1600], (40, 40)), (0, 0, 0));
    }

    #[test]
    fn what_agrees_poorly_says_nothing() {
        let pixels = [90; 1600];
        let image = Image::new(&pixels, 40, 40).unwrap();
        assert_eq!(refine(54_999, (1, -2), image, image, 100), None);
        assert_eq!(refine(55_000, (1, -2), image, image, 100), Some(Refined { x: 64, y: -128, growth: 0 }));
    }
}
