//! How tables are written: for a terminal, as Markdown, or as CSV.

use clap::ValueEnum;
use std::fmt::Write as _;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Layout {
    /// Columns side by side
    #[default]
    Text,
    /// The same tables in Markdown
    Markdown,
    /// One of the tables of --json (--part), with its keys as header
    Csv,
}

/// The cell of a figure that is not known.
pub const NOTHING: &str = "-";

/// The cells of a header: titles with `|` between them.
pub fn header(titles: &str) -> Vec<String> {
    titles.split('|').map(str::to_owned).collect()
}

/// The number with this many digits; empty without a number.
pub fn cell(value: Option<f64>, digits: usize) -> String {
    value.map_or(NOTHING.to_owned(), |value| format!("{value:.digits$}"))
}

impl Layout {
    /// A table whose first line is its header. The first `names` columns begin at their left edge, the others end at their right edge.
    pub(super) fn table(self, lines: &[Vec<String>], names: usize) -> String {
        match self {
            Self::Markdown => markdown(lines, names),
            // CSV is made from the tables of JSON.
            Self::Text | Self::Csv => aligned(lines, names),
        }
    }
}

/// The same for a terminal.
pub fn aligned(lines: &[Vec<String>], names: usize) -> String {
    let columns = lines.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| lines.iter().filter_map(|line| line.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let mut text = String::new();
    for line in lines {
        let mut row = String::new();
        for (column, (cell, &width)) in line.iter().zip(&widths).enumerate() {
            // Writing to a String cannot fail.
            let _ = if column < names { write!(row, "{cell:width$}  ") } else { write!(row, "{cell:>width$}  ") };
        }
        text.push_str(row.trim_end());
        text.push('\n');
    }
    text
}

fn markdown(lines: &[Vec<String>], names: usize) -> String {
    let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let columns = lines.first().map_or(0, Vec::len);
    let rule = row((0..columns).map(|column| if column < names { "---" } else { "---:" }.to_owned()).collect());
    let cells = |line: &Vec<String>| -> Vec<String> {
        let cell = |column| line.get(column).map_or("", |cell: &String| cell.trim());
        (0..columns).map(|column| cell(column).replace('\\', "\\\\").replace('|', "\\|")).collect()
    };
    let mut rows: Vec<String> = lines.iter().map(|line| row(cells(line))).collect();
    rows.insert(rows.len().min(1), rule);
    rows.concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines() -> Vec<Vec<String>> {
        vec![header("name|n"), vec!["a|b, \"c\"".into(), "12".into()], vec!["  short".into()]]
    }

    #[test]
    fn cells_cannot_break_a_table() {
        let markdown = "| name | n |\n| --- | ---: |\n| a\\|b, \"c\" | 12 |\n| short |  |\n";
        assert_eq!(Layout::Markdown.table(&lines(), 1), markdown);
        assert_eq!(Layout::Text.table(&lines(), 1), "name       n\na|b, \"c\"  12\n  short\n");
    }
}
