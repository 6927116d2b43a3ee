//! One table in four forms.

use std::io;
#[cfg(not(test))]
use std::io::Write;

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
    /// A table for documents
    Markdown,
}

/// One value of a row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cell {
    Text(String),
    Count(u64),
    /// A number with this many decimals.
    Number(f64, usize),
    /// Unknown.
    Nothing,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Count(count as u64)
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<u32> for Cell {
    fn from(count: u32) -> Self {
        Self::Count(count.into())
    }
}

impl From<f64> for Cell {
    /// With two decimals.
    fn from(number: f64) -> Self {
        Self::Number(number, 2)
    }
}

impl<T: Into<Self>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Nothing, T::into)
    }
}

/// The values of a row, each with its column's title.
pub(crate) type Row = Vec<(String, Cell)>;

/// A [`Row`] of pairs of a title and a value that becomes a [`Cell`].
macro_rules! row {
    ($(($title:expr, $value:expr)),* $(,)?) => {
        vec![$((($title).to_string(), $crate::table::Cell::from($value))),*]
    };
}
pub(crate) use row;

/// Rows under titles, written as they come; JSON, and a document's notes, at the end.
#[derive(Debug)]
pub(crate) struct Table {
    form: Form,
    /// Width of each column, in characters; empty before the first row.
    widths: Vec<usize>,
    rows: Vec<Value>,
    /// Notes below a document's table.
    below: Vec<String>,
}

impl Table {
    /// Begins a table with a note of the `conditions` of measurement, for people.
    pub(crate) fn start(form: Form, conditions: &str) -> io::Result<Self> {
        let mut table = Self { form, widths: Vec::new(), rows: Vec::new(), below: Vec::new() };
        table.note(conditions)?;
        Ok(table)
    }

    /// Adds a row. All have the same titles, which stand above the first one.
    pub(crate) fn push(&mut self, row: Row) -> io::Result<()> {
        let is_first = self.widths.is_empty();
        if is_first {
            self.widths = row.iter().enumerate().map(|(column, (title, cell))| width(column, title, cell)).collect();
        }
        if self.form == Form::Json {
            self.rows.push(json_of(row));
            return Ok(());
        }
        let (titles, cells): (Vec<String>, Vec<Cell>) = row.into_iter().unzip();
        if is_first {
            let worded = |title: String| if self.form == Form::Markdown { title.replace('_', " ") } else { title };
            let titles: Vec<Cell> = titles.into_iter().map(|title| Cell::Text(worded(title))).collect();
            self.write_row(&titles)?;
            if self.form == Form::Markdown {
                write_line(format!("|{}", " --- |".repeat(titles.len())))?;
            }
        }
        self.write_row(&cells)
    }

    fn write_row(&self, cells: &[Cell]) -> io::Result<()> {
        write_line(match self.form {
            Form::Csv => separated(cells),
            Form::Markdown => barred(cells),
            Form::Table | Form::Json => self.aligned(cells),
        })
    }

    /// Writes a line between rows or below them, for people only. Nothing can stand between the rows of a document.
    pub(crate) fn note(&mut self, text: &str) -> io::Result<()> {
        match self.form {
            Form::Table => write_line(text),
            Form::Markdown if self.widths.is_empty() => write_line(format!("{text}\n")),
            Form::Markdown => {
                self.below.push(text.to_owned());
                Ok(())
            }
            Form::Csv | Form::Json => Ok(()),
        }
    }

    /// Writes notes below the table, a line each, and the rest of the table.
    pub(crate) fn finish(mut self, notes: &[&str]) -> io::Result<()> {
        notes.iter().try_for_each(|note| self.note(note))?;
        match self.form {
            Form::Json => write_line(format!("{:#}", Value::Array(self.rows))),
            Form::Markdown if !self.below.is_empty() => write_line(format!("\n{}", self.below.join("\n"))),
            _ => Ok(()),
        }
    }

    /// The first column is aligned to the left.
    fn aligned(&self, row: &[Cell]) -> String {
        let cells = self.widths.iter().zip(row).enumerate();
        let cells = cells.map(|(column, (&width, cell))| match (column, cell.text()) {
            (0, text) => format!("{text:<width$}"),
            (_, text) => format!(" {text:>width$}"),
        });
        cells.collect::<String>().trim_end().to_owned()
    }
}

/// A row's values by their titles.
pub(crate) fn json_of(row: Row) -> Value {
    Value::Object(row.into_iter().map(|(title, cell)| (title, cell.json())).collect::<Map<_, _>>())
}

/// Room for a title and for values like that of the first row.
fn width(column: usize, title: &str, cell: &Cell) -> usize {
    let values = match cell {
        _ if column == 0 => 28,
        Cell::Text(_) => 16,
        Cell::Count(_) | Cell::Nothing => 7,
        Cell::Number(..) => 8,
    };
    values.max(title.chars().count())
}

/// Writes a line to standard output, which may be closed.
#[cfg(not(test))]
fn write_line(text: impl AsRef<str>) -> io::Result<()> {
    writeln!(io::stdout(), "{}", text.as_ref())
}

#[cfg(test)]
thread_local! {
    /// Lines of the tables of a test.
    pub(crate) static WRITTEN: std::cell::RefCell<Vec<String>> = const { std::cell::RefCell::new(Vec::new()) };
}

#[cfg(test)]
fn write_line(text: impl AsRef<str>) -> io::Result<()> {
    WRITTEN.with_borrow_mut(|lines| lines.push(text.as_ref().to_owned()));
    Ok(())
}

/// A row of a document's table.
fn barred(row: &[Cell]) -> String {
    let cells = row.iter().map(|cell| format!(" {} |", cell.text().replace('|', "\\|")));
    format!("|{}", cells.collect::<String>())
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
        let table = Table { form: Form::Table, widths: vec![6, 7], rows: Vec::new(), below: Vec::new() };
        let row = ["a,\"b".into(), Cell::Number(1.25, 1)];
        assert_eq!(table.aligned(&row), "a,\"b       1.2");
        assert_eq!(separated(&row), "\"a,\"\"b\",1.2");
        assert_eq!(barred(&row), "| a,\"b | 1.2 |");
        assert_eq!(separated(&[Cell::Nothing, Cell::Count(7)]), ",7");
        assert_eq!(row![("ms", 1.25), ("none", None::<usize>)][1], ("none".to_owned(), Cell::Nothing));
    }
}
