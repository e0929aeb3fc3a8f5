//! The pipeline: runs a frame through the stages, in units of work, so that an update or a lock can be done in steps.
//!
//! ```text
//! update: search -> verification -> refinement -> scale -> decision
//!           if there is enough evidence:   -> learning -> refiner (feature `refiner`)
//!           if the target is lost:         -> search -> verification, in a second window
//! lock:   crop (feature `refiner`) -> view, which becomes the template -> features -> learning
//!           24 times:                      -> response -> learning
//! ```
//!
//! A search computes features and responses. Each stage holds its inputs and passes on its result. An update changes
//! only the workspace until it is finished. A lock changes the target earlier: its start drops the track and sets all
//! weights to 0, and each of its 25 steps of learning changes the weights. Its end sets template and track.

use super::alignment::Alignment;
use super::buffers::Buffers;
use super::confidence::{Confidence, Evidence};
use super::config::{Config, Parts};
#[cfg(feature = "unstable")]
use super::constants::SPAN;
use super::constants::{CELL, FIRST_RATE, FIRST_STEPS};
use super::division::quotient;
use super::grid::Grid;
use super::learning::{Learning, Training};
use super::memory::Memory;
use super::motion::{Motion, Place};
use super::refinement::{REFINED, Refined, refine};
use super::refiner::{FirstCrop, Refiner};
use super::response::{CODED, layout};
use super::sampling::Lattice;
use super::scale::{self, ScaleSearch, Tools};
use super::track::Track;
use super::verification::{COPIED, Candidate, Reference, Verification, Verified, View};
use crate::correlation::Window;
use crate::image::{Frame, Image};
use crate::kernels::Products;
use crate::track::State;
use crate::track::budget::Budget;

/// The purpose of a search.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Purpose {
    /// Learns the target at a lock.
    Lock,
    /// Follows the target in the window around its expected place.
    Follow,
    /// Finds the lost target elsewhere.
    Redetect,
}

/// The next stage, with its inputs.
#[derive(Clone, Copy)]
#[repr(u8)] // `Done` is 0, so that a workspace in a `static` begins as zeroes
enum Stage {
    Done,
    Template(View),
    Features(Purpose, Lattice),
    Response(Purpose, usize),
    Verification(Purpose, Verification),
    Refinement(Verified),
    /// The search, and the growth that refinement found, if any. Unit: 1/65536.
    Scale(ScaleSearch, Option<i32>),
    Learning(Learning),
    FirstCrop(FirstCrop),
    Refiner(Refiner),
}

/// The decisions of the stages so far.
#[derive(Clone, Copy)]
pub(super) struct Outcome {
    /// The new track. `None` before the first update or lock in this workspace.
    pub(super) track: Option<Track>,
    /// The candidate of the first window; after redetection, that of the second window if it is the lost target.
    pub(super) candidate: Candidate,
    /// The best alignment of the early template.
    alignment: Alignment,
    /// Whether the early template learns from this frame.
    pub(super) template_learns: bool,
    /// The length of the filter's step.
    step: Option<i64>,
    /// Steps of learning left in a lock, including the present one; 0 in an update.
    steps_left: u32,
}

/// The progress of an update or a lock.
pub(super) struct Pipeline {
    stage: Stage,
    pub(super) outcome: Outcome,
}

impl Pipeline {
    #[inline(always)]
    pub(super) const fn new() -> Self {
        Self { stage: Stage::Done, outcome: Outcome::new(None) }
    }

    pub(super) const fn response(&self) -> i32 {
        self.outcome.candidate.response
    }
}

impl Outcome {
    const fn new(track: Option<Track>) -> Self {
        Self { track, candidate: Candidate::NONE, alignment: (0, 0), template_learns: false, step: None, steps_left: 0 }
    }

    /// The patch that the early template starts as or learns from.
    #[inline(never)]
    pub(super) fn patch<'a>(&self, buffers: &'a Buffers, grid: &Grid) -> Option<Image<'a>> {
        buffers.comparison.patch(grid, self.alignment)
    }

    /// Makes the filter's step, if one was computed.
    pub(super) fn make_step(&mut self, memory: &mut Memory, buffers: &Buffers) {
        if let Some(length) = self.step.take() {
            memory.filter.descend(length, &buffers.coded);
        }
    }

    /// True in an unfinished lock.
    pub(super) const fn is_lock(&self) -> bool {
        self.steps_left > 0
    }

    /// Counts a finished step of a lock. True if another one follows.
    pub(super) fn has_another_step(&mut self) -> bool {
        self.steps_left = self.steps_left.saturating_sub(1);
        self.steps_left > 0
    }
}

/// The inputs of the stages. An update does not change them until it is finished; a lock changes the weights in
/// `memory` at each step of learning.
pub(super) struct Model<'a> {
    pub(super) config: &'a Config,
    pub(super) memory: &'a Memory,
    pub(super) track: Track,
}

