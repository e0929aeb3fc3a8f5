//! Smooth pursuit: keeps the target centred with a pan/tilt head. Feature `pursuit`.
//!
//! The [`Camera`] turns the tracker's box into an angle, each [`Axis`] turns the angle into a step, and a [`Servo`] turns the
//! step into a pulse. This is the only module that uses floats (f32).
//!
//! ```
//! use smr_core::pursuit::{Axis, Camera, Pursuit, PursuitConfig, Servo};
//! use smr_core::paper::{Config, Radius};
//! use smr_core::{Frame, Image, Paper, Rect, Tracker};
//! # use embedded_hal_mock::eh1::{digital, pwm};
//! # let servo_at = |duty| {
//! #     pwm::Mock::new(&[pwm::Transaction::max_duty_cycle(62_500), pwm::Transaction::set_duty_cycle(duty)])
//! # };
//! # let (pan_pin, tilt_pin) = (servo_at(4748), servo_at(4702));
//! # let led_pin = digital::Mock::new(&[digital::Transaction::set(digital::State::High)]);
//! # let (mut pan_mock, mut tilt_mock, mut led_mock) = (pan_pin.clone(), tilt_pin.clone(), led_pin.clone());
//!
//! // A head that reaches 60 degrees to each side, on two servos, with a camera of 64x48 pixels.
//! let axis = Axis {
//!     min_radians: -1.05,
//!     max_radians: 1.05,
//!     home_radians: 0.0,
//!     gain_per_second: 10.0,
//!     deadband_radians: 0.01,
//!     slew_radians_per_second: 3.0,
//!     return_radians_per_second: 0.5,
//! };
//! let servo =
//!     Servo { pulse_at_min_microseconds: 1000, pulse_at_max_microseconds: 2000, period_microseconds: 20_000 };
//! let config = PursuitConfig {
//!     camera: Camera::centred(64.0, 64, 48),
//!     pan: axis,
//!     pan_servo: servo,
//!     tilt: axis,
//!     tilt_servo: servo,
//!     hold_seconds: 2.0,
//!     delay_frames: 1,
//! };
//! let mut pursuit = Pursuit::new(config, pan_pin, tilt_pin, led_pin)?;
//!
//! let mut config = Config::camera();
//! config.window = Radius { x: 8, y: 8 };
//! config.window_limit = Radius { x: 16, y: 16 };
//! let mut tracker = Tracker::<Paper<256, 33>>::new(config)?;
//! # let pixels: Vec<u8> = (0..64 * 48u32).map(|i| (i * i >> 7) as u8).collect();
//! # let frame = Frame::whole(Image::new(&pixels, 64, 48)?);
//! tracker.lock(&frame, Rect::new(34, 16, 12, 12))?;
//!
//! // In each frame, 1/30 of a second after the last one:
//! let followed = pursuit.follow(&mut tracker, &frame, 1.0 / 30.0)?;
//! assert_eq!(followed.answer.bbox.x, 34);
//! let command = followed.commanded?; // or the error of a pin
//! // The target stands 8 pixels to the right of the middle and 2 above it: a third of the way in this frame.
//! assert!((command.pan_radians - 0.041).abs() < 0.002 && (command.tilt_radians - 0.010).abs() < 0.001);
//! # pan_mock.done();
//! # tilt_mock.done();
//! # led_mock.done();
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod camera;
mod controller;
mod head;

pub use camera::Camera;
pub use controller::Axis;
pub use head::Servo;

use crate::{Answer, Frame, State, Target, Tracker, UpdateError};
use core::fmt;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::pwm::{self, SetDutyCycle};
use head::Joint;

/// All numbers of the pursuit. [`Pursuit::new`] checks them once. See the [module's example](self).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PursuitConfig {
    /// Turns the tracker's boxes into angles.
    pub camera: Camera,
    /// The axis that turns the head left and right.
    pub pan: Axis,
    /// The servo of that axis.
    pub pan_servo: Servo,
    /// The axis that turns the camera up and down.
    pub tilt: Axis,
    /// The servo of that axis.
    pub tilt_servo: Servo,
    /// How long the head stays where it is when the target is lost, before it goes home. `f32::MAX` is for ever.
    pub hold_seconds: f32,
    /// After how many frames a command shows in the picture, 0 to 3: 1 if the next frame is exposed before the servos have
    /// turned. [`Pursuit::follow`] tells the tracker then how far the picture has moved.
    pub delay_frames: u8,
}

