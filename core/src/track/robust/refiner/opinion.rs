//! The network's opinion of the box: a running mean that is high if the network expects small errors. A low opinion can
//! make the state worse.
//!
//! ```text
//! trust    = -(log spread of the place + log spread of the size), from 0 to 3; 3 if the early template is exact
//! opinion' = opinion + (trust - opinion) / 8, or / 16 while the opinion rises from below 1.19
//! given up = opinion < 1.19 in 30 updates in a row
//! ```
//!
//! In training the network learns how large the errors of its estimates are. On a crop that does not show the first
//! frame's target it expects large errors. The filter cannot notice that, because it learns whatever it follows.
//!
//! A target that is doubted for long is given up: nothing is learned, and only redetection finds it again. On
//! recordings in which the target leaves and returns elsewhere this raises R by 0.022 +- 0.010, and F by 0.029 +-
//! 0.010. After 10 updates instead of 30, R would lose 0.011 +- 0.011 on other recordings.

use super::network::Outputs;
use crate::track::State;
use crate::track::saved::{Reader, Writer};

/// The largest trust in a box, and so the largest opinion, which is the running mean of the trust: 3. Unit: 1/4096.
const MAX: i32 = 3 << 12;
/// The opinion below which the target is *uncertain*: 1.19, as for expected errors of place and size of 0.12 box sides
/// each. Unit: 1/4096.
const UNCERTAIN_BELOW: i32 = 4864;
/// The opinion below which the target is *lost*, in units of 1/4096: 0.8, the opinion when the expected errors of place
/// and size are 0.15 box sides each. Of 95 targets covered by noise, 67 are *lost* within 30 frames. A threshold of 0.7
/// (2868) makes 55 *lost*, and changes the fraction R of right frames by +0.0008 +- 0.0006; one of 0.9 (3686) makes 80
/// *lost*, and changes R by -0.0020 +- 0.0011.
const LOST_BELOW: i32 = 3277;
/// Updates in a row with an opinion below `UNCERTAIN_BELOW` after which the target is given up.
const PATIENCE: i32 = 30;
/// The first opinion of a target found again: 0.8125, just above `LOST_BELOW`, so that the target begins as
/// *uncertain*. Unit: 1/4096.
const FOUND: i32 = 3328;

/// The opinion, packed. Low 16 bits: the mean, 0 to `MAX`. High 16 bits: the number of consecutive updates, up to now,
/// with a mean below `UNCERTAIN_BELOW`; at most `PATIENCE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Opinion(i32);

impl Opinion {
    pub(crate) const BEST: Self = Self(MAX);

    /// Updates the opinion by the expected errors of an estimate. `place` and `size` are the logarithms of these
    /// errors, with magnitudes below 2^28, in units of 1/4096.
    pub(crate) fn update(&mut self, [.., place, size]: Outputs) {
        self.move_toward((-(place + size)).clamp(0, MAX));
    }

    /// Updates the opinion by an exact match of the early template.
    pub(crate) fn agree(&mut self) {
        self.move_toward(MAX);
    }

    fn move_toward(&mut self, trust: i32) {
        let (mut mean, doubted) = (self.mean(), self.0 >> 16);
        // Below `UNCERTAIN_BELOW`, the opinion rises half as fast: the target was doubted or found again.
        mean += (trust - mean) >> if mean < UNCERTAIN_BELOW.min(trust) { 4 } else { 3 };
        self.0 = if mean < UNCERTAIN_BELOW { mean | PATIENCE.min(doubted + 1) << 16 } else { mean };
    }

    pub(crate) fn gives_up(self) -> bool {
        self.0 >> 16 == PATIENCE
    }

    fn mean(self) -> i32 {
        self.0 & 0xFFFF
    }

    pub(crate) fn begin_again(&mut self) {
        *self = Self(FOUND);
    }

    pub(crate) fn state(self) -> State {
        if self.mean() < LOST_BELOW {
            State::Lost
        } else if self.mean() < UNCERTAIN_BELOW {
            State::Uncertain
        } else {
            State::Tracking
        }
    }

    pub(super) const SAVED: usize = 4;

    pub(crate) fn save(self, to: &mut Writer<'_>) {
        to.i32(self.0);
    }

    pub(crate) fn read(from: &mut Reader<'_>) -> Option<Self> {
        from.i32().map(Self).filter(|opinion| opinion.mean() <= MAX && (0..=PATIENCE).contains(&(opinion.0 >> 16)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each spread is the logarithm of an expected error, an output of the network with a magnitude below 2^28.
    #[test]
    fn the_same_spreads_again_and_again_stay_within_bounds() {
        const LARGEST: i32 = 1 << 28;
        for (spread, end) in [(LARGEST, 0), (0, 0), (-6000, 11_993), (-LARGEST, MAX)] {
            let mut opinion = Opinion::BEST;
            for _ in 0..100 {
                opinion.update([0, 0, 0, 0, spread, spread]);
                assert!((0..=MAX).contains(&opinion.mean()));
            }
            assert!((opinion.mean() - end).abs() < 8, "{spread}: {opinion:?}");
        }
    }

    #[test]
    fn states_begin_at_their_thresholds() {
        let states =
            [0, LOST_BELOW - 1, LOST_BELOW, UNCERTAIN_BELOW - 1, UNCERTAIN_BELOW, MAX].map(|of| Opinion(of).state());
        use State::{Lost, Tracking, Uncertain};
        assert_eq!(states, [Lost, Lost, Uncertain, Uncertain, Tracking, Tracking]);
    }

    #[test]
    fn a_doubted_target_is_given_up_and_found_again_uncertain() {
        let mut opinion = Opinion::BEST;
        let mut updates = 0;
        while !opinion.gives_up() {
            opinion.update([0; 6]);
            updates += 1;
        }
        // The seventh update takes the opinion below `UNCERTAIN_BELOW`, and 30 updates in a row are below it.
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
