use super::axis::{Axis, Servo};
use super::camera::arctangent;
use super::error::PursuitConfigError::{self, *};
use super::*;
use crate::{Answer, FineRect, Frame, Image, Paper, Rect, Robust, State, Target, Tracker, UpdateError, paper, robust};
use core::f32::consts::{FRAC_PI_2, TAU};
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::pwm::{self, SetDutyCycle};
use embedded_hal_mock::eh1::MockError;
use proptest::prelude::*;
use std::io::ErrorKind::{self, BrokenPipe, NotConnected, TimedOut};
use std::string::ToString;
use std::vec::Vec;

const AXIS: Axis = Axis {
    min_radians: -1.0,
    max_radians: 1.0,
    home_radians: 0.0,
    gain_per_second: 10.0,
    deadband_radians: 0.01,
    slew_radians_per_second: 2.0,
    return_radians_per_second: 0.5,
};

const fn servo(at_min: u16, at_max: u16, period: u16) -> Servo {
    Servo { pulse_at_min_microseconds: at_min, pulse_at_max_microseconds: at_max, period_microseconds: period }
}

/// A camera of 160x120 pixels. The tilt servo is mounted reversed.
fn config() -> PursuitConfig {
    PursuitConfig {
        camera: Camera::centred(160.0, 160, 120),
        pan: AXIS,
        pan_servo: servo(1000, 2000, 20_000),
        tilt: AXIS,
        tilt_servo: servo(2000, 1000, 20_000),
        hold_seconds: 1.0,
        delay_frames: 1,
    }
}

/// A mock pin that records PWM duties, or digital levels as 0 and 1. If `error` is set, the first write fails.
struct Pin {
    max_duty: u16,
    error: Option<ErrorKind>,
    written: Vec<u16>,
}

impl pwm::ErrorType for Pin {
    type Error = MockError;
}

impl digital::ErrorType for Pin {
    type Error = MockError;
}

impl SetDutyCycle for Pin {
    fn max_duty_cycle(&self) -> u16 {
        self.max_duty
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), MockError> {
        self.written.push(duty);
        self.error.take().map_or(Ok(()), |kind| Err(MockError::Io(kind)))
    }
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), MockError> {
        self.set_duty_cycle(0)
    }

    fn set_high(&mut self) -> Result<(), MockError> {
        self.set_duty_cycle(1)
    }
}

type Pins = Pursuit<Pin, Pin, Pin>;

/// A pursuit with mock pins (pan, tilt, indicator). Each pin with an entry in `errors` fails at its first write.
fn pursuit(config: PursuitConfig, errors: [Option<ErrorKind>; 3], max_duty: u16) -> Result<Pins, PursuitConfigError> {
    let [pan, tilt, indicator] = errors.map(|error| Pin { max_duty, error, written: Vec::new() });
    Pursuit::new(config, pan, tilt, indicator)
}

fn written(pursuit: &mut Pins) -> [Vec<u16>; 3] {
    [&mut pursuit.pan.pin, &mut pursuit.tilt.pin, &mut pursuit.indicator].map(|pin| core::mem::take(&mut pin.written))
}

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
        identity: None,
        scale: 1 << 16,
        found_again: false,
    }
}

