//! Images and their files: PNG, and OpenEXR of three channels of 32-bit floats in uncompressed
//! scanlines.
//!
//! Format: "OpenEXR File Layout", Academy Software Foundation, version 2 of the file format. This
//! is the simplest of its forms, which every reader must know. Crate `exr` 1.74 writes it too, but
//! brings nine more crates, which compile for 16 seconds of one core; this writer is a page.

use std::path::{Path, PathBuf};

use image::ImageEncoder;

/// Linear RGB image, row 0 at the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Pixels per row.
    pub width: u32,
    pub height: u32,
    /// `width * height` colours, row by row.
    pub pixels: Vec<[f64; 3]>,
}

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
            ImageFormat::Exr => exr(self),
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

const MAGIC: u32 = 20_000_630;
const VERSION: u32 = 2;
const FLOAT: i32 = 2;
/// Channels must be in alphabetical order; each with its place in a colour.
const CHANNELS: [(&[u8; 2], usize); 3] = [(b"B\0", 2), (b"G\0", 1), (b"R\0", 0)];

/// The bytes of an OpenEXR file; colours stay linear and are rounded to 32 bits.
fn exr(image: &Image) -> Vec<u8> {
    let (width, height) = (image.width as usize, image.height as usize);
    let mut out = Vec::with_capacity(512 + height * (16 + 12 * width));
    out.extend(MAGIC.to_le_bytes());
    out.extend(VERSION.to_le_bytes());
    exr_header(image, &mut out);
    let block = 8 + 12 * width;
    let first = out.len() + 8 * height;
    for y in 0..height {
        out.extend(((first + y * block) as u64).to_le_bytes());
    }
    for (y, row) in image.pixels.chunks(width.max(1)).enumerate() {
        out.extend((y as i32).to_le_bytes());
        out.extend((12 * width as u32).to_le_bytes());
        for (_, k) in CHANNELS {
            out.extend(row.iter().flat_map(|color| (color[k] as f32).to_le_bytes()));
        }
    }
    out
}

fn exr_header(image: &Image, out: &mut Vec<u8>) {
    let mut channels = Vec::new();
    for (name, _) in CHANNELS {
        channels.extend(name);
        channels.extend(FLOAT.to_le_bytes());
        // not perceptually linear, three reserved bytes
        channels.extend([0; 4]);
        // every pixel has a sample
        channels.extend([1_i32, 1].map(i32::to_le_bytes).as_flattened());
    }
    channels.push(0);
    let last = [image.width, image.height].map(|n| n.saturating_sub(1) as i32);
    let window = [0, 0, last[0], last[1]].map(i32::to_le_bytes);
    let one = 1.0_f32.to_le_bytes();
    for (name, kind, value) in [
        ("channels", "chlist", &channels[..]),
        ("compression", "compression", &[0]),
        ("dataWindow", "box2i", window.as_flattened()),
        ("displayWindow", "box2i", window.as_flattened()),
        ("lineOrder", "lineOrder", &[0]),
        ("pixelAspectRatio", "float", &one),
        ("screenWindowCenter", "v2f", &[0; 8]),
        ("screenWindowWidth", "float", &one),
    ] {
        for text in [name, kind] {
            out.extend(text.as_bytes());
            out.push(0);
        }
        out.extend((value.len() as u32).to_le_bytes());
        out.extend(value);
    }
    out.push(0);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image() -> Image {
        let value = |i: u32| f64::from(i) * 0.125 - 1.0;
        // negative, above 1, and too small for 16 bits: nothing is clamped
        let pixels = (0..15).map(|i| [value(i), value(i) * 1e-9, value(i) * 1000.0]).collect();
        Image { width: 5, height: 3, pixels }
    }

    fn number(bytes: &[u8], at: usize) -> Option<usize> {
        let word = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes(word.try_into().ok()?) as usize)
    }

    /// Follows the layout from the beginning; `None` where the file breaks it.
    fn decoded(bytes: &[u8]) -> Option<(Vec<String>, Vec<[f32; 3]>)> {
        if number(bytes, 0)? != 20_000_630 || number(bytes, 4)? != 2 {
            return None;
        }
        let (mut at, mut names, mut size) = (8, Vec::new(), [0; 2]);
        while *bytes.get(at)? != 0 {
            let mut text = || {
                let end = at + bytes[at..].iter().position(|b| *b == 0)?;
                let text = String::from_utf8(bytes[at..end].to_vec()).ok();
                at = end + 1;
                text
            };
            names.push(text()?);
            text()?;
            let length = number(bytes, at)?;
            if names.last()? == "dataWindow" {
                size = [number(bytes, at + 12)? + 1, number(bytes, at + 16)? + 1];
            }
            at += 4 + length;
        }
        at += 1;
        let mut pixels = vec![[0.0; 3]; size[0] * size[1]];
        for y in 0..size[1] {
            let row = number(bytes, at + 8 * y)?;
            if number(bytes, row)? != y || number(bytes, row + 4)? != 12 * size[0] {
                return None;
            }
            for (channel, k) in [2, 1, 0].into_iter().enumerate() {
                for x in 0..size[0] {
                    let bits = number(bytes, row + 8 + 4 * (channel * size[0] + x))? as u32;
                    pixels[y * size[0] + x][k] = f32::from_bits(bits);
                }
            }
        }
        Some((names, pixels))
    }

    #[test]
    fn the_file_follows_the_layout_and_holds_the_floats() {
        // crate `exr` 1.74.2 read this very image back, too (2026-11-21)
        let image = image();
        let bytes = exr(&image);
        let (names, pixels) = decoded(&bytes).unwrap();
        assert_eq!(names.len(), 8);
        assert!(names.is_sorted() && names[0] == "channels");
        let expected: Vec<[f32; 3]> = image.pixels.iter().map(|c| c.map(|x| x as f32)).collect();
        assert_eq!(pixels, expected);
        // planted faults: a file that was cut off, an offset that is wrong by one
        assert!(decoded(&bytes[..bytes.len() - 1]).is_none());
        let mut planted = bytes.clone();
        let table = bytes.len() - 3 * (8 + 12 * 5) - 8 * 3;
        planted[table] += 1;
        assert!(decoded(&planted).is_none());
    }

    #[test]
    fn endings_choose_the_format() {
        let of = |name: &str| ImageFormat::of(std::path::Path::new(name));
        assert_eq!(of("a.EXR"), Some(ImageFormat::Exr));
        assert_eq!(of("a.png"), Some(ImageFormat::Png));
        assert_eq!(of("a"), Some(ImageFormat::Png));
        assert_eq!(of("a.jpg"), None);
    }
}
