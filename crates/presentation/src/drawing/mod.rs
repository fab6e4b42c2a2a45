//! Drawings as SVG: boxes, lines, text and images at places.
//!
//! Places are in pixels from the upper left corner, to the right and down. Text is readable on
//! light and dark grounds alike: what is drawn in a colour of [`pen`](crate::svg_plot::pen) follows
//! the reader's choice.

mod heat_maps;
mod item;

pub use image::ImageError;

pub use heat_maps::{Classes, ramp};
pub use heat_maps::{HeatMap, Panel, heat_maps};
pub use item::{Color, Drawing, Item, Paint, color, wrapped};

pub use crate::svg_plot::pen::{Font, PLAIN};
