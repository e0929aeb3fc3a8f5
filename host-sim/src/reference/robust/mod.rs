//! The robust method in f64, written from its description and meant to be checked against it by eye.
//!
//! It takes no number, no table and no arithmetic from `smr-core`, is slow, and scores every offset. Positions are in
//! pixels, scales in 1; where the method says on which grid a number lies it is rounded to that grid (`rounding.rs`), so
//! that both trackers walk through a recording side by side. Scores are in units of 1/65535, summed twice as
//! [`Sums`] says; decisions follow the rounded sums.

mod cells;
mod correlation;
mod grid;
mod rounding;
mod scores;

pub use grid::{Patch, Shape};

use super::Sums;
use grid::{Lattice, Picture};
use rounding::{FINE, POSITION, SCALE, down, nearest, real, whole};
use scores::{Similarity, best, top};

/// One unit of a score: 1.0 is this many.
const UNITS: f64 = 65535.0;

/// The numbers of the method, all of them.
#[derive(Clone, Debug)]
pub struct Numbers {
    /// What the tracker consists of.
    pub parts: Parts,
    /// p = exp(-d / scale), d in gray levels.
    pub scale: f64,
    /// The template's most and the window's most pixels, and the window's most columns.
    pub pixels: i64,
    pub window_pixels: i64,
    pub window_columns: i64,
    /// The template's least side.
    pub least_side: i64,
    /// How far the search reaches, in pixels of the grid.
    pub radius: i64,
    /// Pixels of the grid around the window that may be read for a patch that has grown.
    pub margin: i64,
    /// alpha by contrast: .0 / .1 of the mean absolute deviation, and its bounds.
    pub contrast: (f64, f64),
    pub alpha_bounds: (f64, f64),
    /// alpha by the paper's rule: before the first update, and .0 / .1 of the largest change.
    pub first_alpha: f64,
    pub k: (f64, f64),
    /// The running means learn one part in so many of each patch.
    pub slow_rate: f64,
    pub early_rate: f64,
    /// The cells, and what one frame's growth can be at most.
    pub cells: CellNumbers,
    pub most_growth: f64,
    /// The largest scale; the least is 1 over it.
    pub most_scale: f64,
    /// Contrast of the light may change by this factor.
    pub most_gain: f64,
    /// The early template is compared in so many parts on each side; of their ratios the one that counts stands here, the least
    /// being the first.
    pub parts_across: i64,
    pub ratio_that_counts: usize,
    /// The early template's ratio, in units of 1/65535: doubtful below the first, not to be seen below the second, hardly
    /// anything of it below the third.
    pub doubtful_below: f64,
    pub denied_below: f64,
    pub far_below: f64,
    /// Frames in a row that make it lost, and how many one counts in which hardly anything is seen.
    pub patience: i64,
    pub far_counts: i64,
    /// Doubtful frames in a row that begin the sweep.
    pub doubts: i64,
    /// A lost target is seen again, or found, from this ratio on; a find has to be so much better than what is followed.
    pub seen_from: f64,
    pub better_by: f64,
    /// The sweep looks at a grid so many times as coarse, then so many pixels of the grid around what it found.
    pub coarser: i64,
    pub closer: i64,
    /// Coarse pixels around the sweep's window that the closer look may need.
    pub sweep_margin: i64,
    /// A patch with less than the template's variance over this is none.
    pub plain: f64,
}

/// What can be left out.
#[derive(Clone, Copy, Debug)]
pub struct Parts {
    pub enlarging: bool,
    /// alpha by contrast; without, by the paper's rule.
    pub contrast: bool,
    pub slow_template: bool,
    /// The early template's say in the peak.
    pub anchor: bool,
    pub sub_pixel: bool,
    pub cells: bool,
    pub verification: bool,
    /// Needs verification.
    pub sweep: bool,
}

/// The numbers of the cells, in pixels of the grid; fractions are .0 / .1 of a full score.
#[derive(Clone, Debug)]
pub struct CellNumbers {
    pub side: i64,
    pub stride: i64,
    pub reach: i64,
    pub least_score: (f64, f64),
    /// Over the mean of all offsets.
    pub lead: (f64, f64),
    pub least_cells: usize,
    pub least_pairs: usize,
    /// A pair says something only if its distance, squared, is more.
    pub far_squared: f64,
}

