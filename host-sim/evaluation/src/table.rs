//! Tables of results. A column has a key for programs (JSON, CSV) and a heading for people (text, Markdown). For
//! programs, every row has all columns, a column has values of one type, and an unknown value is null or empty.

use clap::ValueEnum;
use serde::{Serialize, Serializer};
use serde_json::Value;
use smr_files::messages::choice_name;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Layout {
    /// Columns side by side
    #[default]
    Text,
    /// Tables in Markdown
    Markdown,
    /// One of the tables of --json (--part), with its keys as header
    Csv,
}

/// Names of the tables for programs (JSON, CSV); no command has all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TableName {
    /// Figures measured here, for each recording
    Measured,
    /// The starts of --robustness: where they are, and how many frames were correct
    Starts,
    /// Of each tracker over several recordings: means with their standard errors, or with --fault cover counts
    Means,
    /// Correct frames as the paper prints them
    Printed,
    /// Of --robustness: mean differences to another tracker, recording by recording
    Paired,
    /// Of --chip: the trackers, with their accuracy, time and memory
    Candidates,
    /// Of --chip: the choice
    Choice,
}

impl TableName {
    pub fn text(self) -> String {
        choice_name(&self)
    }
}

/// A column: key for programs, heading for people (either may be empty), count of decimals, and the value for a row.
pub type Column<T> = (&'static str, &'static str, usize, fn(&T) -> Value);

#[derive(Clone, Debug)]
pub struct Head {
    key: String,
    title: String,
    digits: usize,
}

impl Head {
    pub fn new(key: &str, title: &str, digits: usize) -> Self {
        Self { key: key.to_owned(), title: title.to_owned(), digits }
    }

    pub fn list(columns: &[(&str, &str)]) -> Vec<Self> {
        columns.iter().map(|(key, title)| Self::new(key, title, 0)).collect()
    }

    pub fn all<T>(columns: &[Column<T>]) -> Vec<Self> {
        columns.iter().map(|&(key, title, digits, _)| Self::new(key, title, digits)).collect()
    }

    pub fn hide(&mut self) {
        self.title.clear();
    }

    /// Creates columns that only JSON and CSV have: each of `keys`, followed by its standard error.
    pub fn with_errors<'a>(keys: impl IntoIterator<Item = &'a str>) -> Vec<Self> {
        keys.into_iter().flat_map(|key| [Self::new(key, "", 0), Self::error(key)]).collect()
    }

    pub fn error(key: &str) -> Self {
        Self::new(&format!("{key}_standard_error"), "", 0)
    }
}

/// Returns the cells of a row; all are unknown if `row` is `None`.
pub fn cells<T>(columns: &[Column<T>], row: Option<&T>) -> Vec<Value> {
    columns.iter().map(|(.., of)| row.map_or(Value::Null, of)).collect()
}

/// Returns an empty cell, for a row in which the column has no meaning.
pub fn blank() -> Value {
    "".into()
}

const UNKNOWN: &str = "-";

pub struct Table {
    /// Name in JSON and CSV; `None` for a table that only text and Markdown show.
    name: Option<TableName>,
    /// Number of leading columns aligned to the left; all others are aligned to the right.
    names: usize,
    heads: Vec<Head>,
    /// Flag and cells of each row; the flag is false if only text and Markdown show the row, not JSON and CSV.
    rows: Vec<(bool, Vec<Value>)>,
}

impl Table {
    pub fn new(name: impl Into<Option<TableName>>, names: usize, heads: Vec<Head>) -> Self {
        Self { name: name.into(), names, heads, rows: Vec::new() }
    }

    pub fn of<'a, T: 'a>(
        name: TableName,
        names: usize,
        columns: &[Column<T>],
        rows: impl IntoIterator<Item = &'a T>,
    ) -> Self {
        let rows = rows.into_iter().map(|row| (true, cells(columns, Some(row)))).collect();
        Self { rows, ..Self::new(name, names, Head::all(columns)) }
    }

    /// Adds `columns` to each row, with values from the row's entry in `parts`.
    pub fn and<T>(mut self, columns: &[Column<T>], parts: impl Iterator<Item = Option<T>>) -> Self {
        self.heads.extend(Head::all(columns));
        self.rows.iter_mut().zip(parts).for_each(|((_, row), part)| row.extend(cells(columns, part.as_ref())));
        self
    }

