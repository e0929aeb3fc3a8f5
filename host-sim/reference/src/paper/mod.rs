//! The paper tracker in f64, a reference for `smr-core` that is meant to be checked against the paper's steps by eye.
//!
//! It is slow, shares no code or constant with `smr-core`, and pads the frame with real zeroes. Pixels stay bytes,
//! because their differences are exact; only exp divides them by the scale. Every score is summed twice, in units of
//! 1/65535: the *exact* sum adds each pixel's similarity as an f64, the *rounded* sum adds it rounded to whole units,
//! as smr-core does. Decisions follow the rounded sums, so that both trackers pass the same states in a recording.

mod numbers;

pub use numbers::{GateNumbers, Numbers};
use rayon::prelude::*;

/// A similarity of 1.0, in the units of a score (1/65535).
pub(super) const UNITS: f64 = 65535.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    Tracking,
    Leaving,
    Lost,
}

/// Score of a candidate position, in units of 1/65535: `rounded` adds rounded similarities, `exact` unrounded ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sums {
    pub rounded: f64,
    pub exact: f64,
}

/// Scores of all candidate positions in the search window, row by row; the first position is (`left`, `top`).
pub struct Scores {
    pub left: i64,
    pub top: i64,
    pub columns: i64,
    pub rows: i64,
    pub sums: Vec<Sums>,
}

impl Scores {
    pub fn iter(&self) -> impl Iterator<Item = ((i64, i64), Sums)> {
        let positions =
            (self.top..self.top + self.rows).flat_map(|y| (self.left..self.left + self.columns).map(move |x| (x, y)));
        positions.zip(self.sums.iter().copied())
    }
}

pub struct Step {
    pub scores: Scores,
    /// Position and score of the best candidate, by the rounded scores and by the exact ones.
    pub peak: ((i64, i64), f64),
    pub exact_peak: ((i64, i64), f64),
    /// Largest rounded sum outside the peak's neighbourhood; 0 if no candidate lies there.
    pub runner_up: f64,
    /// True if the decision depends on the runner-up, or the settings require a runner-up in every frame.
    pub runner_up_asked: bool,
    pub alpha: f64,
    pub decision: Decision,
    /// Left and top edge of the target after the frame, in pixels.
    pub position: (i64, i64),
}

/// Gray image, a frame or a patch: intensities 0 to 255, row by row.
struct Picture {
    width: i64,
    height: i64,
    pixels: Vec<f64>,
}

impl Picture {
    fn new(pixels: &[u8], width: i64, height: i64) -> Self {
        Self { width, height, pixels: pixels.iter().map(|&pixel| f64::from(pixel)).collect() }
    }

    fn padded(&self, padding: i64) -> Self {
        let (width, height) = (self.width + 2 * padding, self.height + 2 * padding);
        let mut pixels = vec![0.0; index(width * height)];
        for y in 0..self.height {
            let to = index((y + padding) * width + padding);
            pixels[to..to + index(self.width)].copy_from_slice(self.row(0, y, self.width));
        }
        Self { width, height, pixels }
    }

    fn row(&self, x: i64, y: i64, count: i64) -> &[f64] {
        let from = index(y * self.width + x);
        &self.pixels[from..from + index(count)]
    }

    fn cut(&self, x: i64, y: i64, width: i64, height: i64) -> Self {
        let pixels = (y..y + height).flat_map(|row| self.row(x, row, width).iter().copied()).collect();
        Self { width, height, pixels }
    }

    fn area(&self) -> f64 {
        (self.width * self.height) as f64
    }

    /// Contrast: the sum of absolute deviations from the mean, which is rounded to a whole gray level.
    fn deviation(&self) -> f64 {
        let mean = (self.pixels.iter().sum::<f64>() / self.area()).round();
        self.pixels.iter().map(|pixel| (pixel - mean).abs()).sum()
    }

    fn cut_off(&self) -> f64 {
        self.pixels.iter().map(|&pixel| if pixel <= 0.0 || pixel >= 255.0 { 1.0 } else { 0.0 }).sum()
    }
}

pub struct Reference {
    numbers: Numbers,
    /// Similarity p in units of 1/65535, indexed by the absolute difference of two bytes, 0 to 255.
    p: Vec<Sums>,
    frame_size: (i64, i64),
    template: Picture,
    position: (i64, i64),
    alpha: f64,
    decision: Decision,
    been_at_border: bool, // `edge`
    lost_for: i64,
}

