//! A box in fractions of a pixel, as annotations and answers state it.

use anyhow::{Context, Result, ensure};
use smr_core::{FineRect, Rect};
use std::fmt;
use std::str::FromStr;

/// An annotated box in pixels, possibly fractional.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct BoundingBox {
    pub x: f64,
    pub y: f64,
    pub width: f64,
    pub height: f64,
}

/// Boxes of a target, one entry per frame: ground truth (`None`: not visible) or answers (`None`: no answer).
pub type Trajectory = [Option<BoundingBox>];

impl BoundingBox {
    /// Rounds each of the four values; `None` if no pixel remains, or a [`Rect`] cannot hold the box.
    pub fn to_rect(&self) -> Option<Rect> {
        let rect = Rect::new(whole(self.x)?, whole(self.y)?, size(self.width)?, size(self.height)?);
        (!rect.is_empty()).then_some(rect)
    }

    /// Returns [`Self::to_rect`], or an error if it is `None`. The text of the error continues the words "the box".
    pub fn pixels(&self) -> Result<Rect> {
        self.to_rect().with_context(|| {
            let least = self.width.min(self.height).round();
            let what = if least < 1.0 {
                "has no pixels".to_owned()
            } else {
                format!("is too large or too far away (at most {} pixels on a side)", u16::MAX)
            };
            format!("{what}: {self} (x,y,width,height)")
        })
    }

    pub fn scaled(&self, (across, down): (f64, f64)) -> Self {
        Self { x: self.x * across, y: self.y * down, width: self.width * across, height: self.height * down }
    }

    pub fn centre(&self) -> (f64, f64) {
        (self.x + self.width / 2.0, self.y + self.height / 2.0)
    }

    pub(crate) fn around(points: &[[f64; 2]]) -> Option<Self> {
        let bound = |axis: usize, of: fn(f64, f64) -> f64| points.iter().map(|point| point[axis]).reduce(of);
        let (x1, y1, x2, y2) = (bound(0, f64::min)?, bound(1, f64::min)?, bound(0, f64::max)?, bound(1, f64::max)?);
        Some(Self::from_corners([x1, y1, x2, y2]))
    }

    pub(crate) fn from_corners([x1, y1, x2, y2]: [f64; 4]) -> Self {
        Self { x: x1, y: y1, width: x2 - x1, height: y2 - y1 }
    }

    pub fn has_area(&self) -> bool {
        self.width > 0.0 && self.height > 0.0
    }

    /// Returns the intersection over union, 0 to 1; 0 if neither box has an area.
    pub fn iou(&self, other: &Self) -> f64 {
        let overlap = |a: f64, a_size: f64, b: f64, b_size: f64| ((a + a_size).min(b + b_size) - a.max(b)).max(0.0);
        let area = |of: &Self| of.width.max(0.0) * of.height.max(0.0);
        let shared =
            overlap(self.x, self.width, other.x, other.width) * overlap(self.y, self.height, other.y, other.height);
        let union = area(self) + area(other) - shared;
        // Far from the origin, rounding can make the shared area larger than the union.
        if union > 0.0 { (shared / union).min(1.0) } else { 0.0 }
    }
}

impl From<[i32; 4]> for BoundingBox {
    fn from(sides: [i32; 4]) -> Self {
        let [x, y, width, height] = sides.map(f64::from);
        Self { x, y, width, height }
    }
}

impl From<Rect> for BoundingBox {
    fn from(rect: Rect) -> Self {
        Self::from([rect.x, rect.y, rect.width.into(), rect.height.into()])
    }
}

impl From<FineRect> for BoundingBox {
    fn from(fine: FineRect) -> Self {
        let pixels = |value: f64| value / 256.0;
        let (width, height) = (pixels(fine.width.into()), pixels(fine.height.into()));
        Self { x: pixels(fine.x.into()), y: pixels(fine.y.into()), width, height }
    }
}

/// Formats `x,y,width,height`, which [`BoundingBox::from_str`] parses. Files have other forms.
impl fmt::Display for BoundingBox {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{},{}", self.x, self.y, self.width, self.height)
    }
}

