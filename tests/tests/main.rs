//! Tests across the crates, in one program, so that they run in parallel.

mod chips;
mod conformance;
mod documents;
mod languages;
#[path = "../markdown.rs"]
mod markdown;
#[path = "../missing.rs"]
mod missing;
mod module_order;
mod paper_rows;
mod pursuit;
mod readout;
mod versions;
