//! The network's opinion of the box, which can make the state worse: a running mean of how little it expects to err.
//!
//! ```text
//! trust    = -(log spread of the place + log spread of the size), from 0 to 3; 3 if the early template is exact
//! opinion' = opinion + (trust - opinion) / 8
//! ```
//!
//! In training the network learns how far its estimates of place and size are off. On a crop that does not show the
//! first frame's target it expects large errors. The filter cannot tell: it learns what it follows.
//!
//! The opinion changes nothing but the state. (Learning, peaks and redetection by it gained nothing on the recordings.)
//! With it 15 % of the wrong frames are *tracking* instead of 20 %; of the right ones 11 % are not, instead of 10 %.

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

/// The opinion: 0 to `MOST`.
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
        self.0 += (trust - self.0) >> 3;
    }

    /// The best state that this opinion allows.
    pub(crate) fn state(self) -> State {
        if self.0 < LOST_BELOW {
            State::Lost
        } else if self.0 < UNCERTAIN_BELOW {
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
        from.i32().filter(|opinion| (0..=MOST).contains(opinion)).map(Self)
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
                assert!((0..=MOST).contains(&opinion.0));
            }
            assert!((opinion.0 - end).abs() < 8, "{spread}: {opinion:?}");
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
    fn an_exact_match_restores_trust() {
        let mut opinion = Opinion(0);
        (0..8).for_each(|_| opinion.agree());
        assert_eq!(opinion.state(), State::Tracking);
    }
}
