//! Decoding of the images that materials refer to: PNG, through the crate `image`.
//!
//! All images of a scene share one budget of decoded bytes; it is checked against the header, so
//! that a small file that unpacks to much is refused before anything is unpacked. An image that
//! cannot be had is no error of the scene: loaders warn and keep the material's plain colour.

use std::collections::HashMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use crate::error::LoadError;
use crate::limits::MAX_TEXTURES;
use crate::scene::{Scene, Warning};
use crate::scene::{Texture, Wrap};

/// The most bytes that all images of a scene may have once decoded, and in their files: 512 MiB.
const BUDGET: u64 = 512 << 20;

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
    #[error("is not a PNG image")]
    Format,
    /// The decoder refused it.
    #[error("is damaged: {0}")]
    Damaged(image::ImageError),
    /// It would not fit into the budget.
    #[error(
        "has {width} x {height} texels: {bytes} bytes decoded, but {left} of the {BUDGET} that the \
         images of a scene may have are left"
    )]
    OverBudget { width: u32, height: u32, bytes: u64, left: u64 },
    /// There are as many as there may be.
    #[error("exceeds the limit of {MAX_TEXTURES} images")]
    TooMany,
    /// The source says that the image is not as it stands.
    #[error("has options that are not read: {0}")]
    Options(String),
    /// The reference to the image is invalid.
    #[error("has {0}")]
    Malformed(String),
}

