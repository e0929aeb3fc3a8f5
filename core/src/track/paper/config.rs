//! Every number of the method in one place: [`Config`], checked once, by [`Target::new`](crate::Target::new).

use crate::image::Rect;
use crate::search::Radius;
use crate::similarity::{Backend, Table};
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
    /// What stands above the line.
    pub numerator: u16,
    /// What stands below the line; at least 1.
    pub denominator: u16,
}

impl Fraction {
    /// `numerator / denominator`.
    #[must_use]
    pub const fn new(numerator: u16, denominator: u16) -> Self {
        Self { numerator, denominator }
    }

    /// The smallest integer that is not less than `value` times the fraction. A denominator of 0 counts as 1.
    #[must_use]
    pub fn ceil_of(self, value: u8) -> u32 {
        // At most 255 * 65535: far from the end of a u32.
        (u32::from(value) * u32::from(self.numerator)).div_ceil(u32::from(self.denominator).max(1))
    }

    /// True if `upper / lower` is more than the fraction: exact, without a division.
    #[must_use]
    pub fn exceeded_by(self, upper: u32, lower: u32) -> bool {
        // Both products are below 2^48.
        u64::from(upper) * u64::from(self.denominator) > u64::from(lower) * u64::from(self.numerator)
    }
}

/// How many pixels a box keeps from each edge of the picture.
///
/// ```
/// use smr_core::{Rect, paper::Margins};
/// let zone = Margins { left: 20, top: 20, right: 2, bottom: 2 };
/// let picture = Rect::new(0, 0, 320, 240);
/// assert!(zone.kept_by(Rect::new(20, 20, 298, 218), picture));
/// assert!(!zone.kept_by(Rect::new(20, 20, 299, 218), picture));
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
    /// The box may touch every edge.
    pub const NONE: Self = Self { left: 0, top: 0, right: 0, bottom: 0 };

    /// True if `target` lies inside `picture` and keeps the margins.
    #[must_use]
    pub fn kept_by(self, target: Rect, picture: Rect) -> bool {
        picture.contains(target)
            && target.x.saturating_sub(picture.x) >= self.left.into()
            && target.y.saturating_sub(picture.y) >= self.top.into()
            && picture.right().saturating_sub(target.right()) >= self.right.into()
            && picture.bottom().saturating_sub(target.bottom()) >= self.bottom.into()
    }
}

/// How clearly the peak must stand above the runner-up before a frame is believed.
///
/// The first four are ratios of the two scores that the peak must exceed; which one holds depends on where the peak is and
/// where the target was. A ratio below 1 demands nothing of a peak that scores at all.
///
/// ```
/// use smr_core::paper::{Config, Fraction};
/// let mut config = Config::paper();
/// // A camera that must not follow a look-alike: be lost rather than wrong.
/// config.gate.tracking = Fraction::new(11, 10);
/// assert!(config.gate.tracking.exceeded_by(1101, 1000) && !config.gate.tracking.exceeded_by(1100, 1000));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Gate {
    /// While the target stays inside the picture.
    pub tracking: Fraction,
    /// When the box at the peak is partly outside the picture.
    pub leaving: Fraction,
    /// When the box at the peak is inside, but one has not been before: until a lost target is found again.
    pub returning: Fraction,
    /// To be found again when lost, wherever that is.
    pub lost: Fraction,
    /// The other way to be believed, in every state: the peak is more than this many fully similar pixels above the
    /// runner-up.
    pub lead: u16,
    /// The least similarity matching ratio of the peak, in units of 1/65535; below it no frame is believed. Where it is not 0, a box inside
    /// the frame must also show a quarter of the template's contrast (mean absolute deviation), and no more pixels cut off at 0 or 255 than
    /// the template has and half of all: what a covered lens shows is no target. 0 demands nothing, neither of the ratio nor of the contrast,
    /// which is the paper's.
    pub least_ratio: u16,
}