impl Numbers {
    /// As measured, with all parts.
    pub fn robust() -> Self {
        Self {
            parts: Parts {
                enlarging: true,
                contrast: true,
                slow_template: true,
                anchor: true,
                sub_pixel: true,
                cells: true,
                verification: true,
                sweep: true,
            },
            scale: 255.0,
            pixels: 1024,
            window_pixels: 12288,
            window_columns: 384,
            least_side: 4,
            radius: 32,
            margin: 4,
            contrast: (7.0, 5.0),
            alpha_bounds: (8.0, 100.0),
            first_alpha: 0.05 * 255.0,
            k: (1.0, 4.0),
            slow_rate: 32.0,
            early_rate: 256.0,
            cells: CellNumbers {
                side: 8,
                stride: 6,
                reach: 3,
                least_score: (3.0, 10.0),
                lead: (1.0, 50.0),
                least_cells: 5,
                least_pairs: 3,
                far_squared: 52.0,
            },
            most_growth: 1.05,
            most_scale: 4.0,
            most_gain: 2.0,
            parts_across: 4,
            ratio_that_counts: 4,
            doubtful_below: 26_500.0,
            denied_below: 22_000.0,
            far_below: 14_000.0,
            patience: 5,
            far_counts: 3,
            doubts: 3,
            seen_from: 44_000.0,
            better_by: 20_000.0,
            coarser: 2,
            closer: 2,
            sweep_margin: 2,
            plain: 16.0,
        }
    }
}

/// What the reference believes after a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Belief {
    Tracking,
    Uncertain,
    Lost,
}

/// All that happened in one frame.
pub struct Step {
    /// The search window on the grid.
    pub window: Patch,
    /// Every offset of the last patch, row by row, and of the slow template, if there is one.
    pub last: Vec<((i64, i64), Sums)>,
    pub slow: Vec<((i64, i64), Sums)>,
    /// The offset with the largest score by all templates, and that score.
    pub peak: ((i64, i64), f64),
    /// The alpha that this frame was scored with.
    pub alpha: f64,
    pub scale: f64,
    pub ratio: f64,
    pub belief: Belief,
    /// The box: left, top, width, height; and its edges rounded, as left, top, width, height.
    pub fine: [f64; 4],
    pub bbox: [i64; 4],
    /// Whether the sweep looked, and whether it found.
    pub swept: bool,
    pub found_again: bool,
}

/// The target's middle and its size against that of the first box.
#[derive(Clone, Copy, Debug)]
struct Place {
    x: f64,
    y: f64,
    scale: f64,
}

