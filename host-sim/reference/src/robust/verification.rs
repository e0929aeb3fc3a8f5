//! Agreement, tile by tile, of a patch with the early template adapted to the patch's brightness and contrast.

use super::Numbers;
use super::lighting::{relit, threshold};
use super::rounding::{index, to_f64, to_i64};
use super::sampling::Patch;
use crate::paper::{UNITS, similarity};

/// Table of the similarity p = exp(-d / scale) in units of 1/65535, for each absolute difference d of two bytes.
pub struct Similarity(Vec<f64>);

impl Similarity {
    pub fn new(scale: f64) -> Self {
        Self((0..=255).map(|difference| similarity(f64::from(difference), scale).rounded).collect())
    }

    /// Agreement, 0 to 65535. Each tile's similarity is the mean over its pixels; the tile of rank
    /// [`Numbers::counted_tile_rank`] counts (rank 1 is the least similar tile).
    pub fn agreement(&self, numbers: &Numbers, seen: &Patch, early: &Patch, gain: f64) -> f64 {
        let lit = relit(early, seen, gain);
        let (alpha, across) = (threshold(numbers, early, seen, gain), numbers.tiles_across);
        let mut ratios: Vec<f64> = (0..across * across)
            .map(|tile| {
                let cut = |side: i64, number: i64| number * side / across;
                let (left, top) = (cut(seen.columns, tile % across), cut(seen.rows, tile / across));
                let (right, bottom) = (cut(seen.columns, tile % across + 1), cut(seen.rows, tile / across + 1));
                let cut = |patch: &Patch| patch.cut(left, top, right - left, bottom - top).expect("tiles lie in it");
                (self.score(&cut(seen), &cut(&lit), alpha) / to_f64((right - left) * (bottom - top))).floor()
            })
            .collect();
        ratios.sort_by(f64::total_cmp);
        ratios[numbers.counted_tile_rank - 1].min(UNITS)
    }

    pub fn score(&self, seen: &Patch, lit: &Patch, alpha: f64) -> f64 {
        let differences = seen.pixels.iter().zip(&lit.pixels).map(|(f, g)| (f - g).abs());
        differences.filter(|&d| d < alpha).map(|d| self.0[index(to_i64(d))]).sum()
    }
}
