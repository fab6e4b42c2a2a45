//! Image files: PNG and OpenEXR.

use image::ImageEncoder;
use std::path::{Path, PathBuf};

use super::exr;
use super::rgb_image::Image;

/// A kind of image file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageFormat {
    /// 8 bits per channel, clamped to [0, 1], in the sRGB transfer function.
    Png,
    /// 32-bit floats, linear, nothing clamped.
    Exr,
}

impl ImageFormat {
    /// The endings of their files.
    pub const ENDINGS: [&'static str; 2] = ["png", "exr"];

    /// The format that a file's ending asks for: PNG where there is none; `None` for others.
    pub fn of(path: &Path) -> Option<Self> {
        let Some(ending) = path.extension() else { return Some(Self::Png) };
        match ending.to_string_lossy().to_lowercase().as_str() {
            "png" => Some(Self::Png),
            "exr" => Some(Self::Exr),
            _ => None,
        }
    }
}

/// An image that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot write the image: {source}", path.display())]
pub struct ImageError {
    pub path: PathBuf,
    pub source: image::ImageError,
}

impl Image {
    /// Writes the image in that format.
    ///
    /// # Errors
    /// [`ImageError`] naming the file.
    pub fn save(&self, path: &Path, format: ImageFormat) -> Result<(), ImageError> {
        let error = |source| ImageError { path: path.to_owned(), source };
        let bytes = match format {
            ImageFormat::Png => self.png().map_err(error)?,
            ImageFormat::Exr => exr::encode(self),
        };
        std::fs::write(path, bytes).map_err(|e| error(e.into()))
    }

    /// Writes an 8-bit PNG in the sRGB transfer function.
    ///
    /// # Errors
    /// [`ImageError`] naming the file.
    pub fn save_png(&self, path: &Path) -> Result<(), ImageError> {
        self.save(path, ImageFormat::Png)
    }

    /// Pixels in sRGB, row by row.
    pub fn rgb8(&self) -> Vec<[u8; 3]> {
        self.pixels.iter().map(|pixel| pixel.map(srgb)).collect()
    }

    /// The bytes of such a file.
    ///
    /// # Errors
    /// Those of the encoder.
    pub fn png(&self) -> Result<Vec<u8>, image::ImageError> {
        let bytes = self.rgb8().concat();
        let mut png = Vec::new();
        image::codecs::png::PngEncoder::new(&mut png).write_image(
            &bytes,
            self.width,
            self.height,
            image::ExtendedColorType::Rgb8,
        )?;
        Ok(png)
    }
}

/// IEC 61966-2-1, clamped; NaN becomes black.
fn srgb(x: f64) -> u8 {
    let x = if x > 0.0 { x.min(1.0) } else { 0.0 };
    let y = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    (y * 255.0 + 0.5) as u8
}
