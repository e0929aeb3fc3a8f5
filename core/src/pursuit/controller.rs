//! The controller of one axis: from the commanded angle and the error to the next angle.

use super::error::PursuitConfigError;
use core::f32::consts::TAU;

/// The motion of one axis of the head: a proportional controller. Right (pan) and up (tilt) are positive, as the camera
/// sees it.
///
/// angle += clamp(gain * error, -slew, slew) * elapsed, at most |error|, within the limits. A target at constant speed
/// is followed at a constant distance of speed / gain.
///
/// With one frame of delay, gain * frame time must stay well below 1, or the head oscillates. Start with 1/3.
///
/// ```
/// use smr_core::pursuit::Axis;
/// let pan = Axis {
///     min_radians: -1.2,
///     max_radians: 1.2,
///     home_radians: 0.0,
///     gain_per_second: 10.0, // 1/3 of the error per frame at 30 frames per second
///     deadband_radians: 0.006, // one pixel at a focal length of 160 pixels
///     slew_radians_per_second: 3.0,
///     return_radians_per_second: 0.5,
/// };
/// # let _ = pan;
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Axis {
    /// The smallest angle (leftmost or lowest), at least -2 pi.
    pub min_radians: f32,
    /// The largest angle (rightmost or highest), at most 2 pi.
    pub max_radians: f32,
    /// The angle at the start. The axis returns to it when the target stays lost.
    pub home_radians: f32,
    /// Speed per error, in radians per second per radian; more than 0.
    pub gain_per_second: f32,
    /// Errors up to this are ignored: the axis holds still; at least 0.
    pub deadband_radians: f32,
    /// The largest speed; more than 0. Choose one that the servo can follow under its load.
    pub slew_radians_per_second: f32,
    /// The speed of the return home; more than 0, limited by the slew rate.
    pub return_radians_per_second: f32,
}

impl Axis {
    /// The next angle after `from_radians`, with the target at `error_radians` from the optical axis.
    pub(super) fn toward(&self, from_radians: f32, error_radians: f32, elapsed_seconds: f32) -> f32 {
        if error_radians.abs() <= self.deadband_radians {
            return from_radians;
        }
        let speed = within(self.gain_per_second * error_radians, self.slew_radians_per_second);
        // A late frame must not overshoot.
        let step = within(speed * elapsed_seconds, error_radians.abs());
        self.limited(from_radians + step)
    }

    /// The next angle after `from_radians` on the way home.
    pub(super) fn homeward(&self, from_radians: f32, elapsed_seconds: f32) -> f32 {
        let speed = self.return_radians_per_second.min(self.slew_radians_per_second);
        self.limited(from_radians + within(self.home_radians - from_radians, speed * elapsed_seconds))
    }

    fn limited(&self, radians: f32) -> f32 {
        // Not `clamp`: that can panic.
        radians.max(self.min_radians).min(self.max_radians)
    }

    pub(super) fn check(&self) -> Result<(), PursuitConfigError> {
        let positive = [self.gain_per_second, self.slew_radians_per_second, self.return_radians_per_second];
        let angles = [self.min_radians, self.max_radians, self.home_radians];
        let mut numbers = positive.iter().chain(&angles).chain([&self.deadband_radians]);
        if !numbers.all(|number| number.is_finite()) {
            return Err(PursuitConfigError::NotFinite);
        }
        if positive.iter().any(|&rate| rate <= 0.0) {
            return Err(PursuitConfigError::RateNotPositive);
        }
        if self.deadband_radians < 0.0 {
            return Err(PursuitConfigError::Negative);
        }
        if self.min_radians >= self.max_radians {
            return Err(PursuitConfigError::LimitsReversed);
        }
        if self.min_radians < -TAU || self.max_radians > TAU {
            return Err(PursuitConfigError::LimitsBeyondOneTurn);
        }
        if self.home_radians < self.min_radians || self.home_radians > self.max_radians {
            return Err(PursuitConfigError::HomeOutsideLimits);
        }
        Ok(())
    }
}

