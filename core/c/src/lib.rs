//! The tracker of `smr-core` for C: what `include/smr.h` declares, and nothing else.
//!
//! Every name is the one that C sees, and the comments of public items are the header's: Doxygen's, for C readers.
//! The header is written by cbindgen; a test fails if it is not current.
//!
//! # How it links
//!
//! `libsmr.a` allocates nothing, has no globals and needs nothing of an operating system. For a microcontroller
//! (`target_os = "none"`) it is `no_std` and brings its own panic handler, which no call can reach. For a host the
//! compiler's `core` is made for unwinding, which only `std` can answer for; so there `std` is linked, for that and to ask
//! the machine which instruction sets it has, and a panic, were there one, would abort at the boundary: it never unwinds
//! into C.

#![no_std]
#![deny(missing_docs)]
#![warn(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]
// The boundary to C: pointers come in, symbols go out. All that is behind it, smr-core, is safe code.
#![allow(unsafe_code)]
// The names of the header, so that there is one word for one thing.
#![allow(non_camel_case_types)]
// What a pointer must be is said in the header's terms: under `@param`, and for all of them at its top (cbindgen.toml).
#![allow(clippy::missing_safety_doc)]

#[cfg(not(target_os = "none"))]
extern crate std;

mod capacity;
#[cfg(target_os = "none")]
mod panic;
mod pointer;
mod robust;
mod status;
mod table;
mod tracker;
mod types;

pub use capacity::{PIXELS, SPAN, STORAGE_ALIGN, STORAGE_SIZE};
pub use robust::{
    ROBUST_STORAGE_ALIGN, ROBUST_STORAGE_SIZE, smr_fine_rect, smr_robust_answer, smr_robust_config,
    smr_robust_config_default, smr_robust_early_template, smr_robust_init, smr_robust_lock, smr_robust_lock_window,
    smr_robust_state, smr_robust_tracker, smr_robust_tracker_size, smr_robust_update, smr_robust_window,
};
pub use status::{smr_status, smr_status_name};
pub use table::{smr_table, smr_table_init};
pub use tracker::{
    smr_alpha, smr_begin, smr_finish, smr_init, smr_lock, smr_step, smr_template, smr_tracker, smr_tracker_size,
    smr_update, smr_window,
};
pub use types::{
    SMR_VERSION_MAJOR, SMR_VERSION_MINOR, SMR_VERSION_PATCH, smr_answer, smr_config, smr_config_camera,
    smr_config_paper, smr_fraction, smr_frame, smr_gate, smr_image, smr_margins, smr_peak, smr_radius, smr_rect,
    smr_state, smr_version,
};