impl Model<'_> {
    /// Begins an update.
    pub(super) fn begin(&self, pipeline: &mut Pipeline, buffers: &mut Buffers, budget: &mut Budget) {
        self.memory.filter.code(&mut buffers.coded);
        buffers.comparison.begin(&self.reference());
        budget.spend(CODED * self.track.grid.work_on_weights() + COPIED * self.track.grid.pixels());
        pipeline.outcome = Outcome::new(Some(self.track));
        self.search(pipeline, buffers, Purpose::Follow);
    }

    /// Begins a lock.
    pub(super) fn begin_lock(&self, pipeline: &mut Pipeline, buffers: &mut Buffers) {
        pipeline.outcome = Outcome { steps_left: FIRST_STEPS, ..Outcome::new(Some(self.track)) };
        let Buffers { extractor, small, .. } = buffers;
        if self.config.refines()
            && let Some(crop) = FirstCrop::begin(self.track.bbox(), self.track.bounds, extractor.sampling(), small)
        {
            pipeline.stage = Stage::FirstCrop(crop);
            return;
        }
        self.begin_template(pipeline, buffers);
    }

    /// Begins the view that becomes the early template.
    #[inline(never)] // see `next_piece`
    fn begin_template(&self, pipeline: &mut Pipeline, buffers: &mut Buffers) {
        pipeline.stage = Stage::Template(self.view(buffers, self.track.motion.place));
    }

    /// Begins a step of a lock's learning: the responses of the present weights.
    pub(super) fn begin_step(&self, pipeline: &mut Pipeline, buffers: &mut Buffers, budget: &mut Budget) {
        self.memory.filter.code(&mut buffers.coded);
        budget.spend(CODED * self.track.grid.work_on_weights());
        pipeline.stage = Stage::Response(Purpose::Lock, 0);
    }

    /// Continues until the grant is spent. True if no stage is left.
    #[inline(never)]
    pub(super) fn step(
        &self,
        pipeline: &mut Pipeline,
        buffers: &mut Buffers,
        budget: &mut Budget,
        frame: &Frame<'_>,
    ) -> bool {
        while !matches!(pipeline.stage, Stage::Done) && !budget.is_spent() {
            self.next_piece(pipeline, buffers, budget, frame);
        }
        matches!(pipeline.stage, Stage::Done)
    }

    /// Does one piece of work. After the last piece of a stage, a separate function that is not inlined begins the next
    /// stage. So a piece of work does not reserve the stack for the beginnings of all stages.
    fn next_piece(&self, pipeline: &mut Pipeline, buffers: &mut Buffers, budget: &mut Budget, frame: &Frame<'_>) {
        match &mut pipeline.stage {
            Stage::Done => {}
            Stage::Template(view) => {
                let Buffers { extractor, comparison, .. } = buffers;
                if view.next_row(frame, extractor.sampling(), comparison, budget) {
                    self.search(pipeline, buffers, Purpose::Lock);
                }
            }
            Stage::Features(purpose, lattice) => {
                let Buffers { extractor, large: cells, .. } = buffers;
                if extractor.next_row(frame, lattice, cells, budget) {
                    match *purpose {
                        Purpose::Lock => {
                            // All weights are 0, and so are their responses.
                            buffers.responses.clear(self.config.span());
                            pipeline.stage = Stage::Learning(Learning::begin((0, 0), FIRST_RATE));
                        }
                        purpose => pipeline.stage = Stage::Response(purpose, 0),
                    }
                }
            }
            Stage::Response(purpose, piece) => {
                let Buffers { extractor, large: cells, coded, responses, sums, .. } = buffers;
                let (window, spare) = (self.window(cells), &mut sums.per_weight);
                let done =
                    responses.compute(coded, self.products(), extractor.lend_sums(), spare, window, *piece, budget);
                *piece += 1;
                match *purpose {
                    _ if !done => {}
                    Purpose::Lock => pipeline.stage = Stage::Learning(Learning::begin((0, 0), FIRST_RATE)),
                    purpose => self.verify(pipeline, buffers, purpose),
                }
            }
            Stage::Verification(purpose, verification) => {
                let Buffers { extractor, comparison, .. } = buffers;
                let reference = self.reference();
                if let Some(verified) =
                    verification.next_piece(&reference, frame, extractor.sampling(), comparison, budget)
                {
                    match *purpose {
                        Purpose::Redetect => redetect(pipeline, verified),
                        _ => pipeline.stage = Stage::Refinement(verified),
                    }
                }
            }
            Stage::Refinement(verified) => {
                let verified = *verified;
                if let Some(scale) = self.refine(pipeline, verified, buffers, budget) {
                    self.decide(pipeline, scale, buffers);
                }
            }
            Stage::Scale(search, growth) => {
                let (tools, mut borrowed) = self.scale_search(buffers);
                if let Some(scale) = search.next_piece(&tools, frame, &mut borrowed, budget) {
                    let last = pipeline.outcome.candidate.place.scale;
                    let scale = growth.map_or(scale, |growth| scale::grown(last, growth));
                    self.decide(pipeline, scale, buffers);
                }
            }
            Stage::Learning(learning) => {
                let Buffers { large: cells, responses, extractor, coded, sums, .. } = buffers;
                let training = Training {
                    filter: &self.memory.filter,
                    grid: &self.track.grid,
                    window: self.window(cells),
                    responses,
                    products: self.products(),
                };
                let length = learning.next_piece(&training, coded, sums, extractor.lend_sums(), budget);
                if length.is_some() {
                    (pipeline.outcome.step, pipeline.stage) = (length, Stage::Done);
                    if self.config.refines() {
                        self.begin_refiner(pipeline, buffers);
                    }
                }
            }
            Stage::FirstCrop(crop) => {
                let Buffers { extractor, small, .. } = buffers;
                if crop.next_row(frame, extractor.sampling(), small, budget) {
                    self.begin_template(pipeline, buffers);
                }
            }
            Stage::Refiner(refiner) => {
                let Buffers { extractor, large, .. } = buffers;
                let Some(Track { correction, .. }) = &mut pipeline.outcome.track else { return };
                let (backend, first) = (self.config.backend(), &self.memory.first);
                if refiner.next_piece(backend, frame, first, extractor.sampling(), large, correction, budget) {
                    pipeline.stage = Stage::Done;
                }
            }
        }
    }

    /// Begins the refiner after the learning of an update, unless the early template gave the exact place and size. The
    /// window's features are not needed any more, so the refiner uses their memory.
    #[inline(never)] // see `next_piece`
    fn begin_refiner(&self, pipeline: &mut Pipeline, buffers: &mut Buffers) {
        let Outcome { track: Some(track), candidate, steps_left: 0, .. } = &mut pipeline.outcome else { return };
        if candidate.is_exact() {
            track.correction.fade();
            return;
        }
        let Buffers { extractor, large, .. } = buffers;
        if let Some(refiner) = Refiner::begin(track.bbox(), track.bounds, extractor.sampling(), large) {
            pipeline.stage = Stage::Refiner(refiner);
        }
    }

    /// Begins the search of a window.
    #[inline(never)] // see `next_piece`
    fn search(&self, pipeline: &mut Pipeline, buffers: &mut Buffers, purpose: Purpose) {
        let lattice = Lattice::search_window(self.centre(purpose), &self.track.grid, self.config.reach());
        buffers.extractor.begin(self.track.bounds, &lattice, &mut buffers.large);
        pipeline.stage = Stage::Features(purpose, lattice);
    }

    #[inline(never)]
    fn centre(&self, purpose: Purpose) -> Place {
        match purpose {
            Purpose::Lock => self.track.motion.place,
            Purpose::Follow => self.track.expected(self.config),
            Purpose::Redetect => self.track.swept(self.config.reach()),
        }
    }

    /// Begins the verification of the peak.
    #[inline(never)] // see `next_piece`
    fn verify(&self, pipeline: &mut Pipeline, buffers: &mut Buffers, purpose: Purpose) {
        let peak = buffers.responses.peak(self.config.parts.distance_penalty);
        // 1/256 cell is 1/64 pixel of the grid.
        let place = self.centre(purpose).moved(&self.track.grid, (peak.x, peak.y)).inside(self.track.bounds);
        let candidate = Candidate::new(place, peak.response);
        let view = self.view(buffers, place);
        pipeline.stage = Stage::Verification(purpose, Verification::begin(candidate, view));
    }

    /// Begins the view of a place.
    #[inline(never)]
    fn view(&self, buffers: &mut Buffers, place: Place) -> View {
        let Buffers { extractor, comparison, .. } = buffers;
        View::begin(place, &self.track.grid, self.track.bounds, extractor.sampling(), comparison)
    }

    /// Refines a verified candidate and begins the scale search. Returns the scale if the configuration has no scale
    /// search.
    #[inline(never)] // see `next_piece`
    fn refine(
        &self,
        pipeline: &mut Pipeline,
        Verified { mut candidate, alignment }: Verified,
        buffers: &mut Buffers,
        budget: &mut Budget,
    ) -> Option<u32> {
        let (grid, comparison) = (&self.track.grid, &buffers.comparison);
        let refined = match (comparison.patch(grid, alignment), comparison.relit(grid)) {
            (Some(patch), Some(relit)) => refine(candidate.agreement, alignment, patch, relit, comparison.alpha()),
            _ => None,
        };
        if let Some(Refined { x, y, .. }) = refined {
            candidate.place = candidate.place.moved(grid, (x, y)).inside(self.track.bounds);
        }
        budget.spend(REFINED * grid.pixels());
        (pipeline.outcome.candidate, pipeline.outcome.alignment) = (candidate, alignment);
        if self.config.size {
            let (tools, mut borrowed) = self.scale_search(buffers);
            let search = ScaleSearch::begin(candidate.place, &tools, &mut borrowed);
            pipeline.stage = Stage::Scale(search, refined.map(|refined| refined.growth));
            None
        } else {
            Some(candidate.place.scale)
        }
    }

    /// Decides on the state, and on learning or redetection, when place and scale are known.
    #[inline(never)] // see `next_piece`
    fn decide(&self, pipeline: &mut Pipeline, scale: u32, buffers: &mut Buffers) {
        pipeline.stage = Stage::Done;
        let Outcome { track: Some(track), candidate, template_learns, .. } = &mut pipeline.outcome else { return };
        let Parts { gated_learning, verification, .. } = self.config.parts;
        candidate.place.scale = scale;
        if verification {
            track.confidence = track.confidence.after(Evidence::of(candidate), self.config.patience);
        }
        if candidate.visible || !verification {
            track.motion.follow(candidate.place);
        } else {
            track.motion.hold();
        }
        if track.confidence.state(self.config) == State::Lost {
            if self.config.sweep {
                self.search(pipeline, buffers, Purpose::Redetect);
            }
            return;
        }
        *template_learns = Evidence::of(candidate).may_be_learned() || !gated_learning || !verification;
        if *template_learns {
            // Cells and responses are still those of the first window.
            let target = offset(&self.track.grid, self.centre(Purpose::Follow), candidate.place);
            pipeline.stage = Stage::Learning(Learning::begin(target, self.config.learning_rate));
        }
    }

    fn reference(&self) -> Reference<'_> {
        Reference { config: self.config, template: &self.memory.template, grid: &self.track.grid }
    }

    fn window<'a>(&self, cells: &'a [i8]) -> Window<'a> {
        Window { cells, layout: layout(&self.track.grid, self.config.span()) }
    }

    fn scale_search<'a>(&'a self, buffers: &'a mut Buffers) -> (Tools<'a>, scale::Borrowed<'a>) {
        let Buffers { extractor, small, coded, sums, .. } = buffers;
        let Track { grid, bounds, .. } = &self.track;
        (
            Tools { grid, bounds: *bounds, weights: coded, products: self.products() },
            scale::Borrowed { extractor, cells: small, sums },
        )
    }

    #[inline(never)]
    fn products(&self) -> Products {
        Products::new(self.config.backend())
    }

    /// Computes the features of the search window, as the next update will. False if a needed pixel is not in memory.
    #[cfg(feature = "unstable")]
    pub(super) fn features(&self, buffers: &mut Buffers, frame: &Frame<'_>) -> bool {
        let place = self.centre(Purpose::Follow);
        let lattice = Lattice::search_window(place, &self.track.grid, self.config.reach());
        buffers.extractor.features(frame, &lattice, &mut buffers.large)
    }

    /// Computes the filter's responses to these features, without penalty.
    #[cfg(feature = "unstable")]
    pub(super) fn responses(&self, buffers: &mut Buffers, budget: &mut Budget) -> [[i32; SPAN]; SPAN] {
        self.memory.filter.code(&mut buffers.coded);
        let Buffers { extractor, large: cells, coded, responses, sums, .. } = buffers;
        responses.rows = [[0; SPAN]; SPAN];
        let mut pieces = 0..;
        while !responses.compute(
            coded,
            self.products(),
            extractor.lend_sums(),
            &mut sums.per_weight,
            self.window(cells),
            pieces.next().unwrap_or(0),
            budget,
        ) {}
        responses.rows
    }
}

/// Ends redetection: follows its candidate if that is the lost target.
#[inline(never)]
fn redetect(Pipeline { stage, outcome }: &mut Pipeline, Verified { candidate, .. }: Verified) {
    *stage = Stage::Done;
    let Some(track) = &mut outcome.track else { return };
    track.sweep.move_on();
    let evidence = Evidence::of(&candidate);
    if evidence.finds(Evidence::of(&outcome.candidate)) {
        track.motion = Motion::at(candidate.place);
        track.confidence = Confidence::found(evidence);
        outcome.candidate = candidate;
    }
}

/// The target's place from the middle of a window, in units of 1/256 cell.
fn offset(grid: &Grid, centre: Place, target: Place) -> (i32, i32) {
    let cell = (i64::from(CELL) * grid.step_at(centre.scale)).max(1);
    let cells = |to: i64, from: i64| i32::try_from(quotient((to - from) * 256, cell)).unwrap_or(0);
    (cells(target.x, centre.x), cells(target.y, centre.y))
}
