//! The rule of the choice. Of the candidates that fit the chip's RAM and reach the wanted frames a second, the most
//! accurate one is the best. The choice is the cheapest of those whose paired difference to the best is at most one
//! standard error.

use super::candidate::Candidate;
use super::chip::Wanted;
use super::measurement::Measurement;
use crate::means::{means, standard_errors};
use anyhow::{Result, ensure};
use std::cmp::Ordering;

/// Of 20 updates, 19 take at most the time by which a candidate is judged.
const OF_20: usize = 19;

/// A candidate on all recordings, and on the chip.
pub(super) struct Row<'a> {
    pub candidate: &'a Candidate,
    pub own: &'a [Measurement],
    /// Pixels of the largest box.
    pub area: usize,
    /// Cycles that 19 of 20 updates take at most.
    pub cycles: f64,
    pub most_cycles: f64,
    /// Bytes of target, workspace and the most pixels that an update reads.
    pub ram: usize,
}

/// A mean over recordings with its standard error, which one recording has not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mean {
    pub value: f64,
    pub error: Option<f64>,
}

impl Mean {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let values: Vec<Vec<f64>> = values.map(|value| vec![value]).collect();
        let error = standard_errors(&values).map(|errors| errors[0]);
        Self { value: means(&values).first().copied().unwrap_or(0.0), error }
    }

    /// True if zero is within one standard error.
    fn is_none(self) -> bool {
        self.value.abs() <= self.error.unwrap_or(0.0)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fit {
    Fits,
    TooSlow,
    TooLarge,
}

impl<'a> Row<'a> {
    /// Errors: No recording has a second frame, in which the tracker would be updated.
    pub fn of(candidate: &'a Candidate, own: &'a [Measurement], wanted: &Wanted) -> Result<Self> {
        let mut work: Vec<u32> = own.iter().flat_map(|one| one.work.iter().copied()).collect();
        work.sort_unstable();
        ensure!(
            !work.is_empty(),
            "the recordings have one frame each: expected frames in which the target is followed"
        );
        let rate = wanted.chip.processor.cycles_per_work(candidate.tracker)?;
        let most = |of: fn(&Measurement) -> usize| own.iter().map(of).max().unwrap_or(0);
        let area = most(|one| one.area);
        let usual = work[(work.len() * OF_20).div_ceil(20) - 1];
        let most_work = work[work.len() - 1];
        Ok(Self {
            candidate,
            own,
            area,
            cycles: rate * f64::from(usual),
            most_cycles: rate * f64::from(most_work),
            ram: candidate.bytes(area) + most(|one| one.most_pixels),
        })
    }
}

impl Row<'_> {
    pub fn right(&self) -> Mean {
        Mean::of(self.own.iter().map(Measurement::right))
    }

    /// The mean difference to `other`, recording by recording.
    pub fn minus(&self, other: &Self) -> Mean {
        Mean::of(self.own.iter().zip(other.own).map(|(own, other)| own.right() - other.right()))
    }

    pub fn fps(&self, wanted: &Wanted) -> f64 {
        f64::from(wanted.chip.clock_mhz) * 1e6 / self.cycles.max(1.0)
    }

    pub fn fit(&self, wanted: &Wanted) -> Fit {
        if self.ram > wanted.chip.ram() {
            Fit::TooLarge
        } else if self.fps(wanted) < f64::from(wanted.fps) {
            Fit::TooSlow
        } else {
            Fit::Fits
        }
    }

    fn is_cheaper(&self, other: &Self) -> bool {
        (self.cycles, self.ram) < (other.cycles, other.ram)
    }
}

/// Indices of the choice, and of the most accurate candidate that fits; often the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Decision {
    pub chosen: usize,
    pub best: usize,
}

/// Returns `None` if no candidate fits.
pub(super) fn choose(rows: &[Row<'_>], wanted: &Wanted) -> Option<Decision> {
    let fitting = || (0..rows.len()).filter(|&at| rows[at].fit(wanted) == Fit::Fits);
    let cheaper = |a: usize, b: usize| if rows[b].is_cheaper(&rows[a]) { b } else { a };
    let better = |a: usize, b: usize| match rows[b].right().value.total_cmp(&rows[a].right().value) {
        Ordering::Greater => b,
        Ordering::Equal => cheaper(a, b),
        Ordering::Less => a,
    };
    let best = fitting().reduce(better)?;
    let as_good = fitting().filter(|&at| rows[at].minus(&rows[best]).is_none());
    Some(Decision { chosen: as_good.reduce(cheaper)?, best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::choice::chip::CHIPS;

    const WANTED: Wanted = Wanted { chip: CHIPS[0], fps: 30 };

    /// The measurements of a candidate by its right frames in each recording.
    fn measured(right: &[f64]) -> Vec<Measurement> {
        let one = |&clean: &f64| Measurement {
            sequence: String::new(),
            clean,
            faults: Vec::new(),
            work: Vec::new(),
            most_pixels: 0,
            area: 0,
        };
        right.iter().map(one).collect()
    }

    /// The index of the choice and of the best one: rights, millions of cycles, bytes of each candidate.
    fn chosen(rows: &[(&[f64], f64, usize)]) -> Option<(usize, usize)> {
        let (candidate, all) = (&Candidate::all()[0], rows.iter().map(|row| measured(row.0)).collect::<Vec<_>>());
        let row = |(&(_, millions, ram), own)| {
            let cycles = millions * 1e6;
            Row { candidate, own: own as &[Measurement], area: 0, cycles, most_cycles: cycles, ram }
        };
        let rows: Vec<Row<'_>> = rows.iter().zip(all.iter().map(Vec::as_slice)).map(row).collect();
        choose(&rows, &WANTED).map(|Decision { chosen, best }| (chosen, best))
    }

    #[test]
    fn the_best_that_fits_unless_a_cheaper_one_is_as_good() {
        // 133 MHz and 30 frames a second leave 4.43 million cycles.
        let (sure, mixed): (&[f64], &[f64]) = (&[0.9, 0.8, 0.7], &[0.8, 0.7, 0.6]);
        assert_eq!(chosen(&[(mixed, 1.0, 9), (sure, 2.0, 9)]), Some((1, 1)), "a difference of 0.1 without error");
        // Differences of -0.1, -0.1 and 0.17: -0.01 +- 0.09.
        assert_eq!(chosen(&[(&[0.8, 0.7, 0.87], 1.0, 9), (sure, 2.0, 9)]), Some((0, 1)));
        assert_eq!(chosen(&[(&[0.8, 0.7, 0.87], 3.0, 9), (sure, 2.0, 9)]), Some((1, 1)), "the best is the cheapest");
        assert_eq!(chosen(&[(mixed, 1.0, 9), (sure, 5.0, 9)]), Some((0, 0)), "the best is too slow");
        assert_eq!(chosen(&[(mixed, 1.0, 9), (sure, 2.0, 264 * 1024 + 1)]), Some((0, 0)), "the best is too large");
        assert_eq!(chosen(&[(sure, 5.0, 9)]), None);
    }

    #[test]
    fn one_recording_has_no_error_and_ties_go_to_the_cheaper_one() {
        assert_eq!(chosen(&[(&[0.89], 1.0, 9), (&[0.9], 2.0, 9)]), Some((1, 1)));
        assert_eq!(chosen(&[(&[0.9], 2.0, 9), (&[0.9], 2.0, 8)]), Some((1, 1)));
        assert_eq!(Mean::of([0.2, 0.4].into_iter()), Mean { value: 0.300_000_000_000_000_04, error: Some(0.1) });
    }
}
