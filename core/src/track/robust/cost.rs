//! The cost of each stage in units of work, and the most work of an update, a lock and a step.
//!
//! A unit is about one instruction of a Cortex-M4. A product of a weight and a feature counts 1, and so does each pixel
//! read from the frame.
#![allow(clippy::cast_possible_truncation)] // numbers of a few thousand, in `const` functions

use super::config::Config;
use super::constants::{
    ALIGNMENTS, CELL, CHANNELS, FIRST_STEPS, MARGIN, MOST_CELLS, MOST_PIXELS, MOST_SIDE, SCALE_REACH,
};
use super::grid::Grid;
use crate::track::MostWork;
use crate::track::budget::units;

/// Units for each sample of a search window, including its share of the features.
pub(super) const SAMPLED: u32 = 64;
/// Units for each sample of the view.
pub(super) const VIEWED: u32 = 32;
/// Units for each pixel of the template that is compared.
pub(super) const COMPARED: u32 = 12;
/// Units for each pixel of the template that is relit.
pub(super) const RELIT: u32 = 20;
/// Units for each pixel of the template in the refinement.
pub(super) const REFINED: u32 = 40;
/// Units for each weight when the direction is computed.
pub(super) const SLOPED: u32 = 64;
/// Units for each weight that is coded or changed, and for each pixel of the template that is copied.
pub(super) const CODED: u32 = 16;

/// Units for each sample of the refiner's crop that is normalised.
pub(super) const NORMALISED: u32 = 16;
/// Samples on a side of the refiner's crop.
pub(super) const CROP: u32 = 32;
/// Units of the refiner's network: its products, and its inputs each time they are gathered.
#[cfg(feature = "refiner")]
const NETWORK: u32 = super::refiner::WORK;
#[cfg(not(feature = "refiner"))]
const NETWORK: u32 = 0;

/// The number of the filter's weights on a grid.
pub(super) fn weights(grid: &Grid) -> u32 {
    units(grid.weights())
}

/// Lines of samples that a row of cells needs.
const LINES: u32 = CELL as u32 + 2;

/// The shape of a filter, in cells.
#[derive(Clone, Copy)]
struct Shape {
    across: u32,
    down: u32,
    /// Reach of the search, in cells.
    reach: u32,
}

/// The most pixels of the frame that a lattice reads. Its steps are less than two blocks, and it reads four pixels of
/// each block.
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

    /// The work for the features of a window with a margin of `reach` cells around the filter.
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

    /// The work for a search with its verification: features, responses, the view of the peak, alignments and
    /// agreement.
    const fn search(self) -> u32 {
        let agreement = ALIGNMENTS as u32 * COMPARED + RELIT + RELIT + COMPARED;
        self.features(self.reach) + self.offsets() * self.weights() + self.view() + agreement * self.pixels()
    }

    const fn scales(self) -> u32 {
        let offsets = (2 * SCALE_REACH as u32 + 1) * (2 * SCALE_REACH as u32 + 1);
        3 * (self.features(SCALE_REACH as u32) + offsets * self.weights())
    }

    /// The work for a step of learning.
    const fn learn(self) -> u32 {
        self.offsets() + (2 * self.offsets() + 2 * CODED + SLOPED) * self.weights()
    }

    /// The work for a crop of the refiner. Its steps across and down are less than four blocks together.
    const fn crop(config: &Config) -> u32 {
        if config.refiner { CROP * CROP * (VIEWED + NORMALISED) + 4 * (2 * CROP + 2) * (2 * CROP + 2) } else { 0 }
    }

    /// The work for the refiner: its crop and its network.
    const fn refiner(config: &Config) -> u32 {
        if config.refiner { Self::crop(config) + NETWORK } else { 0 }
    }

    const fn update(self, config: &Config) -> u32 {
        let begin = CODED * (self.weights() + self.pixels());
        let search = self.search() + REFINED * self.pixels();
        let scales = if config.size { self.scales() } else { 0 };
        // A frame is learned or redetected, never both.
        let (learn, elsewhere) =
            (self.learn() + Self::refiner(config), if config.sweeps() { self.search() } else { 0 });
        begin + search + scales + if learn > elsewhere { learn } else { elsewhere }
    }

    const fn lock(self, config: &Config) -> u32 {
        let lesson = CODED * self.weights() + self.offsets() * self.weights() + self.learn();
        Self::crop(config) + self.view() + self.features(self.reach) + FIRST_STEPS * lesson
    }

    /// The largest piece of work that cannot be divided: a row of cells, of the view or of responses, or one pass over
    /// the weights or the template.
    const fn unit(self) -> u32 {
        let columns = (self.across + 2 * self.reach) * CELL as u32 + 2;
        let span = 2 * self.reach + 1;
        let scale = (2 * SCALE_REACH as u32 + 1) * (2 * SCALE_REACH as u32 + 1) * self.weights();
        let all = [
            LINES * columns * SAMPLED + read(columns, LINES),
            // Some backends multiply two rows of cells at a time. The last piece also codes or changes the weights.
            (2 * span + CODED) * self.weights(),
            // The errors.
            self.offsets() + CODED * self.weights(),
            SLOPED * self.weights(),
            // The pass over the weights of the scale search, or the first alignment, for which the template is
            // relit.
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
    /// assert!(MOST.update < 6_500_000 && MOST.lock < 50_600_000 && MOST.beyond_a_step == 128_000, "{MOST:?}");
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
            let (update, lock, unit) = (shape.update(self) as u64, shape.lock(self) as u64, shape.unit());
            most.update = if update > most.update { update } else { most.update };
            most.lock = if lock > most.lock { lock } else { most.lock };
            most.beyond_a_step = if unit > most.beyond_a_step { unit } else { most.beyond_a_step };
            across += 1;
        }
        most
    }
}
