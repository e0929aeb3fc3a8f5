//! Patches as PNG: gray levels, or differences, of which those that count are green.

use crate::colors::Color;
use crate::encode::palette_png;
use anyhow::Result;

/// Gray levels, row by row.
pub(super) fn patch(size: (u16, u16), levels: &[u8]) -> Result<Vec<u8>> {
    palette_png(size, levels, coarse)
}

/// Differences, brighter than they are, because most are small. Those below `alpha` count, and are green.
pub(super) fn differences(size: (u16, u16), levels: &[u8], alpha: Option<u16>) -> Result<Vec<u8>> {
    palette_png(size, levels, |level| match alpha {
        Some(alpha) if u16::from(level) < alpha => counting_color(level),
        _ => coarse(gray(level)),
    })
}

/// Half of the gray levels are enough for the eye, and noise makes up most of a file.
fn coarse(gray: u8) -> Color {
    [gray / 2 * 2 + gray / 128; 3]
}

/// The difference with the brightest shade. Larger ones look the same.
const BRIGHTEST: u8 = 127;

/// The shade of a difference. It rises steeply at first, because most differences are small.
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
    fn brightness_grows_with_the_difference() {
        assert!((1..=BRIGHTEST).all(|level| gray(level) >= gray(level - 1)));
        assert_eq!((gray(0), gray(BRIGHTEST)), (0, 255));
    }
}
