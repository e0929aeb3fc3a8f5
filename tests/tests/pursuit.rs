//! The closed loop: a simulated camera films a scene, the tracker follows the target, the pursuit turns the head.
//!
//! The camera has 160x120 pixels, a focal length of 160 pixels (53 degrees across) and 30 frames per second. Each frame
//! is rendered ray by ray, deterministically, from the present angles of the head: a textured target of 17 by 17
//! degrees (48x48 pixels at the centre) in front of a textured background. A command reaches the servos one frame after
//! the frame that caused it. They turn at up to 300 degrees per second, with a resolution of one microsecond of pulse.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "gray levels and grid places, all small")]

use embedded_hal::{digital, pwm};
use smr_core::paper::{Config, Fraction, Radius};
use smr_core::pursuit::{Axis, Camera, Pursuit, PursuitConfig, Servo};
use smr_core::{Frame, Image, Paper, Rect, Robust, State, Target, Tracker, robust};
use std::cell::Cell;
use std::convert::Infallible;
use std::rc::Rc;

const WIDTH: u16 = 160;
const HEIGHT: u16 = 120;
const FOCAL_LENGTH_PIXELS: f64 = 160.0;
const FRAME_SECONDS: f64 = 1.0 / 30.0;
/// Side of the target in the picture, in pixels, if the target is in the picture's middle.
const TARGET_PIXELS: u16 = 48;
const SERVO_DEGREES_PER_SECOND: f64 = 300.0;
const RETURN_RADIANS_PER_SECOND: f32 = 0.5;
const LIMIT_RADIANS: f32 = 1.05;

type Direction = [f64; 2];
const HOME: Direction = [0.0, 0.0];

fn right_degrees(degrees: f64) -> Direction {
    [degrees.to_radians(), 0.0]
}

/// Renders a camera's picture in direction `head`. An occluder has its own texture and 1.5 times the target's size.
fn picture(head: Direction, target: Direction, occluder: Option<Direction>) -> Vec<u8> {
    let side = f64::from(TARGET_PIXELS) / FOCAL_LENGTH_PIXELS;
    let seen = |ray: Direction| {
        let within = |place: Direction, side: f64| {
            let at = [ray[0] - place[0], ray[1] - place[1]];
            at.iter().all(|offset| offset.abs() < side / 2.0).then_some(at)
        };
        if let Some(at) = occluder.and_then(|place| within(place, 1.5 * side)) {
            texture(3, at, (20.0, 120.0))
        } else if let Some(at) = within(target, side) {
            texture(1, at, (10.0, 245.0))
        } else {
            texture(2, ray, (40.0, 200.0))
        }
    };
    let middle = [WIDTH, HEIGHT].map(|side| f64::from(side) / 2.0 - 0.5);
    let place = |at| (f64::from(at % WIDTH) - middle[0], middle[1] - f64::from(at / WIDTH));
    (0..WIDTH * HEIGHT).map(place).map(|(right, up)| seen(ray(head, right, up))).collect()
}

/// Returns the direction of a pixel in the picture of a camera that points to `head`. The pixel lies `right` pixels to
/// the right of the picture's middle and `up` pixels above it.
fn ray(head: Direction, right: f64, up: f64) -> Direction {
    let (sin, cos) = head[1].sin_cos();
    let (forward, height) = (FOCAL_LENGTH_PIXELS * cos - up * sin, FOCAL_LENGTH_PIXELS * sin + up * cos);
    [head[0] + right.atan2(forward), height.atan2(forward.hypot(right))]
}

/// Returns the distance of `point` from the picture's middle in pixels, for a camera in direction `head`.
fn offset_pixels(head: Direction, point: Direction) -> f64 {
    let ((sin, cos), (height, level)) = (head[1].sin_cos(), point[1].sin_cos());
    let (right, ahead) = (level * (point[0] - head[0]).sin(), level * (point[0] - head[0]).cos());
    FOCAL_LENGTH_PIXELS * right.hypot(height * cos - ahead * sin) / (ahead * cos + height * sin)
}

/// Returns a texture's gray level at `place`, interpolated between random levels at grid points. In the picture's
/// middle, they are 4 pixels apart.
fn texture(seed: u32, place: Direction, (darkest, brightest): (f64, f64)) -> u8 {
    let [x, y] = place.map(|radians| radians * FOCAL_LENGTH_PIXELS / 4.0);
    let (right, low) = (x - x.floor(), y - y.floor());
    let at = |dx: f64, dy: f64| grain(seed, (x.floor() + dx) as i32, (y.floor() + dy) as i32);
    let row = |dy: f64| at(0.0, dy) * (1.0 - right) + at(1.0, dy) * right;
    (darkest + (brightest - darkest) * (row(0.0) * (1.0 - low) + row(1.0) * low)).round() as u8
}

