//! The colors of boxes, curves and grounds, in all pictures. `report/trackers.rs` has those of methods and of other trackers' results.

use smr_core::State;

/// A color as red, green, blue.
pub type Color = [u8; 3];

pub const WHITE: Color = [255; 3];
pub(crate) const BLACK: Color = [0; 3];
pub(crate) const PAPER: Color = [24; 3];
pub(crate) const GRID: Color = [90; 3];

// Boxes in videos, by the state of the one target.
pub const GREEN: Color = [40, 230, 100];
pub const AMBER: Color = [255, 190, 0];
pub const RED: Color = [255, 70, 60];
/// The colors of several targets, in turn.
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

/// The color of a state. Tracking is what is expected: it does not catch the eye.
pub const fn color_of(state: State) -> Color {
    match state {
        State::Tracking => [150, 160, 170],
        State::Leaving | State::Uncertain => [240, 170, 0],
        State::Lost => [190, 100, 255],
    }
}
