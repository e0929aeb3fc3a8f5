//! The calls that fill a configuration: the presets of both trackers, and settings by name.

use crate::capacity::{PaperTarget, SPAN};
use crate::config::{smr_config, smr_method};
use crate::method::{SizeInC, method_of};
use crate::pointer::{self, Out};
use crate::status::{
    SMR_ERROR_NOT_INITIALISED, SMR_ERROR_SETTING_COUNT, SMR_ERROR_SETTING_UNKNOWN, smr_status, status_of,
};
use core::ffi::{CStr, c_char};
use smr_core::robust::{Small, Standard};
use smr_core::{ConfigError, Robust, Settings, paper, robust};

/// The preset for cameras, with windows that fit the capacity of this library.
const CAMERA: paper::Config = {
    #[allow(clippy::cast_possible_truncation)] // below 161
    paper::Config::camera_within(if SPAN > 160 { 80 } else { (SPAN as u16 - 1) / 2 })
};

/// Fills a configuration of the paper tracker with values for cameras. They limit the tracker's time and memory.
///
/// Unlike with #smr_config_paper, the window of a lost target grows by at most 20 pixels on each side, and all windows
/// fit #SMR_SPAN; the template is updated up to the edge of the frame, a peak inside the frame need not exceed the
/// runner-up, alpha is at least 10 gray levels, and a peak with a ratio below 1/20 is rejected.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_config_camera(config: *mut smr_config) -> smr_status {
    // SAFETY: by the header, `config` points to memory for an `smr_config`, if it passes `pointer::check`.
    status_of(unsafe { fill(config, method_of::<PaperTarget>(), |config| config.paper = (&CAMERA).into()) })
}

/// Fills a configuration of the paper tracker with the values of the authors' program, for frames of about 320x240.
///
/// The window of a lost target grows to the padded frame, so #SMR_SPAN must be at least frame + 40 - box + 1 on each
/// axis; otherwise #smr_lock returns #SMR_ERROR_WINDOW_TOO_LARGE. For firmware use #smr_config_camera.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_config_paper(config: *mut smr_config) -> smr_status {
    // SAFETY: by the header, `config` points to memory for an `smr_config`, if it passes `pointer::check`.
    status_of(unsafe {
        fill(config, method_of::<PaperTarget>(), |config| config.paper = (&paper::Config::paper()).into())
    })
}

/// Fills a configuration of the robust tracker without the refiner. It follows changes of light, size and view, reports
/// when the target is not visible, and then searches for it. It takes more memory and time than the paper tracker.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_config_robust(config: *mut smr_config) -> smr_status {
    // SAFETY: by the header, `config` points to memory for an `smr_config`, if it passes `pointer::check`.
    status_of(unsafe { fill_robust::<Standard>(config, false) })
}

/// Fills a configuration of the robust tracker with the refiner: a small learned network that fits the box to a target
/// that approaches, turns or changes its shape. This preset is the default of host-sim, Python and JavaScript.
///
/// #smr_init accepts it only in a library with the feature `refiner` (core/c/install.sh --refiner), and else returns
/// #SMR_ERROR_REFINER_NOT_BUILT_IN.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_config_refined(config: *mut smr_config) -> smr_status {
    // SAFETY: by the header, `config` points to memory for an `smr_config`, if it passes `pointer::check`.
    status_of(unsafe { fill_robust::<Standard>(config, true) })
}

/// Fills a configuration of the small robust tracker without the refiner. It takes 7 KB less memory than that of
/// #smr_config_robust and a fifth less time, and follows equally well on 90 recordings: its template has at most
/// #SMR_ROBUST_SMALL_PIXELS pixels, and its `reach` is at most 7. Its memory are #smr_robust_small_target and
/// #smr_robust_small_workspace. Saved targets and flight records of one size cannot be continued with the other.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_config_small(config: *mut smr_config) -> smr_status {
    // SAFETY: by the header, `config` points to memory for an `smr_config`, if it passes `pointer::check`.
    status_of(unsafe { fill_robust::<Small>(config, false) })
}

/// Fills a configuration of the small robust tracker with the refiner: see #smr_config_small and #smr_config_refined.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_config_small_refined(config: *mut smr_config) -> smr_status {
    // SAFETY: by the header, `config` points to memory for an `smr_config`, if it passes `pointer::check`.
    status_of(unsafe { fill_robust::<Small>(config, true) })
}

/// # Safety
/// As for [`fill`].
unsafe fn fill_robust<S: SizeInC>(config: *mut smr_config, refiner: bool) -> Result<(), smr_status> {
    let mut preset = S::PRESET;
    preset.refiner = refiner;
    // SAFETY: a `config` that passes `pointer::check` points to memory for an `smr_config`.
    unsafe { fill(config, method_of::<Robust<S>>(), |config| config.robust = (&preset).into()) }
}

/// # Safety
/// A `config` that passes `pointer::check` points to memory for an `smr_config`.
unsafe fn fill(
    config: *mut smr_config,
    method: *const smr_method,
    values: impl FnOnce(&mut smr_config),
) -> Result<(), smr_status> {
    pointer::check(config)?;
    // SAFETY: `config` passed `pointer::check`, so there is memory for an `smr_config`, aligned.
    unsafe {
        config.write(smr_config::EMPTY);
        (*config).method = method;
        values(&mut *config);
    }
    Ok(())
}

