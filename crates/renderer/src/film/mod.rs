//! Images, their files, and images of numbers.

mod exr;
mod file;
pub mod heat_map;
mod rgb_image;

pub use file::{ImageError, ImageFormat};
pub use rgb_image::Image;
