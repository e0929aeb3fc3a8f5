//! Why a call was refused: one small enum for each operation, the same for both trackers.

use core::fmt;

/// Why a configuration cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ConfigError {
    /// A fraction has a denominator of 0.
    ZeroDenominator,
    /// `k` or `first_threshold` is 0: no pixel would ever count.
    NothingCounts,
    /// `window_limit` is smaller than `window`.
    LimitBelowWindow,
    /// A number lies outside the range that its documentation states.
    OutOfRange,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ZeroDenominator => "a fraction of the configuration has a denominator of 0",
            Self::NothingCounts => "k and the first threshold must be more than 0, or no pixel ever counts",
            Self::LimitBelowWindow => "the window's limit is smaller than the window",
            Self::OutOfRange => "a number of the configuration lies outside its range",
        })
    }
}

impl core::error::Error for ConfigError {}

/// Why a tracker does not start on a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LockError {
    /// The box has no pixels.
    BoxEmpty,
    /// A part of the box lies outside the frame.
    BoxOutsideFrame,
    /// The box has more pixels than there is room for. [`Robust`](crate::Robust) has room for every box.
    BoxTooLarge,
    /// The window could grow to more offsets on an axis than there is room for: make the window's limit smaller or `SPAN`
    /// larger. [`Robust`](crate::Robust) always has room.
    WindowTooLarge,
    /// The frame in memory does not cover [`Target::lock_window`](crate::Target::lock_window).
    LockWindowNotInMemory,
    /// The frame is not of the size of the one by which the lock was begun.
    FrameSizeChanged,
    /// No lock of this target is under way in this workspace: none was begun, it was finished, the target has changed since, the
    /// workspace has served another one, or one of them has been moved in memory.
    NotBegun,
}

impl fmt::Display for LockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BoxEmpty => "the box has no pixels: width and height must be at least 1",
            Self::BoxOutsideFrame => "the box is not wholly inside the frame",
            Self::BoxTooLarge => "the box has more pixels than this tracker's template has room for",
            Self::WindowTooLarge => "the window could grow to more offsets on an axis than this tracker has room for",
            Self::LockWindowNotInMemory => "the frame in memory does not cover what lock reads (the lock window)",
            Self::FrameSizeChanged => "the frame is not of the size of the one by which the lock was begun",
            Self::NotBegun => "no lock was begun",
        })
    }
}

impl core::error::Error for LockError {}

/// Why a frame was not searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum UpdateError {
    /// There is no target yet: lock first.
    NotLocked,
    /// The frame is not of the size of the frame that was locked on.
    FrameSizeChanged,
    /// The frame in memory does not cover [`Target::window`](crate::Target::window), or
    /// [`Target::sweep_window`](crate::Target::sweep_window) where there is one.
    WindowNotInMemory,
    /// No update of this target is under way in this workspace: none was begun, it was finished, the target has changed since, the
    /// workspace has served another one, or one of them has been moved in memory.
    NotBegun,
}

impl fmt::Display for UpdateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotLocked => "there is no target yet: lock first",
            Self::FrameSizeChanged => "the frame is not of the size of the one that was locked on",
            Self::WindowNotInMemory => "the frame in memory does not cover the search window",
            Self::NotBegun => "no update was begun",
        })
    }
}

impl core::error::Error for UpdateError {}
