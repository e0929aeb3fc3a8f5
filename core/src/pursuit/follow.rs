//! The pursuit frame by frame, from the tracker's answer to the servos' pulses, and its configuration.

use super::axis::{Axis, Joint, Servo};
use super::camera::Camera;
use super::error::{FollowError, PursuitConfigError, PursuitError, first_broken};
use crate::image::Frame;
use crate::track::{Answer, State, Target, Tracker};
use core::fmt;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::pwm::{self, SetDutyCycle};

/// The number of stored turns of the head: the latest and the 3 before it, because the longest delay is 3 frames.
const TURNS: usize = 4;

/// The configuration of a [`Pursuit`]. The [module](super) has an example.
///
/// A later version may add fields; [`PursuitConfig::new`] gives all of them values.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct PursuitConfig {
    /// The camera model, which converts boxes to angles.
    pub camera: Camera,
    /// The axis that turns the head left and right.
    pub pan: Axis,
    /// The servo of the pan axis.
    pub pan_servo: Servo,
    /// The axis that turns the camera up and down.
    pub tilt: Axis,
    /// The servo of the tilt axis.
    pub tilt_servo: Servo,
    /// The time for which the head holds still after the target is lost, before it turns home. `f32::MAX`: never.
    pub hold_seconds: f32,
    /// The number of frames after a command, 0 to 3, that do not show its effect yet: 1 if the next frame is exposed
    /// before the servos have turned. [`Pursuit::follow`] tells the tracker of each motion that many frames later.
    pub delay_frames: u8,
}

impl PursuitConfig {
    /// A head of two axes, each with its servo, that holds still for 2 seconds after the target is lost. A command takes
    /// effect one frame late. [`Pursuit::new`] checks all values.
    #[must_use]
    pub const fn new(camera: Camera, (pan, pan_servo): (Axis, Servo), (tilt, tilt_servo): (Axis, Servo)) -> Self {
        Self { camera, pan, pan_servo, tilt, tilt_servo, hold_seconds: 2.0, delay_frames: 1 }
    }

    fn check(&self) -> Result<(), PursuitConfigError> {
        self.camera.check()?;
        self.pan.check()?;
        self.tilt.check()?;
        self.pan_servo.check()?;
        self.tilt_servo.check()?;
        first_broken([
            (self.hold_seconds.is_finite(), PursuitConfigError::NotFinite),
            (self.hold_seconds >= 0.0, PursuitConfigError::Negative),
            (usize::from(self.delay_frames) < TURNS, PursuitConfigError::DelayTooLong),
        ])
    }
}

/// The angles that the head was last commanded to, in the coordinates of [`Axis`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Command {
    /// Pan angle; right is positive.
    pub pan_radians: f32,
    /// Tilt angle; up is positive.
    pub tilt_radians: f32,
}

/// The command that was written to the pins, or the error of the first pin that failed.
pub type Commanded<P, T, L> = Result<
    Command,
    PursuitError<<P as pwm::ErrorType>::Error, <T as pwm::ErrorType>::Error, <L as digital::ErrorType>::Error>,
>;

/// The result of [`Pursuit::follow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Followed<C> {
    /// The tracker's answer.
    pub answer: Answer,
    /// The command that was written, or the first error of a pin: see [`Pursuit::steer`].
    pub commanded: C,
}

/// Keeps the target centred, by the pins of a pan servo, a tilt servo and a lock indicator. See the [module](super).
pub struct Pursuit<P, T, L> {
    camera: Camera,
    pub(super) pan: Joint<P>,
    pub(super) tilt: Joint<T>,
    pub(super) indicator: L,
    hold_seconds: f32,
    lost_seconds: f32,
    /// The latest turns of the head, right and up, in radians; the most recent one first.
    turns: [(f32, f32); TURNS],
    delay_frames: u8,
}

impl<P, T, L> Pursuit<P, T, L> {
    /// The angles that the head was last commanded to, or its home angles before the first command.
    #[must_use]
    pub const fn command(&self) -> Command {
        Command { pan_radians: self.pan.radians, tilt_radians: self.tilt.radians }
    }
}

impl<P, T, L> fmt::Debug for Pursuit<P, T, L> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pursuit").field("command", &self.command()).finish_non_exhaustive()
    }
}

