//! The trackers of the paper's comparison: SMR's window, padding, tie rule and template update, another cost.
//!
//! - here: the search that they share, SAD and SSD.
//! - `correlation`: NCC.
//! - `flow`: Lucas-Kanade, which follows gradients in place of a search.
//!
//! They always answer: they have no gate, so they are never lost and their window never grows.

mod correlation;
mod flow;

pub(super) use flow::Flow;

use super::method::{Method, MethodKind, Report};
use anyhow::Result;
use correlation::Correlation;
use smr_core::paper::{Config, Radius};
use smr_core::unstable::Window;
use smr_core::{Frame, Image, LockError, Rect, UpdateError};
use std::ops::Range;

/// How a baseline compares a patch with the template.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Measure {
    /// SAD: the sum of |F - G|, the least wins.
    Absolute,
    /// SSD: the sum of (F - G)^2, the least wins.
    Squared,
    /// NCC: the correlation coefficient of F and G, the largest wins; 0 where either is constant.
    Correlation,
}

/// The most pixels of a box, 1024x1024: all sums are exact.
pub(super) const MAX_PIXELS: u32 = 1 << 20;

pub(super) struct Baseline {
    measure: Measure,
    radius: Radius,
    padding: u16,
    target: Rect,
    /// Of the frame that was locked on; empty before the first lock.
    bounds: Rect,
    template: Vec<u8>,
}

impl Baseline {
    pub(super) fn new(measure: Measure, config: &Config) -> Self {
        let nothing = Rect::default();
        let (radius, padding) = (config.window, config.padding);
        Self { measure, radius, padding, target: nothing, bounds: nothing, template: Vec::new() }
    }

    fn best(&self, window: &Window, canvas: &Canvas) -> (i32, i32) {
        let template = Patch { pixels: &self.template, width: self.target.width.into() };
        match self.measure {
            Measure::Absolute => search(window, self.target, |x, y, best| {
                difference(canvas.rows_at(x, y), template, best, |f, g| u32::from(f.abs_diff(g)))
            }),
            Measure::Squared => search(window, self.target, |x, y, best| {
                difference(canvas.rows_at(x, y), template, best, |f, g| u32::from(f.abs_diff(g)).pow(2))
            }),
            Measure::Correlation => {
                let correlation = Correlation::new(canvas, template);
                search(window, self.target, |x, y, _| -correlation.at(x, y))
            }
        }
    }
}

impl Method for Baseline {
    fn kind(&self) -> MethodKind {
        match self.measure {
            Measure::Absolute => MethodKind::Sad,
            Measure::Squared => MethodKind::Ssd,
            Measure::Correlation => MethodKind::Ncc,
        }
    }

    fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<()> {
        self.template = first_template(frame, target)?;
        (self.target, self.bounds) = (target, frame.bounds());
        Ok(())
    }

    fn update(&mut self, frame: &Frame<'_>) -> Result<Report> {
        check_size(frame, self.bounds)?;
        let window = Window::new(self.target, self.radius, self.bounds, self.padding);
        let (width, height) = (i32::from(self.target.width), i32::from(self.target.height));
        let xs = *window.xs().start()..*window.xs().end() + width;
        let ys = *window.ys().start()..*window.ys().end() + height;
        let canvas = Canvas::new(frame, xs, ys).ok_or(UpdateError::WindowNotInMemory)?;

        let (x, y) = self.best(&window, &canvas);
        self.target = Rect { x, y, ..self.target };
        let patch = frame.patch(self.target);
        if let Some(patch) = patch {
            self.template.clear();
            self.template.extend(patch.rows().flatten());
        }
        Ok(Report::of_baseline(self.target.into(), patch.is_some()))
    }

    fn template(&self) -> Option<Image<'_>> {
        Image::new(&self.template, self.target.width, self.target.height).ok()
    }
}

/// The pixels of the box that is locked on.
fn first_template(frame: &Frame<'_>, target: Rect) -> Result<Vec<u8>> {
    if target.is_empty() {
        return Err(LockError::BoxEmpty.into());
    }
    if !frame.bounds().contains(target) {
        return Err(LockError::BoxOutsideFrame.into());
    }
    if target.area() > MAX_PIXELS {
        return Err(LockError::BoxTooLarge.into());
    }
    let patch = frame.patch(target).ok_or(LockError::LockWindowNotInMemory)?;
    Ok(patch.rows().flatten().copied().collect())
}

