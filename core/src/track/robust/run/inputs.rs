//! The inputs of the stages, and the stages that updates and locks share.

use super::super::config::Config;
use super::super::decision::{Memory, Track};
use super::super::features::{Lattice, Place};
use super::super::filter::{FeatureWindow, Learning, Training, layout};
use super::super::verification::{Early, measuring, window_contrast};
use super::buffers::Buffers;
use crate::kernels::Products;
use crate::track::update::Budget;

/// The inputs of the stages. In an update they change only at its end. In a lock, each step of learning changes the
/// filter's weights.
pub(crate) struct Inputs<'a> {
    pub(crate) config: &'a Config,
    pub(crate) memory: Memory<'a>,
    /// The track at the end of the last frame.
    pub(crate) track: &'a Track,
}

impl Inputs<'_> {
    #[inline(never)]
    pub(super) fn begin_features(&self, centre: &Place, reach: u16, buffers: &mut Buffers<'_>) {
        let lattice = Lattice::search_window(centre, &self.track.grid, reach);
        buffers.extractor.begin(self.track.bounds, &lattice, buffers.large);
    }

    /// Measures the search window's contrast from its features, and predicts the gain of the target's contrast from it.
    #[inline(never)]
    pub(super) fn measure_light(&self, buffers: &mut Buffers<'_>, budget: &mut Budget) {
        buffers.comparison.expect(self.track.light, window_contrast(buffers.large));
        budget.spend(measuring(buffers.large));
    }

    pub(crate) fn begin_view(&self, place: &Place, buffers: &mut Buffers<'_>) {
        let Buffers { extractor, comparison, .. } = buffers;
        comparison.begin_view(place, &self.track.grid, self.track.bounds, extractor.sampling());
    }

    /// Computes the next piece of the responses. True after the last piece.
    #[inline(never)]
    pub(crate) fn respond(
        &self,
        piece: &mut usize,
        reach: u16,
        buffers: &mut Buffers<'_>,
        budget: &mut Budget,
    ) -> bool {
        let Buffers { extractor, large, coded, responses, sums, .. } = buffers;
        let (window, spare) = (self.window(large, reach), &mut sums.per_weight);
        let done = responses.compute(coded, self.products(), extractor.lend_sums(), spare, window, *piece, budget);
        *piece += 1;
        done
    }

    /// Computes the next piece of a step of learning. Returns the step length after the last piece.
    #[inline(never)]
    pub(crate) fn learn(
        &self,
        learning: &mut Learning,
        reach: u16,
        buffers: &mut Buffers<'_>,
        budget: &mut Budget,
    ) -> Option<i64> {
        let Buffers { large, responses, extractor, coded, sums, .. } = buffers;
        let training = Training {
            filter: self.memory.filter,
            grid: &self.track.grid,
            window: self.window(large, reach),
            responses,
            products: self.products(),
        };
        learning.next_piece(&training, coded, sums, extractor.lend_sums(), budget)
    }

    pub(crate) fn early(&self) -> Early<'_> {
        Early { config: self.config, template: self.memory.template, grid: &self.track.grid }
    }

    /// The features of a search window of radius `reach`.
    fn window<'a>(&self, cells: &'a [i8], reach: u16) -> FeatureWindow<'a> {
        FeatureWindow { cells, layout: layout(&self.track.grid, 2 * usize::from(reach) + 1) }
    }

    #[inline(never)]
    pub(crate) fn products(&self) -> Products {
        Products::new(self.config.backend())
    }
}
