//! The conformance vectors are those of the reference, and smr-core gives their answers: at once, in steps, and saved and restored in
//! between.

use smr_core::{Answer, Frame, Robust, Tracker};
use smr_tests::{FRAME_PIXELS, PAPER, Passed, REFINER, ROBUST, SmallPaper, Vectors, follow};
use std::process::Command;

#[test]
fn the_vectors_are_current() {
    for (method, kept) in [(&["smr"][..], PAPER), (&["robust"], ROBUST), (&["robust", "--refiner"], REFINER)] {
        let vectors = env!("CARGO_BIN_EXE_vectors");
        let made = Command::new(vectors).arg("--method").args(method).output().expect("it was built before this test");
        assert!(
            made.status.success() && made.stdout == kept.as_bytes(),
            "the vectors are not current: \
             cargo run --release -p smr-tests --bin vectors -- --method {} --out tests/vectors/...",
            method.join(" ")
        );
    }
}

/// By this machine's fastest backend: the vectors are made by the float reference and by the plain loops.
#[test]
fn smr_core_answers_as_the_vectors_say() {
    passes::<SmallPaper>(|tracker, frame| tracker.update(frame).ok());
    passes::<Robust>(|tracker, frame| tracker.update(frame).ok());
    passes_text::<Robust>(REFINER, |tracker, frame| tracker.update(frame).ok(), (3, 15));
}

#[test]
fn it_does_so_in_steps() {
    passes::<SmallPaper>(stepwise);
    passes::<Robust>(stepwise);
    passes_text::<Robust>(REFINER, stepwise, (3, 15));
}

#[test]
fn it_does_so_saved_and_restored_after_every_frame() {
    passes::<SmallPaper>(restored);
    passes::<Robust>(restored);
    passes_text::<Robust>(REFINER, restored, (3, 15));
}

#[test]
fn another_answer_is_noticed() {
    wrong::<SmallPaper>();
    wrong::<Robust>();
}

fn tracker<T: Vectors>() -> Box<Tracker<T>> {
    Box::new(Tracker::with(T::default_config()).expect("a good configuration"))
}

fn passes<T: Vectors>(update: fn(&mut Tracker<T>, &Frame<'_>) -> Option<Answer>) {
    passes_text::<T>(T::TEXT, update, (6, 60));
}

fn passes_text<T: Vectors>(text: &str, update: fn(&mut Tracker<T>, &Frame<'_>) -> Option<Answer>, least: (u32, u32)) {
    let passed = follow(&mut *tracker::<T>(), text, &mut [0; FRAME_PIXELS], update);
    let Passed { cases, answers } = passed.unwrap_or_else(|failure| panic!("{}: {failure:?}", T::FORM));
    assert!(cases >= least.0 && answers >= least.1, "{}: {cases} cases, {answers} answers", T::FORM);
}

fn stepwise<T: Vectors>(tracker: &mut Tracker<T>, frame: &Frame<'_>) -> Option<Answer> {
    loop {
        if let Some(answer) = tracker.update_step(frame, 777).ok()? {
            return Some(answer);
        }
    }
}

/// Every frame goes to a new tracker, restored from the saved one.
fn restored<T: Vectors>(tracker: &mut Tracker<T>, frame: &Frame<'_>) -> Option<Answer> {
    let mut saved = vec![0; T::SAVED_SIZE];
    let size = tracker.save(&mut saved).ok()?;
    let mut other = Tracker::<T>::with(*tracker.config()).ok()?;
    other.restore(&saved[..size]).ok()?;
    *tracker = other;
    tracker.update(frame).ok()
}

/// Every digit of the first answer matters.
fn wrong<T: Vectors>() {
    let text = T::TEXT;
    let start = text.find("\nanswer ").expect("there is an answer") + "\nanswer ".len();
    let end = start + text[start..].find('\n').expect("the line ends");
    for (at, digit) in text[start..end].char_indices().filter(|(_, letter)| letter.is_ascii_digit()) {
        let other = if digit == '1' { "0" } else { "1" };
        let changed = [&text[..start + at], other, &text[start + at + 1..end]].concat();
        // Up to the first answer: the rest is not needed.
        let changed = [&text[..start], &changed[start..]].concat();
        let said =
            follow(&mut *tracker::<T>(), &changed, &mut [0; FRAME_PIXELS], |tracker, frame| tracker.update(frame).ok());
        assert!(said.is_err(), "{}: {}", T::FORM, &changed[start..]);
    }
}
