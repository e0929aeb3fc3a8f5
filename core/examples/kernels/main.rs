//! Every kernel of the target's best backend against the plain loops, on pictures beyond whose edges there is no memory;
//! then what the kernels take, in instructions.
//!
//! ```text
//! cargo run --target thumbv7em-none-eabihf -p smr-examples --bin kernels
//! ```
//!
//! The tests of the crate run on a host, which has none of these instructions. This is for QEMU only: it relies on where
//! the emulated boards have memory.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod checks;
#[cfg(target_os = "none")]
mod figures;
#[cfg(target_os = "none")]
mod firmware;
#[cfg(target_os = "none")]
#[path = "../replay/measure.rs"]
#[allow(dead_code)] // nobody asks for the stack
mod measure;
#[cfg(target_os = "none")]
mod memory;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: cargo run --target thumbv7em-none-eabihf -p smr-examples --bin kernels");
}
