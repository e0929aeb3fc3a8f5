//! Tests the pursuit against mock pins that expect exact duties.

use super::controller::tests::{PAN, any_axis};
use super::head::tests::{SERVO, servo};
use super::*;
use crate::{Answer, FineRect, Frame, Image, Paper, Rect, Robust, State, Target, Tracker, UpdateError, paper, robust};
use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;
use embedded_hal::{digital, pwm};
use embedded_hal_mock::eh1::{MockError, digital as pin_mock, pwm as pwm_mock};
use proptest::prelude::*;
use std::io::ErrorKind::{BrokenPipe, NotConnected, TimedOut};
use std::string::ToString;
use std::vec::Vec;

/// Two axes from -1 to 1 radians with home at 0; 160x120 pixels; focal length 160 pixels; hold of 1 second.
fn config() -> PursuitConfig {
    let axis = Axis { home_radians: 0.0, ..PAN };
    PursuitConfig {
        camera: Camera::centred(160.0, 160, 120),
        pan: axis,
        pan_servo: SERVO,
        tilt: axis,
        tilt_servo: servo(2000, 1000, 20_000),
        hold_seconds: 1.0,
        delay_frames: 1,
    }
}

/// The answer with a 20x20 box whose middle is at (`x`, `y`).
fn answer(state: State, x: i32, y: i32) -> Answer {
    let bbox = Rect::new(x - 10, y - 10, 20, 20);
    Answer {
        bbox,
        fine: bbox.into(),
        state,
        confidence: 1,
        ratio: 1,
        runner_up_ratio: None,
        alpha: Some(13),
        scale: 1 << 16,
        found_again: false,
    }
}

fn duties(of: &[u16]) -> pwm_mock::Mock {
    let each = |&duty| [pwm_mock::Transaction::max_duty_cycle(20_000), pwm_mock::Transaction::set_duty_cycle(duty)];
    pwm_mock::Mock::new(&of.iter().flat_map(each).collect::<Vec<_>>())
}

fn lamp(states: &[bool]) -> pin_mock::Mock {
    let set = |&on| pin_mock::Transaction::set(if on { pin_mock::State::High } else { pin_mock::State::Low });
    pin_mock::Mock::new(&states.iter().map(set).collect::<Vec<_>>())
}

type Mocked = Pursuit<pwm_mock::Mock, pwm_mock::Mock, pin_mock::Mock>;

/// Runs `steps` on a new pursuit and checks that exactly these duties and lamp states are written.
fn writes(pan: &[u16], tilt: &[u16], indicator: &[bool], steps: impl FnOnce(&mut Mocked)) {
    let mut pursuit = Pursuit::new(config(), duties(pan), duties(tilt), lamp(indicator)).unwrap();
    steps(&mut pursuit);
    done(pursuit);
}

/// Checks that every expected write was made.
fn done(pursuit: Mocked) {
    let (mut pan, mut tilt, mut indicator) = pursuit.release();
    pan.done();
    tilt.done();
    indicator.done();
}

#[test]
fn duties_are_exact() {
    // micromath's atan(32 / 160) is 0.1957 radians. With gain 10 the head turns by all of it in 0.1 seconds.
    writes(&[1598, 1598], &[1500, 1598], &[true, true], |pursuit| {
        let command = pursuit.steer(&answer(State::Tracking, 112, 60), 0.1).unwrap();
        assert!((command.pan_radians - 0.1957).abs() < 0.0001 && command.tilt_radians == 0.0, "{command:?}");
        // The target is below the centre: the head turns down, by the longer pulse of the reversed tilt servo.
        let command = pursuit.steer(&answer(State::Leaving, 80, 92), 0.1).unwrap();
        assert_eq!(command.tilt_radians, -command.pan_radians);
        assert_eq!(command, pursuit.command());
    });
}

#[test]
fn the_slew_rate_and_the_limits_hold() {
    // 2 radians/s * 0.25 s = 0.5 of 2 radians, 250 of 1000 microseconds.
    writes(&[1750, 2000, 2000], &[1250, 1000, 1000], &[true; 3], |pursuit| {
        for _ in 0..3 {
            pursuit.steer(&answer(State::Tracking, 10_000, -10_000), 0.25).unwrap();
        }
        assert_eq!(pursuit.command(), Command { pan_radians: 1.0, tilt_radians: 1.0 });
    });
}

