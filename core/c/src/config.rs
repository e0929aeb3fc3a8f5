//! The configuration of a tracker as C sees it, converted to and from those of `smr-core`.

use crate::frame::same;
use crate::status::smr_status;
use core::ffi::c_void;
use smr_core::paper::{self, Fraction, Gate, Margins, Radius, RunnerUp};
use smr_core::robust;
use smr_core::similarity::Backend;

/// numerator / denominator; the denominator is at least 1.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct smr_fraction {
    /// The numerator.
    pub numerator: u16,
    /// The denominator; at least 1.
    pub denominator: u16,
}

/// The radius of the search window around the last position, in pixels: offsets -x to x and -y to y.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct smr_radius {
    /// To the left and to the right.
    pub x: u16,
    /// Up and down.
    pub y: u16,
}

/// Distances of a box from the edges of the frame, in pixels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct smr_margins {
    /// To the left edge.
    pub left: u16,
    /// To the top edge.
    pub top: u16,
    /// To the right edge.
    pub right: u16,
    /// To the bottom edge.
    pub bottom: u16,
}

/// When a peak is accepted: how far it must exceed the runner-up.
///
/// The four fractions are limits: score(peak) / score(runner-up) must be larger. With a fraction below 1, every peak
/// with a score above 0 is accepted.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct smr_gate {
    /// The limit while the target stays inside the frame.
    pub tracking: smr_fraction,
    /// The limit if the box at the peak is partly outside the frame.
    pub leaving: smr_fraction,
    /// The limit for a box inside the frame after the target has been partly outside. It applies until a lost target is
    /// found again.
    pub returning: smr_fraction,
    /// The limit for finding a lost target again.
    pub lost: smr_fraction,
    /// The alternative to all limits: a peak is also accepted if its score exceeds the runner-up's by more than this
    /// many fully similar pixels.
    pub lead: u16,
    /// The least similarity matching ratio of the peak, in units of 1/65535. Below it no peak is accepted.
    ///
    /// If it is not 0, a patch inside the frame is also checked against a covered lens: it needs a quarter of the
    /// template's contrast (mean absolute deviation), and its number of pixels at 0 or 255 must not exceed that of the
    /// template plus half of all pixels. 0, the paper's value, checks neither the ratio nor the contrast.
    pub least_ratio: u16,
}

/// The numbers of the paper's tracker.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct smr_paper_config {
    /// k in alpha = k * (largest change of a template pixel); more than 0.
    pub k: smr_fraction,
    /// alpha before the first update, in gray levels; at least 1. A pixel counts if its difference is below alpha.
    pub first_threshold: u8,
    /// The least alpha after an update, in gray levels. 0 and 1, the paper's value, mean the same. With them no pixel
    /// counts when the light changes slightly after a still scene.
    pub least_threshold: u8,
    /// Width of the virtual black border around the frame, in pixels: how far a box may leave the frame.
    pub padding: u16,
    /// The search window around the last box.
    pub window: smr_radius,
    /// By how many pixels the window grows on each side, per frame while the target is lost.
    pub growth: u16,
    /// The largest window; at least `window`. On each axis 2 * `window_limit` + 1 offsets must not exceed #SMR_SPAN,
    /// unless the padded frame is smaller than that.
    pub window_limit: smr_radius,
    /// The runner-up is the best score at more than this distance from the peak, in pixels, in x or in y.
    pub neighbourhood: u16,
    /// The box becomes the new template only if it keeps these distances from the edges of the frame.
    pub update_zone: smr_margins,
    /// When a peak is accepted.
    pub gate: smr_gate,
    /// 0: the tracker searches for the runner-up only if the gate's decision depends on it. Else: in every frame, which
    /// takes several times as long.
    pub runner_up_always: u8,
}

/// The numbers of the robust tracker.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct smr_robust_config {
    /// Radius of the search window in cells: 4 to 8. A cell is sqrt(area of the target) / 10 wide. The work of an
    /// update grows with (2 * `reach` + 1) squared.
    pub reach: u8,
    /// 0: the box keeps its size. Else: it follows the size of the target.
    pub size: u8,
    /// 0: a lost target is searched only where it was lost. Else: in the whole frame.
    pub sweep: u8,
    /// Else than 0: a small learned network corrects the box. #smr_config_refined sets it; #smr_config_robust does not.
    /// A library that was built without the feature `refiner` refuses it in #smr_init. It reads more of the frame: see
    /// #smr_windows.
    pub refiner: u8,
    /// Weight of the previous confidence in the running mean, in units of 1/256. With a higher weight the tracker holds
    /// on for longer: through short occlusions, but also to a wrong target.
    pub patience: u8,
    /// The target is lost while the confidence is below this. In units of 1/65535.
    pub lost_below: u16,
    /// The target is uncertain while the confidence is below this; at least `lost_below`.
    pub uncertain_below: u16,
    /// Learning rate of the filter, in units of 1/256: 0 (keeps the filter of the first frame) to 256 (takes the exact
    /// step for the present frame).
    pub learning_rate: u16,
    /// Learning rate of the early template, in units of 1/1024: 0 to 1024.
    pub early_rate: u16,
}

