//! One table in three forms.

use std::io::{self, Write};

use clap::ValueEnum;
use serde_json::{Map, Value, json};

/// How results are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Form {
    /// Columns for people
    Table,
    /// Comma-separated values
    Csv,
    /// JSON
    Json,
}

/// One value of a row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cell {
    Text(String),
    Count(u64),
    /// A number with as many decimals.
    Number(f64, usize),
    /// Not known.
    Nothing,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Count(count as u64)
    }
}

/// Titles, and widths in characters.
pub(crate) type Columns = &'static [(&'static str, usize)];

/// Rows under titles, written as they come; JSON at the end.
#[derive(Debug)]
pub(crate) struct Table {
    form: Form,
    columns: Columns,
    rows: Vec<Value>,
}

impl Table {
    /// Writes the head: for people, under which `conditions` was measured. Columns have titles, and widths in characters;
    /// the first is aligned to the left.
    pub(crate) fn start(form: Form, conditions: &str, columns: Columns) -> io::Result<Self> {
        let table = Self { form, columns, rows: Vec::new() };
        let titles: Vec<Cell> = columns.iter().map(|&(title, _)| title.into()).collect();
        table.note(conditions)?;
        match form {
            Form::Table => write_line(&table.aligned(&titles))?,
            Form::Csv => write_line(&separated(&titles))?,
            Form::Json => {}
        }
        Ok(table)
    }

    /// Adds a row, which has a value for each column.
    pub(crate) fn push(&mut self, row: &[Cell]) -> io::Result<()> {
        match self.form {
            Form::Table => write_line(&self.aligned(row)),
            Form::Csv => write_line(&separated(row)),
            Form::Json => {
                let pairs = self.columns.iter().zip(row).map(|(&(title, _), cell)| (title.to_owned(), cell.json()));
                self.rows.push(Value::Object(pairs.collect::<Map<_, _>>()));
                Ok(())
            }
        }
    }

    /// Writes a line between rows or below them, for people only.
    pub(crate) fn note(&self, text: &str) -> io::Result<()> {
        if self.form == Form::Table { write_line(text) } else { Ok(()) }
    }

    /// Writes notes below, a line each, and what is left.
    pub(crate) fn finish(self, notes: &[&str]) -> io::Result<()> {
        notes.iter().try_for_each(|note| self.note(note))?;
        if self.form == Form::Json { write_line(&format!("{:#}", Value::Array(self.rows))) } else { Ok(()) }
    }

    fn aligned(&self, row: &[Cell]) -> String {
        let cells = self.columns.iter().zip(row).enumerate();
        let cells = cells.map(|(column, (&(_, width), cell))| match (column, cell.text()) {
            (0, text) => format!("{text:<width$}"),
            (_, text) => format!(" {text:>width$}"),
        });
        cells.collect::<String>().trim_end().to_owned()
    }
}

/// Writes a line to standard output, which may be closed.
fn write_line(text: &str) -> io::Result<()> {
    writeln!(io::stdout(), "{text}")
}

fn separated(row: &[Cell]) -> String {
    let quoted = |cell: &Cell| {
        let text = cell.text();
        let needs_quotes = text.contains([',', '"', '\n']);
        if needs_quotes { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
    };
    row.iter().map(quoted).collect::<Vec<_>>().join(",")
}

impl Cell {
    fn text(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Count(count) => count.to_string(),
            Self::Number(number, decimals) => format!("{number:.decimals$}"),
            Self::Nothing => String::new(),
        }
    }

    fn json(&self) -> Value {
        match self {
            Self::Text(text) => json!(text),
            Self::Count(count) => json!(count),
            Self::Number(number, _) => json!(number),
            Self::Nothing => Value::Null,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_aligned_and_separated() {
        let table = Table { form: Form::Json, columns: &[("scene", 6), ("ms", 7)], rows: Vec::new() };
        let row = ["a,\"b".into(), Cell::Number(1.25, 1)];
        assert_eq!(table.aligned(&row), "a,\"b       1.2");
        assert_eq!(separated(&row), "\"a,\"\"b\",1.2");
        assert_eq!(separated(&[Cell::Nothing, Cell::Count(7)]), ",7");
    }
}
