//! The result of an update: the target's box, state and confidence.

use crate::frame::{smr_fine_rect, smr_rect};
use smr_core::{Answer, State};

/// The state of the target after a frame, as the tracker judges it.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum smr_state {
    /// The target is in the box. Paper's tracker: the box is inside the frame. Robust tracker: the box matches, tile by
    /// tile, the early template, which is a running mean of the target's pixels that learns very slowly.
    SMR_TRACKING = 0,
    /// The box, with the target in it, is partly outside the frame. The template is not updated. Paper's tracker only.
    SMR_LEAVING = 1,
    /// The box hardly matches the early template: the target is partly hidden or changes quickly, or the tracker
    /// follows something else. The paper tracker never returns this state.
    SMR_UNCERTAIN = 2,
    /// The target is not visible; the search continues. The box is the last accepted one (paper tracker) or the
    /// current best guess (robust tracker). Nothing is learned, unless only the refiner judges the target lost.
    SMR_LOST = 3,
}

/// The result of #smr_update. Ratios and confidence are in units of 1/65535: 65535 is 1.0.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_answer {
    /// The target's box in whole pixels.
    pub bbox: smr_rect,
    /// The target's box in units of 1/256 pixel. The paper tracker returns only multiples of 256, that is, whole
    /// pixels.
    pub fine: smr_fine_rect,
    /// The reliability of the box: tracking, leaving, uncertain or lost.
    pub state: smr_state,
    /// The target's size relative to its size at the lock, in units of 1/65536; always 65536 from the paper tracker.
    pub scale: u32,
    /// The confidence in the box. The paper tracker: `ratio`, or 0 when lost. The robust tracker: 2/3 of the running
    /// mean, over the frames, of the evidence. A frame's evidence is the agreement with the early template (0 to 1)
    /// plus the filter response (clamped to 0 to 1/2).
    pub confidence: u16,
    /// The similarity of the box to the template. The paper tracker: the similarity matching ratio, rounded down. The
    /// robust tracker: the fourth lowest of the similarity matching ratios of the early template's 16 tiles.
    pub ratio: u16,
    /// The ratio of the runner-up, which is the best match outside the neighbourhood of the best match (see
    /// `neighbourhood` in #smr_paper_config); 0 if there is no runner-up.
    pub runner_up_ratio: u16,
    /// Alpha, the threshold of this frame, rounded up to whole gray levels (1 to 256): a pixel matched if it differed
    /// from the template by less. 0 from the robust tracker, whose threshold follows the contrast of each patch.
    pub alpha: u16,
    /// The judgement of the refiner's network that the box shows the target of the lock, a running mean over about four
    /// frames: 65535 is certain, 32768 undecided, 0 certain that it shows something else. Below 38229 the state is
    /// #SMR_UNCERTAIN or #SMR_LOST. 0 without the refiner.
    pub identity: u16,
    /// 1 if the tracker searched for the runner-up; 0 if no decision needed a runner-up (see setting `runner_up_always`
    /// in #smr_paper_config). Always 0 from the robust tracker.
    pub has_runner_up: u8,
    /// 1 if the answer has an identity, that is, from the robust tracker with the refiner; else 0.
    pub has_identity: u8,
    /// 1 if the target was lost in the previous frame and is found in this one; else 0.
    pub found_again: u8,
}

// The states have the same codes in C and in smr-core.
const _: () = assert!(
    State::Tracking.code() as i32 == smr_state::SMR_TRACKING as i32
        && State::Leaving.code() as i32 == smr_state::SMR_LEAVING as i32
        && State::Uncertain.code() as i32 == smr_state::SMR_UNCERTAIN as i32
        && State::Lost.code() as i32 == smr_state::SMR_LOST as i32
        && State::ALL.len() == 4
);

impl From<State> for smr_state {
    fn from(state: State) -> Self {
        match state {
            State::Tracking => Self::SMR_TRACKING,
            State::Leaving => Self::SMR_LEAVING,
            State::Uncertain => Self::SMR_UNCERTAIN,
            _ => Self::SMR_LOST, // there is no other: the assertion above counts them
        }
    }
}

impl From<smr_answer> for Answer {
    fn from(answer: smr_answer) -> Self {
        let state = State::from_code((answer.state as i32).to_le_bytes()[0]).unwrap_or(State::Lost);
        let mut of_core = Self::new(answer.fine.into(), state);
        of_core.bbox = answer.bbox.into();
        (of_core.confidence, of_core.ratio) = (answer.confidence, answer.ratio);
        of_core.runner_up_ratio = (answer.has_runner_up != 0).then_some(answer.runner_up_ratio);
        of_core.alpha = (answer.alpha != 0).then_some(answer.alpha);
        of_core.identity = (answer.has_identity != 0).then_some(answer.identity);
        (of_core.scale, of_core.found_again) = (answer.scale, answer.found_again != 0);
        of_core
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
            identity: answer.identity.unwrap_or(0),
            has_runner_up: answer.runner_up_ratio.is_some().into(),
            has_identity: answer.identity.is_some().into(),
            found_again: answer.found_again.into(),
        }
    }
}
