//! The robust tracker in f64, a reference for `smr-core` that is meant to be checked against its description by eye.
//!
//! It is slow, and shares no code or constant with `smr-core`. Both round at the same steps, and all sums are exact in
//! f64, so all values must be equal in every frame. Positions are in frame pixels. Files have the names of the stages
//! in `core/src/track/robust`; `refinement` includes the alignment, `target_box` motion and redetection.

mod confidence;
mod gaussian;
mod gradients;
mod learning;
mod lighting;
mod numbers;
mod refinement;
mod refiner;
mod response;
mod rounding;
mod sampling;
mod target_box;
mod verification;

pub use confidence::Decision;
pub use gradients::Cells;
pub use lighting::{free_gain, relit, threshold};
pub use numbers::Numbers;
pub use sampling::{Lattice, Patch, Picture, Shape};

use confidence::{FULL, confidence, decision, evidence, found_mean, running_mean, vetoed};
use gradients::features;
use learning::{Filter, Sample, ScaledIntegers};
use refinement::Aligned;
use refiner::Refiner;
use response::{Peak, peak, penalised, responses};
use rounding::{FINE, POSITION, SCALE, down, nearest, to_f64, to_zero};
use target_box::{Place, sweep, whole_box};
use verification::Similarity;

pub struct Step {
    /// Features of the search window, and the filter's response at each of its offsets.
    pub cells: Cells,
    pub responses: Vec<f64>,
    /// Largest filter response, after the distance penalty, in the window that gave the box: the sweep's window if the
    /// target was found there, else the usual search window.
    pub response: f64,
    pub ratio: f64,
    pub decision: Decision,
    pub confidence: f64,
    /// Running mean of the network's logits, mapped to 0 to 65535; `None` without the refiner.
    pub identity: Option<f64>,
    pub scale: f64,
    /// Box in pixels (left, top, width, height): first with fractions, second with edges rounded to whole pixels.
    pub fine: [f64; 4],
    pub bbox: [i64; 4],
    pub learned: bool,
    /// True if the lost target was searched for in the next few windows of a grid over the whole frame.
    pub swept: bool,
    pub found: bool,
    /// True if a lost target was found again, in its usual search window or in the search of the whole frame.
    pub found_again: bool,
}

/// Best position in a search window, with the values that verify it.
struct Candidate {
    cells: Cells,
    responses: Vec<f64>,
    place: Place,
    response: f64,
    aligned: Aligned,
    agreement: f64,
    /// Contrast of the search window in gray levels, and gain from the early template's contrast to that of the patch.
    window: f64,
    gain: f64,
    can_show: bool,
}

impl Candidate {
    fn evidence(&self) -> f64 {
        if self.can_show { evidence(self.agreement, self.response) } else { 0.0 }
    }
}

pub struct Reference {
    numbers: Numbers,
    similarity: Similarity,
    frame_size: (i64, i64),
    target_size: (i64, i64),
    shape: Shape,
    place: Place,
    /// Velocity to the right and down, in pixels per frame.
    velocity: (f64, f64),
    filter: Filter,
    /// Early template: a slow running mean of the target's patches, rounded to 1/256 gray level.
    early: Patch,
    /// Lighting: gain of the early template's contrast, divided by the search window's contrast in gray levels.
    light: f64,
    /// Frames since the lock or the last find, and the recent offset from the expected position, in cells.
    age: i64,
    off: f64,
    mean_evidence: f64,
    /// Scale in the last frame whose state was *tracking*.
    tracked_scale: f64,
    next_window: i64,
    refiner: Option<Refiner>,
}

