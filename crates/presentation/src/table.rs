//! Tables before any markup: text and Markdown differ only in how they draw them.

/// Colour of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    Plain,
    Bad,
    /// The best of its column.
    Best,
    Dim,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cell {
    pub text: String,
    pub style: Style,
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self { text, style: Style::Plain }
    }
}

/// A table: the first column is text, the others are numbers.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Table {
    pub title: String,
    pub header: Vec<&'static str>,
    /// Cells, row by row.
    pub rows: Vec<Vec<Cell>>,
    pub notes: Vec<String>,
}

/// A table of texts.
pub fn words(
    title: impl Into<String>,
    header: Vec<&'static str>,
    rows: impl IntoIterator<Item = Vec<String>>,
) -> Table {
    let rows = rows.into_iter().map(|row| row.into_iter().map(Cell::from).collect());
    Table { title: title.into(), header, rows: rows.collect(), notes: Vec::new() }
}

/// Cell without a value.
pub fn dash() -> Cell {
    Cell { text: "-".into(), style: Style::Dim }
}