/// The name, range and values of a setting, as #smr_setting_at returns them.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_setting {
    /// The name as a static string: that of the field in #smr_paper_config or #smr_robust_config.
    pub name: *const c_char,
    /// The kind of values. 0: a number. 1: a switch. 2: numerator, denominator. 3: x, y. 4: left, top, right, bottom.
    pub shape: u8,
    /// The number of values, 1 to 4.
    pub count: u8,
    /// The lowest value that the setting may have; a denominator must also be at least 1.
    pub lowest: u16,
    /// The highest value that the setting may have.
    pub highest: u16,
    /// The values in the configuration; unused entries are 0.
    pub values: [u16; 4],
}

/// Sets a setting by its name, such as "window" to { 16, 16 }, for names from a file, a console or another language. If
/// the name is known when you compile, set the field of the configuration instead.
///
/// @param config  Filled by one of the calls smr_config_...
/// @param name    The name of a field of #smr_paper_config or #smr_robust_config, whichever the configuration is for.
/// @param values  The values, in the order of the field.
/// @param count   The number of values.
/// @return        #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED (the configuration),
///                #SMR_ERROR_SETTING_UNKNOWN, #SMR_ERROR_SETTING_COUNT or #SMR_ERROR_CONFIG_OUT_OF_RANGE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_set(
    config: *mut smr_config,
    name: *const c_char,
    values: *const u16,
    count: usize,
) -> smr_status {
    // SAFETY: by the header, `config` is an `smr_config` with a preset's method or none, `name` a string, and `values`
    // has `count` numbers.
    status_of(unsafe {
        deref(config).and_then(|(now, method)| {
            pointer::check(name)?;
            pointer::check(values)?;
            if count > 4 {
                return Err(SMR_ERROR_SETTING_COUNT);
            }
            let (name, values) = (CStr::from_ptr(name), core::slice::from_raw_parts(values, count));
            let mut changed = *now;
            match &method.robust {
                None => changed.paper = (&with(now.paper(), name, values)?).into(),
                Some(preset) => changed.robust = (&with(now.robust(preset), name, values)?).into(),
            }
            config.write(changed);
            Ok(())
        })
    })
}

/// Returns the name, range and values of the setting at an index; #SMR_ERROR_SETTING_UNKNOWN after the last one.
///
/// @param config   Filled by one of the calls smr_config_...
/// @param index    Index of the setting, from 0.
/// @param setting  Is set; unchanged after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED (the configuration) or
///                 #SMR_ERROR_SETTING_UNKNOWN.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_setting_at(
    config: *const smr_config,
    index: usize,
    setting: *mut smr_setting,
) -> smr_status {
    // SAFETY: by the header, `config` is an `smr_config` with a preset's method or none, and `setting` points to memory
    // for a setting.
    status_of(unsafe {
        deref(config).and_then(|(config, method)| {
            let out = Out::new(setting)?;
            out.write(match &method.robust {
                None => at(&config.paper(), index)?,
                Some(preset) => at(&config.robust(preset), index)?,
            });
            Ok(())
        })
    })
}

fn with<C: Settings>(mut config: C, name: &CStr, values: &[u16]) -> Result<C, ConfigError> {
    let name = name.to_bytes_with_nul();
    let setting = C::SETTINGS.iter().find(|setting| setting.name_with_zero().as_bytes() == name);
    config.set(setting.ok_or(ConfigError::UnknownSetting)?.name(), values)?;
    Ok(config)
}

fn at<C: Settings>(config: &C, index: usize) -> Result<smr_setting, smr_status> {
    let setting = config.settings().nth(index).ok_or(SMR_ERROR_SETTING_UNKNOWN)?;
    Ok(smr_setting {
        name: setting.name_with_zero().as_ptr().cast(),
        shape: setting.shape as u8,
        count: setting.shape.count().to_le_bytes()[0],
        lowest: setting.lowest,
        highest: setting.highest,
        values: config.get(setting.name()).unwrap_or_default(),
    })
}

/// Converts a setting's name from an error of `smr-core` to a string of C.
pub(crate) fn name_in_c(name: &str) -> *const c_char {
    let mut settings = paper::Config::SETTINGS.iter().chain(robust::Config::SETTINGS);
    let known = settings.find(|setting| setting.name() == name).map(|setting| setting.name_with_zero());
    known.map_or(if name == "table" { c"table".as_ptr() } else { c"parts".as_ptr() }, |name| name.as_ptr().cast())
}

/// # Safety
/// A `config` that passes `pointer::check` points to one that outlives the result. Its method is NULL or from a preset.
pub(crate) unsafe fn deref<'a>(config: *const smr_config) -> Result<(&'a smr_config, &'static smr_method), smr_status> {
    pointer::check(config)?;
    // SAFETY: `config` passed `pointer::check`, so it points to an `smr_config` that outlives the result.
    let config = unsafe { &*config };
    let method = config.method;
    // SAFETY: the method is NULL or from a preset, and presets fill in the address of a constant.
    unsafe { method.as_ref() }.map(|method| (config, method)).ok_or(SMR_ERROR_NOT_INITIALISED)
}
