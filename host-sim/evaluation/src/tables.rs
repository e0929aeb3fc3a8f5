//! Figures as flat tables, for JSON and CSV. In a table every row has the same columns, and a column has one type; what is not known is null
//! in JSON and empty in CSV.

use anyhow::Result;
use clap::ValueEnum;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::Value;

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
    /// Of --robustness: frames and correct frames by the confidence that was reported
    Calibration,
}

impl TableName {
    /// As on the command line, and its key in JSON.
    pub fn text(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

/// What a command measured: in JSON an object with an array of objects for each table.
pub struct Tables(pub Vec<Table>);

/// One table.
pub struct Table {
    name: TableName,
    columns: Vec<String>,
    rows: Vec<Vec<Value>>,
}

impl Table {
    /// Of each row the values of these columns. What is nested, such as the options of a tracker, becomes a text: its JSON.
    pub fn new(name: TableName, columns: Vec<String>, rows: &[impl Serialize]) -> Result<Self> {
        let row = |row| -> Result<Vec<Value>> {
            let row = serde_json::to_value(row)?;
            Ok(columns.iter().map(|column| flat(&row[column])).collect())
        };
        let rows = rows.iter().map(row).collect::<Result<_>>()?;
        Ok(Self { name, columns, rows })
    }

    fn csv(&self) -> String {
        let lines = std::iter::once(csv_line(self.columns.iter().cloned()));
        lines.chain(self.rows.iter().map(|row| csv_line(row.iter().map(csv_cell)))).collect()
    }
}

/// Names of columns, with commas between them.
pub fn columns(names: &str) -> Vec<String> {
    names.split(',').map(str::to_owned).collect()
}

/// The column of the standard error of what is in the column `name`.
pub fn error_of(name: &str) -> String {
    format!("{name}_standard_error")
}

fn flat(value: &Value) -> Value {
    match value {
        Value::Object(_) | Value::Array(_) => value.to_string().into(),
        other => other.clone(),
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
    #[must_use]
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
        let mut map = serializer.serialize_map(Some(self.columns.len()))?;
        for (column, value) in self.columns.iter().zip(self.values) {
            map.serialize_entry(column, value)?;
        }
        map.end()
    }
}

fn csv_line(cells: impl Iterator<Item = String>) -> String {
    let cell = |cell: String| {
        let quoted = cell.contains([',', '"', '\n', '\r']);
        if quoted { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell }
    };
    cells.map(cell).collect::<Vec<_>>().join(",") + "\n"
}

fn csv_cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn rows_are_flat_and_have_all_columns() {
        let rows = [json!({ "b": { "x": "y" }, "a": 1.0, "c": "1,\"2\"" }), json!({ "a": null, "more": 1 })];
        let table = Table::new(TableName::Measured, columns("a,b,c"), &rows).unwrap();
        let tables = Tables(vec![table, Table::new(TableName::Means, columns("a"), &[0; 0]).unwrap()]);
        let text = serde_json::to_string(&tables).unwrap();
        let expected =
            r#"{"measured":[{"a":1.0,"b":"{\"x\":\"y\"}","c":"1,\"2\""},{"a":null,"b":null,"c":null}],"means":[]}"#;
        assert_eq!(text, expected);
        let csv = tables.csv(TableName::Measured).unwrap();
        assert_eq!(csv, "a,b,c\n1.0,\"{\"\"x\"\":\"\"y\"\"}\",\"1,\"\"2\"\"\"\n,,\n");
        assert_eq!(tables.csv(TableName::Means).unwrap(), "a\n");
        assert_eq!(tables.csv(TableName::Printed), None);
    }
}
