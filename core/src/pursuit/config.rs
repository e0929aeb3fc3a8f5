//! The configuration of the pursuit.

use super::camera::Camera;
use super::controller::Axis;
use super::error::PursuitConfigError;
use super::head::Servo;

/// The number of turns of the head that are remembered: the last one, and one for each frame of the longest delay.
pub(super) const TURNS: usize = 4;

/// The configuration of a [`Pursuit`](super::Pursuit), which checks it. See the [module's example](super).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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
    /// The delay from a command to the frame that shows its effect, in frames, 0 to 3. 1 if the next frame is exposed
    /// before the servos have turned. The tracker is told the motion of the picture with this delay.
    pub delay_frames: u8,
}

impl PursuitConfig {
    pub(super) fn check(&self) -> Result<(), PursuitConfigError> {
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
