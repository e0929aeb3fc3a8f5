//! Tests of the C interface that need Rust, in one program.

mod errors;
mod header;
#[path = "../../../../tests/missing.rs"]
mod missing;
mod refined;
mod stack;
