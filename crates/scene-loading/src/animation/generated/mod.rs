//! Scenes that move, generated in code: the same on every run.

mod city;
mod cloth;
mod falling;
mod gears_turning;
mod marbles;
mod mesh;
mod particles;
mod stage;
mod walker;
mod wall;

use crate::animation::frames::{Animation, check_frame};
use crate::animation::generated::stage::Frames;
use crate::error::LoadError;
use crate::procedural::SpecError;
use crate::scene::Scene;

#[derive(Debug, Clone, Copy)]
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
    pub open: fn(u32) -> Box<dyn Animation>,
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
                Box::new(GeneratedAnimation { name, frames: $frames, make: $module::frames(size) })
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

/// A generated animation at a size.
struct GeneratedAnimation {
    name: String,
    frames: u32,
    make: Frames,
}

impl Animation for GeneratedAnimation {
    fn name(&self) -> &str {
        &self.name
    }

    fn frames(&self) -> u32 {
        self.frames
    }

    fn frame(&mut self, index: u32) -> Result<Scene, LoadError> {
        check_frame(&self.name, index, self.frames)?;
        let mut scene = (self.make)(index);
        scene.name.clone_from(&self.name);
        Ok(scene)
    }
}

/// Opens `marbles` or `marbles:5`; none where no generator has that name.
pub(super) fn open(spec: &str) -> Result<Option<Box<dyn Animation>>, LoadError> {
    let (name, size) = match spec.split_once(':') {
        Some((name, size)) => (name, Some(size)),
        None => (spec, None),
    };
    let Some(entry) = ANIMATED.iter().find(|entry| entry.name == name) else { return Ok(None) };
    let size = size.map_or(Some(entry.default_size), |text| {
        text.parse().ok().filter(|size| (1..=entry.max_size).contains(size))
    });
    let size = size.ok_or_else(|| {
        let error = SpecError::BadSize {
            name: entry.name,
            size: spec.get(name.len() + 1..).unwrap_or_default().to_owned(),
            max_size: entry.max_size,
            default_size: entry.default_size,
        };
        LoadError::Procedural { spec: spec.to_owned(), message: error.to_string() }
    })?;
    Ok(Some((entry.open)(size)))
}
