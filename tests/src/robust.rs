//! The vectors of the robust tracker.

use crate::{Vectors, Words, fnv};
use smr_core::robust::Config;
use smr_core::unstable::{response, weights};
use smr_core::{Answer, FineRect, Robust, State, Tracker};

/// The vectors.
pub const ROBUST: &str = include_str!("../vectors/robust.txt");

/// The same with the refiner.
pub const REFINER: &str = include_str!("../vectors/refiner.txt");

/// An answer, number by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expected {
    fine: FineRect,
    state: State,
    confidence: u16,
    ratio: u16,
    response: i32,
    scale: u32,
    found_again: bool,
    /// Hashes of the early template and of the filter's weights after the frame.
    hashes: (u32, u32),
}

impl Vectors for Robust {
    const FORM: &'static str = "smr-robust-vectors 3";
    const TEXT: &'static str = ROBUST;
    type Expected = Expected;

    fn default_config() -> Config {
        Config::robust()
    }

    fn set(config: &mut Config, keyword: &str, words: &mut Words<'_>) -> Option<()> {
        match keyword {
            "reach" => config.reach = words.number()?,
            "size_part" => config.size = words.switch()?,
            "sweep" => config.sweep = words.switch()?,
            "refiner" => config.refiner = words.switch()?,
            "patience" => config.patience = words.number()?,
            "lost_below" => config.lost_below = words.number()?,
            "uncertain_below" => config.uncertain_below = words.number()?,
            "learning_rate" => config.learning_rate = words.number()?,
            "early_rate" => config.early_rate = words.number()?,
            _ => return None,
        }
        Some(())
    }

    fn expected(words: &mut Words<'_>) -> Option<Expected> {
        let ((x, y), (width, height)) = (words.pair()?, words.pair()?);
        Some(Expected {
            fine: FineRect { x, y, width, height },
            state: words.state()?,
            confidence: words.number()?,
            ratio: words.number()?,
            response: words.number()?,
            scale: words.number()?,
            found_again: words.switch()?,
            hashes: (words.hash()?, words.hash()?),
        })
    }

    fn answered(answer: &Answer, tracker: &Tracker<Self>) -> Expected {
        let target = tracker.target();
        let weights = weights(target).iter().flat_map(|weight| weight.to_le_bytes());
        Expected {
            fine: answer.fine,
            state: answer.state,
            confidence: answer.confidence,
            ratio: answer.ratio,
            response: response(tracker.workspace()),
            scale: answer.scale,
            found_again: answer.found_again,
            hashes: (fnv(target.early_template().into_iter().flatten()), fnv(weights)),
        }
    }
}
