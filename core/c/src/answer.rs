//! What a tracker says of its target after a frame.

use crate::frame::{smr_fine_rect, smr_rect};
use smr_core::{Answer, State};

/// What the tracker holds of its target after a frame.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum smr_state {
    /// The target is where the box is. The paper's: it was found inside the picture. The robust tracker's: its early template
    /// agrees, part by part.
    SMR_TRACKING = 0,
    /// The target is where the box is, partly outside the picture; the template is kept. Never from the robust tracker.
    SMR_LEAVING = 1,
    /// The target is partly hidden or changes quickly, or something else is followed: the early template hardly agrees. Never
    /// from the paper's.
    SMR_UNCERTAIN = 2,
    /// The target is not seen. The box of the paper's tracker is the last one that was believed; that of the robust one is what
    /// it follows meanwhile. Nothing is learned, and the search goes on.
    SMR_LOST = 3,
}

/// The answer of #smr_update. Ratios and the confidence are in units of 1/65535, so 65535 is 1.0.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_answer {
    /// The target's box in whole pixels.
    pub bbox: smr_rect,
    /// The same in units of 1/256 pixel. That of the paper's tracker is always whole.
    pub fine: smr_fine_rect,
    /// Whether the box is to be believed.
    pub state: smr_state,
    /// The target's size against that of the box that was locked on, in units of 1/65536. Always 65536 from the paper's tracker.
    pub scale: u32,
    /// How much speaks for the box. The paper's: `ratio`, and 0 when lost. The robust tracker's: a running mean of the early
    /// template's agreement, two thirds, and of the filter's response, one third.
    pub confidence: u16,
    /// How similar what was found is to the template. The paper's: the similarity matching ratio, rounded down. The robust
    /// tracker's: the fourth least ratio of the 16 parts of the early template.
    pub ratio: u16,
    /// The ratio of the runner-up; 0 if there is none.
    pub runner_up_ratio: u16,
    /// The threshold that this frame was scored with, in gray levels (1..256): alpha, rounded up. A pixel counted if it differed
    /// by less. 0 from the robust tracker, which has one for each place.
    pub alpha: u16,
    /// 1 if the runner-up was looked for; 0 if nothing depended on it (see `runner_up_always` in #smr_paper_config), and from the
    /// robust tracker.
    pub has_runner_up: u8,
    /// 1 if the target was lost before this frame and is not any more; else 0.
    pub found_again: u8,
}

impl From<State> for smr_state {
    fn from(state: State) -> Self {
        match state {
            State::Tracking => Self::SMR_TRACKING,
            State::Leaving => Self::SMR_LEAVING,
            State::Uncertain => Self::SMR_UNCERTAIN,
            State::Lost => Self::SMR_LOST,
        }
    }
}

impl From<Answer> for smr_answer {
    fn from(answer: Answer) -> Self {
        Self {
            bbox: answer.bbox.into(),
            fine: answer.fine.into(),
            state: answer.state.into(),
            scale: answer.scale,
            confidence: answer.confidence,
            ratio: answer.ratio,
            runner_up_ratio: answer.runner_up_ratio.unwrap_or(0),
            alpha: answer.alpha.unwrap_or(0),
            has_runner_up: answer.runner_up_ratio.is_some().into(),
            found_again: answer.found_again.into(),
        }
    }
}
