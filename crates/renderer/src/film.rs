//! The image and its file.

use std::path::{Path, PathBuf};

/// Linear RGB image, row 0 at the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Pixels an image row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` colours, row by row.
    pub pixels: Vec<[f64; 3]>,
}

/// An image that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot write the image: {source}", path.display())]
pub struct ImageError {
    /// The file.
    pub path: PathBuf,
    /// Why.
    pub source: image::ImageError,
}

impl Image {
    /// Writes an 8-bit PNG in the sRGB transfer function.
    ///
    /// # Errors
    /// [`ImageError`] naming the file.
    pub fn save_png(&self, path: &Path) -> Result<(), ImageError> {
        let bytes: Vec<u8> = self.pixels.iter().flatten().map(|&x| srgb(x)).collect();
        image::save_buffer_with_format(
            path,
            &bytes,
            self.width,
            self.height,
            image::ColorType::Rgb8,
            image::ImageFormat::Png,
        )
        .map_err(|source| ImageError { path: path.to_owned(), source })
    }
}

/// IEC 61966-2-1, clamped; NaN becomes black.
fn srgb(x: f64) -> u8 {
    let x = if x > 0.0 { x.min(1.0) } else { 0.0 };
    let y = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    (y * 255.0 + 0.5) as u8
}
