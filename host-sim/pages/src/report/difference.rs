//! Absolute differences |F - G| between the pixels of a patch F of the frame and of the template G, and their image.

use crate::colors::Color;
use crate::encode::palette_png;
use anyhow::Result;
use smr_core::Rect;
use smr_recordings::GrayFrame;

/// A template G, and in `pixels` its differences |F - G| from a patch F of the frame, as large as the template.
pub(super) struct Difference {
    pub pixels: GrayFrame,
    pub template: GrayFrame,
}

/// Gray levels that one bar of a histogram spans.
pub(super) const BAR: usize = 2;
/// Number of bars of a histogram. The last has all differences from 126 up; most exceed alpha and add no similarity.
pub(super) const BARS: usize = 64;

impl Difference {
    pub fn new(frame: &GrayFrame, at: Rect, template: GrayFrame) -> Self {
        let GrayFrame { width, height, .. } = template;
        let mut pixels = part(frame, Rect { width, height, ..at });
        pixels.pixels.iter_mut().zip(&template.pixels).for_each(|(f, g)| *f = f.abs_diff(*g));
        Self { pixels, template }
    }

    /// Returns the fraction of the pixels in each bar.
    pub fn histogram(&self) -> [f64; BARS] {
        let mut counts = [0_u32; BARS];
        for &difference in &self.pixels.pixels {
            counts[(usize::from(difference) / BAR).min(BARS - 1)] += 1;
        }
        counts.map(|count| f64::from(count) / self.pixels.pixels.len().max(1) as f64)
    }

    /// Returns the fraction of pixels that count toward the similarity: those whose difference is below `alpha`.
    pub fn counting(&self, alpha: u16) -> f64 {
        let counting = self.pixels.pixels.iter().filter(|&&difference| u16::from(difference) < alpha).count();
        counting as f64 / self.pixels.pixels.len().max(1) as f64
    }
}

/// Crops a part of a frame. Pixels outside the frame are 0, as in the trackers.
pub(super) fn part(frame: &GrayFrame, Rect { x, y, width, height }: Rect) -> GrayFrame {
    let rows = (y..).take(height.into());
    let pixels = rows.flat_map(|y| (x..).take(width.into()).map(move |x| frame.level(x, y))).collect();
    GrayFrame { width, height, pixels }
}

pub(super) fn patch(levels: &GrayFrame) -> Result<Vec<u8>> {
    palette_png(levels, coarse)
}

/// Encodes differences as PNG, brightened because most are small. Pixels with a difference below `alpha` are green.
pub(super) fn differences(levels: &GrayFrame, alpha: Option<u16>) -> Result<Vec<u8>> {
    palette_png(levels, |level| match alpha {
        Some(alpha) if u16::from(level) < alpha => counting_color(level),
        _ => coarse(gray(level)),
    })
}

/// Quantises a gray level to 128 levels, which are enough for the eye: noise in the lowest bit would enlarge the file.
fn coarse(gray: u8) -> Color {
    [gray / 2 * 2 + gray / 128; 3]
}

/// Smallest difference that is drawn at full brightness.
const BRIGHTEST: u8 = 127;

/// Returns the brightness of a difference: its square root, scaled, because most differences are small.
fn gray(level: u8) -> u8 {
    let shade = (255 * 255 * u32::from(level) / u32::from(BRIGHTEST)).isqrt();
    u8::try_from(shade).unwrap_or(u8::MAX)
}

fn counting_color(level: u8) -> Color {
    let shade = gray(level) / 3;
    [shade, 105 + shade, 65 + shade]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outside_the_frame_are_zeroes() {
        let frame = GrayFrame { width: 2, height: 2, pixels: vec![10, 20, 30, 40] };
        let template = GrayFrame { width: 3, height: 2, pixels: vec![9; 6] };
        let at = |x, y| Difference::new(&frame, Rect::new(x, y, 3, 2), template.clone()).pixels.pixels;
        assert_eq!(at(0, 0), [1, 11, 9, 21, 31, 9]);
        assert_eq!(at(-1, 1), [9, 21, 31, 9, 9, 9]);
    }

    #[test]
    fn the_last_bar_has_the_rest() {
        let pixels = GrayFrame { width: 4, height: 2, pixels: vec![0, 1, 2, 125, 126, 127, 200, 255] };
        let difference = Difference { template: pixels.clone(), pixels };
        let histogram = difference.histogram();
        assert_eq!([0, 1, 62, 63].map(|bar| histogram[bar]), [0.25, 0.125, 0.125, 0.5]);
        assert_eq!(histogram.iter().sum::<f64>(), 1.0);
        assert_eq!(difference.counting(2), 0.25);
    }

    #[test]
    fn brightness_grows_with_the_difference() {
        assert!((1..=BRIGHTEST).all(|level| gray(level) >= gray(level - 1)));
        assert_eq!((gray(0), gray(BRIGHTEST)), (0, 255));
    }
}
