//! The configuration of the paper tracker. [`Target::with`](crate::Target::with) checks it.

use super::search::Radius;
use crate::image::Rect;
use crate::similarity::{Backend, PAPER, Table};
use crate::track::ConfigError;
use crate::track::settings::{Kind, Numbers, Setting, Settings, Shape, names};

/// A ratio of two integers, `numerator / denominator`; the denominator is at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fraction {
    /// The numerator.
    pub numerator: u16,
    /// The denominator; at least 1.
    pub denominator: u16,
}

impl Fraction {
    /// The fraction `numerator / denominator`.
    #[must_use]
    pub const fn new(numerator: u16, denominator: u16) -> Self {
        Self { numerator, denominator }
    }

    /// `value` times the fraction, rounded up. A denominator of 0 counts as 1.
    #[must_use]
    pub fn ceil_of(self, value: u8) -> u32 {
        // No overflow: at most 255 * 65535 < 2^24.
        (u32::from(value) * u32::from(self.numerator)).div_ceil(u32::from(self.denominator).max(1))
    }

    /// True if `upper / lower` is more than the fraction. Exact: compares upper * denominator with lower * numerator.
    #[must_use]
    pub fn exceeded_by(self, upper: u32, lower: u32) -> bool {
        u64::from(upper) * u64::from(self.denominator) > u64::from(lower) * u64::from(self.numerator)
    }
}

/// The distances that a box must keep from the edges of the frame. Unit: pixel.
///
/// ```
/// use smr_core::{Rect, paper::Margins};
/// let zone = Margins { left: 20, top: 20, right: 2, bottom: 2 };
/// let frame = Rect::new(0, 0, 320, 240);
/// assert!(zone.kept_by(Rect::new(20, 20, 298, 218), frame));
/// assert!(!zone.kept_by(Rect::new(20, 20, 299, 218), frame));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Margins {
    /// Columns to the left of the box.
    pub left: u16,
    /// Rows above the box.
    pub top: u16,
    /// Columns to the right of the box.
    pub right: u16,
    /// Rows below the box.
    pub bottom: u16,
}

impl Margins {
    /// No distance: the box may touch every edge.
    pub const NONE: Self = Self { left: 0, top: 0, right: 0, bottom: 0 };

    /// True if `target` lies inside `frame` and keeps the margins.
    #[must_use]
    pub fn kept_by(self, target: Rect, frame: Rect) -> bool {
        frame.contains(target)
            && target.x.saturating_sub(frame.x) >= self.left.into()
            && target.y.saturating_sub(frame.y) >= self.top.into()
            && frame.right().saturating_sub(target.right()) >= self.right.into()
            && frame.bottom().saturating_sub(target.bottom()) >= self.bottom.into()
    }
}

settings! {
    Paper, 0;
    /// The settings of the paper tracker. Start from [`Config::camera`] or [`Config::paper`].
    ///
    /// The gate accepts a peak if peak / runner-up > r, or peak - runner-up > `gate_lead` fully similar pixels. The
    /// state of the target and the position of the peak decide which of `gate_tracking`, `gate_leaving`,
    /// `gate_returning` and `gate_lost` r is.
    ///
    /// ```
    /// use smr_core::{Paper, Target, paper::{Config, Fraction, Radius}};
    /// let mut config = Config::camera();
    /// config.k = Fraction::new(7, 20);
    /// config.window = Radius { x: 16, y: 16 };
    /// config.window_limit = config.window; // the window does not grow while the target is lost
    /// config.gate_tracking = Fraction::new(11, 10); // near a look-alike: rather lost than wrong
    /// assert!(Paper::<4096, 33>::with(config).is_ok());
    /// ```
    {
        /// The similarity p(d) of two pixels that differ by d. [`Table::PAPER`] is exp(-d / 255).
        pub table: &'static Table,
        /// The backend that computes scores; affects only the time. `None`: the fastest backend of the machine. A
        /// backend that the machine lacks is replaced by [`Backend::Scalar`].
        pub backend: Option<Backend>,
        /// Offsets that cannot change the result are skipped; affects only the time. `false`: every offset is
        /// scored to its last pixel.
        pub pruning: bool,
    }
    /// The factor of alpha: the next alpha is `k` times the largest change of a pixel in an update of the template.
    k: Fraction, 1..=65535;
    /// The ratio of peak and runner-up that is needed while the target stays inside the frame. Below 1 every peak above
    /// 0 is accepted.
    gate_tracking: Fraction, 0..=65535;
    /// The ratio of peak and runner-up that is needed if the box at the peak is partly outside the frame.
    gate_leaving: Fraction, 0..=65535;
    /// The ratio of peak and runner-up that is needed after a box was partly outside the frame, until a lost target is
    /// found again.
    gate_returning: Fraction, 0..=65535;
    /// The ratio of peak and runner-up that is needed to find a lost target again.
    gate_lost: Fraction, 0..=65535;
    /// The lead of the peak over the runner-up that is enough whatever their ratio is, in fully similar pixels.
    gate_lead: u16, 0..=65535;
    /// The least similarity matching ratio of an accepted peak, in units of 1/65535. 0, the paper's value, also turns
    /// off the check for a covered lens: a patch inside the frame needs a quarter of the template's contrast (mean
    /// absolute deviation), and its pixels at 0 or 255 may exceed those of the template by at most half of all pixels.
    least_ratio: u16, 0..=65535;
    /// alpha of the first update, in gray levels. Pixels that differ by less are similar.
    first_threshold: u8, 1..=255;
    /// The least alpha of later updates, in gray levels. 0 (the paper's value) and 1 set no bound, so that after a
    /// still scene a change of light leaves no pixel that matches.
    least_threshold: u8, 0..=255;
    /// The width of the black border around the frame, in pixels: how far a box may leave the frame.
    padding: u16, 0..=65535;
    /// The radius of the search window around the last position, in pixels.
    window: Radius, 0..=65535;
    /// The growth of the window in each frame while the target is lost, in pixels on each side.
    growth: u16, 0..=65535;
    /// The largest radius while the target is lost, in pixels; at least `window`. The padded frame always bounds it.
    window_limit: Radius, 0..=65535;
    /// The runner-up is the best score more than this many pixels from the peak, in x or in y.
    neighbourhood: u16, 0..=65535;
    /// The runner-up is searched in every frame, which takes several times as long, not only if the gate needs it.
    runner_up_always: bool, 0..=1;
    /// The distances that a box must keep from the edges of the frame for the tracker to learn from it, in pixels.
    update_zone: Margins, 0..=65535;
}

