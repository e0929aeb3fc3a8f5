//! Where exactly, and how large: the early template at pixel resolution.
//!
//! The filter sees cells of 4x4 pixels, so it errs by a pixel or more, and it learns where it says that the target is, so its errors add
//! up. The early template hardly learns. It is compared (by SMR) at places up to three pixels from the filter's: first two pixels apart,
//! then one. Where it agrees well, the differences that are left tell parts of a pixel and the growth, by one Gauss-Newton step. What
//! matches exactly stays where it is.

use super::features::CELL;
use super::grid::row_of;
use super::trust::is_certain;
use crate::image::Image;
use crate::kernels::rolled;

/// How far the template is compared to each side, in pixels of the grid; the view has so many more on each side.
pub(super) const MARGIN: u16 = 3;
/// The same in whole cells: so much more than a search window may be read.
pub(super) const RIM: u16 = MARGIN.div_ceil(CELL);
/// Places that are compared: the middle and those around it, then those around the best one.
pub(super) const PLACES: u16 = 17;
/// Pixels from one place to the next at first.
const FAR: i16 = 2;
/// The most that a step moves, in units of 1/64 pixel, and grows, in units of 1/65536.
const MOST_MOVE: i64 = 64;
const MOST_GROWTH: i32 = 1310;
/// Each sum of squared slopes grows by a 64th, so that edges of one direction alone do not move it along them.
const MORE: u32 = 6;
/// Binary places of the largest sum when the equations are solved.
const PLACES_OF_SUMS: u32 = 12;

/// The place that was best so far.
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    pub(super) at: (i16, i16),
    /// The place around which others lie.
    middle: (i16, i16),
    score: u32,
}

impl Nearest {
    pub(super) const fn new() -> Self {
        Self { at: (0, 0), middle: (0, 0), score: 0 }
    }

    /// The column and row of the view that the template begins on there.
    pub(super) fn in_view(self) -> [u16; 2] {
        // No place is farther from the middle than the margin.
        [self.at.0, self.at.1].map(|by| MARGIN.saturating_add_signed(by))
    }

    /// The place of a number: 0 is the middle.
    pub(super) fn place(&self, number: u16) -> (i16, i16) {
        let (number, step) = if number < 9 { (number, FAR) } else { (number - 8, 1) };
        // Of nine places row by row the fifth is the middle.
        let ninth = match number {
            0 => 4,
            1..=4 => number - 1,
            _ => number,
        };
        let by = |third: u16| step * (i16::try_from(third).unwrap_or(1) - 1);
        (self.middle.0 + by(ninth % 3), self.middle.1 + by(ninth / 3))
    }

    /// The place of a number has a score. The first of equals is the best.
    pub(super) fn add(&mut self, number: u16, score: u32) {
        if score > self.score {
            (self.at, self.score) = (self.place(number), score);
        }
        if number == 8 {
            self.middle = self.at;
        }
    }
}

/// Where the template lies in the view, from its middle in units of 1/64 pixel of the grid, and how much it has grown, in units of 1/65536.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Exact {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) growth: i32,
}

impl Exact {
    /// By the template in the light of what is `seen`, which lies `at` in the view; `None` if they do not agree well. Differences count up
    /// to `alpha`, at most 100.
    pub(super) fn of(agreement: u16, at: (i16, i16), seen: Image<'_>, lit: Image<'_>, alpha: u16) -> Option<Self> {
        if !is_certain(agreement) {
            return None;
        }
        let (x, y, growth) = Sums::of(seen, lit, alpha.into()).step();
        Some(Self { x: 64 * i32::from(at.0) + x, y: 64 * i32::from(at.1) + y, growth })
    }
}

/// Sums over all pixels but those at the edge, of products of slopes in three directions (right, down, outward) and of slopes with
/// differences. A slope to the right or down is four times the mean slope of both pictures, so at most 510; one outward, an eighth of
/// the slope times the distance, at most 510 * (columns + rows) / 64 < 1130. There are at most 1600 pixels, so sums are below 2^31.
#[derive(Clone, Copy, Default)]
struct Sums {
    squares: [i32; 3],
    /// Of right and down, right and outward, down and outward.
    products: [i32; 3],
    errors: [i32; 3],
}

