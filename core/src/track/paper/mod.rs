//! The paper's tracker: template matching with the last appearance of the target, pixel by pixel.
//!
//! | file | what it does | step of the paper |
//! |---|---|---|
//! | `config.rs` | the numbers of the method, and the presets | |
//! | `track.rs` | the track of a target, and its search window | 1 |
//! | `gate.rs` | whether a match is accepted | |
//! | `template.rs` | the template and alpha | 5, 6 |
//! | `workspace.rs` | scratch memory | |
//! | `saved.rs` | a target as bytes | |
//! | `target.rs` | an update: window, search, gate, template, answer | |
//!
//! Steps 2 to 4, the scores and the peak, are in [`similarity`](crate::similarity) and in `search`.

mod config;
mod gate;
mod saved;
pub(crate) mod target;
mod template;
#[cfg(test)]
mod tests;
mod track;
mod workspace;

pub use crate::search::Radius;
pub use config::{Config, Fraction, Margins};
#[cfg(any(test, feature = "unstable"))]
pub(crate) use target::Paper;
pub use workspace::Workspace;
