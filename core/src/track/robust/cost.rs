//! What each part of an update costs in units of work, and the most that an update, a lock and a step can cost.
//!
//! A unit is about an instruction of a Cortex-M4. A product of a weight and a byte counts 1; so does a pixel of the frame that is read.
#![allow(clippy::cast_possible_truncation)] // of numbers of a few thousand, in functions that are `const`

use super::config::Config;
use super::exact::{MARGIN, PLACES};
use super::features::{CELL, CHANNELS};
use super::grid::MOST_SIDE;
use super::update::{FIRST_STEPS, SIZE_REACH};
use super::{MOST_CELLS, MOST_PIXELS};
use crate::track::MostWork;

/// A pixel of the grid that is sampled, and of which features are made.
pub(super) const SEEN: u32 = 64;
/// One of the view.
pub(super) const VIEWED: u32 = 32;
/// One of the template that is compared.
pub(super) const COMPARED: u32 = 12;
/// One that is put into other light.
pub(super) const LIT: u32 = 20;
/// One by which a place is refined.
pub(super) const REFINED: u32 = 40;
/// A weight while the way to change it is found.
pub(super) const SLOPED: u32 = 64;
/// A weight while it is coded or changed, and a pixel of the template while it is copied.
pub(super) const CODED: u32 = 16;

/// Lines of the grid that a row of cells is made of.
const LINES: u32 = CELL as u32 + 2;

/// The shape of a filter, in cells.
#[derive(Clone, Copy)]
struct Shape {
    across: u32,
    down: u32,
    /// How far is searched, in cells.
    reach: u32,
}

/// The most pixels of the frame that are read for so many columns and rows of the grid: a step is less than two blocks, of each of which
/// four pixels are read.
const fn read(columns: u32, rows: u32) -> u32 {
    4 * (2 * columns + 1) * (2 * rows + 1)
}

impl Shape {
    const fn weights(self) -> u32 {
        self.across * self.down * CHANNELS as u32
    }

    /// The most pixels of the template.
    const fn pixels(self) -> u32 {
        let all = self.across * self.down * CELL as u32 * CELL as u32;
        if all < MOST_PIXELS as u32 { all } else { MOST_PIXELS as u32 }
    }

    const fn offsets(self) -> u32 {
        (2 * self.reach + 1) * (2 * self.reach + 1)
    }

    /// A window of cells that reaches so far beyond the filter.
    const fn see(self, reach: u32) -> u32 {
        let columns = (self.across + 2 * reach) * CELL as u32 + 2;
        let rows = (self.down + 2 * reach) * CELL as u32 + 2;
        columns * rows * SEEN + read(columns, rows)
    }

    const fn view(self) -> u32 {
        // Of all templates that a filter covers the longest has the longest margin.
        let (columns, rows) =
            (self.across * CELL as u32 + 2 * MARGIN as u32, self.down * CELL as u32 + 2 * MARGIN as u32);
        columns * rows * VIEWED + read(columns, rows)
    }

    /// A look at a window: cells, responses, the view of the peak, and whether the early template agrees.
    const fn look(self) -> u32 {
        let agreement = PLACES as u32 * COMPARED + LIT + LIT + COMPARED;
        self.see(self.reach) + self.offsets() * self.weights() + self.view() + agreement * self.pixels()
    }

    const fn scales(self) -> u32 {
        let offsets = (2 * SIZE_REACH as u32 + 1) * (2 * SIZE_REACH as u32 + 1);
        3 * (self.see(SIZE_REACH as u32) + offsets * self.weights())
    }

    /// A step of learning.
    const fn learn(self) -> u32 {
        self.offsets() + (2 * self.offsets() + 2 * CODED + SLOPED) * self.weights()
    }

    const fn update(self, config: &Config) -> u32 {
        let begin = CODED * (self.weights() + self.pixels());
        let look = self.look() + REFINED * self.pixels();
        let scales = if config.size { self.scales() } else { 0 };
        // Nothing is learned in a frame in which the target is looked for elsewhere.
        let (learn, elsewhere) = (self.learn(), if config.sweeps() { self.look() } else { 0 });
        begin + look + scales + if learn > elsewhere { learn } else { elsewhere }
    }

    const fn lock(self) -> u32 {
        let lesson = CODED * self.weights() + self.offsets() * self.weights() + self.learn();
        self.view() + self.see(self.reach) + FIRST_STEPS * lesson
    }

    /// The largest of what is not divided: a row of cells, a row of the view or of responses, the weights or the template once.
    const fn unit(self) -> u32 {
        let columns = (self.across + 2 * self.reach) * CELL as u32 + 2;
        let span = 2 * self.reach + 1;
        let scale = (2 * SIZE_REACH as u32 + 1) * (2 * SIZE_REACH as u32 + 1) * self.weights();
        let all = [
            LINES * columns * SEEN + read(columns, LINES),
            // Where two rows of cells are multiplied at a time. The weights are coded, or changed, at once with the last ones.
            (2 * span + CODED) * self.weights(),
            // The errors, and the first part of what is gathered of them.
            self.offsets() + CODED * self.weights(),
            SLOPED * self.weights(),
            // The first place is put into other light.
            if scale > (LIT + COMPARED) * self.pixels() { scale } else { (LIT + COMPARED) * self.pixels() },
            REFINED * self.pixels(),
        ];
        let (mut rest, mut most) = (all.as_slice(), 0);
        while let [unit, others @ ..] = rest {
            most = if *unit > most { *unit } else { most };
            rest = others;
        }
        most
    }
}

impl Config {
    /// The most work of an update, a lock and a step, whatever the sizes of frame and target, and whatever the frames show.
    ///
    /// ```
    /// use smr_core::robust::Config;
    /// const MOST: smr_core::MostWork = Config::robust().most_work();
    /// assert!(MOST.update < 6_500_000 && MOST.lock < 50_500_000 && MOST.beyond_a_step == 128_000, "{MOST:?}");
    /// ```
    #[must_use]
    pub const fn most_work(&self) -> MostWork {
        let mut most = MostWork { update: 0, lock: 0, beyond_a_step: 0 };
        let mut across = 1;
        while across <= MOST_SIDE as u32 {
            // More rows are more work.
            let down = MOST_CELLS as u32 / across;
            let down = if down < MOST_SIDE as u32 { down } else { MOST_SIDE as u32 };
            let shape = Shape { across, down, reach: self.reach as u32 };
            let (update, lock, unit) = (shape.update(self) as u64, shape.lock() as u64, shape.unit());
            most.update = if update > most.update { update } else { most.update };
            most.lock = if lock > most.lock { lock } else { most.lock };
            most.beyond_a_step = if unit > most.beyond_a_step { unit } else { most.beyond_a_step };
            across += 1;
        }
        most
    }
}
