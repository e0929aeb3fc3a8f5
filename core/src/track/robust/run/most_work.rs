//! Upper bounds of the work of an update, a lock and a step, computed from the bounds of the stages, each in its own
//! file. A unit of work is about one instruction of a Cortex-M4: a product of weight and feature, or a pixel read.

use super::super::config::Config;
use super::super::constants::{Limits, MAX_SIDE};
use super::super::features::{Extent, cells};
use super::super::filter::{CODED, learning, response, scale};
use super::super::refiner;
use super::super::verification::{COPIED, REFINED, agreement, lighting};
use super::lock::FIRST_STEPS;
use super::size::{Size, Standard};
use crate::track::MostWork;
use crate::track::update::largest;

const fn update(config: &Config, extent: Extent) -> u32 {
    let begin = CODED * extent.weights() + COPIED * extent.pixels();
    let scales = if config.size { scale::most_work(extent) } else { 0 };
    let before = begin + search(extent) + REFINED * extent.pixels() + scales;
    let (learned, windows) = (learning::most_work(extent), config.sweep as u32);
    if config.refines() {
        // Learning comes before the refiner, which can still take the evidence that learning and tracking need.
        let redetected = CODED * extent.weights() + windows * (search(extent) + refiner::WORK);
        before + learned + refiner::WORK + redetected
    } else {
        // An update learns from its frame or redetects the target, never both.
        before + largest(&[learned, windows * search(extent)])
    }
}

const fn window(extent: Extent) -> u32 {
    cells::most_work(extent) + lighting::most_work(extent)
}

const fn search(extent: Extent) -> u32 {
    window(extent) + response::most_work(extent) + agreement::most_work(extent)
}

const fn lock(config: &Config, extent: Extent) -> u32 {
    let crop = if config.refines() { refiner::CROP_WORK } else { 0 };
    let begin = CODED * extent.weights() + agreement::most_of_a_view(extent);
    crop + begin + window(extent) + FIRST_STEPS * (learning::most_of_a_lock(extent) + CODED * extent.offsets())
}

/// Upper bound of the work for an indivisible piece, by which a step may exceed its grant.
const fn piece(extent: Extent) -> u32 {
    largest(&[
        // The piece with the last row of features also measures the window's contrast.
        cells::most_work_of_a_piece(extent) + lighting::most_work(extent),
        agreement::most_work_of_a_piece(extent),
        REFINED * extent.pixels(),
        scale::most_work_of_a_piece(extent),
        learning::most_work_of_a_piece(extent),
    ])
}

/// The search window of the filter of this width with the most rows, because more rows are more work.
const fn tallest(config: &Config, across: u32, limits: Limits) -> Extent {
    let down = limits.cells as u32 / across;
    let down = if down < MAX_SIDE as u32 { down } else { MAX_SIDE as u32 };
    Extent { across, down, reach: config.reach as u32, most_pixels: limits.pixels as u32 }
}

impl Config {
    /// Upper bounds of the work of an update, a lock and a step, for any frames and any target, in a tracker of the
    /// [`Standard`] size. A smaller one does less: see [`Config::most_work_of`].
    ///
    /// ```
    /// use smr_core::robust::Config;
    /// const MAX: smr_core::MostWork = Config::robust().most_work();
    /// assert!(MAX.update < 13_800_000 && MAX.lock < 11_100_000 && MAX.beyond_a_step == 128_000, "{MAX:?}");
    /// ```
    #[must_use]
    pub const fn most_work(&self) -> MostWork {
        self.most_work_of::<Standard>()
    }

    /// [`Config::most_work`] of a tracker of size `S`.
    ///
    /// ```
    /// use smr_core::robust::{Config, Small};
    /// const MAX: smr_core::MostWork = Config::robust().within::<Small>().most_work_of::<Small>();
    /// assert!(MAX.update < 11_000_000 && MAX.lock < 7_600_000 && MAX.beyond_a_step < 104_000, "{MAX:?}");
    /// ```
    #[must_use]
    pub const fn most_work_of<S: Size>(&self) -> MostWork {
        let mut most = MostWork { update: 0, lock: 0, beyond_a_step: 0 };
        let mut across = 1;
        while across <= MAX_SIDE as u32 {
            let extent = tallest(self, across, S::LIMITS);
            let (update, lock) = (update(self, extent) as u64, lock(self, extent) as u64);
            most.update = if update > most.update { update } else { most.update };
            most.lock = if lock > most.lock { lock } else { most.lock };
            most.beyond_a_step = largest(&[most.beyond_a_step, piece(extent)]);
            across += 1;
        }
        most
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{format, string::String};

    /// Checks the numbers in the diagram of `robust/mod.rs`: the work of each stage, with the most expensive filter.
    #[test]
    fn the_drawing_has_the_work_of_each_stage() {
        let config = Config::robust();
        let extents = (1..=MAX_SIDE.into()).map(|across| tallest(&config, across, Limits::STANDARD));
        let extent = extents.max_by_key(|&extent| update(&config, extent)).unwrap();
        assert_eq!(u64::from(update(&config, extent)), config.most_work().update);
        assert_eq!(Config { sweep: u8::MAX, ..config }.most_work().update, 658_990_060, "the most fits a u32");
        let stages = [
            ("cells", cells::most_work(extent)),
            ("response", response::most_work(extent)),
            ("(lighting)", agreement::most_work(extent) + lighting::most_work(extent)),
            ("refinement", REFINED * extent.pixels()),
            ("scale", scale::most_work(extent)),
            ("redetection", u32::from(config.sweep) * search(extent)),
            ("learning", learning::most_work(extent)),
            ("answer", update(&config, extent)),
        ]
        .map(|(stage, work)| (stage, format!("{:.2}", f64::from(work) / 1e6)));
        let stands = |(stage, figure): &(&str, String)| {
            let mut lines = include_str!("../mod.rs").lines().filter(|line| line.contains(&format!(" {stage} ")));
            lines.any(|line| line.split(' ').any(|word| word == figure))
        };
        assert!(stages.iter().all(stands), "in millions: {stages:?}");
    }
}
