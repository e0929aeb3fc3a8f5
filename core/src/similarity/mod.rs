//! The measure of SMR: the similarity of a patch to the template.
//!
//! A [`Table`] specifies the similarity of two pixels, `kernels/plain/scores.rs` the score of two pictures. A
//! [`Backend`] computes the same score faster, also if the box reaches beyond the frame into the padding.

mod contrast;
mod table;

pub use crate::kernels::Backend;
pub(crate) use crate::kernels::{CutTable, Scorer};
pub(crate) use contrast::{Contrast, LARGEST_CONTRAST_RATIO};
pub(crate) use table::PAPER;
pub use table::{Table, TableError};

use crate::image::{Frame, Image, Rect};

/// The score of `template` with its top left corner at (`x`, `y`) of the frame. Pixels outside the frame are zero.
/// `None` if a pixel of the frame is needed that is not in memory, or if the template has more than
/// [`Table::MAX_PIXELS`] pixels. Cost: one comparison for each pixel of the template.
#[cfg(any(test, feature = "unstable"))]
pub(crate) fn score_at(frame: &Frame<'_>, template: Image<'_>, x: i32, y: i32, scorer: &Scorer<'_>) -> Option<u32> {
    let target = Rect::new(x, y, template.width(), template.height());
    let needed = target.intersection(frame.bounds());
    let too_large = usize::try_from(target.area()).map_or(true, |area| area > Table::MAX_PIXELS);
    if too_large || (!needed.is_empty() && frame.patch(needed).is_none()) {
        return None;
    }
    score_at_least(frame, template, x, y, scorer, 0)
}

/// The score of `template` at (`x`, `y`); `None` if it is below `floor`, or if a needed pixel is not in memory.
pub(crate) fn score_at_least(
    frame: &Frame<'_>,
    template: Image<'_>,
    x: i32,
    y: i32,
    scorer: &Scorer<'_>,
    floor: u32,
) -> Option<u32> {
    let target = Rect::new(x, y, template.width(), template.height());
    match frame.patch(target) {
        Some(patch) => scorer.score_at_least(patch, template, floor),
        None => score_at_border(frame, template, target, scorer, floor),
    }
}

#[cold]
#[inline(never)] // keeps it out of the usual case, which is inlined
fn score_at_border(
    frame: &Frame<'_>,
    template: Image<'_>,
    target: Rect,
    scorer: &Scorer<'_>,
    floor: u32,
) -> Option<u32> {
    let seen = target.intersection(frame.bounds());
    let within = Rect { x: seen.x.saturating_sub(target.x), y: seen.y.saturating_sub(target.y), ..seen };
    let outside = scorer.score_on_padding(template, if seen.is_empty() { seen } else { within });
    let inside = if seen.is_empty() {
        0
    } else {
        scorer.score_at_least(frame.patch(seen)?, template.crop(within)?, floor.saturating_sub(outside))?
    };
    Some(inside + outside).filter(|&score| score >= floor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_template_whose_score_could_overflow_has_none() {
        let pixels = std::vec![7; 257 * 256];
        let image = |width, height| Image::new(&pixels, width, height).unwrap();
        for backend in Backend::available() {
            let table = CutTable::new(&Table::PAPER, 13);
            let scorer = Scorer::new(backend, &table);
            let score = |template| score_at(&image(257, 256).into(), template, 0, 0, &scorer);
            assert_eq!(score(image(257, 256)), None);
            assert_eq!(score(image(256, 256)), Some(65536 * 65535));
        }
    }
}