/// Errors: The frame that was locked on, if one was, did not have the size of `bounds`.
fn check_size(frame: &Frame<'_>, bounds: Rect) -> Result<(), UpdateError> {
    match bounds {
        bounds if bounds.is_empty() => Err(UpdateError::NotLocked),
        bounds if bounds != frame.bounds() => Err(UpdateError::FrameSizeChanged),
        _ => Ok(()),
    }
}

/// The position of least cost, of equal ones the closest to `last`, then the upper, then the left one.
///
/// `cost` is told the least cost so far, and may stop and give anything larger once it is past that.
fn search(window: &Window, last: Rect, mut cost: impl FnMut(i32, i32, f64) -> f64) -> (i32, i32) {
    let distance = |x: i32, y: i32| {
        let (dx, dy) = (u64::from(x.abs_diff(last.x)), u64::from(y.abs_diff(last.y)));
        dx * dx + dy * dy
    };
    // The last position comes first: it is in the window, and mostly gives a bound that stops the others early.
    let (mut best, mut least) = ((last.x, last.y), cost(last.x, last.y, f64::INFINITY));
    // Rows from the top, columns from the left: of equally close ones the first to come is the one that wins. The last
    // position loses to none of them, for it alone is at distance 0.
    for (x, y) in window.ys().flat_map(|y| window.xs().map(move |x| (x, y))) {
        let here = cost(x, y, least);
        if here < least || (here == least && distance(x, y) < distance(best.0, best.1)) {
            (best, least) = ((x, y), here);
        }
    }
    best
}

/// Rows of pixels without a gap.
#[derive(Clone, Copy)]
struct Patch<'a> {
    pixels: &'a [u8],
    width: usize,
}

/// The sum of `pixel` over all pairs, row by row until it is more than `enough`.
#[inline]
fn difference<'a>(
    rows: impl Iterator<Item = &'a [u8]>,
    template: Patch<'_>,
    enough: f64,
    pixel: impl Fn(u8, u8) -> u32,
) -> f64 {
    let mut sum = 0.0;
    for (f, g) in rows.zip(template.pixels.chunks_exact(template.width)) {
        // Sums of u32 below 2^53: exact in f64.
        sum += f64::from(f.iter().zip(g).map(|(&f, &g)| pixel(f, g)).sum::<u32>());
        if sum > enough {
            break;
        }
    }
    sum
}

/// All pixels that the boxes of one window cover, with the padding's zeroes written out: speed, not memory, counts here.
struct Canvas {
    pixels: Vec<u8>,
    stride: usize,
    left: i32,
    top: i32,
}

impl Canvas {
    /// `None` if the frame is not wholly in memory.
    fn new(frame: &Frame<'_>, xs: Range<i32>, ys: Range<i32>) -> Option<Self> {
        let image = frame.patch(frame.bounds())?;
        let (stride, width) = (xs.len(), i32::from(image.width()));
        let mut pixels = vec![0; stride * ys.len()];
        let seen = xs.start.max(0)..xs.end.min(width);
        if !seen.is_empty() {
            let (from, to) = (index(seen.start), index(seen.end));
            let at = index(seen.start - xs.start);
            for (y, line) in ys.clone().zip(pixels.chunks_exact_mut(stride)) {
                let row = u16::try_from(y).map_or(&[][..], |y| image.row(y));
                if let Some(row) = row.get(from..to) {
                    line[at..at + row.len()].copy_from_slice(row);
                }
            }
        }
        Some(Self { pixels, stride, left: xs.start, top: ys.start })
    }

    fn locate(&self, x: i32, y: i32) -> (usize, usize) {
        (index(x - self.left), index(y - self.top))
    }

    /// From the pixel at (`x`, `y`) of the frame to the end of its row, then the same of the rows below.
    fn rows_at(&self, x: i32, y: i32) -> impl Iterator<Item = &[u8]> {
        let (column, row) = self.locate(x, y);
        self.pixels[row * self.stride..].chunks_exact(self.stride).map(move |row| &row[column..])
    }
}

