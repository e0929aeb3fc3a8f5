//! The paper's tracker: template matching with the last appearance of the target, pixel by pixel.
//!
//! | file | what it does | step of the paper |
//! |---|---|---|
//! | `config.rs` | the numbers of the method, and the presets | |
//! | `track.rs` | the track of a target, and its search window; whether a match is accepted | 1 |
//! | `template.rs` | the template and alpha | 5, 6 |
//! | `saved.rs` | a target as bytes | |
//! | `target.rs` | an update: window, search, gate, template, answer; scratch memory | |
//!
//! Steps 2 to 4, the scores and the peak, are in [`similarity`](crate::similarity) and in `search`.

mod config;
mod saved;
pub(crate) mod target;
mod template;
#[cfg(test)]
mod tests;
mod track;

pub use crate::search::Radius;
pub use config::{Config, Fraction, Margins};
#[cfg(any(test, feature = "unstable"))]
pub(crate) use target::Paper;
pub use target::Workspace;
