//! Decoding of the images that materials refer to: PNG, through the crate `image`.
//!
//! All images of a scene share one budget of decoded bytes; it is checked against the header, so
//! that a small file that unpacks to much is refused before anything is unpacked. An image that
//! cannot be had is no error of the scene: loaders warn and keep the material's plain colour.

use std::collections::HashMap;
use std::io::Cursor;
use std::sync::Arc;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use crate::error::LoadError;
use crate::scene::{Scene, Warning};
use crate::texture::{Texture, Wrap};

/// The most bytes that all images of a scene may have once decoded: 512 MiB.
pub(crate) const BUDGET: u64 = 512 << 20;

/// Why an image is not shown.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TextureError {
    /// Its bytes cannot be had.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// It leads out of the folder of the file that names it.
    #[error("leads out of the folder; not read")]
    OutsideFolder,
    /// It is not of a format that is read.
    #[error("is no PNG image")]
    Format,
    /// The decoder refused it.
    #[error("is damaged: {0}")]
    Damaged(image::ImageError),
    /// It would not fit into the budget.
    #[error(
        "has {width} x {height} texels: {bytes} bytes decoded, but {left} of the {BUDGET} that the \
         images of a scene may have are left"
    )]
    OverBudget {
        /// Texels across.
        width: u32,
        /// Texels down.
        height: u32,
        /// Bytes once decoded.
        bytes: u64,
        /// Bytes of the budget that are left.
        left: u64,
    },
    /// The source says that the image is not as it stands.
    #[error("has options that are not read: {0}")]
    Options(String),
    /// What names the image is not as the format asks.
    #[error("has {0}")]
    Malformed(String),
}

/// An image in memory.
#[derive(Debug, Clone)]
pub(crate) struct Decoded {
    size: [u32; 2],
    texels: Arc<[[u8; 3]]>,
}

/// Decodes the images of one scene, each once.
pub(crate) struct TextureReader {
    left: u64,
    decoded: HashMap<String, Decoded>,
}

impl Default for TextureReader {
    fn default() -> Self {
        Self { left: BUDGET, decoded: HashMap::new() }
    }
}

impl TextureReader {
    /// Adds the image called `name` (unique within the scene) and returns its index. Its bytes are
    /// asked for when it was not decoded before.
    ///
    /// # Errors
    /// [`TextureError`]; the scene is as before then.
    pub fn add(
        &mut self,
        scene: &mut Scene,
        name: &str,
        wrap: [Wrap; 2],
        bytes: impl FnOnce() -> Result<Vec<u8>, TextureError>,
    ) -> Result<u32, TextureError> {
        let is_there = |t: &Texture| t.name == name && t.wrap == wrap;
        if let Some(there) = scene.textures.iter().position(is_there) {
            return Ok(there as u32);
        }
        let decoded = match self.decoded.get(name) {
            Some(decoded) => decoded.clone(),
            None => self.decode(&bytes()?)?,
        };
        self.decoded.insert(name.to_owned(), decoded.clone());
        let Decoded { size, texels } = decoded;
        scene.textures.push(Texture { name: name.to_owned(), size, wrap, texels });
        Ok(scene.textures.len() as u32 - 1)
    }

    /// The header first, then the budget, then the texels.
    fn decode(&mut self, bytes: &[u8]) -> Result<Decoded, TextureError> {
        if !matches!(image::guess_format(bytes), Ok(ImageFormat::Png)) {
            return Err(TextureError::Format);
        }
        let reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
        let decoder = reader.into_decoder().map_err(TextureError::Damaged)?;
        let (width, height) = decoder.dimensions();
        // what the decoder fills, or what is kept of it: the larger
        let kept = u64::from(width).saturating_mul(u64::from(height)).saturating_mul(3);
        let needed = decoder.total_bytes().max(kept);
        let left = self.left;
        if needed > left {
            return Err(TextureError::OverBudget { width, height, bytes: needed, left });
        }
        self.left -= needed;
        let image = DynamicImage::from_decoder(decoder).map_err(TextureError::Damaged)?.to_rgb8();
        let texels: Arc<[[u8; 3]]> = image.as_raw().as_chunks().0.into();
        if texels.is_empty() {
            return Err(TextureError::Malformed("no texels".into()));
        }
        Ok(Decoded { size: [width, height], texels })
    }
}

/// The warning for an image that is not shown. `place` is a file, with the line if there is one.
pub(crate) fn warning(
    place: &dyn std::fmt::Display,
    material: &str,
    image: &str,
    error: &TextureError,
) -> Warning {
    let image = crate::error::quote(image);
    Warning(format!("{place}: material `{material}` has its plain colour: texture {image} {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(width: u32, height: u32) -> Vec<u8> {
        let mut bytes = Vec::new();
        let image = DynamicImage::new_luma8(width, height);
        image.write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png).unwrap();
        bytes
    }

    #[test]
    fn one_budget_for_all_images() {
        let mut reader = TextureReader { left: 3 * (64 + 63), ..TextureReader::default() };
        let mut scene = Scene::new("a");
        let mut add = |name: &str, wrap| {
            reader.add(&mut scene, name, [wrap; 2], || Ok(png(8, 8))).map_err(|e| e.to_string())
        };
        assert_eq!(add("a", Wrap::Repeat), Ok(0));
        // the same again, and the same with other edges: nothing is decoded
        assert_eq!(add("a", Wrap::Repeat), Ok(0));
        assert_eq!(add("a", Wrap::Clamp), Ok(1));
        let error = add("b", Wrap::Repeat).unwrap_err();
        assert!(error.contains("8 x 8 texels: 192 bytes decoded, but 189 of"), "{error}");
        assert_eq!(scene.textures.len(), 2);
    }

    #[test]
    fn the_header_decides_before_anything_is_decoded() {
        // 60,000 x 60,000 texels in a few bytes: width and height of a valid header replaced
        let mut bomb = png(4, 4);
        bomb[16..20].copy_from_slice(&60_000_u32.to_be_bytes());
        bomb[20..24].copy_from_slice(&60_000_u32.to_be_bytes());
        let crc = crc32(&bomb[12..29]);
        bomb[29..33].copy_from_slice(&crc.to_be_bytes());
        let error = TextureReader::default().decode(&bomb).unwrap_err();
        let expected = 3 * 60_000_u64 * 60_000;
        assert!(
            matches!(error, TextureError::OverBudget { bytes, .. } if bytes == expected),
            "{error}"
        );
    }

    #[test]
    fn what_is_no_image_is_refused() {
        let mut reader = TextureReader::default();
        for bytes in [&b""[..], b"P6 1 1 255 abc", b"\xff\xd8\xff\xe0JFIF"] {
            assert!(matches!(reader.decode(bytes), Err(TextureError::Format)));
        }
        let whole = png(20, 20);
        for length in [8, 20, 33, 40] {
            let cut = reader.decode(&whole[..length]);
            assert!(matches!(cut, Err(TextureError::Damaged(_))), "{length}");
        }
    }

    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0, |crc, byte| {
            (0..8).fold(crc ^ u32::from(*byte), |c, _| (c >> 1) ^ (0xedb8_8320 * (c & 1)))
        })
    }
}
