//! What host and firmware tell each other, byte by byte: `core/examples/replay/main.rs` describes it.

use super::Follow;
use crate::replay::answer_values;
use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use serde::Serialize;
use smr_core::{Answer, FineRect, Rect, Target, Tracker};
use smr_evaluation::CoreKind;
use std::fmt;

const VERSION: u32 = 4;

/// What stands for a number that there is not.
const NONE: u32 = u32::MAX;

/// The file that the firmware reads.
pub const FRAMES: &str = "frames.smr";

/// The file that the firmware writes.
pub const ANSWERS: &str = "answers.smr";

/// Bytes of a record in [`ANSWERS`].
pub const RECORD: usize = 80;

/// The beginning of [`FRAMES`].
#[derive(Clone, Copy, Debug)]
pub struct Header {
    pub follow: Follow,
    pub width: u16,
    pub height: u16,
    pub frames: u32,
    pub target: Rect,
}

impl Header {
    /// As it stands in the file.
    pub fn bytes(&self) -> [u8; 44] {
        let Self { follow, width, height, frames, target } = *self;
        let place = [target.x, target.y].map(i32::cast_unsigned);
        let size = [target.width, target.height].map(u32::from);
        let magic = u32::from_le_bytes(*b"SMRF");
        let [left, top, across, down] = [place[0], place[1], size[0], size[1]];
        let (width, height) = (width.into(), height.into());
        let words = [magic, VERSION, number_of(follow), follow.step, width, height, frames, left, top, across, down];
        let mut bytes = [0; 44];
        for (bytes, word) in bytes.chunks_exact_mut(4).zip(words) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }
}

/// As it stands in both files.
const fn number_of(follow: Follow) -> u32 {
    match follow.method {
        CoreKind::Smr => 0,
        CoreKind::Robust => 1 + follow.refiner as u32,
    }
}

/// One record of [`ANSWERS`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Record {
    Hello(Hello),
    Answer {
        frame: u32,
        answered: Remembered,
        taken: Taken,
    },
    /// The stack, and the ticks of the lock.
    End(Stack, u32),
    Refused {
        frame: u32,
        why: u32,
    },
}

impl Record {
    pub fn read(bytes: &[u8; RECORD]) -> Result<Self> {
        let mut words =
            bytes.chunks_exact(4).map(|word| word.iter().rev().fold(0, |sum, &byte| sum << 8 | u32::from(byte)));
        let mut word = || words.next().unwrap_or(0);
        match word() {
            1 => Hello::read(word).map(Self::Hello),
            2 => Ok(Self::Answer {
                frame: word(),
                answered: Remembered::read(&mut word)?,
                taken: Taken::read(&mut word),
            }),
            3 => {
                let _frames = word();
                Ok(Self::End(Stack { used: word(), room: word() }, word()))
            }
            4 => Ok(Self::Refused { frame: word(), why: word() }),
            kind => bail!("the firmware sent a record of kind {kind}: expected 1 to 4"),
        }
    }
}

/// The firmware has no room for the box, or for its window.
#[derive(Debug)]
pub struct TooBig(String);

impl fmt::Display for TooBig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the box is too big for the firmware: {}", self.0)
    }
}

impl std::error::Error for TooBig {}

/// What the firmware has room for, and how fast its timer runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hello {
    method: u32,
    /// The most pixels of a box; 0 if there is no such bound.
    template: u32,
    /// The window's, to each side; 0 if it has none.
    pub radius: u16,
    pub buffer: u32,
    /// Bytes of a target, and of a workspace.
    pub target: u32,
    pub workspace: u32,
    /// This many instructions took so many ticks.
    calibration: (u32, u32),
}

impl Hello {
    fn read(mut word: impl FnMut() -> u32) -> Result<Self> {
        let version = word();
        ensure!(version == VERSION, "the firmware speaks version {version} of the protocol: expected {VERSION}");
        let hello = Self {
            method: word(),
            template: word(),
            radius: u16::try_from(word())?,
            buffer: word(),
            target: word(),
            workspace: word(),
            calibration: (word(), word()),
        };
        ensure!(
            hello.calibration.1 > 0,
            "the firmware's timer stands still: QEMU does not emulate it, or not with -icount"
        );
        Ok(hello)
    }

    /// Instructions in so many ticks.
    pub fn instructions(&self, ticks: u32) -> u64 {
        let (instructions, in_ticks) = (u64::from(self.calibration.0), u64::from(self.calibration.1).max(1));
        (u64::from(ticks) * instructions + in_ticks / 2) / in_ticks
    }

    /// Errors: The firmware follows by another method, or has no room for the box, or for its search window, wherever
    /// it will be. How much the robust tracker reads is known only on the way.
    pub fn check(&self, header: &Header) -> Result<()> {
        ensure!(
            self.method == number_of(header.follow),
            "the firmware does not follow by the method that was asked for"
        );
        let reach = 2 * u32::from(self.radius);
        let most = |size: u16, frame: u16| (u32::from(size) + reach).min(frame.into());
        let (width, height) = (header.target.width, header.target.height);
        if self.template > 0 && header.target.area() > self.template {
            return Err(self.refusal(2, header));
        }
        if most(width, header.width).saturating_mul(most(height, header.height)) > self.buffer {
            return Err(self.refusal(3, header));
        }
        Ok(())
    }

