//! The configuration of a tracker as C sees it, converted to and from those of `smr-core`.

use crate::frame::same;
use crate::status::smr_status;
use crate::table::{self, smr_table};
use core::ffi::c_void;
use core::ptr;
use smr_core::paper::{self, Fraction, Gate, Margins, Radius, RunnerUp};
use smr_core::robust;
use smr_core::similarity::Backend;

/// numerator / denominator; the denominator is at least 1.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_fraction {
    /// The numerator.
    pub numerator: u16,
    /// The denominator; at least 1.
    pub denominator: u16,
}

/// The radius of the search window around the last position, in pixels: offsets -x to x and -y to y.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_radius {
    /// To the left and to the right.
    pub x: u16,
    /// Up and down.
    pub y: u16,
}

/// Distances of a box from the edges of the frame, in pixels.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
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
#[derive(Clone, Copy, Debug)]
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
#[derive(Clone, Copy, Debug)]
pub struct smr_paper_config {
    /// The similarity of two pixels by their difference; NULL for the paper's, exp(-d / 255). The table is not copied:
    /// see #smr_table_init.
    pub table: *const smr_table,
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
    /// Else than 0: a small learned network corrects the box. It is 1 by #smr_config_refined, 0 by #smr_config_robust.
    /// A library that was built without the feature `refiner` refuses it in #smr_init. It reads more of the frame: see
    /// #smr_window.
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
    /// The first two arguments point to memory of these sizes, aligned to `ALIGNMENT`. The third fulfils
    /// [`smr_config::paper`].
    pub(crate) make: unsafe fn(*mut c_void, *mut c_void, &smr_config) -> Result<(), smr_status>,
}

impl smr_config {
    /// With the built-in table, whatever the table of `config`.
    pub(crate) fn of_paper(method: *const smr_method, config: &paper::Config) -> Self {
        Self {
            method,
            plain_loop: (config.backend == Some(Backend::Scalar)).into(),
            paper: smr_paper_config {
                table: ptr::null(),
                k: config.k.into(),
                first_threshold: config.first_threshold,
                least_threshold: config.least_threshold,
                padding: config.padding,
                window: config.window.into(),
                growth: config.growth,
                window_limit: config.window_limit.into(),
                neighbourhood: config.neighbourhood,
                update_zone: config.update_zone.into(),
                gate: config.gate.into(),
                runner_up_always: (config.runner_up == RunnerUp::Always).into(),
            },
            robust: smr_robust_config::default(),
        }
    }

    pub(crate) fn of_robust(method: *const smr_method, config: &robust::Config) -> Self {
        Self {
            method,
            plain_loop: (config.backend == Some(Backend::Scalar)).into(),
            // SAFETY: numbers and a pointer, which may all be 0.
            paper: unsafe { core::mem::zeroed() },
            robust: smr_robust_config {
                reach: config.reach,
                size: config.size.into(),
                sweep: config.sweep.into(),
                refiner: config.refiner.into(),
                patience: config.patience,
                lost_below: config.lost_below,
                uncertain_below: config.uncertain_below,
                learning_rate: config.learning_rate,
                early_rate: config.early_rate,
            },
        }
    }

    fn backend(&self) -> Option<Backend> {
        (self.plain_loop != 0).then_some(Backend::Scalar)
    }

    /// The numbers of the paper's tracker.
    ///
    /// # Safety
    /// As for [`table::given`], with `self.paper.table`.
    pub(crate) unsafe fn paper(&self) -> Result<paper::Config, smr_status> {
        let numbers = &self.paper;
        let mut config = paper::Config::paper();
        // SAFETY: as the caller ensures.
        config.table = unsafe { table::given(numbers.table)? };
        config.k = numbers.k.into();
        config.first_threshold = numbers.first_threshold;
        config.least_threshold = numbers.least_threshold;
        config.padding = numbers.padding;
        config.window = numbers.window.into();
        config.growth = numbers.growth;
        config.window_limit = numbers.window_limit.into();
        config.neighbourhood = numbers.neighbourhood;
        config.update_zone = numbers.update_zone.into();
        config.gate = numbers.gate.into();
        config.backend = self.backend();
        config.runner_up = if numbers.runner_up_always == 0 { RunnerUp::WhenItDecides } else { RunnerUp::Always };
        Ok(config)
    }