#[test]
fn a_lost_target_is_waited_for_then_the_head_goes_home_and_resumes() {
    let pan = [1750, 1750, 1750, 1688, 1563, 1500, 1500, 1750];
    let indicator = [true, false, false, false, false, false, false, true];
    writes(&pan, &[1500; 8], &indicator, |pursuit| {
        let far_right = answer(State::Tracking, 10_000, 60);
        pursuit.steer(&far_right, 0.25).unwrap();
        // The hold of 1 second, then 0.25 s at 0.5 radians/s.
        pursuit.steer(&answer(State::Lost, 10_000, 60), 0.5).unwrap();
        pursuit.steer(&answer(State::Lost, 10_000, 60), 0.5).unwrap();
        pursuit.steer(&answer(State::Lost, 10_000, 60), 0.25).unwrap();
        pursuit.wait(0.5).unwrap();
        pursuit.wait(0.5).unwrap();
        assert_eq!(pursuit.command().pan_radians, 0.0);
        pursuit.wait(f32::MAX).unwrap();
        pursuit.steer(&far_right, 0.25).unwrap();
    });
}

#[test]
fn the_hold_ends_within_a_frame_and_starts_anew() {
    writes(&[1750, 1625, 1875, 1875], &[1500; 4], &[true, false, true, false], |pursuit| {
        pursuit.steer(&answer(State::Tracking, 10_000, 60), 0.25).unwrap();
        pursuit.wait(1.5).unwrap(); // 0.5 seconds after the end of the hold
        pursuit.steer(&answer(State::Tracking, 10_000, 60), 0.25).unwrap();
        pursuit.wait(1.0).unwrap();
    });
}

#[test]
fn an_invalid_time_writes_no_pin() {
    writes(&[], &[], &[], |pursuit| {
        for elapsed in [f32::NAN, f32::INFINITY, -0.001, f32::NEG_INFINITY] {
            let tracking = pursuit.steer(&answer(State::Tracking, 0, 0), elapsed);
            assert_eq!(tracking, Err(PursuitError::ElapsedTime));
            assert_eq!(pursuit.steer(&answer(State::Lost, 0, 0), elapsed), Err(PursuitError::ElapsedTime));
        }
    });
}

#[test]
fn the_error_of_each_pin_is_passed_on_and_the_others_are_written() {
    let failing = |kind| {
        pwm_mock::Mock::new(&[
            pwm_mock::Transaction::max_duty_cycle(20_000),
            pwm_mock::Transaction::set_duty_cycle(1750).with_error(MockError::Io(kind)),
            pwm_mock::Transaction::max_duty_cycle(20_000),
            pwm_mock::Transaction::set_duty_cycle(1750),
        ])
    };
    let broken_lamp = || {
        let on = || pin_mock::Transaction::set(pin_mock::State::High);
        pin_mock::Mock::new(&[on().with_error(MockError::Io(TimedOut)), on()])
    };
    let good = || duties(&[1750, 2000]);
    // Of several errors the first. An axis that was not written does not make up for it by a leap.
    for ([pan, tilt, led], word, error, (pan_radians, tilt_radians)) in [
        ([true, false, false], "pan", PursuitError::Pan(MockError::Io(NotConnected)), (0.5, 1.0)),
        ([false, true, false], "tilt", PursuitError::Tilt(MockError::Io(BrokenPipe)), (1.0, 0.5)),
        ([false, false, true], "indicator", PursuitError::Indicator(MockError::Io(TimedOut)), (1.0, 1.0)),
        ([true; 3], "NotConnected", PursuitError::Pan(MockError::Io(NotConnected)), (0.5, 0.5)),
    ] {
        let config = PursuitConfig { tilt_servo: SERVO, ..config() };
        let pan = if pan { failing(NotConnected) } else { good() };
        let tilt = if tilt { failing(BrokenPipe) } else { good() };
        let indicator = if led { broken_lamp() } else { lamp(&[true; 2]) };
        let mut pursuit = Pursuit::new(config, pan, tilt, indicator).unwrap();
        let mut follow = || pursuit.steer(&answer(State::Tracking, 10_000, -10_000), 0.25);
        assert!(error.to_string().contains(word), "{error}");
        assert_eq!((follow(), follow()), (Err(error), Ok(Command { pan_radians, tilt_radians })));
        done(pursuit);
    }
}

