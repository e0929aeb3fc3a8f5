//! The errors of the pursuit: one small enum for each operation.

use crate::UpdateError;

errors! {
    /// The reason why a [`PursuitConfig`](super::PursuitConfig) was refused.
    PursuitConfigError {
        /// A number is infinite or not a number (NaN).
        NotFinite => "a number of the configuration is infinite or not a number",
        /// The focal length is less than a pixel.
        FocalLengthTooShort => "the focal length must be at least one pixel",
        /// The gain, the slew rate or the return speed is 0 or negative.
        RateNotPositive => "gain, slew rate and return speed must be more than 0",
        /// The deadband or the hold time is negative.
        Negative => "the deadband and the hold time must not be negative",
        /// The minimum of an axis is not less than its maximum.
        LimitsReversed => "the minimum of an axis must be less than its maximum",
        /// A limit is more than 2 pi away from 0, perhaps because it was given in degrees.
        LimitsBeyondOneTurn => "the limits of an axis must be within one turn (2 pi): they are in radians",
        /// The home position of an axis is outside its limits.
        HomeOutsideLimits => "the home position of an axis must be within its limits",
        /// A pulse is as long as the period or longer.
        PulseNotInPeriod => "the pulses of a servo must be shorter than its period",
        /// The pulses at both limits are equal.
        PulsesEqual => "the pulses of a servo at its two limits must differ",
        /// The delay is more than 3 frames.
        DelayTooLong => "the delay must be at most 3 frames",
    }

    /// The reason why a frame was not searched. No pin was written.
    FollowError {
        /// The elapsed time is negative, infinite or not a number.
        ElapsedTime => "the elapsed time is negative, infinite or not a number",
        /// The tracker refused the frame.
        Update(error: UpdateError) => "{error}",
    }

    /// The reason why a command failed: an invalid elapsed time, or the error that one of the three pins returned.
    PursuitError<P, T, L> {
        /// The pan servo's pin failed.
        Pan(error: P) => "the pan servo's pin failed: {error:?}",
        /// The tilt servo's pin failed.
        Tilt(error: T) => "the tilt servo's pin failed: {error:?}",
        /// The indicator's pin failed.
        Indicator(error: L) => "the lock indicator's pin failed: {error:?}",
        /// The elapsed time is negative, infinite or not a number. No pin was written.
        ElapsedTime => "the elapsed time is negative, infinite or not a number",
    }
}

pub(super) fn first_broken<const N: usize>(rules: [(bool, PursuitConfigError); N]) -> Result<(), PursuitConfigError> {
    rules.into_iter().find(|(holds, _)| !holds).map_or(Ok(()), |(_, error)| Err(error))
}
