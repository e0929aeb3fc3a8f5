//! The paper tracker: template matching with the last appearance of the target, pixel by pixel.
//!
//! | file | what it does | step of the paper |
//! |---|---|---|
//! | `config.rs` | the settings, their ranges, and the presets | |
//! | `track.rs` | the track of a target: box, state, and the search window, which grows while it is lost | 1 |
//! | `gate.rs` | the test that accepts or refuses a match; the check for a covered lens | |
//! | `search/` | scores offsets by [`similarity`](crate::similarity), with exact pruning; finds the peak | 1 to 4 |
//! | `template.rs` | the template and alpha | 5, 6 |
//! | `saved.rs` | a target as bytes | |
//! | `target.rs` | an update: window, search, gate, template, answer; scratch memory | |

mod config;
mod gate;
mod saved;
pub(crate) mod search;
pub(crate) mod target;
mod template;
#[cfg(test)]
mod tests;
mod track;

pub use config::{Config, Fraction, Margins};
pub use search::Radius;
#[cfg(any(test, feature = "unstable"))]
pub(crate) use target::Paper;
pub use target::Workspace;
