//! The pipeline of an update: runs a frame through the stages, piece by piece, so that an update can be done in steps.
//!
//! ```text
//! search -> verification -> refinement -> scale -> learning, if there is enough evidence
//!   -> refiner (feature `refiner`), if the patch can show the target -> decision
//!   if the target is lost:   -> search -> verification -> refiner, in each window of the sweep until one shows the target
//! ```
//!
//! A search computes features and responses. The refiner takes the memory of the features, so learning comes first; the
//! decision drops its result if the refiner takes too much evidence. To add a stage, add it to `Stage` and `next_piece`,
//! and begin it at the end of the stage before it. A stage for every frame, before the decision, begins in `scaled`.
//! Until [`Pipeline::commit`] only the workspace changes. Locks have their own pipeline (`lock.rs`).

use super::super::arithmetic::quotient;
use super::super::config::Config;
use super::super::constants::CELL;
#[cfg(feature = "unstable")]
use super::super::constants::SPAN;
use super::super::decision::{Calm, Confidence, Doubt, Evidence, MemoryMut, Track};
#[cfg(feature = "unstable")]
use super::super::features::Lattice;
use super::super::features::{Grid, Motion, Place};
use super::super::filter::{Borrowed, CODED, Learning, ScaleSearch, Tools, scale};
use super::super::refiner::{Logit, Outputs, Refiner};
use super::super::verification::{Alignment, COPIED, Candidate, REFINED, Refined, Verification, Verified, refine};
use super::buffers::Buffers;
use super::inputs::Inputs;
use super::windows::{expected, next_sweep_window};
use crate::image::Frame;
use crate::track::State;
use crate::track::update::Budget;

#[derive(Clone, Copy)]
enum Stage {
    Done,
    Features,
    /// Computes the responses. The value is the index of the next piece.
    Response(usize),
    Verification(Verification),
    Refinement(Verified),
    Scale(ScaleSearch),
    /// Begins the next window of the sweep, if one remains.
    Sweep,
    Learning(Learning),
    /// Runs the network on the box of the candidate.
    Refiner(Refiner, Candidate),
}

#[derive(Clone, Copy)]
pub(crate) struct Pipeline {
    stage: Stage,
    /// The middle of the present search window.
    centre: Place,
    /// The radius of that window, in cells: smaller around a calm target.
    reach: u16,
    /// Windows of the sweep that remain in this frame; `None` before redetection.
    redetects: Option<u8>,
    /// The track at the end of this frame.
    track: Track,
    /// The candidate on which the answer is based: that of the first window, or the one that redetection accepted.
    candidate: Candidate,
    alignment: Alignment,
    /// The evidence at the target's last place, which a find must exceed.
    there: Evidence,
    /// The length of the filter's step, with 44 fractional bits, if the tracker learns from this frame.
    learned: Option<i64>,
}

impl Pipeline {
    pub(crate) fn begin(inputs: &Inputs<'_>, buffers: &mut Buffers<'_>, budget: &mut Budget) -> Self {
        let grid = &inputs.track.grid;
        inputs.memory.filter.code(buffers.coded);
        buffers.comparison.begin(&inputs.early());
        budget.spend(CODED * grid.work_on_weights() + COPIED * grid.pixels());
        let centre = expected(inputs.track);
        let reach = inputs.track.reach(inputs.config);
        inputs.begin_features(&centre, reach, buffers);
        Self {
            stage: Stage::Features,
            centre,
            reach,
            redetects: None,
            track: *inputs.track,
            candidate: Candidate::NONE,
            alignment: (0, 0),
            there: Evidence::NONE,
            learned: None,
        }
    }

    pub(crate) const fn candidate(&self) -> &Candidate {
        &self.candidate
    }

