//! The paper's tracker: the last appearance of the target is looked for in every frame, pixel by pixel.
//!
//! | file | steps of the paper |
//! |---|---|
//! | `config.rs` | every number of the method, and the presets |
//! | `template.rs` | the template and alpha (5, 6) |
//! | `gate.rs` | whether a frame is believed, and the window that follows (1) |
//! | `target.rs` | the way of a frame through the tracker; scoring (2, 3, 4) is that of [`similarity`](crate::similarity) and [`search`](crate::search) |
//! | `workspace.rs` | scratch memory |
//! | `saved.rs` | the target as bytes |

mod config;
mod gate;
mod saved;
mod target;
mod template;
#[cfg(test)]
mod tests;
mod workspace;

pub use crate::search::Radius;
pub use config::{Config, Fraction, Gate, Margins, RunnerUp};
pub(super) use saved::numbers;
pub use target::Paper;
pub use workspace::Workspace;