/// Parses `x,y,width,height`, the start box on the command line.
impl FromStr for BoundingBox {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let expected = "expected x,y,width,height: four numbers with commas, width and height above 0";
        let [x, y, width, height] = four_numbers(text).filter(|_| text.contains(',')).context(expected)?;
        let typed = Self { x, y, width, height };
        ensure!(typed.has_area() && !x.is_nan() && !y.is_nan(), expected);
        Ok(typed)
    }
}

#[allow(clippy::cast_possible_truncation)] // the range is checked
fn whole(value: f64) -> Option<i32> {
    let rounded = value.round();
    (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&rounded).then_some(rounded as i32)
}

fn size(value: f64) -> Option<u16> {
    whole(value)?.try_into().ok()
}

pub(crate) fn four_numbers(line: &str) -> Option<[f64; 4]> {
    numbers(line)?.try_into().ok()
}

/// Parses numbers separated by commas, tabs or spaces. Refuses infinity, and mixed separators (maybe decimal commas).
pub(crate) fn numbers(line: &str) -> Option<Vec<f64>> {
    let separator = [',', '\t'].into_iter().find(|&separator| line.contains(separator)).unwrap_or(' ');
    let line = line.trim().trim_end_matches(separator);
    let fields = line.split(separator).map(str::trim).filter(|field| separator == ',' || !field.is_empty());
    let numbers = fields.map(|field| field.parse().ok().filter(|value: &f64| !value.is_infinite()));
    let numbers: Vec<f64> = numbers.collect::<Option<_>>()?;
    // Refuses "60,5, 80,5, ...": with decimal commas, four numbers would be read as the eight of a polygon.
    let with_blank = line.split(',').filter(|field| field.starts_with([' ', '\t'])).count();
    (numbers.len() <= 4 || with_blank == 0 || with_blank + 1 == numbers.len()).then_some(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn boxed(x: f64, y: f64, width: f64, height: f64) -> BoundingBox {
        BoundingBox { x, y, width, height }
    }

    #[test]
    fn intersection_over_union() {
        let (one, none) = (boxed(0.0, 0.0, 10.0, 10.0), boxed(2.0, 2.0, 0.0, 0.0));
        assert_eq!(one.iou(&boxed(5.0, 0.0, 10.0, 10.0)), 1.0 / 3.0);
        assert_eq!(one.iou(&boxed(10.0, 0.0, 10.0, 10.0)), 0.0);
        assert_eq!([one.iou(&one), one.iou(&none), none.iou(&none)], [1.0, 0.0, 0.0]);
        let far = boxed(-1.0, 8223.0, 1.0, 0.2);
        assert!(far.iou(&far) <= 1.0, "{}", far.iou(&far));
    }

    #[test]
    fn whole_pixels() {
        assert_eq!(boxed(-3.4, 1.5, 9.6, 2.4).to_rect(), Some(Rect::new(-3, 2, 10, 2)));
        for [x, width] in [[0.0, 0.4], [0.0, 65536.0], [0.0, -1.0], [1e12, 1.0], [f64::NAN, 1.0]] {
            assert_eq!(boxed(x, 0.0, width, 5.0).to_rect(), None, "{x} {width}");
        }
    }

    proptest! {
        #[test]
        fn to_rect_never_panics(x: f64, y: f64, width: f64, height: f64) {
            let _ = boxed(x, y, width, height).to_rect();
        }

        #[test]
        fn iou_is_symmetric_and_bounded(numbers in proptest::array::uniform8(0.0..6e4)) {
            let [x1, y1, w1, h1, x2, y2, w2, h2] = numbers;
            let (a, b) = (boxed(x1 - 3e4, y1 - 3e4, w1, h1), boxed(x2 - 3e4, y2 - 3e4, w2, h2));
            prop_assert_eq!(a.iou(&b), b.iou(&a));
            prop_assert!((0.0..=1.0).contains(&a.iou(&b)));
        }
    }
}
