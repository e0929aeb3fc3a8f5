//! Files of host-sim: [`output`] writes a file whole or not at all, [`input`] reads one up to a limit. On
//! [`signals`] each [`process`] is ended and each unfinished file removed; [`wait`] ends a read from another thread.

mod cleanup;
pub mod input;
pub mod messages;
#[cfg(test)]
#[path = "../../../tests/missing.rs"]
mod missing;
pub mod output;
pub mod process;
pub mod signals;
pub mod wait;

pub use cleanup::locked;
