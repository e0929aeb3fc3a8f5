//! What host and firmware tell each other, byte by byte: `core/examples/replay/main.rs` describes it.

use anyhow::{Error, Result, anyhow, bail, ensure};
use serde::Serialize;
use smr_core::{Answer, Rect, State};
use std::fmt;

const VERSION: u32 = 2;

/// The file that the firmware reads.
pub const FRAMES: &str = "frames.smr";

/// The file that the firmware writes.
pub const ANSWERS: &str = "answers.smr";

/// Bytes of a record in [`ANSWERS`].
pub const RECORD: usize = 64;

/// The beginning of [`FRAMES`].
#[derive(Clone, Copy, Debug)]
pub struct Header {
    pub width: u16,
    pub height: u16,
    pub frames: u32,
    pub target: Rect,
}

impl Header {
    /// As it stands in the file.
    #[must_use]
    pub fn bytes(&self) -> [u8; 36] {
        let Self { width, height, frames, target } = *self;
        let place = [target.x, target.y].map(i32::cast_unsigned);
        let size = [target.width, target.height].map(u32::from);
        let magic = u32::from_le_bytes(*b"SMRF");
        let words = [magic, VERSION, width.into(), height.into(), frames, place[0], place[1], size[0], size[1]];
        let mut bytes = [0; 36];
        for (bytes, word) in bytes.chunks_exact_mut(4).zip(words) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }
}

/// One record of [`ANSWERS`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Record {
    Hello(Hello),
    Answer { frame: u32, answered: Answered, ticks: u32 },
    End(Stack),
    Refused { frame: u32, why: u32 },
}

