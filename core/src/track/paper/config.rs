//! The configuration of the paper's tracker. [`Target::with`](crate::Target::with) checks it.

use crate::image::Rect;
use crate::search::Radius;
use crate::similarity::{Backend, PAPER, Table};
use crate::track::ConfigError;

/// A ratio of two integers, `numerator / denominator`; the denominator is at least 1.
///
/// ```
/// use smr_core::paper::Fraction;
/// let k = Fraction { numerator: 1, denominator: 4 };
/// assert_eq!(k.ceil_of(50), 13); // 12.5, rounded up
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fraction {
    /// The numerator.
    pub numerator: u16,
    /// The denominator; at least 1.
    pub denominator: u16,
}

impl Fraction {
    /// `numerator / denominator`.
    #[must_use]
    pub const fn new(numerator: u16, denominator: u16) -> Self {
        Self { numerator, denominator }
    }

    /// `value` times the fraction, rounded up. A denominator of 0 counts as 1.
    #[must_use]
    pub fn ceil_of(self, value: u8) -> u32 {
        // At most 255 * 65535 < 2^24.
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
    /// Rows above it.
    pub top: u16,
    /// Columns to the right of it.
    pub right: u16,
    /// Rows below it.
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

/// The gate: the lead over the runner-up with which a peak is accepted.
///
/// A peak is accepted if peak / runner-up > r, or peak - runner-up > `lead` fully similar pixels. One of the first four
/// numbers is r: the state of the target and the place of the peak decide which one. An r below 1 accepts every peak
/// above 0.
///
/// ```
/// use smr_core::paper::{Config, Fraction};
/// let mut config = Config::paper();
/// // For a camera that must not follow a look-alike: rather lost than wrong.
/// config.gate.tracking = Fraction::new(11, 10);
/// assert!(config.gate.tracking.exceeded_by(1101, 1000) && !config.gate.tracking.exceeded_by(1100, 1000));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Gate {
    /// The ratio needed while the target stays inside the frame.
    pub tracking: Fraction,
    /// The ratio needed if the box at the peak is partly outside the frame.
    pub leaving: Fraction,
    /// The ratio needed after a box was partly outside the frame. It applies until a lost target is found again.
    pub returning: Fraction,
    /// The ratio needed to find a lost target again.
    pub lost: Fraction,
    /// The lead over the runner-up that is sufficient in every state. Unit: one fully similar pixel, a score of 65535.
    pub lead: u16,
    /// The least similarity matching ratio of an accepted peak, in units of 1/65535. The paper's value, 0, also turns
    /// off the following check.
    ///
    /// The check detects a covered lens and applies to boxes inside the frame. The patch must have at least 1/4 of
    /// the template's contrast (mean absolute deviation). Its number of pixels at 0 or 255 must be at most that of the
    /// template plus half of all pixels.
    pub least_ratio: u16,
}

/// The settings of the paper's tracker. Start from [`Config::camera`] (for firmware) or [`Config::paper`] and change
/// what you need.
///
/// ```
/// use smr_core::{Paper, Target, paper::{Config, Fraction, Radius}};
/// let mut config = Config::camera();
/// config.k = Fraction::new(7, 20);
/// config.window = Radius { x: 16, y: 16 };
/// config.window_limit = config.window; // the window does not grow while the target is lost
/// assert!(Paper::<4096, 33>::with(config).is_ok());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Config {
    /// The similarity p(d) of two pixels that differ by d. [`Table::PAPER`] is exp(-d / 255).
    pub table: &'static Table,
    /// k in alpha = k * max |`G_t` - `G_t+1`| (step 6). More than 0.
    pub k: Fraction,
    /// alpha of the first update, rounded up to whole gray levels; at least 1. A pixel counts if d < alpha.
    pub first_threshold: u8,
    /// The least alpha after an update, in whole gray levels. 0 (the paper's value) and 1 set no bound: after a still
    /// scene, alpha is then so small that no pixel counts once the light changes.
    pub least_threshold: u8,
    /// The width of the border of zeros around the frame, in pixels. A box may leave the frame by this much.
    pub padding: u16,
    /// The radius of the search window around the last position.
    pub window: Radius,
    /// The growth of the window in each frame while the target is lost: pixels on each side.
    pub growth: u16,
    /// The largest radius. At least `window`. The padded frame always bounds the window.
    pub window_limit: Radius,
    /// The runner-up is the best score more than this many pixels from the peak, in x or in y.
    pub neighbourhood: u16,
    /// The template and alpha are updated only from a box that keeps these margins. Outside them an accepted peak only
    /// moves the box.
    pub update_zone: Margins,
    /// The gate, which accepts or refuses a match.
    pub gate: Gate,
    /// The backend that computes scores; affects only the time. `None`: the fastest backend of the machine. A backend
    /// that the machine lacks is replaced by the plain loop.
    pub backend: Option<Backend>,
    /// Whether offsets that cannot change the result are skipped; affects only the time. `false`: every offset is
    /// scored to its last pixel.
    pub pruning: bool,
    /// The frames in which the runner-up is searched.
    pub runner_up: RunnerUp,
}

