//! Pixels as PNG.

use image::ImageEncoder;

use super::item::Color;

pub fn encoded(width: u32, pixels: &[Color]) -> Result<Vec<u8>, image::ImageError> {
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
