//! Tests of the C interface that need Rust.

mod errors;
mod header;
mod init;
#[path = "../../../../tests/missing.rs"]
mod missing;
