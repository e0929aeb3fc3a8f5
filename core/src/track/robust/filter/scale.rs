//! The scale search (as in DSST; Danelljan et al., 2014): compares the filter's response at 1/1.02, 1 and 1.02 times
//! the last scale.
//!
//! ```text
//! scale' = the scale s with the largest  peak(s) * (1 if s is the last scale, else 0.984)
//! ```
//!
//! `peak(s)` is the response there, without distance penalty. All three scales are sampled around the same place, so
//! that none has an advantage by its place. Frames in which refinement finds the growth need no scale search. Cost: three
//! small windows of features, and 3 products for each weight.

use super::super::arithmetic::quotient;
use super::super::constants::{CHANNELS, Limits, MAX_SIDE, SCALE, SCALE_REACH};
use super::super::features::{Extent, Extractor, Grid, Lattice, Place, cells};
use super::correlation::{Coded, FeatureWindow};
use super::learning::Sums;
use super::response::{self, layout, peak};
use crate::image::{Frame, Rect};
use crate::kernels::Products;
use crate::track::update::Budget;
use heapless::VecView;

/// The ratio of neighbouring scales, in units of 1/65536: 1.02. At 1.04, the success rate R is lower by 0.063 +- 0.023.
const SCALE_STEP: i64 = 66_847;
/// The factor of a response at a changed scale in the scale search, in units of 1/256: 0.984. A factor of 1 lowers the
/// success rate R by 0.038 +- 0.016.
const SCALE_PENALTY: i64 = 252;
/// The minimum and the maximum scale of a target, relative to its size at the lock.
const MIN_SCALE: u32 = SCALE / 5;
const MAX_SCALE: u32 = 5 * SCALE;

const OFFSETS: usize = 2 * SCALE_REACH as usize + 1;

pub(crate) const fn most_work(extent: Extent) -> u32 {
    let extent = extent.with_reach(SCALE_REACH);
    3 * (cells::most_work(extent) + response::most_work(extent))
}

pub(crate) const fn most_work_of_a_piece(extent: Extent) -> u32 {
    response::most_work(extent.with_reach(SCALE_REACH))
}

/// Size of the largest window of features, in bytes: the cells of the largest filter, and a margin, which has the most
/// cells around the longest filter.
pub(crate) const fn most_bytes(Limits { cells, .. }: Limits) -> usize {
    let (margin, sides) = (2 * SCALE_REACH, MAX_SIDE + cells / MAX_SIDE);
    (cells + margin * (sides + margin)) as usize * CHANNELS
}

#[derive(Clone, Copy)]
pub(crate) struct ScaleSearch {
    place: Place,
    /// The height of the best peak so far, in units of 1/16384, and its scale, in units of 1/65536.
    highest: i64,
    best: u32,
    /// Index of the present scale. 0: the scale of the last frame, 1: the next smaller one, 2: the next larger one.
    number: usize,
    /// True if the features at the present scale are computed.
    sampled: bool,
}

pub(crate) struct Tools<'a> {
    pub(crate) grid: &'a Grid,
    pub(crate) bounds: Rect,
    pub(crate) weights: &'a Coded,
    pub(crate) products: Products,
}

pub(crate) struct Borrowed<'a> {
    pub(crate) extractor: &'a mut Extractor,
    pub(crate) cells: &'a mut VecView<i8>,
    pub(crate) sums: &'a mut Sums,
}

impl ScaleSearch {
    pub(crate) fn begin(place: Place, tools: &Tools<'_>, borrowed: &mut Borrowed<'_>) -> Self {
        let lattice = Lattice::search_window(&place, tools.grid, SCALE_REACH);
        borrowed.extractor.begin(tools.bounds, &lattice, borrowed.cells);
        Self { place, highest: i64::MIN, best: place.scale, number: 0, sampled: false }
    }

    /// Computes one piece of the search. Returns the best scale after the last piece.
    pub(crate) fn next_piece(
        &mut self,
        tools: &Tools<'_>,
        frame: &Frame<'_>,
        borrowed: &mut Borrowed<'_>,
        budget: &mut Budget,
    ) -> Option<u32> {
        if !self.sampled {
            self.sampled = borrowed.extractor.next_row(frame, borrowed.cells, budget);
            return None;
        }
        let [smaller, larger] = other_scales(self.place.scale);
        let scales = [self.place.scale, smaller, larger];
        let height = peak_height(tools, borrowed);
        budget.spend(u32::from(2 * SCALE_REACH + 1).pow(2) * tools.grid.work_on_weights());
        let counted = if self.number == 0 { height } else { (height * SCALE_PENALTY) >> 8 };
        if let Some(&scale) = scales.get(self.number).filter(|_| counted > self.highest) {
            (self.highest, self.best) = (counted, scale);
        }
        self.number += 1;
        let Some(&scale) = scales.get(self.number) else { return Some(self.best) };
        let lattice = Lattice::search_window(&Place { scale, ..self.place }, tools.grid, SCALE_REACH);
        self.sampled = false;
        borrowed.extractor.begin(tools.bounds, &lattice, borrowed.cells);
        None
    }
}

fn peak_height(tools: &Tools<'_>, borrowed: &mut Borrowed<'_>) -> i64 {
    let Borrowed { extractor, cells, sums: Sums { per_weight: spare, per_offset: responses, .. } } = borrowed;
    let window = FeatureWindow { cells: &cells[..], layout: layout(tools.grid, OFFSETS) };
    let mut pieces = 0..;
    let mut respond =
        |piece| tools.weights.respond(tools.products, extractor.lend_sums(), spare, window, piece, responses);
    while !respond(pieces.next().unwrap_or(0)) {}
    let rows = responses.get_mut(..OFFSETS).unwrap_or_default();
    tools.weights.to_responses(rows);
    peak(rows, OFFSETS, false).height.into()
}

/// The neighbouring scales: the smaller and the larger one.
#[inline(never)]
pub(crate) fn other_scales(scale: u32) -> [u32; 2] {
    let scale = i64::from(scale);
    [quotient(scale << 16, SCALE_STEP), (scale * SCALE_STEP) >> 16]
        .map(|scale| u32::try_from(scale).unwrap_or(SCALE).clamp(MIN_SCALE, MAX_SCALE))
}

/// The scale after a growth of `growth` / 65536, clamped to the smallest and the largest scale.
pub(crate) fn grown(scale: u32, growth: i32) -> u32 {
    let grown = i64::from(scale) + ((i64::from(scale) * i64::from(growth)) >> 16);
    u32::try_from(grown).unwrap_or(SCALE).clamp(MIN_SCALE, MAX_SCALE)
}

pub(crate) fn is_possible(scale: u32) -> bool {
    (MIN_SCALE..=MAX_SCALE).contains(&scale)
}
