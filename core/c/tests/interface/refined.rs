//! The presets `robust` and `refined`: in a library with the refiner and in one without it. Both builds run this test.

#![allow(unsafe_code)] // calls the C interface

use crate::stack::Storage;
use smr::{
    ROBUST_TARGET_SIZE, ROBUST_WORKSPACE_SIZE, smr_config, smr_config_refined, smr_config_robust, smr_init, smr_status,
};
use std::mem::MaybeUninit;
use std::ptr;

/// A filled configuration.
fn filled(fill: unsafe extern "C" fn(*mut smr_config) -> smr_status) -> smr_config {
    let mut config = MaybeUninit::uninit();
    // SAFETY: there is memory for the configuration, and it is written before it is read.
    unsafe {
        assert_eq!(fill(config.as_mut_ptr()), smr_status::SMR_OK);
        config.assume_init()
    }
}

fn init(config: &smr_config) -> smr_status {
    let mut storage = Box::new(Storage([0; ROBUST_TARGET_SIZE]));
    let mut workspace = Box::new(Storage([0; ROBUST_WORKSPACE_SIZE]));
    let (storage, workspace) = (storage.0.as_mut_ptr().cast(), workspace.0.as_mut_ptr().cast());
    let mut tracker = ptr::null_mut();
    // SAFETY: only this call uses the memory.
    unsafe { smr_init(storage, ROBUST_TARGET_SIZE, workspace, ROBUST_WORKSPACE_SIZE, config, &raw mut tracker) }
}

#[test]
fn the_presets_differ_in_the_refiner_alone() {
    let (robust, mut refined) = (filled(smr_config_robust), filled(smr_config_refined));
    assert_eq!((robust.robust.refiner, refined.robust.refiner), (0, 1));
    refined.robust.refiner = 0;
    assert_eq!(format!("{robust:?}"), format!("{refined:?}"));
}

#[test]
fn a_library_without_the_refiner_says_so() {
    assert_eq!(init(&filled(smr_config_robust)), smr_status::SMR_OK);
    // Another package in the same build may have switched the feature of smr-core on.
    let mut config = smr_core::robust::Config::robust();
    config.refiner = true;
    let expected = match config.check() {
        Ok(()) => smr_status::SMR_OK,
        Err(_) => smr_status::SMR_ERROR_REFINER_NOT_BUILT_IN,
    };
    assert_eq!(init(&filled(smr_config_refined)), expected);
}
