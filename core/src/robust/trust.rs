//! Trust: what the evidence says, frame after frame.

use super::tracker::State;
use super::tuning::Tuning;

/// What is believed of the track: a running mean of the evidence, in units of 1/65536.
#[derive(Clone, Copy)]
pub(super) struct Trust(i32);

impl Trust {
    /// After a look at the target that was this clear.
    pub(super) const fn new(evidence: i32) -> Self {
        Self(evidence)
    }

    pub(super) fn after(self, evidence: i32, t: &Tuning) -> Self {
        Self(self.0 + (((evidence - self.0) * t.smooth) >> 8))
    }

    pub(super) fn state(self, t: &Tuning) -> State {
        if self.0 < t.lost {
            State::Lost
        } else if self.0 < t.sure {
            State::Uncertain
        } else {
            State::Tracking
        }
    }

    pub(super) fn sweeps(self, t: &Tuning) -> bool {
        self.0 < t.sweep_below
    }

    /// 0 to 65535.
    pub(super) fn confidence(self) -> u16 {
        u16::try_from((self.0 * 2 / 3).clamp(0, 65535)).unwrap_or(0)
    }
}
