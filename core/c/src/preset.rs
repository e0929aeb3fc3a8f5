//! The calls that fill a configuration: the presets of both trackers.

use crate::capacity::{PaperTarget, SPAN};
use crate::config::{smr_config, smr_method};
use crate::method::method_of;
use crate::pointer;
use crate::status::{smr_status, status_of};
use smr_core::{Robust, paper, robust};

/// With windows for the capacity of this library.
const CAMERA: paper::Config = {
    #[allow(clippy::cast_possible_truncation)] // below 161
    paper::Config::camera_within(if SPAN > 160 { 80 } else { (SPAN as u16 - 1) / 2 })
};

/// Fills a configuration of the paper's tracker with values for cameras, which bound time and memory.
///
/// Differences from #smr_config_paper: the window of a lost target grows by at most 20 pixels on each side, and all
/// windows fit #SMR_SPAN; the template is updated up to the edge of the frame, a peak inside the frame need not exceed
/// the runner-up, alpha is at least 10 gray levels, and a peak with a ratio below 1/20 is not accepted.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_config_camera(config: *mut smr_config) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe { fill(config, method_of::<PaperTarget>(), |config| config.paper = (&CAMERA).into()) })
}

/// Fills a configuration of the paper's tracker with the values of the paper and of its authors' program, for frames of
/// about 320x240.
///
/// The window of a lost target grows to the padded frame, so #SMR_SPAN must be at least frame + 40 - box + 1 on each
/// axis; otherwise #smr_lock returns #SMR_ERROR_WINDOW_TOO_LARGE. For firmware use #smr_config_camera.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_config_paper(config: *mut smr_config) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        fill(config, method_of::<PaperTarget>(), |config| config.paper = (&paper::Config::paper()).into())
    })
}

/// Fills a configuration of the robust tracker. It goes beyond the paper: it follows changes of light, size and view,
/// reports when the target is not visible, and searches for it then. It takes more memory and time. The same numbers in
/// every library; #smr_config_refined has the refiner as well.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_config_robust(config: *mut smr_config) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        fill(config, method_of::<Robust>(), |config| config.robust = (&robust::Config::robust()).into())
    })
}

/// Fills a configuration as #smr_config_robust does, with the refiner: a small learned network that keeps the box to a
/// target that comes nearer, turns or changes its shape. It is the default of host-sim, of Python and of JavaScript.
///
/// Every library has this call, but #smr_init takes the configuration only in one that was built with the feature
/// `refiner` (core/c/install.sh --refiner); in others it returns #SMR_ERROR_REFINER_NOT_BUILT_IN.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_config_refined(config: *mut smr_config) -> smr_status {
    let mut refined = robust::Config::robust();
    refined.refiner = true;
    // SAFETY: as the header demands of the caller.
    status_of(unsafe { fill(config, method_of::<Robust>(), |config| config.robust = (&refined).into()) })
}

/// # Safety
/// A `config` that passes `pointer::check` points to memory for one.
unsafe fn fill(
    config: *mut smr_config,
    method: *const smr_method,
    values: impl FnOnce(&mut smr_config),
) -> Result<(), smr_status> {
    pointer::check(config)?;
    // SAFETY: neither NULL nor misaligned; there is memory, as the caller ensures.
    unsafe {
        config.write(smr_config::EMPTY);
        (*config).method = method;
        values(&mut *config);
    }
    Ok(())
}
