//! Searches a window tile by tile: excludes groups of 4x4 offsets (`exclusion.rs`), and scores the remaining offsets.

use super::exclusion::{SIDE, Tile};
use super::progress::{Place, Scene, Search, Stage, area, maxima_count, words};
use crate::image::{Image, Rect};
use crate::kernels::ALL_FOUR;
use crate::similarity::{Scorer, Table};

impl<const PIXELS: usize, const SPAN: usize> Search<PIXELS, SPAN> {
    pub(super) fn first_tile(&mut self, scene: &Scene<'_>) {
        self.place = Place::tile(0, 0);
        self.stage = if self.pruning && self.ranges.divide(&scene.window, scene.template) {
            Stage::Ranges
        } else {
            Stage::Offsets
        };
    }

    #[inline(never)]
    pub(super) fn compute_ranges(&mut self, scene: &Scene<'_>) {
        let Place { column, row, next, .. } = self.place;
        let pass = self.place.pass.into();
        if next == 0 && pass == 0 {
            self.tile = self.ranges.tile(&scene.window, column, row);
            self.ranges.begin_tile(&self.tile, area(scene));
        }
        if let Some(rest) = self.ranges.remaining_part(&self.tile) {
            let pixels = self.ranges.pixels(&scene.frame, &scene.window, &rest);
            let rows = self.ranges.rows(&self.tile, &rest, pass);
            let next = next.max(rows.start);
            let next = next + self.compute_several(scene, pixels, &rest, pass, next);
            for next in next..rows.end {
                if self.is_spent() {
                    self.place.next = next;
                    return;
                }
                let Scene { frame, window, scorer, .. } = scene;
                let ranges = self.ranges.compute_row(frame, pixels, window, (&self.tile, &rest), pass, next, scorer);
                self.spend(2 * ranges);
            }
        }
        if pass == 0 {
            self.spend(words(self.tile.groups())); // by `begin_tile`
        }
        self.place.next = 0;
        self.ranges.begin_groups();
        self.stage = Stage::Exclude;
    }

    /// Computes as many rows of ranges as the grant allows, if the backend can do several at once. Returns their count.
    fn compute_several(
        &mut self,
        scene: &Scene<'_>,
        pixels: Option<Image<'_>>,
        rest: &Tile,
        pass: usize,
        next: usize,
    ) -> usize {
        let Some(pixels) = pixels.filter(|_| Scorer::RANGES_OF_ROWS) else { return 0 };
        let a_row = 2 * self.ranges.ranges_in_row(rest);
        let most = self.granted.saturating_sub(self.work).div_ceil(a_row.max(1));
        let most = usize::try_from(most).unwrap_or(usize::MAX);
        let rows = self.ranges.compute_rows(pixels, (&self.tile, rest), pass, next, most, scene.scorer);
        self.spend(a_row * words(rows));
        rows
    }

    #[inline(never)]
    pub(super) fn exclude(&mut self, scene: &Scene<'_>) {
        let needed = self.leaders.needed().max(1);
        let (pass, groups) = (self.place.pass.into(), self.tile.groups());
        for group in self.place.next..groups {
            if !self.ranges.is_worth_bounding(group, needed, area(scene), pass) {
                continue;
            }
            if self.is_spent() {
                return;
            }
            let compared = self.ranges.bound_group(scene.template, &self.tile, pass, group, needed, scene.scorer);
            self.spend(compared + words(group - self.place.next));
            self.place.next = group + 1;
        }
        self.spend(words(groups.saturating_sub(self.place.next)));
        self.place.next = 0;
        self.place.pass += 1;
        self.stage = if usize::from(self.place.pass) < self.ranges.passes() { Stage::Ranges } else { Stage::Refine };
    }

    fn next_group(&mut self, needed: u32) -> Option<usize> {
        let group = self.ranges.next_group(&self.tile, self.place.next, needed);
        if group.is_none() {
            self.spend(words(self.tile.groups().saturating_sub(self.place.next)));
        }
        group
    }

