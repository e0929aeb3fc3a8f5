//! What a tracker is made with: which method, and its numbers.

use crate::capacity::PaperTarget;
use crate::frame::same;
use crate::method::smr_method;
use crate::pointer::Out;
use crate::status::{smr_status, status_of};
use crate::table::{self, smr_table};
use core::ptr;
use smr_core::paper::{self, Fraction, Gate, Margins, Radius, RunnerUp};
use smr_core::similarity::Backend;
use smr_core::{Robust, robust};

/// numerator / denominator; the denominator is at least 1.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_fraction {
    /// What stands above the line.
    pub numerator: u16,
    /// What stands below the line; at least 1.
    pub denominator: u16,
}

/// How far the search window reaches to each side of the last position, in pixels: offsets -x..x and -y..y.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_radius {
    /// To the left and to the right.
    pub x: u16,
    /// Up and down.
    pub y: u16,
}

/// How many pixels a box keeps from each edge of the picture.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_margins {
    /// Columns to the left of the box.
    pub left: u16,
    /// Rows above it.
    pub top: u16,
    /// Columns to the right of it.
    pub right: u16,
    /// Rows below it.
    pub bottom: u16,
}

/// How clearly the peak must stand above the runner-up before a frame is believed.
///
/// The first four are ratios of the two scores that the peak must exceed. A ratio below 1 demands nothing of a peak that
/// scores at all.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_gate {
    /// While the target stays inside the picture.
    pub tracking: smr_fraction,
    /// When the box at the peak is partly outside the picture.
    pub leaving: smr_fraction,
    /// When the box at the peak is inside, but one has not been before: until a lost target is found again.
    pub returning: smr_fraction,
    /// To be found again when lost, wherever that is.
    pub lost: smr_fraction,
    /// The other way to be believed, in every state: the peak is more than this many fully similar pixels above the
    /// runner-up.
    pub lead: u16,
    /// The least similarity matching ratio of the peak, in units of 1/65535; below it no frame is believed. Where it is not 0, a box inside
    /// the frame must also show a quarter of the template's contrast (mean absolute deviation), and no more pixels cut off at 0 or 255 than
    /// the template has and half of all: what a covered lens shows is no target. 0 demands nothing, neither of the ratio nor of the contrast,
    /// which is the paper's.
    pub least_ratio: u16,
}

/// The numbers of the paper's tracker.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_paper_config {
    /// The similarity of two pixels by their difference, or NULL for the paper's, exp(-d / 255). A table given here is
    /// not copied: see #smr_table_init.
    pub table: *const smr_table,
    /// k in alpha = k * (largest change of a pixel of the template); more than 0.
    pub k: smr_fraction,
    /// alpha before the first update, in gray levels: a pixel counts if its difference is below it. At least 1.
    pub first_threshold: u8,
    /// The least alpha after an update, in gray levels. 0 and 1 are the same, and the paper's: after a still scene a slight
    /// change of light then leaves no pixel that counts.
    pub least_threshold: u8,
    /// Width of the virtual border of zeroes around the frame, in pixels: how far a box may leave the picture.
    pub padding: u16,
    /// The search window around the last position.
    pub window: smr_radius,
    /// How many pixels the window grows on each side, for each frame that the target stays lost.
    pub growth: u16,
    /// Where that growth ends; at least `window`. On each axis 2 * limit + 1 offsets must fit #SMR_SPAN, unless the
    /// padded frame is smaller than that.
    pub window_limit: smr_radius,
    /// The runner-up is the best score more than this many pixels away from the peak, in x or in y.
    pub neighbourhood: u16,
    /// What a box keeps from the edges of the picture for its patch to become the template.
    pub update_zone: smr_margins,
    /// When a frame is believed.
    pub gate: smr_gate,
    /// 0: the runner-up is looked for when the gate's decision depends on it. Else: in every frame, which multiplies the
    /// time.
    pub runner_up_always: u8,
}