impl PursuitConfig {
    fn check(&self) -> Result<(), PursuitConfigError> {
        self.camera.check()?;
        self.pan.check()?;
        self.tilt.check()?;
        self.pan_servo.check()?;
        self.tilt_servo.check()?;
        if !self.hold_seconds.is_finite() {
            return Err(PursuitConfigError::NotFinite);
        }
        if self.hold_seconds < 0.0 {
            return Err(PursuitConfigError::Negative);
        }
        if usize::from(self.delay_frames) >= TURNS {
            return Err(PursuitConfigError::DelayTooLong);
        }
        Ok(())
    }
}

/// Commands that can be on their way: the present one and those of the longest delay before.
const TURNS: usize = 4;

/// Where the head was last told to look, to the right and up from where both servos are at 0 radians.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Command {
    /// The pan angle.
    pub pan_radians: f32,
    /// The tilt angle.
    pub tilt_radians: f32,
}

/// The command that was given, or the error of the first of these pins that failed.
pub type Commanded<P, T, L> = Result<
    Command,
    PursuitError<<P as pwm::ErrorType>::Error, <T as pwm::ErrorType>::Error, <L as digital::ErrorType>::Error>,
>;

/// What was found in a frame, and what was done about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Followed<C> {
    /// The tracker's answer.
    pub answer: Answer,
    /// The command that was given, or the first error of a pin: see [`Pursuit::steer`].
    pub commanded: C,
}

/// Keeps the target centred: owns the pins of the pan servo, of the tilt servo and of the lock indicator.
///
/// See the [module's example](self).
pub struct Pursuit<P, T, L> {
    camera: Camera,
    pan: Joint<P>,
    tilt: Joint<T>,
    indicator: L,
    hold_seconds: f32,
    /// How long no target has been seen.
    lost_seconds: f32,
    /// By how much the last commands turned the head, the last one first, to the right and up.
    turns: [(f32, f32); TURNS],
    delay_frames: u8,
}

impl<P: SetDutyCycle, T: SetDutyCycle, L: OutputPin> Pursuit<P, T, L> {
    /// A pursuit whose head is to be at home. No pin is touched before the first [`Pursuit::follow`], [`Pursuit::steer`] or
    /// [`Pursuit::wait`].
    /// Where the servos stand is not known, so they go to their first angle as fast as they can.
    ///
    /// # Errors
    /// [`PursuitConfigError`], if a number of the configuration cannot be used.
    pub fn new(config: PursuitConfig, pan: P, tilt: T, indicator: L) -> Result<Self, PursuitConfigError> {
        config.check()?;
        Ok(Self {
            camera: config.camera,
            pan: Joint::new(config.pan, config.pan_servo, pan),
            tilt: Joint::new(config.tilt, config.tilt_servo, tilt),
            indicator,
            hold_seconds: config.hold_seconds,
            lost_seconds: 0.0,
            turns: [(0.0, 0.0); TURNS],
            delay_frames: config.delay_frames,
        })
    }

    /// What there is to do in a frame, `elapsed_seconds` after the last one: finds the target, steers by the answer, and tells
    /// the tracker how far the picture moves because the head turns.
    ///
    /// If a pin fails, the answer is still there, beside the error, and the tracker is told of the turn that the others have made.
    ///
    /// # Errors
    /// [`FollowError`]; no pin was touched then, and the tracker is as it was before.
    pub fn follow<F: Target>(
        &mut self,
        tracker: &mut Tracker<F>,
        frame: &Frame<'_>,
        elapsed_seconds: f32,
    ) -> Result<Followed<Commanded<P, T, L>>, FollowError> {
        if !can_elapse(elapsed_seconds) {
            return Err(FollowError::ElapsedTime);
        }
        let answer = tracker.update(frame).map_err(FollowError::Update)?;
        let commanded = self.steer(&answer, elapsed_seconds);
        let (right, down) = self.picture_motion();
        tracker.moved(right, down);
        Ok(Followed { answer, commanded })
    }

