//! Baselines of the paper's comparison: they share SMR's window, padding, tie rule and template update, not its score.
//!
//! SAD (sum of |F - G|) and SSD (sum of (F - G)^2) take the least cost, NCC the largest correlation of F and G, 0 if
//! either is constant; Lucas-Kanade (`flow`) follows gradients. Baselines always answer, and their window never grows.

mod flow;

use super::method::{Method, MethodAnswer, MethodKind};
use anyhow::Result;
use flow::{Plane, floor, levels};
use smr_core::paper::{Config, Radius};
use smr_core::unstable::Window;
use smr_core::{Frame, Image, LockError, Rect, UpdateError};
use smr_recordings::BoundingBox;

/// Maximum number of pixels of a box, 1024x1024. Up to it, the integer sums of the SAD, SSD and NCC scores are exact.
pub(super) const MAX_PIXELS: u32 = 1 << 20;

pub(super) struct Baseline {
    kind: MethodKind,
    radius: Radius,
    padding: u16,
    /// Bounds of the frame in which the target was locked; empty before the first lock.
    bounds: Rect,
    size: (u16, u16),
    /// Left and top edge of the target in pixels; fractional only with Lucas-Kanade.
    place: [f64; 2],
    template: Vec<u8>,
}

impl Baseline {
    pub(super) fn new(kind: MethodKind, config: &Config) -> Self {
        let (radius, padding) = (config.window, config.padding);
        Self { kind, radius, padding, bounds: Rect::default(), size: (0, 0), place: [0.0; 2], template: Vec::new() }
    }

    fn search(&self, image: Image<'_>) -> [f64; 2] {
        let (width, height) = self.size;
        let last = Rect::new(floor(self.place[0]), floor(self.place[1]), width, height);
        let window = Window::new(last, self.radius, self.bounds, self.padding);
        let (left, top) = (*window.xs().start(), *window.ys().start());
        let size = (window.xs().end() + i32::from(width) - left, window.ys().end() + i32::from(height) - top);
        // The canvas holds every pixel that a box at any position in the search window covers.
        let canvas: Vec<u8> = levels(image, (left, top), size).collect();
        let rows = |x: i32, y: i32| {
            let (column, row, stride) = (index(x - left), index(y - top), index(size.0));
            let below = canvas[row * stride..].chunks_exact(stride).map(move |row| &row[column..]);
            below.zip(self.template.chunks_exact(width.into()))
        };
        let (x, y) = match self.kind {
            MethodKind::Ncc => {
                let (spread, sums) = (Spread::new(&self.template), integral(&canvas, index(size.0)));
                let at = |x: i32, y: i32| sums[index(y - top) * (index(size.0) + 1) + index(x - left)];
                best(&window, last, |x, y, _| {
                    let (right, low) = (x + i32::from(width), y + i32::from(height));
                    let [a, b, c, d] = [at(x, y), at(right, y), at(x, low), at(right, low)];
                    -spread.correlation([0, 1].map(|i| d[i] + a[i] - b[i] - c[i]), rows(x, y))
                })
            }
            MethodKind::Ssd => {
                best(&window, last, |x, y, least| difference(rows(x, y), least, |f, g| u32::from(f.abs_diff(g)).pow(2)))
            }
            _ => best(&window, last, |x, y, least| difference(rows(x, y), least, |f, g| f.abs_diff(g).into())),
        };
        [x.into(), y.into()]
    }

    fn flow(&self, image: Image<'_>) -> [f64; 2] {
        let limits = |place: f64, radius: u16, size: u16, frame: u16| {
            let (radius, padding) = (f64::from(radius), f64::from(self.padding));
            let (least, most) = (-padding, f64::from(frame) + padding - f64::from(size));
            ((place - radius).max(least), (place + radius).min(most))
        };
        let xs = limits(self.place[0], self.radius.x, self.size.0, self.bounds.width);
        let ys = limits(self.place[1], self.radius.y, self.size.1, self.bounds.height);
        flow::find(image, &self.template, self.size, self.place, [xs, ys])
    }
}

impl Method for Baseline {
    fn kind(&self) -> MethodKind {
        self.kind
    }

    fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<()> {
        let error = match target {
            target if target.is_empty() => Some(LockError::BoxEmpty),
            target if !frame.bounds().contains(target) => Some(LockError::BoxOutsideFrame),
            target if target.area() > MAX_PIXELS => Some(LockError::BoxTooLarge),
            _ => None,
        };
        error.map_or(Ok(()), Err)?;
        let patch = frame.patch(target).ok_or(LockError::LockWindowNotInMemory)?;
        self.template = patch.rows().flatten().copied().collect();
        (self.size, self.bounds) = ((target.width, target.height), frame.bounds());
        self.place = [target.x.into(), target.y.into()];
        Ok(())
    }

