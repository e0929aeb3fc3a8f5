//! The colors of boxes, curves and grounds, in all pictures. `report/palette.rs` has the colors of other trackers' results, and fits all to a page.

use smr_core::State;
use smr_evaluation::MethodKind;

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

// The paper's colors: SMR red, SAD blue. They must be told from each other on any frame, and from the states'.
pub const SMR: Color = [255, 64, 64];
pub const SAD: Color = [64, 140, 255];
pub const TRUTH: Color = [0, 230, 90];

pub(crate) const fn color_of_method(method: MethodKind) -> Color {
    match method {
        MethodKind::Smr => SMR,
        MethodKind::Robust => [255, 130, 220],
        MethodKind::Sad => SAD,
        MethodKind::Ssd => [0, 205, 220],
        MethodKind::Ncc => [200, 225, 90],
        MethodKind::Lk => [235, 235, 235],
    }
}

/// The color of a state. Tracking is what is expected: it does not catch the eye.
pub const fn color_of(state: State) -> Color {
    match state {
        State::Tracking => [150, 160, 170],
        State::Leaving | State::Uncertain => [240, 170, 0],
        State::Lost => [190, 100, 255],
    }
}
