//! An answer as it is compared, with the names that people read: that of a record, and that of firmware.

use crate::evaluate::name_of;
use anyhow::{Context, Result};
use smr_core::{Answer, FineRect, State};

/// All that an update answers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answered {
    pub fine: FineRect,
    pub state: State,
    pub confidence: u16,
    pub ratio: u16,
    pub runner_up_ratio: Option<u16>,
    pub alpha: Option<u16>,
    pub scale: u32,
    pub found_again: bool,
}

impl Answered {
    #[must_use]
    pub const fn of(answer: &Answer) -> Self {
        let Answer { fine, state, confidence, ratio, runner_up_ratio, alpha, scale, found_again, .. } = *answer;
        Self { fine, state, confidence, ratio, runner_up_ratio, alpha, scale, found_again }
    }

    /// Every value, by the name that people read.
    #[must_use]
    pub fn described(&self) -> [(&'static str, String); 8] {
        let number = |number: Option<u16>| number.map_or("none".to_owned(), |number| number.to_string());
        [
            ("box in 1/256 pixel", described(self.fine)),
            ("state", name_of(self.state).to_owned()),
            ("confidence", self.confidence.to_string()),
            ("ratio", self.ratio.to_string()),
            ("runner-up's ratio", number(self.runner_up_ratio)),
            ("alpha", number(self.alpha)),
            ("scale", self.scale.to_string()),
            ("whether it was found again", self.found_again.to_string()),
        ]
    }
}

/// The state with this code, as records and firmware write it.
///
/// # Errors
/// There is none.
pub fn state(code: u32) -> Result<State> {
    let state = u8::try_from(code).ok().and_then(State::from_code);
    state.with_context(|| format!("state {code}: expected 0 to 3"))
}

/// A box, in the units of the answer.
#[must_use]
pub fn described(FineRect { x, y, width, height }: FineRect) -> String {
    format!("{width}x{height} at ({x}, {y})")
}
