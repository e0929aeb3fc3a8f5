//! Scores: the sum of the similarities, of every offset, and which offset is the best.

use super::grid::Patch;
use super::rounding::{index, whole};
use crate::reference::Sums;
use crate::reference::paper::similarity;
use rayon::prelude::*;

/// p by difference, for each of the 256 that bytes can have.
pub struct Similarity(Vec<Sums>);

impl Similarity {
    /// p = exp(-d / scale)
    pub fn new(scale: f64) -> Self {
        Self((0..=255).map(|difference| similarity(f64::from(difference), scale)).collect())
    }

    /// `template` with its top left corner at (`x`, `y`) of `window`; `None` if it reaches outside.
    pub fn score(&self, window: &Patch, template: &Patch, x: i64, y: i64, alpha: f64) -> Option<Sums> {
        let inside = x >= 0 && y >= 0 && x + template.columns <= window.columns && y + template.rows <= window.rows;
        if !inside {
            return None;
        }
        let mut sums = Sums { rounded: 0.0, exact: 0.0 };
        for row in 0..template.rows {
            let f = window.row(x, y + row, template.columns);
            let g = template.row(0, row, template.columns);
            for (f, g) in f.iter().zip(g) {
                let difference = (f - g).abs();
                if difference < alpha {
                    let p = self.0[index(whole(difference))];
                    sums.rounded += p.rounded;
                    sums.exact += p.exact;
                }
            }
        }
        Some(sums)
    }

    /// All offsets, row by row, as many as `template` has in `window`.
    pub fn all(&self, window: &Patch, template: &Patch, alpha: f64) -> Vec<((i64, i64), Sums)> {
        let (columns, rows) = (window.columns - template.columns + 1, window.rows - template.rows + 1);
        let row = |y| (0..columns).filter_map(move |x| Some(((x, y), self.score(window, template, x, y, alpha)?)));
        (0..rows).into_par_iter().flat_map_iter(row).collect()
    }
}

/// The offset with the largest score; of equals the one closest to the window's middle, then the upper, then the left.
pub fn best(scores: impl IntoIterator<Item = ((i64, i64), f64)>, middle: i64) -> ((i64, i64), f64) {
    let distance = |(x, y): (i64, i64)| (x - middle).pow(2) + (y - middle).pow(2);
    let order = |&(a, score_a): &((i64, i64), f64), &(b, score_b): &((i64, i64), f64)| {
        let by_tie_rule = || (distance(b), b.1, b.0).cmp(&(distance(a), a.1, a.0));
        score_a.total_cmp(&score_b).then_with(by_tie_rule)
    };
    scores.into_iter().max_by(order).expect("there is an offset")
}

/// How far the top of the parabola through three scores, one apart, lies from the middle one: at most half. 0 if it has none.
pub fn top(before: f64, at: f64, after: f64) -> f64 {
    let bend = before - 2.0 * at + after;
    if bend >= 0.0 {
        return 0.0;
    }
    super::rounding::to_zero((before - after) / 2.0 / bend, super::rounding::POSITION).clamp(-0.5, 0.5)
}
