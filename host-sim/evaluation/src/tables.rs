//! What was measured as tables. [`Columns`] say what stands in one, once: for programs (JSON, CSV) and for people (text, Markdown). For programs
//! every row has the same columns, and a column has one type; what is not known is null in JSON and empty in CSV.

use super::Layout;
use super::layout::NOTHING;
use clap::ValueEnum;
use serde::{Serialize, Serializer};
use serde_json::Value;
use smr_recordings::messages::choice_name;

/// The tables that there are; no command has all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TableName {
    /// What was measured here, in each recording
    Measured,
    /// The starts of --robustness: where they are, and how many frames were correct
    Starts,
    /// Of each tracker over several recordings: means with their standard errors, or with --covered counts
    Means,
    /// Correct frames as the paper prints them
    Printed,
    /// Of --robustness: mean differences to another tracker, recording by recording
    Paired,
}

impl TableName {
    /// As on the command line, and its key in JSON.
    pub fn text(self) -> String {
        choice_name(&self)
    }
}

/// The columns of a table with a row for each `T`.
pub struct Columns<'a, T>(Vec<Column<'a, T>>);

struct Column<'a, T> {
    /// In JSON and CSV; empty if it is for people alone.
    key: String,
    /// For people; empty if it is for programs alone.
    title: &'static str,
    of: Box<dyn Fn(&T) -> Value + 'a>,
}

/// A column as it is listed: its key, its title, and what stands in it.
pub type Listed<T> = (&'static str, &'static str, fn(&T) -> Value);

impl<'a, T: 'a> Columns<'a, T> {
    pub fn new(list: &[Listed<T>]) -> Self {
        Self(list.iter().map(|&(key, title, of)| Column { key: key.to_owned(), title, of: Box::new(of) }).collect())
    }

    /// Then those of a `part` of the row; null where there is none.
    pub fn and<U: 'a>(mut self, more: Columns<'a, U>, part: fn(&T) -> Option<&U>) -> Self {
        let column = |Column { key, title, of }: Column<'a, U>| {
            let of = Box::new(move |row: &T| part(row).map_or(Value::Null, &of));
            Column { key, title, of: of as Box<dyn Fn(&T) -> Value> }
        };
        self.0.extend(more.0.into_iter().map(column));
        self
    }

    /// Then one for each of `keys`, for programs alone; `of` is told its place among them.
    pub fn each(mut self, keys: impl IntoIterator<Item = String>, of: fn(&T, usize) -> Value) -> Self {
        let column = |(place, key)| Column { key, title: "", of: Box::new(move |row: &T| of(row, place)) };
        self.0.extend(keys.into_iter().enumerate().map(column));
        self
    }

    /// For programs.
    pub fn table<'b>(&self, name: TableName, rows: impl IntoIterator<Item = &'b T>) -> Table
    where
        T: 'b,
    {
        let columns = || self.0.iter().filter(|column| !column.key.is_empty());
        let row = |row| columns().map(|column| (column.of)(row)).collect();
        Table {
            name,
            columns: columns().map(|column| column.key.clone()).collect(),
            rows: rows.into_iter().map(row).collect(),
        }
    }

    /// For people. The first `names` columns begin at their left edge.
    pub fn text(&self, rows: &[T], layout: Layout, names: usize) -> String {
        let columns = || self.0.iter().filter(|column| !column.title.is_empty());
        let line = |row| columns().map(|column| text(&(column.of)(row), NOTHING)).collect();
        let titles = columns().map(|column| column.title.to_owned()).collect();
        layout.table(&std::iter::once(titles).chain(rows.iter().map(line)).collect::<Vec<_>>(), names)
    }
}

/// The column of the standard error of what is in the column `name`.
pub fn error_of(name: &str) -> String {
    format!("{name}_standard_error")
}

/// Each of `names`, and its standard error after it.
pub fn with_errors<'a>(names: impl IntoIterator<Item = &'a str>) -> impl Iterator<Item = String> {
    names.into_iter().flat_map(|name| [name.to_owned(), error_of(name)])
}

/// What a command measured: in JSON an object with an array of objects for each table.
pub struct Tables(pub Vec<Table>);

pub struct Table {
    name: TableName,
    columns: Vec<String>,
    rows: Vec<Vec<Value>>,
}

impl Table {
    fn csv(&self) -> String {
        let lines = std::iter::once(csv_line(self.columns.iter().cloned()));
        lines.chain(self.rows.iter().map(|row| csv_line(row.iter().map(|value| text(value, ""))))).collect()
    }
}

impl Tables {
    /// The columns of the table `name`, each with its values; none if there is no such table.
    pub fn columns(&self, name: TableName) -> impl Iterator<Item = (&str, Vec<&Value>)> {
        let table = self.0.iter().find(move |table| table.name == name);
        table.into_iter().flat_map(|table| {
            let values = |column: usize| table.rows.iter().map(|row| &row[column]).collect();
            table.columns.iter().enumerate().map(move |(column, name)| (name.as_str(), values(column)))
        })
    }

    /// The table `name` as CSV, by RFC 4180 but with the line ends of all other output; `None` if there is no such table.
    pub fn csv(&self, name: TableName) -> Option<String> {
        self.0.iter().find(|table| table.name == name).map(Table::csv)
    }
}

impl Serialize for Tables {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|table| (table.name.text(), table.rows())))
    }
}

impl Table {
    fn rows(&self) -> Vec<Row<'_>> {
        self.rows.iter().map(|values| Row { columns: &self.columns, values }).collect()
    }
}

/// A row as an object, with its keys in the order of the columns.
struct Row<'a> {
    columns: &'a [String],
    values: &'a [Value],
}

impl Serialize for Row<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.columns.iter().zip(self.values))
    }
}

fn csv_line(cells: impl Iterator<Item = String>) -> String {
    let cell = |cell: String| {
        let quoted = cell.contains([',', '"', '\n', '\r']);
        if quoted { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell }
    };
    cells.map(cell).collect::<Vec<_>>().join(",") + "\n"
}

fn text(value: &Value, nothing: &str) -> String {
    match value {
        Value::Null => nothing.to_owned(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_and_programs_read_the_same_columns() {
        type Row = (Option<f64>, &'static str);
        let part = Columns::new(&[("c", "", |text: &&str| (*text).into())]);
        let columns =
            Columns::new(&[("a", "A", |row: &Row| row.0.into()), ("", "twice", |row| row.1.repeat(2).into())]);
        let columns = columns.and(part, |row| row.0.map(|_| &row.1)).each(with_errors(["d"]), |_, place| place.into());
        let rows = [(Some(1.0), "1,\"2\""), (None, "x")];
        let tables = Tables(vec![columns.table(TableName::Measured, &rows), columns.table(TableName::Means, [])]);
        let text = serde_json::to_string(&tables).unwrap();
        let expected = r#"{"measured":[{"a":1.0,"c":"1,\"2\"","d":0,"d_standard_error":1},{"a":null,"c":null,"d":0,"d_standard_error":1}],"means":[]}"#;
        assert_eq!(text, expected);
        let csv = tables.csv(TableName::Measured).unwrap();
        assert_eq!(csv, "a,c,d,d_standard_error\n1.0,\"1,\"\"2\"\"\",0,1\n,,0,1\n");
        assert_eq!(tables.csv(TableName::Means).unwrap(), "a,c,d,d_standard_error\n");
        assert_eq!(tables.csv(TableName::Printed), None);
        let expected = "A         twice\n1.0  1,\"2\"1,\"2\"\n-            xx\n";
        assert_eq!(columns.text(&rows, Layout::Text, 1), expected);
    }
}
