//! What people look at: methods side by side on recordings, as one page, as one picture or as figures; how fast they are and what
//! their confidence is worth, as diagrams.

pub mod axes;
pub mod calibration;
pub mod canvas;
mod coordinates;
mod data;
pub mod diagram;
mod difference;
mod encode;
mod entrants;
pub mod figures;
mod film;
mod look;
mod page;
mod palette;
mod pick;
mod picture;
mod pictures;
mod pixels;
mod reel;
mod scores;
mod tile;
mod turns;

pub use coordinates::coordinates;
pub use film::{Film, Refusal, watch, watch_all};
pub use page::{About, page};
pub use pick::{Choosing, Picked, SIDE, Shots, pick};
pub use picture::picture;
pub use reel::Choice;

use smr_core::State;
use smr_evaluation::MethodKind;

/// A color as red, green, blue.
pub type Color = [u8; 3];

// The paper's colors: SMR red, SAD blue. They must be told from each other on any frame, and from the states'.
pub const SMR: Color = [255, 64, 64];
pub const SAD: Color = [64, 140, 255];
pub const TRUTH: Color = [0, 230, 90];

/// The color of a method.
const fn color_of_method(method: MethodKind) -> Color {
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
