//! The robust method in f64, written from its description and meant to be checked against it by eye.
//!
//! It takes no number, no table and no arithmetic from `smr-core`, and it is slow. Positions are in pixels, scales in 1; where
//! the method says on which grid a number lies it is rounded to that grid (`rounding.rs`), so that both trackers walk through
//! a recording side by side. All sums are of numbers that f64 has exactly.

mod agreement;
mod exact;
mod features;
mod filter;
mod grid;
mod label;
mod light;
mod look;
mod numbers;
mod place;
mod rounding;
mod trust;

pub use features::Cells;
pub use grid::{Lattice, Patch, Picture, Shape};
pub use light::{in_light_of, threshold};
pub use numbers::{Numbers, Parts};
pub use trust::Belief;

use agreement::Similarity;
use exact::Nearest;
use features::features;
use filter::{Coded, Filter, Sample};
use look::{Peak, nearer, peak, responses};
use place::{Place, sweep, whole_box};
use rounding::{FINE, POSITION, SCALE, down, nearest, real, to_zero};
use trust::{CLEAR, after, belief, confidence, evidence};

/// All that happened in one frame.
pub struct Step {
    /// The features of the search window, and the filter's responses to them.
    pub cells: Cells,
    pub responses: Vec<f64>,
    /// Of the place that is answered.
    pub response: f64,
    pub ratio: f64,
    pub belief: Belief,
    pub confidence: f64,
    pub scale: f64,
    /// The box: left, top, width, height; and its edges rounded, as left, top, width, height.
    pub fine: [f64; 4],
    pub bbox: [i64; 4],
    /// Whether it was learned from, whether the sweep looked, and whether it found.
    pub learned: bool,
    pub swept: bool,
    pub found: bool,
    /// Whether it was lost before and is not any more: found by the sweep, or seen again where it was followed.
    pub found_again: bool,
}

/// What was seen in a window.
struct Look {
    cells: Cells,
    responses: Vec<f64>,
    place: Place,
    response: f64,
    nearest: Nearest,
    agreement: f64,
    /// What is seen there can show the target.
    shows: bool,
}

impl Look {
    fn evidence(&self) -> f64 {
        if self.shows { evidence(self.agreement, self.response) } else { 0.0 }
    }
}

/// The tracker in f64.
pub struct Reference {
    numbers: Numbers,
    similarity: Similarity,
    frame_size: (i64, i64),
    target_size: (i64, i64),
    shape: Shape,
    place: Place,
    /// In pixels a frame: right and down.
    velocity: (f64, f64),
    filter: Filter,
    /// A running mean on the grid of 1/256.
    early: Patch,
    /// The running mean of the evidence.
    trust: f64,
    /// The scale when it was last tracked.
    believed: f64,
    /// The number of the sweep's next window.
    next_window: i64,
}

impl Reference {
    /// Starts on the `width` x `height` box at (`x`, `y`) of a frame; the box lies inside the frame.
    pub fn lock(numbers: Numbers, frame: &[u8], frame_size: (i64, i64), target: (i64, i64, i64, i64)) -> Self {
        let (x, y, width, height) = target;
        let shape = Shape::new(&numbers, width, height);
        let middle = |from: i64, size: i64| real(from) + (real(size) - 1.0) / 2.0;
        let place = Place { x: middle(x, width), y: middle(y, height), scale: 1.0 };
        let frame = Picture { pixels: frame, width: frame_size.0, height: frame_size.1 };
        let window = features(&numbers, &place.window(&numbers, &shape, numbers.reach).sample(&numbers, &frame));
        let mut filter = Filter::new(&shape);
        for _ in 0..numbers.first_steps {
            let responses = responses(&shape, &filter.coded(&numbers), &window, numbers.reach);
            let sample = Sample { cells: &window, responses: &responses, target: (0.0, 0.0) };
            filter.learn(&numbers, &shape, &sample, numbers.first_step);
        }
        Self {
            similarity: Similarity::new(numbers.scale),
            frame_size,
            target_size: (width, height),
            shape,
            place,
            velocity: (0.0, 0.0),
            filter,
            early: middle_of(&numbers, &place.view(&numbers, &shape).sample(&numbers, &frame)),
            trust: CLEAR,
            believed: 1.0,
            next_window: 0,
            numbers,
        }
    }

    /// The grid's shape.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// The filter's weights.
    pub fn weights(&self) -> &[f64] {
        &self.filter.weights
    }

    /// The early template in whole gray levels.
    pub fn early(&self) -> Patch {
        Patch { pixels: self.early.pixels.iter().map(|&pixel| nearest(pixel, 1.0)).collect(), ..self.early }
    }

