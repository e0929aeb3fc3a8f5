//! Units of work: what each part of an update costs, and the most that an update, a lock and a step can cost.
//!
//! A unit is about one instruction of a Cortex-M4. A product of a weight and a feature counts 1, and so does a pixel of the frame that is
//! read.
#![allow(clippy::cast_possible_truncation)] // numbers of a few thousand, in `const` functions

use super::config::Config;
use super::constants::{
    CELL, CHANNELS, DISPLACEMENTS, FIRST_STEPS, MARGIN, MOST_CELLS, MOST_PIXELS, MOST_SIDE, SCALE_REACH,
};
use super::grid::Grid;
use crate::track::MostWork;

/// For each sample of a search window, with its part of the features.
pub(super) const SAMPLED: u32 = 64;
/// For each sample of the view.
pub(super) const VIEWED: u32 = 32;
/// For each pixel of the template that is compared.
pub(super) const COMPARED: u32 = 12;
/// For each pixel of the template that is relit.
pub(super) const RELIT: u32 = 20;
/// For each pixel of the template by which place and size are refined.
pub(super) const REFINED: u32 = 40;
/// For each weight when the direction is computed.
pub(super) const SLOPED: u32 = 64;
/// For each weight that is coded or changed, and each pixel of the template that is copied.
pub(super) const CODED: u32 = 16;

/// A number of products as work.
pub(super) fn units(products: usize) -> u32 {
    u32::try_from(products).unwrap_or(u32::MAX)
}

/// The weights of the filter on a grid, as work is computed from them.
pub(super) fn weights(grid: &Grid) -> u32 {
    units(grid.weights())
}

/// Lines of samples from which a row of cells is made.
const LINES: u32 = CELL as u32 + 2;

/// The shape of a filter, in cells.
#[derive(Clone, Copy)]
struct Shape {
    across: u32,
    down: u32,
    /// How far it searches, in cells.
    reach: u32,
}

/// The most pixels of the frame that are read for a lattice: its steps are less than two blocks, and four pixels of each block are read.
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

    /// Features of a window that reaches this much further than the filter.
    const fn features(self, reach: u32) -> u32 {
        let columns = (self.across + 2 * reach) * CELL as u32 + 2;
        let rows = (self.down + 2 * reach) * CELL as u32 + 2;
        columns * rows * SAMPLED + read(columns, rows)
    }

    const fn view(self) -> u32 {
        // The longest template that a filter covers has the longest margin.
        let (columns, rows) =
            (self.across * CELL as u32 + 2 * MARGIN as u32, self.down * CELL as u32 + 2 * MARGIN as u32);
        columns * rows * VIEWED + read(columns, rows)
    }

    /// A search and its verification: features, responses, the view of the peak, displacements and agreement.
    const fn search(self) -> u32 {
        let agreement = DISPLACEMENTS as u32 * COMPARED + RELIT + RELIT + COMPARED;
        self.features(self.reach) + self.offsets() * self.weights() + self.view() + agreement * self.pixels()
    }

    const fn scales(self) -> u32 {
        let offsets = (2 * SCALE_REACH as u32 + 1) * (2 * SCALE_REACH as u32 + 1);
        3 * (self.features(SCALE_REACH as u32) + offsets * self.weights())
    }

    /// A step of learning.
    const fn learn(self) -> u32 {
        self.offsets() + (2 * self.offsets() + 2 * CODED + SLOPED) * self.weights()
    }

    const fn update(self, config: &Config) -> u32 {
        let begin = CODED * (self.weights() + self.pixels());
        let search = self.search() + REFINED * self.pixels();
        let scales = if config.size { self.scales() } else { 0 };
        // A frame is either learned or searched elsewhere.
        let (learn, elsewhere) = (self.learn(), if config.sweeps() { self.search() } else { 0 });
        begin + search + scales + if learn > elsewhere { learn } else { elsewhere }
    }

    const fn lock(self) -> u32 {
        let lesson = CODED * self.weights() + self.offsets() * self.weights() + self.learn();
        self.view() + self.features(self.reach) + FIRST_STEPS * lesson
    }

    /// The largest piece that cannot be cut: a row of cells, of the view or of responses, or once through the weights or the template.
    const fn unit(self) -> u32 {
        let columns = (self.across + 2 * self.reach) * CELL as u32 + 2;
        let span = 2 * self.reach + 1;
        let scale = (2 * SCALE_REACH as u32 + 1) * (2 * SCALE_REACH as u32 + 1) * self.weights();
        let all = [
            LINES * columns * SAMPLED + read(columns, LINES),
            // The DSP extension multiplies two rows of cells at a time. With the last ones the weights are coded or changed.
            (2 * span + CODED) * self.weights(),
            // The errors.
            self.offsets() + CODED * self.weights(),
            SLOPED * self.weights(),
            // The first displacement, for which the template is relit.
            if scale > (RELIT + COMPARED) * self.pixels() { scale } else { (RELIT + COMPARED) * self.pixels() },
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
    /// The most work of an update, a lock and a step, for any frames and any target.
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
