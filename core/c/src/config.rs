//! The configuration structs of C, and their conversion to and from those of `smr-core`.

use crate::frame::same;
use crate::status::smr_status;
use core::ffi::c_void;
use smr_core::paper::{self, Fraction, Margins, Radius};
use smr_core::robust;
use smr_core::similarity::Backend;

/// A fraction: numerator / denominator.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct smr_fraction {
    /// Numerator; its range depends on the setting.
    pub numerator: u16,
    /// Denominator; at least 1.
    pub denominator: u16,
}

/// A search radius in pixels: offsets of -x to x and -y to y around the last position.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct smr_radius {
    /// The largest offset to the left and to the right.
    pub x: u16,
    /// The largest offset up and down.
    pub y: u16,
}

/// Distances of a box from the four edges of the frame, in pixels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct smr_margins {
    /// Pixels from the frame's left edge to the box.
    pub left: u16,
    /// Pixels from the frame's top edge to the box.
    pub top: u16,
    /// Pixels from the box to the frame's right edge.
    pub right: u16,
    /// Pixels from the box to the frame's bottom edge.
    pub bottom: u16,
}

/// The settings of the paper tracker.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
#[allow(missing_docs)] // the header has their texts from `Settings::TEXTS`
pub struct smr_paper_config {
    pub k: smr_fraction,
    pub gate_tracking: smr_fraction,
    pub gate_leaving: smr_fraction,
    pub gate_returning: smr_fraction,
    pub gate_lost: smr_fraction,
    pub gate_lead: u16,
    pub least_ratio: u16,
    pub first_threshold: u8,
    pub least_threshold: u8,
    pub padding: u16,
    pub window: smr_radius,
    pub growth: u16,
    pub window_limit: smr_radius,
    pub neighbourhood: u16,
    pub update_zone: smr_margins,
    pub runner_up_always: u8,
}

/// The settings of the robust tracker.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
#[allow(missing_docs)] // as above
pub struct smr_robust_config {
    pub reach: u8,
    pub size: u8,
    pub sweep: u8,
    pub refiner: u8,
    pub patience: u8,
    pub lost_below: u16,
    pub uncertain_below: u16,
    pub learning_rate: u16,
    pub early_rate: u16,
}

/// The choice of a tracker and its settings. Fill it with #smr_config_camera, #smr_config_paper, #smr_config_robust,
/// #smr_config_refined, #smr_config_small or #smr_config_small_refined, then change the settings that you need.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_config {
    /// Points to the chosen tracker's code; do not change it. A program contains the code of a tracker only if it calls
    /// one of the functions smr_config_... for that tracker.
    pub method: *const smr_method,
    /// 0: the tracker uses the fastest code for the processor. Otherwise: it uses plain loops that load single bytes,
    /// and gives the same answers. This is for frames in Device memory (external RAM that the MPU has not made Normal),
    /// where unaligned word loads fault.
    pub plain_loop: u8,
    /// Settings of the paper tracker; all 0 if the preset is of the robust one.
    pub paper: smr_paper_config,
    /// Settings of the robust tracker; all 0 if the preset is of the paper's.
    pub robust: smr_robust_config,
}

/// One of the trackers, opaque in C: its constructor and the sizes of its memory.
pub struct smr_method {
    /// The preset of the robust tracker, with the largest `reach` of its size; `None` for the paper's.
    pub(crate) robust: Option<robust::Config>,
    pub(crate) target_size: usize,
    pub(crate) workspace_size: usize,
    /// Constructs a tracker and its workspace. Writes nothing if it fails.
    ///
    /// # Safety
    /// The first two arguments point to `target_size` and `workspace_size` bytes that can be written, aligned to
    /// `ALIGNMENT`. As long as the tracker is used, only its calls use the former, and only calls on trackers that share
    /// it the latter.
    pub(crate) make: unsafe fn(*mut c_void, *mut c_void, &smr_config) -> Result<(), smr_status>,
}

impl smr_config {
    // SAFETY: every field is a pointer or a number, for which zeroes are a value.
    pub(crate) const EMPTY: Self = unsafe { core::mem::zeroed() };

    fn backend(&self) -> Option<Backend> {
        (self.plain_loop != 0).then_some(Backend::Scalar)
    }

    pub(crate) fn paper(&self) -> paper::Config {
        let mut config = paper::Config::paper();
        self.paper.put(&mut config);
        config.backend = self.backend();
        config
    }

    /// The configuration of a robust tracker that has this `preset`.
    pub(crate) fn robust(&self, preset: &robust::Config) -> robust::Config {
        let mut config = *preset;
        self.robust.put(&mut config);
        config.backend = self.backend();
        config
    }
}

same! {
    Fraction, smr_fraction { numerator, denominator }
    Radius, smr_radius { x, y }
    Margins, smr_margins { left, top, right, bottom }
}

/// Converts between a configuration of `smr-core` and its struct in C. The fields after the semicolon are booleans.
macro_rules! convert_config {
    ($core:ty, $c:ident { $($number:ident),+; $($switch:ident),* }) => {
        impl From<&$core> for $c {
            fn from(of: &$core) -> Self {
                Self { $($number: of.$number.into(),)+ $($switch: of.$switch.into()),* }
            }
        }

        impl $c {
            fn put(&self, config: &mut $core) {
                $(config.$number = self.$number.into();)+
                $(config.$switch = self.$switch != 0;)*
            }
        }
    };
}

convert_config! { paper::Config, smr_paper_config {
    k, gate_tracking, gate_leaving, gate_returning, gate_lost, gate_lead, least_ratio, first_threshold,
    least_threshold, padding, window, growth, window_limit, neighbourhood, update_zone; runner_up_always
}}

convert_config! { robust::Config, smr_robust_config {
    reach, patience, lost_below, uncertain_below, learning_rate, early_rate, sweep; size, refiner
}}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_configuration_comes_back_as_it_was() {
        let mut slow = paper::Config::camera();
        (slow.runner_up_always, slow.backend) = (true, Some(Backend::Scalar));
        for config in [paper::Config::paper(), paper::Config::camera(), slow] {
            assert_eq!(
                smr_config {
                    plain_loop: (config.backend.is_some()).into(),
                    paper: (&config).into(),
                    ..smr_config::EMPTY
                }
                .paper(),
                config
            );
        }
        let mut other = robust::Config::robust();
        (other.reach, other.size, other.sweep, other.refiner, other.patience) = (4, false, 2, true, 1);
        (other.lost_below, other.uncertain_below, other.learning_rate, other.early_rate) = (2, 3, 4, 5);
        for config in [robust::Config::robust(), other] {
            assert_eq!(
                smr_config { robust: (&config).into(), ..smr_config::EMPTY }.robust(&robust::Config::robust()),
                config
            );
        }
    }
}
