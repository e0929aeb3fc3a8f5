//! Lucas-Kanade, as the paper names it beside SSD and SAD: the shift of least squared difference, found along gradients from
//! coarse to fine. Window, padding and template update are those of the other baselines; positions are finer than a pixel.

use super::{check_size, first_template};
use crate::method::{Method, MethodKind, Report};
use anyhow::Result;
use smr_core::paper::{Config, Radius};
use smr_core::{Frame, Image, Rect, UpdateError};
use smr_recordings::BoundingBox;

/// Steps on each level of the pyramid, at most.
const STEPS: usize = 30;
/// A step below this many pixels of its level is the last one.
const SMALL: f64 = 0.005;
/// Templates are halved as long as their sides keep so many pixels.
const LEAST_SIDE: usize = 5;
/// Pixels around the window that gradients at its edge need.
const MARGIN: i32 = 2;

pub(crate) struct Flow {
    radius: Radius,
    padding: u16,
    /// Of the target; its place is (`x`, `y`).
    size: (u16, u16),
    x: f64,
    y: f64,
    bounds: Rect,
    template: Vec<u8>,
}

impl Flow {
    pub(crate) fn new(config: &Config) -> Self {
        let (radius, padding) = (config.window, config.padding);
        Self { radius, padding, size: (0, 0), x: 0.0, y: 0.0, bounds: Rect::default(), template: Vec::new() }
    }

    /// The window on one axis: the least and the largest place.
    fn range(&self, place: f64, radius: u16, size: u16, frame: u16) -> (f64, f64) {
        let (radius, padding) = (f64::from(radius), f64::from(self.padding));
        let (least, most) = (-padding, f64::from(frame) + padding - f64::from(size));
        ((place - radius).max(least), (place + radius).min(most))
    }

    /// Where the template fits best in `frame`.
    fn fit(&self, frame: Image<'_>) -> (f64, f64) {
        let (width, height) = self.size;
        let xs = self.range(self.x, self.radius.x, width, self.bounds.width);
        let ys = self.range(self.y, self.radius.y, height, self.bounds.height);
        let (left, top) = (floor(xs.0) - MARGIN, floor(ys.0) - MARGIN);
        let columns = floor(xs.1) + i32::from(width) + MARGIN + 1 - left;
        let rows = floor(ys.1) + i32::from(height) + MARGIN + 1 - top;
        let scene = Plane::of_frame(frame, (left, top), (columns, rows));
        let template = Plane {
            width: width.into(),
            height: height.into(),
            pixels: self.template.iter().map(|&pixel| pixel.into()).collect(),
        };

        // From the window's corner: half of it is the place one level higher.
        let (left, top) = (f64::from(left), f64::from(top));
        let limits = [(xs.0 - left, xs.1 - left), (ys.0 - top, ys.1 - top)];
        let [x, y] = coarse_to_fine(&scene, &template, [self.x - left, self.y - top], limits);
        (x + left, y + top)
    }

    fn bbox(&self) -> BoundingBox {
        BoundingBox { x: self.x, y: self.y, width: self.size.0.into(), height: self.size.1.into() }
    }

    fn is_inside(&self) -> bool {
        let (right, lower) = (self.x + f64::from(self.size.0), self.y + f64::from(self.size.1));
        self.x >= 0.0 && self.y >= 0.0 && right <= self.bounds.width.into() && lower <= self.bounds.height.into()
    }
}

impl Method for Flow {
    fn kind(&self) -> MethodKind {
        MethodKind::Lk
    }

    fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<()> {
        self.template = first_template(frame, target)?;
        (self.size, self.bounds) = ((target.width, target.height), frame.bounds());
        (self.x, self.y) = (target.x.into(), target.y.into());
        Ok(())
    }

    fn update(&mut self, frame: &Frame<'_>) -> Result<Report> {
        check_size(frame, self.bounds)?;
        let image = frame.patch(self.bounds).ok_or(UpdateError::WindowNotInMemory)?;
        (self.x, self.y) = self.fit(image);
        let inside = self.is_inside();
        if inside {
            let (left, top) = (floor(self.x), floor(self.y));
            let size = (i32::from(self.size.0) + 1, i32::from(self.size.1) + 1);
            let found = Plane::of_frame(image, (left, top), size);
            let at = [self.x - f64::from(left), self.y - f64::from(top)];
            self.template = found.patch(at, self.size).map(byte).collect();
        }
        Ok(Report::of_baseline(self.bbox(), inside))
    }

    fn template(&self) -> Option<Image<'_>> {
        Image::new(&self.template, self.size.0, self.size.1).ok()
    }
}

/// Down the pyramid to `scene` itself; each level begins where the one above it ended.
fn coarse_to_fine(scene: &Plane, template: &Plane, from: [f64; 2], limits: [(f64, f64); 2]) -> [f64; 2] {
    let mut start = from;
    if template.width.min(template.height) / 2 >= LEAST_SIDE {
        let half = |place: f64| place / 2.0;
        let limits = limits.map(|(least, most)| (half(least), half(most)));
        let above = coarse_to_fine(&scene.halved(), &template.halved(), from.map(half), limits);
        start = above.map(|place| place * 2.0);
    }
    fit(scene, template, start, limits)
}