#[test]
fn a_configuration_is_checked_when_the_pursuit_is_built() {
    use PursuitConfigError::*;
    macro_rules! refused {
        ($($error:ident: $($($field:ident).+ = $value:expr),+;)+) => {$($({
            let mut config = config();
            config.$($field).+ = $value;
            assert_eq!(pursuit(config, [false; 3]).err(), Some($error), stringify!($($field).+ = $value));
        })+)+};
    }
    refused! {
        NotFinite: camera.focal_length_pixels = f32::NAN, camera.principal_x_pixels = f32::INFINITY;
        NotFinite: hold_seconds = f32::INFINITY, pan.min_radians = f32::NAN, tilt.deadband_radians = f32::INFINITY, pan.gain_per_second = f32::NAN;
        Negative: hold_seconds = -1.0, pan.deadband_radians = -0.01;
        FocalLengthTooShort: camera.focal_length_pixels = 0.0, camera.focal_length_pixels = -160.0;
        RateNotPositive: pan.gain_per_second = 0.0, tilt.gain_per_second = 0.0, pan.slew_radians_per_second = -1.0, pan.return_radians_per_second = 0.0;
        LimitsReversed: pan.max_radians = -1.0, pan.max_radians = -2.0;
        LimitsBeyondOneTurn: pan.max_radians = 90.0, pan.min_radians = -90.0;
        HomeOutsideLimits: pan.home_radians = 1.5, pan.home_radians = -1.5;
        PulseNotInPeriod: pan_servo.period_microseconds = 0, tilt_servo.period_microseconds = 0;
        PulseNotInPeriod: pan_servo = servo(1000, 20_000, 20_000), pan_servo = servo(20_000, 1000, 20_000), tilt_servo = servo(0, 0, 0);
        PulsesEqual: pan_servo = servo(1500, 1500, 20_000);
        DelayTooLong: delay_frames = 4;
    }
    for delay_frames in [1, 3] {
        assert!(pursuit(PursuitConfig { delay_frames, ..config() }, [false; 3]).is_ok());
    }
}

/// A pin that remembers the last duty, or fails.
struct Pin {
    duty: u16,
    fails: bool,
}

impl Pin {
    fn written(&self) -> Result<(), MockError> {
        if self.fails { Err(MockError::Io(NotConnected)) } else { Ok(()) }
    }
}

/// A pursuit with pins for pan, tilt and the indicator, some of which fail.
fn pursuit(config: PursuitConfig, fail: [bool; 3]) -> Result<Pursuit<Pin, Pin, Pin>, PursuitConfigError> {
    let [pan, tilt, indicator] = fail.map(|fails| Pin { fails, duty: 0 });
    Pursuit::new(config, pan, tilt, indicator)
}

impl pwm::ErrorType for Pin {
    type Error = MockError;
}

impl digital::ErrorType for Pin {
    type Error = MockError;
}

impl SetDutyCycle for Pin {
    fn max_duty_cycle(&self) -> u16 {
        20_000
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), MockError> {
        self.written().map(|()| self.duty = duty)
    }
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), MockError> {
        self.written()
    }

    fn set_high(&mut self) -> Result<(), MockError> {
        self.written()
    }
}

/// A frame of 160x120 pixels with a target of 24x24 at (`x`, `y`).
fn seen(x: usize, y: usize) -> Vec<u8> {
    let hash = |x: usize, y: usize, seed: usize| ((x * 31 + y * 57 + seed).wrapping_mul(2_654_435_761) >> 16) as u8;
    let level = |px: usize, py: usize| match (px.checked_sub(x), py.checked_sub(y)) {
        (Some(px @ 0..24), Some(py @ 0..24)) => hash(px / 4, py / 4, 1),
        _ => 80 + hash(px / 9, py / 9, 9) / 5,
    };
    (0..160 * 120).map(|at| level(at % 160, at / 160)).collect()
}

fn small() -> paper::Config {
    paper::Config { window: paper::Radius { x: 8, y: 8 }, ..paper::Config::camera() }
}

