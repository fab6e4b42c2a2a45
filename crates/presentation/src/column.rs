//! A column of results: what it is called, what it holds and how that is written, in every format.
//! Text, Markdown and HTML show cells, CSV has fields; all of them come from one line per column.

use std::borrow::Borrow;

use statistics::estimate::Estimate;

use crate::csv::{number, written};
use crate::json::FormatError;
use crate::numbers;
use crate::table::{Cell, Table, dash};

/// Value of a row in a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    None,
    Text(String),
    Count(u64),
    Real(f64),
    /// A measurement with its interval.
    Measured(Estimate),
}

impl Value {
    /// A value, where there is one.
    pub fn of<T>(value: Option<T>, make: fn(T) -> Self) -> Self {
        value.map_or(Self::None, make)
    }
}

/// The unit of a column, and so the form of its numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// None: counts whole, other numbers short.
    None,
    PerRay,
    /// Seconds; milliseconds in tables.
    Seconds,
    /// Bytes; MiB in tables.
    Bytes,
    /// A ratio with its interval.
    Ratio,
}

/// A column over rows of a type.
pub struct Column<R> {
    /// In CSV; of what has an interval there its ends, too.
    pub keys: &'static [&'static str],
    /// In tables; empty for what is in none.
    pub head: &'static str,
    pub unit: Unit,
    pub of: fn(&R) -> Value,
    /// Text that tables show instead of the value, if any.
    pub instead: fn(&R) -> Option<Cell>,
    /// Numbers have all their digits in CSV.
    pub is_exact: bool,
}

impl<R> Column<R> {
    pub const fn new(
        keys: &'static [&'static str],
        head: &'static str,
        unit: Unit,
        of: fn(&R) -> Value,
    ) -> Self {
        Self { keys, head, unit, of, instead: |_| None, is_exact: false }
    }

    /// The same with something in its place in tables.
    #[must_use]
    pub const fn or(self, instead: fn(&R) -> Option<Cell>) -> Self {
        Self { instead, ..self }
    }

    /// The same with all digits of its numbers in CSV.
    #[must_use]
    pub const fn exact(self) -> Self {
        Self { is_exact: true, ..self }
    }

    pub fn cell(&self, row: &R) -> Cell {
        (self.instead)(row).unwrap_or_else(|| self.value_cell(row))
    }

    /// The cell of a row, nothing in its place.
    pub fn value_cell(&self, row: &R) -> Cell {
        match ((self.of)(row), self.unit) {
            (Value::None, _) => dash(),
            (Value::Text(text), _) => text.into(),
            (Value::Count(n), Unit::Bytes) => numbers::mebibytes(n).into(),
            (Value::Count(n), _) => n.to_string().into(),
            (Value::Real(x), Unit::PerRay) => format!("{x:.2}").into(),
            (Value::Real(x), Unit::Seconds) => numbers::milliseconds(x).into(),
            (Value::Real(x), _) => numbers::short(x).into(),
            (Value::Measured(x), Unit::Ratio) => numbers::ratio(&x).into(),
            (Value::Measured(x), Unit::Seconds) => numbers::milliseconds(x.median).into(),
            (Value::Measured(x), _) => numbers::short(x.median).into(),
        }
    }

    /// The fields of a row in CSV, one for each key.
    pub fn fields(&self, row: &R) -> impl Iterator<Item = String> {
        let number = |x: f64| match self.unit {
            _ if self.is_exact => x.to_string(),
            Unit::PerRay => format!("{x:.6}"),
            _ => number(Some(x)),
        };
        let fields = match (self.of)(row) {
            Value::None => Vec::new(),
            Value::Text(text) => vec![text],
            Value::Count(n) => vec![n.to_string()],
            Value::Real(x) => vec![number(x)],
            Value::Measured(x) => [x.median, x.low, x.high].map(number).into(),
        };
        fields.into_iter().chain(std::iter::repeat(String::new())).take(self.keys.len())
    }
}

/// The keys of columns in CSV, in their order.
pub fn keys<R>(columns: &[Column<R>]) -> impl Iterator<Item = &'static str> {
    columns.iter().flat_map(|column| column.keys.iter().copied())
}

/// The fields of a row in CSV, one for each of [`keys`].
pub fn fields<'a, R>(columns: &'a [Column<R>], row: &'a R) -> impl Iterator<Item = String> + 'a {
    columns.iter().flat_map(move |column| column.fields(row))
}