    /// The frame pixels that the next update may read where the target is followed: left, top, right, bottom. The other scales are
    /// looked at anywhere in the window.
    pub fn region(&self) -> [i64; 4] {
        let Numbers { parts, reach, size_reach, .. } = self.numbers;
        let around = |place: Place, reach| self.around(place, reach);
        let centre = self.expected();
        let mut all = vec![around(centre, reach + self.rim())];
        if parts.size {
            let larger = |scale| around(Place { scale, ..centre }, reach + 2 * size_reach);
            all.extend(self.other_scales(centre.scale).map(larger));
        }
        let both = |a: [i64; 4], b: [i64; 4]| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])];
        all.into_iter().reduce(both).expect("there is a window")
    }

    /// Those that it may read elsewhere: the sweep's window, if a frame without evidence would make the target lost.
    pub fn sweep_region(&self) -> Option<[i64; 4]> {
        let Numbers { parts, reach, .. } = self.numbers;
        let lost_next = belief(&self.numbers, after(&self.numbers, self.trust, 0.0)) == Belief::Lost;
        (parts.verification && parts.sweep && lost_next).then(|| self.around(self.sweep(), reach + self.rim()))
    }

    /// The cells that the margin of a view lies on.
    fn rim(&self) -> i64 {
        (self.numbers.margin + self.numbers.cell - 1) / self.numbers.cell
    }

    fn around(&self, place: Place, reach: i64) -> [i64; 4] {
        place.window(&self.numbers, &self.shape, reach).region(&self.numbers, self.frame_size)
    }

    /// One frame.
    pub fn update(&mut self, frame: &[u8]) -> Step {
        let frame = Picture { pixels: frame, width: self.frame_size.0, height: self.frame_size.1 };
        let parts = self.numbers.parts;
        let (coded, centre) = (self.filter.coded(&self.numbers), self.expected());
        let mut look = self.look(&frame, &coded, centre);
        let growth = self.refine(&mut look);
        let was_lost = belief(&self.numbers, self.trust) == Belief::Lost;
        if parts.verification {
            self.trust = after(&self.numbers, self.trust, look.evidence());
        }
        let lost = belief(&self.numbers, self.trust) == Belief::Lost;
        let seen = look.evidence() >= self.numbers.learned_from;
        let learned = !lost && (seen || !parts.gated_learning || !parts.verification);
        if learned {
            towards(&mut self.early, &look.nearest.seen, self.numbers.early_rate);
        }
        // In cells, on a grid of 1/256.
        let cell = real(self.numbers.cell) * self.shape.step_at(centre.scale);
        let moved = |to: f64, from: f64| to_zero((to - from) / cell, FINE);
        let target = (moved(look.place.x, centre.x), moved(look.place.y, centre.y));
        if parts.size {
            look.place.scale = match growth {
                Some(growth) => self.within(look.place.scale + down(look.place.scale * growth, SCALE)),
                None => self.size(&frame, &coded, &look),
            };
        }
        if parts.verification && !look.shows {
            look.place = self.place;
        }
        let followed = |to: f64, from: f64, velocity: f64| {
            down(velocity + (to - from - velocity) * self.numbers.last_move, POSITION)
        };
        self.velocity = (
            followed(look.place.x, self.place.x, self.velocity.0),
            followed(look.place.y, self.place.y, self.velocity.1),
        );
        let (cells, responses) = (look.cells.clone(), look.responses.clone());
        let swept = lost && parts.sweep;
        let found = if swept { self.find(&frame, &coded, &look) } else { None };
        self.next_window += i64::from(swept);
        let is_found = found.is_some();
        if let Some(elsewhere) = found {
            (self.velocity, self.trust) = ((0.0, 0.0), elsewhere.evidence());
            look = elsewhere;
        }
        self.place = look.place;
        if learned {
            let sample = Sample { cells: &cells, responses: &responses, target };
            self.filter.learn(&self.numbers, &self.shape, &sample, self.numbers.step);
        }
        let belief = belief(&self.numbers, self.trust);
        if belief == Belief::Tracking {
            self.believed = self.place.scale;
        }
        let (fine, scale) = (self.place.bbox(self.target_size), self.place.scale);
        let (response, ratio, confidence) = (look.response, look.agreement, confidence(self.trust));
        let bbox = whole_box(fine);
        let (found, found_again) = (is_found, was_lost && belief != Belief::Lost);
        Step {
            cells,
            responses,
            response,
            ratio,
            belief,
            confidence,
            scale,
            fine,
            bbox,
            learned,
            swept,
            found,
            found_again,
        }
    }

    /// Where the target is expected.
    fn expected(&self) -> Place {
        let part = if self.numbers.parts.velocity { self.numbers.expected } else { 0.0 };
        self.place.moved(part * self.velocity.0, part * self.velocity.1).inside(self.frame_size)
    }

    /// The sweep's next place.
    fn sweep(&self) -> Place {
        sweep(&self.numbers, &self.shape, self.frame_size, self.believed, self.next_window)
    }

    fn look(&self, frame: &Picture<'_>, coded: &Coded, centre: Place) -> Look {
        let Numbers { reach, cell, parts, .. } = self.numbers;
        let cells =
            features(&self.numbers, &centre.window(&self.numbers, &self.shape, reach).sample(&self.numbers, frame));
        let responses = responses(&self.shape, coded, &cells, reach);
        let Peak { x, y, response, .. } = if parts.distance_penalty {
            peak(&nearer(&self.numbers, &responses), reach)
        } else {
            peak(&responses, reach)
        };
        let cell = real(cell) * self.shape.step_at(centre.scale);
        let place = centre.moved(x * cell, y * cell).inside(self.frame_size);
        let view = place.view(&self.numbers, &self.shape).sample(&self.numbers, frame);
        let nearest = exact::nearest(&self.numbers, &self.similarity, &view, &self.early());
        let shows = light::shows(&self.numbers, &self.early(), &nearest.seen);
        let agreement =
            if shows { self.similarity.agreement(&self.numbers, &nearest.seen, &self.early()) } else { 0.0 };
        Look { cells, responses, place, response, nearest, agreement, shows }
    }

    /// Moves a place to where the early template lies, if it agrees well; then says how much the target has grown, too.
    fn refine(&self, look: &mut Look) -> Option<f64> {
        if look.agreement < self.numbers.certain_from {
            return None;
        }
        let (nearest, pixel) = (&look.nearest, self.shape.step_at(look.place.scale));
        let step = exact::step(&self.numbers, &self.early(), &nearest.seen);
        let place = look.place.moved((real(nearest.x) + step.x) * pixel, (real(nearest.y) + step.y) * pixel);
        look.place = place.inside(self.frame_size);
        Some(step.growth)
    }

    /// The next smaller scale and the next larger one.
    fn other_scales(&self, scale: f64) -> [f64; 2] {
        let Numbers { size_step, .. } = self.numbers;
        [self.within(scale / size_step), self.within(scale * size_step)]
    }

    /// The next scale that is not larger, among those that a target can have.
    fn within(&self, scale: f64) -> f64 {
        let most = self.numbers.most_scale;
        down(scale, SCALE).clamp(down(1.0 / most, SCALE), most)
    }

    /// The scale whose response is largest: the last one, the next smaller one, or the next larger one.
    fn size(&self, frame: &Picture<'_>, coded: &Coded, look: &Look) -> f64 {
        let Numbers { size_part, size_reach, .. } = self.numbers;
        let (mut highest, mut best) = (f64::NEG_INFINITY, look.place.scale);
        let [smaller, larger] = self.other_scales(look.place.scale);
        for (scale, part) in [(best, FINE), (smaller, size_part), (larger, size_part)] {
            let window = Place { scale, ..look.place }.window(&self.numbers, &self.shape, size_reach);
            let cells = features(&self.numbers, &window.sample(&self.numbers, frame));
            let peak = peak(&responses(&self.shape, coded, &cells, size_reach), size_reach);
            let counts = (peak.height * part / FINE).floor();
            if counts > highest {
                (highest, best) = (counts, scale);
            }
        }
        best
    }

    /// The lost target, if the sweep's next window has clearly more of it than `followed`.
    fn find(&self, frame: &Picture<'_>, coded: &Coded, followed: &Look) -> Option<Look> {
        let Numbers { found_from, better_by, .. } = self.numbers;
        let look = self.look(frame, coded, self.sweep());
        (look.evidence() >= found_from && look.evidence() >= followed.evidence() + better_by).then_some(look)
    }
}

/// What a view has within its margin.
fn middle_of(numbers: &Numbers, view: &Patch) -> Patch {
    let margin = numbers.margin;
    let middle = view.cut(margin, margin, view.columns - 2 * margin, view.rows - 2 * margin);
    middle.expect("a view has a margin")
}

/// Moves a running mean one part in `rate` of the way to `patch`.
fn towards(mean: &mut Patch, patch: &Patch, rate: f64) {
    for (mean, new) in mean.pixels.iter_mut().zip(&patch.pixels) {
        *mean += nearest((new - *mean) * rate, FINE);
    }
}