impl Sums {
    #[inline(never)] // its stack is not that of a step
    fn of(seen: Image<'_>, lit: Image<'_>, alpha: i32) -> Self {
        let mut sums = Self::default();
        let from_middle = |at: usize, size: u16| 2 * i32::try_from(at).unwrap_or(0) + 3 - i32::from(size);
        for y in 1..seen.height().saturating_sub(1) {
            let v = from_middle(usize::from(y) - 1, seen.height());
            let three = |image| [y - 1, y, y + 1].map(|y| row_of(image, y, 0));
            let ([above, here, below], [lit_above, lit_here, lit_below]) = (three(seen), three(lit));
            let vertical = above.iter().zip(below).zip(lit_above.iter().zip(lit_below)).skip(1);
            let horizontal = here.windows(3).zip(lit_here.windows(3));
            for (x, ((seen, lit), ((above, below), (lit_above, lit_below)))) in
                rolled(horizontal.zip(vertical).enumerate())
            {
                let ([left, seen, right], [lit_left, lit, lit_right]) = (seen, lit) else { continue };
                let slope = |from: u8, to: u8, lit_from: u8, lit_to: u8| {
                    i32::from(to) - i32::from(from) + i32::from(lit_to) - i32::from(lit_from)
                };
                let across = slope(*left, *right, *lit_left, *lit_right);
                let down = slope(*above, *below, *lit_above, *lit_below);
                let outward = (across * from_middle(x, lit_here.len().try_into().unwrap_or(0)) + down * v) >> 6;
                sums.add([across, down, outward], (i32::from(*seen) - i32::from(*lit)).clamp(-alpha, alpha));
            }
        }
        sums
    }

    fn add(&mut self, [across, down, outward]: [i32; 3], error: i32) {
        let Self { squares, products, errors } = self;
        let add = |to: &mut [i32; 3], what: [i32; 3]| to.iter_mut().zip(what).for_each(|(to, what)| *to += what);
        add(squares, [across * across, down * down, outward * outward]);
        add(products, [across * down, across * outward, down * outward]);
        add(errors, [across * error, down * error, outward * error]);
    }

    /// The step: to the right and down in units of 1/64 pixel, and the growth in units of 1/65536.
    ///
    /// error = -(across * x + down * y) / 4 - 8 * outward * growth: least squares by Cramer's rule. Sums are shifted until the largest is
    /// below 2^12. Then minors are at most 2^25 and, by the inequality of Cauchy and Schwarz, 256 times a sum of errors 2^26 (those of all
    /// pixels, squared, are below 2^24), so both are an `i32`, and sums of their products stay below 2^53.
    #[inline(never)] // its registers are not those of a step
    fn step(&self) -> (i32, i32, i32) {
        let squares = self.squares.map(|square| square.unsigned_abs() + (square.unsigned_abs() >> MORE));
        let largest = squares.into_iter().max().unwrap_or(0);
        let mut shift = 0;
        while largest >> shift >= 1 << PLACES_OF_SUMS {
            shift += 1;
        }
        let [a, b, c] = squares.map(|square| i32::try_from(square >> shift).unwrap_or(0) + 1);
        let [d, e, f] = self.products.map(|product| toward_zero(product, shift));
        let errors = self.errors.map(|error| toward_zero(error, shift - 8));
        // The inverse of a symmetric matrix has a symmetric adjoint.
        let (first, second, third) = (b * c - f * f, a * c - e * e, a * b - d * d);
        let (one_two, one_three, two_three) = (e * f - d * c, d * f - e * b, d * e - f * a);
        let determinant = products([first, one_two, one_three], [a, d, e]);
        let part = |row| quotient(products(row, errors), determinant);
        let growth = -32 * part([one_three, two_three, third]);
        (
            -part([first, one_two, one_three]),
            -part([one_two, second, two_three]),
            growth.clamp(-MOST_GROWTH, MOST_GROWTH),
        )
    }
}

/// A number divided by a power of two, or multiplied where that is negative.
fn toward_zero(number: i32, power: i32) -> i32 {
    if power < 0 { number << -power } else { number / (1 << power) }
}

/// The sum of three products.
#[inline(never)] // one copy in flash
fn products(some: [i32; 3], others: [i32; 3]) -> i64 {
    some.iter().zip(others).map(|(&some, other)| i64::from(some) * i64::from(other)).sum()
}

