//! SVG as pixels, drawn by resvg with the letters of DejaVu Sans.

use std::sync::{Arc, LazyLock};

use image::error::{EncodingError, ImageFormatHint};
use image::{ImageEncoder, ImageError, ImageFormat};
use resvg::tiny_skia::{Color as Fill, Pixmap, Transform};
use resvg::usvg::fontdb::Database;
use resvg::usvg::{Options, Tree};

use crate::drawing::item::Color;

/// Pixels of the longest side, at most.
const MOST: f32 = 32_768.0;

static FONTS: LazyLock<Arc<Database>> = LazyLock::new(|| {
    let mut fonts = Database::new();
    fonts.load_font_data(dejavu::sans::regular().to_vec());
    fonts.load_font_data(dejavu::sans::bold().to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    Arc::new(fonts)
});

/// The pixels of a picture that is so many times as large, and their width.
pub fn drawn(svg: &str, scale: f32) -> Result<(u32, Vec<Color>), ImageError> {
    let failed = |error| {
        ImageError::Encoding(EncodingError::new(ImageFormatHint::Exact(ImageFormat::Png), error))
    };
    let options = Options { fontdb: Arc::clone(&FONTS), ..Options::default() };
    let tree = Tree::from_str(svg, &options).map_err(|error| failed(error.to_string()))?;
    let size = tree.size();
    let scale = scale.min(MOST / size.width().max(size.height()));
    let [width, height] = [size.width(), size.height()].map(|x| (x * scale).ceil() as u32);
    let mut pixels = Pixmap::new(width, height)
        .ok_or_else(|| failed(format!("{width} x {height} pixels are too many")))?;
    pixels.fill(Fill::WHITE);
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    Ok((width, pixels.pixels().iter().map(|p| [p.red(), p.green(), p.blue()]).collect()))
}

pub fn encoded(width: u32, pixels: &[Color]) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    let height = pixels.len() as u32 / width.max(1);
    image::codecs::png::PngEncoder::new(&mut bytes).write_image(
        pixels.as_flattened(),
        width,
        height,
        image::ExtendedColorType::Rgb8,
    )?;
    Ok(bytes)
}
