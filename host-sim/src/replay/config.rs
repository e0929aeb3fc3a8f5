//! The configuration of a tracker from the numbers in its record, in the order that `smr_core::record` describes.

use anyhow::{Context, Result, ensure};
use smr_core::paper::{self, Fraction, Margins, Radius, RunnerUp};
use smr_core::record::Recorded;
use smr_core::robust;
use smr_core::similarity::Table;
use smr_core::unstable::{Part, without};
use std::sync::LazyLock;

/// A tracker whose configuration can be read from a record.
pub trait Configured: Recorded {
    /// Errors: They are not those of this version.
    fn configuration(numbers: &[u16]) -> Result<Self::Config>;
}

impl Configured for smr_evaluation::Paper {
    fn configuration(numbers: &[u16]) -> Result<paper::Config> {
        let mut config = paper::Config::paper();
        config.table = table(numbers)?;
        let mut rest = Rest::of(numbers, 282)?;
        config.k = rest.fraction();
        let gate = &mut config.gate;
        for fraction in [&mut gate.tracking, &mut gate.leaving, &mut gate.returning, &mut gate.lost] {
            *fraction = rest.fraction();
        }
        (gate.lead, gate.least_ratio) = (rest.next(), rest.next());
        (config.first_threshold, config.least_threshold) = (rest.byte()?, rest.byte()?);
        config.padding = rest.next();
        config.window = rest.radius();
        config.growth = rest.next();
        config.window_limit = rest.radius();
        config.neighbourhood = rest.next();
        config.runner_up = if rest.flag()? { RunnerUp::Always } else { RunnerUp::WhenItDecides };
        config.update_zone = Margins { left: rest.next(), top: rest.next(), right: rest.next(), bottom: rest.next() };
        Ok(config)
    }
}

impl Configured for smr_core::Robust {
    fn configuration(numbers: &[u16]) -> Result<robust::Config> {
        let mut config = robust::Config::robust();
        config.table = table(numbers)?;
        // The refiner adds a number if it is on.
        config.refiner = numbers.len() == 269;
        let mut rest = Rest::of(numbers, if config.refiner { 269 } else { 268 })?;
        (config.size, config.sweep) = (rest.flag()?, rest.flag()?);
        for part in [Part::Velocity, Part::DistancePenalty, Part::Verification, Part::GatedLearning] {
            if !rest.flag()? {
                config = without(config, part);
            }
        }
        (config.reach, config.patience) = (rest.byte()?, rest.byte()?);
        (config.lost_below, config.uncertain_below) = (rest.next(), rest.next());
        (config.learning_rate, config.early_rate) = (rest.next(), rest.next());
        Ok(config)
    }
}

/// The numbers after the table, one after the other.
struct Rest<'a>(&'a [u16]);

impl<'a> Rest<'a> {
    /// Errors: There are not so many numbers in all.
    fn of(numbers: &'a [u16], expected: usize) -> Result<Self> {
        let count = numbers.len();
        ensure!(count == expected, "the configuration has {count} numbers: expected {expected}");
        Ok(Self(&numbers[256..]))
    }

    /// There are as many as are asked for: `of` has counted them.
    fn next(&mut self) -> u16 {
        self.0.split_off_first().copied().unwrap_or_default()
    }

    fn byte(&mut self) -> Result<u8> {
        Ok(u8::try_from(self.next())?)
    }

    fn flag(&mut self) -> Result<bool> {
        let number = self.next();
        ensure!(number < 2, "a flag of the configuration is {number}: expected 0 or 1");
        Ok(number == 1)
    }

    fn fraction(&mut self) -> Fraction {
        Fraction::new(self.next(), self.next())
    }

    fn radius(&mut self) -> Radius {
        Radius { x: self.next(), y: self.next() }
    }
}

/// Those that are not the paper's, for the life of the program, as a configuration wants them.
static TABLES: LazyLock<Vec<Table>> =
    LazyLock::new(|| Table::SCALES.filter_map(|scale| Table::new(scale).ok()).collect());

/// The table with these entries: its scale is not in the record, but found.
fn table(numbers: &[u16]) -> Result<&'static Table> {
    let entries = numbers.get(..256).unwrap_or_default();
    if entries == Table::PAPER.entries() {
        return Ok(&Table::PAPER);
    }
    let found = TABLES.iter().find(|table| table.entries() == entries);
    found.context("its table of similarities is none of exp(-d / scale)")
}