    /// Steers by the tracker's answer to a frame, `elapsed_seconds` after the last call. For those who update the tracker
    /// themselves, in steps for example; they tell it of [`Pursuit::picture_motion`], too.
    ///
    /// While the target is not lost, the head turns to bring the middle of the box onto the optical axis. When it is lost, this
    /// is [`Pursuit::wait`]. The indicator is on while the state is tracking or leaving. A target that is found again is
    /// followed at once.
    ///
    /// # Errors
    /// [`PursuitError`]. If a pin fails, the others are still written; the first error is the one returned. The axis
    /// whose pin failed is taken to be where it was.
    pub fn steer(&mut self, answer: &Answer, elapsed_seconds: f32) -> Commanded<P, T, L> {
        if answer.state == State::Lost {
            return self.wait(elapsed_seconds);
        }
        check_elapsed(elapsed_seconds)?;
        self.lost_seconds = 0.0;
        let (right, up) = self.camera.error_radians(answer.fine);
        let pan = self.pan.axis.toward(self.pan.radians, right, elapsed_seconds);
        let tilt = self.tilt.axis.toward(self.tilt.radians, up, elapsed_seconds);
        self.turn_to(pan, tilt, answer.state != State::Uncertain)
    }

    /// What to do in a frame without a target, lost or not yet locked on: the indicator is off, the head stays where it
    /// is for the configured time and then goes home.
    ///
    /// ```
    /// # use embedded_hal_mock::eh1::{digital, pwm};
    /// # use smr_core::pursuit::{Axis, Camera, Pursuit, PursuitConfig, Servo};
    /// # let pin = || pwm::Mock::new(&[pwm::Transaction::max_duty_cycle(20_000), pwm::Transaction::set_duty_cycle(1500)]);
    /// # let (pan, tilt) = (pin(), pin());
    /// # let led = digital::Mock::new(&[digital::Transaction::set(digital::State::Low)]);
    /// # let (mut pan_mock, mut tilt_mock, mut led_mock) = (pan.clone(), tilt.clone(), led.clone());
    /// # let axis = Axis { min_radians: -1.0, max_radians: 1.0, home_radians: 0.0, gain_per_second: 1.0,
    /// #     deadband_radians: 0.0, slew_radians_per_second: 1.0, return_radians_per_second: 1.0 };
    /// # let servo = Servo { pulse_at_min_microseconds: 1000, pulse_at_max_microseconds: 2000, period_microseconds: 20_000 };
    /// # let config = PursuitConfig { camera: Camera::centred(100.0, 160, 120), pan: axis, tilt: axis,
    /// #     pan_servo: servo, tilt_servo: servo, hold_seconds: 1.0, delay_frames: 0 };
    /// let mut pursuit = Pursuit::new(config, pan, tilt, led)?;
    /// let command = pursuit.wait(0.0)?; // the first pulses: the head goes home
    /// assert_eq!((command.pan_radians, command.tilt_radians), (0.0, 0.0));
    /// # (pan_mock.done(), tilt_mock.done(), led_mock.done());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Pursuit::steer`].
    pub fn wait(&mut self, elapsed_seconds: f32) -> Commanded<P, T, L> {
        check_elapsed(elapsed_seconds)?;
        self.lost_seconds = (self.lost_seconds + elapsed_seconds).min(f32::MAX);
        // Of this step, only what lies beyond the hold is spent on the way home.
        let homeward_seconds = (self.lost_seconds - self.hold_seconds).max(0.0).min(elapsed_seconds);
        let pan = self.pan.axis.homeward(self.pan.radians, homeward_seconds);
        let tilt = self.tilt.axis.homeward(self.tilt.radians, homeward_seconds);
        self.turn_to(pan, tilt, false)
    }

    /// How far the picture moves until the next frame because the head turns, to the right and down, in units of 1/256 pixel: for
    /// [`Target::moved`]. It is that of the command [`PursuitConfig::delay_frames`] before the last one.
    #[must_use]
    pub fn picture_motion(&self) -> (i32, i32) {
        let (right, up) = self.turns.get(usize::from(self.delay_frames)).copied().unwrap_or_default();
        self.camera.picture_motion(right, up)
    }