/// The numbers of the robust tracker.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct smr_robust_config {
    /// How far the target is looked for to each side, in cells: 4 to 8. A cell is a tenth of the root of the target's area. The
    /// work of an update grows with the square of 2 `reach` + 1.
    pub reach: u8,
    /// 0 if the box keeps its size; else it follows the target's.
    pub size: u8,
    /// 0 if a lost target is looked for only where it was lost; else all over the frame.
    pub sweep: u8,
    /// How slowly the confidence follows what speaks for the target: it keeps so many 256ths of itself in each frame. More
    /// holds on for longer, through short occlusions and through errors alike.
    pub patience: u8,
    /// The target is lost while the confidence is below this, in units of 1/65535.
    pub lost_below: u16,
    /// It is uncertain while the confidence is below this; at least `lost_below`.
    pub uncertain_below: u16,
    /// How far the filter goes towards what is best for the present frame, in units of 1/256: 0 to 256. 0 keeps what was learned
    /// in the first frame.
    pub learning_rate: u16,
    /// How far the early template goes towards the present frame, in units of 1/1024: 0 to 1024.
    pub early_rate: u16,
}

/// Which tracker, and its numbers. Fill it with #smr_config_camera, #smr_config_paper or #smr_config_robust first, then change
/// what is to be changed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_config {
    /// The tracker's code: leave it as it was filled in. A program links only the trackers whose configurations it fills.
    pub method: *const smr_method,
    /// 0: the fastest way that the processor has. Else: the plain loop, which loads single bytes; a frame in Device memory
    /// (external RAM before the MPU makes it Normal) needs it, as unaligned loads of words fault there. It changes no answer.
    pub plain_loop: u8,
    /// Read by the paper's tracker alone, and 0 from #smr_config_robust.
    pub paper: smr_paper_config,
    /// Read by the robust tracker alone, and 0 from the other two.
    pub robust: smr_robust_config,
}

/// Fills a configuration of the paper's tracker with the values for cameras: the paper's with a bounded window, so that time and
/// memory are, too.
///
/// Beside #smr_config_paper the window of a lost target grows by at most 20 pixels on each side (an #SMR_SPAN of 161 holds
/// it), the template is updated up to the edge of the picture, a peak inside the picture need not exceed the runner-up, alpha
/// is at least 10 gray levels, and a peak of less than a twentieth of what is possible is not believed.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_config_camera(config: *mut smr_config) -> smr_status {
    // SAFETY: as the header asks of the caller.
    status_of(unsafe { fill(config, || smr_config::of_paper(&paper::Config::camera())) })
}

/// Fills a configuration of the paper's tracker with the values of the paper and its authors' program, for frames of about
/// 320x240.
///
/// The window of a lost target grows until it is the padded frame: #SMR_SPAN must be at least frame + 40 - box + 1 on each
/// axis, or #smr_lock answers #SMR_ERROR_WINDOW_TOO_LARGE. For firmware see #smr_config_camera.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_config_paper(config: *mut smr_config) -> smr_status {
    // SAFETY: as the header asks of the caller.
    status_of(unsafe { fill(config, || smr_config::of_paper(&paper::Config::paper())) })
}

/// Fills a configuration of the robust tracker. It goes beyond the paper: it holds when light, size and view change, says when
/// the target is not seen, and looks for it then; it takes more memory and time.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_config_robust(config: *mut smr_config) -> smr_status {
    // SAFETY: as the header asks of the caller.
    status_of(unsafe { fill(config, || smr_config::of_robust(&robust::Config::robust())) })
}

/// # Safety
/// A `config` that passes `pointer::check` points to memory for one.
unsafe fn fill(config: *mut smr_config, values: impl FnOnce() -> smr_config) -> Result<(), smr_status> {
    // SAFETY: as the caller says.
    unsafe { Out::new(config)? }.write(values());
    Ok(())
}

