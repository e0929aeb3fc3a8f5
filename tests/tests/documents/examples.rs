//! Compiles and runs the READMEs' Rust examples (`build.rs` extracts them). `.ci/c` does so with their C examples,
//! `core/python/tests/test_readme.py` with those of Python, `.ci/micropython` with those of MicroPython.

#![allow(elided_lifetimes_in_paths, reason = "the examples are written as most people write Rust")]

/// Draws the target of the examples: 40x48 pixels at 150,100 in the first picture (320x240), two pixels further right
/// in each next one.
fn pictures(count: usize) -> Vec<Vec<u8>> {
    let texture = |x: usize, y: usize| (x / 4 * 83 + y / 4 * 47 + (x / 4) * (y / 4) * 29) % 200 + 55;
    let pixel = |left: usize, x: usize, y: usize| {
        let inside = (left..left + 40).contains(&x) && (100..148).contains(&y);
        u8::try_from(if inside { texture(x - left, y) } else { (x * 7 + y * 3) % 32 }).expect("a gray level")
    };
    let picture = |left| (0..240).flat_map(|y| (0..320).map(move |x| pixel(left, x, y))).collect();
    (0..count).map(|step| picture(150 + 2 * step)).collect()
}

mod project {
    use super::pictures;

    include!(concat!(env!("OUT_DIR"), "/smr-1.rs"));

    #[test]
    fn the_target_of_the_next_frame_is_found() {
        let pictures = pictures(2);
        assert_eq!(follow(&pictures[0], &pictures[1]).unwrap(), Some(Rect::new(152, 100, 40, 48)));
        let covered = vec![0; 320 * 240];
        assert_eq!(follow(&pictures[0], &covered).unwrap(), None);
    }
}

mod library {
    use super::pictures;
    use std::cell::RefCell;

    include!(concat!(env!("OUT_DIR"), "/core-1.rs"));

    #[test]
    fn every_frame_is_followed() {
        let pictures = pictures(5);
        let mut left = pictures.iter().map(Vec::as_slice);
        let seen = RefCell::new(Vec::new());
        follow(|| left.next(), |place| seen.borrow_mut().push(place.x)).unwrap();
        assert_eq!(seen.into_inner(), [152, 154, 156, 158]);
        follow(|| None, |_| panic!("there is no frame")).unwrap();
    }
}

mod lost {
    use super::pictures;
    use smr_core::Image;

    include!(concat!(env!("OUT_DIR"), "/core-2.rs"));

    #[test]
    fn the_box_of_the_detector_is_followed() {
        let pictures = pictures(31);
        let covered = vec![90; 320 * 240];
        let frame = |pixels| Frame::whole(Image::new(pixels, 320, 240).unwrap());
        let mut tracker = Box::new(Tracker::<Robust>::new());
        tracker.lock(&frame(&pictures[0]), Rect::new(150, 100, 40, 48)).unwrap();
        let mut lost_frames = 0;
        for _ in 0..10 {
            let answer = follow(&mut tracker, &frame(&covered), &mut lost_frames, |_| None).unwrap();
            assert!(answer.state != State::Tracking);
        }
        // The target comes back outside of all windows that the next update searches, so only `detect` can find it.
        let detect = |_: &Frame<'_>| Some(Rect::new(210, 100, 40, 48));
        lost_frames = 10;
        follow(&mut tracker, &frame(&pictures[30]), &mut lost_frames, detect).unwrap();
        assert_eq!(lost_frames, 0);
        let answer = follow(&mut tracker, &frame(&pictures[30]), &mut lost_frames, detect).unwrap();
        assert_eq!((answer.state, answer.bbox), (State::Tracking, Rect::new(210, 100, 40, 48)));
    }
}

mod lines {
    use super::pictures;
    use smr_core::Robust;

    include!(concat!(env!("OUT_DIR"), "/core-3.rs"));

    #[test]
    fn the_lines_of_a_camera_are_enough() {
        let pictures = pictures(3);
        // YUYV: each second byte is gray.
        let cameras = pictures.iter().map(|gray| gray.iter().flat_map(|&gray| [gray, 128]).collect::<Vec<u8>>());
        let (mut tracker, mut pixels) = (Box::new(Tracker::<Robust>::new()), vec![0; 320 * 240]);
        let target = Rect::new(150, 100, 40, 48);
        let answers = cameras.map(|bytes| {
            follow(&mut tracker, target, (0..).zip(bytes.chunks(640)), &mut pixels).unwrap().map(|answer| answer.bbox.x)
        });
        assert_eq!(answers.collect::<Vec<_>>(), [None, Some(152), Some(154)]);
    }
}

mod shrunk {
    use smr_core::{Robust, Target, Tracker};

    include!(concat!(env!("OUT_DIR"), "/core-4.rs"));

    #[test]
    fn the_tracker_sees_a_quarter_of_each_side() {
        assert_eq!(FORMAT.gray_size(SENSOR), (160, 120));
        let tracker = Tracker::<Robust>::new();
        let window = tracker.target().lock_window(Rect::new(0, 0, 160, 120), Rect::new(60, 40, 20, 24));
        let readout = begin(window.into()).unwrap();
        assert_eq!(readout.pixels(), usize::from(window.width) * usize::from(window.height));
    }
}

mod turns {
    use super::pictures;
    use smr_core::{Image, LockError, Paper};

    include!(concat!(env!("OUT_DIR"), "/core-5.rs"));