/// Which tracker, and its numbers. Fill it with #smr_config_camera, #smr_config_paper, #smr_config_robust or
/// #smr_config_refined first, then change the numbers that you need.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_config {
    /// The tracker's code. Do not change it. A program links only the trackers whose configurations it fills.
    pub method: *const smr_method,
    /// 0: the fastest code for the processor. Else: the plain loop, which loads single bytes. Frames in Device memory
    /// (external RAM that the MPU has not made Normal) need it, because unaligned loads of words fault there. The
    /// answers are the same.
    pub plain_loop: u8,
    /// Only the paper's tracker reads it. #smr_config_robust and #smr_config_refined set it to 0.
    pub paper: smr_paper_config,
    /// Only the robust tracker reads it. The other two presets set it to 0.
    pub robust: smr_robust_config,
}

/// The code of a tracker.
pub struct smr_method {
    pub(crate) target_size: usize,
    pub(crate) workspace_size: usize,
    /// Makes a tracker and its workspace. Writes nothing if it fails.
    ///
    /// # Safety
    /// The first two arguments point to memory of these sizes, aligned to `ALIGNMENT`.
    pub(crate) make: unsafe fn(*mut c_void, *mut c_void, &smr_config) -> Result<(), smr_status>,
}

impl smr_config {
    pub(crate) fn of_paper(method: *const smr_method, config: &paper::Config) -> Self {
        let plain_loop = (config.backend == Some(Backend::Scalar)).into();
        Self { method, plain_loop, paper: config.into(), robust: smr_robust_config::default() }
    }

    pub(crate) fn of_robust(method: *const smr_method, config: &robust::Config) -> Self {
        let plain_loop = (config.backend == Some(Backend::Scalar)).into();
        Self { method, plain_loop, paper: smr_paper_config::default(), robust: config.into() }
    }

    fn backend(&self) -> Option<Backend> {
        (self.plain_loop != 0).then_some(Backend::Scalar)
    }

    /// The numbers of the paper's tracker.
    pub(crate) fn paper(&self) -> paper::Config {
        let mut config = paper::Config::paper();
        self.paper.put(&mut config);
        config.backend = self.backend();
        if self.paper.runner_up_always != 0 {
            config.runner_up = RunnerUp::Always;
        }
        config
    }

    /// The numbers of the robust tracker.
    pub(crate) fn robust(&self) -> robust::Config {
        let mut config = robust::Config::robust();
        self.robust.put(&mut config);
        config.backend = self.backend();
        config
    }
}

same! {
    Fraction, smr_fraction { numerator, denominator }
    Radius, smr_radius { x, y }
    Margins, smr_margins { left, top, right, bottom }
    Gate, smr_gate { tracking, leaving, returning, lost, lead, least_ratio }
}

/// Converts between a configuration of `smr-core` and its struct in C. Numbers and then switches are listed that have the
/// same name in both. For the rest of C's fields an expression of the configuration `$of` follows; `smr_config` reads
/// those.
macro_rules! numbers {
    ($of:ident: $core:ty, $c:ident { $($number:ident),+; $($switch:ident),*; $($other:ident: $value:expr),* }) => {
        impl From<&$core> for $c {
            fn from($of: &$core) -> Self {
                Self { $($number: $of.$number.into(),)+ $($switch: $of.$switch.into(),)* $($other: $value),* }
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

numbers! { of: paper::Config, smr_paper_config {
    k, first_threshold, least_threshold, padding, window, growth, window_limit, neighbourhood, update_zone, gate;;
    runner_up_always: (of.runner_up == RunnerUp::Always).into()
}}

numbers! { of: robust::Config, smr_robust_config {
    reach, patience, lost_below, uncertain_below, learning_rate, early_rate; size, sweep, refiner;
}}

#[cfg(test)]
mod tests {
    use super::*;
    use core::ptr;

    #[test]
    fn a_configuration_comes_back_as_it_was() {
        let mut slow = paper::Config::camera();
        (slow.runner_up, slow.backend) = (RunnerUp::Always, Some(Backend::Scalar));
        for config in [paper::Config::paper(), paper::Config::camera(), slow] {
            assert_eq!(smr_config::of_paper(ptr::null(), &config).paper(), config);
        }
        let mut other = robust::Config::robust();
        (other.reach, other.size, other.sweep, other.refiner, other.patience) = (4, false, false, true, 1);
        (other.lost_below, other.uncertain_below, other.learning_rate, other.early_rate) = (2, 3, 4, 5);
        for config in [robust::Config::robust(), other] {
            assert_eq!(smr_config::of_robust(ptr::null(), &config).robust(), config);
        }
    }
}