    fn update(&mut self, frame: &Frame<'_>) -> Result<MethodAnswer> {
        match self.bounds {
            bounds if bounds.is_empty() => return Err(UpdateError::NotLocked.into()),
            bounds if bounds != frame.bounds() => return Err(UpdateError::FrameSizeChanged.into()),
            _ => {}
        }
        let image = frame.patch(self.bounds).ok_or(UpdateError::WindowNotInMemory)?;
        self.place = if self.kind == MethodKind::Lk { self.flow(image) } else { self.search(image) };
        let ([x, y], (width, height)) = (self.place, self.size);
        let target = BoundingBox { x, y, width: width.into(), height: height.into() };
        let (right, lower) = (x + target.width, y + target.height);
        let inside = x >= 0.0 && y >= 0.0 && right <= self.bounds.width.into() && lower <= self.bounds.height.into();
        if inside {
            let (left, top) = (floor(x), floor(y));
            let found = Plane::new(image, (left, top), (i32::from(width) + 1, i32::from(height) + 1));
            self.template = found.patch([x - f64::from(left), y - f64::from(top)], self.size).map(byte).collect();
        }
        Ok(MethodAnswer::of_baseline(target, inside))
    }

    fn template(&self) -> Option<Image<'_>> {
        Image::new(&self.template, self.size.0, self.size.1).ok()
    }
}

/// Returns the position of least cost; among equal costs the closest to `last`, then the upper, then the left one.
/// `cost` gets x, y and the least cost so far; it may stop early and return any partial sum above that least cost.
fn best(window: &Window, last: Rect, mut cost: impl FnMut(i32, i32, f64) -> f64) -> (i32, i32) {
    let distance = |(x, y): (i32, i32)| u64::from(x.abs_diff(last.x)).pow(2) + u64::from(y.abs_diff(last.y)).pow(2);
    // Starts at the last position, which is likely to be the best, so that the sums of later positions stop early.
    let (mut best, mut least) = ((last.x, last.y), cost(last.x, last.y, f64::INFINITY));
    // Scans from the top left, so that the first of equally close positions wins; the position `last` wins every tie.
    for at in window.ys().flat_map(|y| window.xs().map(move |x| (x, y))) {
        let here = cost(at.0, at.1, least);
        if here < least || (here == least && distance(at) < distance(best)) {
            (best, least) = (at, here);
        }
    }
    best
}

/// A row of pixels of the frame, and a row of the template, which may be shorter.
type Pair<'a> = (&'a [u8], &'a [u8]);

/// Returns the sum of `pixel(f, g)` over all frame pixels f, each with the template pixel g at its place. Stops after
/// the row in which the sum exceeds `enough`.
#[inline]
fn difference<'a>(rows: impl Iterator<Item = Pair<'a>>, enough: f64, pixel: impl Fn(u8, u8) -> u32) -> f64 {
    let mut sum = 0.0;
    for (f, g) in rows {
        // The sums are integers below 2^53, which f64 holds exactly.
        sum += f64::from(f.iter().zip(g).map(|(&f, &g)| pixel(f, g)).sum::<u32>());
        if sum > enough {
            break;
        }
    }
    sum
}

/// Template statistics: pixel count n, sum of the levels, and n^2 times their variance (at most 2^40 * 255^2 < 2^56).
struct Spread {
    pixels: i64,
    sum: i64,
    spread: i64,
}

impl Spread {
    fn new(template: &[u8]) -> Self {
        let pixels = i64::try_from(template.len()).expect("a template has at most 2^20 pixels");
        let [sum, squares] = [1, 2].map(|power| template.iter().map(|&g| i64::from(g).pow(power)).sum::<i64>());
        Self { pixels, sum, spread: pixels * squares - sum * sum }
    }

    /// Returns the correlation coefficient of the template and a box, or 0 if either is uniform. `sum` and `squares`
    /// are the exact sums of the box's levels and of their squares.
    fn correlation<'a>(&self, [sum, squares]: [i64; 2], rows: impl Iterator<Item = Pair<'a>>) -> f64 {
        let of_row = |(f, g): Pair<'_>| f.iter().zip(g).map(|(&f, &g)| u32::from(f) * u32::from(g)).sum::<u32>();
        let products: i64 = rows.map(|row| i64::from(of_row(row))).sum();
        let common = self.pixels * products - sum * self.sum;
        let spreads = (self.pixels * squares - sum * sum) as f64 * self.spread as f64;
        if spreads == 0.0 { 0.0 } else { common as f64 / spreads.sqrt() }
    }
}