/// The tracker in f64.
pub struct Reference {
    numbers: Numbers,
    similarity: Similarity,
    frame_size: (i64, i64),
    target_size: (i64, i64),
    shape: Shape,
    place: Place,
    alpha: f64,
    last: Patch,
    /// Running means on the grid of 1/256.
    slow: Patch,
    early: Patch,
    /// The early template in the light of the last patch.
    anchor: Patch,
    belief: Belief,
    /// Frames in a row in which the early template was not seen, and in which it was doubtful.
    denied: i64,
    doubted: i64,
    /// The scale when it was last clearly seen.
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
        let picture = Picture { pixels: frame, width: frame_size.0, height: frame_size.1 };
        let patch = lattice(&shape, place, 0).sample(&picture);
        let alpha = if numbers.parts.contrast { by_contrast(&numbers, &patch) } else { numbers.first_alpha };
        Self {
            similarity: Similarity::new(numbers.scale),
            numbers,
            frame_size,
            target_size: (width, height),
            shape,
            place,
            alpha,
            last: patch.clone(),
            slow: patch.clone(),
            early: patch.clone(),
            anchor: patch,
            belief: Belief::Tracking,
            denied: 0,
            doubted: 0,
            believed: 1.0,
            next_window: 0,
        }
    }

    /// The grid's shape.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// The last patch.
    pub fn last(&self) -> &Patch {
        &self.last
    }

    /// The slow template in whole gray levels.
    pub fn slow(&self) -> Patch {
        in_gray_levels(&self.slow)
    }

    /// The early template in whole gray levels.
    pub fn early(&self) -> Patch {
        in_gray_levels(&self.early)
    }

    /// The early template in the light of the last patch.
    pub fn anchor(&self) -> &Patch {
        &self.anchor
    }

    /// alpha of the next frame.
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// The frame pixels that the next update may read: left, top, right, bottom. The sweep's window is one of them if it
    /// may look there.
    pub fn region(&self) -> [i64; 4] {
        let Numbers { parts, radius, margin, doubts, sweep_margin, .. } = self.numbers;
        let near = lattice(&self.shape, self.place, radius + margin).region(self.frame_size);
        if !parts.verification || !parts.sweep || self.doubted + 1 < doubts {
            return near;
        }
        let far = self.sweep_window(sweep_margin).region(self.frame_size);
        [near[0].min(far[0]), near[1].min(far[1]), near[2].max(far[2]), near[3].max(far[3])]
    }

    /// One frame.
    pub fn update(&mut self, frame: &[u8]) -> Step {
        let frame = Picture { pixels: frame, width: self.frame_size.0, height: self.frame_size.1 };
        let (alpha, parts) = (self.alpha, self.numbers.parts);
        let window = lattice(&self.shape, self.place, self.numbers.radius).sample(&frame);
        let last = self.similarity.all(&window, &self.last, alpha);
        let slow = if parts.slow_template { self.similarity.all(&window, &self.slow(), alpha) } else { Vec::new() };
        let peak = self.peak(&window, &last, &slow);
        let mut place = self.moved(&window, peak);
        if parts.cells {
            place.scale = self.grown(&window, peak.0);
        }
        let weights = if parts.anchor { 5.0 } else { 3.0 };
        let mut ratio = (peak.1 / (weights * self.template_pixels())).floor();
        let (mut swept, mut found) = (false, None);
        if parts.verification {
            ratio = self.agreement(&window, peak.0);
            self.judge(ratio);
            if self.doubted >= self.numbers.doubts && parts.sweep {
                swept = true;
                found = self.sweep(&frame, ratio);
                self.next_window += 1;
            }
        }
        if let Some((at, agreement)) = found {
            (place, ratio) = (at, agreement);
            (self.belief, self.denied, self.doubted) = (Belief::Tracking, 0, 0);
        }
        self.place = place;
        self.learn(&frame, found.is_some());
        let (fine, belief) = (self.fine(), self.belief);
        let (scale, bbox, found_again) = (place.scale, whole_box(fine), found.is_some());
        Step { window, last, slow, peak, alpha, scale, ratio, belief, fine, bbox, swept, found_again }
    }

    fn template_pixels(&self) -> f64 {
        real(self.shape.columns * self.shape.rows)
    }

    /// The last patch counts twice, the slow template once (without one the last patch stands in for it), the anchor twice.
    fn score_of_all(&self, window: &Patch, x: i64, y: i64) -> Option<f64> {
        let slow = if self.numbers.parts.slow_template { &self.slow() } else { &self.last };
        let last = self.similarity.score(window, &self.last, x, y, self.alpha)?;
        let slow = self.similarity.score(window, slow, x, y, self.alpha)?;
        let anchor = self.similarity.score(window, &self.anchor, x, y, self.alpha)?;
        let anchored = if self.numbers.parts.anchor { 2.0 * anchor.rounded } else { 0.0 };
        Some(2.0 * last.rounded + slow.rounded + anchored)
    }

    /// The best by all templates of the offsets next to the last patch's and the slow template's own best.
    fn peak(&self, window: &Patch, last: &[((i64, i64), Sums)], slow: &[((i64, i64), Sums)]) -> ((i64, i64), f64) {
        let middle = self.numbers.radius;
        let searches = [last, slow].into_iter().filter(|scores| !scores.is_empty());
        let candidates = searches.flat_map(|scores| {
            let ((x, y), _) = best(scores.iter().map(|&(at, sums)| (at, sums.rounded)), middle);
            around(x, y, 1)
        });
        let scored = candidates.filter_map(|(x, y)| Some(((x, y), self.score_of_all(window, x, y)?)));
        best(scored, middle)
    }

    /// The target's middle when the peak, or the top of the parabola through its neighbours, is the template's place.
    fn moved(&self, window: &Patch, ((x, y), score): ((i64, i64), f64)) -> Place {
        let part = |before: Option<f64>, after: Option<f64>| match (before, after) {
            (Some(before), Some(after)) if self.numbers.parts.sub_pixel => top(before, score, after),
            _ => 0.0,
        };
        let across = part(self.score_of_all(window, x - 1, y), self.score_of_all(window, x + 1, y));
        let along = part(self.score_of_all(window, x, y - 1), self.score_of_all(window, x, y + 1));
        let step = self.shape.step_at(self.place.scale);
        let offset = |at: i64, part: f64| down((real(at - self.numbers.radius) + part) * step, POSITION);
        self.inside(Place {
            x: self.place.x + offset(x, across),
            y: self.place.y + offset(y, along),
            scale: self.place.scale,
        })
    }

    /// The place, its middle not beyond the frame's pixels.
    fn inside(&self, place: Place) -> Place {
        let within = |at: f64, size: i64| at.clamp(0.0, real(size) - 1.0);
        Place { x: within(place.x, self.frame_size.0), y: within(place.y, self.frame_size.1), ..place }
    }

    /// The scale after the cells were looked for, with the template at `peak`: half of the way, as logarithms go.
    fn grown(&self, window: &Patch, peak: (i64, i64)) -> f64 {
        let numbers = &self.numbers;
        let side = numbers.cells.side;
        let slow = if numbers.parts.slow_template { self.slow() } else { self.last.clone() };
        let score = |(x, y): (i64, i64), (dx, dy): (i64, i64)| {
            let score_of = |template: &Patch| {
                let cell = template.cut(x, y, side, side)?;
                self.similarity.score(window, &cell, peak.0 + x + dx, peak.1 + y + dy, self.alpha)
            };
            // What lies outside the window is not seen at all.
            match (score_of(&self.last), score_of(&slow)) {
                (Some(last), Some(slow)) => 2.0 * last.rounded + slow.rounded,
                _ => 0.0,
            }
        };
        let Some(growth) = cells::growth_squared(&numbers.cells, &self.last, score) else { return self.place.scale };
        let most = numbers.most_growth * numbers.most_growth;
        let growth = growth.clamp(down(1.0 / most, SCALE), down(most, SCALE));
        let factor = down(down(growth.sqrt(), SCALE).sqrt(), SCALE);
        nearest(self.place.scale * factor, SCALE).clamp(1.0 / numbers.most_scale, numbers.most_scale)
    }

    /// The early template's best agreement at the peak and next to it.
    fn agreement(&self, window: &Patch, (x, y): (i64, i64)) -> f64 {
        around(x, y, 1).filter_map(|(x, y)| self.agreement_at(window, x, y)).fold(0.0, f64::max)
    }

    /// How well the early template, in the light of what is seen there, agrees with it part by part.
    fn agreement_at(&self, window: &Patch, x: i64, y: i64) -> Option<f64> {
        let Shape { columns, rows, .. } = self.shape;
        let seen = window.cut(x, y, columns, rows)?;
        let lit = in_light_of(&self.numbers, &self.early(), &seen);
        let (_, deviation) = mean_and_deviation(&seen);
        let (least, most) = self.numbers.alpha_bounds;
        let alpha = (deviation / self.template_pixels()).floor().clamp(least, most);
        let across = self.numbers.parts_across;
        let mut ratios: Vec<f64> = (0..across * across)
            .map(|part| {
                let (column, row) = (part % across, part / across);
                let (left, right) = (column * columns / across, (column + 1) * columns / across);
                let (top, bottom) = (row * rows / across, (row + 1) * rows / across);
                let lit = lit.cut(left, top, right - left, bottom - top).expect("parts lie in the template");
                let sums = self.similarity.score(&seen, &lit, left, top, alpha).expect("parts lie in the patch");
                (sums.rounded / real((right - left) * (bottom - top))).floor()
            })
            .collect();
        ratios.sort_by(f64::total_cmp);
        Some(ratios[self.numbers.ratio_that_counts - 1])
    }

    /// Lost after some frames in a row in which the target was not to be seen, until it is clearly seen.
    fn judge(&mut self, ratio: f64) {
        let Numbers { patience, far_counts, doubts, seen_from, doubtful_below, denied_below, far_below, .. } =
            self.numbers;
        let was_lost = self.denied == patience;
        let seen = ratio >= if was_lost { seen_from } else { doubtful_below };
        if seen {
            (self.denied, self.doubted) = (0, 0);
        } else {
            self.doubted = (self.doubted + 1).min(doubts);
            let denied = was_lost || ratio < denied_below;
            let count = if ratio < far_below { far_counts } else { 1 };
            self.denied = if denied { (self.denied + count).min(patience) } else { 0 };
        }
        self.belief = if self.denied == patience {
            Belief::Lost
        } else if ratio < doubtful_below {
            Belief::Uncertain
        } else {
            Belief::Tracking
        };
    }

    /// The sweep's next window: the frame is divided into equal parts, no larger than a search reaches, each with a window in
    /// its middle, at the scale that was last believed, on a coarser grid; and so many pixels around it.
    fn sweep_window(&self, around: i64) -> Lattice {
        let coarser = self.numbers.coarser;
        let step = real(coarser) * self.shape.step_at(self.believed);
        let side = |size: i64| size / coarser + 2 * (self.numbers.radius + around);
        let reach = real(2 * self.numbers.radius + 1) * step;
        let count = |size: i64| whole((real(size) / reach).ceil());
        let (columns, rows) = (count(self.frame_size.0), count(self.frame_size.1));
        let number = self.next_window % (columns * rows);
        let middle = |number: i64, count: i64, size: i64| {
            (down((real(number) + 0.5) * real(size) / real(count), POSITION) - 0.5).max(0.0)
        };
        let x = middle(number % columns, columns, self.frame_size.0);
        let y = middle(number / columns, rows, self.frame_size.1);
        Lattice { x, y, step, columns: side(self.shape.columns), rows: side(self.shape.rows) }
    }

    /// Where the early template agrees clearly in the sweep's window, and much better than what is followed.
    fn sweep(&self, frame: &Picture<'_>, followed: f64) -> Option<(Place, f64)> {
        let Numbers { seen_from, better_by, coarser, closer, radius, plain, .. } = self.numbers;
        let coarse = self.sweep_window(0);
        let early = self.early().coarser(coarser);
        let (x, y) = correlation::best(&coarse.sample(frame), &early, plain)?;
        let near = lattice(&self.shape, self.place_in(&coarse, x, y, radius), closer);
        let view = near.sample(frame);
        let ratios =
            around(closer, closer, closer).filter_map(|(x, y)| Some(((x, y), self.agreement_at(&view, x, y)?)));
        // Of equals the first.
        let ((x, y), ratio) = ratios.fold(((closer, closer), 0.0), |best, new| if new.1 > best.1 { new } else { best });
        let found = ratio >= seen_from && ratio >= followed + better_by;
        found.then(|| (self.place_in(&near, x, y, closer), ratio))
    }

    /// The place at an offset of a window that reaches `radius` around the template, at the believed scale.
    fn place_in(&self, window: &Lattice, x: i64, y: i64, radius: i64) -> Place {
        let at = |middle: f64, offset: i64| middle + real(offset - radius) * window.step;
        self.inside(Place { x: at(window.x, x), y: at(window.y, y), scale: self.believed })
    }

    /// The templates and alpha of the next frame.
    fn learn(&mut self, frame: &Picture<'_>, found_again: bool) {
        let patch = lattice(&self.shape, self.place, 0).sample(frame);
        if found_again {
            self.slow = self.early();
        } else {
            towards(&mut self.slow, &patch, self.numbers.slow_rate);
        }
        if self.numbers.parts.contrast {
            self.alpha = by_contrast(&self.numbers, &patch);
        } else {
            let changes = self.last.pixels.iter().zip(&patch.pixels).map(|(old, new)| (old - new).abs());
            let largest = changes.fold(0.0, f64::max);
            if largest > 0.0 {
                self.alpha = largest * self.numbers.k.0 / self.numbers.k.1;
            }
        }
        if self.belief != Belief::Lost {
            towards(&mut self.early, &patch, self.numbers.early_rate);
        }
        if self.belief == Belief::Tracking {
            self.believed = self.place.scale;
        }
        self.anchor = in_light_of(&self.numbers, &self.early(), &patch);
        self.last = patch;
    }

    /// The box: left, top, width, height.
    fn fine(&self) -> [f64; 4] {
        let size = |size: i64| nearest(real(size) * self.place.scale, FINE);
        let (width, height) = (size(self.target_size.0), size(self.target_size.1));
        // A position is that of a pixel's middle, half a pixel from its edge.
        let corner = |middle: f64, size: f64| down(middle + 0.5, FINE) - down(size / 2.0, FINE);
        [corner(self.place.x, width), corner(self.place.y, height), width, height]
    }
}

