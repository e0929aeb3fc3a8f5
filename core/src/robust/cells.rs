//! Cells: parts of the template, each matched by itself around the peak. Where they have moved apart the target has grown.

use super::peak;
use crate::image::{Image, Rect};
use crate::similarity::{Scorer, Table};
use heapless::Vec;

/// Side of a cell, and from one to the next.
const SIDE: u16 = 8;
const STRIDE: u16 = 6;
/// How far a cell is looked for.
const REACH: i32 = 3;
/// Offsets of a cell on an axis, and all.
const ACROSS: usize = 2 * REACH as usize + 1;
const OFFSETS: usize = ACROSS * ACROSS;
/// A template of 1024 pixels has at most 25 of them.
const MOST_CELLS: usize = 32;
const MOST_PAIRS: usize = MOST_CELLS * (MOST_CELLS - 1) / 2;
/// Cells, and pairs of them, without which nothing is said.
const LEAST_CELLS: usize = 5;
const LEAST_PAIRS: usize = 3;
/// Only pairs of cells farther apart than the root of this say how much: 7.2 pixels.
const FAR: i32 = 52;
/// Of both templates' scores together: the last patch counts twice.
const FULL: u64 = 3 * SIDE as u64 * SIDE as u64 * Table::ONE as u64;

/// What is compared.
pub(super) struct Scene<'a> {
    pub(super) window: Image<'a>,
    pub(super) last: Image<'a>,
    pub(super) slow: Image<'a>,
    /// The template's place in the window.
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) scorer: &'a Scorer,
}

/// Where a cell is in the template, and how far it was found from there in units of 1/4096.
struct Moved {
    x: i32,
    y: i32,
    dx: i64,
    dy: i64,
}

/// How many times as far apart as before the cells are, squared, in units of 1/65536: the median of all pairs. `None` if too
/// few are seen clearly.
#[inline(never)] // one copy in flash
pub(super) fn growth_squared(scene: &Scene<'_>) -> Option<u32> {
    let (columns, rows) = cells(scene.last);
    let margin = |side: u16, cells: u16| side.saturating_sub(SIDE + cells.saturating_sub(1) * STRIDE) / 2;
    let (left, top) = (margin(scene.last.width(), columns), margin(scene.last.height(), rows));
    let mut moved = Vec::<Moved, MOST_CELLS>::new();
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let (x, y) = (i32::from(left + column * STRIDE), i32::from(top + row * STRIDE));
        if let Some((dx, dy)) = find(scene, x, y) {
            // Cannot fail: there are no more cells.
            let _ = moved.push(Moved { x, y, dx, dy });
        }
    }
    if moved.len() < LEAST_CELLS {
        return None;
    }
    let mut growths = Vec::<u32, MOST_PAIRS>::new();
    for (number, a) in moved.iter().enumerate() {
        for b in moved.iter().take(number) {
            if let Some(growth) = pair(a, b) {
                let _ = growths.push(growth);
            }
        }
    }
    if growths.len() < LEAST_PAIRS { None } else { Some(median(&growths)) }
}

/// How many comparisons of bytes [`growth_squared`] makes, at most.
pub(super) fn comparisons(template: Image<'_>) -> u32 {
    let (columns, rows) = cells(template);
    let offsets = u32::try_from(OFFSETS).unwrap_or(0);
    u32::from(columns * rows) * offsets * u32::from(SIDE * SIDE) * 2
}

/// Columns and rows of cells in a template.
fn cells(template: Image<'_>) -> (u16, u16) {
    let along = |side: u16| if side < SIDE { 0 } else { (side - SIDE) / STRIDE + 1 };
    (along(template.width()), along(template.height()))
}

/// Where the cell at (`x`, `y`) of the template is found; `None` if it is not seen clearly: on the edge of its reach, or
/// below 3/10, or less than 1/50 above the mean.
fn find(scene: &Scene<'_>, x: i32, y: i32) -> Option<(i64, i64)> {
    let cell = Rect::new(x, y, SIDE, SIDE);
    let (last, slow) = (scene.last.crop(cell)?, scene.slow.crop(cell)?);
    let mut scores = [[0u32; ACROSS]; ACROSS];
    let (mut sum, mut best, mut closeness, mut at) = (0u64, 0, i32::MAX, (0, 0));
    for (dy, row) in (-REACH..).zip(&mut scores) {
        for (dx, score) in (-REACH..).zip(row) {
            let place = Rect { x: scene.x + x + dx, y: scene.y + y + dy, ..cell };
            if let Some(patch) = scene.window.crop(place) {
                *score = 2 * scene.scorer.score(patch, last) + scene.scorer.score(patch, slow);
            }
            sum += u64::from(*score);
            let distance = dx * dx + dy * dy;
            if *score > best || (*score == best && distance < closeness) {
                (best, closeness, at) = (*score, distance, (dx, dy));
            }
        }
    }
    let count = OFFSETS as u64;
    let clear = 10 * u64::from(best) >= 3 * FULL && 50 * count * u64::from(best) >= 50 * sum + count * FULL;
    if !clear || at.0.abs() == REACH || at.1.abs() == REACH {
        return None;
    }
    let score = |dx: i32, dy: i32| {
        let index = |d: i32| usize::try_from(d + REACH).unwrap_or(0);
        scores.get(index(dy)).and_then(|row| row.get(index(dx))).copied().unwrap_or(0)
    };
    let (dx, dy) = at;
    let across = peak::top(score(dx - 1, dy), best, score(dx + 1, dy));
    let down = peak::top(score(dx, dy - 1), best, score(dx, dy + 1));
    Some(((i64::from(dx) << 12) + across, (i64::from(dy) << 12) + down))
}

/// How many times as far apart as before two cells are, squared, in units of 1/65536; `None` if they were too close.
fn pair(a: &Moved, b: &Moved) -> Option<u32> {
    let (x, y) = (a.x - b.x, a.y - b.y);
    let before = x * x + y * y;
    if before <= FAR {
        return None;
    }
    let (dx, dy) = ((i64::from(x) << 12) + a.dx - b.dx, (i64::from(y) << 12) + a.dy - b.dy);
    // At most (384 * 4096)^2 twice, below 2^42; in units of 2^-16 below 2^34, over at least 53.
    let after = (dx * dx + dy * dy) >> 8;
    u32::try_from(after / i64::from(before)).ok()
}

/// The least value that more than half of all are not above; without sorting, and without a path to a panic.
fn median(values: &[u32]) -> u32 {
    let (mut low, mut high) = (0, u32::MAX);
    while low < high {
        let middle = low + (high - low) / 2;
        if 2 * values.iter().filter(|&&value| value <= middle).count() > values.len() {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_median_is_that_of_sorted_values(mut values in prop::collection::vec(any::<u32>(), 1..50)) {
            let found = median(&values);
            values.sort_unstable();
            prop_assert_eq!(found, values[values.len() / 2]);
        }
    }

    #[test]
    fn cells_that_move_apart_say_how_much() {
        let at = |x, y, dx, dy| Moved { x, y, dx, dy };
        assert_eq!(pair(&at(0, 0, 0, 0), &at(10, 0, 0, 0)), Some(65536));
        assert_eq!(pair(&at(0, 0, -2048, 0), &at(10, 0, 2048, 0)), Some(65536 * 121 / 100));
        assert_eq!(pair(&at(0, 0, 0, 0), &at(6, 4, 0, 0)), None, "6 and 4 are 7.2 apart");
    }
}