    /// Where the head was last told to look; home before the first call.
    #[must_use]
    pub const fn command(&self) -> Command {
        Command { pan_radians: self.pan.radians, tilt_radians: self.tilt.radians }
    }

    /// Gives the pins back: pan, tilt, indicator.
    pub fn release(self) -> (P, T, L) {
        (self.pan.pin, self.tilt.pin, self.indicator)
    }

    fn turn_to(&mut self, pan_radians: f32, tilt_radians: f32, locked: bool) -> Commanded<P, T, L> {
        let before = self.command();
        let pan = self.pan.turn_to(pan_radians).map_err(PursuitError::Pan);
        let tilt = self.tilt.turn_to(tilt_radians).map_err(PursuitError::Tilt);
        let indicator = self.indicator.set_state(locked.into()).map_err(PursuitError::Indicator);
        let after = self.command();
        self.turns.rotate_right(1);
        let [last, ..] = &mut self.turns;
        *last = (after.pan_radians - before.pan_radians, after.tilt_radians - before.tilt_radians);
        pan.and(tilt).and(indicator)?;
        Ok(after)
    }
}

/// A time that is negative or not a number must not get into an angle.
fn can_elapse(elapsed_seconds: f32) -> bool {
    elapsed_seconds.is_finite() && elapsed_seconds >= 0.0
}

fn check_elapsed<P, T, L>(elapsed_seconds: f32) -> Result<(), PursuitError<P, T, L>> {
    if can_elapse(elapsed_seconds) { Ok(()) } else { Err(PursuitError::ElapsedTime) }
}

/// Why a [`PursuitConfig`] cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PursuitConfigError {
    /// A number is infinite or not a number (NaN).
    NotFinite,
    /// The focal length is less than a pixel.
    FocalLengthTooShort,
    /// The gain, the slew rate or the speed of the way home is not more than 0.
    RateNotPositive,
    /// The deadband or the time to hold is less than 0.
    Negative,
    /// The minimum of an axis is not less than its maximum.
    LimitsReversed,
    /// A limit is more than one turn away from 0: it may be in degrees.
    LimitsBeyondOneTurn,
    /// The home of an axis is not between its limits.
    HomeOutsideLimits,
    /// A pulse is not shorter than the period.
    PulseNotInPeriod,
    /// The pulses at both limits are the same.
    PulsesEqual,
    /// A command shows in the picture after more than 3 frames.
    DelayTooLong,
}

impl fmt::Display for PursuitConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "a number of the configuration is infinite or not a number",
            Self::FocalLengthTooShort => "the focal length must be at least one pixel",
            Self::RateNotPositive => "gain, slew rate and the speed of the way home must be more than 0",
            Self::Negative => "the deadband and the time to hold must not be negative",
            Self::LimitsReversed => "the minimum of an axis must be less than its maximum",
            Self::LimitsBeyondOneTurn => "the limits of an axis must be within one turn: they are in radians",
            Self::HomeOutsideLimits => "the home of an axis must lie between its limits",
            Self::PulseNotInPeriod => "the pulses of a servo must be shorter than its period",
            Self::PulsesEqual => "the pulses of a servo at its two limits must differ",
            Self::DelayTooLong => "a command must show in the picture after 3 frames at most",
        })
    }
}

impl core::error::Error for PursuitConfigError {}

/// Why a frame was not looked at. No pin was touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FollowError {
    /// The elapsed time is negative, infinite or not a number.
    ElapsedTime,
    /// The frame could not be searched.
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

/// Why the head was not turned: the errors of the pan pin, the tilt pin and the indicator's pin, as they came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PursuitError<P, T, L> {
    /// The pan servo's pin failed.
    Pan(P),
    /// The tilt servo's pin failed.
    Tilt(T),
    /// The indicator's pin failed.
    Indicator(L),
    /// The elapsed time is negative, infinite or not a number. No pin was touched.
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

#[cfg(test)]
mod tests;
