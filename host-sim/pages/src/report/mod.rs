//! What people look at: methods side by side on recordings, as one page, as one picture or as figures; how fast they are and what
//! their confidence is worth, as diagrams.

pub mod axes;
pub mod calibration;
pub mod canvas;
mod coordinates;
mod data;
pub mod diagram;
mod difference;
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
