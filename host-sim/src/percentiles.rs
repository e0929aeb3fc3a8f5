//! Many measurements as three numbers: median, 95th percentile, largest.

use serde::Serialize;
use std::cmp::Ordering;

/// The median (the larger of two middle values), the 95th percentile and the largest of some measurements. Each is a measured
/// value; nothing is interpolated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Spread<T> {
    pub median: T,
    pub p95: T,
    pub max: T,
}

impl<T: Copy + Default + PartialOrd> Spread<T> {
    /// All zero, if there is no measurement.
    pub fn of(measurements: &[T]) -> Self {
        let mut sorted = measurements.to_vec();
        sorted.sort_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
        let at = |index: usize| sorted.get(index).copied().unwrap_or_default();
        Self {
            median: at(sorted.len() / 2),
            p95: at((sorted.len() * 95).div_ceil(100).saturating_sub(1)),
            max: at(sorted.len().saturating_sub(1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_and_the_95th_of_a_hundred() {
        let expected = Spread { median: 51, p95: 95, max: 100 };
        assert_eq!(Spread::of(&(1..=100).rev().collect::<Vec<u64>>()), expected);
    }

    #[test]
    fn of_few_and_of_none() {
        assert_eq!(Spread::of(&[7]), Spread { median: 7, p95: 7, max: 7 });
        assert_eq!(Spread::of(&[0.5, 2.0, 1.0]), Spread { median: 1.0, p95: 2.0, max: 2.0 });
        assert_eq!(Spread::<u64>::of(&[]), Spread::default());
    }

    #[test]
    fn one_in_twenty_may_lie_above_the_95th() {
        let mut measurements = vec![1_u64; 19];
        measurements.push(100);
        assert_eq!(Spread::of(&measurements), Spread { median: 1, p95: 1, max: 100 });
        measurements.push(100);
        assert_eq!(Spread::of(&measurements), Spread { median: 1, p95: 100, max: 100 });
    }
}