    pub fn row(&mut self, cells: Vec<Value>) {
        self.rows.push((true, cells));
    }

    /// Adds a row that only text and Markdown show. Trailing cells may be omitted if their columns have no heading.
    pub fn remark(&mut self, cells: Vec<Value>) {
        self.rows.push((false, cells));
    }

    fn keyed(&self) -> impl Iterator<Item = (usize, &str)> {
        self.heads.iter().map(|head| head.key.as_str()).enumerate().filter(|(_, key)| !key.is_empty())
    }

    fn for_programs(&self) -> impl Iterator<Item = &Vec<Value>> {
        self.rows.iter().filter_map(|(is_for_all, cells)| is_for_all.then_some(cells))
    }

    fn csv(&self) -> String {
        let line = |cells: Vec<String>| cells.iter().map(|cell| quoted(cell)).collect::<Vec<_>>().join(",") + "\n";
        let header = line(self.keyed().map(|(_, key)| key.to_owned()).collect());
        let row = |cells: &Vec<Value>| line(self.keyed().map(|(at, _)| text(&cells[at], "", None)).collect());
        std::iter::once(header).chain(self.for_programs().map(row)).collect()
    }

    /// Returns the table as text or Markdown; `None` if it has no row or no heading.
    fn text(&self, layout: Layout) -> Option<String> {
        let titled = || self.heads.iter().enumerate().filter(|(_, head)| !head.title.is_empty());
        let cell = |cells: &[Value], (at, head): (usize, &Head)| {
            cells.get(at).map_or(String::new(), |value| text(value, UNKNOWN, Some(head.digits)))
        };
        let rows = self.rows.iter().map(|(_, cells)| titled().map(|column| cell(cells, column)).collect());
        let header: Vec<String> = titled().map(|(_, head)| head.title.clone()).collect();
        if header.is_empty() || self.rows.is_empty() {
            return None;
        }
        let lines: Vec<Vec<String>> = std::iter::once(header).chain(rows).collect();
        Some(if layout == Layout::Markdown { markdown(&lines, self.names) } else { aligned(&lines, self.names) })
    }
}

/// Results of a command. The JSON is an object with one key for each named table; its value is an array of rows.
#[derive(Default)]
pub struct Tables {
    pub tables: Vec<Table>,
    /// Lines below the tables in text and Markdown.
    pub remarks: String,
}

impl Tables {
    fn find(&self, name: TableName) -> Option<&Table> {
        self.tables.iter().find(|table| table.name == Some(name))
    }

    /// Returns the columns of the table `name`, each with its values; none if there is no such table.
    pub fn columns(&self, name: TableName) -> impl Iterator<Item = (&str, Vec<&Value>)> {
        self.find(name).into_iter().flat_map(|table| {
            table.keyed().map(|(at, key)| (key, table.for_programs().map(|cells| &cells[at]).collect()))
        })
    }

    /// Returns a table as CSV (RFC 4180, but lines end with LF); `None` without such a table.
    pub fn csv(&self, name: TableName) -> Option<String> {
        self.find(name).map(Table::csv)
    }

    pub fn text(&self, layout: Layout) -> String {
        let mut parts: Vec<String> = self.tables.iter().filter_map(|table| table.text(layout)).collect();
        parts.extend(Some(self.remarks.clone()).filter(|remarks| !remarks.is_empty()));
        parts.join("\n")
    }
}

impl Serialize for Tables {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let named = self.tables.iter().filter_map(|table| Some((table.name?.text(), table)));
        serializer.collect_map(named.map(|(name, table)| {
            let rows = table.for_programs().map(|cells| KeyedCells { table, cells });
            (name, rows.collect::<Vec<_>>())
        }))
    }
}

/// Serialises a row as an object, with keys in the order of the columns.
struct KeyedCells<'a> {
    table: &'a Table,
    cells: &'a [Value],
}

impl Serialize for KeyedCells<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.table.keyed().map(|(at, key)| (key, &self.cells[at])))
    }
}

fn quoted(cell: &str) -> String {
    let needs_it = cell.contains([',', '"', '\n', '\r']);
    if needs_it { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_owned() }
}