/// How often a determinant fits, at most `MOST_MOVE` times to either side; 0 if there is none.
#[inline(never)] // one copy in flash
fn quotient(sum: i64, determinant: i64) -> i32 {
    let times = if determinant > 0 { sum / determinant } else { 0 };
    i32::try_from(times.clamp(-MOST_MOVE, MOST_MOVE)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// A pattern of waves, so much to the right, down, and larger, as `columns` x `rows` pixels.
    fn waves((columns, rows): (u16, u16), (right, down, growth): (f64, f64, f64)) -> Vec<u8> {
        let pixel = |x: u16, y: u16| {
            let from_middle = |at: u16, size: u16| f64::from(at) - (f64::from(size) - 1.0) / 2.0;
            let (u, v) = (from_middle(x, columns) - right, from_middle(y, rows) - down);
            let (u, v) = (u / (1.0 + growth), v / (1.0 + growth));
            128.0 + 50.0 * (0.4 * u + 0.1 * v).sin() + 40.0 * (0.5 * v - 0.2 * u).cos()
        };
        (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))).map(|(x, y)| pixel(x, y).round() as u8).collect()
    }

    fn step(seen: &[u8], lit: &[u8], (columns, rows): (u16, u16)) -> (i32, i32, i32) {
        let image = |pixels| Image::new(pixels, columns, rows).unwrap();
        Sums::of(image(seen), image(lit), 100).step()
    }

    #[test]
    fn the_place_that_was_best_is_surrounded_next() {
        let mut nearest = Nearest::new();
        let mut places = Vec::new();
        for number in 0..PLACES {
            places.push(nearest.place(number));
            let (x, y) = nearest.place(number);
            nearest.add(number, 1000 - u32::from(x.abs_diff(3) + y.abs_diff(-1)));
        }
        assert_eq!(places[..9].iter().filter(|&&(x, y)| x % 2 == 0 && y % 2 == 0).count(), 9);
        assert_eq!(nearest.at, (3, -1));
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), usize::from(PLACES), "none is compared twice");
        assert!(places.iter().all(|&(x, y)| x.unsigned_abs() <= MARGIN && y.unsigned_abs() <= MARGIN));
    }

    #[test]
    fn an_exact_match_stays_and_others_come_near() {
        let size = (40, 40);
        let lit = waves(size, (0.0, 0.0, 0.0));
        assert_eq!(step(&lit, &lit, size), (0, 0, 0));
        for by in [(0.5, 0.0, 0.0), (0.0, -0.5, 0.0), (0.0, 0.0, 0.01), (-0.3, 0.4, -0.015)] {
            let (x, y, growth) = step(&waves(size, by), &lit, size);
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
        let lit = waves(size, (0.0, 0.0, 0.0));
        for by in [(0.0, 0.0, 0.1), (0.0, 0.0, -0.1), (2.0, 2.0, 0.0), (-2.0, -2.0, 0.0)] {
            let (x, y, growth) = step(&waves(size, by), &lit, size);
            assert!(x.abs() <= 64 && y.abs() <= 64 && growth.abs() <= 1310, "{by:?}: {x} {y} {growth}");
        }
    }

    /// Black and white next to each other, turned over: slopes and differences as large as they get. Overflow would end the test.
    #[test]
    fn the_largest_sums() {
        for (columns, rows) in [(40, 40), (128, 12), (12, 128), (4, 4), (126, 4)] {
            for side in [1, 2, 3] {
                let board = |turn: u16| -> Vec<u8> {
                    let white = |x: u16, y: u16| (x / side + y / side + turn).is_multiple_of(2);
                    (0..rows).flat_map(|y| (0..columns).map(move |x| if white(x, y) { 255 } else { 0 })).collect()
                };
                for (seen, lit) in [(0, 0), (0, 1), (1, 0)] {
                    let (x, y, growth) = step(&board(seen), &board(lit), (columns, rows));
                    assert!(x.abs() <= 64 && y.abs() <= 64 && growth.abs() <= 1310);
                }
            }
        }
    }

    /// One edge tells nothing of what lies along it, and a plain picture nothing at all.
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
        assert_eq!(Exact::of(54_999, (1, -2), image, image, 100), None);
        assert_eq!(Exact::of(55_000, (1, -2), image, image, 100), Some(Exact { x: 64, y: -128, growth: 0 }));
    }
}