impl<P: SetDutyCycle, T: SetDutyCycle, L: OutputPin> Pursuit<P, T, L> {
    /// A pursuit that assumes the head at home. The servos' true positions are unknown, so at the first call of
    /// [`Pursuit::follow`], [`Pursuit::steer`] or [`Pursuit::wait`] they turn at full speed, not the slew rate.
    ///
    /// # Errors
    /// [`PursuitConfigError`] if a value of the configuration is invalid.
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

    /// Updates the tracker with a frame taken `elapsed_seconds` after the last one, steers by the answer, and tells the
    /// tracker how the turn moves the picture. If a pin fails, the result contains both the answer and the error.
    ///
    /// # Errors
    /// [`FollowError`]. No pin was written then, and the tracker is unchanged.
    pub fn follow<F: Target>(
        &mut self,
        tracker: &mut Tracker<F>,
        frame: &Frame<'_>,
        elapsed_seconds: f32,
    ) -> Result<Followed<Commanded<P, T, L>>, FollowError> {
        check_elapsed(elapsed_seconds, FollowError::ElapsedTime)?;
        let answer = tracker.update(frame).map_err(FollowError::Update)?;
        let commanded = self.steer(&answer, elapsed_seconds);
        let (right, down) = self.picture_motion();
        tracker.moved(right, down);
        Ok(Followed { answer, commanded })
    }

    /// Steers by an answer of the tracker; `elapsed_seconds` is the time since the last call. For programs that update
    /// the tracker themselves, for example in steps. They must also pass [`Pursuit::picture_motion`] to the tracker.
    ///
    /// Turns the head to bring the centre of the box onto the optical axis, or if the target is lost as in
    /// [`Pursuit::wait`]. The indicator is on in the states tracking and leaving.
    ///
    /// # Errors
    /// [`PursuitError`]: the first error of a pin, whose axis keeps its angle. The other pins are still written.
    pub fn steer(&mut self, answer: &Answer, elapsed_seconds: f32) -> Commanded<P, T, L> {
        if answer.state == State::Lost {
            return self.wait(elapsed_seconds);
        }
        check_elapsed(elapsed_seconds, PursuitError::ElapsedTime)?;
        self.lost_seconds = 0.0;
        let (right, up) = self.camera.error_radians(answer.fine);
        let pan = self.pan.axis.toward(self.pan.radians, right, elapsed_seconds);
        let tilt = self.tilt.axis.toward(self.tilt.radians, up, elapsed_seconds);
        self.turn_to(pan, tilt, answer.state != State::Uncertain)
    }

    /// Steers without a target (lost, or not locked yet): turns the indicator off, holds the head for
    /// [`PursuitConfig::hold_seconds`], then turns it home.
    ///
    /// # Errors
    /// As [`Pursuit::steer`].
    pub fn wait(&mut self, elapsed_seconds: f32) -> Commanded<P, T, L> {
        check_elapsed(elapsed_seconds, PursuitError::ElapsedTime)?;
        self.lost_seconds = (self.lost_seconds + elapsed_seconds).min(f32::MAX);
        // The part of the elapsed time after the end of the hold.
        let homeward_seconds = (self.lost_seconds - self.hold_seconds).max(0.0).min(elapsed_seconds);
        let pan = self.pan.axis.homeward(self.pan.radians, homeward_seconds);
        let tilt = self.tilt.axis.homeward(self.tilt.radians, homeward_seconds);
        self.turn_to(pan, tilt, false)
    }

    /// The expected motion of the picture from the last frame to the next, right and down, in units of 1/256 pixel, to
    /// be passed to [`Target::moved`]. It is caused by the turn of the head at the last command or, with a delay, at
    /// the command that was given [`PursuitConfig::delay_frames`] commands before the last.
    #[must_use]
    pub fn picture_motion(&self) -> (i32, i32) {
        let (right, up) = self.turns.get(usize::from(self.delay_frames)).copied().unwrap_or_default();
        self.camera.picture_motion(right, up)
    }

    /// Returns the pins: pan, tilt, indicator.
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

fn check_elapsed<E>(elapsed_seconds: f32, or: E) -> Result<(), E> {
    if elapsed_seconds.is_finite() && elapsed_seconds >= 0.0 { Ok(()) } else { Err(or) }
}
