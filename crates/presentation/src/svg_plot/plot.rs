//! What is plotted.

/// Width of a figure, in pixels.
pub const WIDTH: f64 = 900.0;

/// A panel of a figure.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Plot {
    pub title: String,
    /// Below the title, small.
    pub subtitle: String,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
    pub marks: Vec<Mark>,
    /// Legend of marks that belong to no series.
    pub marks_name: String,
    /// Horizontal lines to compare with.
    pub levels: Vec<Level>,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct Axis {
    /// Quantity with its unit.
    pub label: String,
    /// Form in which it is shown.
    pub scale: Scale,
}

/// How an axis maps numbers to places. Its ends follow from what is plotted.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Scale {
    /// Equal differences, equal lengths.
    #[default]
    Linear,
    /// The same, from zero.
    FromZero,
    /// Equal ratios, equal lengths; what is not above zero has no place.
    Log,
    /// Words at 0, 1, 2...
    Words(Vec<String>),
}

#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    pub name: String,
    /// Its points, in the order in which they are joined.
    pub points: Vec<Point>,
    /// Lines between the points.
    pub is_joined: bool,
}

/// A point with an error bar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Place on the horizontal axis.
    pub x: f64,
    /// Place on the vertical axis.
    pub y: f64,
    /// Lower end of the error bar.
    pub low: f64,
    /// Upper end of the error bar.
    pub high: f64,
}

/// A point that is pointed out.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    pub point: Point,
    /// The label; may be empty.
    pub label: String,
    /// Shown while a pointer is over the point; may be empty.
    pub hover: String,
    /// The ring around it.
    pub ring: Ring,
    /// The point is one of a series and drawn with it.
    pub is_in_series: bool,
}

/// A ring around a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ring {
    None,
    Best,
    /// Dashed: as good as the best.
    AsGood,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// Place on the vertical axis.
    pub y: f64,
    pub label: String,
}
