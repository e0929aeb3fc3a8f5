//! Reads the conformance vectors (for the format see `vectors/README.md`) and compares a tracker's answers with them, on the host and on a
//! chip, without allocating.
//!
//! The tests themselves are in `tests/`, one file per subject.

#![no_std]

mod paper;
mod robust;
mod words;

pub use paper::{PAPER, SmallPaper};
pub use robust::{REFINER, ROBUST};
pub use words::{Hex, Words};

/// The example in the project's README is a test, too.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;

use smr_core::{Answer, Frame, Image, State, Target, Tracker};

/// The most pixels of a frame in any vector.
pub const FRAME_PIXELS: usize = 7938;

/// A tracker with conformance vectors.
pub trait Vectors: Target {
    /// The first line that is not a comment.
    const FORM: &'static str;
    /// The vectors.
    const TEXT: &'static str;
    /// An answer in the vectors, number by number.
    type Expected: PartialEq;

    /// The configuration at the start of a case.
    fn default_config() -> Self::Config;

    /// Applies a line of the configuration; `None` if it is invalid.
    fn set(config: &mut Self::Config, keyword: &str, words: &mut Words<'_>) -> Option<()>;

    /// The answer in an `answer` line.
    fn expected(words: &mut Words<'_>) -> Option<Self::Expected>;

    /// The last answer of `tracker`, in the same form.
    fn answered(answer: &Answer, tracker: &Tracker<Self>) -> Self::Expected;
}

/// The number of correct cases and answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Passed {
    pub cases: u32,
    pub answers: u32,
}

/// The first wrong answer, or the first invalid line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failure<'a> {
    pub case: &'a str,
    /// The number of the answer, from 1 over all cases; 0 before the first one.
    pub answer: u32,
    pub what: &'static str,
}

/// Follows all targets of the vectors with `tracker` by `update`, and compares every answer. `buffer` has room for [`FRAME_PIXELS`].
///
/// # Errors
/// The first wrong answer, or the first invalid line.
pub fn follow<'a, T: Vectors>(
    tracker: &mut Tracker<T>,
    text: &'a str,
    buffer: &mut [u8],
    mut update: impl FnMut(&mut Tracker<T>, &Frame<'_>) -> Option<Answer>,
) -> Result<Passed, Failure<'a>> {
    let (mut passed, mut case) = (Passed::default(), "");
    let (mut config, mut size, mut answered) = (T::default_config(), (0, 0), None);
    for line in text.lines() {
        if line.is_empty() || line.starts_with('#') || line == T::FORM {
            continue;
        }
        let failure = |what| Failure { case, answer: passed.answers, what };
        let misread = || failure("a line is not understood");
        let (keyword, values) = line.split_once(' ').ok_or_else(misread)?;
        let words = &mut Words::new(values);
        match keyword {
            "case" => {
                (config, case) = (T::default_config(), values);
                passed.cases += 1;
            }
            "size" => size = words.pair().ok_or_else(misread)?,
            "lock" => {
                let target = words.rect().ok_or_else(misread)?;
                let frame = frame(words.hex().ok_or_else(misread)?, buffer, size).map_err(failure)?;
                // Only the target: a whole tracker would be built on the stack and copied.
                *tracker.parts().0 = T::with(config).map_err(|_| failure("the configuration is refused"))?;
                tracker.lock(&frame, target).map_err(|_| failure("no lock"))?;
            }
            "frame" => {
                let frame = frame(Hex::new(values), buffer, size).map_err(failure)?;
                let answer = update(tracker, &frame).ok_or(failure("no update"))?;
                answered = Some(T::answered(&answer, tracker));
            }
            "answer" => {
                let expected = T::expected(words).ok_or_else(misread)?;
                passed.answers += 1;
                if answered.take() != Some(expected) {
                    let what = "another answer than the one expected";
                    return Err(Failure { case, answer: passed.answers, what });
                }
            }
            _ => T::set(&mut config, keyword, words).ok_or_else(misread)?,
        }
    }
    Ok(passed)
}

fn frame<'b>(pixels: Hex<'_>, buffer: &'b mut [u8], (width, height): (u16, u16)) -> Result<Frame<'b>, &'static str> {
    let pixels = pixels.decode(buffer).ok_or("a frame that does not fit")?;
    Image::new(pixels, width, height).map(Frame::whole).map_err(|_| "a frame of another size")
}

/// A state by its name in the vectors.
fn state(word: &str) -> Option<State> {
    match word {
        "tracking" => Some(State::Tracking),
        "leaving" => Some(State::Leaving),
        "uncertain" => Some(State::Uncertain),
        "lost" => Some(State::Lost),
        _ => None,
    }
}

/// FNV-1a, 32 bits.
fn fnv(bytes: impl Iterator<Item = u8>) -> u32 {
    bytes.fold(0x811C_9DC5, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}