impl Reference {
    /// Locks on the box `target` (left, top, width, height), which must lie inside the frame.
    pub fn lock(numbers: Numbers, frame: &[u8], frame_size: (i64, i64), target: (i64, i64, i64, i64)) -> Self {
        let (x, y, width, height) = target;
        let p = (0..=255).map(|d| similarity(f64::from(d), numbers.scale)).collect();
        let alpha = numbers.first_alpha;
        let template = Picture::new(frame, frame_size.0, frame_size.1).cut(x, y, width, height);
        let (decision, position) = (Decision::Tracking, (x, y));
        Self { numbers, p, frame_size, template, position, alpha, decision, been_at_border: false, lost_for: 0 }
    }

    pub fn template(&self) -> &[f64] {
        &self.template.pixels
    }

    pub fn update(&mut self, frame: &[u8]) -> Step {
        let frame = Picture::new(frame, self.frame_size.0, self.frame_size.1);
        let scores = self.score_window(&frame.padded(self.numbers.padding));
        let peak = self.arg_max(&scores, |sums| sums.rounded);
        let exact_peak = self.arg_max(&scores, |sums| sums.exact);
        let runner_up = self.best_outside_neighbourhood(&scores, peak.0);
        let alpha = self.alpha;

        let over_border = !self.keeps((0, 0, 0, 0), peak.0);
        let needed = self.needed_ratio(over_border);
        let as_large = needed.0 == needed.1 && peak.1 > 0.0 && peak.1 == runner_up;
        let runner_up_asked = needed.0 > needed.1 || as_large || self.numbers.runner_up_always;
        let was_lost = self.decision == Decision::Lost;
        if !was_lost && over_border {
            self.been_at_border = true;
        }
        if self.is_accepted(peak.1, runner_up, needed) && (over_border || self.is_shown(&frame, peak.0)) {
            self.position = peak.0;
            self.lost_for = 0;
            if was_lost {
                self.been_at_border = false;
            }
            self.decision = if over_border { Decision::Leaving } else { Decision::Tracking };
            if self.keeps(self.numbers.zone, peak.0) {
                self.replace_template(&frame);
            }
        } else {
            self.decision = Decision::Lost;
            self.lost_for += 1;
        }
        let (decision, position) = (self.decision, self.position);
        Step { scores, peak, exact_peak, runner_up, runner_up_asked, alpha, decision, position }
    }

    /// Step 1: scores every position in the search window at which the box lies inside the padded frame.
    fn score_window(&self, padded: &Picture) -> Scores {
        let Numbers { padding, window, window_limit, growth, .. } = self.numbers;
        let (mut reach_x, mut reach_y) = (window.0 + growth * self.lost_for, window.1 + growth * self.lost_for);
        if let Some(limit) = window_limit {
            (reach_x, reach_y) = (reach_x.min(limit.0), reach_y.min(limit.1));
        }
        let left = (self.position.0 - reach_x).max(-padding);
        let top = (self.position.1 - reach_y).max(-padding);
        let right = (self.position.0 + reach_x).min(self.frame_size.0 + padding - self.template.width);
        let bottom = (self.position.1 + reach_y).min(self.frame_size.1 + padding - self.template.height);
        let (columns, rows) = (right - left + 1, bottom - top + 1);
        let sums = (top..=bottom)
            .into_par_iter()
            .flat_map_iter(|y| (left..=right).map(move |x| self.score(padded, x + padding, y + padding)))
            .collect();
        Scores { left, top, columns, rows, sums }
    }

    /// Steps 2 and 3: sums the similarity p of the pixels whose difference to the template is below alpha.
    fn score(&self, padded: &Picture, x: i64, y: i64) -> Sums {
        let mut sums = Sums { rounded: 0.0, exact: 0.0 };
        for row in 0..self.template.height {
            let f = padded.row(x, y + row, self.template.width);
            let g = self.template.row(0, row, self.template.width);
            for (f, g) in f.iter().zip(g) {
                let difference = (f - g).abs();
                if difference < self.alpha {
                    let p = self.p[whole(difference)];
                    sums.rounded += p.rounded;
                    sums.exact += p.exact;
                }
            }
        }
        sums
    }

    /// Step 4: finds the largest sum. Ties go to the position nearest to the previous one, then upper, then left.
    fn arg_max(&self, scores: &Scores, sum: impl Fn(Sums) -> f64) -> ((i64, i64), f64) {
        let distance = |(x, y): (i64, i64)| (x - self.position.0).pow(2) + (y - self.position.1).pow(2);
        let mut best: Option<((i64, i64), f64)> = None;
        // Scores come row by row, so of positions with equal sum and distance the first is the upper or left one.
        for (at, sums) in scores.iter() {
            let better = best.is_none_or(|(best_at, best_sum)| {
                sum(sums) > best_sum || (sum(sums) == best_sum && distance(at) < distance(best_at))
            });
            if better {
                best = Some((at, sum(sums)));
            }
        }
        best.expect("a window holds the last position at least")
    }