/// Returns a pseudo-random value from 0 to below 1, always the same for a seed and a grid point.
fn grain(seed: u32, column: i32, row: i32) -> f64 {
    let mut mixed = seed.wrapping_mul(0x9E37_79B9) ^ column.cast_unsigned().wrapping_mul(0x85EB_CA6B);
    mixed = (mixed ^ (mixed >> 15)).wrapping_add(row.cast_unsigned().wrapping_mul(0xC2B2_AE35));
    mixed = (mixed ^ (mixed >> 16)).wrapping_mul(0x7FEB_352D);
    mixed = (mixed ^ (mixed >> 15)).wrapping_mul(0x846C_A68B);
    f64::from((mixed ^ (mixed >> 16)) >> 8) / f64::from(1 << 24)
}

/// A PWM pin with a resolution of one microsecond, or an LED. The test reads the last written value.
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
        pwm::SetDutyCycle::set_duty_cycle(self, 0)
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        pwm::SetDutyCycle::set_duty_cycle(self, 1)
    }
}

struct Loop<T: Target> {
    tracker: Box<Tracker<T>>,
    pursuit: Pursuit<Pin, Pin, Pin>,
    servo_pins: [Pin; 2],
    lamp: Pin,
    /// Angles of the servos (`head`), and the angles that the last frame commanded (`goal`), all in radians.
    head: Direction,
    goal: Direction,
}

impl<T: Target> Loop<T> {
    fn locked(config: T::Config) -> Self {
        let mut tracker = Box::new(Tracker::<T>::with(config).expect("a good configuration"));
        let picture = picture(HOME, HOME, None);
        let [x, y] = [WIDTH, HEIGHT].map(|side| i32::from((side - TARGET_PIXELS) / 2));
        tracker.lock(&frame(&picture), Rect::new(x, y, TARGET_PIXELS, TARGET_PIXELS)).expect("a good box");
        let mut axis = Axis::new(-LIMIT_RADIANS, LIMIT_RADIANS);
        axis.deadband_radians = 0.004;
        axis.slew_radians_per_second = 4.0;
        axis.return_radians_per_second = RETURN_RADIANS_PER_SECOND;
        let camera = Camera::centred(FOCAL_LENGTH_PIXELS as f32, WIDTH, HEIGHT);
        let [pan, tilt] = [(900, 2100), (2100, 900)].map(|(at_min, at_max)| (axis, Servo::new(at_min, at_max)));
        let mut config = PursuitConfig::new(camera, pan, tilt);
        config.hold_seconds = 1.0;
        let (servo_pins, lamp) = (<[Pin; 2]>::default(), Pin::default());
        let [pan, tilt] = servo_pins.clone();
        let pursuit = Pursuit::new(config, pan, tilt, lamp.clone()).expect("a good configuration");
        Self { tracker, pursuit, servo_pins, lamp, head: HOME, goal: HOME }
    }

    /// Runs one frame. Returns the tracker's state, true if the lamp is on, and the target's distance from the
    /// picture's middle in pixels.
    fn step(&mut self, target: Direction, occluder: Option<Direction>) -> (State, bool, f64) {
        let error_pixels = offset_pixels(self.head, target);
        let picture = picture(self.head, target, occluder);
        let followed = self.pursuit.follow(&mut self.tracker, &frame(&picture), FRAME_SECONDS as f32);
        let state = followed.expect("a frame of the same size").answer.state;
        let reach = SERVO_DEGREES_PER_SECOND.to_radians() * FRAME_SECONDS;
        for (axis, way) in [1.0, -1.0].into_iter().enumerate() {
            self.head[axis] += (self.goal[axis] - self.head[axis]).clamp(-reach, reach);
            let pulse = f64::from(self.servo_pins[axis].0.get());
            self.goal[axis] = way * (pulse - 1500.0) / 600.0 * f64::from(LIMIT_RADIANS);
        }
        (state, self.lamp.0.get() == 1, error_pixels)
    }

    fn turned_degrees(&self, from: Direction) -> f64 {
        (self.head[0] - from[0]).abs().max((self.head[1] - from[1]).abs()).to_degrees()
    }
}

fn frame(pixels: &[u8]) -> Frame<'_> {
    Frame::whole(Image::new(pixels, WIDTH, HEIGHT).expect("as many pixels as that"))
}

/// The paper tracker, with a search window that the target does not leave.
type Small = Paper<4096, 65>;

fn small() -> Config {
    let mut config = Config::camera();
    config.window = Radius { x: 12, y: 12 };
    config.window_limit = Radius { x: 32, y: 32 };
    // The preset's 0 accepts every ratio of peak to runner-up; this limit must tell the target from the occluder.
    config.gate_tracking = Fraction::new(5, 4);
    // Only the ratio decides: no peak can lead by more pixels than this. The preset's 100 of 2304 are easy to exceed.
    config.gate_lead = u16::MAX;
    config
}

