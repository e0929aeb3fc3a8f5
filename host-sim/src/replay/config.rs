//! The configuration of a tracker from the numbers in its record.

use anyhow::{Context, Result};
use smr_core::Settings;
use smr_core::similarity::Table;
use std::sync::LazyLock;

/// Those that are not the paper's, for the life of the program, as a configuration wants them.
static TABLES: LazyLock<Vec<Table>> =
    LazyLock::new(|| Table::SCALES.filter_map(|scale| Table::new(scale).ok()).collect());

/// Errors: They are not those of this version. The scale of the table is not in the record, but found.
pub fn configuration<C: Settings>(numbers: &[u16]) -> Result<C> {
    let (entries, rest) = numbers.split_at_checked(256).context("its table of similarities is cut off")?;
    let mut tables = [&Table::PAPER].into_iter().chain(TABLES.iter());
    let table = tables.find(|table| table.entries() == entries);
    Ok(C::of_numbers(table.context("its table of similarities is none of exp(-d / scale)")?, rest)?)
}