    fn best_outside_neighbourhood(&self, scores: &Scores, (peak_x, peak_y): (i64, i64)) -> f64 {
        let near = self.numbers.neighbourhood;
        let outside = scores.iter().filter(|((x, y), _)| (x - peak_x).abs() > near || (y - peak_y).abs() > near);
        outside.map(|(_, sums)| sums.rounded).fold(0.0, f64::max)
    }

    /// Steps 5 and 6: the winning patch becomes the template; alpha = k * max |old - new|, at least `least_alpha`. If
    /// no pixel has changed, alpha stays.
    fn replace_template(&mut self, frame: &Picture) {
        let next = frame.cut(self.position.0, self.position.1, self.template.width, self.template.height);
        let changes = self.template.pixels.iter().zip(&next.pixels).map(|(old, new)| (old - new).abs());
        let largest = changes.fold(0.0, f64::max);
        if largest > 0.0 {
            self.alpha = (largest * self.numbers.k.0 / self.numbers.k.1).max(self.numbers.least_alpha);
        }
        self.template = next;
    }

    /// Accepts a peak above `needed` * runner-up or above runner-up + lead, if the peak's mean similarity per pixel
    /// reaches `least_ratio`.
    fn is_accepted(&self, peak: f64, runner_up: f64, needed: (f64, f64)) -> bool {
        let gate = &self.numbers.gate;
        let stands_out = peak * needed.1 > runner_up * needed.0 || peak > runner_up + gate.lead * UNITS;
        stands_out && (peak / self.template.area()).floor() >= gate.least_ratio
    }

    /// True if the patch at (`x`, `y`) keeps to `least_contrast` and `most_cut_off`, or if `least_ratio` is 0.
    fn is_shown(&self, frame: &Picture, (x, y): (i64, i64)) -> bool {
        let gate = &self.numbers.gate;
        let seen = frame.cut(x, y, self.template.width, self.template.height);
        let has_contrast = seen.deviation() >= self.template.deviation() * gate.least_contrast;
        let more_cut_off = seen.cut_off() - self.template.cut_off();
        gate.least_ratio == 0.0 || has_contrast && more_cut_off <= seen.area() * gate.most_cut_off
    }

    fn needed_ratio(&self, over_border: bool) -> (f64, f64) {
        let gate = &self.numbers.gate;
        if self.decision == Decision::Lost {
            gate.lost
        } else if over_border {
            gate.border
        } else if self.been_at_border {
            gate.been_at_border
        } else {
            gate.tracking
        }
    }

    fn keeps(&self, (left, top, right, bottom): (i64, i64, i64, i64), (x, y): (i64, i64)) -> bool {
        x >= left
            && y >= top
            && x + self.template.width <= self.frame_size.0 - right
            && y + self.template.height <= self.frame_size.1 - bottom
    }
}

/// Step 3: similarity p of a pixel, in units of 1/65535.
pub(super) fn similarity(difference: f64, scale: f64) -> Sums {
    let exact = UNITS * (-difference / scale).exp();
    Sums { rounded: exact.round(), exact }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // 0 to 255, and whole
fn whole(difference: f64) -> usize {
    difference as usize
}

pub(super) fn index(value: i64) -> usize {
    usize::try_from(value).expect("places and numbers of things are not negative")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_counts_only_below_alpha_and_adds_exp_of_its_difference() {
        let frame: Vec<u8> = vec![100, 112, 113, 87, 88, 100];
        let reference = Reference::lock(Numbers::paper(), &[100; 6], (6, 1), (0, 0, 6, 1));
        let sums = reference.score(&Picture::new(&frame, 6, 1), 0, 0);
        let p12 = 65535.0 * (-12.0_f64 / 255.0).exp();
        assert!((sums.exact - (2.0 * 65535.0 + 2.0 * p12)).abs() < 1e-6);
        assert_eq!(sums.rounded, 2.0 * 65535.0 + 2.0 * p12.round());
    }

    #[test]
    fn alpha_is_a_quarter_of_the_largest_change_and_stays_where_nothing_changed() {
        // No margins, because the paper's margins leave no room for a template update in a 3x3 frame.
        let everywhere = Numbers { zone: (0, 0, 0, 0), ..Numbers::paper() };
        let mut reference = Reference::lock(everywhere, &[100; 9], (3, 3), (0, 0, 3, 3));
        reference.update(&[100; 9]);
        assert_eq!(reference.alpha, 12.75);
        let mut changed = [100; 9];
        changed[4] = 130;
        let step = reference.update(&changed);
        assert_eq!((step.alpha, reference.alpha), (12.75, 7.5));
    }
}
