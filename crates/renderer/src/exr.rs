//! OpenEXR images: three channels of 32-bit floats, uncompressed scanlines.
//!
//! Format: "OpenEXR File Layout", Academy Software Foundation, version 2 of the file format. The
//! simplest of its forms, which every reader must know: a writer of it is a page, a library for
//! all forms minutes of compile time.

use crate::film::Image;

const MAGIC: u32 = 20_000_630;
const VERSION: u32 = 2;
/// Pixel type `FLOAT`.
const FLOAT: i32 = 2;
/// Channels must be in alphabetical order; each with its place in a colour.
const CHANNELS: [(&[u8; 2], usize); 3] = [(b"B\0", 2), (b"G\0", 1), (b"R\0", 0)];

/// The file of an image; colours stay linear and are rounded to 32 bits.
pub fn encode(image: &Image) -> Vec<u8> {
    let (width, height) = (image.width as usize, image.height as usize);
    let mut out = Vec::with_capacity(512 + height * (16 + 12 * width));
    out.extend(MAGIC.to_le_bytes());
    out.extend(VERSION.to_le_bytes());
    header(image, &mut out);
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

fn header(image: &Image, out: &mut Vec<u8>) {
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
