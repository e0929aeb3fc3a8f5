//! Errors: one small enum per operation, the same for both trackers.

use core::fmt;

/// Why a configuration was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ConfigError {
    /// A number of a setting is outside its range.
    OutOfRange {
        /// The name of the setting.
        name: &'static str,
        /// The lowest value.
        lowest: u16,
        /// The highest value.
        highest: u16,
        /// The number.
        found: u16,
    },
    /// `window_limit` is smaller than `window`.
    LimitBelowWindow,
    /// `uncertain_below` is smaller than `lost_below`.
    UncertainBelowLost,
    /// `window` has more offsets on an axis than the tracker's `SPAN`. Only from [`Paper`](crate::Paper).
    WindowTooLarge,
    /// The configuration has the refiner on, in a build without the feature `refiner`.
    RefinerNotBuiltIn,
    /// No setting has this name: see [`Settings::SETTINGS`](crate::Settings::SETTINGS).
    UnknownSetting,
    /// A setting has another count of numbers.
    WrongCount {
        /// The name of the setting.
        name: &'static str,
        /// Its count of numbers.
        count: usize,
    },
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OutOfRange { name, lowest, highest, found } => {
                return write!(f, "{name} is {lowest} to {highest}, not {found}");
            }
            Self::LimitBelowWindow => "window_limit is smaller than window",
            Self::UncertainBelowLost => "uncertain_below is smaller than lost_below",
            Self::WindowTooLarge => "the window has more offsets on an axis than this tracker has room for",
            Self::RefinerNotBuiltIn => "the refiner is on, and this build is without it (feature refiner)",
            Self::UnknownSetting => "no setting of this tracker has this name",
            Self::WrongCount { name, count } => return write!(f, "{name} takes {count} numbers"),
        })
    }
}

impl core::error::Error for ConfigError {}

/// Why a box was not locked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LockError {
    /// The box has no pixels.
    BoxEmpty,
    /// The box is partly outside the frame.
    BoxOutsideFrame,
    /// The box has more than `PIXELS` pixels. Only from [`Paper`](crate::Paper).
    BoxTooLarge,
    /// The window could grow to more than `SPAN` offsets on an axis: reduce `window_limit` or increase `SPAN`. Only
    /// from [`Paper`](crate::Paper).
    WindowTooLarge,
    /// [`Target::lock_window`](crate::Target::lock_window) is not wholly in memory.
    LockWindowNotInMemory,
}

impl fmt::Display for LockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BoxEmpty => "the box has no pixels: width and height must be at least 1",
            Self::BoxOutsideFrame => "the box is not wholly inside the frame",
            Self::BoxTooLarge => "the box has more pixels than this tracker's template has room for",
            Self::WindowTooLarge => "the window can grow to more offsets on an axis than this tracker has room for",
            Self::LockWindowNotInMemory => "the lock window is not wholly in memory",
        })
    }
}

impl core::error::Error for LockError {}

/// Why a frame was not searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum UpdateError {
    /// There is no target yet: call `lock` first.
    NotLocked,
    /// The frame has another size than the one that was locked on.
    FrameSizeChanged,
    /// [`Target::window`](crate::Target::window) or [`Target::sweep_window`](crate::Target::sweep_window) is not wholly
    /// in memory.
    WindowNotInMemory,
}

impl fmt::Display for UpdateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotLocked => "there is no target yet: lock first",
            Self::FrameSizeChanged => "the frame has another size than the one that was locked on",
            Self::WindowNotInMemory => "the search window is not wholly in memory",
        })
    }
}

impl core::error::Error for UpdateError {}
