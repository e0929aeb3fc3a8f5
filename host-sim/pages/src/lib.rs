//! Pages are what people look at: frames with what trackers answered, drawn.
//!
//! [`report`] makes the HTML page of a recording, the page to choose a box on, the paper's figures and diagrams. [`export`] writes recordings as
//! files: pictures, Y4M, C arrays, the layouts of toolkits, and videos and animations with boxes drawn. It runs trackers by
//! `smr-evaluation` and shows differences as `smr-reference` has them. What is written where is said by the caller.

pub mod colors;
mod encode;
pub mod export;
pub mod front_end;
#[cfg(test)]
#[path = "../../../tests/missing.rs"]
mod missing;
pub mod report;
pub mod window;
