//! The network's opinion of the box, which can make the state worse: a running mean of how little it expects to err.
//!
//! ```text
//! trust    = -(log spread of the place + log spread of the size), from 0 to 3; 3 if the early template is exact
//! opinion' = opinion + (trust - opinion) / 8, while it rises from below 1.19 / 16
//! given up = opinion < 1.19 in 30 updates in a row
//! ```
//!
//! In training the network learns how far its estimates of place and size are off. On a crop that does not show the
//! first frame's target it expects large errors. The filter cannot tell: it learns what it follows.
//!
//! A bad opinion makes the state worse. A target that is doubted for long is given up: nothing is learned, and only
//! redetection brings it back. On recordings in which the target leaves and returns elsewhere R gains 0.022 +- 0.010 by
//! that, and F 0.029 +- 0.010. After 10 updates R would lose 0.011 +- 0.011 on others.

use super::network::Outputs;
use crate::track::State;
use crate::track::saved::{Reader, Writer};

/// The most trust. Trust and opinion are in units of 1/4096.
const MOST: i32 = 3 << 12;
/// The target is uncertain while the opinion is below this: the network expects errors of 0.12 sides.
const UNCERTAIN_BELOW: i32 = 4864;
/// It is lost while the opinion is below this: errors of 0.15 sides.
/// Of 95 targets covered by noise 67 are lost within 30 frames. With 2868 there are 55, and R +0.0008 +- 0.0006; with
/// 3686 there are 80, and R -0.0020 +- 0.0011.
const LOST_BELOW: i32 = 3277;
/// The target is given up after so many updates in a row with an opinion below `UNCERTAIN_BELOW`.
const PATIENCE: i32 = 30;
/// The opinion of a target that was found again, 0.8125: uncertain, until the network has trusted it for some frames.
const FOUND: i32 = 3328;

/// The opinion. Low 16 bits: the mean, 0 to `MOST`. High 16 bits: how many updates in a row, up to now, left it below
/// `UNCERTAIN_BELOW`; at most `PATIENCE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Opinion(i32);

impl Opinion {
    /// The opinion after a lock.
    pub(crate) const BEST: Self = Self(MOST);

    /// Follows the spreads of an estimate, which are below 2^28.
    pub(crate) fn follow(&mut self, [.., place, size]: Outputs) {
        self.near((-(place + size)).clamp(0, MOST));
    }

    /// Follows an exact match of the early template.
    pub(crate) fn agree(&mut self) {
        self.near(MOST);
    }

    fn near(&mut self, trust: i32) {
        let (mut mean, doubted) = (self.mean(), self.0 >> 16);
        // A target that was doubted or found must earn trust for twice as long.
        mean += (trust - mean) >> if mean < UNCERTAIN_BELOW.min(trust) { 4 } else { 3 };
        self.0 = if mean < UNCERTAIN_BELOW { mean | PATIENCE.min(doubted + 1) << 16 } else { mean };
    }

    /// True if the target was doubted for so long that the tracker gives it up.
    pub(crate) fn gives_up(self) -> bool {
        self.0 >> 16 == PATIENCE
    }

    fn mean(self) -> i32 {
        self.0 & 0xFFFF
    }

    /// Starts *uncertain* and with new patience, for a target that was found again.
    pub(crate) fn begin_again(&mut self) {
        *self = Self(FOUND);
    }

    /// The best state that this opinion allows.
    pub(crate) fn state(self) -> State {
        if self.mean() < LOST_BELOW {
            State::Lost
        } else if self.mean() < UNCERTAIN_BELOW {
            State::Uncertain
        } else {
            State::Tracking
        }
    }

    /// Bytes of the saved form.
    pub(super) const SAVED: usize = 4;

    pub(crate) fn save(self, to: &mut Writer<'_>) {
        to.i32(self.0);
    }

    /// Reads a saved opinion; `None` if it is out of range.
    pub(crate) fn read(from: &mut Reader<'_>) -> Option<Self> {
        from.i32().map(Self).filter(|opinion| opinion.mean() <= MOST && (0..=PATIENCE).contains(&(opinion.0 >> 16)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest sums of the network are below 2^28.
    #[test]
    fn the_same_spreads_again_and_again_stay_within_bounds() {
        const LARGEST: i32 = 1 << 28;
        for (spread, end) in [(LARGEST, 0), (0, 0), (-6000, 11_993), (-LARGEST, MOST)] {
            let mut opinion = Opinion::BEST;
            for _ in 0..100 {
                opinion.follow([0, 0, 0, 0, spread, spread]);
                assert!((0..=MOST).contains(&opinion.mean()));
            }
            assert!((opinion.mean() - end).abs() < 8, "{spread}: {opinion:?}");
        }
    }

    #[test]
    fn states_begin_at_their_thresholds() {
        let states =
            [0, LOST_BELOW - 1, LOST_BELOW, UNCERTAIN_BELOW - 1, UNCERTAIN_BELOW, MOST].map(|of| Opinion(of).state());
        use State::{Lost, Tracking, Uncertain};
        assert_eq!(states, [Lost, Lost, Uncertain, Uncertain, Tracking, Tracking]);
    }

    #[test]
    fn a_doubted_target_is_given_up_and_found_again_uncertain() {
        let mut opinion = Opinion::BEST;
        let mut updates = 0;
        while !opinion.gives_up() {
            opinion.follow([0; 6]);
            updates += 1;
        }
        // The first six leave it at `UNCERTAIN_BELOW` or above.
        assert_eq!((updates, opinion.state()), (36, State::Lost));
        opinion.begin_again();
        assert_eq!((opinion.gives_up(), opinion.state()), (false, State::Uncertain));
        let states = [(); 3].map(|()| {
            opinion.agree();
            opinion.state()
        });
        assert_eq!((opinion.0 >> 16, states), (0, [State::Uncertain, State::Uncertain, State::Tracking]));
    }
}
