//! The vectors of the paper's tracker.

use crate::{Vectors, Words, fnv};
use smr_core::paper::Config;
use smr_core::similarity::Table;
use smr_core::unstable::{Found, Peak, found};
use smr_core::{Answer, Paper, State, Tracker};

/// The vectors.
pub const PAPER: &str = include_str!("../vectors/conformance.txt");

/// Room for the largest box and the most offsets on an axis in the vectors.
pub type SmallPaper = Paper<128, 81>;

/// An answer, number by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expected {
    /// Left and top of the box.
    position: (i32, i32),
    state: State,
    ratio: u16,
    runner_up_ratio: Option<u16>,
    alpha: Option<u16>,
    found: Option<Found>,
    /// Hash of the template after the frame.
    template: u32,
}

static STEEP: Table = match Table::new(40) {
    Ok(table) => table,
    Err(_) => panic!("40 is in range"),
};

impl Vectors for SmallPaper {
    const FORM: &'static str = "smr-vectors 3";
    const TEXT: &'static str = PAPER;
    type Expected = Expected;

    fn default_config() -> Config {
        Config::paper()
    }

    fn set(config: &mut Config, keyword: &str, words: &mut Words<'_>) -> Option<()> {
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
            "gate_least_ratio" => config.least_ratio = words.number()?,
            "padding" => config.padding = words.number()?,
            "window" => config.window = words.radius()?,
            "growth" => config.growth = words.number()?,
            "window_limit" => config.window_limit = words.radius()?,
            "neighbourhood" => config.neighbourhood = words.number()?,
            "gate_tracking" => config.gate_tracking = words.fraction()?,
            "gate_leaving" => config.gate_leaving = words.fraction()?,
            "gate_returning" => config.gate_returning = words.fraction()?,
            "gate_lost" => config.gate_lost = words.fraction()?,
            "gate_lead" => config.gate_lead = words.number()?,
            "runner_up_always" => config.runner_up_always = words.switch()?,
            _ => return None,
        }
        Some(())
    }

    fn expected(words: &mut Words<'_>) -> Option<Expected> {
        let (position, state, ratio) = (words.pair()?, words.state()?, words.number()?);
        let (runner_up_ratio, alpha) = words.pair()?;
        let (x, y) = words.pair()?;
        let (score, runner_up) = words.pair()?;
        let asked = words.switch()?;
        if !asked && (runner_up, runner_up_ratio) != (0, 0) {
            return None;
        }
        Some(Expected {
            position,
            state,
            ratio,
            runner_up_ratio: asked.then_some(runner_up_ratio),
            alpha: Some(alpha),
            found: Some(Found { peak: Peak { x, y, score }, runner_up: asked.then_some(runner_up) }),
            template: words.hash()?,
        })
    }

    fn answered(answer: &Answer, tracker: &Tracker<Self>) -> Expected {
        let template = tracker.target().template();
        Expected {
            position: (answer.bbox.x, answer.bbox.y),
            state: answer.state,
            ratio: answer.ratio,
            runner_up_ratio: answer.runner_up_ratio,
            alpha: answer.alpha,
            found: found(tracker.workspace()),
            template: fnv(template.iter().flat_map(|template| template.rows().flatten()).copied()),
        }
    }
}
