//! An axis of the head: computes the next angle from the error, and the servo's PWM duty from the angle.

use super::error::{PursuitConfigError, first_broken};
use core::f32::consts::TAU;
use embedded_hal::pwm::SetDutyCycle;

/// One axis of the head, with a proportional controller. Right (pan) and up (tilt) are positive, seen from the camera.
///
/// angle += clamp(gain * error, -slew, slew) * elapsed, at most |error|, within the limits. A target at constant speed
/// is followed at a constant distance of speed / gain.
///
/// With one frame of delay, gain * frame time must stay well below 1, or the head oscillates. Start with 1/3.
///
/// A later version may add fields; [`Axis::new`] gives all of them values.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Axis {
    /// The smallest angle (leftmost or lowest), at least -2 pi.
    pub min_radians: f32,
    /// The largest angle (rightmost or highest), at most 2 pi.
    pub max_radians: f32,
    /// The angle at the start. The axis returns to it when the target stays lost.
    pub home_radians: f32,
    /// Speed per error, in 1/s; more than 0. A gain of 10 turns the axis by 1/3 of the error per frame at 30 frames/s.
    pub gain_per_second: f32,
    /// The axis holds still up to this error; at least 0. One pixel of error is 1 / (focal length in pixels) radians.
    pub deadband_radians: f32,
    /// The largest speed; more than 0. Choose one that the servo can follow under its load.
    pub slew_radians_per_second: f32,
    /// The speed of the return home; more than 0, limited by the slew rate.
    pub return_radians_per_second: f32,
}

impl Axis {
    /// An axis that turns from `min_radians` to `max_radians`, with values for a start: home at 0 (or the limit next to
    /// it), a gain of 10 per second, a deadband of 0.006 radians, a slew rate of 3 and a return at 0.5 radians per
    /// second. [`Pursuit::new`](super::Pursuit::new) checks the limits.
    ///
    /// ```
    /// use smr_core::pursuit::Axis;
    /// let mut pan = Axis::new(-1.05, 1.05); // 60 degrees to each side
    /// pan.gain_per_second = 3.0;
    /// assert_eq!((pan.home_radians, pan.slew_radians_per_second), (0.0, 3.0));
    /// assert_eq!(Axis::new(0.2, 1.05).home_radians, 0.2);
    /// ```
    #[must_use]
    pub const fn new(min_radians: f32, max_radians: f32) -> Self {
        Self {
            min_radians,
            max_radians,
            // Not `clamp`: that can panic.
            home_radians: 0.0_f32.max(min_radians).min(max_radians),
            gain_per_second: 10.0,
            deadband_radians: 0.006,
            slew_radians_per_second: 3.0,
            return_radians_per_second: 0.5,
        }
    }

    /// The next angle after `from_radians`, with the target at `error_radians` from the optical axis.
    pub(super) fn toward(&self, from_radians: f32, error_radians: f32, elapsed_seconds: f32) -> f32 {
        if error_radians.abs() <= self.deadband_radians {
            return from_radians;
        }
        let speed = clamp_abs(self.gain_per_second * error_radians, self.slew_radians_per_second);
        // The turn never exceeds the error, so a late frame causes no overshoot.
        let step = clamp_abs(speed * elapsed_seconds, error_radians.abs());
        self.limited(from_radians + step)
    }

    pub(super) fn homeward(&self, from_radians: f32, elapsed_seconds: f32) -> f32 {
        let speed = self.return_radians_per_second.min(self.slew_radians_per_second);
        self.limited(from_radians + clamp_abs(self.home_radians - from_radians, speed * elapsed_seconds))
    }

    fn limited(&self, radians: f32) -> f32 {
        // Not `clamp`: that can panic.
        radians.max(self.min_radians).min(self.max_radians)
    }

