//! Colors of boxes, curves and backgrounds. `report/trackers.rs` defines the colors of methods and of result files.

use smr_core::State;

/// Red, green and blue, 0 to 255 each.
pub type Color = [u8; 3];

pub const WHITE: Color = [255; 3];
pub(crate) const BLACK: Color = [0; 3];
pub(crate) const PAPER: Color = [24; 3];
pub(crate) const GRID: Color = [90; 3];

/// Box colors of targets, as in the viewer and the page: `build.rs` reads them from the front end's colors.js.
const TARGETS: &[Color] = include!(concat!(env!("OUT_DIR"), "/targets.rs"));

/// Returns the color of the target `id`. Ids begin at 1.
pub const fn of_target(id: usize) -> Color {
    TARGETS[id.saturating_sub(1) % TARGETS.len()]
}

pub const TRUTH: Color = [0, 230, 90];

/// Returns the color of a tracker's state in a figure. The normal state, tracking, gets an inconspicuous gray.
pub const fn color_of(state: State) -> Color {
    match state {
        State::Tracking => [150, 160, 170],
        State::Lost => [190, 100, 255],
        _ => [240, 170, 0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn viewer_page_and_video_have_one_palette() {
        let css = |name: &str, [red, green, blue]: Color| format!("--{name}: rgb({red} {green} {blue})");
        for (name, state) in [("leaving", State::Leaving), ("lost", State::Lost)] {
            assert!(crate::front_end::STYLES[1].contains(&css(name, color_of(state))), "{name} in the dark");
        }
        let targets = crate::front_end::module("colors.js").unwrap();
        assert_eq!(TARGETS.len(), 8);
        for (at, [red, green, blue]) in TARGETS.iter().enumerate() {
            assert!(targets.contains(&format!("\"#{red:02x}{green:02x}{blue:02x}\"")), "{at}");
        }
        assert_eq!((of_target(1), of_target(9)), ([0xFF, 0x6E, 0xC7], of_target(1)));
    }
}