/// The heads of the columns that tables have, in their order.
pub fn heads<R>(columns: &[Column<R>]) -> Vec<&'static str> {
    columns.iter().map(|column| column.head).filter(|head| !head.is_empty()).collect()
}

pub fn headed<'c, R>(columns: &'c [Column<R>], head: &str) -> Option<&'c Column<R>> {
    columns.iter().find(|column| column.head == head)
}

/// Rows as CSV, the keys above them.
pub fn csv<R>(
    columns: &[Column<R>],
    rows: impl IntoIterator<Item: Borrow<R>>,
) -> Result<String, FormatError> {
    written(|writer| {
        writer.write_record(keys(columns))?;
        rows.into_iter().try_for_each(|row| writer.write_record(fields(columns, row.borrow())))
    })
}

/// A table of the columns with these heads, no title above it and no notes below.
pub fn table<R>(
    columns: &[Column<R>],
    heads: &[&'static str],
    rows: impl IntoIterator<Item: Borrow<R>>,
) -> Table {
    let shown: Vec<_> = heads.iter().filter_map(|head| headed(columns, head)).collect();
    let cells = |row: &R| shown.iter().map(|column| column.cell(row)).collect();
    Table {
        header: shown.iter().map(|column| column.head).collect(),
        rows: rows.into_iter().map(|row| cells(row.borrow())).collect(),
        ..Table::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_gives_the_cell_and_the_csv_fields() {
        type Row = Option<Estimate>;
        let keys: &[&str] = &["time_s", "time_s_low", "time_s_high"];
        let of = |row: &Row| Value::of(*row, Value::Measured);
        let time = Column::new(keys, "ms", Unit::Seconds, of);
        let row = Some(Estimate { median: 0.0025, low: 0.002, high: 0.003 });
        assert_eq!(time.cell(&row).text, "2.50");
        let fields: Vec<String> = time.fields(&row).collect();
        assert_eq!(fields, ["0.002500000", "0.002000000", "0.003000000"]);
        assert_eq!((time.cell(&None), time.fields(&None).count()), (dash(), 3));
        let said = time.or(|row| row.is_none().then(|| "wrong".to_owned().into()));
        assert_eq!((said.cell(&None).text, said.value_cell(&None)), ("wrong".to_owned(), dash()));
        assert_eq!(said.cell(&row).text, "2.50");
    }

    #[test]
    fn units_are_the_form_of_numbers() {
        let show = |unit, value: fn(&()) -> Value| {
            let column = Column::new(&["x"], "x", unit, value);
            (column.cell(&()).text, column.fields(&()).next().unwrap())
        };
        let pair = |a: &str, b: &str| (a.to_owned(), b.to_owned());
        assert_eq!(show(Unit::Bytes, |()| Value::Count(3 << 19)), pair("1.50", "1572864"));
        assert_eq!(show(Unit::None, |()| Value::Count(7)), pair("7", "7"));
        assert_eq!(show(Unit::PerRay, |()| Value::Real(1.5)), pair("1.50", "1.500000"));
        assert_eq!(show(Unit::None, |()| Value::Real(0.5)), pair("0.50", "0.500000000"));
        let exact = Column::new(&["x"], "", Unit::Seconds, |()| Value::Real(1.5e-10)).exact();
        assert_eq!(exact.fields(&()).collect::<Vec<_>>(), ["0.00000000015"]);
    }

    #[test]
    fn tables_have_heads_in_any_order_and_csv_has_all_keys() {
        let text = |row: &u64| Value::Text(format!("row {row}"));
        let columns = [
            Column::new(&["n"], "N", Unit::None, |row| Value::Count(*row)),
            Column::new(&["name"], "what", Unit::None, text),
            Column::new(&["hidden"], "", Unit::None, |_| Value::None),
        ];
        assert_eq!(csv(&columns, [1, 2]).unwrap(), "n,name,hidden\n1,row 1,\n2,row 2,\n");
        assert_eq!(heads(&columns), ["N", "what"]);
        let table = table(&columns, &["what", "N"], [&3]);
        assert_eq!(table.header, ["what", "N"]);
        assert_eq!(table.rows, [["row 3".to_owned().into(), "3".to_owned().into()]]);
    }
}