#[test]
fn the_pulses_of_each_frame_are_exact() {
    use State::*;
    let mut pursuit = pursuit(config(), [None; 3], 20_000).unwrap();
    let (far, far_right, anywhere) = ((10_000, -10_000), (10_000, 60), (0, 0));
    let frames = [
        // The arctangent of 32 / 160 is 0.1974 radians. With gain 10 the head turns by all of it in 0.1 seconds.
        (Some(Tracking), (112, 60), 0.1, [1599, 1500, 1]),
        (Some(Leaving), (80, 92), 0.1, [1599, 1599, 1]),
        (Some(Uncertain), (48, 60), 0.1, [1500, 1599, 0]),
        (None, anywhere, f32::MAX, [1500, 1500, 0]),
        // At 2 radians/s, 0.25 s allow 0.5 radians (250 microseconds of pulse). The next turn ends at the limits.
        (Some(Tracking), far, 0.25, [1750, 1250, 1]),
        (Some(Tracking), far, 0.25, [2000, 1000, 1]),
        (Some(Tracking), far, 0.25, [2000, 1000, 1]),
        (None, anywhere, f32::MAX, [1500, 1500, 0]),
        // The head holds still for 1 second, then turns home at 0.5 radians/s.
        (Some(Tracking), far_right, 0.25, [1750, 1500, 1]),
        (Some(Lost), far_right, 0.5, [1750, 1500, 0]),
        (Some(Lost), far_right, 0.5, [1750, 1500, 0]),
        (Some(Lost), far_right, 0.25, [1688, 1500, 0]),
        (None, anywhere, 0.5, [1563, 1500, 0]),
        (None, anywhere, 0.5, [1500, 1500, 0]),
        (None, anywhere, f32::MAX, [1500, 1500, 0]),
        // The second of these frames comes 0.5 s after the end of the hold (1 s). A new sighting restarts the hold.
        (Some(Tracking), far_right, 0.25, [1750, 1500, 1]),
        (None, anywhere, 1.5, [1625, 1500, 0]),
        (Some(Tracking), far_right, 0.25, [1875, 1500, 1]),
        (None, anywhere, 1.0, [1875, 1500, 0]),
    ];
    for (number, (state, (x, y), seconds, pulses)) in frames.into_iter().enumerate() {
        let command = match state {
            Some(state) => pursuit.steer(&answer(state, x, y), seconds),
            None => pursuit.wait(seconds),
        };
        let Command { pan_radians, tilt_radians } = pursuit.command();
        assert_eq!(command, Ok(pursuit.command()));
        assert_eq!((1500.0 + 500.0 * pan_radians).round(), f32::from(pulses[0]), "frame {number}");
        assert_eq!((1500.0 - 500.0 * tilt_radians).round(), f32::from(pulses[1]), "frame {number}");
        assert_eq!(written(&mut pursuit), pulses.map(|pulse| std::vec![pulse]), "frame {number}");
    }
}

#[test]
fn an_invalid_time_writes_no_pin() {
    let mut pursuit = pursuit(config(), [None; 3], 20_000).unwrap();
    for elapsed in [f32::NAN, f32::INFINITY, -0.001, f32::NEG_INFINITY] {
        for state in [State::Tracking, State::Lost] {
            assert_eq!(pursuit.steer(&answer(state, 0, 0), elapsed), Err(PursuitError::ElapsedTime));
        }
        let (mut tracker, frame) = (Tracker::<Robust>::new(), seen());
        let frame = Frame::whole(Image::new(&frame, 160, 120).unwrap());
        assert_eq!(pursuit.follow(&mut tracker, &frame, elapsed).err(), Some(FollowError::ElapsedTime));
    }
    assert_eq!(written(&mut pursuit), [const { Vec::new() }; 3]);
}

#[test]
fn the_error_of_each_pin_is_passed_on_and_the_others_are_written() {
    let [pan, tilt, led] = [NotConnected, BrokenPipe, TimedOut].map(Some);
    // The first of several errors is returned. The turn after a failed write does not make up for the missed turn.
    for (errors, word, error, (pan_radians, tilt_radians)) in [
        ([pan, None, None], "pan", PursuitError::Pan(MockError::Io(NotConnected)), (0.5, 1.0)),
        ([None, tilt, None], "tilt", PursuitError::Tilt(MockError::Io(BrokenPipe)), (1.0, 0.5)),
        ([None, None, led], "indicator", PursuitError::Indicator(MockError::Io(TimedOut)), (1.0, 1.0)),
        ([pan, tilt, led], "NotConnected", PursuitError::Pan(MockError::Io(NotConnected)), (0.5, 0.5)),
    ] {
        let mut pursuit = pursuit(config(), errors, 20_000).unwrap();
        let mut follow = || pursuit.steer(&answer(State::Tracking, 10_000, -10_000), 0.25);
        assert!(error.to_string().contains(word), "{error}");
        assert_eq!((follow(), follow()), (Err(error), Ok(Command { pan_radians, tilt_radians })));
        assert_eq!(written(&mut pursuit).map(|writes| writes.len()), [2; 3], "{word}");
    }
}

