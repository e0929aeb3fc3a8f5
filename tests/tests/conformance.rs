//! The conformance vectors are those of the reference, and smr-core answers as they say.

use smr_core::robust;
use smr_core::{Frame, Image};
use smr_tests::{
    CONFORMANCE, Expected, FRAME_PIXELS, Line, ROBUST, ROBUST_FRAME_PIXELS, Reader, RobustExpected, RobustLine,
    RobustReader, SmallTracker,
};

#[test]
fn the_vectors_are_the_references() {
    let made = host_sim::vectors::text();
    assert!(
        made == CONFORMANCE,
        "the vectors are not current: cargo run --release -p host-sim -- vectors --out tests/vectors/conformance.txt"
    );
}

#[test]
fn smr_core_answers_as_the_vectors_say() {
    let mut reader = Reader::new(CONFORMANCE);
    let mut buffer = [0; FRAME_PIXELS];
    let (mut size, mut name) = ((0, 0), "");
    let mut tracker = None;
    let mut answered = None;
    let (mut cases, mut answers) = (0, 0);
    while let Some(line) = reader.next() {
        match line.unwrap_or_else(|line| panic!("not understood: {line}")) {
            Line::Case(case) => (cases, name) = (cases + 1, case),
            Line::Size(width, height) => size = (width, height),
            Line::Number => {}
            Line::Lock(target, pixels) => {
                let pixels = pixels.decode(&mut buffer).expect("a frame that fits");
                let mut locked = SmallTracker::new(reader.config).unwrap();
                locked.lock(&frame(pixels, size), target).unwrap();
                tracker = Some(locked);
            }
            Line::Frame(pixels) => {
                let tracker = tracker.as_mut().expect("a lock before a frame");
                let pixels = pixels.decode(&mut buffer).expect("a frame that fits");
                let answer = tracker.update(&frame(pixels, size)).unwrap();
                answered = Some(Expected::of(&answer, tracker));
            }
            Line::Answer(expected) => {
                answers += 1;
                assert_eq!(answered, Some(expected), "case {name}, answer {answers}");
            }
        }
    }
    assert!(cases >= 4 && answers >= 30, "{cases} cases, {answers} answers");
}

#[test]
fn the_robust_vectors_are_current() {
    let made = host_sim::vectors::robust::text();
    assert!(
        made == ROBUST,
        "the vectors are not current: \
         cargo run --release -p host-sim -- vectors --config robust --out tests/vectors/robust.txt"
    );
}

/// By this machine's fastest backend: the vectors are made by the plain loops.
#[test]
fn smr_core_answers_as_the_robust_vectors_say() {
    let mut reader = RobustReader::new(ROBUST);
    let mut buffer = [0; ROBUST_FRAME_PIXELS];
    let (mut size, mut name) = ((0, 0), "");
    let mut tracker: Box<robust::Tracker> = Box::new(robust::Tracker::new(reader.config));
    let mut answered = None;
    let (mut cases, mut answers) = (0, 0);
    while let Some(line) = reader.next() {
        match line.unwrap_or_else(|line| panic!("not understood: {line}")) {
            RobustLine::Case(case) => (cases, name) = (cases + 1, case),
            RobustLine::Size(width, height) => size = (width, height),
            RobustLine::Part => {}
            RobustLine::Lock(target, pixels) => {
                let pixels = pixels.decode(&mut buffer).expect("a frame that fits");
                *tracker = robust::Tracker::new(reader.config);
                tracker.lock(&frame(pixels, size), target).unwrap();
            }
            RobustLine::Frame(pixels) => {
                let pixels = pixels.decode(&mut buffer).expect("a frame that fits");
                let answer = tracker.update(&frame(pixels, size)).unwrap();
                answered = Some(RobustExpected::of(&answer, &tracker));
            }
            RobustLine::Answer(expected) => {
                answers += 1;
                assert_eq!(answered, Some(expected), "case {name}, answer {answers}");
            }
        }
    }
    assert!(cases >= 13 && answers >= 90, "{cases} cases, {answers} answers");
}

fn frame(pixels: &[u8], (width, height): (u16, u16)) -> Frame<'_> {
    Frame::whole(Image::new(pixels, width, height).unwrap())
}
