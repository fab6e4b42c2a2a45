//! `rtbench show`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;

use crate::args::parsers::scene_name;

#[derive(Debug, Clone, Args)]
pub struct ShowArgs {
    /// Scene name or file
    #[arg(value_parser = scene_name())]
    pub scene: String,
    /// Structures, side by side on one scale: uniform-grid,kd-tree or uniform-grid:density=8
    #[arg(short, long, alias = "structure", value_name = "STRUCTURE", value_delimiter = ',')]
    #[arg(required = true)]
    pub structures: Vec<String>,
    /// SVG file to write
    #[arg(short, long, value_name = "FILE", required_unless_present = "ray")]
    pub output: Option<PathBuf>,
    /// Plane that cuts the cells [default: across the view, through the middle of the scene]
    #[arg(long, value_name = "x|y|z[=POSITION]", conflicts_with_all = ["project", "ray"])]
    pub slice: Option<Slice>,
    /// Draw what lies in the box between two corners alone, in the coordinates of the scene's file
    #[arg(long, value_name = "X,Y,Z:X,Y,Z", allow_hyphen_values = true, value_parser = window,
          conflicts_with_all = ["project", "ray"])]
    pub window: Option<[[f64; 3]; 2]>,
    /// Draw all non-empty cells as boxes, seen along the camera's direction
    #[arg(long, conflicts_with = "ray")]
    pub project: bool,
    /// Draw cells at this depth of a hierarchy, and leaves above it [default: all leaves]
    #[arg(long, value_name = "N")]
    pub depth: Option<u32>,
    /// Draw the path of one ray, in a plane that contains it: a pixel of the image that `render`
    /// makes by default, or an origin and a target point
    #[arg(long, value_name = "X,Y|X,Y,Z:X,Y,Z", allow_hyphen_values = true)]
    pub ray: Option<RayAt>,
    /// Longer side of a panel in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 360,
          value_parser = clap::value_parser!(u32).range(64..=4096))]
    pub size: u32,
    /// References that the darkest colour stands for, to give several pictures one scale
    /// [default: the most in this picture]
    #[arg(long, value_name = "REFERENCES", value_parser = clap::value_parser!(u64).range(2..))]
    pub scale: Option<u64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slice {
    /// The axis that the plane is across.
    pub axis: usize,
    /// Position, in the coordinates of the scene's file; the middle of the scene by default.
    pub position: Option<f64>,
}

impl FromStr for Slice {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const FORM: &str = "expected x, y or z, or a position like y=0.25";
        let (name, position) = match text.split_once('=') {
            None => (text, None),
            Some((name, position)) => (name, Some(number(position).ok_or(FORM)?)),
        };
        let axis = ["x", "y", "z"].iter().position(|axis| *axis == name).ok_or(FORM)?;
        Ok(Self { axis, position })
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RayAt {
    /// Through the middle of a pixel.
    Pixel([u32; 2]),
    /// From a point towards another.
    Points([[f64; 3]; 2]),
}

/// Width and height of the image that `--ray X,Y` counts pixels of.
pub const IMAGE: u32 = 512;

impl FromStr for RayAt {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const FORM: &str =
            "expected a pixel of 512 x 512 like 256,200, or two points like 0,0,5:0.5,1,0";
        if text.contains(':') {
            let points = points(text).ok_or(FORM)?;
            return if points[0] == points[1] {
                Err("the points are one")
            } else {
                Ok(Self::Points(points))
            };
        }
        let (x, y) = text.split_once(',').ok_or(FORM)?;
        let pixel = |text: &str| text.trim().parse().ok().filter(|n| *n < IMAGE);
        Ok(Self::Pixel([pixel(x).ok_or(FORM)?, pixel(y).ok_or(FORM)?]))
    }
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite())
}

fn point(text: &str) -> Option<[f64; 3]> {
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    numbers?.try_into().ok()
}

fn points(text: &str) -> Option<[[f64; 3]; 2]> {
    let (one, other) = text.split_once(':')?;
    Some([point(one)?, point(other)?])
}

/// Two corners of a box that has a size along every axis.
fn window(text: &str) -> Result<[[f64; 3]; 2], &'static str> {
    let corners = points(text).ok_or("expected two corners like -1,0,-1:1,2,1")?;
    let [one, other] = &corners;
    let is_flat = one.iter().zip(other).any(|(a, b)| a == b);
    if is_flat { Err("the box is flat: its corners agree in a coordinate") } else { Ok(corners) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_and_rays_are_read() {
        assert_eq!("y".parse(), Ok(Slice { axis: 1, position: None }));
        assert_eq!("z=-0.5".parse(), Ok(Slice { axis: 2, position: Some(-0.5) }));
        for wrong in ["", "w", "x=", "x=nan", "x=1e999", "xy"] {
            assert!(wrong.parse::<Slice>().is_err(), "{wrong}");
        }
        assert_eq!("511,0".parse(), Ok(RayAt::Pixel([511, 0])));
        let points = RayAt::Points([[0.0, 1.0, -2.0], [1e3, 0.0, 0.5]]);
        assert_eq!("0,1,-2:1e3,0,.5".parse(), Ok(points));
        assert_eq!(window("-1,0,-1:1,2,0.5"), Ok([[-1.0, 0.0, -1.0], [1.0, 2.0, 0.5]]));
        for wrong in ["", "0,0,0", "0,0,0:1,1", "0,0,0:1,0,1", "0,0,0:1,1,inf"] {
            assert!(window(wrong).is_err(), "{wrong}");
        }
        for wrong in ["", "1", "512,0", "-1,0", "1,2,3", "1,2:3,4", "0,0,0:0,0,0", "0,0,0:0,0,inf"]
        {
            assert!(wrong.parse::<RayAt>().is_err(), "{wrong}");
        }
    }
}
