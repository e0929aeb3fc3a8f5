//! The pipeline of a lock: learns the target from its first frame.
//!
//! ```text
//! crop (feature `refiner`) -> view, which becomes the template -> features -> learning, in `FIRST_STEPS` steps
//! ```
//!
//! Even an unfinished lock changes the target: it begins by dropping the track and setting all weights to 0, and each
//! step of learning changes the weights.

use super::super::config::Config;
use super::super::constants::ONE_GAIN;
use super::super::decision::{Memory, MemoryMut, Track};
use super::super::filter::{CODED, Learning};
use super::super::refiner::FirstCrop;
use super::super::verification::{Light, measuring, window_contrast};
use super::buffers::Buffers;
use super::inputs::Inputs;
use crate::image::Frame;
use crate::track::Quality;
use crate::track::update::{Budget, units};

/// The threshold alpha, in gray levels, with which a lock measures how distinct its target is: 0.05 of full scale.
const QUALITY_ALPHA: u16 = 13;
/// Steps of conjugate gradients at the lock. More steps overfit the first frame: 9 lower the success rate R by 0.004 +-
/// 0.006. 25 steps of steepest descent, at four times the work, raise it by 0.003 +- 0.005.
pub(super) const FIRST_STEPS: u32 = 7;

#[derive(Clone, Copy)]
enum Stage {
    Done,
    FirstCrop(FirstCrop),
    Template,
    Features,
    Learning(Learning),
}

#[derive(Clone, Copy)]
pub(crate) struct LockPipeline {
    stage: Stage,
    track: Track,
    /// Steps of learning that remain, including the present one.
    steps_left: u32,
}

impl LockPipeline {
    pub(crate) fn begin(track: Track, config: &Config, memory: &mut MemoryMut<'_>, buffers: &mut Buffers<'_>) -> Self {
        *memory.track = None;
        memory.filter.start(track.grid.weights());
        memory.filter.code(buffers.coded);
        let mut lock = Self { stage: Stage::Done, track, steps_left: FIRST_STEPS };
        let Buffers { extractor, small, .. } = buffers;
        if config.refines()
            && let Some(crop) = FirstCrop::begin(track.bbox(), track.bounds, extractor.sampling(), small)
        {
            lock.stage = Stage::FirstCrop(crop);
        } else {
            lock.begin_template(config, memory.shared(), buffers);
        }
        lock
    }

    /// Runs pieces of work until the grant is spent. True if no stage remains.
    pub(crate) fn step(
        &mut self,
        (config, memory): (&Config, &mut MemoryMut<'_>),
        buffers: &mut Buffers<'_>,
        budget: &mut Budget,
        frame: &Frame<'_>,
    ) -> bool {
        loop {
            if matches!(self.stage, Stage::Done) {
                return true;
            }
            if budget.is_spent() {
                return false;
            }
            self.next_piece((config, memory), buffers, budget, frame);
        }
    }

    #[inline(never)] // keeps its stack out of `step`
    fn next_piece(
        &mut self,
        (config, memory): (&Config, &mut MemoryMut<'_>),
        buffers: &mut Buffers<'_>,
        budget: &mut Budget,
        frame: &Frame<'_>,
    ) {
        let inputs = Inputs { config, memory: memory.shared(), track: &self.track };
        match &mut self.stage {
            Stage::Done => {}
            Stage::FirstCrop(crop) => {
                let Buffers { extractor, small, .. } = buffers;
                if crop.next_row(frame, extractor.sampling(), small, budget) {
                    self.begin_template(config, memory.shared(), buffers);
                }
            }
            Stage::Template => {
                let Buffers { extractor, comparison, .. } = buffers;
                if comparison.next_row(frame, extractor.sampling(), budget) {
                    inputs.begin_features(&self.track.motion.place, config.reach(), buffers);
                    self.stage = Stage::Features;
                }
            }
            Stage::Features => {
                if buffers.extractor.next_row(frame, buffers.large, budget) {
                    self.measure_light(buffers, budget);
                    // The responses are 0, because all weights are 0.
                    buffers.responses.clear(config.span());
                    self.stage = Stage::Learning(Learning::lock());
                }
            }
            Stage::Learning(learning) => {
                if let Some(length) = inputs.learn(learning, config.reach(), buffers, budget) {
                    self.learned(length, memory, buffers, budget);
                }
            }
        }
    }

    #[inline(never)]
    fn begin_template(&mut self, config: &Config, memory: Memory<'_>, buffers: &mut Buffers<'_>) {
        let inputs = Inputs { config, memory, track: &self.track };
        inputs.begin_view(&self.track.motion.place, buffers);
        self.stage = Stage::Template;
    }

    /// Measures the light (gain divided by window contrast) at the lock, where the gain is 1 by definition.
    fn measure_light(&mut self, buffers: &Buffers<'_>, budget: &mut Budget) {
        self.track.light = Light::of(ONE_GAIN, window_contrast(buffers.large));
        budget.spend(measuring(buffers.large));
    }

    fn learned(&mut self, length: i64, memory: &mut MemoryMut<'_>, buffers: &mut Buffers<'_>, budget: &mut Budget) {
        memory.filter.descend(length, buffers.coded);
        let Buffers { responses, sums, coded, .. } = buffers;
        sums.descend(length, coded, responses);
        budget.spend(CODED * units(responses.span.pow(2)));
        self.steps_left -= 1;
        if self.steps_left == 0 {
            self.stage = Stage::Done;
        }
    }

    /// Sets template and track. Returns how distinct the target is.
    pub(crate) fn commit(&self, config: &Config, memory: &mut MemoryMut<'_>, buffers: &mut Buffers<'_>) -> Quality {
        let Buffers { comparison, small, .. } = buffers;
        let mut track = self.track;
        comparison.table_mut().set(config.table, QUALITY_ALPHA);
        if let Some(patch) = comparison.patch(&track.grid, (0, 0)) {
            track.quality = Quality::of(patch, comparison.table());
            memory.template.start(patch);
        }
        if config.refines() {
            memory.first.keep(small);
        }
        *memory.track = Some(track);
        track.quality
    }
}
