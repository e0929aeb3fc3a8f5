//! The descent from the last position: a good score early excludes more offsets.

use super::progress::{Descent, Scene, Search, Stage};
use super::window::Window;
use crate::image::Rect;

/// The first step of the descent in pixels: 0, 1, 2, 4 or 8. A step costs as much as 2 offsets (8 SADs of every fourth
/// row). All steps together cost at most 1/64 of the window.
fn first_step(window: &Window) -> u8 {
    first_step_of(window.size())
}

pub(super) fn first_step_of((columns, rows): (usize, usize)) -> u8 {
    match columns * rows / 128 {
        0 => 0,
        steps => 1 << (steps - 1).min(MOST_STEPS - 1),
    }
}

/// Rows from one row that a SAD reads to the next.
pub(super) const SAD_STEP: u16 = 4;

/// The most steps of a descent. The first one is at most 2^(4 - 1) = 8 pixels, so the descent reaches 15. Beyond that
/// the ranges are faster.
pub(super) const MOST_STEPS: usize = 4;

impl<const PIXELS: usize, const SPAN: usize> Search<PIXELS, SPAN> {
    /// Begins the descent at the last position. If there is no descent, it ends at the last position at once.
    pub(super) fn last_position(&mut self, scene: &Scene<'_>) {
        let (x, y) = scene.window.centre();
        self.descent = Descent { x, y, best: (x, y), distance: u32::MAX, step: 0 };
        self.stage = Stage::Descent;
        let step = first_step(&scene.window);
        if step > 0
            && let Some(distance) = self.sad(scene, x, y, u32::MAX)
        {
            (self.descent.distance, self.descent.step) = (distance, step);
        }
    }

    /// Compares the next neighbour, row by row. After the last one the next step of the descent begins, or the descent
    /// ends.
    #[cfg_attr(smr_small, inline(never))]
    pub(super) fn descend(&mut self, scene: &Scene<'_>) {
        let Descent { x, y, best, distance: least, step } = self.descent;
        if step == 0 {
            self.score(scene, x, y);
            if self.leaders.needed() == 0 {
                // If all offsets score 0, the last position is the peak. Groups that cannot score more are excluded
                // below.
                let (x, y) = scene.window.centre();
                self.score(scene, x, y);
            }
            return self.begin_scouts();
        }
        let next = self.place.next;
        self.place.next += 1;
        if next == 9 {
            self.place.next = 0;
            (self.descent.x, self.descent.y) = best;
            self.descent.step = step / 2;
        } else if next != 4 {
            let (x, y) = (x + third(next % 3, step), y + third(next / 3, step));
            if scene.window.contains(x, y)
                && let Some(distance) = self.sad(scene, x, y, least)
                && distance < least
            {
                (self.descent.best, self.descent.distance) = ((x, y), distance);
            }
        }
    }

    /// The SAD of every fourth row; `None` if the box is not wholly inside the frame. Stops early once the sum exceeds
    /// `enough`.
    #[cfg_attr(smr_small, inline(never))]
    fn sad(&mut self, scene: &Scene<'_>, x: i32, y: i32, enough: u32) -> Option<u32> {
        let patch = scene.frame.patch(Rect::new(x, y, scene.template.width(), scene.template.height()))?;
        self.spend(u32::from(scene.template.width()) * u32::from(scene.template.height().div_ceil(SAD_STEP)));
        scene.scorer.distance(patch.every(0, SAD_STEP.into())?, scene.template.every(0, SAD_STEP.into())?, enough)
    }
}

/// The `number`-th of -`step`, 0 and `step`.
fn third(number: usize, step: u8) -> i32 {
    match number {
        0 => -i32::from(step),
        1 => 0,
        _ => step.into(),
    }
}
