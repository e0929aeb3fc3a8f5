//! Makes a tracker in the caller's memory, and returns the sizes of that memory.

use crate::capacity::ALIGNMENT;
use crate::config::smr_config;
use crate::pointer::{self, Out};
use crate::setting::given;
use crate::status::{
    SMR_ERROR_MISALIGNED, SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE, SMR_ERROR_STORAGE_TOO_SMALL,
    SMR_ERROR_WORKSPACE_TOO_SMALL, smr_status, status_of,
};
use crate::tracker::smr_tracker;
use core::ffi::c_void;
use core::ptr;

/// The size of a tracker's storage: #SMR_PAPER_TARGET_SIZE or #SMR_ROBUST_TARGET_SIZE of the library as it was built.
///
/// @param config  Filled by one of the calls smr_config_...
/// @return        Bytes; 0 if `config` is NULL or was not filled. Differs from the macro if this program defines other capacities
///                than those that the library was built with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_target_size(config: *const smr_config) -> usize {
    // SAFETY: as the header demands of the caller.
    unsafe { given(config) }.map_or(0, |(_, method)| method.target_size)
}

/// The size of a tracker's workspace: #SMR_PAPER_WORKSPACE_SIZE or #SMR_ROBUST_WORKSPACE_SIZE of the library as it was
/// built.
///
/// @param config  Filled by one of the calls smr_config_...
/// @return        As #smr_target_size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_workspace_size(config: *const smr_config) -> usize {
    // SAFETY: as the header demands of the caller.
    unsafe { given(config) }.map_or(0, |(_, method)| method.workspace_size)
}

/// Makes a tracker without a target.
///
/// @param storage         Memory for all that the tracker remembers, such as an #smr_paper_target or an #smr_robust_target; aligned to
///                        #SMR_ALIGNMENT. It must stay where it is, untouched, as long as the tracker is used. After that you may use
///                        it for anything.
/// @param storage_size    Bytes at `storage`; at least #smr_target_size.
/// @param workspace       Scratch memory for updates, such as an #smr_paper_workspace or an #smr_robust_workspace; aligned to
///                        #SMR_ALIGNMENT. It must stay as `storage` must, but trackers of the same kind may share it. #smr_init
///                        cancels an update that another tracker has begun in it.
/// @param workspace_size  Bytes at `workspace`; at least #smr_workspace_size.
/// @param config          Which tracker, and its numbers. It is copied.
/// @param tracker         Is set to the tracker, or to NULL after an error.
/// @return                #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_STORAGE_TOO_SMALL,
///                        #SMR_ERROR_WORKSPACE_TOO_SMALL, #SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE, #SMR_ERROR_NOT_INITIALISED (the
///                        configuration) or an error of the configuration (#SMR_ERROR_CONFIG_OUT_OF_RANGE,
///                        #SMR_ERROR_LIMIT_BELOW_WINDOW, #SMR_ERROR_UNCERTAIN_BELOW_LOST or #SMR_ERROR_REFINER_NOT_BUILT_IN).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_init(
    storage: *mut c_void,
    storage_size: usize,
    workspace: *mut c_void,
    workspace_size: usize,
    config: *const smr_config,
    tracker: *mut *mut smr_tracker,
) -> smr_status {
    // SAFETY: the caller gives memory for a pointer.
    let out = match unsafe { Out::new(tracker) } {
        Ok(out) => out,
        Err(status) => return status,
    };
    // SAFETY: as the header demands of the caller.
    let made = unsafe { init(storage, storage_size, workspace, workspace_size, config) };
    out.write(if made.is_ok() { storage.cast() } else { ptr::null_mut() });
    status_of(made)
}

/// # Safety
/// As `smr_init` demands.
unsafe fn init(
    storage: *mut c_void,
    storage_size: usize,
    workspace: *mut c_void,
    workspace_size: usize,
    config: *const smr_config,
) -> Result<(), smr_status> {
    pointer::check(storage)?;
    pointer::check(workspace)?;
    if !storage.addr().is_multiple_of(ALIGNMENT) || !workspace.addr().is_multiple_of(ALIGNMENT) {
        return Err(SMR_ERROR_MISALIGNED);
    }
    // SAFETY: as the caller ensures.
    let (config, method) = unsafe { given(config)? };
    if storage_size < method.target_size {
        return Err(SMR_ERROR_STORAGE_TOO_SMALL);
    }
    if workspace_size < method.workspace_size {
        return Err(SMR_ERROR_WORKSPACE_TOO_SMALL);
    }
    let [storage_range, workspace_range] =
        [pointer::range(storage, method.target_size), pointer::range(workspace, method.workspace_size)];
    if pointer::overlap(&storage_range, &workspace_range) {
        return Err(SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE);
    }
    // SAFETY: sizes and alignment are checked; the caller ensures the rest.
    unsafe { (method.make)(storage, workspace, config) }
}
