//! Shows trackers' answers: reports, the paper's figures, videos, and the live page of `host-sim view`.
//!
//! [`report`] renders the HTML page of a recording and the paper's figures. [`export`] writes recordings as files:
//! pictures, Y4M, C arrays, the layouts of toolkits, and videos with boxes. [`viewer`] serves `host-sim view`.
//! `smr-evaluation` runs the trackers. The caller chooses the paths of files.

pub mod colors;
mod encode;
pub mod export;
pub mod front_end;
#[cfg(test)]
#[path = "../../../tests/missing.rs"]
mod missing;
pub mod report;
pub mod viewer;
