//! The servos of the pan/tilt head: from angles to PWM duties.

use super::controller::Axis;
use super::error::PursuitConfigError;
use embedded_hal::pwm::SetDutyCycle;

/// The pulses of a hobby servo in microseconds. Measure them once for your servo and its linkage.
///
/// If the servo is mounted the other way round, the pulse at the minimum is the longer one. The resolution is that of
/// the pin's timer: at a period of 20,000 microseconds a 16-bit duty resolves 0.3 microseconds, an 8-bit duty 78 (7
/// degrees).
///
/// ```
/// use smr_core::pursuit::Servo;
/// let pan = Servo {
///     pulse_at_min_microseconds: 1000,
///     pulse_at_max_microseconds: 2000,
///     period_microseconds: 20_000, // 50 Hz
/// };
/// # let _ = pan;
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Servo {
    /// The pulse for `min_radians` of the axis.
    pub pulse_at_min_microseconds: u16,
    /// The pulse for `max_radians` of the axis.
    pub pulse_at_max_microseconds: u16,
    /// The period that the PWM pin is set to; longer than both pulses.
    pub period_microseconds: u16,
}

impl Servo {
    /// The duty (0 to `max_duty`) for the angle `radians` of `axis`.
    fn duty(&self, axis: &Axis, radians: f32, max_duty: u16) -> u16 {
        let along = (radians - axis.min_radians) / (axis.max_radians - axis.min_radians);
        let [at_min, at_max, period, max_duty] =
            [self.pulse_at_min_microseconds, self.pulse_at_max_microseconds, self.period_microseconds, max_duty]
                .map(f32::from);
        nearest((at_min + along * (at_max - at_min)) / period * max_duty)
    }

    pub(super) fn check(&self) -> Result<(), PursuitConfigError> {
        let longest = self.pulse_at_min_microseconds.max(self.pulse_at_max_microseconds);
        if longest >= self.period_microseconds {
            return Err(PursuitConfigError::PulseNotInPeriod);
        }
        if self.pulse_at_min_microseconds == self.pulse_at_max_microseconds {
            return Err(PursuitConfigError::PulsesEqual);
        }
        Ok(())
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
fn nearest(value: f32) -> u16 {
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

    /// Writes the pulse for `radians`. If the pin fails, the axis keeps its last angle, so that the next step is not
    /// larger.
    pub(super) fn turn_to(&mut self, radians: f32) -> Result<(), P::Error> {
        let duty = self.servo.duty(&self.axis, radians, self.pin.max_duty_cycle());
        self.pin.set_duty_cycle(duty)?;
        self.radians = radians;
        Ok(())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::pursuit::controller::tests::{PAN, any_axis};
    use proptest::prelude::*;

    pub(in crate::pursuit) const SERVO: Servo = servo(1000, 2000, 20_000);

    pub(in crate::pursuit) const fn servo(at_min: u16, at_max: u16, period: u16) -> Servo {
        Servo { pulse_at_min_microseconds: at_min, pulse_at_max_microseconds: at_max, period_microseconds: period }
    }

    #[test]
    fn the_ends_and_the_middle_are_exact() {
        for (servo, duties) in [(SERVO, [1000, 1250, 1500, 2000]), (servo(2400, 600, 20_000), [2400, 1950, 1500, 600])]
        {
            assert_eq!([-1.0, -0.5, 0.0, 1.0].map(|radians| servo.duty(&PAN, radians, 20_000)), duties);
        }
    }

    #[test]
    fn a_duty_is_rounded_to_the_nearest() {
        assert_eq!(SERVO.duty(&PAN, -1.0, 65_535), 3277); // 3276.75
        assert_eq!(SERVO.duty(&PAN, 1.0, 255), 26); // 25.5
        assert_eq!(SERVO.duty(&PAN, -1.0, 255), 13); // 12.75
        assert_eq!(SERVO.duty(&PAN, 1.0, 0), 0);
    }

    proptest! {
        #[test]
        fn no_duty_is_outside_the_pulses(
            axis in any_axis(),
            along in 0.0..=1.0f32,
            (at_min, at_max, period, max_duty) in any::<(u16, u16, u16, u16)>(),
        ) {
            let servo = servo(at_min, at_max, period);
            prop_assume!(servo.check().is_ok());
            let radians = (axis.min_radians + along * (axis.max_radians - axis.min_radians)).min(axis.max_radians);
            let duty = f64::from(servo.duty(&axis, radians, max_duty));
            let exact = |pulse: u16| f64::from(pulse) / f64::from(period) * f64::from(max_duty);
            let (least, most) = (exact(at_min.min(at_max)), exact(at_min.max(at_max)));
            prop_assert!(duty > least - 0.52 && duty < most + 0.52, "{} of {}..{}", duty, least, most);
        }
    }
}
