//! The image that tracers draw.

/// Linear RGB image, row 0 at the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Pixels per row.
    pub width: u32,
    pub height: u32,
    /// `width * height` colours, row by row.
    pub pixels: Vec<[f64; 3]>,
}