/// What is known not to be negative as an index.
fn index(value: i32) -> usize {
    usize::try_from(value).expect("the canvas begins where the window does")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use smr_core::State;
    use smr_recordings::GrayFrame;

    const ALL: [Measure; 3] = [Measure::Absolute, Measure::Squared, Measure::Correlation];

    /// A plain picture with a 6x5 target, no two rows or columns of which are alike, at (`left`, `top`).
    fn picture(left: i32, top: i32) -> GrayFrame {
        let pixel = |x: i32, y: i32| {
            let (i, j) = (x - left, y - top);
            if (0..6).contains(&i) && (0..5).contains(&j) { 60 + (i * i * 7 + j * 13) % 120 } else { 20 }
        };
        let pixels = (0..30).flat_map(|y| (0..40).map(move |x| pixel(x, y).try_into().unwrap())).collect();
        GrayFrame { width: 40, height: 30, pixels }
    }

    fn config(radius: u16, padding: u16) -> Config {
        let mut config = Config::paper();
        config.window = Radius { x: radius, y: radius };
        config.padding = padding;
        config
    }

    fn locked(measure: Measure, config: &Config, frame: &GrayFrame, target: Rect) -> Baseline {
        let mut baseline = Baseline::new(measure, config);
        baseline.lock(&frame.frame(), target).unwrap();
        baseline
    }

    #[test]
    fn a_target_is_followed_out_of_the_picture_and_its_template_is_kept() {
        for measure in ALL {
            let mut baseline = locked(measure, &config(6, 20), &picture(5, 10), Rect::new(5, 10, 6, 5));
            let inside = baseline.update(&picture(1, 12).frame()).unwrap();
            assert_eq!(inside, Report::locked(Rect::new(1, 12, 6, 5)), "{measure:?}");
            let template = baseline.template.clone();
            let leaving = baseline.update(&picture(-2, 13).frame()).unwrap();
            assert_eq!(leaving.state, State::Leaving, "{measure:?}");
            assert_eq!(baseline.template, template, "{measure:?}");
        }
    }

    #[test]
    fn without_texture_the_box_stays_where_it_was() {
        let plain = GrayFrame { width: 20, height: 20, pixels: vec![90; 400] };
        let target = Rect::new(7, 6, 4, 3);
        for measure in ALL {
            let mut baseline = locked(measure, &config(3, 0), &plain, target);
            assert_eq!(baseline.update(&plain.frame()).unwrap().target, Some(target.into()), "{measure:?}");
        }
    }

    #[test]
    fn correlation_does_not_see_brightness_and_contrast() {
        let mut darker = picture(12, 9);
        darker.pixels.iter_mut().for_each(|pixel| *pixel = *pixel / 3 + 1);
        let mut baseline = locked(Measure::Correlation, &config(6, 0), &picture(10, 10), Rect::new(10, 10, 6, 5));
        assert_eq!(baseline.update(&darker.frame()).unwrap().target, Some(Rect::new(12, 9, 6, 5).into()));
    }

    #[test]
    fn what_cannot_be_followed_is_an_error() {
        let frame = picture(5, 5);
        let mut baseline = Baseline::new(Measure::Absolute, &config(3, 0));
        assert_eq!(baseline.update(&frame.frame()).unwrap_err().downcast_ref(), Some(&UpdateError::NotLocked));
        let mut refused = |target| baseline.lock(&frame.frame(), target).unwrap_err().downcast::<LockError>().unwrap();
        assert_eq!(refused(Rect::default()), LockError::BoxEmpty);
        assert_eq!(refused(Rect::new(36, 0, 6, 5)), LockError::BoxOutsideFrame);
        let large = GrayFrame { width: 1025, height: 1024, pixels: vec![0; 1025 * 1024] };
        let too_large = baseline.lock(&large.frame(), Rect::new(0, 0, 1025, 1024)).unwrap_err();
        assert_eq!(too_large.downcast_ref(), Some(&LockError::BoxTooLarge));
        baseline.lock(&large.frame(), Rect::new(0, 0, 1024, 1024)).unwrap();
    }

    #[test]
    fn the_largest_sums_are_exact() {
        let frame = |pixel: u8| GrayFrame { width: 1024, height: 1024, pixels: vec![pixel; 1 << 20] };
        let target = Rect::new(0, 0, 1024, 1024);
        let canvas = Canvas::new(&frame(255).frame(), 0..1024, 0..1024).unwrap();
        let black = frame(0);
        let template = Patch { pixels: &black.pixels, width: 1024 };
        let squares = difference(canvas.rows_at(0, 0), template, f64::INFINITY, |f, g| u32::from(f.abs_diff(g)).pow(2));
        assert_eq!(squares, 1_048_576.0 * 255.0 * 255.0);
        for measure in ALL {
            let mut baseline = locked(measure, &config(0, 0), &frame(255), target);
            assert_eq!(baseline.update(&frame(255).frame()).unwrap().target, Some(target.into()));
        }
    }

    /// Everything anew, pixel by pixel: what a box at (`x`, `y`) costs.
    fn plain_cost(measure: Measure, frame: &GrayFrame, template: &[u8], target: Rect) -> f64 {
        let pixel = |x: i32, y: i32| {
            let inside = (0..i32::from(frame.width)).contains(&x) && (0..i32::from(frame.height)).contains(&y);
            if inside { f64::from(frame.pixels[index(y * i32::from(frame.width) + x)]) } else { 0.0 }
        };
        let places = (target.y..target.bottom()).flat_map(|y| (target.x..target.right()).map(move |x| (x, y)));
        let pairs: Vec<(f64, f64)> = places.map(|(x, y)| pixel(x, y)).zip(template.iter().map(|&g| g.into())).collect();
        let sum = |of: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|&(f, g)| of(f, g)).sum::<f64>();
        match measure {
            Measure::Absolute => sum(&|f, g| (f - g).abs()),
            Measure::Squared => sum(&|f, g| (f - g).powi(2)),
            Measure::Correlation => {
                let (f_mean, g_mean) = (sum(&|f, _| f) / pairs.len() as f64, sum(&|_, g| g) / pairs.len() as f64);
                let common = sum(&|f, g| (f - f_mean) * (g - g_mean));
                let spreads = sum(&|f, _| (f - f_mean).powi(2)) * sum(&|_, g| (g - g_mean).powi(2));
                if spreads < 1e-9 { 0.0 } else { -common / spreads.sqrt() }
            }
        }
    }

    /// Few gray levels, so that ties are frequent.
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
            measure in prop::sample::select(&ALL[..]),
        ) {
            let mut target = Rect::new(x, y, width, height);
            let config = config(radius, padding);
            let mut baseline = locked(measure, &config, &frames[0], target);
            for frame in &frames[1..] {
                let window = Window::new(target, config.window, frame.frame().bounds(), padding);
                let cost = |x, y| plain_cost(measure, frame, &baseline.template, Rect { x, y, ..target });
                // As core states it: the least cost, then the closest, then the upper, then the left one.
                let rank = |(x, y): (i32, i32)| (x.abs_diff(target.x).pow(2) + y.abs_diff(target.y).pow(2), y, x);
                let all: Vec<_> = window.ys().flat_map(|y| window.xs().map(move |x| (x, y))).collect();
                let least = all.iter().map(|&(x, y)| cost(x, y)).fold(f64::INFINITY, f64::min);
                // A plain correlation is not exact: what is equal but for its last digits may be the best.
                let slack = if measure == Measure::Correlation { 1e-9 } else { 0.0 };
                let best: Vec<_> = all.into_iter().filter(|&(x, y)| cost(x, y) <= least + slack).collect();

                let found = baseline.update(&frame.frame()).unwrap().target.unwrap().to_rect().unwrap();
                if measure == Measure::Correlation {
                    prop_assert!(best.contains(&(found.x, found.y)));
                } else {
                    prop_assert_eq!(Some((found.x, found.y)), best.into_iter().min_by_key(|&at| rank(at)));
                }
                target = found;
            }
        }
    }
}
