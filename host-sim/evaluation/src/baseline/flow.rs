//! Lucas-Kanade: Gauss-Newton steps to the sub-pixel position of least squared difference of template and frame.

use smr_core::Image;

/// Maximum number of Gauss-Newton steps on each level of the pyramid.
const MAX_STEPS: usize = 30;
/// Length of a step, in pixels of its pyramid level, below which the iteration ends.
const MIN_STEP: f64 = 0.005;
/// Minimum side of a template, in pixels, on the smallest level of the pyramid.
const MIN_SIDE: usize = 5;
/// Margin in pixels around the search window, because gradients at the window's edge need the pixels beyond it.
const MARGIN: i32 = 2;

pub(super) fn find(
    frame: Image<'_>,
    template: &[u8],
    (width, height): (u16, u16),
    from: [f64; 2],
    limits: [(f64, f64); 2],
) -> [f64; 2] {
    let first = limits.map(|(least, _)| floor(least) - MARGIN);
    let size = [(0, width), (1, height)]
        .map(|(axis, size): (usize, _)| floor(limits[axis].1) + i32::from(size) + MARGIN + 1 - first[axis]);
    let scene = Plane::new(frame, first.into(), size.into());
    let pixels = template.iter().map(|&pixel| pixel.into()).collect();
    let template = Plane { width: width.into(), height: height.into(), pixels };
    // Measures positions from the corner of `scene`: when `scene` is halved for the next pyramid level, they halve too.
    let corner = first.map(f64::from);
    let limits = [0, 1].map(|axis| (limits[axis].0 - corner[axis], limits[axis].1 - corner[axis]));
    let place = coarse_to_fine(&scene, &template, [from[0] - corner[0], from[1] - corner[1]], limits);
    [place[0] + corner[0], place[1] + corner[1]]
}

/// Fits the template on all pyramid levels, smallest first, `scene` last; each fit starts from the previous result.
fn coarse_to_fine(scene: &Plane, template: &Plane, from: [f64; 2], limits: [(f64, f64); 2]) -> [f64; 2] {
    let mut start = from;
    if template.width.min(template.height) / 2 >= MIN_SIDE {
        let half = |place: f64| place / 2.0;
        let limits = limits.map(|(least, most)| (half(least), half(most)));
        let above = coarse_to_fine(&scene.halved(), &template.halved(), from.map(half), limits);
        start = above.map(|place| place * 2.0);
    }
    fit(scene, template, start, limits)
}

/// Minimizes the squared difference by Gauss-Newton steps; stops after a short step, or if gradients determine none.
fn fit(scene: &Plane, template: &Plane, start: [f64; 2], limits: [(f64, f64); 2]) -> [f64; 2] {
    let mut place = start;
    for _ in 0..MAX_STEPS {
        let Some(step) = step(scene, template, place) else { break };
        let next = [0, 1].map(|axis| (place[axis] + step[axis]).clamp(limits[axis].0, limits[axis].1));
        let moved = (next[0] - place[0]).hypot(next[1] - place[1]);
        place = next;
        if moved < MIN_STEP {
            break;
        }
    }
    place
}

/// Returns the Gauss-Newton step from (x, y) to the best fit; `None` if gradients do not determine it.
fn step(scene: &Plane, template: &Plane, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
    // Sums of gx gx, gx gy, gy gy, gx d and gy d: (gx, gy) is the gradient of `scene`, and d is template minus scene.
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
    // Without texture, or with a single edge, gradients do not determine the step.
    (determinant > 1e-6 * (xx + yy).powi(2) && xx + yy > 0.0)
        .then(|| [(yy * xd - xy * yd) / determinant, (xx * yd - xy * xd) / determinant])
}

pub(super) struct Plane {
    width: usize,
    height: usize,
    pixels: Vec<f64>,
}

impl Plane {
    /// Copies the box of `size` pixels at `place` from `frame`; zeros outside of the frame.
    pub fn new(frame: Image<'_>, place: (i32, i32), size: (i32, i32)) -> Self {
        let side = |length: i32| usize::try_from(length).unwrap_or(0);
        Self { width: side(size.0), height: side(size.1), pixels: levels(frame, place, size).map(f64::from).collect() }
    }

    /// Averages blocks of 2x2 pixels; an odd width loses its last column, and an odd height its last row.
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