impl Reference {
    /// Locks on the box `target` (left, top, width, height) inside the frame. `refiner`: the network's weights file.
    pub fn lock(
        numbers: Numbers,
        refiner: &'static [u8],
        frame: &[u8],
        frame_size: (i64, i64),
        target: (i64, i64, i64, i64),
    ) -> Self {
        let (x, y, width, height) = target;
        let shape = Shape::new(&numbers, width, height);
        let middle = |from: i64, size: i64| to_f64(from) + (to_f64(size) - 1.0) / 2.0;
        let place = Place { x: middle(x, width), y: middle(y, height), scale: 1.0 };
        let frame = Picture { pixels: frame, width: frame_size.0, height: frame_size.1 };
        let window = features(&numbers, &place.window(&numbers, &shape, numbers.reach).sample(&numbers, &frame));
        let mut filter = Filter::new(&shape);
        filter.lock(&numbers, &shape, &window);
        let first = place.bbox((width, height));
        let refiner = numbers.refiner.then(|| Refiner::new(&numbers, refiner, &frame, first));
        Self {
            refiner,
            similarity: Similarity::new(numbers.similarity_scale),
            frame_size,
            target_size: (width, height),
            shape,
            place,
            velocity: (0.0, 0.0),
            filter,
            early: without_margin(&numbers, &place.view(&numbers, &shape).sample(&numbers, &frame)),
            light: lighting::gain_per_contrast(1.0, lighting::window_contrast(&numbers, &window)),
            age: 0,
            off: 0.0,
            mean_evidence: FULL,
            tracked_scale: 1.0,
            next_window: 0,
            numbers,
        }
    }

    pub fn shape(&self) -> Shape {
        self.shape
    }

    pub fn weights(&self) -> &[f64] {
        &self.filter.weights
    }

    pub fn early(&self) -> Patch {
        Patch { pixels: self.early.pixels.iter().map(|&pixel| nearest(pixel, 1.0)).collect(), ..self.early }
    }

    /// Bounds (left, top, right, bottom) of the frame pixels that the next update may read to track the target,
    /// including searches at other scales around any position in the search window.
    pub fn region(&self) -> [i64; 4] {
        let Numbers { size, scale_reach, cell, margin, .. } = self.numbers;
        let reach = self.reach();
        let around = |place: Place, reach| self.region_around(place, reach);
        let centre = self.expected();
        let mut all = vec![around(centre, reach + self.margin_cells())];
        if size {
            let larger = |scale| around(Place { scale, ..centre }, reach + scale_reach + self.margin_cells());
            all.extend(self.other_scales(centre.scale).map(larger));
        }
        // The target's move is at most the search radius plus 1 cell, plus the alignment margin, plus 2 template pixels, and
        // its scale may grow.
        let [_, larger] = self.other_scales(centre.scale);
        all.extend(self.crops_around(Place { scale: larger, ..centre }, (reach + 1) * cell + margin + 2));
        all.into_iter().reduce(union).expect("there is a window")
    }

    /// Bounds (left, top, right, bottom) of the frame pixels that the next update also reads if it searches the sweep's
    /// windows. `None` if the sweep is off, or if the network has not given up the target and even evidence 0 in the
    /// next frame would not make the target lost.
    pub fn sweep_region(&self) -> Option<[i64; 4]> {
        let Numbers { sweep, reach, cell, .. } = self.numbers;
        let lost_next = decision(&self.numbers, running_mean(&self.numbers, self.mean_evidence, 0.0)) == Decision::Lost;
        if sweep == 0 || !lost_next && !self.given_up() {
            return None;
        }
        let windows = self.sweep().into_iter().map(|place| {
            let window = self.region_around(place, reach + self.margin_cells());
            self.crops_around(place, (reach + 1) * cell).map_or(window, |crops| union(window, crops))
        });
        windows.reduce(union)
    }

    /// Bounds of the pixels that the refiner's crops may read at `place` and up to `pixels` template pixels around it.
    /// `None` without the refiner.
    fn crops_around(&self, place: Place, pixels: i64) -> Option<[i64; 4]> {
        let refiner = self.refiner.as_ref()?;
        let by = to_f64(pixels) * self.shape.step_at(place.scale);
        Some(refiner.region(place.bbox(self.target_size), by, self.frame_size))
    }

    fn margin_cells(&self) -> i64 {
        (self.numbers.margin + self.numbers.cell - 1) / self.numbers.cell
    }

    fn region_around(&self, place: Place, reach: i64) -> [i64; 4] {
        place.window(&self.numbers, &self.shape, reach).region(&self.numbers, self.frame_size)
    }