impl Config {
    /// The values of the paper and of its authors' program, for frames of about 320x240.
    ///
    /// While the target is lost, the window grows up to the padded frame. So `SPAN` must be at least frame + 40 - box +
    /// 1 on each axis, or `lock` fails; 361 is enough for every box in 320x240. For firmware see [`Config::camera`].
    #[must_use]
    pub const fn paper() -> Self {
        Self {
            table: &PAPER,
            k: Fraction::new(1, 4),
            first_threshold: 13, // 0.05 * 255 = 12.75; for integers d < 12.75 is d < 13
            least_threshold: 0,
            padding: 20,
            window: Radius { x: 60, y: 50 },
            growth: 1,
            window_limit: Radius { x: u16::MAX, y: u16::MAX },
            neighbourhood: 8,
            update_zone: Margins { left: 20, top: 20, right: 2, bottom: 2 }, // x + w < W - 1
            gate_tracking: Fraction::new(1, 1),
            gate_leaving: Fraction::new(102, 100),
            gate_returning: Fraction::new(120, 100),
            gate_lost: Fraction::new(125, 100),
            gate_lead: 100,
            least_ratio: 0,
            backend: None,
            pruning: true,
            runner_up_always: false,
        }
    }

    /// The preset for cameras: the paper's values with bounded time and memory.
    ///
    /// Differences from [`Config::paper`]:
    /// - While the target is lost, the window grows by at most 20 pixels on each side, so the cost of a frame at most
    ///   doubles. It needs a `SPAN` of 161; for less see [`Config::camera_within`].
    /// - The template is updated up to the edge of the frame. A peak inside the frame need not exceed the runner-up.
    /// - alpha is at least 10 gray levels, and a peak needs a ratio of at least 1/20: else a slight change of light
    ///   after a still scene could move the box anywhere. A patch needs contrast: see [`Config::least_ratio`].
    #[must_use]
    pub const fn camera() -> Self {
        Self {
            least_threshold: 10,
            window_limit: Radius { x: 80, y: 70 },
            update_zone: Margins::NONE,
            gate_tracking: Fraction::new(0, 1),
            least_ratio: Table::ONE / 20,
            ..Self::paper()
        }
    }

    /// [`Config::camera`] with windows of at most `radius` pixels to each side, also while the target is lost. It fits
    /// a tracker with a `SPAN` of `2 * radius + 1`: `Tracker::<Paper<1024, 33>>::with(Config::camera_within(16))`.
    #[must_use]
    pub const fn camera_within(radius: u16) -> Self {
        let camera = Self::camera();
        let (window, window_limit) = (camera.window.at_most(radius), camera.window_limit.at_most(radius));
        Self { window, window_limit, ..camera }
    }

    /// Checks all values, as [`Target::with`](crate::Target::with) does.
    ///
    /// # Errors
    /// [`ConfigError::OutOfRange`] or [`ConfigError::LimitBelowWindow`].
    #[cfg_attr(smr_small, inline(never))] // so that a configuration is copied by words
    pub const fn check(&self) -> Result<(), ConfigError> {
        if self.window_limit.x < self.window.x || self.window_limit.y < self.window.y {
            return Err(ConfigError::LimitBelowWindow);
        }
        self.check_ranges()
    }
}

impl Default for Config {
    /// Returns [`Config::camera`].
    fn default() -> Self {
        Self::camera()
    }
}
