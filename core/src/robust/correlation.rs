//! Correlation: where in a window a template may be, whatever the light. It only says where to look closer.
//!
//! The measure follows the light poorly (a search with it would need a gain and a mean for each offset), and a target that
//! comes back has often walked out of its light. So the sweep looks by correlation, at half the grid's resolution: a product
//! for each of a quarter of the pixels.

use super::RADIUS;
use super::grid::COLUMNS;
use crate::image::{Image, Rect};
use heapless::Vec;

/// Where the template correlates best.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Likely {
    pub(super) x: i32,
    pub(super) y: i32,
}

/// The most columns of a window at half resolution.
const HALF: usize = (COLUMNS - 2 * RADIUS as usize) / 2 + 2 * RADIUS as usize;
/// A patch with less than this part of the template's variance is none: 1/4 of its deviation.
const PLAIN: u32 = 16;

/// Makes `half` out of `image`, by 2x2 means, rounded; an odd last row or column is left out. Says its shape.
pub(super) fn halve<const PIXELS: usize>(image: Image<'_>, half: &mut Vec<u8, PIXELS>) -> (u16, u16) {
    let (columns, rows) = (image.width() / 2, image.height() / 2);
    half.clear();
    for row in 0..rows {
        let pairs =
            |row: u16| image.row(row).chunks_exact(2).map(|pair| pair.iter().map(|&p| u32::from(p)).sum::<u32>());
        for (upper, lower) in pairs(2 * row).zip(pairs(2 * row + 1)) {
            // Cannot fail: it is smaller than the template.
            let _ = half.push(u8::try_from((upper + lower + 2) / 4).unwrap_or(u8::MAX));
        }
    }
    (columns, rows)
}

/// The offset at which covariance over the patch's deviation is the largest, in whole units; of equals the upper and then the
/// left one. `None` if everything is plain or the template's opposite.
///
/// A template has at most 256 pixels at half resolution: no sum of products, times their count, is above
/// 256 * 256 * 255 * 255, which is below 2^32.
#[inline(never)] // one copy in flash
pub(super) fn find(window: Image<'_>, template: Image<'_>) -> Option<Likely> {
    let (width, height) = (template.width(), template.height());
    let count = u32::from(width) * u32::from(height);
    let mut whole = Sums::default();
    (0..height).flat_map(|row| template.row(row)).for_each(|&pixel| whole.add(pixel));
    let spread = whole.spread(count);
    let mut best = None;
    let mut most = 0;
    let mut columns = Vec::<Sums, HALF>::new();
    for y in 0..=window.height().checked_sub(height)? {
        columns.clear();
        for _ in 0..window.width() {
            let _ = columns.push(Sums::default());
        }
        for row in y..y + height {
            columns.iter_mut().zip(window.row(row)).for_each(|(sums, &pixel)| sums.add(pixel));
        }
        let mut inside = Sums::default();
        columns.iter().take(usize::from(width)).for_each(|sums| inside.enter(sums));
        let leaving = columns.iter();
        let entering = columns.iter().skip(usize::from(width)).map(Some).chain([None]);
        for (x, (leave, enter)) in (0i32..).zip(leaving.zip(entering)) {
            let variance = inside.spread(count);
            if variance >= (spread / PLAIN).max(1) {
                let patch = window.crop(Rect::new(x, y.into(), width, height))?;
                let together = (count * products(patch, template)).saturating_sub(inside.sum * whole.sum);
                let score = together / variance.isqrt().max(1);
                if score > most {
                    (most, best) = (score, Some(Likely { x, y: y.into() }));
                }
            }
            inside.leave(leave);
            if let Some(enter) = enter {
                inside.enter(enter);
            }
        }
    }
    best
}

/// How many products of pixels [`find`] makes, at most.
pub(super) fn products_in(window: Image<'_>, template: Image<'_>) -> u32 {
    let offsets = |window: u16, template: u16| u32::from(window.saturating_sub(template)) + 1;
    let (width, height) = (template.width(), template.height());
    offsets(window.width(), width) * offsets(window.height(), height) * u32::from(width) * u32::from(height)
}

fn products(patch: Image<'_>, template: Image<'_>) -> u32 {
    let rows = (0..template.height()).map(|row| patch.row(row).iter().zip(template.row(row)));
    rows.map(|row| row.map(|(&a, &b)| u32::from(a) * u32::from(b)).sum::<u32>()).sum()
}

