//! Drawings: boxes, lines, text and images at places, the same as SVG and as PNG.
//!
//! Places are in pixels from the upper left corner, to the right and down. As SVG, text is readable
//! on light and dark grounds alike: what is drawn in a colour of
//! [`pen`](crate::svg_plot::pen) follows the reader's choice. As PNG, it is drawn twice as
//! large, on a light ground.

mod heat_maps;
mod item;

pub use image::ImageError;

pub use heat_maps::{Classes, ramp};
pub use heat_maps::{HeatMap, Panel, heat_maps};
pub use item::{Color, Drawing, Item, Paint, color, wrapped};

pub use crate::svg_plot::pen::{Font, PLAIN};
