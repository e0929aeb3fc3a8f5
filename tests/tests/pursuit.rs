//! The closed loop: a simulated camera on a head sees a rendered scene, the tracker follows the target, the pursuit turns the head.
//!
//! The camera has 160x120 pixels, a focal length of 160 pixels (53 degrees across) and 30 frames per second. Each frame is
//! rendered ray by ray from the present angles of the head: a textured target of 17 by 17 degrees (48x48 pixels at the
//! centre) in front of a textured background. A command reaches the servos one frame after the frame that caused it. The
//! servos turn at up to 300 degrees per second, with a resolution of one microsecond of pulse. Everything is
//! deterministic.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "gray levels and grid places, all small")]

use embedded_hal::{digital, pwm};
use smr_core::paper::{Config, Fraction, Radius};
use smr_core::pursuit::{Axis, Camera, Pursuit, PursuitConfig, Servo};
use smr_core::{Answer, Frame, Image, Paper, Rect, Robust, State, Target, Tracker, robust};
use std::cell::Cell;
use std::convert::Infallible;
use std::rc::Rc;

const WIDTH: u16 = 160;
const HEIGHT: u16 = 120;
const FOCAL_LENGTH_PIXELS: f64 = 160.0;
const FRAME_SECONDS: f64 = 1.0 / 30.0;
/// Length of the target's sides, in pixels at the centre.
const TARGET_PIXELS: u16 = 48;
const SERVO_DEGREES_PER_SECOND: f64 = 300.0;
const HOLD_SECONDS: f32 = 1.0;
const RETURN_RADIANS_PER_SECOND: f32 = 0.5;

const AXIS: Axis = Axis {
    min_radians: -1.05,
    max_radians: 1.05,
    home_radians: 0.0,
    gain_per_second: 10.0,
    deadband_radians: 0.004,
    slew_radians_per_second: 4.0,
    return_radians_per_second: RETURN_RADIANS_PER_SECOND,
};
const PAN_SERVO: Servo =
    Servo { pulse_at_min_microseconds: 900, pulse_at_max_microseconds: 2100, period_microseconds: 20_000 };
/// A servo that is mounted the other way round.
const TILT_SERVO: Servo =
    Servo { pulse_at_min_microseconds: 2100, pulse_at_max_microseconds: 900, period_microseconds: 20_000 };

/// A direction: angles to the right and up, in radians.
#[derive(Clone, Copy, Debug)]
struct Direction {
    pan: f64,
    tilt: f64,
}

impl Direction {
    fn degrees(pan: f64, tilt: f64) -> Self {
        Self { pan: pan.to_radians(), tilt: tilt.to_radians() }
    }
}

struct Scene {
    target: Direction,
    /// The direction of an occluder: it has its own texture and 1.5 times the size of the target.
    hidden_by: Option<Direction>,
}

impl Scene {
    /// The picture that a camera in direction `head` takes.
    fn picture(&self, head: Direction) -> Vec<u8> {
        let rows = (0..HEIGHT).map(|y| f64::from(HEIGHT) / 2.0 - f64::from(y) - 0.5);
        rows.flat_map(|up| {
            (0..WIDTH).map(move |x| self.seen(ray(head, f64::from(x) + 0.5 - f64::from(WIDTH) / 2.0, up)))
        })
        .collect()
    }

    fn seen(&self, ray: Direction) -> u8 {
        let side = f64::from(TARGET_PIXELS) / FOCAL_LENGTH_PIXELS;
        if let Some((right, up)) = self.hidden_by.and_then(|place| within(ray, place, 1.5 * side)) {
            texture(3, right, up, (20.0, 120.0))
        } else if let Some((right, up)) = within(ray, self.target, side) {
            texture(1, right, up, (10.0, 245.0))
        } else {
            texture(2, ray.pan, ray.tilt, (40.0, 200.0))
        }
    }
}

/// The point where a ray meets a square of `side` around `place`.
fn within(ray: Direction, place: Direction, side: f64) -> Option<(f64, f64)> {
    let (right, up) = (ray.pan - place.pan, ray.tilt - place.tilt);
    (right.abs() < side / 2.0 && up.abs() < side / 2.0).then_some((right, up))
}

/// The direction in which a camera that looks to `head` sees the point `right` and `up` pixels from the middle.
fn ray(head: Direction, right: f64, up: f64) -> Direction {
    let (sin, cos) = head.tilt.sin_cos();
    let forward = FOCAL_LENGTH_PIXELS * cos - up * sin;
    let height = FOCAL_LENGTH_PIXELS * sin + up * cos;
    Direction { pan: head.pan + right.atan2(forward), tilt: height.atan2(forward.hypot(right)) }
}

