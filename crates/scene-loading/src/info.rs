//! Contents of a scene, and properties of it that may trouble a benchmark.

use std::collections::BTreeMap;
use std::fmt;

use glam::DVec3;

use crate::error::FilePlace;
use crate::polygon::{area_vector, is_flat};
use crate::scene::{Bounds, Scene, Shape, Warning};

/// Counts and sizes of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneInfo {
    pub primitives: usize,
    pub spheres: usize,
    /// Cones and cylinders among them.
    pub cones: usize,
    pub polygons: usize,
    /// Flat triangles among them.
    pub triangles: usize,
    /// Triangles with normals among them.
    pub patches: usize,
    pub vertices: usize,
    pub normals: usize,
    pub materials: usize,
    pub lights: usize,
    /// Objects that the source places several times.
    pub objects: usize,
    pub instances: usize,
    /// Bounds of all primitives, in the coordinates of the file.
    pub bounds: Bounds,
    /// The scene's origin in the coordinates of the file.
    pub origin: DVec3,
    /// Bytes that the scene's arrays take in memory.
    pub bytes: usize,
}

impl SceneInfo {
    /// Counts what the scene holds. Primitives with invalid indices are counted but add nothing
    /// to the bounds.
    pub fn of(scene: &Scene) -> Self {
        let mut placed: BTreeMap<u32, usize> = BTreeMap::new();
        for instance in &scene.instances {
            *placed.entry(instance.object).or_default() += 1;
        }
        placed.retain(|_, instances| *instances > 1);
        let mut info = Self {
            primitives: scene.primitives.len(),
            spheres: 0,
            cones: 0,
            polygons: 0,
            triangles: 0,
            patches: 0,
            vertices: scene.vertices.len(),
            normals: scene.normals.len(),
            materials: scene.materials.len(),
            lights: scene.lights.len(),
            objects: placed.len(),
            instances: placed.values().sum(),
            bounds: Bounds::EMPTY,
            origin: scene.origin,
            bytes: size_of_val(scene.lights.as_slice())
                + size_of_val(scene.materials.as_slice())
                + scene.materials.iter().map(|m| m.name.len()).sum::<usize>()
                + size_of_val(scene.vertices.as_slice())
                + size_of_val(scene.normals.as_slice())
                + size_of_val(scene.spheres.as_slice())
                + size_of_val(scene.cones.as_slice())
                + size_of_val(scene.primitives.as_slice())
                + size_of_val(scene.velocities.as_slice()),
        };
        for primitive in &scene.primitives {
            match primitive.shape {
                Shape::Sphere(_) => info.spheres += 1,
                Shape::Cone(_) => info.cones += 1,
                Shape::Polygon { .. } => info.polygons += 1,
                Shape::Triangle { .. } => info.triangles += 1,
                Shape::Patch { .. } => info.patches += 1,
            }
            if indices_are_valid(scene, primitive.shape) {
                let bounds = scene.shape_bounds(primitive.shape);
                info.bounds.include(scene.to_file_coordinates(bounds.min));
                info.bounds.include(scene.to_file_coordinates(bounds.max));
            }
        }
        info
    }
}

impl fmt::Display for SceneInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "primitives  {}", self.primitives)?;
        for (name, count) in [
            ("spheres", self.spheres),
            ("cones", self.cones),
            ("polygons", self.polygons),
            ("triangles", self.triangles),
            ("patches", self.patches),
        ] {
            if count > 0 {
                writeln!(f, "  {name:<10}{count}")?;
            }
        }
        writeln!(f, "vertices    {}", self.vertices)?;
        writeln!(f, "normals     {}", self.normals)?;
        writeln!(f, "materials   {}", self.materials)?;
        writeln!(f, "lights      {}", self.lights)?;
        if self.objects > 0 {
            writeln!(f, "instances   {} of {} objects", self.instances, self.objects)?;
        }
        if !self.bounds.is_empty() {
            writeln!(f, "bounds      {} to {}", self.bounds.min, self.bounds.max)?;
        }
        if self.origin != DVec3::ZERO {
            let shift = DVec3::ZERO - self.origin;
            writeln!(f, "shift       by {shift}: coordinates are computed from there")?;
        }
        write!(f, "memory      {:.1} MiB", self.bytes as f64 / (1 << 20) as f64)
    }
}

/// Looks for what loaders let pass or generators may get wrong: invalid indices, numbers that are
/// not finite, shapes without extent, bent polygons, a camera without a view, no lights. An empty
/// list means that nothing was found; the scene's own warnings are not repeated.
pub fn validate(scene: &Scene) -> Vec<Warning> {
    let mut faults = Faults::default();
    for (id, primitive) in scene.primitives.iter().enumerate() {
        if primitive.material as usize >= scene.materials.len() {
            faults.add(Fault::Material, id);
        }
        if !indices_are_valid(scene, primitive.shape) {
            faults.add(Fault::Index, id);
        } else {
            check_shape(scene, primitive.shape, id, &mut faults);
        }
    }
    let mut warnings = faults.warnings(&scene.name);
    let mut warn = |text: String| warnings.push(Warning(format!("{}: {text}", scene.name)));
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

/// `shape` has valid indices.
fn check_shape(scene: &Scene, shape: Shape, id: usize, faults: &mut Faults) {
    let bounds = scene.shape_bounds(shape);
    if !(bounds.min.is_finite() && bounds.max.is_finite()) {
        faults.add(Fault::NotFinite, id);
        return;
    }
    let extent = bounds.size().max_element();
    match shape {
        Shape::Sphere(_) | Shape::Cone(_) => {
            if extent <= 0.0 {
                faults.add(Fault::NoExtent, id);
            }
        }
        Shape::Polygon { .. } | Shape::Triangle { .. } | Shape::Patch { .. } => {
            let outline = scene.outline(shape);
            match area_vector(&outline) {
                None => faults.add(Fault::NoExtent, id),
                Some(area) if !is_flat(&outline, area) => faults.add(Fault::Bent, id),
                Some(_) => {}
            }
        }
    }
    if let Shape::Patch { n, .. } = shape {
        let unusable = |i: &u32| {
            scene.normals.get(*i as usize).is_none_or(|n| !n.is_finite() || n.length() == 0.0)
        };
        if n.iter().any(unusable) {
            faults.add(Fault::Normal, id);
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Fault {
    Material,
    Index,
    NotFinite,
    NoExtent,
    Bent,
    Normal,
}

/// For each kind of fault: how many primitives have it, and the first.
#[derive(Default)]
struct Faults(BTreeMap<Fault, (usize, usize)>);

impl Faults {
    fn add(&mut self, fault: Fault, id: usize) {
        self.0.entry(fault).or_insert((0, id)).0 += 1;
    }

    fn warnings(&self, name: &str) -> Vec<Warning> {
        let text = |fault| match fault {
            Fault::Material => "with a material that does not exist",
            Fault::Index => "with vertices, normals or shapes that do not exist",
            Fault::NotFinite => "with numbers that are not finite",
            Fault::NoExtent => "without area or extent",
            Fault::Bent => "that are polygons with corners off their plane",
            Fault::Normal => "with normals of length 0",
        };
        let found = self.0.iter().map(|(&fault, (count, first))| {
            Warning(format!("{name}: {count} primitives {} (first: {first})", text(fault)))
        });
        found.collect()
    }
}