impl smr_config {
    /// With the library's own table: another one has no address that C could give.
    fn of_paper(config: &paper::Config) -> Self {
        Self {
            method: smr_method::of::<PaperTarget>(),
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

    fn of_robust(config: &robust::Config) -> Self {
        Self {
            method: smr_method::of::<Robust>(),
            plain_loop: (config.backend == Some(Backend::Scalar)).into(),
            // SAFETY: numbers and a pointer, all of which may be 0.
            paper: unsafe { core::mem::zeroed() },
            robust: smr_robust_config {
                reach: config.reach,
                size: config.size.into(),
                sweep: config.sweep.into(),
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

    /// # Safety
    /// As for [`table::given`], of `self.paper.table`.
    pub(crate) unsafe fn paper(&self) -> Result<paper::Config, smr_status> {
        let numbers = &self.paper;
        let mut config = paper::Config::paper();
        // SAFETY: as the caller says.
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

    pub(crate) fn robust(&self) -> robust::Config {
        let numbers = &self.robust;
        let mut config = robust::Config::robust();
        config.reach = numbers.reach;
        config.size = numbers.size != 0;
        config.sweep = numbers.sweep != 0;
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

    /// What a configuration prints, after the table, which stands first.
    fn printed(config: impl core::fmt::Debug) -> String {
        let text = format!("{config:?}");
        text.split_once("] }").expect("the table stands first").1.into()
    }

    #[test]
    fn a_configuration_comes_back_as_it_was() {
        for config in [paper::Config::paper(), paper::Config::camera()] {
            // SAFETY: no table is given.
            let back = unsafe { smr_config::of_paper(&config).paper() }.unwrap();
            assert_eq!(printed(back), printed(config));
        }
        let config = robust::Config::robust();
        assert_eq!(printed(smr_config::of_robust(&config).robust()), printed(config));
        // A number that `Config` gains would come back by itself, without C being able to set it. Only pruning and which backend
        // but the plain loop are left to the library: they change no answer.
        let numbers = printed(paper::Config::paper());
        assert_eq!(
            numbers.matches(": ").count(),
            37,
            "has Config a new number? Then smr_paper_config needs it: {numbers}"
        );
        let numbers = printed(config);
        assert_eq!(
            numbers.matches(": ").count(),
            14,
            "has Config a new number? Then smr_robust_config needs it: {numbers}"
        );
    }

    #[test]
    fn every_number_of_the_configuration_goes_to_its_place() {
        // In the order in which `Config` declares them, and prints them: the fields of a literal are evaluated as written.
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
        let config = smr_config { paper, ..smr_config::of_paper(&paper::Config::paper()) };
        // SAFETY: no table is given.
        let printed = printed(unsafe { config.paper() }.unwrap());
        let words = printed.split(|character: char| !character.is_ascii_digit());
        let numbers: std::vec::Vec<u16> = words.filter_map(|word| word.parse().ok()).collect();
        assert!(printed.contains("runner_up: Always") && printed.contains("backend: None"));
        assert_eq!(numbers, (1..=25).collect::<std::vec::Vec<_>>());
    }

    #[test]
    fn every_number_of_the_robust_configuration_goes_to_its_place() {
        let all = smr_config::of_robust(&robust::Config::robust());
        let robust = smr_robust_config {
            reach: 1,
            size: 0,
            sweep: 1,
            patience: 2,
            lost_below: 3,
            uncertain_below: 4,
            learning_rate: 5,
            early_rate: 6,
        };
        let text = printed(smr_config { robust, ..all }.robust());
        let expected = "reach: 1, size: false, sweep: true, patience: 2, lost_below: 3, uncertain_below: 4, learning_rate: 5, \
                        early_rate: 6";
        assert!(text.contains(expected), "{text}");
        let swapped = smr_config { robust: smr_robust_config { size: 1, sweep: 0, ..robust }, ..all }.robust();
        assert!(swapped.size && !swapped.sweep);
        let plain = smr_config { plain_loop: 1, ..all };
        assert_eq!((all.robust().backend, plain.robust().backend), (None, Some(Backend::Scalar)));
        let plain = smr_config { plain_loop: 1, ..smr_config::of_paper(&paper::Config::camera()) };
        // SAFETY: no table is given.
        assert_eq!(unsafe { plain.paper() }.unwrap().backend, Some(Backend::Scalar));
    }
}
