//! The network's opinion of the box: a running mean that is high if the network expects small errors. A low opinion can
//! make the state worse.
//!
//! ```text
//! trust    = -(log spread of the place + log spread of the size), from 0 to 3; 3 if the early template is exact
//! opinion' = opinion + (trust - opinion) / 8, or / 16 while the opinion rises from below 1.19
//! ```
//!
//! In training the network learns how large the errors of its estimates are. On a crop that does not show the first
//! frame's target it expects large errors. The filter cannot notice that, because it learns whatever it follows.

use super::network::Outputs;
use crate::track::State;
use crate::track::saved::{Reader, Writer};

/// The largest trust in a box, and so the largest opinion, which is the running mean of the trust: 3. Unit: 1/4096.
const MAX_TRUST: i32 = 3 << 12;
/// The opinion below which the target is *uncertain*: 1.19, as for expected errors of place and size of 0.12 box sides
/// each. Unit: 1/4096.
const UNCERTAIN_BELOW: i32 = 4864;
/// The opinion below which the target is *lost*, in units of 1/4096: 0.8, the opinion when the expected errors of place
/// and size are 0.15 box sides each. Of 95 targets covered by noise, 67 are *lost* within 30 frames. A threshold of 0.7
/// (2868) makes 55 *lost*, and changes the fraction R of right frames by +0.0008 +- 0.0006; one of 0.9 (3686) makes 80
/// *lost*, and changes R by -0.0020 +- 0.0011.
const LOST_BELOW: i32 = 3277;
/// The first opinion of a target found again: 0.8125, just above `LOST_BELOW`, so that the target begins as
/// *uncertain*. Unit: 1/4096.
const FOUND: i32 = 3328;

/// The running mean of the trust, 0 to `MAX_TRUST`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Opinion(i32);

impl Opinion {
    pub(crate) const BEST: Self = Self(MAX_TRUST);

    /// Updates the opinion by the expected errors of an estimate. `place` and `size` are the logarithms of these
    /// errors, with magnitudes below 2^28, in units of 1/4096.
    pub(crate) fn update(&mut self, [.., place, size, _]: &Outputs) {
        self.move_toward((-(place + size)).clamp(0, MAX_TRUST));
    }

    /// Updates the opinion by an exact match of the early template.
    pub(crate) fn agree(&mut self) {
        self.move_toward(MAX_TRUST);
    }

    fn move_toward(&mut self, trust: i32) {
        // Below `UNCERTAIN_BELOW`, the opinion rises half as fast: the target was doubted or found again.
        self.0 += (trust - self.0) >> if self.0 < UNCERTAIN_BELOW.min(trust) { 4 } else { 3 };
    }

    /// True if the opinion does not allow the state *tracking*.
    pub(crate) fn doubts(self) -> bool {
        self.0 < UNCERTAIN_BELOW
    }

    pub(crate) fn begin_again(&mut self) {
        *self = Self(FOUND);
    }

    pub(crate) fn state(self) -> State {
        if self.0 < LOST_BELOW {
            State::Lost
        } else if self.doubts() {
            State::Uncertain
        } else {
            State::Tracking
        }
    }

    pub(super) const SAVED: usize = 2;

    pub(crate) fn save(self, to: &mut Writer<'_>) {
        to.u16(u16::try_from(self.0).unwrap_or(u16::MAX));
    }

    pub(crate) fn read(from: &mut Reader<'_>) -> Option<Self> {
        from.u16().map(|mean| Self(mean.into())).filter(|opinion| opinion.0 <= MAX_TRUST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each spread is the logarithm of an expected error, an output of the network with a magnitude below 2^28.
    #[test]
    fn the_same_spreads_again_and_again_stay_within_bounds() {
        const LARGEST: i32 = 1 << 28;
        for (spread, end) in [(LARGEST, 0), (0, 0), (-6000, 11_993), (-LARGEST, MAX_TRUST)] {
            let mut opinion = Opinion::BEST;
            for _ in 0..100 {
                opinion.update(&[0, 0, 0, 0, spread, spread, 0]);
                assert!((0..=MAX_TRUST).contains(&opinion.0));
            }
            assert!((opinion.0 - end).abs() < 8, "{spread}: {opinion:?}");
        }
    }

    #[test]
    fn states_begin_at_their_thresholds() {
        let states = [0, LOST_BELOW - 1, LOST_BELOW, UNCERTAIN_BELOW - 1, UNCERTAIN_BELOW, MAX_TRUST]
            .map(|of| Opinion(of).state());
        use State::{Lost, Tracking, Uncertain};
        assert_eq!(states, [Lost, Lost, Uncertain, Uncertain, Tracking, Tracking]);
    }
}