/// Identity of a file, however its path is spelled.
pub(crate) fn file_key(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

/// Decodes the images of one scene. Each is read and decoded once, or found not to be one.
pub(crate) struct TextureReader {
    /// Bytes that images may still take once decoded.
    left: u64,
    /// Bytes that may still be read.
    left_to_read: u64,
    /// Images, still without names, and why others are none.
    decoded: HashMap<PathBuf, Result<Texture, Rc<TextureError>>>,
    /// Textures of the scene.
    added: HashMap<(PathBuf, [Wrap; 2]), u32>,
}

impl Default for TextureReader {
    fn default() -> Self {
        Self { left: BUDGET, left_to_read: BUDGET, decoded: HashMap::new(), added: HashMap::new() }
    }
}

impl TextureReader {
    /// Adds an image and returns its index. Its key is [`file_key`], or for a part of the scene's
    /// own file what no path is. Its bytes, of which no more than a number are taken, are asked
    /// for once.
    ///
    /// # Errors
    /// [`TextureError`]; the scene is as before then.
    pub fn add(
        &mut self,
        scene: &mut Scene,
        key: PathBuf,
        name: &str,
        wrap: [Wrap; 2],
        bytes: impl FnOnce(u64) -> Result<Vec<u8>, TextureError>,
    ) -> Result<u32, Rc<TextureError>> {
        let key = (key, wrap);
        if let Some(&there) = self.added.get(&key) {
            return Ok(there);
        }
        let decoded = match self.decoded.get(&key.0) {
            Some(known) => known.clone(),
            None => {
                let found = bytes(self.left_to_read).and_then(|bytes| self.decode(&bytes));
                let found = found.map_err(Rc::new);
                self.decoded.insert(key.0.clone(), found.clone());
                found
            }
        }?;
        if scene.textures.len() >= MAX_TEXTURES {
            return Err(Rc::new(TextureError::TooMany));
        }
        let index = scene.textures.len() as u32;
        scene.textures.push(Texture { name: name.to_owned(), wrap, ..decoded });
        self.added.insert(key, index);
        Ok(index)
    }

    /// The header first, then the budget, then the texels.
    fn decode(&mut self, bytes: &[u8]) -> Result<Texture, TextureError> {
        self.left_to_read = self.left_to_read.saturating_sub(bytes.len() as u64);
        if !matches!(image::guess_format(bytes), Ok(ImageFormat::Png)) {
            return Err(TextureError::Format);
        }
        let bytes = without_ancillary_chunks(bytes);
        let reader = ImageReader::with_format(Cursor::new(&bytes), ImageFormat::Png);
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
        let (name, wrap) = (String::new(), [Wrap::Repeat; 2]);
        Ok(Texture { name, size: [width, height], wrap, texels })
    }
}

/// A PNG file's signature, then the chunks that make up the image. Colour profiles and texts are
/// left out: packed, they unpack to what no budget would count.
fn without_ancillary_chunks(bytes: &[u8]) -> Vec<u8> {
    let (signature, mut rest) = bytes.split_at(bytes.len().min(8));
    let mut kept = signature.to_vec();
    while let Some(&[a, b, c, d, ref kind @ ..]) = rest.first_chunk::<8>() {
        // length, kind, data and checksum; what is cut off stays so
        let length = 12 + u64::from(u32::from_be_bytes([a, b, c, d]));
        let length = usize::try_from(length).unwrap_or(usize::MAX).min(rest.len());
        let (chunk, after) = rest.split_at(length);
        if matches!(kind, b"IHDR" | b"PLTE" | b"tRNS" | b"IDAT" | b"IEND") {
            kept.extend_from_slice(chunk);
        }
        rest = after;
    }
    kept.extend_from_slice(rest);
    kept
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
    fn all_images_share_one_budget() {
        let mut reader = TextureReader { left: 3 * (64 + 63), ..TextureReader::default() };
        let mut scene = Scene::new("a");
        let mut add = |name: &str, wrap| {
            reader
                .add(&mut scene, name.into(), name, [wrap; 2], |_| Ok(png(8, 8)))
                .map_err(|e| e.to_string())
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
        let TextureError::OverBudget { bytes, .. } = error else { panic!("{error}") };
        assert_eq!(bytes, 3 * 60_000 * 60_000);
    }

    #[test]
    fn files_that_are_not_images_are_refused() {
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

    /// A chunk of any kind and data.
    fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
        let body = [&kind[..], data].concat();
        let (length, crc) = ((data.len() as u32).to_be_bytes(), crc32(&body).to_be_bytes());
        [&length[..], &body, &crc].concat()
    }

    #[test]
    fn profiles_and_texts_are_not_unpacked() {
        let zeros = {
            use std::io::Write;
            let mut packed =
                flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
            packed.write_all(&vec![0; 1 << 20]).unwrap();
            packed.finish().unwrap()
        };
        let plain = png(4, 4);
        let profile = chunk(b"iCCP", &[&b"bomb\0\0"[..], &zeros].concat());
        let text = chunk(b"zTXt", &[&b"bomb\0\0"[..], &zeros].concat());
        let bomb = [&plain[..33], &profile, &text, &plain[33..]].concat();
        let whole = without_ancillary_chunks(&plain);
        assert_eq!(without_ancillary_chunks(&bomb), whole);
        // The planted fault: all of it does reach the decoder where nothing is left out.
        let mut decoder = image::codecs::png::PngDecoder::new(Cursor::new(&bomb)).unwrap();
        assert_eq!(decoder.icc_profile().unwrap().unwrap().len(), 1 << 20);
        assert_eq!(TextureReader::default().decode(&bomb).unwrap().size, [4, 4]);
        for cut in 0..bomb.len() {
            let _ = without_ancillary_chunks(&bomb[..cut]);
        }
    }

    #[test]
    fn failed_images_are_read_once() {
        let (mut reader, mut scene, mut asked) = (TextureReader::default(), Scene::new("a"), 0);
        for _ in 0..100 {
            let bytes = |_| {
                asked += 1;
                Ok(b"no image".to_vec())
            };
            let failed =
                reader.add(&mut scene, "a".into(), "a", [Wrap::Repeat; 2], bytes).unwrap_err();
            assert!(matches!(*failed, TextureError::Format));
        }
        assert_eq!((asked, scene.textures.len()), (1, 0));
    }

    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0, |crc, byte| {
            (0..8).fold(crc ^ u32::from(*byte), |c, _| (c >> 1) ^ (0xedb8_8320 * (c & 1)))
        })
    }
}