/// Integral images of pixels and squared pixels, one row and column larger than the canvas: 4 entries give a box's sum.
fn integral(canvas: &[u8], stride: usize) -> Vec<[i64; 2]> {
    let mut sums = vec![[0; 2]; stride + 1];
    for row in canvas.chunks_exact(stride) {
        let (above, mut so_far) = (sums.len() - stride, [0; 2]);
        sums.push(so_far);
        for (column, &f) in row.iter().enumerate() {
            so_far = [so_far[0] + i64::from(f), so_far[1] + i64::from(f).pow(2)];
            let above = sums[above + column];
            sums.push([0, 1].map(|i| above[i] + so_far[i]));
        }
    }
    sums
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // means of bytes
fn byte(level: f64) -> u8 {
    level.round() as u8
}

fn index(value: i32) -> usize {
    usize::try_from(value).expect("the canvas begins where the window does")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use smr_core::State;
    use smr_recordings::GrayFrame;

    const ALL: [MethodKind; 3] = [MethodKind::Sad, MethodKind::Ssd, MethodKind::Ncc];

    /// A uniform picture with a 6x5 target at (`left`, `top`); no two rows or columns of the target are equal.
    fn picture(left: i32, top: i32) -> GrayFrame {
        GrayFrame::drawn(40, 30, |x, y| {
            let (i, j) = (x - left, y - top);
            let inside = (0..6).contains(&i) && (0..5).contains(&j);
            if inside { (60 + (i * i * 7 + j * 13) % 120).try_into().unwrap() } else { 20 }
        })
    }

    fn config(radius: u16, padding: u16) -> Config {
        let mut config = Config::paper();
        config.window = Radius { x: radius, y: radius };
        config.padding = padding;
        config
    }

    fn locked(kind: MethodKind, config: &Config, frame: &GrayFrame, target: Rect) -> Baseline {
        let mut baseline = Baseline::new(kind, config);
        baseline.lock(&frame.frame(), target).unwrap();
        baseline
    }

    #[test]
    fn a_target_is_followed_out_of_the_picture_and_its_template_is_kept() {
        for kind in ALL {
            let mut baseline = locked(kind, &config(6, 20), &picture(5, 10), Rect::new(5, 10, 6, 5));
            let inside = baseline.update(&picture(1, 12).frame()).unwrap();
            assert_eq!(inside, MethodAnswer::locked(Rect::new(1, 12, 6, 5)), "{kind:?}");
            let template = baseline.template.clone();
            let leaving = baseline.update(&picture(-2, 13).frame()).unwrap();
            assert_eq!(leaving.state, State::Leaving, "{kind:?}");
            assert_eq!(baseline.template, template, "{kind:?}");
        }
    }

    #[test]
    fn without_texture_the_box_stays_where_it_was() {
        let plain = GrayFrame { width: 20, height: 20, pixels: vec![90; 400] };
        let target = Rect::new(7, 6, 4, 3);
        for kind in ALL {
            let mut baseline = locked(kind, &config(3, 0), &plain, target);
            assert_eq!(baseline.update(&plain.frame()).unwrap().target, Some(target.into()), "{kind:?}");
        }
    }

    #[test]
    fn correlation_does_not_see_brightness_and_contrast() {
        let mut darker = picture(12, 9);
        darker.pixels.iter_mut().for_each(|pixel| *pixel = *pixel / 3 + 1);
        let mut baseline = locked(MethodKind::Ncc, &config(6, 0), &picture(10, 10), Rect::new(10, 10, 6, 5));
        assert_eq!(baseline.update(&darker.frame()).unwrap().target, Some(Rect::new(12, 9, 6, 5).into()));
    }

    #[test]
    fn what_cannot_be_followed_is_an_error() {
        let frame = picture(5, 5);
        for kind in [MethodKind::Sad, MethodKind::Lk] {
            let mut baseline = Baseline::new(kind, &config(3, 0));
            assert_eq!(baseline.update(&frame.frame()).unwrap_err().downcast_ref(), Some(&UpdateError::NotLocked));
            let large = GrayFrame { width: 1025, height: 1024, pixels: vec![0; 1025 * 1024] };
            for (frame, target, expected) in [
                (&frame, Rect::default(), LockError::BoxEmpty),
                (&frame, Rect::new(36, 0, 6, 5), LockError::BoxOutsideFrame),
                (&large, Rect::new(0, 0, 1025, 1024), LockError::BoxTooLarge),
            ] {
                assert_eq!(baseline.lock(&frame.frame(), target).unwrap_err().downcast_ref(), Some(&expected));
            }
            baseline.lock(&large.frame(), Rect::new(0, 0, 1024, 1024)).unwrap();
            assert_eq!(
                baseline.update(&frame.frame()).unwrap_err().downcast_ref(),
                Some(&UpdateError::FrameSizeChanged)
            );
        }
    }

    #[test]
    fn the_largest_sums_are_exact() {
        let frame = |pixel: u8| GrayFrame { width: 1024, height: 1024, pixels: vec![pixel; 1 << 20] };
        let target = Rect::new(0, 0, 1024, 1024);
        let (white, black) = (frame(255).pixels, frame(0).pixels);
        let rows = white.chunks_exact(1024).zip(black.chunks_exact(1024));
        let squares = difference(rows, f64::INFINITY, |f, g| u32::from(f.abs_diff(g)).pow(2));
        assert_eq!(squares, 1_048_576.0 * 255.0 * 255.0);
        assert_eq!(integral(&white, 1024).last(), Some(&[255 << 20, (255 * 255) << 20]));
        for kind in ALL {
            let mut baseline = locked(kind, &config(0, 0), &frame(255), target);
            assert_eq!(baseline.update(&frame(255).frame()).unwrap().target, Some(target.into()));
        }
    }

    fn plain_cost(kind: MethodKind, frame: &GrayFrame, template: &[u8], target: Rect) -> f64 {
        let rows = (target.y..target.bottom()).flat_map(|y| (target.x..target.right()).map(move |x| frame.level(x, y)));
        let pairs: Vec<(f64, f64)> = rows.zip(template).map(|(f, &g)| (f.into(), g.into())).collect();
        let sum = |of: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|&(f, g)| of(f, g)).sum::<f64>();
        match kind {
            MethodKind::Sad => sum(&|f, g| (f - g).abs()),
            MethodKind::Ssd => sum(&|f, g| (f - g).powi(2)),
            _ => {
                let (f_mean, g_mean) = (sum(&|f, _| f) / pairs.len() as f64, sum(&|_, g| g) / pairs.len() as f64);
                let common = sum(&|f, g| (f - f_mean) * (g - g_mean));
                let spreads = sum(&|f, _| (f - f_mean).powi(2)) * sum(&|_, g| (g - g_mean).powi(2));
                if spreads < 1e-9 { 0.0 } else { -common / spreads.sqrt() }
            }
        }
    }

    /// Frames of few gray levels, so that ties are frequent.
    fn frames() -> impl Strategy<Value = Vec<GrayFrame>> {
        let frame = proptest::collection::vec(prop_oneof![Just(0_u8), Just(1), Just(2), Just(255)], 11 * 9)
            .prop_map(|pixels| GrayFrame { width: 11, height: 9, pixels });
        proptest::collection::vec(frame, 2..5)
    }

    proptest! {
        #[test]
        fn the_best_is_what_a_plain_search_finds(
            frames in frames(),
            (width, height, x, y) in (1..5_u16, 1..5_u16, 0..7_i32, 0..5_i32),
            (radius, padding) in (0..6_u16, 0..8_u16),
            kind in prop::sample::select(&ALL[..]),
        ) {
            let mut target = Rect::new(x, y, width, height);
            let config = config(radius, padding);
            let mut baseline = locked(kind, &config, &frames[0], target);
            for frame in &frames[1..] {
                let window = Window::new(target, config.window, frame.frame().bounds(), padding);
                let cost = |x, y| plain_cost(kind, frame, &baseline.template, Rect { x, y, ..target });
                // The tie rule of smr-core: least cost, then closest to `target`, then the upper, then the left one.
                let rank = |(x, y): (i32, i32)| (x.abs_diff(target.x).pow(2) + y.abs_diff(target.y).pow(2), y, x);
                let all: Vec<_> = window.ys().flat_map(|y| window.xs().map(move |x| (x, y))).collect();
                let least = all.iter().map(|&(x, y)| cost(x, y)).fold(f64::INFINITY, f64::min);
                // The reference correlation is not exact, so costs that differ in the last digits count as equal.
                let slack = if kind == MethodKind::Ncc { 1e-9 } else { 0.0 };
                let best: Vec<_> = all.into_iter().filter(|&(x, y)| cost(x, y) <= least + slack).collect();

                let found = baseline.update(&frame.frame()).unwrap().target.unwrap().to_rect().unwrap();
                if kind == MethodKind::Ncc {
                    prop_assert!(best.contains(&(found.x, found.y)));
                } else {
                    prop_assert_eq!(Some((found.x, found.y)), best.into_iter().min_by_key(|&at| rank(at)));
                }
                target = found;
            }
        }
    }
}