/// Each row has a speed in degrees per second, a ratio of tilt to pan, and a limit in pixels. The target moves for 10
/// seconds between 40 degrees left and right. It must stay tracked and nearer to the picture's middle than the limit.
fn holds<T: Target>(config: T::Config, rows: &[(f64, f64, f64)]) {
    for &(speed, tilt_per_pan, most) in rows {
        let mut head = Loop::<T>::locked(config);
        let errors = (1..=300).map(|frame| {
            let way = speed * FRAME_SECONDS * f64::from(frame);
            // A triangle wave in degrees: 0, 40, 0, -40, 0.
            let pan = (40.0 - ((way + 40.0).rem_euclid(160.0) - 80.0).abs()).to_radians();
            let (state, lamp, error_pixels) = head.step([pan, tilt_per_pan * pan], None);
            assert_eq!((state, lamp), (State::Tracking, true), "frame {frame} at {speed} degrees a second");
            error_pixels
        });
        let worst = errors.fold(0.0, f64::max);
        println!("{speed} degrees a second, tilt {tilt_per_pan} of pan: at most {worst:.1} pixels from the centre");
        assert!(worst < most, "{speed} degrees a second, {tilt_per_pan}: {worst:.1} pixels");
    }
}

/// Largest errors measured at 40 and 60 degrees per second: 15.4 and 20.2 pixels horizontally, 19.1 and 28.7 diagonally.
/// Horizontally, 11.2 and 16.8 of these are the steady error of a proportional controller (speed / gain).
///
/// Slower targets are not promised: at 30 degrees per second it is 26.5 pixels horizontally; diagonally the box slips off
/// the target (80 pixels). A template that is replaced in every frame accumulates sub-pixel errors, so that a change of
/// the gain by 6 % moves the speed at which that happens.
#[test]
fn a_moving_target_stays_near_the_centre() {
    holds::<Small>(small(), &[(40.0, 0.0, 18.0), (60.0, 0.0, 22.0)]);
    holds::<Small>(small(), &[(40.0, 0.5, 21.0), (60.0, 0.5, 31.0)]);
}

/// The robust tracker also keeps slow and diagonal targets. Largest errors measured, in the order of the rows: 1.7, 3.7,
/// 6.9, 9.2, 13.8 and 18.5 pixels.
#[test]
fn the_robust_tracker_holds_at_every_speed() {
    let config = robust::Config::refined();
    holds::<Robust>(config, &[(5.0, 0.0, 14.0), (10.0, 0.5, 14.0), (20.0, 0.5, 14.0)]);
    holds::<Robust>(config, &[(30.0, 0.0, 14.0), (40.0, 0.5, 18.0), (60.0, 0.0, 20.0)]);
}

/// Follows a target that moves 20 degrees to the right at 30 degrees per second and then stands still for a second.
fn at_20_degrees() -> Loop<Small> {
    let mut head = Loop::<Small>::locked(small());
    for frame in 1..=50 {
        let (state, ..) = head.step(right_degrees(f64::from(frame).min(20.0)), None);
        assert_eq!(state, State::Tracking, "frame {frame}");
    }
    head
}

/// Measured distance of the target from the picture's middle: 6.4 pixels in the first frame without the occluder, in
/// which the tracker finds the target; 2.8 in the third, 0.9 in the fourth. The head then turns 4.2 pixels too far,
/// because of the frame of delay, and is back at 0.9 after 17 frames.
#[test]
fn a_target_that_was_hidden_is_centred_again() {
    let mut head = at_20_degrees();
    let held = head.head;
    for frame in 1..=25 {
        // The target keeps moving behind the occluder.
        let target = right_degrees(20.0 + 0.15 * f64::from(frame));
        let (state, lamp, _) = head.step(target, Some(right_degrees(20.0)));
        assert_eq!((state, lamp), (State::Lost, false), "frame {frame}");
        assert!(head.turned_degrees(held) < 0.1, "the head holds still in frame {frame}");
    }
    for frame in 1..=30 {
        let (state, lamp, error_pixels) = head.step(right_degrees(23.75), None);
        assert_eq!((state, lamp), (State::Tracking, true), "frame {frame}");
        let most = [8.0, 8.0, 4.0].get(frame - 1).copied().unwrap_or(if frame < 17 { 5.0 } else { 2.0 });
        assert!(error_pixels < most, "frame {frame}: {error_pixels:.1} pixels");
    }
}

/// Measured: the head holds still for 31 frames (one of them is the servos' delay), 20.55 degrees away from home. It is
/// home 22 frames later.
#[test]
fn a_target_that_stays_lost_is_waited_for_and_then_the_head_goes_home() {
    let mut head = at_20_degrees();
    let held = head.head;
    for frame in 1..=60 {
        let before = head.head;
        let (state, lamp, _) = head.step(right_degrees(120.0), Some(right_degrees(20.0)));
        assert_eq!((state, lamp), (State::Lost, false), "frame {frame}");
        assert!(frame > 30 || head.turned_degrees(held) < 0.1, "it holds in frame {frame}");
        let slowly = (f64::from(RETURN_RADIANS_PER_SECOND) * FRAME_SECONDS).to_degrees();
        // A microsecond of the pulse is a tenth of a degree.
        assert!(head.turned_degrees(before) < slowly + 0.1, "it does not rush in frame {frame}");
    }
    assert!(head.turned_degrees(HOME) < 0.1, "it is home");
}