/// The template at `place`, and so many pixels of the grid around it.
fn lattice(shape: &Shape, place: Place, around: i64) -> Lattice {
    let (columns, rows) = (shape.columns + 2 * around, shape.rows + 2 * around);
    Lattice { x: place.x, y: place.y, step: shape.step_at(place.scale), columns, rows }
}

/// An offset and those up to `reach` from it, row by row.
fn around(x: i64, y: i64, reach: i64) -> impl Iterator<Item = (i64, i64)> {
    (y - reach..=y + reach).flat_map(move |y| (x - reach..=x + reach).map(move |x| (x, y)))
}

/// Each edge rounded; at least one pixel is left.
fn whole_box([x, y, width, height]: [f64; 4]) -> [i64; 4] {
    let edge = |at: f64| whole(nearest(at, 1.0));
    let side = |from: f64, size: f64| (edge(from + size) - edge(from)).max(1);
    [edge(x), edge(y), side(x, width), side(y, height)]
}

/// The mean in whole gray levels, and the sum of all absolute deviations from it.
fn mean_and_deviation(patch: &Patch) -> (f64, f64) {
    let count = patch.columns * patch.rows;
    let mean = nearest(patch.pixels.iter().sum::<f64>() / real(count), 1.0);
    (mean, patch.pixels.iter().map(|pixel| (pixel - mean).abs()).sum())
}

