//! Frames per second by size of template and of window, with the fastest backend of this machine.

use super::case::{self, Case, Size, Triple};
use super::searches;
use crate::clock::{Budget, Patience, timed};
use anyhow::Result;
use host_sim::percentiles::Spread;
use serde::Serialize;
use smr_core::paper::Radius;
use smr_core::similarity::Backend;
use std::time::Duration;

/// Sides of the templates.
pub const TEMPLATES: [u16; 4] = [16, 32, 48, 64];

/// The windows, the smallest first.
pub const WINDOWS: [Radius; 5] = [
    Radius { x: 4, y: 4 },
    Radius { x: 8, y: 8 },
    Radius { x: 16, y: 16 },
    Radius { x: 32, y: 32 },
    Radius { x: 60, y: 50 },
];

/// All combinations.
pub struct Speeds {
    cells: Vec<Cell>,
}

struct Cell {
    template: u16,
    radius: Radius,
    /// Of an update with pruning, and without.
    times: [Vec<Duration>; 2],
    budgets: [Budget; 2],
}

/// One combination, as it is printed; `None` where no recording has room for it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Speed {
    /// The template's side.
    pub template: u16,
    #[serde(serialize_with = "super::window::as_text")]
    pub window: Radius,
    pub offsets: u32,
    pub pruned: Option<f64>,
    pub exhaustive: Option<f64>,
}

impl Speeds {
    /// Nothing timed yet. Each combination may take `each`, for about `expected` cases.
    pub fn new(each: Duration, expected: u32) -> Self {
        let cell = |template, radius| {
            let budgets = [Budget::new(each, expected); 2];
            Cell { template, radius, times: [vec![], vec![]], budgets }
        };
        let windows = |template| WINDOWS.map(|radius| cell(template, radius));
        Self { cells: TEMPLATES.into_iter().flat_map(windows).collect() }
    }

    /// Times the search of `triple` in every combination that has room.
    pub fn add(&mut self, triple: &Triple, patience: Patience) -> Result<()> {
        for cell in &mut self.cells {
            let Some(case) = Case::new(triple, Size::Of(cell.template, cell.template), cell.radius)? else { continue };
            let kinds = [true, false].into_iter().zip(&mut cell.times).zip(&mut cell.budgets);
            for ((pruning, times), budget) in
                kinds.filter_map(|(kind, budget)| budget.allows().then_some((kind, budget)))
            {
                let (time, spent) = timed(|| update(&case, pruning, patience));
                times.push(time?);
                budget.spend(spent);
            }
        }
        Ok(())
    }

    /// Frames per second of the median update, template by template, window by window.
    pub fn rows(&self) -> Vec<Speed> {
        let speed = |times: &Vec<Duration>| {
            let seconds: Vec<f64> = times.iter().map(Duration::as_secs_f64).collect();
            (!seconds.is_empty()).then(|| 1.0 / Spread::of(&seconds).median.max(1e-9))
        };
        let row = |cell: &Cell| {
            let offsets = case::offsets(cell.radius);
            let [pruned, exhaustive] = cell.times.each_ref().map(speed);
            Speed { template: cell.template, window: cell.radius, offsets, pruned, exhaustive }
        };
        self.cells.iter().map(row).collect()
    }
}

fn update(case: &Case, pruning: bool, patience: Patience) -> Result<Duration> {
    let mut tracker = case.tracker(Backend::best(), pruning)?;
    Ok(searches::update(case, &mut tracker, patience)?.time)
}
