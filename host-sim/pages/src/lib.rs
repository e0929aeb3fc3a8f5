//! Pages for people: frames with the answers of trackers, drawn.
//!
//! [`report`] makes the HTML page of a recording and the paper's figures. [`export`] writes recordings as files: pictures, Y4M, C arrays, the
//! layouts of toolkits, and videos with boxes drawn. [`window`] serves `host-sim view`. Trackers run by `smr-evaluation`, and differences are those
//! of `smr-reference`. The caller says where files are written.

pub mod colors;
mod encode;
pub mod export;
pub mod front_end;
#[cfg(test)]
#[path = "../../../tests/missing.rs"]
mod missing;
pub mod report;
pub mod window;
