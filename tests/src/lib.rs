//! Reads the conformance vectors (`vectors/README.md` has their form) without allocating, on the host and on a target.
//!
//! The tests themselves are in `tests/`, one file a subject.

#![no_std]

mod robust;

pub use robust::{ROBUST, ROBUST_FRAME_PIXELS, RobustExpected, RobustLine, RobustReader};

/// The example of the project's README is a test, too.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;

use smr_core::similarity::Table;
use smr_core::{Answer, Config, Fraction, Margins, Radius, Rect, RunnerUp, State, Tracker};

/// The vectors.
pub const CONFORMANCE: &str = include_str!("../vectors/conformance.txt");

/// The largest area of a box and the most offsets on an axis that any vector needs.
pub type SmallTracker = Tracker<128, 81>;

/// The most pixels of a frame in any vector.
pub const FRAME_PIXELS: usize = 1536;

/// A line of the vectors.
#[derive(Clone, Copy, Debug)]
pub enum Line<'a> {
    /// A new tracker begins.
    Case(&'a str),
    /// Width and height of the frames to come.
    Size(u16, u16),
    /// A number of the configuration is set.
    Number,
    /// The box to lock on, and the frame.
    Lock(Rect, Hex<'a>),
    /// The next frame.
    Frame(Hex<'a>),
    /// What must be answered to it.
    Answer(Expected<'a>),
}

/// Pixels as hexadecimal digits.
#[derive(Clone, Copy, Debug)]
pub struct Hex<'a>(&'a str);

impl Hex<'_> {
    /// The bytes, written to the front of `buffer`; `None` if they are not hexadecimal or more than fit.
    pub fn decode<'b>(&self, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
        let digits = self.0.as_bytes().chunks_exact(2);
        let length = digits.len();
        if !digits.remainder().is_empty() || length > buffer.len() {
            return None;
        }
        for (byte, pair) in buffer.iter_mut().zip(digits) {
            *byte = u8::from_str_radix(core::str::from_utf8(pair).ok()?, 16).ok()?;
        }
        buffer.get(..length)
    }
}

/// An answer, number by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expected<'a> {
    /// Left and top of the box.
    pub position: (i32, i32),
    pub state: &'a str,
    pub ratio: u16,
    pub runner_up_ratio: Option<u16>,
    pub alpha: u16,
    pub peak: (i32, i32),
    pub score: u32,
    pub runner_up: Option<u32>,
    pub template_hash: u32,
}

impl Expected<'static> {
    /// What `tracker` has answered.
    pub fn of<const PIXELS: usize, const SPAN: usize>(answer: &Answer, tracker: &Tracker<PIXELS, SPAN>) -> Self {
        let template = tracker.template();
        let pixels = template.iter().flat_map(|template| template.rows().flatten());
        Self {
            position: (answer.bbox.x, answer.bbox.y),
            state: match answer.state {
                State::Tracking => "tracking",
                State::Leaving => "leaving",
                State::Lost => "lost",
            },
            ratio: answer.ratio,
            runner_up_ratio: answer.runner_up_ratio,
            alpha: answer.alpha,
            peak: (answer.found.peak.x, answer.found.peak.y),
            score: answer.found.peak.score,
            runner_up: answer.found.runner_up,
            template_hash: pixels.fold(0x811C_9DC5, |hash, &pixel| (hash ^ u32::from(pixel)).wrapping_mul(0x0100_0193)),
        }
    }
}

/// Reads one line after the other; `config` is that of the present case.
pub struct Reader<'a> {
    lines: core::str::Lines<'a>,
    /// The configuration as far as it was read; complete at [`Line::Lock`].
    pub config: Config,
}

static STEEP: Table = match Table::new(40) {
    Ok(table) => table,
    Err(_) => panic!("40 is in range"),
};

impl<'a> Reader<'a> {
    #[must_use]
    pub fn new(text: &'a str) -> Self {
        Self { lines: text.lines(), config: Config::paper() }
    }

