//! The confidence in the target: a running mean of each frame's evidence for it. It decides the state.
//!
//! ```text
//! evidence   = agreement + min(response, 1/2)
//! mean'      = min(mean + (1 - patience / 256) * (evidence - mean), evidence + lead)
//! confidence = 2/3 mean
//! ```
//!
//! `response` is the penalised one ([`response`](super::super::filter::response)), at least 0. It adds at most 1/2,
//! because a filter that learns from its own answers responds well to anything it follows. The early template hardly
//! learns, so its agreement adds up to 1. A patch that cannot show the target has no evidence. Unit: 1/65536.

use super::super::config::Config;
use super::super::constants::ONE;
use super::super::verification::Candidate;
use crate::track::State;

/// The largest evidence of a frame for the target: 1.5, in units of 1/65536.
const MAX_EVIDENCE: i32 = 3 << 15;
/// The least evidence for the target with which the filter learns from a frame.
const LEARNED_FROM: i32 = 37_500;
/// The requirements for finding a lost target in a search window.
struct Find {
    /// The minimum evidence in the window.
    from: i32,
    /// The minimum lead of the evidence in the window over the evidence at the place where the target was lost.
    lead: i32,
}
const FIND: Find = Find { from: 52_000, lead: 16_000 };
/// With the refiner less evidence suffices, because the network must recognise the target in what was found.
const RECOGNISED_FIND: Find = Find { from: 45_000, lead: 9_000 };
/// The maximum by which the running mean of the evidence may exceed the frame's evidence. With the default settings,
/// one frame without evidence thus makes a *tracking* target *uncertain*, and a second such frame makes it *lost*. The
/// bound improves the state, not the place: without the bound, the success rate R is higher by 0.002 +- 0.002.
const CONFIDENCE_LEAD: i32 = 29_000;

/// The evidence for the target in one frame or one window, in units of 1/65536.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Evidence(i32);

impl Evidence {
    pub(crate) const NONE: Self = Self(0);

    /// The evidence of a candidate; 0 if its patch cannot show the target.
    #[inline(never)]
    pub(crate) fn of(candidate: &Candidate) -> Self {
        if candidate.visible { Self::new(candidate.agreement, candidate.response) } else { Self(0) }
    }

    fn new(agreement: u16, response: i32) -> Self {
        Self(i32::from(agreement) + 4 * response.clamp(0, ONE / 2))
    }

    /// The evidence less `veto`, which is at least 0; no less than 0.
    pub(crate) fn less(self, veto: i32) -> Self {
        Self((self.0 - veto).max(0))
    }

    pub(crate) fn may_be_learned(self) -> bool {
        self.0 >= LEARNED_FROM
    }

    /// True if the evidence suffices to find a lost target again; with the refiner the network must also recognise it.
    /// `there` is the evidence at the target's last place.
    pub(crate) fn finds(self, there: Self, config: &Config) -> bool {
        let Find { from, lead } = if config.refines() { RECOGNISED_FIND } else { FIND };
        self.0 >= from && self.0 >= there.0 + lead
    }
}

/// The running mean of the evidence: 0 to 98,304, in units of 1/65536.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Confidence(i32);

impl Confidence {
    pub(super) const FULL: Self = Self(MAX_EVIDENCE);

    /// The confidence in a target that the refiner gives up: only redetection can find it again.
    pub(crate) const NONE: Self = Self(0);

    /// The confidence after redetection: the evidence, clamped to the range in which the state is *uncertain*. If that
    /// range is empty, the least mean at which the state is not *lost*.
    pub(crate) fn found(evidence: Evidence, config: &Config) -> Self {
        let below = |bound: u16| (3 * i32::from(bound) + 1) / 2;
        Self(evidence.0.min(below(config.uncertain_below) - 1).max(below(config.lost_below)))
    }

    pub(crate) const fn mean(self) -> i32 {
        self.0
    }

    /// Restores a saved mean; `None` if it is out of range.
    pub(crate) const fn restore(mean: i32) -> Option<Self> {
        if 0 <= mean && mean <= MAX_EVIDENCE { Some(Self(mean)) } else { None }
    }

