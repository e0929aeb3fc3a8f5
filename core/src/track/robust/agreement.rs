//! Agreement: is what is seen the target? The early template, in the light of what is seen, is compared part by part.
//!
//! As a whole even a plain patch, or half of what hides the target, agrees with a template by more than one half. So the
//! template is cut into 16 parts, and the fourth least of their ratios is what counts: three may be hidden or have turned
//! away, but not four.

use super::MOST_PIXELS;
use super::early::Early;
use super::light::{self, Contrast};
use crate::image::{Image, Rect};
use crate::similarity::{Backend, CutTable, Scorer, Table};
use heapless::Vec;

/// Parts along a side.
const ACROSS: u16 = 4;
/// The place of the ratio that counts, from the least.
const RANK: usize = 4;

/// Places that are compared: the middle of the view and one pixel around it.
pub(super) const PLACES: u16 = 9;

/// What is compared with what.
pub(super) struct Compared<'a> {
    pub(super) view: Image<'a>,
    pub(super) early: &'a Early,
    /// The early template's own brightness and contrast.
    pub(super) was: Contrast,
    /// The template's shape; the view has one pixel more on each side.
    pub(super) columns: u16,
    pub(super) rows: u16,
}

impl Compared<'_> {
    /// The agreement at one of the places, in its own light, in units of 1/65535. alpha is the mean absolute deviation of what is
    /// seen, and the `measure` what scores by it. `lit` and `table` are scratch.
    #[inline(never)] // one copy in flash
    pub(super) fn at(
        &self,
        place: u16,
        lit: &mut Vec<u8, MOST_PIXELS>,
        table: &mut CutTable,
        measure: (Backend, &Table),
    ) -> u16 {
        let Self { view, early, was, columns, rows } = *self;
        let Some(seen) = view.crop(Rect::new((place % 3).into(), (place / 3).into(), columns, rows)) else { return 0 };
        table.set(measure.1, light::of(early.pixels(), was, seen, lit).threshold());
        Image::new(lit, columns, rows).map_or(0, |lit| fourth_least(seen, lit, &Scorer::new(measure.0, table)))
    }
}

/// Of the ratios of all parts.
fn fourth_least(seen: Image<'_>, lit: Image<'_>, scorer: &Scorer<'_>) -> u16 {
    let mut least = [u16::MAX; RANK];
    for (row, column) in (0..ACROSS).flat_map(|row| (0..ACROSS).map(move |column| (row, column))) {
        let cut = |side: u16, number: u16| number * side / ACROSS;
        let (left, top) = (cut(seen.width(), column), cut(seen.height(), row));
        let (right, bottom) = (cut(seen.width(), column + 1), cut(seen.height(), row + 1));
        let part = Rect::new(left.into(), top.into(), right - left, bottom - top);
        let (Some(seen), Some(lit)) = (seen.crop(part), lit.crop(part)) else { continue };
        let mut ratio = u16::try_from(scorer.score(seen, lit).unwrap_or(0) / part.area().max(1)).unwrap_or(u16::MAX);
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
    use std::vec::Vec as Pixels;

    /// How well a template of 16x16 pixels agrees with what is seen in its place, with pixels of one level around it.
    fn agreement(template: &[u8], seen: &[u8], around: u8) -> u16 {
        let mut early = Early::new();
        early.start(template.iter().copied());
        let mut view = std::vec![around; 18 * 18];
        for (row, seen) in view.chunks_mut(18).skip(1).zip(seen.chunks(16)) {
            row[1..17].copy_from_slice(seen);
        }
        let view = Image::new(&view, 18, 18).unwrap();
        let compared = Compared { view, early: &early, was: Contrast::of(early.pixels()), columns: 16, rows: 16 };
        let mut table = CutTable::new(&Table::PAPER, 0);
        let at = |place| compared.at(place, &mut Vec::new(), &mut table, (Backend::Scalar, &Table::PAPER));
        (0..PLACES).map(at).max().unwrap()
    }

    fn pixel(at: usize) -> u8 {
        u8::try_from(at * 37 % 200).unwrap()
    }

    /// The first so many of the 16 parts are not those of the template.
    fn with_hidden(hidden: usize) -> u16 {
        let template: Pixels<u8> = (0..256).map(pixel).collect();
        let part = |at: usize| at / 64 * 4 + at % 16 / 4;
        let seen: Pixels<u8> = (0..256).map(|at| if part(at) < hidden { 199 - pixel(at) } else { pixel(at) }).collect();
        agreement(&template, &seen, 0)
    }

    #[test]
    fn three_parts_may_be_hidden_but_not_four() {
        assert_eq!(with_hidden(0), u16::MAX);
        assert!(with_hidden(3) > 60_000, "{}", with_hidden(3));
        assert!(with_hidden(4) < 40_000, "{}", with_hidden(4));
    }

    #[test]
    fn a_plain_patch_does_not_agree() {
        let template: Pixels<u8> = (0..=255).map(|at: u8| if at.is_multiple_of(3) { 20 } else { 180 }).collect();
        // In its light the template's levels are 37 and 117, of which none is less than 8 from 90.
        assert_eq!(agreement(&template, &[90; 256], 90), 0);
    }
}