    pub(super) fn check(&self) -> Result<(), PursuitConfigError> {
        use PursuitConfigError::*;
        let rates = [self.gain_per_second, self.slew_radians_per_second, self.return_radians_per_second];
        let (min, max, home) = (self.min_radians, self.max_radians, self.home_radians);
        first_broken([
            (rates.iter().chain(&[min, max, home, self.deadband_radians]).all(|number| number.is_finite()), NotFinite),
            (rates.iter().all(|&rate| rate > 0.0), RateNotPositive),
            (self.deadband_radians >= 0.0, Negative),
            (min < max, LimitsReversed),
            (-TAU <= min && max <= TAU, LimitsBeyondOneTurn),
            (min <= home && home <= max, HomeOutsideLimits),
        ])
    }
}

fn clamp_abs(value: f32, bound: f32) -> f32 {
    value.max(-bound).min(bound)
}

/// The pulses of a hobby servo, in microseconds. Measure them once for your servo and its linkage. If the servo is
/// mounted reversed, the pulse at the minimum of the axis is the longer one. The resolution is that of the pin's timer:
/// at a period of 20,000 microseconds, a 16-bit duty resolves 0.3 microseconds, and an 8-bit duty 78 microseconds (7
/// degrees, if 1000 microseconds turn the servo by 90 degrees).
///
/// A later version may add fields; [`Servo::new`] gives all of them values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Servo {
    /// The pulse for `min_radians` of the axis.
    pub pulse_at_min_microseconds: u16,
    /// The pulse for `max_radians` of the axis.
    pub pulse_at_max_microseconds: u16,
    /// The period that the PWM pin is set to, usually 20,000 (50 Hz); longer than both pulses.
    pub period_microseconds: u16,
}

impl Servo {
    /// A servo with these pulses at the limits of its axis, in microseconds, and a period of 20,000 microseconds.
    ///
    /// ```
    /// let servo = smr_core::pursuit::Servo::new(900, 2100);
    /// assert_eq!(servo.period_microseconds, 20_000);
    /// ```
    #[must_use]
    pub const fn new(pulse_at_min_microseconds: u16, pulse_at_max_microseconds: u16) -> Self {
        Self { pulse_at_min_microseconds, pulse_at_max_microseconds, period_microseconds: 20_000 }
    }

    pub(super) fn duty(&self, axis: &Axis, radians: f32, max_duty: u16) -> u16 {
        let along = (radians - axis.min_radians) / (axis.max_radians - axis.min_radians);
        let [at_min, at_max, period, max_duty] =
            [self.pulse_at_min_microseconds, self.pulse_at_max_microseconds, self.period_microseconds, max_duty]
                .map(f32::from);
        round_to_u16((at_min + along * (at_max - at_min)) / period * max_duty)
    }

    pub(super) fn check(&self) -> Result<(), PursuitConfigError> {
        let (at_min, at_max) = (self.pulse_at_min_microseconds, self.pulse_at_max_microseconds);
        first_broken([
            (at_min.max(at_max) < self.period_microseconds, PursuitConfigError::PulseNotInPeriod),
            (at_min != at_max, PursuitConfigError::PulsesEqual),
        ])
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
fn round_to_u16(value: f32) -> u16 {
    (value + 0.5) as u16
}

/// One axis of the head: its controller, its servo and the commanded angle.
pub(super) struct Joint<P> {
    pub(super) axis: Axis,
    servo: Servo,
    pub(super) pin: P,
    pub(super) radians: f32,
}

impl<P: SetDutyCycle> Joint<P> {
    pub(super) fn new(axis: Axis, servo: Servo, pin: P) -> Self {
        Self { axis, servo, pin, radians: axis.home_radians }
    }

    /// Writes the pulse for `radians`. If the pin fails, the stored angle is kept, and the next turn starts from it.
    pub(super) fn turn_to(&mut self, radians: f32) -> Result<(), P::Error> {
        let duty = self.servo.duty(&self.axis, radians, self.pin.max_duty_cycle());
        self.pin.set_duty_cycle(duty)?;
        self.radians = radians;
        Ok(())
    }
}
