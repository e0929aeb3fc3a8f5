//! Files of host-sim. [`output`] writes a file whole or not at all, [`cleanup`] removes what is unfinished on a signal,
//! [`input`] reads a file up to a limit, [`wait`] ends a read from another thread, and [`messages`] are their errors.

pub mod cleanup;
pub mod input;
pub mod messages;
#[cfg(test)]
#[path = "../../../tests/missing.rs"]
mod missing;
pub mod output;
pub mod wait;
