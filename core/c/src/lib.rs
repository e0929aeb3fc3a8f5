//! The trackers of `smr-core` for C: exactly what `include/smr.h` declares.
//!
//! Public items have their names in C. Their doc comments become the header's comments, so they are written for C
//! readers, in Doxygen's syntax. cbindgen writes the header; a test fails if the file is not current.
//!
//! # Modules
//!
//! A module imports only modules that come before it in this table.
//!
//! | module | contents |
//! |---|---|
//! | `capacity` | the largest box and window, and the sizes of memory |
//! | `status` | every status with its number, name and text; the library's version |
//! | `pointer` | the checks of every pointer |
//! | `frame`, `answer` | the inputs and the result of an update |
//! | `config` | the configuration structs of C, converted to and from those of `smr-core` |
//! | `tracker` | the handle `smr_tracker`, and the access to the tracker behind it |
//! | `method` | both trackers in the caller's memory |
//! | `setting`, `follow`, `target`, `readout`, `record`, `entry` | the exported calls |
//! | `unstable` | calls for the browser's page, which the header does not declare (feature `unstable`) |
//!
//! # Linking
//!
//! `libsmr.a` does not allocate, has no globals and needs no operating system. For a microcontroller (`target_os =
//! "none"`) and as WebAssembly it is `no_std` and contains its own panic handler, which no call can reach.
//!
//! For a host, Rust's `core` is compiled for unwinding, whose runtime is in `std`. The library therefore links `std`
//! there, and also detects the processor's instruction sets with it. A panic would abort: it never unwinds into C.

#![no_std]
#![deny(missing_docs)]
#![warn(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]
// This crate is the boundary to C: it dereferences C's pointers and exports symbols.
#![allow(unsafe_code)]
// Types have C names, such as `smr_rect`.
#![allow(non_camel_case_types)]
// The header states the requirements on pointers under `@param`, and in its first comment, written in cbindgen.toml.
#![allow(clippy::missing_safety_doc)]

#[cfg(not(any(target_os = "none", target_family = "wasm")))]
extern crate std;

mod answer;
mod capacity;
mod config;
mod frame;
mod method;
mod pointer;
mod status;
mod tracker;

// The exported calls, in the order of the header.
mod setting;

mod follow;

mod target;

mod readout;

mod record;

// Not in WebAssembly: JavaScript reads no flight records, and modules would contain `smr_next_entry` even if unused.
#[cfg(not(target_family = "wasm"))]
mod entry;

#[cfg(feature = "unstable")]
mod unstable;

pub use answer::*;
pub use capacity::*;
pub use config::*;
#[cfg(not(target_family = "wasm"))]
pub use entry::*;
pub use follow::*;
pub use frame::*;
pub use readout::*;
pub use record::*;
pub use setting::*;
pub use status::*;
pub use target::*;
pub use tracker::*;

/// The panic handler that the linker requires. No call reaches it: `.ci/c` fails if it is in a linked program.
#[cfg(any(target_os = "none", target_family = "wasm"))]
#[panic_handler]
fn stop(_: &core::panic::PanicInfo<'_>) -> ! {
    #[cfg(target_family = "wasm")]
    core::arch::wasm32::unreachable();
    #[cfg(not(target_family = "wasm"))]
    loop {
        core::hint::spin_loop();
    }
}
