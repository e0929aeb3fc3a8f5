//! Where exactly: the last patch and its running mean, compared pixel by pixel around the place that the filter says.

use super::grid::PIXEL;
use super::peak;
use crate::image::{Image, Rect};
use crate::similarity::Scorer;

/// So many pixels of the grid to each side: one cell.
pub(super) const AROUND: u16 = 4;
/// Offsets on an axis.
const SPAN: usize = 2 * AROUND as usize + 1;

/// Where in `view` the templates match best, from its middle, in units of 1/4096 pixel of the grid. `first` is the first offset
/// from the view's left and top.
pub(super) fn best(view: Image<'_>, first: u16, templates: [(Image<'_>, u32); 3], scorer: &Scorer) -> (i64, i64) {
    let [(last, _), ..] = templates;
    let mut scores = [[0u32; SPAN]; SPAN];
    let (mut most, mut at) = (0, (usize::from(AROUND), usize::from(AROUND)));
    for (y, row) in scores.iter_mut().enumerate() {
        for (x, score) in row.iter_mut().enumerate() {
            let corner = |at: usize| i32::from(first) + i32::try_from(at).unwrap_or(0);
            let rect = Rect::new(corner(x), corner(y), last.width(), last.height());
            let Some(patch) = view.crop(rect) else { continue };
            // Two scores of at most 1600 pixels.
            *score = templates.iter().filter(|(_, weight)| *weight > 0).map(|&(template, weight)| weight * scorer.score(patch, template)).sum();
            if *score > most {
                (most, at) = (*score, (x, y));
            }
        }
    }
    let score = |x: usize, y: usize| scores.get(y).and_then(|row| row.get(x)).copied();
    let (x, y) = at;
    let part = |before: Option<u32>, after: Option<u32>| match (before, after) {
        (Some(before), Some(after)) => peak::top(before, most, after),
        _ => 0,
    };
    let right = part(x.checked_sub(1).and_then(|x| score(x, y)), score(x + 1, y));
    let down = part(y.checked_sub(1).and_then(|y| score(x, y)), score(x, y + 1));
    let from_middle = |at: usize| (i64::try_from(at).unwrap_or(0) - i64::from(AROUND)) * PIXEL;
    (from_middle(x) + right, from_middle(y) + down)
}