    /// Runs pieces of work until the grant is spent. True if no stage remains.
    pub(crate) fn step(
        &mut self,
        inputs: &Inputs<'_>,
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
            self.next_piece(inputs, buffers, budget, frame);
        }
    }

    /// Runs one indivisible piece of work. Calls functions that are not inlined to begin a stage, to save stack here.
    fn next_piece(&mut self, inputs: &Inputs<'_>, buffers: &mut Buffers<'_>, budget: &mut Budget, frame: &Frame<'_>) {
        match &mut self.stage {
            Stage::Done => {}
            Stage::Features => {
                if buffers.extractor.next_row(frame, buffers.large, budget) {
                    inputs.measure_light(buffers, budget);
                    self.stage = Stage::Response(0);
                }
            }
            Stage::Response(piece) => {
                if inputs.respond(piece, self.reach, buffers, budget) {
                    self.verify(inputs, buffers);
                }
            }
            Stage::Verification(verification) => {
                let Buffers { extractor, comparison, .. } = buffers;
                let early = inputs.early();
                let verified = verification.next_piece(&early, frame, extractor.sampling(), comparison, budget);
                match verified {
                    None => {}
                    Some(Verified { candidate, .. }) if self.redetects.is_some() => {
                        self.redetect(inputs, candidate, buffers);
                    }
                    Some(verified) => self.stage = Stage::Refinement(verified),
                }
            }
            Stage::Refinement(_) => self.refine(inputs, buffers, budget),
            Stage::Scale(_) => {
                if let Some(scale) = self.next_scale(inputs, buffers, budget, frame) {
                    self.scaled(inputs, scale, buffers, budget);
                }
            }
            Stage::Sweep => self.search_window(inputs, buffers),
            Stage::Learning(learning) => {
                let length = inputs.learn(learning, self.reach, buffers, budget);
                if length.is_some() {
                    self.learned = length;
                    self.examine(inputs, buffers, budget);
                }
            }
            Stage::Refiner(refiner, _) => {
                let Buffers { extractor, large, .. } = buffers;
                let (backend, first) = (inputs.config.backend(), inputs.memory.first);
                let estimate = refiner.next_piece(backend, frame, first, extractor.sampling(), large, budget);
                if let Some(estimate) = estimate {
                    self.judge(inputs, &estimate, buffers, budget);
                }
            }
        }
    }

    #[inline(never)] // see `next_piece`
    fn verify(&mut self, inputs: &Inputs<'_>, buffers: &mut Buffers<'_>) {
        let Track { grid, bounds, .. } = inputs.track;
        let peak = buffers.responses.peak(true);
        // A peak is in units of 1/256 cell, which is 1/64 pixel of the grid.
        let place = self.centre.moved(grid, (peak.x, peak.y)).inside(*bounds);
        let candidate = Candidate::new(place, peak.response);
        inputs.begin_view(&place, buffers);
        self.stage = Stage::Verification(Verification::begin(candidate));
    }

    /// Refines the verified candidate. Begins the scale search, unless refinement gave the scale or the size is fixed.
    #[inline(never)] // see `next_piece`
    fn refine(&mut self, inputs: &Inputs<'_>, buffers: &mut Buffers<'_>, budget: &mut Budget) {
        let Stage::Refinement(Verified { mut candidate, alignment }) = self.stage else { return };
        let Track { grid, bounds, .. } = inputs.track;
        let comparison = &buffers.comparison;
        let refined = match (comparison.patch(grid, alignment), comparison.relit(grid)) {
            (Some(patch), Some(relit)) => refine(candidate.agreement, alignment, patch, relit, comparison.alpha()),
            _ => None,
        };
        if let Some(Refined { x, y, .. }) = refined {
            candidate.place = candidate.place.moved(grid, (x, y)).inside(*bounds);
        }
        budget.spend(REFINED * grid.pixels());
        (self.candidate, self.alignment) = (candidate, alignment);
        let last = candidate.place.scale;
        match refined {
            _ if !inputs.config.size => self.scaled(inputs, last, buffers, budget),
            Some(Refined { growth, .. }) => self.scaled(inputs, scale::grown(last, growth), buffers, budget),
            None => {
                let (tools, mut borrowed) = scale_search(inputs, buffers);
                self.stage = Stage::Scale(ScaleSearch::begin(candidate.place, &tools, &mut borrowed));
            }
        }
    }

    /// Runs one piece of the scale search. Returns the best scale after the last piece.
    #[inline(never)] // see `next_piece`
    fn next_scale(
        &mut self,
        inputs: &Inputs<'_>,
        buffers: &mut Buffers<'_>,
        budget: &mut Budget,
        frame: &Frame<'_>,
    ) -> Option<u32> {
        let Stage::Scale(search) = &mut self.stage else { return None };
        let (tools, mut borrowed) = scale_search(inputs, buffers);
        search.next_piece(&tools, frame, &mut borrowed, budget)
    }

    /// Sets the candidate's scale. Place and scale are now final, so learning or the refiner can begin.
    #[inline(never)] // see `next_piece`
    fn scaled(&mut self, inputs: &Inputs<'_>, scale: u32, buffers: &mut Buffers<'_>, budget: &mut Budget) {
        let Self { track, candidate, .. } = self;
        candidate.place.scale = scale;
        let evidence = Evidence::of(candidate);
        let confidence = track.confidence.after(evidence, inputs.config.patience);
        let is_lost = track.is_given_up(inputs.config) || confidence.state(inputs.config) == State::Lost;
        if evidence.may_be_learned() && !is_lost {
            // Features and responses are those of the first window, because there was no redetection.
            let target = offset(&inputs.track.grid, self.centre, candidate.place);
            self.stage = Stage::Learning(Learning::begin(target, inputs.config.learning_rate));
        } else {
            self.examine(inputs, buffers, budget);
        }
    }

    /// Begins the refiner, or decides at once: without the refiner, if the early template gave the exact place and size,
    /// or if the patch cannot show the target.
    fn examine(&mut self, inputs: &Inputs<'_>, buffers: &mut Buffers<'_>, budget: &mut Budget) {
        let candidate = self.candidate;
        if inputs.config.refines() && candidate.visible && !candidate.is_exact() {
            self.begin_refiner(candidate, buffers);
        } else {
            self.decide(inputs, None, buffers, budget);
        }
    }

    /// Decides the state, and whether to learn or to redetect. `estimate` is the refiner's, if it ran.
    #[inline(never)] // see `next_piece`
    fn decide(
        &mut self,
        inputs: &Inputs<'_>,
        estimate: Option<&Outputs>,
        buffers: &mut Buffers<'_>,
        budget: &mut Budget,
    ) {
        let (config, candidate) = (inputs.config, self.candidate);
        let track = &mut self.track;
        self.stage = Stage::Done;
        let logit = if candidate.is_exact() { Some(Logit::EXACT) } else { estimate.map(Logit::of) };
        let mut evidence = Evidence::of(&candidate);
        if config.refines()
            && let Some(logit) = logit
        {
            evidence = evidence.less(logit.veto());
            track.review.identify(logit);
        }
        track.confidence = track.confidence.after(evidence, config.patience);
        // For a target that was given up, the evidence at the old place does not count.
        self.there = evidence;
        if track.is_given_up(config) {
            (track.confidence, self.there) = (Confidence::NONE, Evidence::NONE);
        }
        let moved = candidate.visible.then(|| offset(&track.grid, self.centre, candidate.place));
        track.calm.settle(moved.unwrap_or_default());
        track.motion.follow(candidate.visible.then_some(candidate.place));
        let is_lost = track.confidence.state(config) == State::Lost;
        let refused = config.refines() && (is_lost || !evidence.may_be_learned());
        if refused && self.learned.take().is_some() {
            // Learning has replaced the coded weights, which redetection needs.
            inputs.memory.filter.code(buffers.coded);
            budget.spend(CODED * track.grid.work_on_weights());
        }
        if is_lost {
            (self.redetects, self.stage) = (Some(config.sweep), Stage::Sweep);
        } else if config.refines() {
            let doubts = match estimate {
                Some(estimate) => track.review.update(estimate, self.learned.is_some()),
                None if candidate.is_exact() => track.review.agree(),
                None => return,
            };
            track.doubt = track.doubt.after(doubts);
        }
    }

    #[inline(never)] // see `next_piece`
    fn search_window(&mut self, inputs: &Inputs<'_>, buffers: &mut Buffers<'_>) {
        self.stage = Stage::Done;
        if let Some(left @ 1..) = self.redetects {
            let (centre, is_last) = next_sweep_window(inputs.track, inputs.config, self.track.sweep);
            self.track.sweep.move_on();
            self.redetects = Some(if is_last { 0 } else { left - 1 });
            (self.centre, self.reach, self.stage) = (centre, inputs.config.reach(), Stage::Features);
            inputs.begin_features(&centre, self.reach, buffers);
        }
    }

    /// Accepts the candidate of a window of the sweep if its evidence suffices, with the refiner only after a run of the
    /// network. Otherwise begins the next window.
    #[inline(never)] // see `next_piece`
    fn redetect(&mut self, inputs: &Inputs<'_>, candidate: Candidate, buffers: &mut Buffers<'_>) {
        self.stage = Stage::Sweep;
        if !Evidence::of(&candidate).finds(self.there, inputs.config) {
            return;
        }
        if inputs.config.refines() {
            self.begin_refiner(candidate, buffers);
        } else {
            self.find(inputs.config, &candidate);
        }
    }

    /// In redetection accepts the candidate if the network recognises the target in its box, or begins the next window.
    /// Otherwise decides the state.
    #[inline(never)] // see `next_piece`
    fn judge(&mut self, inputs: &Inputs<'_>, estimate: &Outputs, buffers: &mut Buffers<'_>, budget: &mut Budget) {
        match self.stage {
            Stage::Refiner(_, candidate) if self.redetects.is_some() => {
                self.stage = Stage::Sweep;
                if Logit::of(estimate).finds() {
                    self.find(inputs.config, &candidate);
                }
            }
            _ => self.decide(inputs, Some(estimate), buffers, budget),
        }
    }

    fn find(&mut self, config: &Config, candidate: &Candidate) {
        let track = &mut self.track;
        track.motion = Motion::at(candidate.place);
        track.calm = Calm::NEW;
        track.confidence = Confidence::found(Evidence::of(candidate), config);
        track.review.begin_again();
        track.doubt = Doubt::NONE;
        (self.candidate, self.stage) = (*candidate, Stage::Done);
    }

    /// Begins the refiner at a candidate's box, in the memory of the features.
    #[inline(never)] // see `next_piece`
    fn begin_refiner(&mut self, candidate: Candidate, buffers: &mut Buffers<'_>) {
        let Self { track, .. } = self;
        let Buffers { extractor, large, .. } = buffers;
        let target = track.corrected(candidate.place);
        if let Some(refiner) = Refiner::begin(target, track.bounds, extractor.sampling(), large) {
            self.stage = Stage::Refiner(refiner, candidate);
        }
    }

    pub(crate) fn commit(&mut self, config: &Config, memory: &mut MemoryMut<'_>, buffers: &Buffers<'_>) {
        let Self { track, alignment, .. } = self;
        if let Some(length) = self.learned {
            let patch = buffers.comparison.patch(&track.grid, *alignment);
            patch.into_iter().for_each(|patch| memory.template.learn(patch, config.early_rate));
            memory.filter.descend(length, buffers.coded);
            track.light = track.light.following(buffers.comparison.light());
        }
        if track.confidence.state(config) == State::Tracking {
            track.tracked_scale = track.motion.place.scale;
        }
        *memory.track = Some(*track);
    }
}

