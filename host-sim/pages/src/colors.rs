//! Colors of boxes, curves and backgrounds. `report/trackers.rs` defines the colors of methods and of result files.

use smr_core::State;

/// Red, green and blue, 0 to 255 each.
pub type Color = [u8; 3];

pub const WHITE: Color = [255; 3];
pub(crate) const BLACK: Color = [0; 3];
pub(crate) const PAPER: Color = [24; 3];
pub(crate) const GRID: Color = [90; 3];

// Box colors in a video of one target: tracking is green, uncertain or leaving is amber, lost is red.
pub const GREEN: Color = [40, 230, 100];
pub const AMBER: Color = [255, 190, 0];
pub const RED: Color = [255, 70, 60];
/// Box colors in a video of several targets, by target index; they repeat after the last.
pub const TARGETS: [Color; 8] = [
    [0, 200, 255],
    [255, 120, 220],
    [255, 225, 60],
    [120, 255, 120],
    [255, 150, 60],
    [170, 150, 255],
    [60, 255, 220],
    [255, 110, 110],
];

pub const TRUTH: Color = [0, 230, 90];

/// Returns the color of a tracker's state in a figure. The normal state, tracking, gets an inconspicuous gray.
pub const fn color_of(state: State) -> Color {
    match state {
        State::Tracking => [150, 160, 170],
        State::Leaving | State::Uncertain => [240, 170, 0],
        State::Lost => [190, 100, 255],
    }
}