    pub fn update(&mut self, frame: &[u8]) -> Step {
        let frame = Picture { pixels: frame, width: self.frame_size.0, height: self.frame_size.1 };
        let (weights, centre) = (self.filter.scaled(&self.numbers), self.expected());
        let reach = self.reach();
        let mut candidate = self.candidate(&frame, &weights, centre, reach);
        let growth = self.refine(&mut candidate);
        let was_lost = self.decision() == Decision::Lost;
        // Centre of the label: offset of the target from the window's middle in cells, rounded toward 0 to 1/256 cell.
        let cell = to_f64(self.numbers.cell) * self.shape.step_at(centre.scale);
        let moved = |to: f64, from: f64| to_zero((to - from) / cell, FINE);
        let target = (moved(candidate.place.x, centre.x), moved(candidate.place.y, centre.y));
        if self.numbers.size {
            candidate.place.scale = match growth {
                Some(growth) => self.limited(candidate.place.scale + down(candidate.place.scale * growth, SCALE)),
                None => self.best_scale(&frame, &weights, &candidate),
            };
        }
        let is_exact = candidate.agreement >= self.numbers.refined_from;
        let estimates = if candidate.can_show && !is_exact { self.estimates(&frame, candidate.place) } else { None };
        let evidence = self.identified(candidate.evidence(), is_exact, estimates.as_deref());
        self.mean_evidence = running_mean(&self.numbers, self.mean_evidence, evidence);
        let given_up = self.given_up();
        self.mean_evidence *= if given_up { 0.0 } else { 1.0 };
        let lost = decision(&self.numbers, self.mean_evidence) == Decision::Lost;
        let learned = !lost && evidence >= self.numbers.learned_from;
        if learned {
            let light = lighting::gain_per_contrast(candidate.gain, candidate.window);
            self.light = lighting::running_light(&self.numbers, self.light, light);
            for (mean, new) in self.early.pixels.iter_mut().zip(&candidate.aligned.seen.pixels) {
                *mean += nearest((new - *mean) * self.numbers.early_rate, FINE);
            }
        }
        self.settle(if candidate.can_show { target } else { (0.0, 0.0) });
        if !candidate.can_show {
            candidate.place = self.place;
        }
        let rate = self.numbers.velocity_rate;
        let followed = |moved: f64, velocity: f64| down(velocity + (moved - velocity) * rate, POSITION);
        let (right, below) = (candidate.place.x - self.place.x, candidate.place.y - self.place.y);
        self.velocity = (followed(right, self.velocity.0), followed(below, self.velocity.1));
        let (cells, responses) = (candidate.cells.clone(), candidate.responses.clone());
        let (swept, there) = (lost && self.numbers.sweep > 0, if given_up { 0.0 } else { evidence });
        let found = swept.then(|| self.redetect(&frame, &weights, there)).flatten();
        let is_found = found.is_some();
        if let Some(elsewhere) = found {
            (self.age, self.off) = (0, 0.0);
            (self.velocity, self.mean_evidence) = ((0.0, 0.0), found_mean(&self.numbers, elsewhere.evidence()));
            self.refiner.iter_mut().for_each(|refiner| refiner.begin_again(&self.numbers));
            candidate = elsewhere;
        }
        self.place = candidate.place;
        if learned {
            let sample = Sample { cells: &cells, responses: &responses, reach, target };
            let length = (self.numbers.update_step, 5 * reach / 8);
            self.filter.learn(&self.numbers, &self.shape, &sample, length, None);
        }
        if decision(&self.numbers, self.mean_evidence) == Decision::Tracking {
            self.tracked_scale = self.place.scale;
        }
        let (mut fine, scale) = (self.place.bbox(self.target_size), self.place.scale);
        if let Some(refiner) = &mut self.refiner {
            match estimates {
                _ if lost => {}
                Some(estimates) => refiner.update(&self.numbers, &estimates, learned),
                None if is_exact => refiner.fade(&self.numbers),
                None => {}
            }
            fine = refiner.correct(fine);
        }
        let decision = self.decision();
        Step {
            cells,
            responses,
            response: candidate.response,
            ratio: candidate.agreement,
            decision,
            confidence: confidence(self.mean_evidence),
            identity: self.refiner.as_ref().map(|refiner| refiner.identity(&self.numbers)),
            scale,
            fine,
            bbox: whole_box(fine),
            learned,
            swept,
            found: is_found,
            found_again: was_lost && decision != Decision::Lost,
        }
    }

