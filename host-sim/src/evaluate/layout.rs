//! How tables are written: for a terminal, as Markdown, or as CSV.

use super::aligned;
use clap::ValueEnum;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Layout {
    /// Columns side by side
    #[default]
    Text,
    /// The same tables in Markdown
    Markdown,
    /// One table: the objects of --json, one a line, with their keys as header
    Csv,
}

impl Layout {
    /// A table with a header, of which the first `names` columns begin at their left edge.
    pub(super) fn table(self, lines: &[Vec<String>], names: usize) -> String {
        match self {
            Self::Text => aligned(lines, names),
            Self::Markdown => markdown(lines, names),
            Self::Csv => lines.iter().map(|line| csv_line(line)).collect(),
        }
    }
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

/// By RFC 4180, but with the line ends of all other output.
fn csv_line(cells: &[String]) -> String {
    let cell = |cell: &String| {
        let quoted = cell.contains([',', '"', '\n', '\r']);
        if quoted { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.clone() }
    };
    cells.iter().map(cell).collect::<Vec<_>>().join(",") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines() -> Vec<Vec<String>> {
        vec![vec!["name".into(), "n".into()], vec!["a|b, \"c\"".into(), "12".into()], vec!["  short".into()]]
    }

    #[test]
    fn cells_cannot_break_a_table() {
        let markdown = "| name | n |\n| --- | ---: |\n| a\\|b, \"c\" | 12 |\n| short |  |\n";
        assert_eq!(Layout::Markdown.table(&lines(), 1), markdown);
        assert_eq!(Layout::Csv.table(&lines(), 1), "name,n\n\"a|b, \"\"c\"\"\",12\n  short\n");
        assert_eq!(Layout::Text.table(&lines(), 1), aligned(&lines(), 1));
    }
}
