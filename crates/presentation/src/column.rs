//! A column of results: what it is called, what it holds and how that is written, in every format.
//! Text, Markdown and HTML show cells, CSV has fields; all of them come from one line per column.

use statistics::estimate::Estimate;

use crate::csv::{estimate, number};
use crate::numbers;
use crate::table::{Cell, dash};

/// What a row has in a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Nothing.
    None,
    /// Words.
    Text(String),
    /// What is counted.
    Count(u64),
    /// A number.
    Real(f64),
    /// What is measured, with its interval.
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
    /// Something per ray.
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
    /// Unit.
    pub unit: Unit,
    /// What a row has.
    pub of: fn(&R) -> Value,
    /// What tables show in its place, for rows that have something else to say.
    pub instead: fn(&R) -> Option<Cell>,
}

impl<R> Column<R> {
    /// A column.
    pub const fn new(
        keys: &'static [&'static str],
        head: &'static str,
        unit: Unit,
        of: fn(&R) -> Value,
    ) -> Self {
        Self { keys, head, unit, of, instead: |_| None }
    }

    /// The same with something in its place in tables.
    #[must_use]
    pub const fn or(self, instead: fn(&R) -> Option<Cell>) -> Self {
        Self { instead, ..self }
    }

    /// The cell of a row.
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
        let fields = match (self.of)(row) {
            Value::None => Vec::new(),
            Value::Text(text) => vec![text],
            Value::Count(n) => vec![n.to_string()],
            Value::Real(x) if self.unit == Unit::PerRay => vec![format!("{x:.6}")],
            Value::Real(x) => vec![number(Some(x))],
            Value::Measured(x) => estimate(Some(x)).into(),
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

/// The column with that head.
pub fn headed<'c, R>(columns: &'c [Column<R>], head: &str) -> Option<&'c Column<R>> {
    columns.iter().find(|column| column.head == head)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_gives_the_cell_and_the_fields() {
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
    }
}