    /// The network's estimates for the box at a place; `None` without the refiner.
    fn estimates(&self, frame: &Picture<'_>, place: Place) -> Option<Vec<f64>> {
        let refiner = self.refiner.as_ref()?;
        Some(refiner.estimates(&self.numbers, frame, place.bbox(self.target_size)))
    }

    /// Updates the identity by the frame's logit, if there is one. Returns the evidence that its veto leaves.
    fn identified(&mut self, evidence: f64, is_exact: bool, estimates: Option<&[f64]>) -> f64 {
        let Some(refiner) = &mut self.refiner else { return evidence };
        let logit = if is_exact {
            self.numbers.exact_logit
        } else if let Some(estimates) = estimates {
            refiner::logit(&self.numbers, estimates)
        } else {
            return evidence;
        };
        refiner.identify(&self.numbers, logit);
        vetoed(&self.numbers, evidence, logit)
    }

    fn given_up(&self) -> bool {
        let Numbers { sweep, lost_below, .. } = self.numbers;
        sweep > 0 && lost_below > 0.0 && self.refiner.as_ref().is_some_and(|refiner| refiner.gives_up(&self.numbers))
    }

    /// Worse of two decisions: by the mean evidence, and by the network's opinion of the box.
    fn decision(&self) -> Decision {
        let opinion = self.refiner.as_ref().map_or(Decision::Tracking, |refiner| refiner.decision(&self.numbers));
        decision(&self.numbers, self.mean_evidence).max(opinion)
    }

    /// The radius of the next search window, in cells: smaller while the target is tracked and calm.
    fn reach(&self) -> i64 {
        let Numbers { reach, calm_reach, calm_after, calm_off, .. } = self.numbers;
        let is_calm = self.age >= calm_after && self.off <= calm_off;
        let is_tracked = decision(&self.numbers, self.mean_evidence) == Decision::Tracking && !self.given_up();
        if is_calm && is_tracked { reach.min(calm_reach) } else { reach }
    }

    /// Counts a frame in which the target was `right` and `below` cells from its expected position.
    fn settle(&mut self, (right, below): (f64, f64)) {
        let largest = to_f64(i64::from(u16::MAX)) / FINE;
        self.off =
            right.abs().max(below.abs()).min(largest).max(down(self.off * (1.0 - self.numbers.calm_decay), FINE));
        self.age += 1;
    }

    fn expected(&self) -> Place {
        let part = self.numbers.velocity_fraction;
        self.place.moved(part * self.velocity.0, part * self.velocity.1).inside(self.frame_size)
    }

    fn sweep(&self) -> Vec<Place> {
        sweep(&self.numbers, &self.shape, self.frame_size, self.tracked_scale, self.next_window)
    }

    fn candidate(&self, frame: &Picture<'_>, weights: &ScaledIntegers, centre: Place, reach: i64) -> Candidate {
        let Numbers { cell, .. } = self.numbers;
        let cells =
            features(&self.numbers, &centre.window(&self.numbers, &self.shape, reach).sample(&self.numbers, frame));
        let responses = responses(&self.shape, weights, &cells, reach);
        let Peak { x, y, response, .. } = peak(&penalised(&self.numbers, &responses, reach), reach);
        let cell = to_f64(cell) * self.shape.step_at(centre.scale);
        let place = centre.moved(x * cell, y * cell).inside(self.frame_size);
        let view = place.view(&self.numbers, &self.shape).sample(&self.numbers, frame);
        let (numbers, early) = (&self.numbers, self.early());
        let window = lighting::window_contrast(numbers, &cells);
        let expected = lighting::expected_gain(numbers, self.light, window);
        let aligned = refinement::aligned(numbers, &self.similarity, &view, &early, expected);
        let gain = lighting::gain(numbers, &early, &aligned.seen, expected);
        let can_show = lighting::can_show(numbers, &early, &aligned.seen, expected);
        let agreement = if can_show { self.similarity.agreement(numbers, &aligned.seen, &early, gain) } else { 0.0 };
        Candidate { cells, responses, place, response, aligned, agreement, window, gain, can_show }
    }