/// Offset of `point` from the middle of a camera that looks to `head`, in pixels to the right and up.
fn offset_pixels(head: Direction, point: Direction) -> (f64, f64) {
    let (sin, cos) = head.tilt.sin_cos();
    let level = point.tilt.cos();
    let (right, ahead, height) =
        (level * (point.pan - head.pan).sin(), level * (point.pan - head.pan).cos(), point.tilt.sin());
    let (forward, up) = (ahead * cos + height * sin, height * cos - ahead * sin);
    (FOCAL_LENGTH_PIXELS * right / forward, FOCAL_LENGTH_PIXELS * up / forward)
}

/// Random gray levels, 4 pixels apart at the centre, interpolated in between.
fn texture(seed: u32, pan: f64, tilt: f64, (darkest, brightest): (f64, f64)) -> u8 {
    let (x, y) = (pan * FOCAL_LENGTH_PIXELS / 4.0, tilt * FOCAL_LENGTH_PIXELS / 4.0);
    let (column, row) = (x.floor(), y.floor());
    let (right, low) = (x - column, y - row);
    let at = |dx: f64, dy: f64| grain(seed, (column + dx) as i32, (row + dy) as i32);
    let upper = at(0.0, 0.0) * (1.0 - right) + at(1.0, 0.0) * right;
    let lower = at(0.0, 1.0) * (1.0 - right) + at(1.0, 1.0) * right;
    (darkest + (brightest - darkest) * (upper * (1.0 - low) + lower * low)).round() as u8
}

/// A number from 0 to 1 for each place.
fn grain(seed: u32, column: i32, row: i32) -> f64 {
    let mut mixed = seed.wrapping_mul(0x9E37_79B9) ^ column.cast_unsigned().wrapping_mul(0x85EB_CA6B);
    mixed = (mixed ^ (mixed >> 15)).wrapping_add(row.cast_unsigned().wrapping_mul(0xC2B2_AE35));
    mixed = (mixed ^ (mixed >> 16)).wrapping_mul(0x7FEB_352D);
    mixed = (mixed ^ (mixed >> 15)).wrapping_mul(0x846C_A68B);
    f64::from((mixed ^ (mixed >> 16)) >> 8) / f64::from(1 << 24)
}

/// A PWM pin with a resolution of one microsecond, or an LED. The test can read the value last written to it.
#[derive(Clone, Default)]
struct Pin(Rc<Cell<u16>>);

impl pwm::ErrorType for Pin {
    type Error = Infallible;
}

impl pwm::SetDutyCycle for Pin {
    fn max_duty_cycle(&self) -> u16 {
        20_000
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.0.set(duty);
        Ok(())
    }
}

impl digital::ErrorType for Pin {
    type Error = Infallible;
}

impl digital::OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set(0);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set(1);
        Ok(())
    }
}

/// A servo on a pin: its angle, and the pulse of the frame before.
struct Motor {
    pin: Pin,
    servo: Servo,
    pulse: u16,
    radians: f64,
}

impl Motor {
    fn new(pin: &Pin, servo: Servo) -> Self {
        let home = u16::midpoint(servo.pulse_at_min_microseconds, servo.pulse_at_max_microseconds);
        Self { pin: pin.clone(), servo, pulse: home, radians: 0.0 }
    }

    /// One frame passes: the servo turns toward the pulse of the frame before, then takes the new one.
    fn turn(&mut self) {
        let (at_min, at_max) =
            (f64::from(self.servo.pulse_at_min_microseconds), f64::from(self.servo.pulse_at_max_microseconds));
        let along = (f64::from(self.pulse) - at_min) / (at_max - at_min);
        let (min, max) = (f64::from(AXIS.min_radians), f64::from(AXIS.max_radians));
        let reach = SERVO_DEGREES_PER_SECOND.to_radians() * FRAME_SECONDS;
        self.radians += (min + along * (max - min) - self.radians).clamp(-reach, reach);
        self.pulse = self.pin.0.get();
    }
}

/// The whole loop: scene, camera, tracker, pursuit, head.
struct Loop<T: Target> {
    tracker: Box<Tracker<T>>,
    pursuit: Pursuit<Pin, Pin, Pin>,
    pan: Motor,
    tilt: Motor,
    lamp: Pin,
}

/// The paper's tracker, with a window that the target does not leave.
type Small = Paper<4096, 65>;

