//! How a command that measures prints its tables: in words, as JSON, or as CSV.

use super::tell;
use anyhow::{Context, Result, ensure};
use smr_evaluation::{Layout, TableName, Tables};
use std::io::Write;

#[derive(Debug, clap::Args)]
pub struct TableOptions {
    /// Print JSON instead of tables: an object with the tables of --part, each an array of flat objects
    ///
    /// All objects of a table have the same keys, and a key has values of one type; what is not known is null. The options of a tracker are a
    /// text, itself JSON.
    #[arg(long)]
    json: bool,
    /// How the tables are written
    #[arg(long, value_enum, default_value_t, conflicts_with = "json")]
    format: Layout,
    /// With --format csv: which table of --json [default: measured]
    #[arg(long, value_enum, conflicts_with = "json")]
    part: Option<TableName>,
}

impl TableOptions {
    /// Errors: --part without CSV, or of a table that is not one of `known`.
    pub fn check(&self, known: &[TableName]) -> Result<()> {
        let Some(part) = self.part else { return Ok(()) };
        ensure!(self.format == Layout::Csv, "--part chooses a table of --format csv: expected both");
        let names = || known.iter().map(|name| name.text()).collect::<Vec<_>>().join(", ");
        ensure!(known.contains(&part), "--part {}: expected one of {}", part.text(), names());
        Ok(())
    }

    /// Prints `tables` as JSON or CSV, or what `words` says.
    pub fn print(&self, tables: &Tables, words: impl FnOnce(Layout) -> String) -> Result<()> {
        let text = match self.format {
            Layout::Csv => tables.csv(self.part.unwrap_or(TableName::Measured)).context("there is no such table")?,
            layout => words(layout),
        };
        tell(self.json, tables, |_, out| out.write_all(text.as_bytes()))
    }
}
