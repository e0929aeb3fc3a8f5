//! Tests of the C interface that need Rust, in one program.

mod errors;
mod header;
mod init;
#[path = "../../../../tests/missing.rs"]
mod missing;
