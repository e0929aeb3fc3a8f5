//! An answer as it is compared, with the names that people read: that of a record, and that of firmware.

use anyhow::{Context, Result};
use smr_core::{Answer, FineRect, State};
use smr_evaluation::name_of;

/// Every value of an answer, by the name that people read.
pub fn values(answer: &Answer) -> [(&'static str, String); 8] {
    let number = |number: Option<u16>| number.map_or("none".to_owned(), |number| number.to_string());
    [
        ("box in 1/256 pixel", described(answer.fine)),
        ("state", name_of(answer.state).to_owned()),
        ("confidence", answer.confidence.to_string()),
        ("ratio", answer.ratio.to_string()),
        ("runner-up's ratio", number(answer.runner_up_ratio)),
        ("alpha", number(answer.alpha)),
        ("scale", answer.scale.to_string()),
        ("whether it was found again", answer.found_again.to_string()),
    ]
}

/// The state with this code, as records and firmware write it.
/// Errors: no state has this code.
pub fn state(code: u32) -> Result<State> {
    let state = u8::try_from(code).ok().and_then(State::from_code);
    state.with_context(|| format!("state {code}: expected 0 to 3"))
}

/// A box, in the units of the answer.
pub fn described(FineRect { x, y, width, height }: FineRect) -> String {
    format!("{width}x{height} at ({x}, {y})")
}