/// alpha: a part of the mean absolute deviation, rounded down, within bounds.
fn by_contrast(numbers: &Numbers, patch: &Patch) -> f64 {
    let (_, deviation) = mean_and_deviation(patch);
    let (part, of) = numbers.contrast;
    let alpha = (part * deviation / (of * real(patch.columns * patch.rows))).floor();
    alpha.clamp(numbers.alpha_bounds.0, numbers.alpha_bounds.1)
}

/// `template` with the brightness and the contrast of `seen`.
fn in_light_of(numbers: &Numbers, template: &Patch, seen: &Patch) -> Patch {
    let (was, is) = (mean_and_deviation(template), mean_and_deviation(seen));
    // Of a template without contrast nothing but its mean is left, whatever the gain.
    let gain = down(is.1 / was.1.max(1.0), FINE).clamp(1.0 / numbers.most_gain, numbers.most_gain);
    let pixel = |pixel: &f64| (is.0 + ((pixel - was.0) * gain).floor()).clamp(0.0, 255.0);
    Patch { pixels: template.pixels.iter().map(pixel).collect(), ..*template }
}

/// Moves a running mean one part in `rate` of the way to `patch`.
fn towards(mean: &mut Patch, patch: &Patch, rate: f64) {
    for (mean, new) in mean.pixels.iter_mut().zip(&patch.pixels) {
        *mean += nearest((new - *mean) / rate, FINE);
    }
}

fn in_gray_levels(mean: &Patch) -> Patch {
    Patch { pixels: mean.pixels.iter().map(|&pixel| nearest(pixel, 1.0)).collect(), ..*mean }
}