    /// The next line that means something; the error is the line that means nothing.
    #[allow(clippy::should_implement_trait)] // between two lines `config` is looked at
    pub fn next(&mut self) -> Option<Result<Line<'a>, &'a str>> {
        loop {
            let line = self.lines.next()?;
            if !(line.is_empty() || line.starts_with('#') || line == "smr-vectors 3") {
                return Some(self.read(line).ok_or(line));
            }
        }
    }

    fn read(&mut self, line: &'a str) -> Option<Line<'a>> {
        let (keyword, values) = line.split_once(' ')?;
        let mut words = Words(values.split(' '));
        match keyword {
            "case" => {
                self.config = Config::paper();
                Some(Line::Case(values))
            }
            "size" => Some(Line::Size(words.number()?, words.number()?)),
            "lock" => Some(Line::Lock(
                Rect::new(words.number()?, words.number()?, words.number()?, words.number()?),
                Hex(words.0.next()?),
            )),
            "frame" => Some(Line::Frame(Hex(values))),
            "answer" => words.answer().map(Line::Answer),
            _ => self.set(keyword, &mut words).map(|()| Line::Number),
        }
    }

    fn set(&mut self, keyword: &str, words: &mut Words<'_>) -> Option<()> {
        let config = &mut self.config;
        match keyword {
            "scale" => {
                config.table = match words.number::<u16>()? {
                    255 => &Table::PAPER,
                    40 => &STEEP,
                    _ => return None,
                }
            }
            "k" => config.k = words.fraction()?,
            "first_threshold" => config.first_threshold = words.number()?,
            "least_threshold" => config.least_threshold = words.number()?,
            "update_zone" => config.update_zone = words.margins()?,
            "gate_least_ratio" => config.gate.least_ratio = words.number()?,
            "padding" => config.padding = words.number()?,
            "window" => config.window = words.radius()?,
            "growth" => config.growth = words.number()?,
            "window_limit" => config.window_limit = words.radius()?,
            "neighbourhood" => config.neighbourhood = words.number()?,
            "gate_tracking" => config.gate.tracking = words.fraction()?,
            "gate_leaving" => config.gate.leaving = words.fraction()?,
            "gate_returning" => config.gate.returning = words.fraction()?,
            "gate_lost" => config.gate.lost = words.fraction()?,
            "gate_lead" => config.gate.lead = words.number()?,
            "runner_up_always" => {
                config.runner_up = match words.number::<u8>()? {
                    0 => RunnerUp::WhenItDecides,
                    1 => RunnerUp::Always,
                    _ => return None,
                }
            }
            _ => return None,
        }
        Some(())
    }
}

struct Words<'a>(core::str::Split<'a, char>);

impl<'a> Words<'a> {
    fn number<T: core::str::FromStr>(&mut self) -> Option<T> {
        self.0.next()?.parse().ok()
    }

    fn fraction(&mut self) -> Option<Fraction> {
        Some(Fraction::new(self.number()?, self.number()?))
    }

    fn radius(&mut self) -> Option<Radius> {
        Some(Radius { x: self.number()?, y: self.number()? })
    }

    fn margins(&mut self) -> Option<Margins> {
        Some(Margins { left: self.number()?, top: self.number()?, right: self.number()?, bottom: self.number()? })
    }

    fn answer(&mut self) -> Option<Expected<'a>> {
        let mut expected = Expected {
            position: (self.number()?, self.number()?),
            state: self.0.next()?,
            ratio: self.number()?,
            runner_up_ratio: Some(self.number()?),
            alpha: self.number()?,
            peak: (self.number()?, self.number()?),
            score: self.number()?,
            runner_up: Some(self.number()?),
            template_hash: 0,
        };
        if self.number::<u8>()? == 0 {
            (expected.runner_up, expected.runner_up_ratio) = (None, None);
        }
        expected.template_hash = u32::from_str_radix(self.0.next()?, 16).ok()?;
        Some(expected)
    }
}
