//! Scenes that move, generated in code: the same on every run.

mod city;
mod cloth;
mod gears_turning;
mod marbles;
mod particles;
mod stage;
mod walker;
mod wall;

use crate::animation::frames::Animation;
use crate::error::LoadError;
use crate::procedural::{size_of, split_spec};

#[derive(Clone, Copy)]
pub struct AnimatedEntry {
    /// Its name, to which a size can be added: `marbles:5`.
    pub name: &'static str,
    /// Size factor where none is named.
    pub default_size: u32,
    /// Largest size factor: about 20 million primitives.
    pub max_size: u32,
    pub frames: u32,
    /// What the scene shows and how it grows with the size factor `n`.
    pub summary: &'static str,
    /// Primitives of each frame at a size.
    pub count: fn(u32) -> u64,
    /// The animation at a size from 1 to `max_size`.
    pub open: fn(u32) -> Animation,
}

macro_rules! animated {
    ($($name:literal $module:ident $size:literal..=$max:literal, $frames:literal frames: $summary:literal)*) => {
        &[$(AnimatedEntry {
            name: $name,
            default_size: $size,
            max_size: $max,
            frames: $frames,
            summary: $summary,
            count: $module::count,
            open: |size| {
                let name = if size == $size { $name.to_owned() } else { format!("{}:{size}", $name) };
                let mut make = $module::frames(size);
                Animation::new(name, $frames, move |index| Ok(make(index)))
            },
        }),*]
    };
}

/// The generated animations, by name: module, default and largest size, frames.
pub static ANIMATED: &[AnimatedEntry] = animated! {
    "city" city 20..=263, 60 frames: "cars among n^2 buildings at rest, two streets of n cars: at the default size 0.8 % moves"
    "cloth" cloth 48..=790, 50 frames: "a waving cloth of 32 n^2 long thin triangles, none of them rigid"
    "gears-turning" gears_turning 6..=32, 40 frames: "n^3 meshing gears (SPD's) that turn, 572 triangles each"
    "marbles" marbles 110..=249000, 50 frames: "n marbles of 80 triangles that fall into a bowl"
    "particles" particles 27..=170, 50 frames: "n^3 tetrahedra in a swirling flow, each on its own"
    "walker" walker 16..=277, 40 frames: "a walking figure of 13 rigid limbs, 20 n^2 triangles each; the camera follows"
    "wall" wall 90..=1290, 50 frames: "a wall of n^2 bricks that is hit and breaks"
};

/// Opens `marbles` or `marbles:5`; none where no generator has that name.
pub(super) fn open(spec: &str) -> Result<Option<Animation>, LoadError> {
    let (name, size) = split_spec(spec);
    let Some(entry) = ANIMATED.iter().find(|entry| entry.name == name) else { return Ok(None) };
    let size = size_of(entry.name, size, entry.default_size, entry.max_size)
        .map_err(|error| LoadError::procedural(spec, error))?;
    Ok(Some((entry.open)(size)))
}