    /// The numbers of the robust tracker.
    pub(crate) fn robust(&self) -> robust::Config {
        let numbers = &self.robust;
        let mut config = robust::Config::robust();
        config.reach = numbers.reach;
        config.size = numbers.size != 0;
        config.sweep = numbers.sweep != 0;
        config.refiner = numbers.refiner != 0;
        config.patience = numbers.patience;
        config.lost_below = numbers.lost_below;
        config.uncertain_below = numbers.uncertain_below;
        config.learning_rate = numbers.learning_rate;
        config.early_rate = numbers.early_rate;
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::{format, string::String};

    /// The debug output of a configuration after the table, which comes first.
    fn printed(config: impl core::fmt::Debug) -> String {
        let text = format!("{config:?}");
        text.split_once("] }").expect("the table comes first").1.into()
    }

    #[test]
    fn a_configuration_comes_back_as_it_was() {
        for config in [paper::Config::paper(), paper::Config::camera()] {
            // SAFETY: no table is given.
            let back = unsafe { smr_config::of_paper(ptr::null(), &config).paper() }.unwrap();
            assert_eq!(printed(back), printed(config));
        }
        let config = robust::Config::robust();
        assert_eq!(printed(smr_config::of_robust(ptr::null(), &config).robust()), printed(config));
        // This test alone would not notice a new number of `Config` that C cannot set. So their count is checked. Only
        // pruning and the choice between fast backends are left to the library: they change no answer.
        let numbers = printed(paper::Config::paper());
        assert_eq!(
            numbers.matches(": ").count(),
            37,
            "if Config has a new number, smr_paper_config needs it: {numbers}"
        );
        let numbers = printed(config);
        assert_eq!(
            numbers.matches(": ").count(),
            15,
            "if Config has a new number, smr_robust_config needs it: {numbers}"
        );
    }

    #[test]
    fn every_number_of_the_configuration_goes_to_its_place() {
        // Fields of a literal are evaluated as written: here in the order in which `Config` declares and prints them.
        let mut numbers = 1..;
        let next = &mut || numbers.next().unwrap();
        fn fraction(next: &mut dyn FnMut() -> u16) -> smr_fraction {
            smr_fraction { numerator: next(), denominator: next() }
        }
        fn radius(next: &mut dyn FnMut() -> u16) -> smr_radius {
            smr_radius { x: next(), y: next() }
        }
        let paper = smr_paper_config {
            table: ptr::null(),
            k: fraction(next),
            first_threshold: u8::try_from(next()).unwrap(),
            least_threshold: u8::try_from(next()).unwrap(),
            padding: next(),
            window: radius(next),
            growth: next(),
            window_limit: radius(next),
            neighbourhood: next(),
            update_zone: smr_margins { left: next(), top: next(), right: next(), bottom: next() },
            gate: smr_gate {
                tracking: fraction(next),
                leaving: fraction(next),
                returning: fraction(next),
                lost: fraction(next),
                lead: next(),
                least_ratio: next(),
            },
            runner_up_always: 1,
        };
        let config = smr_config { paper, ..smr_config::of_paper(ptr::null(), &paper::Config::paper()) };
        // SAFETY: no table is given.
        let printed = printed(unsafe { config.paper() }.unwrap());
        let words = printed.split(|character: char| !character.is_ascii_digit());
        let numbers: std::vec::Vec<u16> = words.filter_map(|word| word.parse().ok()).collect();
        assert!(printed.contains("runner_up: Always") && printed.contains("backend: None"));
        assert_eq!(numbers, (1..=25).collect::<std::vec::Vec<_>>());
    }

    #[test]
    fn every_number_of_the_robust_configuration_goes_to_its_place() {
        let all = smr_config::of_robust(ptr::null(), &robust::Config::robust());
        let robust = smr_robust_config {
            reach: 1,
            size: 0,
            sweep: 1,
            refiner: 0,
            patience: 2,
            lost_below: 3,
            uncertain_below: 4,
            learning_rate: 5,
            early_rate: 6,
        };
        let text = printed(smr_config { robust, ..all }.robust());
        let expected = "reach: 1, size: false, sweep: true, refiner: false, patience: 2, lost_below: 3, uncertain_below: 4, learning_rate: 5, \
                        early_rate: 6";
        assert!(text.contains(expected), "{text}");
        let swapped =
            smr_config { robust: smr_robust_config { size: 1, sweep: 0, refiner: 1, ..robust }, ..all }.robust();
        assert!(swapped.size && !swapped.sweep && swapped.refiner);
        let plain = smr_config { plain_loop: 1, ..all };
        assert_eq!((all.robust().backend, plain.robust().backend), (None, Some(Backend::Scalar)));
        let plain = smr_config { plain_loop: 1, ..smr_config::of_paper(ptr::null(), &paper::Config::camera()) };
        // SAFETY: no table is given.
        assert_eq!(unsafe { plain.paper() }.unwrap().backend, Some(Backend::Scalar));
    }
}
