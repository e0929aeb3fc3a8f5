//! The measure: how similar a patch is to the template.
//!
//! [`table`](Table) is the specification of a pixel's similarity, [`scalar`] that of a score. Here the two meet the
//! frame: [`score_at`] scores any offset, also one whose box reaches into the padding.

pub mod scalar;
mod table;

pub use table::{Table, TableError};

use crate::image::{Frame, Image, Rect};

/// The score of `template` with its top left corner at (`x`, `y`) of the frame; what lies outside the frame is zeroes.
///
/// `None` if a pixel that is needed lies within the frame, but not in the part of it that is in memory.
/// Cost: one comparison for each pixel of the template.
///
/// ```
/// use smr_core::{Frame, Image, similarity::{Table, score_at}};
/// let frame = Frame::whole(Image::new(&[5, 6, 7, 8], 2, 2)?);
/// let template = Image::new(&[8, 0, 0, 0], 2, 2)?;
/// // At (1, 1) only the first pixel is in the frame; the others are compared with the padding.
/// assert_eq!(score_at(&frame, template, 1, 1, &Table::PAPER, 13), Some(4 * 65535));
/// # Ok::<(), smr_core::ImageError>(())
/// ```
#[must_use]
pub fn score_at(frame: &Frame<'_>, template: Image<'_>, x: i32, y: i32, table: &Table, threshold: u16) -> Option<u32> {
    let target = Rect::new(x, y, template.width(), template.height());
    if let Some(patch) = frame.patch(target) {
        return Some(scalar::score(patch, template, table, threshold));
    }
    let seen = target.intersection(frame.bounds());
    if seen == target {
        return None;
    }
    let within = Rect { x: seen.x.saturating_sub(x), y: seen.y.saturating_sub(y), ..seen };
    if seen.is_empty() {
        return Some(scalar::score_on_padding(template, seen, table, threshold));
    }
    let inside = scalar::score(frame.patch(seen)?, template.crop(within)?, table, threshold);
    Some(inside + scalar::score_on_padding(template, within, table, threshold))
}
