//! Contents of a scene, and properties of it that may trouble a benchmark.

use std::collections::BTreeMap;
use std::fmt;

use glam::DVec3;

use crate::error::FilePlace;
use crate::polygon::{area_vector, is_flat};
use crate::scene::{Bounds, Primitive, Scene, Shape, Warning};

/// Counts and sizes of a scene; its text has those that the scene itself knows, too.
#[derive(Debug, Clone)]
pub struct SceneInfo<'a> {
    scene: &'a Scene,
    /// Primitives of each kind, by its name.
    pub kinds: [(&'static str, usize); 5],
    /// Objects that the source places several times.
    pub objects: usize,
    pub instances: usize,
    /// Bounds of all primitives, in the coordinates of the file.
    pub bounds: Bounds,
}

impl<'a> SceneInfo<'a> {
    /// Counts what the scene holds. Primitives with invalid indices are counted but add nothing
    /// to the bounds.
    pub fn of(scene: &'a Scene) -> Self {
        let mut placed: BTreeMap<u32, usize> = BTreeMap::new();
        for instance in &scene.instances {
            *placed.entry(instance.object).or_default() += 1;
        }
        placed.retain(|_, instances| *instances > 1);
        let (objects, instances) = (placed.len(), placed.values().sum());
        let kinds = ["spheres", "cones", "polygons", "triangles", "patches"].map(|kind| (kind, 0));
        let mut info = Self { scene, kinds, objects, instances, bounds: Bounds::EMPTY };
        for primitive in &scene.primitives {
            let [spheres, cones, polygons, triangles, patches] = &mut info.kinds;
            let (_, count) = match primitive.shape {
                Shape::Sphere(_) => spheres,
                Shape::Cone(_) => cones,
                Shape::Polygon { .. } => polygons,
                Shape::Triangle { .. } => triangles,
                Shape::Patch { .. } => patches,
            };
            *count += 1;
            if indices_are_valid(scene, primitive.shape) {
                let bounds = scene.shape_bounds(primitive.shape);
                info.bounds.include(scene.to_file_coordinates(bounds.min));
                info.bounds.include(scene.to_file_coordinates(bounds.max));
            }
        }
        info
    }
}

impl fmt::Display for SceneInfo<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let scene = self.scene;
        writeln!(f, "primitives  {}", scene.primitives.len())?;
        for (name, count) in self.kinds.iter().filter(|(_, count)| *count > 0) {
            writeln!(f, "  {name:<10}{count}")?;
        }
        writeln!(f, "vertices    {}", scene.vertices.len())?;
        writeln!(f, "normals     {}", scene.normals.len())?;
        writeln!(f, "materials   {}", scene.materials.len())?;
        writeln!(f, "lights      {}", scene.lights.len())?;
        if self.objects > 0 {
            writeln!(f, "instances   {} of {} objects", self.instances, self.objects)?;
        }
        if !self.bounds.is_empty() {
            writeln!(f, "bounds      {} to {}", self.bounds.min, self.bounds.max)?;
        }
        if scene.origin != DVec3::ZERO {
            let shift = DVec3::ZERO - scene.origin;
            writeln!(f, "shift       by {shift}: coordinates are computed from there")?;
        }
        let bytes = size_of_val(scene.lights.as_slice())
            + size_of_val(scene.materials.as_slice())
            + scene.materials.iter().map(|m| m.name.len()).sum::<usize>()
            + size_of_val(scene.vertices.as_slice())
            + size_of_val(scene.normals.as_slice())
            + size_of_val(scene.spheres.as_slice())
            + size_of_val(scene.cones.as_slice())
            + size_of_val(scene.primitives.as_slice())
            + size_of_val(scene.velocities.as_slice());
        write!(f, "memory      {:.1} MiB", bytes as f64 / (1 << 20) as f64)
    }
}

/// Looks for what loaders let pass or generators may get wrong: invalid indices, numbers that are
/// not finite, shapes without extent, bent polygons, a camera without a view, no lights. An empty
/// list means that nothing was found; the scene's own warnings are not repeated.
pub fn validate(scene: &Scene) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let mut warn = |text: String| warnings.push(Warning(format!("{}: {text}", scene.name)));
    // for each kind of fault how many primitives have it, and the first
    let mut found = [("", 0, 0); 6];
    for (id, primitive) in scene.primitives.iter().enumerate() {
        for (entry, (text, is_found)) in found.iter_mut().zip(faults(scene, primitive)) {
            match entry {
                _ if !is_found => {}
                (_, 0, _) => *entry = (text, 1, id),
                (_, count, _) => *count += 1,
            }
        }
    }
    for (text, count, first) in found.into_iter().filter(|(_, count, _)| *count > 0) {
        warn(format!("{count} primitives {text} (first: {first})"));
    }
    if scene.primitives.is_empty() {
        warn("no primitives".into());
    }
    if scene.lights.is_empty() {
        warn("no lights: every surface is black".into());
    }
    if let Err(error) = scene.camera.check(|| FilePlace::file(scene.name.as_ref())) {
        warnings.push(Warning(error.to_string()));
    }
    warnings
}

/// What may be wrong with a primitive, in words, and whether it is.
fn faults(scene: &Scene, &Primitive { shape, material }: &Primitive) -> [(&'static str, bool); 6] {
    let is_there = indices_are_valid(scene, shape);
    let bounds = if is_there { scene.shape_bounds(shape) } else { Bounds::EMPTY };
    let is_finite = bounds.min.is_finite() && bounds.max.is_finite();
    let (mut lacks_extent, mut is_bent, mut lacks_normal) = (false, false, false);
    match shape {
        _ if !is_finite => {}
        Shape::Sphere(_) | Shape::Cone(_) => lacks_extent = bounds.size().max_element() <= 0.0,
        Shape::Polygon { .. } | Shape::Triangle { .. } | Shape::Patch { .. } => {
            let outline = scene.outline(shape);
            let area = area_vector(&outline);
            lacks_extent = area.is_none();
            is_bent = area.is_some_and(|area| !is_flat(&outline, area));
        }
    }
    if let (Shape::Patch { n, .. }, true) = (shape, is_finite) {
        let is_usable = |n: &DVec3| n.is_finite() && n.length() > 0.0;
        lacks_normal = n.iter().any(|&i| !scene.normals.get(i as usize).is_some_and(is_usable));
    }
    [
        ("with a material that does not exist", material as usize >= scene.materials.len()),
        ("with vertices, normals or shapes that do not exist", !is_there),
        ("with numbers that are not finite", is_there && !is_finite),
        ("without area or extent", lacks_extent),
        ("that are polygons with corners off their plane", is_bent),
        ("with normals of length 0", lacks_normal),
    ]
}

fn indices_are_valid(scene: &Scene, shape: Shape) -> bool {
    let below = |indices: [u32; 3], length: usize| indices.iter().all(|&i| (i as usize) < length);
    match shape {
        Shape::Sphere(i) => (i as usize) < scene.spheres.len(),
        Shape::Cone(i) => (i as usize) < scene.cones.len(),
        Shape::Polygon { first, count } => {
            count >= 3 && u64::from(first) + u64::from(count) <= scene.vertices.len() as u64
        }
        Shape::Triangle { v } => below(v, scene.vertices.len()),
        Shape::Patch { v, n } => below(v, scene.vertices.len()) && below(n, scene.normals.len()),
    }
}
