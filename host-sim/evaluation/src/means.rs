//! Means over recordings, and their standard errors: the recordings count as a random sample.

/// Applies `of` to each figure's values over all recordings; an entry of `recordings` has all figures of one recording.
fn over(recordings: &[Vec<f64>], of: fn(&[f64]) -> f64) -> Vec<f64> {
    let values = |figure: usize| recordings.iter().map(|one| one[figure]).collect::<Vec<_>>();
    (0..recordings.first().map_or(0, Vec::len)).map(|figure| of(&values(figure))).collect()
}

pub fn means(recordings: &[Vec<f64>]) -> Vec<f64> {
    over(recordings, mean)
}

/// Returns the standard error of each mean, with variances over n - 1; `None` for fewer than two recordings.
pub fn standard_errors(recordings: &[Vec<f64>]) -> Option<Vec<f64>> {
    (recordings.len() > 1).then(|| over(recordings, standard_error))
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
        // Mean 0.5; squared deviations 0.09 + 0.01 + 0.16 = 0.26; squared standard error 0.26 / 2 / 3 = 0.043333.
        let three = [0.2, 0.4, 0.9].map(|value| vec![value, 2.0 * value, 0.5]);
        let errors = standard_errors(&three).unwrap();
        for (found, expected) in means(&three).iter().chain(&errors).zip([0.5, 1.0, 0.5, 0.208_166_6, 0.416_333_2, 0.0])
        {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
        assert_eq!(standard_errors(&three[..1]), None);
    }
}