/// Gauss-Newton on the sum of squared differences; a place at which there is no gradient is left as it is.
fn fit(scene: &Plane, template: &Plane, start: [f64; 2], limits: [(f64, f64); 2]) -> [f64; 2] {
    let mut place = start;
    for _ in 0..STEPS {
        let Some(step) = step(scene, template, place) else { break };
        let next = [0, 1].map(|axis| (place[axis] + step[axis]).clamp(limits[axis].0, limits[axis].1));
        let moved = (next[0] - place[0]).hypot(next[1] - place[1]);
        place = next;
        if moved < SMALL {
            break;
        }
    }
    place
}

/// The shift that would make `scene` at `place` equal to `template`, were its gradients to go on as they are.
fn step(scene: &Plane, template: &Plane, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
    // Sums of gx gx, gx gy, gy gy, gx d, gy d.
    let mut sums = [0.0; 5];
    for row in 0..template.height {
        for column in 0..template.width {
            let (x, y) = (x + column as f64, y + row as f64);
            let gx = (scene.at(x + 1.0, y) - scene.at(x - 1.0, y)) / 2.0;
            let gy = (scene.at(x, y + 1.0) - scene.at(x, y - 1.0)) / 2.0;
            let difference = template.pixels[row * template.width + column] - scene.at(x, y);
            let terms = [gx * gx, gx * gy, gy * gy, gx * difference, gy * difference];
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
    }
    let [xx, xy, yy, xd, yd] = sums;
    let determinant = xx * yy - xy * xy;
    // Without texture, or with an edge alone, nothing tells where to go.
    (determinant > 1e-6 * (xx + yy).powi(2) && xx + yy > 0.0)
        .then(|| [(yy * xd - xy * yd) / determinant, (xx * yd - xy * xd) / determinant])
}

/// Gray levels as f64.
struct Plane {
    width: usize,
    height: usize,
    pixels: Vec<f64>,
}

impl Plane {
    /// The pixels of `frame` from (`left`, `top`) on; outside of it there are zeroes.
    fn of_frame(frame: Image<'_>, (left, top): (i32, i32), (columns, rows): (i32, i32)) -> Self {
        let pixel = |x: i32, y: i32| match (u16::try_from(x), u16::try_from(y)) {
            (Ok(x), Ok(y)) if x < frame.width() && y < frame.height() => f64::from(frame.row(y)[usize::from(x)]),
            _ => 0.0,
        };
        let pixels = (top..top + rows).flat_map(|y| (left..left + columns).map(move |x| (x, y)));
        let side = |length: i32| usize::try_from(length).unwrap_or(0);
        Self { width: side(columns), height: side(rows), pixels: pixels.map(|(x, y)| pixel(x, y)).collect() }
    }

    /// Means of 2x2 pixels; an odd column or row at the end is left out.
    fn halved(&self) -> Self {
        let (width, height) = (self.width / 2, self.height / 2);
        let mean = |x: usize, y: usize| {
            let at = 2 * y * self.width + 2 * x;
            let below = at + self.width;
            (self.pixels[at] + self.pixels[at + 1] + self.pixels[below] + self.pixels[below + 1]) / 4.0
        };
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Self { width, height, pixels: pixels.map(|(x, y)| mean(x, y)).collect() }
    }

    /// Between pixels by their distances; beyond the last ones these go on.
    fn at(&self, x: f64, y: f64) -> f64 {
        let (x, y) = (x.clamp(0.0, (self.width - 1) as f64), y.clamp(0.0, (self.height - 1) as f64));
        let (column, row) = (whole(x), whole(y));
        let (right, below) = ((column + 1).min(self.width - 1), (row + 1).min(self.height - 1));
        let (dx, dy) = (x - column as f64, y - row as f64);
        let pixel = |column: usize, row: usize| self.pixels[row * self.width + column];
        let upper = pixel(column, row) + dx * (pixel(right, row) - pixel(column, row));
        let lower = pixel(column, below) + dx * (pixel(right, below) - pixel(column, below));
        upper + dy * (lower - upper)
    }

    fn patch(&self, [left, top]: [f64; 2], (width, height): (u16, u16)) -> impl Iterator<Item = f64> {
        (0..height).flat_map(move |y| (0..width).map(move |x| self.at(left + f64::from(x), top + f64::from(y))))
    }
}

#[allow(clippy::cast_possible_truncation)] // places are within the padded frame
fn floor(place: f64) -> i32 {
    place.floor() as i32
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it is within the plane
fn whole(place: f64) -> usize {
    place as usize
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // means of bytes
fn byte(level: f64) -> u8 {
    level.round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_core::State;
    use smr_recordings::GrayFrame;

    /// Waves of several lengths in a frame of 120x90, moved by (`dx`, `dy`).
    fn waves(dx: f64, dy: f64) -> GrayFrame {
        rough(dx, dy, 0.0)
    }

    /// With short waves of this height, too.
    fn rough(dx: f64, dy: f64, height: f64) -> GrayFrame {
        let level = |x: f64, y: f64| {
            let waves = (x / 5.0).sin() + (y / 6.0).sin() + ((x + 2.0 * y) / 17.0).sin() + ((2.0 * x - y) / 23.0).cos();
            byte(128.0 + (28.0 - height) * waves + 2.0 * height * ((1.2 * x).sin() + (1.1 * y).sin()))
        };
        let pixels = (0..90_u8).flat_map(|y| (0..120_u8).map(move |x| (x, y)));
        let pixels = pixels.map(|(x, y)| level(f64::from(x) - dx, f64::from(y) - dy)).collect();
        GrayFrame { width: 120, height: 90, pixels }
    }

    fn locked(frame: &GrayFrame, target: Rect) -> Flow {
        let mut flow = Flow::new(&Config::paper());
        flow.lock(&frame.frame(), target).unwrap();
        flow
    }

    #[test]
    fn a_shift_finer_than_a_pixel_is_found() {
        for (dx, dy) in [(0.0, 0.0), (0.4, -0.3), (1.3, -0.7), (-3.6, 2.2), (7.5, 5.25)] {
            let mut flow = locked(&waves(0.0, 0.0), Rect::new(40, 30, 32, 24));
            let report = flow.update(&waves(dx, dy).frame()).unwrap();
            let found = report.target.unwrap();
            let error = (found.x - 40.0 - dx).hypot(found.y - 30.0 - dy);
            assert!(error < 0.05, "({dx}, {dy}): {found}");
            assert_eq!((report.state, found.width, found.height), (State::Tracking, 32.0, 24.0));
        }
    }

    #[test]
    fn without_the_pyramid_a_large_shift_is_not_found() {
        let (scene, moved) = (rough(0.0, 0.0, 14.0), rough(9.0, 0.0, 14.0));
        let plane = |frame: &GrayFrame, at, size| {
            Plane::of_frame(frame.frame().patch(frame.frame().bounds()).unwrap(), at, size)
        };
        let template = plane(&scene, (40, 30), (32, 24));
        let limits = [(0.0, 80.0), (0.0, 60.0)];
        let moved = plane(&moved, (0, 0), (120, 90));
        assert!((fit(&moved, &template, [40.0, 30.0], limits)[0] - 49.0).abs() > 1.0);
        assert!((coarse_to_fine(&moved, &template, [40.0, 30.0], limits)[0] - 49.0).abs() < 0.05);
    }

    #[test]
    fn the_template_is_what_was_found_and_drift_stays_small() {
        let mut flow = locked(&waves(0.0, 0.0), Rect::new(40, 30, 32, 24));
        for frame in 1..=20 {
            let shift = f64::from(frame) * 0.35;
            flow.update(&waves(shift, -shift).frame()).unwrap();
        }
        assert!((flow.x - 47.0).abs() < 0.3 && (flow.y - 23.0).abs() < 0.3, "{}", flow.bbox());
        let template = flow.template().unwrap();
        assert_eq!((template.width(), template.height()), (32, 24));
    }

    #[test]
    fn a_box_leaves_the_picture_by_the_padding_at_most_and_keeps_its_template() {
        let mut flow = locked(&waves(0.0, 0.0), Rect::new(2, 30, 32, 24));
        let template = flow.template.clone();
        let mut left = false;
        for frame in 1..=20 {
            let report = flow.update(&waves(-2.0 * f64::from(frame), 0.0).frame()).unwrap();
            left |= report.state == State::Leaving;
            assert!(flow.x >= -20.0);
            if left {
                break;
            }
        }
        assert!(left);
        assert!(flow.template.len() == template.len());
        let kept = flow.template.clone();
        flow.update(&waves(-30.0, 0.0).frame()).unwrap();
        assert!(flow.is_inside() || flow.template == kept);
    }

    #[test]
    fn a_window_bounds_the_step() {
        let mut config = Config::paper();
        config.window = Radius { x: 2, y: 1 };
        let mut flow = Flow::new(&config);
        flow.lock(&waves(0.0, 0.0).frame(), Rect::new(40, 30, 32, 24)).unwrap();
        let found = flow.update(&waves(6.0, 4.0).frame()).unwrap().target.unwrap();
        assert_eq!((found.x, found.y), (42.0, 31.0));
    }

    #[test]
    fn what_cannot_be_followed_is_an_error() {
        let mut flow = Flow::new(&Config::paper());
        let error = flow.update(&waves(0.0, 0.0).frame()).unwrap_err();
        assert_eq!(error.downcast_ref(), Some(&UpdateError::NotLocked));
        flow.lock(&waves(0.0, 0.0).frame(), Rect::new(0, 0, 1, 1)).unwrap();
        let found = flow.update(&waves(1.0, 1.0).frame()).unwrap().target.unwrap();
        assert!((-20.0..=139.0).contains(&found.x));
    }
}
