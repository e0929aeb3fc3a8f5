//! The figures that trackers are compared by, their means over recordings, and how sure these are.

use super::Figures;
use crate::evaluate::means;
use serde::Serialize;

/// The figures that trackers are compared by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Headline {
    pub mean_correct: f64,
    pub mean_correct_50: f64,
    pub f: f64,
}

impl Headline {
    pub(super) fn of(figures: &Figures) -> Self {
        Self { mean_correct: figures.mean_correct, mean_correct_50: figures.mean_correct_50, f: figures.f }
    }

    /// As tables have them, in this order.
    pub(super) const COLUMNS: [&str; 3] = ["correct", "correct@0.5", "F"];

    pub(super) const fn values(self) -> [f64; 3] {
        [self.mean_correct, self.mean_correct_50, self.f]
    }

    fn from_values([mean_correct, mean_correct_50, f]: [f64; 3]) -> Self {
        Self { mean_correct, mean_correct_50, f }
    }

    pub(super) fn minus(self, other: Self) -> Self {
        let (a, b) = (self.values(), other.values());
        Self::from_values([0, 1, 2].map(|figure| a[figure] - b[figure]))
    }

    pub(super) fn mean(of: &[Self]) -> Self {
        Self::from_values([0, 1, 2].map(|figure| means::mean(&values(of, figure))))
    }

    /// Of the mean; `None` of fewer than two.
    pub(super) fn standard_error(of: &[Self]) -> Option<Self> {
        let [correct, correct_50, f] = [0, 1, 2].map(|figure| means::standard_error(&values(of, figure)));
        Some(Self::from_values([correct?, correct_50?, f?]))
    }
}

fn values(of: &[Headline], figure: usize) -> Vec<f64> {
    of.iter().map(|one| one.values()[figure]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        let of = |value: f64| Headline { mean_correct: value, mean_correct_50: 2.0 * value, f: 0.5 };
        // Mean 0.5; squares 0.09 + 0.01 + 0.16 = 0.26; 0.26 / 2 / 3 = 0.043333.
        let three = [of(0.2), of(0.4), of(0.9)];
        assert!((Headline::mean(&three).mean_correct - 0.5).abs() < 1e-12);
        let error = Headline::standard_error(&three).unwrap();
        assert!((error.mean_correct - 0.208_166_6).abs() < 1e-6, "{error:?}");
        assert!((error.mean_correct_50 - 0.416_333_2).abs() < 1e-6);
        assert_eq!(error.f, 0.0);
        assert_eq!(Headline::standard_error(&three[..1]), None);
        assert_eq!(Headline::mean(&[]), Headline::default());
    }
}
