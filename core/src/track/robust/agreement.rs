//! Agreement: is what is seen the target? The early template, in the light of what is seen, is compared part by part.
//!
//! As a whole even a plain patch, or half of what hides the target, agrees with a template by more than one half. So the
//! template is cut into 16 parts, and the fourth least of their ratios is what counts: three may be hidden or have turned
//! away, but not four.

use super::MOST_PIXELS;
use super::early::Early;
use super::exact::MARGIN;
use super::light;
use crate::image::{Image, Rect};
use crate::similarity::{Contrast, CutTable, Scorer, Table};
use heapless::Vec;

/// Parts along a side.
const ACROSS: u16 = 4;
/// The place of the ratio that counts, from the least.
const RANK: usize = 4;

/// What is compared with what.
pub(super) struct Compared<'a> {
    pub(super) view: Image<'a>,
    pub(super) early: &'a Early,
    /// The early template's own brightness and contrast.
    pub(super) was: Contrast,
    /// The template's shape; the view has `MARGIN` pixels more on each side.
    pub(super) columns: u16,
    pub(super) rows: u16,
}

impl Compared<'_> {
    /// What is seen at a place, which is told from the view's middle and at most `MARGIN` away on each axis.
    pub(super) fn seen(&self, (x, y): (i16, i16)) -> Option<Image<'_>> {
        let from = |by: i16| i32::from(MARGIN) + i32::from(by);
        self.view.crop(Rect::new(from(x), from(y), self.columns, self.rows))
    }

    /// Makes `lit`, the early template in the light of a place, and the table that it is compared by: alpha is the mean absolute deviation
    /// of what is seen. True if what is seen there can show the target at all.
    #[inline(never)] // one copy in flash
    pub(super) fn light(
        &self,
        at: (i16, i16),
        lit: &mut Vec<u8, MOST_PIXELS>,
        table: &mut CutTable,
        similarity: &Table,
    ) -> bool {
        let Some(seen) = self.seen(at) else { return false };
        self.early.copy_to(lit);
        let is = light::of(lit, self.was, seen);
        table.set(similarity, light::threshold(is));
        is.has_contrast_of(self.was) && !is.is_cut_off_beside(Contrast::NONE)
    }

    /// The score of a place, in the light that `lit` is in.
    pub(super) fn score(&self, at: (i16, i16), lit: &[u8], scorer: &Scorer<'_>) -> u32 {
        let (Some(seen), Ok(lit)) = (self.seen(at), Image::new(lit, self.columns, self.rows)) else { return 0 };
        scorer.score(seen, lit).unwrap_or(0)
    }

    /// The agreement at a place, in its own light, in units of 1/65535.
    pub(super) fn agreement(&self, at: (i16, i16), lit: &[u8], scorer: &Scorer<'_>) -> u16 {
        let (Some(seen), Ok(lit)) = (self.seen(at), Image::new(lit, self.columns, self.rows)) else { return 0 };
        fourth_least(seen, lit, scorer)
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
    use crate::similarity::Backend;
    use std::vec::Vec as Pixels;

    /// How well a template of 16x16 pixels agrees with what is seen.
    fn agreement(template: &[u8], seen: &[u8]) -> u16 {
        let mut early = Early::new();
        let template = Image::new(template, 16, 16).unwrap();
        early.start(template);
        const SIDE: usize = 16 + 2 * MARGIN as usize;
        let mut view = std::vec![0; SIDE * SIDE];
        for (row, seen) in view.chunks_mut(SIDE).skip(MARGIN.into()).zip(seen.chunks(16)) {
            row[MARGIN.into()..][..16].copy_from_slice(seen);
        }
        let view = Image::new(&view, 16 + 2 * MARGIN, 16 + 2 * MARGIN).unwrap();
        let compared = Compared { view, early: &early, was: Contrast::of(template), columns: 16, rows: 16 };
        let (mut lit, mut table) = (Vec::new(), CutTable::EMPTY);
        compared.light((0, 0), &mut lit, &mut table, &Table::PAPER);
        compared.agreement((0, 0), &lit, &Scorer::new(Backend::Scalar, &table))
    }

    fn pixel(at: usize) -> u8 {
        u8::try_from(at * 37 % 200).unwrap()
    }

    /// The first so many of the 16 parts are not those of the template.
    fn with_hidden(hidden: usize) -> u16 {
        let template: Pixels<u8> = (0..256).map(pixel).collect();
        let part = |at: usize| at / 64 * 4 + at % 16 / 4;
        let seen: Pixels<u8> = (0..256).map(|at| if part(at) < hidden { 199 - pixel(at) } else { pixel(at) }).collect();
        agreement(&template, &seen)
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
        assert_eq!(agreement(&template, &[90; 256]), 0);
    }
}
