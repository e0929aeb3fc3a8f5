//! The configuration of the robust tracker: the settings that firmware may tune, with ranges and defaults.

use super::constants::REACH;
use crate::similarity::{Backend, PAPER, Table};
use crate::track::ConfigError;

/// The settings of the robust tracker. Start from [`Config::robust`], the values that were best on many recordings, or
/// from `Config::refined`, the same values with the refiner, and change what you need.
///
/// ```
/// use smr_core::{Robust, Target, robust::Config};
/// let mut config = Config::robust();
/// config.size = false; // a target whose distance does not change
/// config.reach = 5; // and that moves slowly: two fifths of the work
/// let target = Robust::with(config)?;
/// assert!(target.window().is_none());
/// # Ok::<(), smr_core::ConfigError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Config {
    /// The similarity p(d) of two pixels that differ by d.
    pub table: &'static Table,
    /// The backend that computes sums; affects only the time. `None`: the fastest backend of the machine.
    pub backend: Option<Backend>,
    /// The radius of the search window in cells, 4 to 8. The side of a cell is a tenth of the root of the target's
    /// area. The work of an update grows with the square of 2 `reach` + 1.
    pub reach: u8,
    /// Whether the box follows the target's size.
    pub size: bool,
    /// Whether a lost target is searched in the whole frame (redetection), or only in the window around its last place.
    pub sweep: bool,
    /// Whether a small learned network corrects the answered box. With it the box keeps to a target that comes nearer,
    /// turns or changes its shape. Where it does not recognise the target, the state is *uncertain* or *lost* at any
    /// confidence. It reads more of the frame: see [`Target::window`](crate::Target::window). In a build without the
    /// feature `refiner`, [`Config::check`] refuses it.
    pub refiner: bool,
    /// The inertia of the confidence: it keeps `patience` / 256 of its value in each frame, and follows the evidence by
    /// the rest. A higher value holds on to the target for longer: through short occlusions, but also through errors.
    pub patience: u8,
    /// The target is lost while the confidence is below this, in units of 1/65535.
    pub lost_below: u16,
    /// It is uncertain while the confidence is below this; at least `lost_below`.
    pub uncertain_below: u16,
    /// The filter's learning rate: the fraction of the exact step, in units of 1/256, 0 to 256. With 0 the filter keeps
    /// what it learned in the first frame.
    pub learning_rate: u16,
    /// The early template's learning rate, in units of 1/1024: 0 to 1024.
    pub early_rate: u16,
    pub(super) parts: Parts,
}

/// The parts of the tracker that can be left out, to measure the effect of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Parts {
    pub(super) velocity: bool,
    pub(super) distance_penalty: bool,
    pub(super) verification: bool,
    pub(super) gated_learning: bool,
    pub(super) opinion: bool,
}

/// A part of the robust tracker that [`without`](crate::unstable::without) leaves out.
#[cfg(feature = "unstable")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// A moving target is expected to keep moving.
    Velocity,
    /// Responses far from the expected place count less.
    DistancePenalty,
    /// The early template verifies the target. Without this part the state is always tracking.
    Verification,
    /// The tracker learns only from frames with enough evidence.
    GatedLearning,
    /// The refiner's network can make the state worse.
    Opinion,
}

impl Config {
    /// The values that were best on many recordings, without the refiner: the same in every build.
    #[must_use]
    pub const fn robust() -> Self {
        Self {
            table: &PAPER,
            backend: None,
            reach: 8,
            size: true,
            sweep: true,
            refiner: false,
            patience: 179,
            lost_below: 19_200,
            uncertain_below: 32_500,
            learning_rate: 160,
            early_rate: 1,
            parts: Parts {
                velocity: true,
                distance_penalty: true,
                verification: true,
                gated_learning: true,
                opinion: true,
            },
        }
    }

    /// [`Config::robust`] with the refiner.
    #[cfg(feature = "refiner")]
    #[must_use]
    pub const fn refined() -> Self {
        Self { refiner: true, ..Self::robust() }
    }

    /// This configuration without a part.
    #[cfg(feature = "unstable")]
    #[must_use]
    pub(crate) const fn without(mut self, part: Part) -> Self {
        match part {
            Part::Velocity => self.parts.velocity = false,
            Part::DistancePenalty => self.parts.distance_penalty = false,
            Part::Verification => self.parts.verification = false,
            Part::GatedLearning => self.parts.gated_learning = false,
            Part::Opinion => self.parts.opinion = false,
        }
        self
    }

    /// Whether this configuration has a part.
    #[cfg(feature = "unstable")]
    #[must_use]
    pub(crate) const fn has(&self, part: Part) -> bool {
        match part {
            Part::Velocity => self.parts.velocity,
            Part::DistancePenalty => self.parts.distance_penalty,
            Part::Verification => self.parts.verification,
            Part::GatedLearning => self.parts.gated_learning,
            Part::Opinion => self.parts.opinion,
        }
    }

    /// Checks the numbers, as [`Target::with`](crate::Target::with) does.
    ///
    /// # Errors
    /// [`ConfigError::OutOfRange`], or [`ConfigError::RefinerNotBuiltIn`].
    ///
    /// ```
    /// use smr_core::{ConfigError, robust::Config};
    /// let mut config = Config::robust();
    /// config.reach = 9;
    /// assert_eq!(config.check(), Err(ConfigError::OutOfRange));
    /// ```
    pub const fn check(&self) -> Result<(), ConfigError> {
        let reach = 4 <= self.reach && self.reach as u16 <= REACH;
        let states = self.lost_below <= self.uncertain_below;
        let rates = self.learning_rate <= 256 && self.early_rate <= 1024;
        if !(reach && states && rates) {
            Err(ConfigError::OutOfRange)
        } else if self.refiner && !cfg!(feature = "refiner") {
            Err(ConfigError::RefinerNotBuiltIn)
        } else {
            Ok(())
        }
    }

    /// The number of offsets of the search on each axis.
    pub(super) const fn span(&self) -> usize {
        2 * self.reach as usize + 1
    }

    /// The backend that is used.
    pub(super) fn backend(&self) -> Backend {
        self.backend.unwrap_or_else(Backend::best)
    }

    /// Whether the refiner corrects the box. False in a build without it.
    pub(super) const fn refines(&self) -> bool {
        cfg!(feature = "refiner") && self.refiner
    }

    /// Whether the refiner's network can make the state worse.
    pub(super) const fn has_opinion(&self) -> bool {
        self.refines() && self.parts.opinion && self.parts.verification
    }

    pub(super) fn reach(&self) -> u16 {
        self.reach.into()
    }

    /// Whether a lost target is searched in the whole frame.
    pub(super) const fn sweeps(&self) -> bool {
        self.sweep && self.parts.verification
    }
}

impl Default for Config {
    fn default() -> Self {
        Self::robust()
    }
}
