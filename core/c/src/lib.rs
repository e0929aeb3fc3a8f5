//! The trackers of `smr-core` for C: exactly what `include/smr.h` declares.
//!
//! Every public item has the name that C sees. The doc comments of public items become the header's comments, so they
//! are written for C readers, in Doxygen's syntax. cbindgen writes the header; a test fails if the file is not current.
//!
//! # Modules
//!
//! A module imports only modules that come before it in this table.
//!
//! | module | what it holds |
//! |---|---|
//! | `version` | the version of the library |
//! | `capacity` | how much a tracker holds, fixed at build time |
//! | `status` | all statuses: number, name, text |
//! | `pointer` | the checks of every pointer |
//! | `frame`, `answer`, `table` | the inputs and the result of an update |
//! | `config` | a configuration as C sees it, converted to and from those of `smr-core` |
//! | `tracker` | `smr_tracker`, and how a call finds the tracker behind a pointer |
//! | `method` | both trackers in the caller's memory |
//! | `preset`, `init`, `lock`, `update`, `inspect`, `saved`, `readout` | the exported calls |
//! | `unstable` | calls for the browser's page, which the header does not declare (feature `unstable`) |
//!
//! # Linking
//!
//! `libsmr.a` does not allocate, has no globals and needs no operating system. For a microcontroller (`target_os =
//! "none"`) and as WebAssembly it is `no_std` and contains its own panic handler, which no call can reach.
//!
//! For a host, Rust's `core` is compiled for unwinding, which needs the runtime in `std`. The library therefore links
//! `std` there, and also uses it to detect the processor's instruction sets. A panic would abort at the boundary; it
//! never unwinds into C.

#![no_std]
#![deny(missing_docs)]
#![warn(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]
// This crate is the boundary to C: it dereferences C's pointers and exports symbols.
#![allow(unsafe_code)]
// Items have the names of the header.
#![allow(non_camel_case_types)]
// The header says what a pointer must be: each call under `@param`, all calls at its top (cbindgen.toml).
#![allow(clippy::missing_safety_doc)]

#[cfg(not(any(target_os = "none", target_family = "wasm")))]
extern crate std;

mod answer;
mod capacity;
mod config;
mod frame;
mod method;
#[cfg(any(target_os = "none", target_family = "wasm"))]
mod panic;
mod pointer;
mod status;
mod table;
mod tracker;
mod version;

// The exported calls, in the order of the header.
mod preset;

mod init;

mod lock;

mod update;

mod inspect;

mod saved;

mod readout;

#[cfg(feature = "unstable")]
mod unstable;

pub use answer::{smr_answer, smr_state};
pub use capacity::{
    ALIGNMENT, PAPER_SAVED_SIZE, PAPER_TARGET_SIZE, PAPER_WORKSPACE_SIZE, PIXELS, ROBUST_SAVED_SIZE,
    ROBUST_TARGET_SIZE, ROBUST_WORKSPACE_SIZE, SPAN,
};
pub use config::{
    smr_config, smr_fraction, smr_gate, smr_margins, smr_method, smr_paper_config, smr_radius, smr_robust_config,
};
pub use frame::{smr_fine_rect, smr_frame, smr_image, smr_part, smr_rect};
pub use init::{smr_init, smr_target_size, smr_workspace_size};
pub use inspect::{smr_alpha, smr_early_template, smr_last, smr_quality, smr_template};
pub use lock::{smr_begin_lock, smr_finish_lock, smr_lock, smr_lock_window};
pub use preset::{smr_config_camera, smr_config_paper, smr_config_refined, smr_config_robust};
pub use readout::{
    smr_format, smr_readout, smr_readout_add_window, smr_readout_begin, smr_readout_frame, smr_readout_line,
    smr_readout_lines,
};
pub use saved::{
    smr_newest_copy, smr_other_setting, smr_restore, smr_save, smr_save_copy, smr_saved_copy, smr_saved_size,
};
pub use status::{STATUSES, smr_status, smr_status_name};
pub use table::{smr_table, smr_table_init};
pub use tracker::smr_tracker;
pub use update::{smr_begin, smr_finish, smr_moved, smr_step, smr_sweep_window, smr_update, smr_window};
pub use version::{SMR_VERSION_MAJOR, SMR_VERSION_MINOR, SMR_VERSION_PATCH, smr_version};
