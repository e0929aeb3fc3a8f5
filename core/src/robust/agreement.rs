//! Agreement: is what is seen the target? The early template, in the light of what is seen, is compared part by part.
//!
//! As a whole even a plain patch, or half of what hides the target, agrees with a template by more than one half. So the
//! template is cut into 16 parts, and the fourth least of their ratios is what counts: three may be hidden or have turned
//! away, but not four.

use super::{light, threshold};
use crate::image::{Image, Rect};
use crate::similarity::Scorer;
use heapless::Vec;

/// Parts along a side.
const ACROSS: u16 = 4;
/// The place of the ratio that counts, from the least.
const RANK: usize = 4;

/// What is compared with what.
pub(super) struct Scene<'a> {
    pub(super) view: Image<'a>,
    pub(super) early: &'a [u8],
    /// The template's shape.
    pub(super) columns: u16,
    pub(super) rows: u16,
}

/// The best place, and how well the early template agrees there, in units of 1/65535.
pub(super) struct Agreement {
    pub(super) ratio: u16,
    pub(super) x: i32,
    pub(super) y: i32,
}

/// The best agreement at (`x`, `y`) and up to `reach` pixels around it, each in its own light; of equals the upper and then the
/// left one. alpha is the mean absolute deviation of what is seen. `lit` is scratch.
#[inline(never)] // one copy in flash
pub(super) fn best<const PIXELS: usize>(
    scene: &Scene<'_>,
    (x, y): (i32, i32),
    reach: i32,
    lit: &mut Vec<u8, PIXELS>,
    scorer: impl Fn(u16) -> Scorer,
) -> Agreement {
    let Scene { view, early, columns, rows } = *scene;
    let was = threshold::Contrast::of(early.iter().copied());
    let mut best = Agreement { ratio: 0, x, y };
    for (dx, dy) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy))) {
        let Some(seen) = view.crop(Rect::new(x + dx, y + dy, columns, rows)) else { continue };
        let scorer = scorer(threshold::within_deviation(light::of(early, was, seen, lit)));
        let Ok(lit) = Image::new(lit, columns, rows) else { continue };
        let ratio = fourth_least(seen, lit, &scorer);
        if ratio > best.ratio {
            best = Agreement { ratio, x: x + dx, y: y + dy };
        }
    }
    best
}

/// Of the ratios of all parts.
fn fourth_least(seen: Image<'_>, lit: Image<'_>, scorer: &Scorer) -> u16 {
    let mut least = [u16::MAX; RANK];
    for (row, column) in (0..ACROSS).flat_map(|row| (0..ACROSS).map(move |column| (row, column))) {
        let cut = |side: u16, number: u16| number * side / ACROSS;
        let (left, top) = (cut(seen.width(), column), cut(seen.height(), row));
        let (right, bottom) = (cut(seen.width(), column + 1), cut(seen.height(), row + 1));
        let part = Rect::new(left.into(), top.into(), right - left, bottom - top);
        let (Some(seen), Some(lit)) = (seen.crop(part), lit.crop(part)) else { continue };
        let mut ratio = u16::try_from(scorer.score(seen, lit) / part.area().max(1)).unwrap_or(u16::MAX);
        for least in &mut least {
            if ratio < *least {
                core::mem::swap(&mut ratio, least);
            }
        }
    }
    let [.., fourth] = least;
    fourth
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::similarity::{Backend, Table};

    /// 16x16 pixels; the first so many of the 16 parts are not those of the template.
    fn agreement(hidden: usize) -> u16 {
        let pixel = |at: usize| u8::try_from(at * 37 % 200).unwrap();
        let early: std::vec::Vec<u8> = (0..256).map(pixel).collect();
        let part = |at: usize| at / 64 * 4 + at % 16 / 4;
        let seen: std::vec::Vec<u8> =
            (0..256).map(|at| if part(at) < hidden { 199 - pixel(at) } else { pixel(at) }).collect();
        let scene = Scene { view: Image::new(&seen, 16, 16).unwrap(), early: &early, columns: 16, rows: 16 };
        let scorer = |alpha| Scorer::new(Backend::Scalar, &Table::PAPER, alpha);
        best(&scene, (0, 0), 1, &mut Vec::<u8, 256>::new(), scorer).ratio
    }

    #[test]
    fn three_parts_may_be_hidden_but_not_four() {
        assert_eq!(agreement(0), u16::MAX);
        assert!(agreement(3) > 60_000, "{}", agreement(3));
        assert!(agreement(4) < 40_000, "{}", agreement(4));
    }

    #[test]
    fn a_plain_patch_does_not_agree() {
        let early: std::vec::Vec<u8> = (0..=255).map(|at: u8| if at.is_multiple_of(3) { 20 } else { 180 }).collect();
        let plain = [90; 256];
        let scene = Scene { view: Image::new(&plain, 16, 16).unwrap(), early: &early, columns: 16, rows: 16 };
        let scorer = |alpha| Scorer::new(Backend::Scalar, &Table::PAPER, alpha);
        assert_eq!(best(&scene, (0, 0), 0, &mut Vec::<u8, 256>::new(), scorer).ratio, 0);
    }
}