fn scale_search<'a>(inputs: &Inputs<'a>, buffers: &'a mut Buffers<'_>) -> (Tools<'a>, Borrowed<'a>) {
    let Buffers { extractor, small, coded, sums, .. } = buffers;
    let Track { grid, bounds, .. } = inputs.track;
    (
        Tools { grid, bounds: *bounds, weights: coded, products: inputs.products() },
        Borrowed { extractor, cells: small, sums },
    )
}

/// The target's offset from the middle of a window, in units of 1/256 cell.
#[inline(never)]
fn offset(grid: &Grid, centre: Place, target: Place) -> (i32, i32) {
    let cell = (i64::from(CELL) * grid.step_at(centre.scale)).max(1);
    let cells = |to: i64, from: i64| i32::try_from(quotient((to - from) * 256, cell)).unwrap_or(0);
    (cells(target.x, centre.x), cells(target.y, centre.y))
}

/// Computes the features of the next update's search window. False if a needed pixel is not in memory.
#[cfg(feature = "unstable")]
pub(crate) fn features(inputs: &Inputs<'_>, buffers: &mut Buffers<'_>, frame: &Frame<'_>) -> bool {
    let place = expected(inputs.track);
    let lattice = Lattice::search_window(&place, &inputs.track.grid, inputs.track.reach(inputs.config));
    buffers.extractor.features(frame, &lattice, buffers.large)
}

/// Computes the filter's responses to the features in `buffers`, without the penalty for distance.
#[cfg(feature = "unstable")]
pub(crate) fn responses(inputs: &Inputs<'_>, buffers: &mut Buffers<'_>, budget: &mut Budget) -> [[i32; SPAN]; SPAN] {
    inputs.memory.filter.code(buffers.coded);
    buffers.responses.rows = [[0; SPAN]; SPAN];
    let mut piece = 0;
    while !inputs.respond(&mut piece, inputs.track.reach(inputs.config), buffers, budget) {}
    buffers.responses.rows
}
