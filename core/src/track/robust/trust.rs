//! Trust: what the evidence says, frame after frame.
//!
//! A track that learns from itself agrees with itself, whatever it follows: the filter's own response says little about whether
//! it is right. The early template hardly learns, so it counts twice as much. A response of one half is as good as any that is larger:
//! beyond, it says no more.

use super::config::Config;
use super::label::ONE;
use crate::track::State;

/// Evidence and its mean are in units of 1/65536: 1 for a template that agrees wholly, and 1/2 for a response of 1/2 or more.
const CLEAR: i32 = 3 << 15;
/// A look with less evidence is not learned from.
const LEARNED: i32 = 37_500;
/// The early template agrees so well that place and size go by it.
const CERTAIN: u16 = 55_000;
/// A lost target is found where there is so much evidence, and so much more than where it was followed.
const FOUND: i32 = 52_000;
const BETTER: i32 = 16_000;

/// Trust is at most so much more than the evidence of the present frame: a frame that shows nothing makes the target uncertain at once,
/// and not yet lost, as set by default.
const BEYOND: i32 = 29_000;

/// What a look at a place says for the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Evidence(i32);

/// True if the early template agrees so well that it says exactly where the target is.
pub(super) const fn is_certain(agreement: u16) -> bool {
    agreement >= CERTAIN
}

impl Evidence {
    /// Of a look that cannot show the target.
    pub(super) const NONE: Self = Self(0);

    /// By how well the early template agrees, in units of 1/65535, and by the filter's response.
    pub(super) fn of(agreement: u16, response: i32) -> Self {
        Self(i32::from(agreement) + 4 * response.clamp(0, ONE / 2))
    }

    /// True if what was seen may be learned.
    pub(super) fn teaches(self) -> bool {
        self.0 >= LEARNED
    }

    /// True if this is the lost target, which was followed elsewhere with the evidence `there`.
    pub(super) fn finds(self, there: Self) -> bool {
        self.0 >= FOUND && self.0 >= there.0 + BETTER
    }
}

/// The running mean of the evidence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Trust(pub(super) i32);

impl Trust {
    /// Of a target that was pointed at.
    pub(super) const fn new() -> Self {
        Self(CLEAR)
    }

    /// Of a target that was found again.
    pub(super) const fn found(evidence: Evidence) -> Self {
        Self(evidence.0)
    }

    /// A number that trust can be.
    pub(super) const fn restore(number: i32) -> Option<Self> {
        if 0 <= number && number <= CLEAR { Some(Self(number)) } else { None }
    }

    pub(super) fn after(self, evidence: Evidence, patience: u8) -> Self {
        // Both are between 0 and CLEAR.
        let mean = self.0 + (((evidence.0 - self.0) * (256 - i32::from(patience))) >> 8);
        Self(mean.min(evidence.0 + BEYOND))
    }

    pub(super) fn state(self, config: &Config) -> State {
        let confidence = self.confidence();
        if confidence < config.lost_below {
            State::Lost
        } else if confidence < config.uncertain_below {
            State::Uncertain
        } else {
            State::Tracking
        }
    }

    /// True if a frame without any evidence would make it lost.
    pub(super) fn may_be_lost_next(self, config: &Config) -> bool {
        self.after(Evidence(0), config.patience).state(config) == State::Lost
    }

    /// 0 to 65535.
    pub(super) fn confidence(self) -> u16 {
        u16::try_from(self.0.max(0) * 2 / 3).unwrap_or(u16::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evidence_is_between_nothing_and_clear() {
        assert_eq!(Evidence::of(0, -ONE), Evidence(0));
        assert_eq!([ONE / 2, 9 * ONE].map(|response| Evidence::of(u16::MAX, response)), [Evidence(CLEAR - 1); 2]);
        let confidence = |trust: Trust| trust.confidence();
        assert_eq!([confidence(Trust::new()), confidence(Trust::found(Evidence(0)))], [u16::MAX, 0]);
    }

    #[test]
    fn without_evidence_a_target_is_uncertain_and_then_lost() {
        let config = Config::robust();
        let next = |trust: &Trust| Some(trust.after(Evidence(0), config.patience));
        let states = core::iter::successors(Some(Trust::new()), next).map(|trust| trust.state(&config));
        let runs: std::vec::Vec<State> = states.take(8).collect();
        use State::{Lost, Tracking, Uncertain};
        assert_eq!(runs, [Tracking, Uncertain, Lost, Lost, Lost, Lost, Lost, Lost]);
    }

    #[test]
    fn states_begin_where_they_are_said_to() {
        let state = |mean: i32| Trust(mean).state(&Config::robust());
        // 2/3 of the mean is the confidence.
        assert_eq!([state(28_799), state(28_800)], [State::Lost, State::Uncertain]);
        assert_eq!([state(48_749), state(48_750)], [State::Uncertain, State::Tracking]);
    }

    #[test]
    fn a_find_is_clear_and_clearer_than_what_is_followed() {
        assert!(Evidence(66_000).finds(Evidence(50_000)) && !Evidence(65_999).finds(Evidence(50_000)));
        assert!(Evidence(FOUND).finds(Evidence(FOUND - BETTER)));
        assert!(!Evidence(FOUND - 1).finds(Evidence(0)) && !Evidence(FOUND).finds(Evidence(FOUND - BETTER + 1)));
        assert!(Evidence(LEARNED).teaches() && !Evidence(LEARNED - 1).teaches());
    }
}
