//! The TraX protocol (Visual Tracking eXchange), by which evaluation tools such as the VOT toolkit run a tracker: messages, a line
//! each, on two streams.
//!
//! - [`message`]: a line as a message, and back.
//! - `image`, `region`: what the arguments of messages stand for.
//! - [`serve`]: the session, from `hello` to `quit`.

mod image;
pub mod message;
mod region;
mod server;

pub use server::{PROTOCOLS, Server, serve};