#[test]
fn a_configuration_is_checked_when_the_pursuit_is_built() {
    macro_rules! refused {
        ($($error:ident: $($($field:ident).+ = $value:expr),+;)+) => {$($({
            let mut config = config();
            config.$($field).+ = $value;
            assert_eq!(pursuit(config, [None; 3], 1).err(), Some($error), stringify!($($field).+ = $value));
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
        assert!(pursuit(PursuitConfig { delay_frames, ..config() }, [None; 3], 1).is_ok());
    }
}

#[test]
fn angles_steps_and_duties_are_exact() {
    let camera = Camera::centred(160.0, 160, 120);
    assert_eq!(camera.error_radians(Rect::new(70, 50, 20, 20).into()), (0.0, 0.0));
    let (right, up) = camera.error_radians(Rect::new(80, 40, 20, 20).into());
    assert!(right > 0.0 && right == up, "right and up are positive");
    // A turn of the camera moves the picture in the opposite direction.
    assert_eq!(camera.picture_motion(0.1, 0.2), (-16 * 256, 32 * 256));
    assert_eq!(camera.picture_motion(f32::NAN, f32::INFINITY), (0, i32::MAX));

    let axis = Axis { home_radians: 0.25, ..AXIS };
    for (from, error, to) in [(0.0, 0.1, 0.03125), (0.5, -0.1, 0.46875)] {
        assert!((axis.toward(from, error, 0.03125) - to).abs() < 1e-6, "the gain times the error");
    }
    let fast = Axis { slew_radians_per_second: 100.0, ..axis };
    assert_eq!(fast.toward(0.5, 0.125, 10.0), 0.625, "a late frame does not overshoot");
    let slow = Axis { slew_radians_per_second: 0.25, ..axis };
    let home = [(axis, 0.75, 0.5, 0.5), (axis, 0.5, 0.75, 0.25), (axis, -0.25, 0.5, 0.0), (axis, 0.25, 5.0, 0.25)];
    for (axis, from, seconds, to) in home.into_iter().chain([(slow, 0.75, 0.5, 0.625)]) {
        assert_eq!(axis.homeward(from, seconds), to, "the way home ends there");
    }

    let [straight, reversed] = [servo(1000, 2000, 20_000), servo(2400, 600, 20_000)];
    for (servo, max_duty, duties) in [
        (straight, 20_000, [1000, 1250, 1500, 2000]),
        (reversed, 20_000, [2400, 1950, 1500, 600]),
        (straight, 65_535, [3277, 4096, 4915, 6554]), // 3276.75, 4095.9, 4915.1 and 6553.5
        (straight, 255, [13, 16, 19, 26]),            // 12.75, 15.9, 19.1 and 25.5
        (straight, 0, [0; 4]),
    ] {
        assert_eq!([-1.0, -0.5, 0.0, 1.0].map(|radians| servo.duty(&AXIS, radians, max_duty)), duties);
    }
}

#[test]
fn the_arctangent_is_as_exact_as_the_documentation_says() {
    let (mut largest, mut relative) = (0.0_f64, 0.0_f64);
    let near = (-400_000..=400_000).map(|step| step as f32 / 100_000.0); // slopes up to 4
    let far = (-300..=380).map(|step| 1.1_f32.powi(step)).flat_map(|slope| [slope, -slope]);
    for slope in near.chain(far).chain([f32::MIN_POSITIVE, f32::MAX, f32::MIN]) {
        let (angle, exact) = (f64::from(arctangent(slope)), f64::from(slope).atan());
        largest = largest.max((angle - exact).abs());
        if exact.abs() < 0.1 && exact != 0.0 {
            relative = relative.max((angle / exact - 1.0).abs());
        }
    }
    assert!(largest < 1.2e-5 && relative < 1.4e-4, "{largest} {relative}");
    assert_eq!([0.0, f32::INFINITY, f32::NEG_INFINITY].map(arctangent), [0.0, FRAC_PI_2, -FRAC_PI_2]);
}

const PLACE: Rect = Rect::new(100, 30, 24, 24);

fn seen() -> Vec<u8> {
    let hash = |x: i32, y: i32| ((x * 31 + y * 57 + 1).wrapping_mul(-1_640_531_535) >> 16) as u8;
    let is_target = |x, y| PLACE.contains(Rect::new(x, y, 1, 1));
    let level = |x, y| if is_target(x, y) { hash(x / 4, y / 4) } else { 80 + hash(x / 9, y / 9) / 5 };
    (0..160 * 120).map(|at| level(at % 160, at / 160)).collect()
}

/// Checks that the tracker's window moves with the picture after the delay, and that a failed pin stops only its axis.
fn follows<T: Target>(target: T::Config, delay_frames: u8, fails: [bool; 3]) {
    let mut tracker = std::boxed::Box::new(Tracker::<T>::with(target).unwrap());
    let errors = fails.map(|fails| fails.then_some(NotConnected));
    let mut pursuit = pursuit(PursuitConfig { delay_frames, ..config() }, errors, 20_000).unwrap();
    let pixels = seen();
    let frame = Frame::whole(Image::new(&pixels, 160, 120).unwrap());
    let error = pursuit.follow(&mut tracker, &frame, 0.03).unwrap_err();
    assert_eq!(error, FollowError::Update(UpdateError::NotLocked));
    assert_eq!(error.to_string(), "there is no target yet: lock first");
    tracker.lock(&frame, PLACE).unwrap();
    // The middle of the window, because a calm target has a smaller one.
    let middle = |window: Rect| (window.x + i32::from(window.width) / 2, window.y + i32::from(window.height) / 2);
    let before = middle(tracker.window().unwrap());
    let mut expected = (0, 0);
    for number in 0..=delay_frames {
        let Followed { answer, commanded } = pursuit.follow(&mut tracker, &frame, 0.03).unwrap();
        if number == 0 {
            assert_eq!((answer.bbox, answer.state), (PLACE, State::Tracking));
            assert_eq!(commanded.is_err(), fails.contains(&true));
            let Command { pan_radians, tilt_radians } = pursuit.command();
            assert_eq!((pan_radians > 0.05, tilt_radians > 0.02), (!fails[0], !fails[1]));
            expected = ((pan_radians * 160.0) as i32, (tilt_radians * 160.0) as i32);
        }
        let moved = middle(tracker.window().unwrap());
        let by = (before.0 - moved.0, moved.1 - before.1);
        let wanted = if number == delay_frames { expected } else { (0, 0) };
        assert!((by.0 - wanted.0).abs() <= 1 && (by.1 - wanted.1).abs() <= 1, "{number}: {by:?}, not {wanted:?}");
    }
}

#[test]
fn the_tracker_is_told_how_far_the_picture_moves() {
    let small = paper::Config { window: paper::Radius { x: 8, y: 8 }, ..paper::Config::camera() };
    let good = [false; 3];
    let failing = [[true, false, false], [false, true, false], [false, false, true]].map(|fails| (0, fails));
    for (delay_frames, fails) in [(0, good), (1, good), (3, good)].into_iter().chain(failing) {
        follows::<Paper<1024, 161>>(small, delay_frames, fails);
        // The refiner is off, because it enlarges the tracker's window, which the frame's edge would then cut.
        follows::<Robust>(robust::Config::robust(), delay_frames, fails);
    }
}

/// Axes with ordinary and extreme values; products of the extreme ones overflow.
fn any_axis() -> impl Strategy<Value = Axis> {
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

proptest! {
    #[test]
    fn angles_are_those_of_the_pinhole(x in -65_535..65_535i32, width in any::<u16>(), focal in 1.0..5000.0f32) {
        let (angle, _) = Camera::centred(focal, 320, 240).error_radians(Rect::new(x, 0, width, 1).into());
        let exact = ((f64::from(x) + f64::from(width) / 2.0 - 160.0) / f64::from(focal)).atan();
        // The error of the arctangent, and that of the slope, which is an f32.
        prop_assert!((f64::from(angle) - exact).abs() < 1.25e-5, "{} for {}", angle, exact);
    }

    #[test]
    fn no_step_leaves_the_limits_the_slew_rate_or_the_deadband_nor_passes_the_target(
        axis in any_axis(),
        frames in prop::collection::vec((
            prop_oneof![-1.58..1.58f32, -0.2..0.2f32],
            prop_oneof![0.0..0.2f32, Just(0.0), Just(f32::MIN_POSITIVE), Just(f32::MAX)],
            any::<bool>(),
        ), 1..50),
    ) {
        prop_assert_eq!(axis.check(), Ok(()));
        let mut angle = axis.home_radians;
        for (error, elapsed, found) in frames {
            let next = if found { axis.toward(angle, error, elapsed) } else { axis.homeward(angle, elapsed) };
            let step = next - angle;
            prop_assert!(next >= axis.min_radians && next <= axis.max_radians, "{}", next);
            prop_assert!(step.abs() <= axis.slew_radians_per_second * elapsed + 1e-6, "{} to {}", angle, next);
            if found {
                prop_assert!(step * error >= 0.0 && step.abs() <= error.abs() + 1e-6, "{} for {}", step, error);
                prop_assert!(step == 0.0 || error.abs() > axis.deadband_radians, "{} for {}", step, error);
            }
            angle = next;
        }
    }

    /// For every valid configuration, answer and time, the pulses stay between the servo's two limits.
    #[test]
    fn no_pulse_leaves_its_limits(
        (pan, tilt) in (any_axis(), any_axis()),
        (at_min, at_max, period, max_duty) in any::<(u16, u16, u16, u16)>(),
        (focal_length_pixels, principal_x_pixels) in (prop::num::f32::ANY, any::<f32>()),
        hold_seconds in prop_oneof![0.0..1.0f32, Just(f32::MAX)],
        frames in prop::collection::vec((any::<(i32, i32)>(), 0u8..3, prop::num::f32::ANY), 1..40),
    ) {
        let (pan_servo, tilt_servo) = (servo(at_min, at_max, period), servo(at_max, at_min, period));
        prop_assume!(pan_servo.check().is_ok());
        let camera = Camera { focal_length_pixels, principal_x_pixels, principal_y_pixels: 60.0 };
        let camera = if camera.check().is_ok() { camera } else { config().camera };
        let config = PursuitConfig { camera, pan, pan_servo, tilt, tilt_servo, hold_seconds, ..config() };
        let mut pursuit = pursuit(config, [None; 3], max_duty).unwrap();
        for ((x, y), state, elapsed) in frames {
            let fine = FineRect { x, y, width: 5120, height: 5120 };
            let (right, up) = camera.error_radians(fine);
            prop_assert!(right.abs() < 1.58 && up.abs() < 1.58, "{} {}", right, up);
            let state = [State::Tracking, State::Leaving, State::Lost][usize::from(state)];
            let _ = pursuit.steer(&Answer { fine, ..answer(state, 0, 0) }, elapsed); // the time may be invalid
        }
        let [pan, tilt, _] = written(&mut pursuit);
        let exact = |pulse: u16| f64::from(pulse) / f64::from(period) * f64::from(max_duty);
        let (least, most) = (exact(at_min.min(at_max)), exact(at_min.max(at_max)));
        for duty in pan.into_iter().chain(tilt).map(f64::from) {
            prop_assert!(duty > least - 0.52 && duty < most + 0.52, "{} of {}..{}", duty, least, most);
        }
    }
}
