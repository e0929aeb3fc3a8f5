//! The gate: accepts or refuses the peak of a search. The peak must exceed the runner-up enough and reach
//! `least_ratio`. If `least_ratio` is above 0, a patch inside the frame must also have enough contrast and few clipped
//! pixels.

use super::config::{Config, Fraction};
use super::search::{Peak, Peaks, Wanted};
use super::template::Template;
use super::track::Track;
use crate::image::Rect;
use crate::similarity::{Contrast, Table};
use crate::track::State;
use core::cmp::Ordering;

impl Track {
    /// True if the peak exceeds the runner-up enough for the target to enter `state`, and reaches `least_ratio`.
    #[cfg_attr(smr_small, inline(never))]
    pub(super) fn passes(&self, peaks: &Peaks, state: State, config: &Config) -> bool {
        let peak = peaks.peak.score;
        // `None`: the decision does not depend on the runner-up, so 0 stands for it.
        let runner_up = peaks.runner_up.unwrap_or(0);
        let leads = peak.saturating_sub(runner_up) > u32::from(config.gate_lead) * u32::from(Table::ONE);
        let stands_out = leads || self.ratio(state, config).exceeded_by(peak, runner_up);
        stands_out && ratio(peak, self.target.area()) >= config.least_ratio
    }

    /// The result that the gate needs from a search, to decide whether the target enters `state`.
    #[cfg_attr(smr_small, inline(never))]
    pub(super) fn wanted(&self, state: State, config: &Config) -> Wanted {
        let ratio = self.ratio(state, config);
        match ratio.numerator.cmp(&ratio.denominator) {
            _ if config.runner_up_always => Wanted::RunnerUp(config.neighbourhood),
            Ordering::Greater => Wanted::RunnerUp(config.neighbourhood),
            Ordering::Equal => Wanted::Equals(config.neighbourhood),
            Ordering::Less => Wanted::Peak,
        }
    }

    /// True if the gate's decision on `peak` needs a second search, for the runner-up.
    pub(super) fn needs_second_search(&self, peak: &Peak, config: &Config) -> bool {
        match (self.wanted(State::Tracking, config), self.wanted(self.at(peak).1, config)) {
            (Wanted::RunnerUp(_), _) | (_, Wanted::Peak) => false,
            (first, then) => first != then,
        }
    }

    #[cfg_attr(smr_small, inline(never))]
    const fn ratio(&self, state: State, config: &Config) -> Fraction {
        match (self.state, state) {
            (State::Lost, _) => config.gate_lost,
            (_, State::Leaving) => config.gate_leaving,
            _ if self.edge => config.gate_returning,
            _ => config.gate_tracking,
        }
    }
}

impl<const PIXELS: usize> Template<PIXELS> {
    /// True if a patch with the contrast `is` can show the target: it has at least a quarter of the template's
    /// contrast, and its clipped pixels exceed the template's by at most half of all pixels.
    pub(crate) fn is_shown_by(&mut self, is: Contrast) -> bool {
        if is.is_enough_for_any() {
            return true;
        }
        if self.contrast == Contrast::NONE {
            self.contrast = self.image().map_or(Contrast::NONE, Contrast::of);
        }
        is.has_contrast_of(self.contrast) && !is.is_more_clipped_than(self.contrast)
    }
}

/// One item for each of a tracked, a returning and a lost target. First value: true if the first search of an update
/// includes the runner-up. Second: true if a second search, for the runner-up, may follow.
pub(super) fn searches(config: &Config) -> impl Iterator<Item = (bool, bool)> {
    let bounds = Rect::new(0, 0, 1, 1);
    let states = [(State::Tracking, false), (State::Tracking, true), (State::Lost, false)];
    states.into_iter().map(move |(state, edge)| {
        let track = Track { state, edge, ..Track::new(bounds, bounds) };
        let [inside, outside] = [State::Tracking, State::Leaving].map(|to| track.wanted(to, config));
        let first = matches!(inside, Wanted::RunnerUp(_));
        (first, !first && outside != Wanted::Peak && outside != inside)
    })
}

/// `score` / `pixels` in units of 1/65535, rounded down.
pub(super) fn ratio(score: u32, pixels: u32) -> u16 {
    u16::try_from(score / pixels.max(1)).unwrap_or(Table::ONE)
}
