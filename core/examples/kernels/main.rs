//! Compares every kernel of the chip's best backend with the plain loops, on pictures at the edge of the memory. Then
//! counts the instructions of the kernels.
//!
//! ```text
//! cargo run --target thumbv7em-none-eabihf -p smr-examples --bin kernels
//! ```
//!
//! The tests of the crate cannot do this, because they run on a host, which lacks these instructions. It runs in QEMU
//! only, because it depends on the memory maps of the emulated boards.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "../alignment.rs"]
mod alignment;
#[cfg(target_os = "none")]
mod checks;
#[cfg(target_os = "none")]
mod figures;
#[cfg(target_os = "none")]
mod firmware;
#[cfg(target_os = "none")]
#[path = "../replay/measure.rs"]
#[allow(dead_code)] // this firmware does not measure the stack
mod measure;
#[cfg(target_os = "none")]
mod memory;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: cargo run --target thumbv7em-none-eabihf -p smr-examples --bin kernels");
}
