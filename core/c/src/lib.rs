//! The trackers of `smr-core` for C: what `include/smr.h` declares, and nothing else.
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

mod answer;
mod capacity;
mod config;
mod frame;
mod method;
#[cfg(target_os = "none")]
mod panic;
mod pointer;
mod status;
mod table;
mod tracker;
mod version;

pub use answer::{smr_answer, smr_state};
pub use capacity::{
    ALIGNMENT, PAPER_SAVED_SIZE, PAPER_TARGET_SIZE, PAPER_WORKSPACE_SIZE, PIXELS, ROBUST_SAVED_SIZE,
    ROBUST_TARGET_SIZE, ROBUST_WORKSPACE_SIZE, SPAN,
};
pub use config::{
    smr_config, smr_config_camera, smr_config_paper, smr_config_robust, smr_fraction, smr_gate, smr_margins,
    smr_paper_config, smr_radius, smr_robust_config,
};
pub use frame::{smr_fine_rect, smr_frame, smr_image, smr_part, smr_rect};
pub use method::smr_method;
pub use status::{STATUSES, smr_status, smr_status_name};
pub use table::{smr_table, smr_table_init};
pub use tracker::{
    smr_alpha, smr_begin, smr_begin_lock, smr_early_template, smr_finish, smr_finish_lock, smr_init, smr_last,
    smr_lock, smr_lock_window, smr_moved, smr_quality, smr_restore, smr_save, smr_saved_size, smr_step,
    smr_sweep_window, smr_target_size, smr_template, smr_tracker, smr_update, smr_window, smr_workspace_size,
};
pub use version::{SMR_VERSION_MAJOR, SMR_VERSION_MINOR, SMR_VERSION_PATCH, smr_version};