    pub(crate) fn after(self, evidence: Evidence, patience: u8) -> Self {
        let mean = self.0 + (((evidence.0 - self.0) * (256 - i32::from(patience))) >> 8);
        Self(mean.min(evidence.0 + CONFIDENCE_LEAD))
    }

    #[inline(never)]
    pub(crate) fn state(self, config: &Config) -> State {
        let confidence = self.value();
        if confidence < config.lost_below {
            State::Lost
        } else if confidence < config.uncertain_below {
            State::Uncertain
        } else {
            State::Tracking
        }
    }

    /// True if one frame without evidence would make the target lost.
    pub(crate) fn may_be_lost_next(self, config: &Config) -> bool {
        self.after(Evidence(0), config.patience).state(config) == State::Lost
    }

    /// The confidence for the answer: 2/3 of the mean, in units of 1/65535.
    #[inline(never)]
    pub(crate) fn value(self) -> u16 {
        u16::try_from(self.0.max(0) * 2 / 3).unwrap_or(u16::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evidence_is_bounded() {
        assert_eq!(Evidence::new(0, -ONE), Evidence(0));
        assert_eq!(
            [ONE / 2, 9 * ONE].map(|response| Evidence::new(u16::MAX, response)),
            [Evidence(MAX_EVIDENCE - 1); 2]
        );
        assert_eq!([Confidence::FULL, Confidence::NONE].map(Confidence::value), [u16::MAX, 0]);
    }

    #[test]
    fn without_evidence_a_target_is_uncertain_and_then_lost() {
        let config = Config::robust();
        let next = |confidence: &Confidence| Some(confidence.after(Evidence(0), config.patience));
        let states = core::iter::successors(Some(Confidence::FULL), next).map(|confidence| confidence.state(&config));
        let runs: std::vec::Vec<State> = states.take(8).collect();
        use State::{Lost, Tracking, Uncertain};
        assert_eq!(runs, [Tracking, Uncertain, Lost, Lost, Lost, Lost, Lost, Lost]);
    }

    #[test]
    fn states_begin_at_their_thresholds() {
        let state = |mean: i32| Confidence(mean).state(&Config::robust());
        // The thresholds, 19,200 and 32,500, apply to the confidence, which is 2/3 of the mean.
        assert_eq!([state(28_799), state(28_800)], [State::Lost, State::Uncertain]);
        assert_eq!([state(48_749), state(48_750)], [State::Uncertain, State::Tracking]);
    }

    #[test]
    fn a_target_that_was_found_is_not_lost_and_not_yet_tracked() {
        for evidence in [0, FIND.from, MAX_EVIDENCE] {
            let found = Confidence::found(Evidence(evidence), &Config::robust());
            assert_eq!(found.state(&Config::robust()), State::Uncertain, "{evidence}");
        }
        // With equal thresholds no confidence is *uncertain*.
        for below in [0, 1, 2, 30_000] {
            let config = Config { lost_below: below, uncertain_below: below, ..Config::robust() };
            assert_eq!(Confidence::found(Evidence(FIND.from), &config).state(&config), State::Tracking, "{below}");
        }
    }

    #[test]
    fn a_find_needs_much_evidence_and_a_lead() {
        let finds = |there: i32, here: i32| Evidence(there).finds(Evidence(here), &Config::robust());
        assert!(finds(66_000, 50_000) && !finds(65_999, 50_000));
        assert!(finds(52_000, 36_000) && !finds(51_999, 0) && !finds(52_000, 36_001));
        #[cfg(feature = "refiner")]
        {
            let finds = |there: i32, here: i32| Evidence(there).finds(Evidence(here), &Config::refined());
            assert!(finds(45_000, 36_000) && !finds(44_999, 0) && !finds(45_000, 36_001));
        }
        assert_eq!([0, 5, 60].map(|veto| Evidence(20).less(veto)), [Evidence(20), Evidence(15), Evidence::NONE]);
        assert!(Evidence(LEARNED_FROM).may_be_learned() && !Evidence(LEARNED_FROM - 1).may_be_learned());
    }
}
