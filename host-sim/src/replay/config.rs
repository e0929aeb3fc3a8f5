//! The configuration of a tracker from the numbers in its record, in the order that `smr_core::record` describes.

use anyhow::{Context, Result, bail, ensure};
use smr_core::paper::{self, Fraction, Margins, Radius, RunnerUp};
use smr_core::record::Recorded;
use smr_core::robust;
use smr_core::similarity::Table;
use smr_core::unstable::{Part, without};
use std::sync::LazyLock;

/// A tracker whose configuration can be read from a record.
pub trait Configured: Recorded {
    /// # Errors
    /// They are not those of this version.
    fn configuration(numbers: &[u16]) -> Result<Self::Config>;
}

impl Configured for crate::Paper {
    fn configuration(numbers: &[u16]) -> Result<paper::Config> {
        let mut config = paper::Config::paper();
        config.table = table(numbers)?;
        let rest = numbers.get(256..).unwrap_or_default();
        let &[
            k,
            of_k,
            tracking,
            of_tracking,
            leaving,
            of_leaving,
            returning,
            of_returning,
            lost,
            of_lost,
            lead,
            least_ratio,
            first_threshold,
            least_threshold,
            padding,
            x,
            y,
            growth,
            limit_x,
            limit_y,
            neighbourhood,
            always,
            left,
            top,
            right,
            bottom,
        ] = rest
        else {
            bail!("the configuration has {} numbers: expected 282", numbers.len())
        };
        config.k = Fraction::new(k, of_k);
        let gate = &mut config.gate;
        gate.tracking = Fraction::new(tracking, of_tracking);
        gate.leaving = Fraction::new(leaving, of_leaving);
        gate.returning = Fraction::new(returning, of_returning);
        gate.lost = Fraction::new(lost, of_lost);
        (gate.lead, gate.least_ratio) = (lead, least_ratio);
        (config.first_threshold, config.least_threshold) = (byte(first_threshold)?, byte(least_threshold)?);
        (config.padding, config.growth, config.neighbourhood) = (padding, growth, neighbourhood);
        config.window = Radius { x, y };
        config.window_limit = Radius { x: limit_x, y: limit_y };
        config.runner_up = if flag(always)? { RunnerUp::Always } else { RunnerUp::WhenItDecides };
        config.update_zone = Margins { left, top, right, bottom };
        Ok(config)
    }
}

impl Configured for smr_core::Robust {
    fn configuration(numbers: &[u16]) -> Result<robust::Config> {
        let mut config = robust::Config::robust();
        config.table = table(numbers)?;
        let rest = numbers.get(256..).unwrap_or_default();
        let &[
            size,
            sweep,
            velocity,
            distance_penalty,
            verification,
            gated_learning,
            reach,
            patience,
            lost_below,
            uncertain_below,
            learning_rate,
            early_rate,
        ] = rest
        else {
            bail!("the configuration has {} numbers: expected 268", numbers.len())
        };
        (config.size, config.sweep) = (flag(size)?, flag(sweep)?);
        let parts = [
            (velocity, Part::Velocity),
            (distance_penalty, Part::DistancePenalty),
            (verification, Part::Verification),
            (gated_learning, Part::GatedLearning),
        ];
        for (has, part) in parts {
            if !flag(has)? {
                config = without(config, part);
            }
        }
        (config.reach, config.patience) = (byte(reach)?, byte(patience)?);
        (config.lost_below, config.uncertain_below) = (lost_below, uncertain_below);
        (config.learning_rate, config.early_rate) = (learning_rate, early_rate);
        Ok(config)
    }
}

fn byte(number: u16) -> Result<u8> {
    Ok(u8::try_from(number)?)
}

fn flag(number: u16) -> Result<bool> {
    ensure!(number < 2, "a flag of the configuration is {number}: expected 0 or 1");
    Ok(number == 1)
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
