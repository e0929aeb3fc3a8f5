//! The mean over recordings, and how sure it is: recordings are drawn from all that there could be.

use super::tables::error_of;
use serde::{Serialize, Serializer};

/// Figures by their names; in JSON an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Named(pub Vec<(&'static str, f64)>);

impl Serialize for Named {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().copied())
    }
}

/// Standard errors as JSON: what they are of is in their keys.
pub fn errors<S: Serializer>(of: &Option<Named>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(of.iter().flat_map(|named| &named.0).map(|&(name, error)| (error_of(name), error)))
}

impl Named {
    pub fn values(&self) -> impl Iterator<Item = f64> {
        self.0.iter().map(|&(_, value)| value)
    }

    /// What `of` makes of each figure of all recordings.
    fn over(recordings: &[Self], of: fn(&[f64]) -> f64) -> Self {
        let figures = recordings.first().map_or(&[][..], |first| &first.0);
        let values = |figure: usize| recordings.iter().map(|one| one.0[figure].1).collect::<Vec<_>>();
        Self(figures.iter().enumerate().map(|(figure, &(name, _))| (name, of(&values(figure)))).collect())
    }

    pub fn mean(recordings: &[Self]) -> Self {
        Self::over(recordings, mean)
    }

    /// Of the mean: the standard deviation (over n - 1) over the square root of n. `None` of fewer than two.
    pub fn standard_error(recordings: &[Self]) -> Option<Self> {
        (recordings.len() > 1).then(|| Self::over(recordings, standard_error))
    }
}

fn mean(of: &[f64]) -> f64 {
    of.iter().sum::<f64>() / of.len() as f64
}

fn standard_error(of: &[f64]) -> f64 {
    let (mean, n) = (mean(of), of.len() as f64);
    let squares: f64 = of.iter().map(|one| (one - mean).powi(2)).sum();
    (squares / (n - 1.0) / n).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        let of = |value: f64| Named(vec![("correct", value), ("twice", 2.0 * value), ("f", 0.5)]);
        // Mean 0.5; squares 0.09 + 0.01 + 0.16 = 0.26; 0.26 / 2 / 3 = 0.043333.
        let three = [of(0.2), of(0.4), of(0.9)];
        assert!((Named::mean(&three).0[0].1 - 0.5).abs() < 1e-12);
        let error = Named::standard_error(&three).unwrap();
        assert!((error.0[0].1 - 0.208_166_6).abs() < 1e-6, "{error:?}");
        assert!((error.0[1].1 - 0.416_333_2).abs() < 1e-6);
        assert_eq!(error.0[2], ("f", 0.0));
        assert_eq!(Named::standard_error(&three[..1]), None);
    }
}