impl Record {
    /// # Errors
    /// It is none of this version.
    pub fn read(bytes: &[u8; RECORD]) -> Result<Self> {
        let mut words =
            bytes.chunks_exact(4).map(|word| word.iter().rev().fold(0, |sum, &byte| sum << 8 | u32::from(byte)));
        let mut word = || words.next().unwrap_or(0);
        match word() {
            1 => Hello::read(word).map(Self::Hello),
            2 => Ok(Self::Answer { frame: word(), answered: Answered::read(&mut word)?, ticks: word() }),
            3 => {
                let _frames = word();
                Ok(Self::End(Stack { used: word(), room: word() }))
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
    template: u32,
    /// The window's, to each side.
    pub radius: u16,
    buffer: u32,
    /// Bytes of a tracker.
    pub tracker: u32,
    /// This many instructions took so many ticks.
    calibration: (u32, u32),
}

impl Hello {
    fn read(mut word: impl FnMut() -> u32) -> Result<Self> {
        let version = word();
        ensure!(version == VERSION, "the firmware speaks version {version} of the protocol: expected {VERSION}");
        let (template, span, radius, buffer) = (word(), word(), word(), word());
        let hello =
            Self { template, radius: u16::try_from(radius)?, buffer, tracker: word(), calibration: (word(), word()) };
        ensure!(span > radius, "the firmware's window of +-{radius} has no room on an axis of {span} offsets");
        ensure!(
            hello.calibration.1 > 0,
            "the firmware's timer stands still: QEMU does not emulate it, or not with -icount"
        );
        Ok(hello)
    }

    /// Instructions in so many ticks.
    #[must_use]
    pub fn instructions(&self, ticks: u32) -> u64 {
        let (instructions, in_ticks) = (u64::from(self.calibration.0), u64::from(self.calibration.1).max(1));
        (u64::from(ticks) * instructions + in_ticks / 2) / in_ticks
    }

    /// # Errors
    /// The firmware has no room for the box, or for its search window, wherever it will be.
    pub fn check(&self, header: &Header) -> Result<()> {
        let reach = 2 * u32::from(self.radius);
        let most = |size: u16, frame: u16| (u32::from(size) + reach).min(frame.into());
        let (width, height) = (header.target.width, header.target.height);
        if header.target.area() > self.template {
            return Err(self.refusal(2, header));
        }
        if most(width, header.width).saturating_mul(most(height, header.height)) > self.buffer {
            return Err(self.refusal(3, header));
        }
        Ok(())
    }

    /// What the firmware means by `why`.
    #[must_use]
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
                "the window of +-{radius} around {width}x{height} is more than the {} pixels of its buffer",
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

/// An answer and the template after it, as far as they are compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answered {
    position: (i32, i32),
    state: State,
    ratio: u32,
    /// 0 where it was not asked for, as the score.
    runner_up_ratio: u32,
    alpha: u32,
    peak: (i32, i32),
    score: u32,
    runner_up: u32,
    has_runner_up: u32,
    template_hash: u32,
}

impl Answered {
    fn read(word: &mut impl FnMut() -> u32) -> Result<Self> {
        Ok(Self {
            position: (word().cast_signed(), word().cast_signed()),
            state: match word() {
                0 => State::Tracking,
                1 => State::Leaving,
                2 => State::Lost,
                other => bail!("the firmware sent state {other}: expected 0 to 2"),
            },
            ratio: word(),
            runner_up_ratio: word(),
            alpha: word(),
            peak: (word().cast_signed(), word().cast_signed()),
            score: word(),
            runner_up: word(),
            has_runner_up: word(),
            template_hash: word(),
        })
    }

    /// What `tracker` has just answered.
    #[must_use]
    pub fn of(answer: &Answer, tracker: &crate::Tracker) -> Self {
        let template = tracker.template();
        let pixels = template.iter().flat_map(|template| template.rows().flatten());
        Self {
            position: (answer.bbox.x, answer.bbox.y),
            state: answer.state,
            ratio: answer.ratio.into(),
            runner_up_ratio: answer.runner_up_ratio.unwrap_or(0).into(),
            alpha: answer.alpha.into(),
            peak: (answer.found.peak.x, answer.found.peak.y),
            score: answer.found.peak.score,
            runner_up: answer.found.runner_up.unwrap_or(0),
            has_runner_up: answer.found.runner_up.is_some().into(),
            // FNV-1a
            template_hash: pixels.fold(0x811C_9DC5, |hash, &pixel| (hash ^ u32::from(pixel)).wrapping_mul(0x0100_0193)),
        }
    }

    /// Every value, by the name that people read.
    #[must_use]
    pub fn described(&self) -> [(&'static str, String); 10] {
        [
            ("box's position", format!("{:?}", self.position)),
            ("state", format!("{:?}", self.state)),
            ("ratio", self.ratio.to_string()),
            ("runner-up's ratio", self.runner_up_ratio.to_string()),
            ("alpha", self.alpha.to_string()),
            ("peak's position", format!("{:?}", self.peak)),
            ("peak's score", self.score.to_string()),
            ("runner-up's score", self.runner_up.to_string()),
            ("whether there is a runner-up", self.has_runner_up.to_string()),
            ("template's hash", format!("{:08x}", self.template_hash)),
        ]
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
        let Ok(Record::Hello(hello)) = Record::read(&record(&[1, 2, 4096, 33, 16, 9216, 4500, 2_000_000, 80_000]))
        else {
            panic!("a hello")
        };
        hello
    }

    fn header(width: u16, height: u16) -> Header {
        Header { width: 320, height: 240, frames: 2, target: Rect::new(0, 0, width, height) }
    }

    #[test]
    fn other_versions_and_kinds_are_errors() {
        assert!(error(Record::read(&record(&[1, 1]))).contains("version 1 of the protocol: expected 2"));
        assert!(error(Record::read(&record(&[9]))).contains("kind 9"));
        assert!(error(Record::read(&record(&[2, 2, 0, 0, 3]))).contains("state 3"));
        assert!(error(Record::read(&record(&[1, 2, 4096, 33, 16, 9216, 4500, 1, 0]))).contains("stands still"));
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
        let words = [2, 7, u32::MAX, 5, 1, 6, 7, 8, u32::MAX - 1, 4, 9, 10, 1, 11, 12];
        let Ok(Record::Answer { frame, answered, ticks }) = Record::read(&record(&words)) else { panic!("an answer") };
        assert_eq!((frame, answered.position, answered.peak, ticks), (7, (-1, 5), (-2, 4), 12));
        assert_eq!(answered.state, State::Leaving);
    }
}
