//! Cells: parts of the template, each looked for around the peak. How far they have moved apart says how it has grown.

use super::CellNumbers;
use super::grid::Patch;
use super::rounding::{SCALE, down, index, real};
use super::scores::{best, top};

/// A cell's middle in the template, and where it was found to be.
struct Seen {
    before: (f64, f64),
    after: (f64, f64),
}

/// How many times as far apart as before the cells are, squared: the median of all pairs. `None` if too few are seen.
///
/// `score` is that of a cell, x and y in the template, moved by dx and dy.
pub fn growth_squared(
    numbers: &CellNumbers,
    template: &Patch,
    score: impl Fn((i64, i64), (i64, i64)) -> f64,
) -> Option<f64> {
    let (xs, ys) = (starts(numbers, template.columns), starts(numbers, template.rows));
    let places = ys.iter().flat_map(|&y| xs.iter().map(move |&x| (x, y)));
    let seen: Vec<Seen> = places.filter_map(|at| find(numbers, at, |moved| score(at, moved))).collect();
    let pairs = seen.iter().enumerate().flat_map(|(number, a)| seen[..number].iter().map(move |b| (a, b)));
    let mut growths: Vec<f64> = pairs.filter_map(|(a, b)| growth_of_pair(numbers, a, b)).collect();
    growths.sort_by(f64::total_cmp);
    let enough = seen.len() >= numbers.least_cells && growths.len() >= numbers.least_pairs;
    enough.then(|| growths[growths.len() / 2])
}

/// Where cells begin on an axis: as many as fit, in the middle of it.
fn starts(numbers: &CellNumbers, side: i64) -> Vec<i64> {
    if side < numbers.side {
        return Vec::new();
    }
    let count = (side - numbers.side) / numbers.stride + 1;
    let margin = (side - numbers.side - (count - 1) * numbers.stride) / 2;
    (0..count).map(|number| margin + number * numbers.stride).collect()
}

/// A cell is seen if its best score is not on the edge of its reach, is high, and stands out from the mean.
fn find(numbers: &CellNumbers, at: (i64, i64), score: impl Fn((i64, i64)) -> f64) -> Option<Seen> {
    let reach = numbers.reach;
    let offsets = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)));
    let scores: Vec<((i64, i64), f64)> = offsets.map(|moved| (moved, score(moved))).collect();
    let ((dx, dy), peak) = best(scores.iter().copied(), 0);
    let sum: f64 = scores.iter().map(|(_, score)| score).sum();
    // Multiplied out, so that all is whole and exact.
    let count = real(scores.len().try_into().ok()?);
    let full = 3.0 * real(numbers.side * numbers.side) * super::UNITS;
    let high = peak * numbers.least_score.1 >= full * numbers.least_score.0;
    let (lead, of) = numbers.lead;
    let stands_out = peak * count * of >= sum * of + full * count * lead;
    if !high || !stands_out || dx.abs() == reach || dy.abs() == reach {
        return None;
    }
    let at_offset = |x: i64, y: i64| scores[index((y + reach) * (2 * reach + 1) + x + reach)].1;
    let across = real(dx) + top(at_offset(dx - 1, dy), peak, at_offset(dx + 1, dy));
    let along = real(dy) + top(at_offset(dx, dy - 1), peak, at_offset(dx, dy + 1));
    let before = (real(at.0), real(at.1));
    Some(Seen { before, after: (before.0 + across, before.1 + along) })
}

fn growth_of_pair(numbers: &CellNumbers, a: &Seen, b: &Seen) -> Option<f64> {
    let squared = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).powi(2) + (a.1 - b.1).powi(2);
    let before = squared(a.before, b.before);
    (before > numbers.far_squared).then(|| down(squared(a.after, b.after) / before, SCALE))
}
