//! The colors of the front end's colors.css, from which `build.rs` makes constants. Frames, videos and figures have those for
//! dark pages.

use smr_core::State;

/// Red, green and blue, 0 to 255 each.
pub type Color = [u8; 3];

/// A color on light and on dark pages.
pub(crate) struct Shades {
    /// Name in colors.css, without `--`.
    pub name: &'static str,
    #[allow(dead_code)] // pages have it from the file itself
    pub light: Color,
    pub dark: Color,
}

#[allow(dead_code)] // pages alone use some
pub(crate) mod css {
    use super::Shades;
    include!(concat!(env!("OUT_DIR"), "/colors.rs"));
}

pub const WHITE: Color = [255; 3];
pub(crate) const BLACK: Color = [0; 3];
pub const TRUTH: Color = css::TRUTH.dark;

/// Returns the color of the target `id`. Ids begin at 1.
pub const fn of_target(id: usize) -> Color {
    css::TARGETS[id.saturating_sub(1) % css::TARGETS.len()].dark
}

/// Returns the color of a state's name on a frame. The normal state, tracking, is inconspicuous there.
pub const fn color_of(state: State) -> Color {
    match state {
        State::Tracking => WHITE,
        State::Lost => css::LOST.dark,
        _ => css::LEAVING.dark,
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Least contrast ratio of a curve to its background, as WCAG 2 requires for graphics.
    const CONTRAST: f64 = 3.0;

    /// Returns the contrast ratio of WCAG 2: 1 for equal colors, 21 for black and white.
    fn contrast(one: Color, other: Color) -> f64 {
        let (one, other) = (luminance(one), luminance(other));
        (one.max(other) + 0.05) / (one.min(other) + 0.05)
    }

    fn luminance(color: Color) -> f64 {
        let linear = color.map(|channel| {
            let channel = f64::from(channel) / 255.0;
            if channel <= 0.040_45 { channel / 12.92 } else { ((channel + 0.055) / 1.055).powf(2.4) }
        });
        0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    }

    /// True if the color is seen on a plot of a light and of a dark page.
    pub(crate) fn is_seen(color: &Shades) -> bool {
        contrast(color.light, css::PANEL.light) >= CONTRAST && contrast(color.dark, css::PANEL.dark) >= CONTRAST
    }

    #[test]
    fn states_letters_and_targets_are_seen() {
        for color in [css::TRACKING, css::LEAVING, css::LOST, css::FOCUS, css::INK, css::FAINT, css::TRUTH] {
            assert!(is_seen(&color), "{}", color.name);
        }
        for target in css::TARGETS {
            assert!(contrast(target.dark, BLACK) >= CONTRAST, "{} on the dark border of its letters", target.name);
        }
        assert_eq!((css::TARGETS.len(), of_target(1), of_target(9)), (8, [0xFF, 0x6E, 0xC7], of_target(1)));
        assert_eq!((css::FILES.len(), css::FILES[9].name), (14, "file10"));
        assert_eq!((css::PAPER.light, css::PAPER.dark), (WHITE, [21, 24, 27]));
    }

    #[test]
    fn contrast_is_that_of_wcag() {
        assert_eq!((contrast([0; 3], [255; 3]), contrast([7; 3], [7; 3])), (21.0, 1.0));
        assert!((contrast([119; 3], [255; 3]) - 4.48).abs() < 0.01);
    }
}
