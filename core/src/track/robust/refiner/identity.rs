//! The identity: the network's judgement that the box shows the target of the lock, and nothing else.
//!
//! ```text
//! z         = the network's seventh output, -6 to 6; 4 if the early template is exact    a logit: 0 is undecided
//! veto      = 5/16 (1 - z), from 0 to 0.4                                                 taken from the evidence
//! identity' = identity + (z - identity) / 4
//! ```
//!
//! In training the network also sees what is not the target: things beside it, things that resemble it, boxes of other
//! recordings, wrong boxes of the tracker. A frame in which the patch cannot show the target has no z, and changes nothing.

use super::network::Outputs;
use crate::track::State;
use crate::track::saved::{Reader, Writer};

/// The logit of a frame, in units of 1/1024: -`MAX` to `MAX`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Logit(i32);

/// The largest magnitude of a logit: 6, in units of 1/1024.
const MAX: i32 = 6 << 10;
/// The identity below which the target is *uncertain*, and the logit below which a frame loses evidence: 1, in units of
/// 1/1024.
const SAME_FROM: i32 = 1 << 10;
/// The least logit with which redetection takes a window's best place for the target: 1.5, in units of 1/1024.
const FOUND_FROM: i32 = 1536;
/// The first identity of a target found again: -0.5, so that it begins as *uncertain*. Unit: 1/1024.
const FOUND: i32 = -512;
/// The most evidence that a frame loses by its logit: 0.4, in units of 1/65536.
const MAX_VETO: i32 = 26_214;

impl Logit {
    /// The logit of a frame in which the early template gives the exact place and size: 4. The network does not run.
    pub(crate) const EXACT: Self = Self(4 << 10);

    /// The logit is the network's output times 4: 1/4096 times 4 is 1/1024.
    pub(crate) fn of(&[.., logit]: &Outputs) -> Self {
        Self(logit.clamp(-MAX, MAX))
    }

    /// The evidence that a frame loses by its logit: 0 to `MAX_VETO`, in units of 1/65536.
    pub(crate) fn veto(self) -> i32 {
        (20 * (SAME_FROM - self.0)).clamp(0, MAX_VETO)
    }

    pub(crate) fn finds(self) -> bool {
        self.0 >= FOUND_FROM
    }
}

/// The running mean of the logits, in units of 1/1024: -`MAX` to `MAX`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Identity(i32);

impl Identity {
    pub(crate) const SURE: Self = Self(MAX);

    pub(crate) fn update(&mut self, Logit(logit): Logit) {
        self.0 += (logit - self.0) >> 2;
    }

    pub(crate) fn begin_again(&mut self) {
        *self = Self(FOUND);
    }

    pub(crate) fn state(self) -> State {
        if self.0 < SAME_FROM { State::Uncertain } else { State::Tracking }
    }

    /// The identity for the answer, in units of 1/65535: 0 for a logit of -6, 65535 for one of 6.
    pub(crate) fn value(self) -> u16 {
        u16::try_from((self.0 + MAX) * 16 / 3).unwrap_or(u16::MAX)
    }

    pub(super) const SAVED: usize = 2;

    pub(crate) fn save(self, to: &mut Writer<'_>) {
        to.u16(u16::try_from(self.0 + MAX).unwrap_or(0));
    }

    pub(crate) fn read(from: &mut Reader<'_>) -> Option<Self> {
        from.u16().map(|mean| Self(i32::from(mean) - MAX)).filter(|identity| identity.0 <= MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logits_and_vetoes_have_bounds() {
        let logit = |output: i32| Logit::of(&[0, 0, 0, 0, 0, 0, output]);
        assert_eq!([1 << 28, -(1 << 28), 700].map(logit), [Logit(MAX), Logit(-MAX), Logit(700)]);
        assert_eq!(
            [i32::MAX, 1024, 1023, -286, -287, i32::MIN].map(|output| logit(output).veto()),
            [0, 0, 20, 26_200, MAX_VETO, MAX_VETO]
        );
        assert!(logit(1536).finds() && !logit(1535).finds());
    }

    #[test]
    fn the_same_logit_again_and_again_stays_within_bounds() {
        for (logit, end) in [(Logit(MAX), u16::MAX), (Logit(-MAX), 0), (Logit::EXACT, 54_613)] {
            for mut identity in [Identity::SURE, Identity(-MAX), Identity(FOUND)] {
                (0..100).for_each(|_| identity.update(logit));
                assert!(identity.value().abs_diff(end) <= 16, "{logit:?}: {identity:?}");
            }
        }
    }

    #[test]
    fn a_target_that_was_found_is_uncertain_for_a_frame_at_least() {
        let mut identity = Identity::SURE;
        identity.begin_again();
        assert_eq!(identity.state(), State::Uncertain);
        identity.update(Logit(MAX));
        assert_eq!((identity.0, identity.state()), (1152, State::Tracking));
        assert_eq!([Identity(1023), Identity(1024)].map(Identity::state), [State::Uncertain, State::Tracking]);
    }
}
