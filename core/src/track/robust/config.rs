//! The configuration of the robust tracker: the settings that firmware may tune, with ranges and defaults.

use super::constants::REACH;
use crate::similarity::{Backend, PAPER, Table};
use crate::track::ConfigError;
use crate::track::settings::{Kind, Numbers, Setting, Settings, Shape, names};

settings! {
    Robust | RobustSmall, 1;
    /// The settings of the robust tracker. Start from [`Config::robust`], the values that were best on many recordings,
    /// or from `Config::refined`, the same values with the refiner, and change what you need.
    ///
    /// ```
    /// use smr_core::{Robust, Target, robust::Config};
    /// let mut config = Config::robust();
    /// config.size = false; // a target whose distance does not change
    /// config.reach = 5; // and that moves slowly: two fifths of the work
    /// let target: Robust = Target::with(config)?;
    /// assert!(target.window().is_none());
    /// # Ok::<(), smr_core::ConfigError>(())
    /// ```
    {
        /// The similarity p(d) of two pixels that differ by d.
        pub table: &'static Table,
        /// The instruction set of the inner loops; affects only the time. `None`: the fastest one that the machine has.
        pub backend: Option<Backend>,
        /// The largest `reach` of the size of tracker that the configuration is for: see `Config::within`.
        pub(in crate::track) max_reach: u8,
    }
    /// The box follows the size of the target.
    size: bool, 0..=1;
    /// Windows in which each frame is searched for a lost target, besides the one around its last place. From frame to
    /// frame they sweep the whole picture. Each takes about as much work as the search of a frame. 0: no sweep.
    sweep: u8, 0..=255;
    /// The radius of the search in cells. The side of a cell is a tenth of the root of the target's area. The work of an
    /// update grows with the square of 2 `reach` + 1. At most 7 in a tracker of the small size.
    reach: u8, 4..=8 at_most max_reach after 4;
    /// The part of its value that the confidence keeps in each frame, in units of 1/256. A higher one holds on to the
    /// target for longer: through short occlusions, but also through errors.
    patience: u8, 0..=255;
    /// The target is lost while the confidence is below this, in units of 1/65535.
    lost_below: u16, 0..=65535;
    /// The target is uncertain while the confidence is below this, in units of 1/65535; at least `lost_below`.
    uncertain_below: u16, 0..=65535;
    /// The learning rate of the filter, in units of 1/256: 0 keeps the filter of the first frame, 256 takes the exact step
    /// for the present frame.
    learning_rate: u16, 0..=256;
    /// The learning rate of the early template, in units of 1/1024.
    early_rate: u16, 0..=1024;
    /// A small learned network corrects the box. It keeps the box to a target that comes nearer, turns or changes
    /// its shape, reads more of the frame, and can make the state *uncertain* or *lost*. In firmware a build without the
    /// feature `refiner` refuses it.
    refiner: bool, 0..=1;
}

impl Config {
    /// Returns the settings that were best on many recordings, the same in every build. They leave the refiner off.
    #[must_use]
    pub const fn robust() -> Self {
        Self {
            table: &PAPER,
            backend: None,
            max_reach: 8,
            reach: 8,
            size: true,
            sweep: 4,
            refiner: false,
            patience: 179,
            lost_below: 19_200,
            uncertain_below: 32_500,
            learning_rate: 160,
            early_rate: 1,
        }
    }

    /// [`Config::robust`] with the refiner.
    #[cfg(feature = "refiner")]
    #[must_use]
    pub const fn refined() -> Self {
        Self { refiner: true, ..Self::robust() }
    }

    /// Checks the settings, as [`Target::with`](crate::Target::with) does.
    ///
    /// # Errors
    /// [`ConfigError::OutOfRange`], [`ConfigError::UncertainBelowLost`] or [`ConfigError::RefinerNotBuiltIn`].
    ///
    /// ```
    /// use smr_core::robust::Config;
    /// let mut config = Config::robust();
    /// config.reach = 100;
    /// assert_eq!(config.check().unwrap_err().to_string(), "reach is 4 to 8, not 100");
    /// ```
    pub const fn check(&self) -> Result<(), ConfigError> {
        if self.uncertain_below < self.lost_below {
            return Err(ConfigError::UncertainBelowLost);
        }
        match self.check_ranges() {
            Ok(()) if self.refiner && !cfg!(feature = "refiner") => Err(ConfigError::RefinerNotBuiltIn),
            checked => checked,
        }
    }

    /// [`Config::check`] for a tracker whose largest `reach` is `largest`.
    pub(super) const fn check_for(&self, largest: u16) -> Result<(), ConfigError> {
        if largest < REACH {
            in_range!("reach", self.reach as u16, 4, largest);
        }
        self.check()
    }

    pub(super) const fn span(&self) -> usize {
        2 * self.reach as usize + 1
    }

    pub(super) fn backend(&self) -> Backend {
        self.backend.unwrap_or_else(Backend::best)
    }

    pub(super) const fn refines(&self) -> bool {
        cfg!(feature = "refiner") && self.refiner
    }

    pub(super) fn reach(&self) -> u16 {
        self.reach.into()
    }
}

impl Default for Config {
    fn default() -> Self {
        Self::robust()
    }
}