    /// Interpolates between pixels; beyond the edge the last pixels are repeated.
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

    /// Returns the interpolated levels of a box at a fractional position, row by row.
    pub fn patch(&self, [left, top]: [f64; 2], (width, height): (u16, u16)) -> impl Iterator<Item = f64> {
        (0..height).flat_map(move |y| (0..width).map(move |x| self.at(left + f64::from(x), top + f64::from(y))))
    }
}

/// Returns the pixels of `frame` in a box at (`left`, `top`), row by row; zeros outside of the frame.
pub(super) fn levels(
    frame: Image<'_>,
    (left, top): (i32, i32),
    (columns, rows): (i32, i32),
) -> impl Iterator<Item = u8> {
    (top..top + rows).flat_map(move |y| {
        let row = u16::try_from(y).ok().filter(|&y| y < frame.height()).map_or(&[][..], |y| frame.row(y));
        let level = |x: i32| usize::try_from(x).ok().and_then(|x| row.get(x)).copied().unwrap_or(0);
        (left..left + columns).map(level)
    })
}

#[allow(clippy::cast_possible_truncation)] // places are within the padded frame
pub(super) fn floor(place: f64) -> i32 {
    place.floor() as i32
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it is within the plane
fn whole(place: f64) -> usize {
    place as usize
}

#[cfg(test)]
mod tests {
    use super::super::{Baseline, byte};
    use super::*;
    use crate::method::{Method, MethodKind};
    use smr_core::paper::{Config, Radius};
    use smr_core::{Rect, State};
    use smr_recordings::GrayFrame;

    fn waves(dx: f64, dy: f64) -> GrayFrame {
        rough(dx, dy, 0.0)
    }

    fn rough(dx: f64, dy: f64, height: f64) -> GrayFrame {
        let level = |x: f64, y: f64| {
            let waves = (x / 5.0).sin() + (y / 6.0).sin() + ((x + 2.0 * y) / 17.0).sin() + ((2.0 * x - y) / 23.0).cos();
            byte(128.0 + (28.0 - height) * waves + 2.0 * height * ((1.2 * x).sin() + (1.1 * y).sin()))
        };
        GrayFrame::drawn(120, 90, |x, y| level(f64::from(x) - dx, f64::from(y) - dy))
    }

    fn locked(frame: &GrayFrame, target: Rect) -> Baseline {
        let mut flow = Baseline::new(MethodKind::Lk, &Config::paper());
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
        let plane = |frame: &GrayFrame, at, size| Plane::new(frame.image(), at, size);
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
        let [x, y] = flow.place;
        assert!((x - 47.0).abs() < 0.3 && (y - 23.0).abs() < 0.3, "{x} {y}");
        let template = flow.template().unwrap();
        assert_eq!((template.width(), template.height()), (32, 24));
    }

    #[test]
    fn a_box_leaves_the_picture_by_the_padding_at_most_and_keeps_its_template() {
        let mut flow = locked(&waves(0.0, 0.0), Rect::new(2, 30, 32, 24));
        let mut update = |shift: f64| {
            let before = flow.template.clone();
            let report = flow.update(&waves(-shift, 0.0).frame()).unwrap();
            assert!(flow.place[0] >= -20.0);
            assert!(report.state == State::Tracking || flow.template == before);
            report.state
        };
        assert!((1..=20).any(|frame| update(2.0 * f64::from(frame)) == State::Leaving));
        update(30.0);
    }

    #[test]
    fn a_window_bounds_the_step() {
        let mut config = Config::paper();
        config.window = Radius { x: 2, y: 1 };
        let mut flow = Baseline::new(MethodKind::Lk, &config);
        flow.lock(&waves(0.0, 0.0).frame(), Rect::new(40, 30, 32, 24)).unwrap();
        let found = flow.update(&waves(6.0, 4.0).frame()).unwrap().target.unwrap();
        assert_eq!((found.x, found.y), (42.0, 31.0));
        // A box of one pixel has almost no gradient.
        flow.lock(&waves(0.0, 0.0).frame(), Rect::new(0, 0, 1, 1)).unwrap();
        let found = flow.update(&waves(1.0, 1.0).frame()).unwrap().target.unwrap();
        assert!((-2.0..=2.0).contains(&found.x));
    }
}
