//! The errors of the pursuit: one small enum for each operation.

use crate::UpdateError;
use core::fmt;

/// The reason why a [`PursuitConfig`](super::PursuitConfig) was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PursuitConfigError {
    /// A number is infinite or not a number (NaN).
    NotFinite,
    /// The focal length is less than a pixel.
    FocalLengthTooShort,
    /// The gain, the slew rate or the return speed is 0 or negative.
    RateNotPositive,
    /// The deadband or the hold time is negative.
    Negative,
    /// The minimum of an axis is not less than its maximum.
    LimitsReversed,
    /// A limit is more than 2 pi away from 0. It may be in degrees.
    LimitsBeyondOneTurn,
    /// The home position of an axis is outside its limits.
    HomeOutsideLimits,
    /// A pulse is as long as the period or longer.
    PulseNotInPeriod,
    /// The pulses at both limits are equal.
    PulsesEqual,
    /// The delay is more than 3 frames.
    DelayTooLong,
}

impl fmt::Display for PursuitConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "a number of the configuration is infinite or not a number",
            Self::FocalLengthTooShort => "the focal length must be at least one pixel",
            Self::RateNotPositive => "gain, slew rate and return speed must be more than 0",
            Self::Negative => "the deadband and the hold time must not be negative",
            Self::LimitsReversed => "the minimum of an axis must be less than its maximum",
            Self::LimitsBeyondOneTurn => "the limits of an axis must be within one turn (2 pi): they are in radians",
            Self::HomeOutsideLimits => "the home position of an axis must be within its limits",
            Self::PulseNotInPeriod => "the pulses of a servo must be shorter than its period",
            Self::PulsesEqual => "the pulses of a servo at its two limits must differ",
            Self::DelayTooLong => "the delay must be at most 3 frames",
        })
    }
}

impl core::error::Error for PursuitConfigError {}

/// The reason why a frame was not searched. No pin was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FollowError {
    /// The elapsed time is negative, infinite or not a number.
    ElapsedTime,
    /// The tracker refused the frame.
    Update(UpdateError),
}

impl fmt::Display for FollowError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ElapsedTime => f.write_str("the elapsed time is negative, infinite or not a number"),
            Self::Update(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for FollowError {}

/// The reason why the head was not turned: the error of the pan, tilt or indicator pin, unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PursuitError<P, T, L> {
    /// The pan servo's pin failed.
    Pan(P),
    /// The tilt servo's pin failed.
    Tilt(T),
    /// The indicator's pin failed.
    Indicator(L),
    /// The elapsed time is negative, infinite or not a number. No pin was written.
    ElapsedTime,
}

impl<P: fmt::Debug, T: fmt::Debug, L: fmt::Debug> fmt::Display for PursuitError<P, T, L> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pan(error) => write!(f, "the pan servo's pin failed: {error:?}"),
            Self::Tilt(error) => write!(f, "the tilt servo's pin failed: {error:?}"),
            Self::Indicator(error) => write!(f, "the lock indicator's pin failed: {error:?}"),
            Self::ElapsedTime => f.write_str("the elapsed time is negative, infinite or not a number"),
        }
    }
}

impl<P: fmt::Debug, T: fmt::Debug, L: fmt::Debug> core::error::Error for PursuitError<P, T, L> {}