    #[test]
    fn each_target_gets_its_turn() {
        let pictures = pictures(2);
        let frame = |number: usize| Frame::whole(Image::new(&pictures[number], 320, 240).unwrap());
        let mut workspace = smr_core::paper::Workspace::<4096, 33>::new();
        let mut targets = [Paper::new(), Paper::new()];
        let locks = targets
            .iter_mut()
            .zip([150, 151])
            .map(|(target, x)| target.lock(&mut workspace, &frame(0), Rect::new(x, 100, 39, 48)));
        locks.collect::<Result<Vec<_>, LockError>>().unwrap();
        let (mut next, mut periods, mut seen) = (0, 0, vec![]);
        while next < targets.len() {
            let found = |number, bbox: Rect| seen.push((number, bbox.x));
            follow_in_turn(&mut targets, &mut next, &mut workspace, &frame(1), || true, found).unwrap();
            periods += 1;
        }
        assert_eq!(seen, [(0, 152), (1, 153)]);
        assert!(periods > 2, "{periods}");
    }
}

mod recorder {
    use super::pictures;
    use smr_core::{Image, Paper, Rect, paper};
    use std::convert::Infallible;
    use std::io::Cursor;

    include!(concat!(env!("OUT_DIR"), "/core-6.rs"));

    #[test]
    fn the_record_holds_the_answer() {
        let pictures = pictures(2);
        let frame = |number: usize| Frame::whole(Image::new(&pictures[number], 320, 240).unwrap());
        // `Paper<4096, 33>` allows search radii up to 16, so the preset is the one for a radius of 16.
        let mut tracker = Tracker::<Paper<4096, 33>>::with(paper::Config::camera_within(16)).unwrap();
        let mut bytes = Vec::new();
        let write = |piece: &[u8]| -> Result<(), Infallible> {
            bytes.extend_from_slice(piece);
            Ok(())
        };
        let Ok(mut recorder) = Recorder::begin(tracker.target(), write);
        let target = Rect::new(150, 100, 40, 48);
        tracker.lock(&frame(0), target).unwrap();
        let Ok(()) = recorder.lock(tracker.target(), &frame(0), target);
        let answer = recorded(&mut tracker, &mut recorder, &frame(1)).unwrap();
        assert_eq!(answer.bbox, Rect::new(152, 100, 40, 48));
        let report = host_sim::replay::replay(Cursor::new(bytes), false, || ()).unwrap();
        assert_eq!(report.flights[0].locks, 1);
    }
}

mod several {
    use super::pictures;
    use smr_core::Image;

    include!(concat!(env!("OUT_DIR"), "/core-7.rs"));

    #[test]
    fn both_are_locked() {
        let pictures = pictures(1);
        let frame = Frame::whole(Image::new(&pictures[0], 320, 240).unwrap());
        let config = robust::Config::refined();
        let mut targets = [(); 2].map(|()| <Robust>::with(config).unwrap());
        let mut workspace = Box::new(robust::Workspace::new());
        lock_both(&frame, &mut targets, &mut workspace).unwrap();
        for target in &mut targets {
            target.update(&mut workspace, &frame).unwrap();
        }
    }
}

mod small {
    include!(concat!(env!("OUT_DIR"), "/core-8.rs"));

    #[test]
    fn it_has_a_smaller_reach() {
        assert_eq!(slow_target().unwrap().config().reach, 5);
    }
}

mod head {
    use super::pictures;
    use embedded_hal::{digital, pwm};
    use smr_core::{Frame, Image, Rect, Robust, Tracker, robust};
    use std::cell::Cell;
    use std::convert::Infallible;
    use std::error::Error;

    struct Pin<'a>(&'a Cell<u16>);

    impl pwm::ErrorType for Pin<'_> {
        type Error = Infallible;
    }

    impl pwm::SetDutyCycle for Pin<'_> {
        fn max_duty_cycle(&self) -> u16 {
            u16::MAX
        }

        fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
            self.0.set(duty);
            Ok(())
        }
    }

    impl digital::ErrorType for Pin<'_> {
        type Error = Infallible;
    }

    impl digital::OutputPin for Pin<'_> {
        fn set_low(&mut self) -> Result<(), Infallible> {
            self.0.set(0);
            Ok(())
        }

        fn set_high(&mut self) -> Result<(), Infallible> {
            self.0.set(1);
            Ok(())
        }
    }

    /// The example loops forever; a frame of another size ends it with an error.
    #[test]
    #[allow(unused_variables, reason = "the example leaves to its reader what is done about a pin")]
    fn the_head_turns_to_the_target() {
        let pictures = pictures(1);
        let part = |y: usize| &pictures[0][(y + 80) * 320 + 60..][..160];
        let picture: Vec<u8> = (0..120).flat_map(part).copied().collect();
        let (pan, tilt, led) = (Cell::new(0), Cell::new(0), Cell::new(0));
        let (pan_pin, tilt_pin, led_pin) = (Pin(&pan), Pin(&tilt), Pin(&led));
        let mut tracker = Tracker::<Robust>::with(robust::Config::refined()).unwrap();
        let whole = || Frame::whole(Image::new(&picture, 160, 120).unwrap());
        tracker.lock(&whole(), Rect::new(90, 20, 40, 48)).unwrap();
        let mut frames = 0;
        let mut next_frame = || {
            frames += 1;
            if frames <= 3 { whole() } else { Frame::whole(Image::new(&picture, 120, 160).unwrap()) }
        };
        let seconds_since_last_frame = || 1.0 / 30.0;
        let endless = || -> Result<Infallible, Box<dyn Error>> { include!(concat!(env!("OUT_DIR"), "/core-9.rs")) };
        let ended = endless().unwrap_err().to_string();
        assert!(ended.contains("size"), "{ended}");
        // `pan` and `tilt` are duty cycles: a pulse of 1500 in 20,000 microseconds would point straight ahead.
        assert!(led.get() == 1 && pan.get() != tilt.get() && pan.get() > 0, "{pan:?} {tilt:?} {led:?}");
    }
}
