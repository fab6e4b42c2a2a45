//! Images and their files.

mod exr;
mod file;
mod rgb_image;

pub use file::{ImageError, ImageFormat};
pub use rgb_image::Image;