    /// What the firmware means by `why`.
    pub fn refusal(&self, why: u32, header: &Header) -> Error {
        let (width, height, radius) = (header.target.width, header.target.height, self.radius);
        match why {
            1 => anyhow!("the firmware cannot read {FRAMES}"),
            2 => Error::new(TooBig(format!(
                "{width}x{height} is {} pixels, its template has room for {}",
                header.target.area(),
                self.template
            ))),
            3 => Error::new(TooBig(format!(
                "the window{} around {width}x{height} is more than the {} pixels of its buffer",
                if radius > 0 { format!(" of +-{radius}") } else { String::new() },
                self.buffer
            ))),
            4 => anyhow!("the firmware cannot lock on the box {:?}", header.target),
            5 => anyhow!("the firmware cannot search the frame"),
            6 => anyhow!("the firmware cannot write {ANSWERS}"),
            _ => anyhow!("the firmware refuses for a reason unknown here: {why}"),
        }
    }
}

/// Stack that was used since the start, and that there is, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Stack {
    pub used: u32,
    pub room: u32,
}

/// What an update took: work, and ticks of all of it and of its longest step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Taken {
    pub work: u32,
    pub ticks: u32,
    pub longest: u32,
}

impl Taken {
    fn read(word: &mut impl FnMut() -> u32) -> Self {
        Self { work: word(), ticks: word(), longest: word() }
    }
}

/// An answer and what is remembered after it, as far as they are compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remembered {
    answer: Answer,
    /// Of the target as it is saved: templates, weights, track.
    hash: u32,
}

impl Remembered {
    fn read(word: &mut impl FnMut() -> u32) -> Result<Self> {
        let some = |word: u32| (word != NONE).then(|| u16::try_from(word)).transpose();
        let fine = FineRect { x: word().cast_signed(), y: word().cast_signed(), width: word(), height: word() };
        let answer = Answer {
            bbox: fine.whole(),
            fine,
            state: answer_values::state(word()).context("from the firmware")?,
            confidence: word().try_into()?,
            ratio: word().try_into()?,
            runner_up_ratio: some(word())?,
            alpha: some(word())?,
            scale: word(),
            found_again: word() != 0,
        };
        Ok(Self { answer, hash: word() })
    }

    /// What `tracker` has just answered.
    pub fn of<T: Target>(answer: &Answer, tracker: &Tracker<T>) -> Result<Self> {
        let mut saved = vec![0; T::SAVED_SIZE];
        let size = tracker.save(&mut saved)?;
        // FNV-1a
        let hash = |hash: u32, byte: &u8| (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193);
        Ok(Self { answer: *answer, hash: saved[..size].iter().fold(0x811C_9DC5, hash) })
    }

    /// Every value, by the name that people read.
    pub fn described(&self) -> impl Iterator<Item = (&'static str, String)> {
        let hash = ("hash of the saved target", format!("{:08x}", self.hash));
        answer_values::values(&self.answer).into_iter().chain([hash])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(words: &[u32]) -> [u8; RECORD] {
        let mut bytes = [0; RECORD];
        for (bytes, word) in bytes.chunks_exact_mut(4).zip(words) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }

    fn error<T: fmt::Debug>(result: Result<T>) -> String {
        format!("{:#}", result.unwrap_err())
    }

    fn hello() -> Hello {
        let Ok(Record::Hello(hello)) =
            Record::read(&record(&[1, VERSION, 0, 4096, 16, 9216, 4500, 4600, 2_000_000, 80_000]))
        else {
            panic!("a hello")
        };
        hello
    }

    fn header(width: u16, height: u16) -> Header {
        Header {
            follow: Follow { method: CoreKind::Smr, refiner: false, step: 0 },
            width: 320,
            height: 240,
            frames: 2,
            target: Rect::new(0, 0, width, height),
        }
    }

    #[test]
    fn other_versions_and_kinds_are_errors() {
        assert!(error(Record::read(&record(&[1, 1]))).contains("version 1 of the protocol: expected 4"));
        assert!(error(Record::read(&record(&[9]))).contains("kind 9"));
        assert!(error(Record::read(&record(&[2, 2, 0, 0, 3, 3, 4]))).contains("state 4"));
        assert!(
            error(Record::read(&record(&[1, VERSION, 0, 4096, 16, 9216, 4500, 4600, 1, 0]))).contains("stands still")
        );
    }

    #[test]
    fn a_tick_is_what_the_calibration_says() {
        assert_eq!(hello().instructions(3), 75);
    }

    #[test]
    fn a_box_that_has_no_room_is_said_to_be_too_big() {
        assert!(hello().check(&header(64, 64)).is_ok());
        let expected = "the box is too big for the firmware: 65x64 is 4160 pixels, its template has room for 4096";
        assert_eq!(error(hello().check(&header(65, 64))), expected);
        assert!(hello().check(&header(65, 64)).unwrap_err().is::<TooBig>());
        assert!(error(hello().check(&header(200, 20))).contains("+-16 around 200x20 is more than the 9216 pixels"));
    }

    #[test]
    fn negative_positions_are_read() {
        let words = [2, 7, u32::MAX, 5, 300, 400, 1, 6, 7, NONE, 8, 9, 1, 10, 11, 12, 13];
        let Ok(Record::Answer { frame, answered, taken }) = Record::read(&record(&words)) else { panic!("an answer") };
        let Remembered { answer, hash } = answered;
        assert_eq!((frame, answer.fine), (7, FineRect { x: -1, y: 5, width: 300, height: 400 }));
        assert_eq!((answer.state, answer.runner_up_ratio, answer.alpha), (smr_core::State::Leaving, None, Some(8)));
        assert_eq!((answer.found_again, hash), (true, 10));
        assert_eq!(taken, Taken { work: 11, ticks: 12, longest: 13 });
    }

    #[test]
    fn another_method_is_noticed() {
        let robust = Follow { method: CoreKind::Robust, refiner: false, step: 0 };
        let header = Header { follow: robust, ..header(9, 9) };
        assert!(error(hello().check(&header)).contains("method"));
    }
}