/// The frames in which the runner-up is searched.
///
/// The runner-up is usually far below the peak, so few offsets can be excluded. A search for it in every frame
/// multiplies the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RunnerUp {
    /// If the decision of the gate depends on it. With the paper's gate it does not while a target stays inside the
    /// frame: its peak only has to exceed the runner-up, so the runner-up is given only if it equals the peak.
    WhenItDecides,
    /// In every frame.
    Always,
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
            gate: Gate {
                tracking: Fraction::new(1, 1),
                leaving: Fraction::new(102, 100),
                returning: Fraction::new(120, 100),
                lost: Fraction::new(125, 100),
                lead: 100,
                least_ratio: 0,
            },
            backend: None,
            pruning: true,
            runner_up: RunnerUp::WhenItDecides,
        }
    }

    /// The preset for cameras: the paper's values with bounded time and memory.
    ///
    /// Differences from [`Config::paper`]:
    /// - While the target is lost, the window grows by at most 20 pixels on each side, so the cost of a frame at most
    ///   doubles. It needs a `SPAN` of 161; for less see [`Config::camera_within`].
    /// - The template is updated up to the edge of the frame, and a peak inside the frame need not exceed the
    ///   runner-up.
    /// - alpha is at least 10 gray levels, and a peak needs a ratio of at least 1/20. Without these, a slight change of
    ///   light after a still scene could move the box anywhere. A patch without contrast is not accepted: see
    ///   [`Gate::least_ratio`].
    #[must_use]
    pub const fn camera() -> Self {
        let paper = Self::paper();
        let gate = Gate { tracking: Fraction::new(0, 1), least_ratio: Table::ONE / 20, ..paper.gate };
        let window_limit = Radius { x: 80, y: 70 };
        Self { least_threshold: 10, window_limit, update_zone: Margins::NONE, gate, ..paper }
    }

    /// [`Config::camera`] with windows of at most `radius` pixels to each side, also while the target is lost. It fits
    /// a tracker with a `SPAN` of `2 * radius + 1`.
    ///
    /// ```
    /// use smr_core::{Paper, Tracker, paper::Config};
    /// let tracker = Tracker::<Paper<1024, 33>>::with(Config::camera_within(16))?;
    /// # Ok::<(), smr_core::ConfigError>(())
    /// ```
    #[must_use]
    pub const fn camera_within(radius: u16) -> Self {
        let camera = Self::camera();
        let (window, window_limit) = (camera.window.at_most(radius), camera.window_limit.at_most(radius));
        Self { window, window_limit, ..camera }
    }

    /// Checks the numbers, as [`Target::with`](crate::Target::with) does.
    ///
    /// # Errors
    /// The first [`ConfigError`] found.
    ///
    /// ```
    /// use smr_core::{ConfigError, paper::Config};
    /// let mut config = Config::camera();
    /// config.first_threshold = 0;
    /// assert_eq!(config.check(), Err(ConfigError::NothingCounts));
    /// ```
    #[cfg_attr(smr_small, inline(never))] // so that a configuration is copied by words
    pub const fn check(&self) -> Result<(), ConfigError> {
        let Gate { tracking, leaving, returning, lost, .. } = &self.gate;
        let mut fractions: &[&Fraction] = &[&self.k, tracking, leaving, returning, lost];
        while let [fraction, rest @ ..] = fractions {
            if fraction.denominator == 0 {
                return Err(ConfigError::ZeroDenominator);
            }
            fractions = rest;
        }
        if self.k.numerator == 0 || self.first_threshold == 0 {
            return Err(ConfigError::NothingCounts);
        }
        if self.window_limit.x < self.window.x || self.window_limit.y < self.window.y {
            return Err(ConfigError::LimitBelowWindow);
        }
        Ok(())
    }
}

impl Default for Config {
    /// [`Config::camera`].
    fn default() -> Self {
        Self::camera()
    }
}