/// Of some pixels.
#[derive(Clone, Copy, Default)]
struct Sums {
    sum: u32,
    squares: u32,
}

impl Sums {
    fn add(&mut self, pixel: u8) {
        self.sum += u32::from(pixel);
        self.squares += u32::from(pixel) * u32::from(pixel);
    }

    fn enter(&mut self, column: &Self) {
        *self = Self { sum: self.sum + column.sum, squares: self.squares + column.squares };
    }

    fn leave(&mut self, column: &Self) {
        *self = Self { sum: self.sum - column.sum, squares: self.squares - column.squares };
    }

    /// The variance, times the square of their count.
    fn spread(&self, count: u32) -> u32 {
        (count * self.squares).saturating_sub(self.sum * self.sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn by_definition(window: Image<'_>, template: Image<'_>) -> Option<Likely> {
        let pixels = |image: Image<'_>| -> std::vec::Vec<i64> {
            (0..image.height()).flat_map(|y| image.row(y)).map(|&pixel| pixel.into()).collect()
        };
        let (t, mut best) = (pixels(template), (0, None));
        let n = t.len() as i64;
        let centred = |a: &[i64], b: &[i64]| {
            let products: i64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
            n * products - a.iter().sum::<i64>() * b.iter().sum::<i64>()
        };
        for y in 0..=window.height() - template.height() {
            for x in 0..=window.width() - template.width() {
                let at = Rect::new(x.into(), y.into(), template.width(), template.height());
                let p = pixels(window.crop(at).unwrap());
                let variance = centred(&p, &p);
                let score = centred(&p, &t) / variance.isqrt().max(1);
                if variance >= (centred(&t, &t) / 16).max(1) && score > best.0 {
                    best = (score, Some(Likely { x: x.into(), y: y.into() }));
                }
            }
        }
        best.1
    }

    proptest! {
        #[test]
        fn the_best_offset_is_that_of_the_definition(
            pixels in prop::collection::vec(prop_oneof![any::<u8>(), 90..110u8, Just(255)], 12 * 9 + 5 * 4),
        ) {
            let (window, template) = pixels.split_at(12 * 9);
            let (window, template) = (Image::new(window, 12, 9).unwrap(), Image::new(template, 5, 4).unwrap());
            prop_assert_eq!(find(window, template), by_definition(window, template));
        }
    }

    #[test]
    fn light_does_not_matter() {
        let dim: std::vec::Vec<u8> = (0..64u8).map(|at| (u32::from(at).pow(3) * 7 % 61 + 10) as u8).collect();
        let bright: std::vec::Vec<u8> = dim.iter().map(|pixel| pixel * 2 + 60).collect();
        let window = Image::new(&bright, 8, 8).unwrap();
        let template: std::vec::Vec<u8> = (2..6).flat_map(|y| dim[y * 8 + 3..y * 8 + 7].to_vec()).collect();
        assert_eq!(find(window, Image::new(&template, 4, 4).unwrap()), Some(Likely { x: 3, y: 2 }));
    }

    #[test]
    fn the_largest_sums_fit_and_plain_windows_have_nothing() {
        let checks = |at: usize| if at.is_multiple_of(2) { 255 } else { 0 };
        let (bright, template) = (std::vec![255; 18 * 18], (0..256).map(checks).collect::<std::vec::Vec<u8>>());
        let template = Image::new(&template, 16, 16).unwrap();
        assert_eq!(find(Image::new(&bright, 18, 18).unwrap(), template), None);
        let all = Image::new(&bright[..256], 16, 16).unwrap();
        assert_eq!(find(Image::new(&bright, 18, 18).unwrap(), all), None);
        assert_eq!(find(template, template), Some(Likely { x: 0, y: 0 }));
    }

    #[test]
    fn halves_are_means_and_odd_edges_are_left_out() {
        let image = [0, 1, 9, 2, 4, 9, 9, 9, 9];
        let mut half = Vec::<u8, 4>::new();
        assert_eq!(halve(Image::new(&image, 3, 3).unwrap(), &mut half), (1, 1));
        assert_eq!(half, [2]);
    }
}