fn small() -> Config {
    let mut config = Config::camera();
    config.window = Radius { x: 12, y: 12 };
    config.window_limit = Radius { x: 32, y: 32 };
    // The paper's gate of 1.0 accepts every peak inside the frame. Here the tracker must distinguish the target from
    // the occluder.
    config.gate_tracking = Fraction::new(5, 4);
    // A lead of 100 pixels is easy to reach with the target's 2304. So only the ratio decides here.
    config.gate_lead = u16::MAX;
    config
}

/// One frame: the tracker's answer, and the distance of the target from the middle of the picture.
struct Step {
    answer: Answer,
    error_pixels: f64,
    lamp: bool,
}

impl<T: Target> Loop<T> {
    fn locked(config: T::Config) -> Self {
        let mut tracker = Box::new(Tracker::<T>::with(config).expect("a good configuration"));
        let picture =
            Scene { target: Direction::degrees(0.0, 0.0), hidden_by: None }.picture(Direction::degrees(0.0, 0.0));
        let (x, y) = (i32::from((WIDTH - TARGET_PIXELS) / 2), i32::from((HEIGHT - TARGET_PIXELS) / 2));
        tracker.lock(&frame(&picture), Rect::new(x, y, TARGET_PIXELS, TARGET_PIXELS)).expect("a good box");

        let (pan_pin, tilt_pin, lamp) = (Pin::default(), Pin::default(), Pin::default());
        let (pan, tilt) = (Motor::new(&pan_pin, PAN_SERVO), Motor::new(&tilt_pin, TILT_SERVO));
        let config = PursuitConfig {
            camera: Camera::centred(FOCAL_LENGTH_PIXELS as f32, WIDTH, HEIGHT),
            pan: AXIS,
            pan_servo: PAN_SERVO,
            tilt: AXIS,
            tilt_servo: TILT_SERVO,
            hold_seconds: HOLD_SECONDS,
            delay_frames: 1,
        };
        let pursuit = Pursuit::new(config, pan_pin, tilt_pin, lamp.clone()).expect("a good configuration");
        Self { tracker, pursuit, pan, tilt, lamp }
    }

    fn head(&self) -> Direction {
        Direction { pan: self.pan.radians, tilt: self.tilt.radians }
    }

    fn step(&mut self, scene: &Scene) -> Step {
        let (right, up) = offset_pixels(self.head(), scene.target);
        let picture = scene.picture(self.head());
        let followed = self.pursuit.follow(&mut self.tracker, &frame(&picture), FRAME_SECONDS as f32);
        let answer = followed.expect("a frame of the same size").answer;
        self.pan.turn();
        self.tilt.turn();
        Step { answer, error_pixels: right.hypot(up), lamp: self.lamp.0.get() == 1 }
    }
}

fn frame(pixels: &[u8]) -> Frame<'_> {
    Frame::whole(Image::new(pixels, WIDTH, HEIGHT).expect("as many pixels as that"))
}

/// The largest error in pixels during 10 seconds. The target moves between 40 degrees left and right at a constant speed,
/// and `tilt_per_pan` times as far up and down.
fn sweep<T: Target>(config: T::Config, degrees_per_second: f64, tilt_per_pan: f64) -> f64 {
    let mut head = Loop::<T>::locked(config);
    let errors = (1..=300).map(|frame| {
        let way = degrees_per_second * FRAME_SECONDS * f64::from(frame);
        // A triangle: 0, 40, 0, -40, 0.
        let pan = 40.0 - ((way + 40.0).rem_euclid(160.0) - 80.0).abs();
        let step = head.step(&Scene { target: Direction::degrees(pan, tilt_per_pan * pan), hidden_by: None });
        assert_eq!(step.answer.state, State::Tracking, "frame {frame} at {degrees_per_second} degrees a second");
        assert!(step.lamp, "frame {frame}: the indicator is on");
        step.error_pixels
    });
    errors.fold(0.0, f64::max)
}

/// Measured at 30, 40 and 60 degrees per second: 12.3, 16.0 and 32.0 pixels horizontally, 12.8, 27.1 and 30.9 diagonally.
/// Of this, 8.4, 11.2 and 16.8 are speed / gain, the steady error of a proportional controller.
///
/// Slow targets are not promised: at 10 and 20 degrees per second it is 4.5 and 21.4 pixels horizontally; diagonally the
/// box slips off the target (91 pixels). A template that is replaced in every frame accumulates sub-pixel errors.
#[test]
fn a_moving_target_stays_near_the_centre() {
    for (speed, tilt_per_pan, most) in [
        (30.0, 0.0, 14.0),
        (40.0, 0.0, 18.0),
        (60.0, 0.0, 34.0),
        (30.0, 0.5, 14.0),
        (40.0, 0.5, 29.0),
        (60.0, 0.5, 34.0),
    ] {
        let worst = sweep::<Small>(small(), speed, tilt_per_pan);
        println!("{speed} degrees a second, tilt {tilt_per_pan} of pan: at most {worst:.1} pixels from the centre");
        assert!(worst < most, "{speed} degrees a second, {tilt_per_pan}: {worst:.1} pixels");
    }
}

