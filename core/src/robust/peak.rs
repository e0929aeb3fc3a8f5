//! The peak on the grid: the search's, then the best of its neighbourhood by both templates, then a parabola.

use super::grid::PIXEL;

/// Where between its neighbours a maximum lies, in units of 1/4096 of their distance, -2048 to 2048: the top of the parabola
/// through three scores one apart. 0 if the middle one is no maximum.
pub(super) fn top(before: u32, at: u32, after: u32) -> i64 {
    let [before, at, after] = [before, at, after].map(i64::from);
    let bend = before - 2 * at + after;
    if bend >= 0 {
        return 0;
    }
    // Scores are below 2^32: the product is below 2^44.
    ((before - after) * (PIXEL / 2) / bend).clamp(-PIXEL / 2, PIXEL / 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_top_of_a_parabola() {
        let parabola = |top: i64, x: i64| u32::try_from(1_000_000 - (x * 4096 - top).pow(2) / 4096).unwrap();
        for at in [-2000, -1, 0, 1, 777, 2048] {
            let found = top(parabola(at, -1), parabola(at, 0), parabola(at, 1));
            assert!((found - at).abs() <= 1, "{at}: {found}");
        }
    }

    #[test]
    fn flat_and_extreme_scores_stay() {
        assert_eq!(top(5, 5, 5), 0);
        assert_eq!(top(9, 5, 9), 0);
        assert_eq!(top(u32::MAX, u32::MAX, 0), -2048);
        assert_eq!(top(0, u32::MAX, 0), 0);
    }
}
