//! Trust: what the early template's agreement says, frame after frame.
//!
//! A track that learns from itself agrees with itself, whatever it follows. The early template learns so slowly (a 256th of
//! a patch in each frame, nothing while lost) that what slips in is noticed before it is learned.

use super::tracker::State;

/// Agreement in units of 1/65535: below, the target is not to be seen; far below, hardly anything of it; and it is doubtful.
const DENIED: u16 = 22_000;
const FAR_BELOW: u16 = 14_000;
const DOUBTFUL: u16 = 26_500;
/// A lost target is seen again.
pub(super) const SEEN_AGAIN: u16 = 44_000;
/// So many frames in a row in which it is not to be seen make it lost; one far below counts as three.
const PATIENCE: u8 = 5;
const FAR_COUNTS: u8 = 3;
/// So many doubtful frames in a row, and the sweep begins to look elsewhere.
const DOUBTS: u8 = 3;

/// What is believed of the track.
#[derive(Clone, Copy)]
pub(super) struct Trust {
    /// Frames in a row in which the target was not to be seen, at most [`PATIENCE`].
    denied: u8,
    /// Frames in a row in which it was doubtful, at most [`DOUBTS`].
    doubted: u8,
}

impl Trust {
    pub(super) const fn new() -> Self {
        Self { denied: 0, doubted: 0 }
    }

    /// After a frame in which the early template agrees so well.
    pub(super) fn after(self, agreement: u16) -> Self {
        if agreement >= if self.is_lost() { SEEN_AGAIN } else { DOUBTFUL } {
            return Self::new();
        }
        let count = if agreement < FAR_BELOW { FAR_COUNTS } else { 1 };
        let denied = if self.is_lost() || agreement < DENIED { (self.denied + count).min(PATIENCE) } else { 0 };
        Self { denied, doubted: (self.doubted + 1).min(DOUBTS) }
    }

    /// True if the target is to be looked for elsewhere.
    pub(super) const fn sweeps(self) -> bool {
        self.doubted >= DOUBTS
    }

    /// True if the next frame can be one in which it is looked for elsewhere.
    pub(super) const fn may_sweep_next(self) -> bool {
        self.doubted + 1 >= DOUBTS
    }

    pub(super) fn state(self, agreement: u16) -> State {
        if self.is_lost() {
            State::Lost
        } else if agreement < DOUBTFUL {
            State::Uncertain
        } else {
            State::Tracking
        }
    }

    const fn is_lost(self) -> bool {
        self.denied >= PATIENCE
    }
}

#[cfg(test)]
mod tests {
    use super::State::{Lost, Tracking, Uncertain};
    use super::*;

    fn states<const N: usize>(agreements: [u16; N]) -> [State; N] {
        let mut trust = Trust::new();
        agreements.map(|agreement| {
            trust = trust.after(agreement);
            trust.state(agreement)
        })
    }

    #[test]
    fn five_frames_make_it_lost_and_a_clear_one_ends_it() {
        let denied = DENIED - 1;
        assert_eq!(states([DOUBTFUL, DENIED, denied]), [Tracking, Uncertain, Uncertain]);
        assert_eq!(states([denied; 5]), [Uncertain, Uncertain, Uncertain, Uncertain, Lost]);
        assert_eq!(states([denied, denied, denied, denied, DENIED, denied])[5], Uncertain, "not in a row");
        let [.., doubtful, clear, after] = states([0, 0, SEEN_AGAIN - 1, SEEN_AGAIN, DOUBTFUL]);
        assert_eq!([doubtful, clear, after], [Lost, Tracking, Tracking]);
        assert_eq!(states([FAR_BELOW - 1, FAR_BELOW - 1]), [Uncertain, Lost], "far below counts as three");
        assert_eq!(states([FAR_BELOW - 1, FAR_BELOW, denied]), [Uncertain, Uncertain, Lost]);
    }

    #[test]
    fn three_doubts_begin_the_sweep() {
        let doubt = |trust: Trust| trust.after(DOUBTFUL - 1);
        let (one, two) = (doubt(Trust::new()), doubt(doubt(Trust::new())));
        assert!(!one.may_sweep_next() && two.may_sweep_next() && !two.sweeps());
        assert!(doubt(two).sweeps() && doubt(doubt(two)).sweeps() && !doubt(two).after(DOUBTFUL).sweeps());
    }
}
