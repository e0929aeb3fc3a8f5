//! Verification: is it still the target? An early template, the slowest of all, is asked.
//!
//! A track that learns from itself agrees with itself, whatever it follows. The early template learns so slowly (a 256th of
//! a patch in each frame, nothing while lost) that what slips in is noticed before it is learned.

use super::tracker::State;

/// In units of 1/65535: below, the target is not to be seen; and is it again.
pub(super) const LOST: u16 = 40_000;
pub(super) const DOUBTFUL: u16 = 43_500;
/// So many frames of it in a row, before the target is said to be lost.
const PATIENCE: u8 = 3;

/// What is believed of the track.
#[derive(Clone, Copy)]
pub(super) struct Trust {
    /// Frames in a row in which the early template did not agree.
    denied: u8,
}

impl Trust {
    pub(super) const fn new() -> Self {
        Self { denied: 0 }
    }

    /// After a frame in which the early template's ratio is `agreement`.
    pub(super) fn after(self, agreement: u16) -> Self {
        if agreement >= DOUBTFUL {
            return Self::new();
        }
        let lost = self.denied >= PATIENCE;
        let denied = if lost || agreement < LOST { self.denied.saturating_add(1).min(PATIENCE) } else { 0 };
        Self { denied }
    }

    /// True if one more frame can make it lost, or leave it so.
    pub(super) const fn may_be_lost_next(self) -> bool {
        self.denied + 1 >= PATIENCE
    }

    pub(super) fn state(self, agreement: u16) -> State {
        if self.denied >= PATIENCE {
            State::Lost
        } else if agreement < DOUBTFUL {
            State::Uncertain
        } else {
            State::Tracking
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_frames_to_be_lost_and_a_clear_one_to_be_found() {
        let mut trust = Trust::new();
        let mut next = |agreement| {
            trust = trust.after(agreement);
            trust.state(agreement)
        };
        let (clear, doubtful, denied) = (DOUBTFUL, LOST, LOST - 1);
        let answers = [clear, doubtful, denied, denied, denied, doubtful, clear].map(&mut next);
        use State::{Lost, Tracking, Uncertain};
        assert_eq!(answers, [Tracking, Uncertain, Uncertain, Uncertain, Lost, Lost, Tracking]);
    }
}