    #[inline(never)]
    pub(super) fn refine(&mut self, scene: &Scene<'_>) {
        while let Some(group) = self.next_group(self.leaders.needed()) {
            let from = self.place.next;
            if group != from {
                (self.place.next, self.place.offset) = (group, 0);
            }
            let new = self.tile.first_unshared(group);
            // Once per row of groups: raises the floor if that costs at most 1/32 of the work since it was last raised.
            let is_first = self.place.offset == 0 && (from == 0 || new.1 != self.tile.first_unshared(from - 1).1);
            if is_first && self.since_floor.wrapping_add(self.work) / 32 >= maxima_count(scene) {
                self.raise_floor(scene);
            }
            self.spend(words(group - from));
            let first = self.tile.group(group);
            while self.place.offset < OFFSETS && self.ranges.reaches(group, self.leaders.needed()) {
                if self.is_spent() {
                    return;
                }
                self.score_in_group(scene, first, new);
                self.place.offset += 1;
            }
            (self.place.next, self.place.offset) = (group + 1, 0);
        }
        self.next_tile(scene);
    }

    /// Scores the present offset of a group, unless an earlier group or tile contains it. At the first offset of each
    /// row of four, determines which of the four can change the result.
    fn score_in_group(&mut self, scene: &Scene<'_>, group: (usize, usize), new: (usize, usize)) {
        let Place { column: first_column, row: first_row, offset, .. } = self.place;
        let new = (
            new.0.max(first_column.saturating_sub(self.tile.column)),
            new.1.max(first_row.saturating_sub(self.tile.row)),
        );
        let offset = usize::from(offset);
        let (column, row) = (group.0 + offset % SIDE, group.1 + offset / SIDE);
        let (x, y) = scene.window.position(self.tile.column + column, self.tile.row + row);
        if offset.is_multiple_of(SIDE) {
            let wanted = if row < new.1 { 0 } else { ALL_FOUR << new.0.saturating_sub(column) & ALL_FOUR };
            self.candidates = self.candidates(scene, (x, y), wanted);
        }
        if column < new.0 || row < new.1 {
            return;
        }
        if self.candidates >> (offset % SIDE) & 1 == 0 {
            self.spend(area(scene));
        } else {
            self.score(scene, x, y);
        }
    }

    /// The offsets of `wanted` (a bit mask of four, from (`x`, `y`) to the right) that can change the result: see
    /// [`Scorer::candidates`]. Leaves out the best offset so far, which is scored already.
    fn candidates(&self, scene: &Scene<'_>, (x, y): (i32, i32), mut wanted: u8) -> u8 {
        if let Some(best) = self.leaders.best()
            && best.y == y
        {
            wanted &= !1u8.checked_shl(best.x.wrapping_sub(x).cast_unsigned()).unwrap_or(0);
        }
        // Scoring one offset is faster than bounding four.
        if Scorer::BOUNDS_FOUR && wanted & wanted.wrapping_sub(1) != 0 {
            wanted = candidates(scene, (x, y), self.leaders.needed(), wanted).unwrap_or(wanted);
        }
        wanted
    }

    fn next_tile(&mut self, scene: &Scene<'_>) {
        let (columns, rows) = scene.window.size();
        let Tile { column, row, columns: wide, rows: high } = self.tile;
        self.stage = Stage::Ranges;
        if column + wide < columns {
            self.place = Place::tile(column + wide, self.place.row);
        } else if row + high < rows {
            self.place = Place::tile(0, row + high);
        } else {
            self.stage = Stage::Done;
        }
    }
}

/// Returns those offsets of `wanted` (bit i: the offset (`x` + i, `y`), i from 0 to 3) whose upper bound of the score
/// reaches `needed`; `None` if no offset can be excluded. The bound compares template pixels inside the frame at all
/// four offsets, scores those outside at all four as on padding, and counts all other pixels as fully similar.
fn candidates(scene: &Scene<'_>, (x, y): (i32, i32), needed: u32, wanted: u8) -> Option<u8> {
    let Scene { frame, template, scorer, .. } = scene;
    let four = Rect::new(x, y, template.width().saturating_add(3), template.height());
    let seen = four.intersection(frame.bounds());
    let (left, top) = (seen.x.wrapping_sub(x), seen.y.wrapping_sub(y));
    let at_all = Rect::new(left, top, seen.width.checked_sub(3)?, seen.height);
    let mut others = 0;
    if seen != four {
        let at_any = Rect::new(left.saturating_sub(3), top, seen.width.saturating_add(3), seen.height);
        let at_any = at_any.intersection(Rect::new(0, 0, template.width(), template.height()));
        others = at_any.area().saturating_sub(at_all.area()) * u32::from(Table::ONE);
        others = others.saturating_add(scorer.score_on_padding(*template, at_any));
    }
    let needed = needed.checked_sub(others).filter(|&needed| needed > 0)?;
    Some(scorer.candidates(frame.patch(seen)?, template.crop(at_all)?, needed, wanted))
}

const OFFSETS: u8 = 16;