/// The head turns to the target, and the search window moves with the picture.
fn follows<T: Target>(target: T::Config, delay_frames: u8) {
    let mut tracker = std::boxed::Box::new(Tracker::<T>::with(target).unwrap());
    let mut pursuit = pursuit(PursuitConfig { delay_frames, ..config() }, [false; 3]).unwrap();
    let first = seen(100, 30);
    let frame = Frame::whole(Image::new(&first, 160, 120).unwrap());
    let error = pursuit.follow(&mut tracker, &frame, 0.03).unwrap_err();
    assert_eq!(error, FollowError::Update(UpdateError::NotLocked));
    assert_eq!(error.to_string(), "there is no target yet: lock first");
    tracker.lock(&frame, Rect::new(100, 30, 24, 24)).unwrap();
    let before = tracker.window().unwrap();
    let mut expected = (0, 0);
    for number in 0..=delay_frames {
        let Followed { answer, commanded } = pursuit.follow(&mut tracker, &frame, 0.03).unwrap();
        let command = commanded.unwrap();
        if number == 0 {
            assert_eq!((answer.bbox, answer.state), (Rect::new(100, 30, 24, 24), State::Tracking));
            assert!(command.pan_radians > 0.05 && command.tilt_radians > 0.02, "{command:?}");
            expected = ((command.pan_radians * 160.0) as i32, (command.tilt_radians * 160.0) as i32);
        }
        let moved = tracker.window().unwrap();
        let by = (before.x - moved.x, moved.y - before.y);
        let wanted = if number == delay_frames { expected } else { (0, 0) };
        assert!((by.0 - wanted.0).abs() <= 1 && (by.1 - wanted.1).abs() <= 1, "{number}: {by:?}, not {wanted:?}");
    }
}

#[test]
fn the_tracker_is_told_how_far_the_picture_moves() {
    // Without the refiner, whose larger window the frame's edge would cut.
    let robust = robust::Config::robust();
    for delay_frames in [0, 1, 3] {
        follows::<Paper<1024, 161>>(small(), delay_frames);
        follows::<Robust>(robust, delay_frames);
    }
}

/// If a pin fails, the other axis still turns: the tracker is told, and the answer is returned.
#[test]
fn a_pin_that_fails_hides_neither_the_turn_nor_the_answer() {
    let first = seen(100, 30);
    let frame = Frame::whole(Image::new(&first, 160, 120).unwrap());
    let follow = |fail: [bool; 3]| {
        let mut pursuit = pursuit(PursuitConfig { delay_frames: 0, ..config() }, fail).unwrap();
        let mut tracker = Tracker::<Paper<1024, 161>>::with(small()).unwrap();
        tracker.lock(&frame, Rect::new(100, 30, 24, 24)).unwrap();
        let followed = pursuit.follow(&mut tracker, &frame, 0.03).unwrap();
        assert_eq!(followed.answer.bbox, Rect::new(100, 30, 24, 24));
        (followed.commanded.is_ok(), pursuit.command(), tracker.window().unwrap())
    };
    let (good, command, window) = follow([false; 3]);
    assert!(good && window.x < 92 && window.y > 22, "{window:?}");
    assert_eq!(follow([false, false, true]), (false, command, window), "the LED");
    // Without pan the picture only moves down.
    let (tilted, moved) = (Command { pan_radians: 0.0, ..command }, Rect { x: 92, ..window });
    assert_eq!(follow([true, false, false]), (false, tilted, moved));
}

proptest! {
    /// For every valid configuration, answer and time the pulses stay within the two of the servo.
    #[test]
    fn no_pulse_leaves_its_limits(
        (pan, tilt) in (any_axis(), any_axis()),
        (focal_length_pixels, principal_x_pixels) in prop::num::f32::ANY.prop_flat_map(|focal| (Just(focal), any::<f32>())),
        hold_seconds in prop_oneof![0.0..1.0f32, Just(f32::MAX)],
        frames in prop::collection::vec((any::<(i32, i32)>(), 0u8..3, prop::num::f32::ANY), 1..40),
    ) {
        let camera = Camera { focal_length_pixels, principal_x_pixels, principal_y_pixels: 60.0 };
        let camera = if camera.check().is_ok() { camera } else { config().camera };
        let config = PursuitConfig { camera, pan, tilt, hold_seconds, ..config() };
        let mut pursuit = pursuit(config, [false; 3]).unwrap();
        for ((x, y), state, elapsed) in frames {
            let state = [State::Tracking, State::Leaving, State::Lost][usize::from(state)];
            let answer = Answer { fine: FineRect { x, y, width: 5120, height: 5120 }, ..answer(state, 0, 0) };
            if pursuit.steer(&answer, elapsed).is_ok() {
                prop_assert!((1000..=2000).contains(&pursuit.pan.pin.duty), "{}", pursuit.pan.pin.duty);
                prop_assert!((1000..=2000).contains(&pursuit.tilt.pin.duty), "{}", pursuit.tilt.pin.duty);
            }
        }
    }
}
