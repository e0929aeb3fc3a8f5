//! Reads the vectors of the robust tracker, in the way of the paper's.

use crate::{Hex, Words};
use smr_core::Rect;
use smr_core::robust::{Answer, Config, FineRect, State, Tracker};

/// The vectors.
pub const ROBUST: &str = include_str!("../vectors/robust.txt");

/// The most pixels of a frame in any vector.
pub const ROBUST_FRAME_PIXELS: usize = 7938;

/// A line of the vectors.
#[derive(Clone, Copy, Debug)]
pub enum RobustLine<'a> {
    /// A new tracker begins.
    Case(&'a str),
    /// Width and height of the frames to come.
    Size(u16, u16),
    /// A part of the configuration is set.
    Part,
    /// The box to lock on, and the frame.
    Lock(Rect, Hex<'a>),
    /// The next frame.
    Frame(Hex<'a>),
    /// What must be answered to it.
    Answer(RobustExpected<'a>),
}

/// An answer, number by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RobustExpected<'a> {
    pub fine: FineRect,
    pub state: &'a str,
    pub confidence: u16,
    pub ratio: u16,
    pub response: i32,
    pub scale: u32,
    pub found_again: bool,
    /// Hash of the early template.
    pub early: u32,
    /// Hash of the filter's weights.
    pub weights: u32,
}

impl RobustExpected<'static> {
    /// What `tracker` has answered.
    pub fn of(answer: &Answer, tracker: &Tracker) -> Self {
        Self {
            fine: answer.fine,
            state: match answer.state {
                State::Tracking => "tracking",
                State::Uncertain => "uncertain",
                State::Lost => "lost",
            },
            confidence: answer.confidence,
            ratio: answer.ratio,
            response: answer.response,
            scale: answer.scale,
            found_again: answer.found_again,
            early: hash(tracker.early_template().into_iter().flatten()),
            weights: hash(tracker.weights().iter().flat_map(|weight| weight.to_le_bytes())),
        }
    }
}

/// FNV-1a.
fn hash(bytes: impl Iterator<Item = u8>) -> u32 {
    bytes.fold(0x811C_9DC5, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}

/// Reads one line after the other; `config` is that of the present case.
pub struct RobustReader<'a> {
    lines: core::str::Lines<'a>,
    /// The configuration as far as it was read; complete at [`RobustLine::Lock`].
    pub config: Config,
}

impl<'a> RobustReader<'a> {
    #[must_use]
    pub fn new(text: &'a str) -> Self {
        Self { lines: text.lines(), config: Config::robust() }
    }

    /// The next line that means something; the error is the line that means nothing.
    #[allow(clippy::should_implement_trait)] // between two lines `config` is looked at
    pub fn next(&mut self) -> Option<Result<RobustLine<'a>, &'a str>> {
        loop {
            let line = self.lines.next()?;
            if !(line.is_empty() || line.starts_with('#') || line == "smr-robust-vectors 2") {
                return Some(self.read(line).ok_or(line));
            }
        }
    }

    fn read(&mut self, line: &'a str) -> Option<RobustLine<'a>> {
        let (keyword, values) = line.split_once(' ')?;
        let mut words = Words(values.split(' '));
        match keyword {
            "case" => {
                self.config = Config::robust();
                Some(RobustLine::Case(values))
            }
            "size" => Some(RobustLine::Size(words.number()?, words.number()?)),
            "lock" => Some(RobustLine::Lock(
                Rect::new(words.number()?, words.number()?, words.number()?, words.number()?),
                Hex(words.0.next()?),
            )),
            "frame" => Some(RobustLine::Frame(Hex(values))),
            "answer" => words.robust_answer().map(RobustLine::Answer),
            _ => self.set(keyword, &mut words).map(|()| RobustLine::Part),
        }
    }

    fn set(&mut self, keyword: &str, words: &mut Words<'_>) -> Option<()> {
        let config = &mut self.config;
        match keyword {
            "velocity" => config.velocity = words.switch()?,
            "near" => config.near = words.switch()?,
            "size_part" => config.size = words.switch()?,
            "verification" => config.verification = words.switch()?,
            "caution" => config.caution = words.switch()?,
            "sweep" => config.sweep = words.switch()?,
            _ => return None,
        }
        Some(())
    }
}

impl<'a> Words<'a> {
    fn switch(&mut self) -> Option<bool> {
        match self.number::<u8>()? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }

    fn hexadecimal(&mut self) -> Option<u32> {
        u32::from_str_radix(self.0.next()?, 16).ok()
    }

    fn robust_answer(&mut self) -> Option<RobustExpected<'a>> {
        Some(RobustExpected {
            fine: FineRect { x: self.number()?, y: self.number()?, width: self.number()?, height: self.number()? },
            state: self.0.next()?,
            confidence: self.number()?,
            ratio: self.number()?,
            response: self.number()?,
            scale: self.number()?,
            found_again: self.switch()?,
            early: self.hexadecimal()?,
            weights: self.hexadecimal()?,
        })
    }
}