/// `value`, clamped to -bound..=bound.
fn within(value: f32, bound: f32) -> f32 {
    value.max(-bound).min(bound)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    pub(in crate::pursuit) const PAN: Axis = Axis {
        min_radians: -1.0,
        max_radians: 1.0,
        home_radians: 0.25,
        gain_per_second: 10.0,
        deadband_radians: 0.01,
        slew_radians_per_second: 2.0,
        return_radians_per_second: 0.5,
    };

    #[test]
    fn steps_are_exact() {
        for (from, error, to) in [(0.0, 0.1, 0.03125), (0.5, -0.1, 0.46875)] {
            assert!((PAN.toward(from, error, 0.03125) - to).abs() < 1e-6, "the gain times the error");
        }
        let patient = Axis { slew_radians_per_second: 100.0, ..PAN };
        assert_eq!(patient.toward(0.5, 0.125, 10.0), 0.625, "a late frame does not overshoot");
        let slow = Axis { slew_radians_per_second: 0.25, ..PAN };
        let home = [(PAN, 0.75, 0.5, 0.5), (PAN, 0.5, 0.75, 0.25), (PAN, -0.25, 0.5, 0.0), (PAN, 0.25, 5.0, 0.25)];
        for (axis, from, seconds, to) in home.into_iter().chain([(slow, 0.75, 0.5, 0.625)]) {
            assert_eq!(axis.homeward(from, seconds), to, "the way home ends there");
        }
    }

    /// Axes with ordinary and extreme numbers; some products overflow.
    pub(in crate::pursuit) fn any_axis() -> impl Strategy<Value = Axis> {
        let rate = || prop_oneof![0.01..50.0f32, Just(f32::MIN_POSITIVE), Just(f32::MAX)];
        let deadband = prop_oneof![Just(0.0), 0.0..0.2f32, Just(f32::MAX)];
        (-6.2..6.2f32, 0.001..3.0f32, 0.0..=1.0f32, rate(), deadband, rate(), rate()).prop_map(
            |(min, span, home, gain, deadband, slew, back)| {
                let max = (min + span).min(TAU);
                Axis {
                    min_radians: min,
                    max_radians: max,
                    home_radians: (min + home * (max - min)).min(max),
                    gain_per_second: gain,
                    deadband_radians: deadband,
                    slew_radians_per_second: slew,
                    return_radians_per_second: back,
                }
            },
        )
    }

    fn any_seconds() -> impl Strategy<Value = f32> {
        prop_oneof![0.0..0.2f32, Just(0.0), Just(f32::MIN_POSITIVE), Just(f32::MAX)]
    }

    proptest! {
        #[test]
        fn limits_and_slew_rate_are_never_exceeded(
            axis in any_axis(),
            frames in prop::collection::vec((-1.58..1.58f32, any_seconds(), any::<bool>()), 1..50),
        ) {
            prop_assert_eq!(axis.check(), Ok(()));
            let mut angle = axis.home_radians;
            for (error, elapsed, found) in frames {
                let next = if found { axis.toward(angle, error, elapsed) } else { axis.homeward(angle, elapsed) };
                prop_assert!(next >= axis.min_radians && next <= axis.max_radians, "{}", next);
                let slewed = axis.slew_radians_per_second * elapsed;
                prop_assert!((next - angle).abs() <= slewed + 1e-6, "{} to {}", angle, next);
                angle = next;
            }
        }

        #[test]
        fn the_deadband_holds_still(axis in any_axis(), along in -1.0..=1.0f32, elapsed in any_seconds()) {
            let error = within(along * axis.deadband_radians, 1.58);
            prop_assert_eq!(axis.toward(axis.home_radians, error, elapsed), axis.home_radians);
        }

        #[test]
        fn no_step_goes_past_the_target(axis in any_axis(), error in -1.58..1.58f32, elapsed in any_seconds()) {
            let step = axis.toward(axis.home_radians, error, elapsed) - axis.home_radians;
            prop_assert!(step * error >= 0.0 && step.abs() <= error.abs() + 1e-6);
        }
    }
}