/// The robust tracker also keeps slow targets and diagonal ones. Measured: 3.9, 5.4, 7.9, 9.8, 13.9 and 18.8 pixels.
#[test]
fn the_robust_tracker_holds_at_every_speed() {
    for (speed, tilt_per_pan, most) in [
        (5.0, 0.0, 14.0),
        (10.0, 0.5, 14.0),
        (20.0, 0.5, 14.0),
        (30.0, 0.0, 14.0),
        (40.0, 0.5, 18.0),
        (60.0, 0.0, 34.0),
    ] {
        let worst = sweep::<Robust>(robust::Config::refined(), speed, tilt_per_pan);
        println!(
            "robust: {speed} degrees a second, tilt {tilt_per_pan} of pan: at most {worst:.1} pixels from the centre"
        );
        assert!(worst < most, "{speed} degrees a second, {tilt_per_pan}: {worst:.1} pixels");
    }
}

/// Follows a target that moves 20 degrees to the right at 30 degrees per second and then stands still for a second.
fn at_20_degrees() -> (Loop<Small>, Direction) {
    let mut head = Loop::<Small>::locked(small());
    for frame in 1..=50 {
        let step = head.step(&Scene { target: Direction::degrees(f64::from(frame).min(20.0), 0.0), hidden_by: None });
        assert_eq!(step.answer.state, State::Tracking, "frame {frame}");
    }
    (head, Direction::degrees(20.0, 0.0))
}

fn turned_degrees(from: Direction, to: Direction) -> f64 {
    (to.pan - from.pan).abs().max((to.tilt - from.tilt).abs()).to_degrees()
}

/// Measured: found in the first frame in which it is visible again, 8.9 pixels away; at most 5.3 pixels from the third
/// frame on, 0.3 in the fifth. Sub-pixel errors of the tracker then add up to 7.0 within a second.
#[test]
fn a_target_that_was_hidden_is_centred_again() {
    let (mut head, place) = at_20_degrees();
    let held = head.head();
    let moved = |frame| Direction::degrees(20.0 + 0.15 * f64::from(frame), 0.0);
    for frame in 1..=25 {
        // It keeps moving behind the occluder.
        let step = head.step(&Scene { target: moved(frame), hidden_by: Some(place) });
        assert_eq!((step.answer.state, step.lamp), (State::Lost, false), "frame {frame}");
        assert!(turned_degrees(held, head.head()) < 0.1, "the head holds still in frame {frame}");
    }
    for frame in 1..=30 {
        let step = head.step(&Scene { target: moved(25), hidden_by: None });
        assert_eq!((step.answer.state, step.lamp), (State::Tracking, true), "frame {frame}");
        let most = if frame <= 4 { 10.0 } else { 8.0 };
        assert!(step.error_pixels < most, "frame {frame}: {:.1} pixels", step.error_pixels);
        assert!(frame != 5 || step.error_pixels < 2.0, "it is centred within 5 frames: {:.1}", step.error_pixels);
    }
}

/// Measured: 20.55 degrees away from home the head holds still for 31 frames, including one of delay. It is home 22 frames later.
#[test]
fn a_target_that_stays_lost_is_waited_for_and_then_the_head_goes_home() {
    let (mut head, place) = at_20_degrees();
    let held = head.head();
    let gone = Scene { target: Direction::degrees(120.0, 0.0), hidden_by: Some(place) };
    let home = Direction::degrees(0.0, 0.0);
    for frame in 1..=60 {
        let before = head.head();
        let step = head.step(&gone);
        assert_eq!((step.answer.state, step.lamp), (State::Lost, false), "frame {frame}");
        if frame <= 30 {
            assert!(turned_degrees(held, head.head()) < 0.1, "it holds in frame {frame}");
        }
        let slowly = f64::from(RETURN_RADIANS_PER_SECOND) * FRAME_SECONDS;
        // A microsecond of the pulse is a tenth of a degree.
        assert!(turned_degrees(before, head.head()) < slowly.to_degrees() + 0.1, "it does not rush in frame {frame}");
    }
    assert!(turned_degrees(home, head.head()) < 0.1, "it is home");
}