    /// Refines the target's position by aligning the early template, and returns the relative growth of the target;
    /// `None` if the agreement is below `refined_from`.
    fn refine(&self, candidate: &mut Candidate) -> Option<f64> {
        if candidate.agreement < self.numbers.refined_from {
            return None;
        }
        let (aligned, pixel) = (&candidate.aligned, self.shape.step_at(candidate.place.scale));
        let step = refinement::step(&self.numbers, &self.early(), &aligned.seen, candidate.gain);
        let place = candidate.place.moved((to_f64(aligned.x) + step.x) * pixel, (to_f64(aligned.y) + step.y) * pixel);
        candidate.place = place.inside(self.frame_size);
        Some(step.growth)
    }

    fn other_scales(&self, scale: f64) -> [f64; 2] {
        let Numbers { scale_step, .. } = self.numbers;
        [self.limited(scale / scale_step), self.limited(scale * scale_step)]
    }

    fn limited(&self, scale: f64) -> f64 {
        let most = self.numbers.most_scale;
        down(scale, SCALE).clamp(down(1.0 / most, SCALE), most)
    }

    /// Scale with the highest interpolated response: the current scale, the next smaller or the next larger one.
    /// Responses at the other two scales count `scale_gain` / 256.
    fn best_scale(&self, frame: &Picture<'_>, weights: &ScaledIntegers, candidate: &Candidate) -> f64 {
        let Numbers { scale_gain, scale_reach, .. } = self.numbers;
        let (mut highest, mut best) = (f64::NEG_INFINITY, candidate.place.scale);
        let [smaller, larger] = self.other_scales(candidate.place.scale);
        for (scale, part) in [(best, FINE), (smaller, scale_gain), (larger, scale_gain)] {
            let window = Place { scale, ..candidate.place }.window(&self.numbers, &self.shape, scale_reach);
            let cells = features(&self.numbers, &window.sample(&self.numbers, frame));
            let peak = peak(&responses(&self.shape, weights, &cells, scale_reach), scale_reach);
            let counts = (peak.height * part / FINE).floor();
            if counts > highest {
                (highest, best) = (counts, scale);
            }
        }
        best
    }

    /// Searches the next windows of the sweep for the lost target. Returns the first candidate whose evidence suffices,
    /// is enough above `followed`, the evidence at the tracked position, and that the network recognises.
    fn redetect(&mut self, frame: &Picture<'_>, weights: &ScaledIntegers, followed: f64) -> Option<Candidate> {
        let Numbers { found_from, better_by, recognised_from, recognised_better_by, .. } = self.numbers;
        let (from, lead) = match self.refiner {
            Some(_) => (recognised_from, recognised_better_by),
            None => (found_from, better_by),
        };
        for place in self.sweep() {
            self.next_window += 1;
            let candidate = self.candidate(frame, weights, place, self.numbers.reach);
            let suffices = candidate.evidence() >= from && candidate.evidence() >= followed + lead;
            if suffices && self.recognises(frame, candidate.place) {
                return Some(candidate);
            }
        }
        None
    }

    fn recognises(&self, frame: &Picture<'_>, place: Place) -> bool {
        let estimates = self.estimates(frame, place);
        estimates.is_none_or(|estimates| refiner::logit(&self.numbers, &estimates) >= self.numbers.recognised_logit)
    }
}

fn union(a: [i64; 4], b: [i64; 4]) -> [i64; 4] {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
}

fn without_margin(numbers: &Numbers, view: &Patch) -> Patch {
    let margin = numbers.margin;
    let middle = view.cut(margin, margin, view.columns - 2 * margin, view.rows - 2 * margin);
    middle.expect("a view has a margin")
}