/// The numbers of the method. [`Config::camera`] holds those for firmware, [`Config::paper`] the paper's; each can be changed.
///
/// ```
/// use smr_core::{Paper, Target, paper::{Config, Fraction, Radius}};
/// let mut config = Config::camera();
/// config.k = Fraction::new(7, 20);
/// config.window = Radius { x: 16, y: 16 };
/// config.window_limit = config.window; // does not grow while lost
/// assert!(Paper::<4096, 33>::new(config).is_ok());
/// ```
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Config {
    /// The similarity of two pixels by their difference. [`Table::PAPER`] is exp(-d / 255).
    pub table: &'static Table,
    /// k in alpha = k * max |G_t - G_t+1| (step 6).
    pub k: Fraction,
    /// alpha before the first update, rounded up to whole gray levels: a pixel counts if its difference is below it.
    pub first_threshold: u8,
    /// The least alpha after an update, in whole gray levels. 0 and 1 are the same, and the paper's: alpha follows the change
    /// of the template however small it is, and after a still scene a slight change of light leaves no pixel that counts.
    pub least_threshold: u8,
    /// Width of the virtual border of zeroes around the frame, in pixels: how far a box may leave the picture.
    pub padding: u16,
    /// The search window around the last position.
    pub window: Radius,
    /// How many pixels the window grows on each side, for each frame that the target stays lost.
    pub growth: u16,
    /// Where that growth ends. The window never reaches beyond the padded frame.
    pub window_limit: Radius,
    /// The runner-up is the best score more than this many pixels away from the peak, in x or in y.
    pub neighbourhood: u16,
    /// What a box keeps from the edges of the picture for its patch to become the template. Elsewhere an accepted peak moves
    /// the box; template and alpha stay.
    pub update_zone: Margins,
    /// When a frame is believed.
    pub gate: Gate,
    /// How scores are computed; it changes nothing but the time. `None` is the fastest way that the machine has; one that
    /// it does not have is replaced by the plain loop.
    pub backend: Option<Backend>,
    /// Whether offsets that cannot matter are left out; it changes nothing but the time. Without, every offset is scored to
    /// its last pixel.
    pub pruning: bool,
    /// When the runner-up is looked for.
    pub runner_up: RunnerUp,
}

/// When the runner-up is looked for.
///
/// It lies far below the peak of a target that is followed, so few offsets can be excluded from being it: looking for it
/// always multiplies the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RunnerUp {
    /// When the gate's decision depends on it. With the paper's gate that is every frame but those where the target was
    /// tracked before and the peak is inside the frame. There the peak only has to be larger than the runner-up: the
    /// runner-up is given if it is as large.
    WhenItDecides,
    /// In every frame.
    Always,
}

impl Config {
    /// The values of the paper and its authors' program, for frames of about 320x240.
    ///
    /// The window of a lost target grows until it is the padded frame: on each axis `SPAN` must be at least
    /// frame + 40 - box + 1 offsets (361 holds every box on 320x240), or the tracker does not lock. For firmware see
    /// [`Config::camera`].
    #[must_use]
    pub const fn paper() -> Self {
        Self {
            table: &Table::PAPER,
            k: Fraction::new(1, 4),
            first_threshold: 13, // 0.05 of full scale is 12.75, and d < 12.75 is d < 13
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

    /// For cameras: the paper's values with a bounded window, so that time and memory are, too.
    ///
    /// Beside [`Config::paper`]:
    /// - The window of a lost target grows by at most 20 pixels on each side, so the cost of a frame at most doubles. A
    ///   `SPAN` of 161 holds it.
    /// - The template is updated up to the edge of the picture, and a peak inside the picture need not exceed the runner-up.
    /// - alpha is at least 10 gray levels, and a peak of less than a twentieth of what is possible is not believed: after a
    ///   still scene a slight change of light would otherwise move the box to anywhere. Nor is one that shows no contrast, as under a covered
    ///   lens: see [`Gate::least_ratio`].
    #[must_use]
    pub const fn camera() -> Self {
        let paper = Self::paper();
        let gate = Gate { tracking: Fraction::new(0, 1), least_ratio: Table::ONE / 20, ..paper.gate };
        let window_limit = Radius { x: 80, y: 70 };
        Self { least_threshold: 10, window_limit, update_zone: Margins::NONE, gate, ..paper }
    }

    /// Whether a tracker takes it: what [`Target::new`](crate::Target::new) asks.
    ///
    /// # Errors
    /// The first thing found wrong.
    ///
    /// ```
    /// use smr_core::{ConfigError, paper::Config};
    /// let mut config = Config::camera();
    /// config.first_threshold = 0;
    /// assert_eq!(config.check(), Err(ConfigError::NothingCounts));
    /// ```
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
