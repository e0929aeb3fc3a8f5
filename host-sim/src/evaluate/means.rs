//! The mean over recordings, and how sure it is: recordings are drawn from all that there could be.

/// 0 of none.
pub fn mean(of: &[f64]) -> f64 {
    of.iter().sum::<f64>() / of.len().max(1) as f64
}

/// Of the mean: the standard deviation (over n - 1) over the square root of n. `None` of fewer than two.
pub fn standard_error(of: &[f64]) -> Option<f64> {
    let (mean, n) = (mean(of), of.len() as f64);
    let squares: f64 = of.iter().map(|one| (one - mean).powi(2)).sum();
    (of.len() > 1).then(|| (squares / (n - 1.0) / n).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        // Mean 0.5; squares 0.09 + 0.01 + 0.16 = 0.26; 0.26 / 2 / 3 = 0.043333.
        let three = [0.2, 0.4, 0.9];
        assert!((mean(&three) - 0.5).abs() < 1e-12);
        assert!((standard_error(&three).unwrap() - 0.208_166_6).abs() < 1e-6);
        assert_eq!(standard_error(&[0.5, 0.5]), Some(0.0));
        assert_eq!((standard_error(&[0.5]), mean(&[])), (None, 0.0));
    }
}
