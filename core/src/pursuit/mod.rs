//! Smooth pursuit: keeps the target centred with a pan/tilt head. Feature `pursuit`.
//!
//! [`Camera`] converts a box to an angle, [`Axis`] the angle to a turn, [`Servo`] the turn to a pulse, all in `f32`.
//!
//! ```
//! use smr_core::pursuit::{Axis, Camera, Pursuit, PursuitConfig, Servo};
//! use smr_core::paper::{Config, Radius};
//! use smr_core::{Frame, Image, Paper, Rect, Tracker};
//! # use embedded_hal_mock::eh1::{digital, pwm};
//! # let servo_at = |duty| {
//! #     pwm::Mock::new(&[pwm::Transaction::max_duty_cycle(62_500), pwm::Transaction::set_duty_cycle(duty)])
//! # };
//! # let (pan_pin, tilt_pin) = (servo_at(4749), servo_at(4703));
//! # let led_pin = digital::Mock::new(&[digital::Transaction::set(digital::State::High)]);
//! # let (mut pan_mock, mut tilt_mock, mut led_mock) = (pan_pin.clone(), tilt_pin.clone(), led_pin.clone());
//!
//! // Two servos that turn 60 degrees to each side, and a camera of 64x48 pixels.
//! let mut axis = Axis::new(-1.05, 1.05);
//! axis.deadband_radians = 0.01;
//! let head = (axis, Servo::new(1000, 2000));
//! let config = PursuitConfig::new(Camera::centred(64.0, 64, 48), head, head);
//! let mut pursuit = Pursuit::new(config, pan_pin, tilt_pin, led_pin)?;
//!
//! let mut config = Config::camera();
//! config.window = Radius { x: 8, y: 8 };
//! config.window_limit = Radius { x: 16, y: 16 };
//! let mut tracker = Tracker::<Paper<256, 33>>::with(config)?;
//! # let pixels: Vec<u8> = (0..64 * 48u32).map(|i| (i * i >> 7) as u8).collect();
//! # let frame = Frame::whole(Image::new(&pixels, 64, 48)?);
//! tracker.lock(&frame, Rect::new(34, 16, 12, 12))?;
//!
//! // For each frame, 1/30 s after the last one:
//! let followed = pursuit.follow(&mut tracker, &frame, 1.0 / 30.0)?;
//! assert_eq!(followed.answer.bbox.x, 34);
//! let command = followed.commanded?; // or the error of a pin
//! // The target is 8 pixels right of the centre and 2 above it. The head turns a third of the way in this frame.
//! assert!((command.pan_radians - 0.041).abs() < 0.002 && (command.tilt_radians - 0.010).abs() < 0.001);
//! # pan_mock.done();
//! # tilt_mock.done();
//! # led_mock.done();
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod axis;
mod camera;
mod error;
mod follow;

pub use axis::{Axis, Servo};
pub use camera::Camera;
pub use error::{FollowError, PursuitConfigError, PursuitError};
pub use follow::{Command, Commanded, Followed, Pursuit, PursuitConfig};

#[cfg(test)]
mod tests;