/// Returns the value as text. Fractions have `digits` decimals, or all if `digits` is `None`.
fn text(value: &Value, unknown: &str, digits: Option<usize>) -> String {
    match (value, digits) {
        (Value::Null, _) => unknown.to_owned(),
        (Value::String(text), _) => text.clone(),
        (Value::Number(number), Some(digits)) if number.is_f64() => {
            number.as_f64().map_or_else(String::new, |number| format!("{number:.digits$}"))
        }
        (other, _) => other.to_string(),
    }
}

fn aligned(lines: &[Vec<String>], names: usize) -> String {
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..lines[0].len()).map(width).collect();
    let line = |line: &Vec<String>| {
        let cell = |(column, cell): (usize, &String)| {
            let width = widths[column];
            if column < names { format!("{cell:width$}  ") } else { format!("{cell:>width$}  ") }
        };
        line.iter().enumerate().map(cell).collect::<String>().trim_end().to_owned() + "\n"
    };
    lines.iter().map(line).collect()
}

fn markdown(lines: &[Vec<String>], names: usize) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let cell = |cell: &String| cell.trim().replace('\\', "\\\\").replace('|', "\\|");
    let rule = |column: usize| if column < names { "---" } else { "---:" }.to_owned();
    let mut rows: Vec<String> = lines.iter().map(|cells| line(cells.iter().map(cell).collect())).collect();
    rows.insert(1, line((0..lines[0].len()).map(rule).collect()));
    rows.concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    type Given = (Option<f64>, &'static str);

    const COLUMNS: &[Column<Given>] = &[
        ("a", "A", 2, |row| row.0.into()),
        ("", "twice", 0, |row| row.1.repeat(2).into()),
        ("b", "", 0, |row| row.1.into()),
    ];

    #[test]
    fn people_and_programs_read_the_same_columns() {
        let heads = [Head::all(COLUMNS), Head::with_errors(["d"])].concat();
        let mut tables = Tables { remarks: "no\n".to_owned(), ..Tables::default() };
        tables.tables.push(Table::new(TableName::Measured, 1, heads.clone()));
        for row in [(Some(1.0), "1,\"2\""), (None, "x|y")] {
            tables.tables[0].row([cells(COLUMNS, Some(&row)), vec![0.into(), 1.into()]].concat());
        }
        tables.tables[0].remark(vec!["  short".into()]);
        tables.tables.push(Table::new(TableName::Means, 1, heads));
        tables.tables.push(Table::new(None, 0, vec![Head::new("", "c", 0)]));
        tables.tables[2].row(cells(&[("", "", 0, |_: &()| 1.into())], None));
        let json = r#"{"measured":[{"a":1.0,"b":"1,\"2\"","d":0,"d_standard_error":1},{"a":null,"b":"x|y","d":0,"d_standard_error":1}],"means":[]}"#;
        assert_eq!(serde_json::to_string(&tables).unwrap(), json);
        let csv = tables.csv(TableName::Measured).unwrap();
        assert_eq!(csv, "a,b,d,d_standard_error\n1.0,\"1,\"\"2\"\"\",0,1\n,x|y,0,1\n");
        assert_eq!(tables.csv(TableName::Means).unwrap(), "a,b,d,d_standard_error\n");
        assert_eq!(tables.csv(TableName::Printed), None);
        let text = "A             twice\n1.00     1,\"2\"1,\"2\"\n-            x|yx|y\n  short\n\nc\n-\n\nno\n";
        assert_eq!(tables.text(Layout::Text), text);
        let markdown = "| A | twice |\n| --- | ---: |\n| 1.00 | 1,\"2\"1,\"2\" |\n| - | x\\|yx\\|y |\n| short |  |\n\n| c |\n| ---: |\n| - |\n\nno\n";
        assert_eq!(tables.text(Layout::Markdown), markdown);
        assert_eq!(Tables::default().text(Layout::Text), "");
        let columns: Vec<_> = tables.columns(TableName::Measured).map(|(key, values)| (key, values.len())).collect();
        assert_eq!(columns, [("a", 2), ("b", 2), ("d", 2), ("d_standard_error", 2)]);
    }
}
