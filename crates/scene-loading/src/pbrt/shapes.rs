//! Shapes of PBRT files: triangles, bilinear patches, spheres and PLY files; and instances of
//! objects.

use std::path::Path;

use glam::{DMat4, DVec3};

use crate::error::{FilePlace, LoadError};
use crate::limits::{self, MAX_ELEMENTS};
use crate::mesh::{FaceCounts, Mesh, cofactor, coordinate, usable};
use crate::pbrt::params::Params;
use crate::pbrt::state::uniform_scale;
use crate::scene::{Primitive, Scene, Shape, index};

/// The most there may be of vertices, normals, or primitives after so many more of each.
pub(super) fn check_size(
    scene: &Scene,
    more: usize,
    place: impl FnOnce() -> FilePlace,
) -> Result<(), LoadError> {
    let most = scene.vertices.len().max(scene.normals.len()).max(scene.primitives.len());
    let size = most.saturating_add(more);
    limits::check(size, MAX_ELEMENTS, "the number of vertices or triangles", place)
}

/// Context for adding shapes.
pub(super) struct ShapeSink<'a> {
    pub scene: &'a mut Scene,
    pub counts: &'a mut FaceCounts,
    pub transform: DMat4,
    pub material: u32,
    pub triangulate: bool,
}

impl ShapeSink<'_> {
    /// `trianglemesh` and `bilinearmesh`: `corners` is 3 or 4.
    pub fn mesh(&mut self, params: &Params, corners: usize) -> Result<(), LoadError> {
        let place = || params.place();
        let positions = points(params, "P")?;
        let mut normals = points(params, "N").unwrap_or_default();
        let has_other_number = normals.len() != positions.len();
        if params.has("N") && has_other_number {
            self.counts.normals.add(place);
            normals.clear();
        }
        check_size(self.scene, positions.len(), place)?;
        let indices = params.numbers("indices")?;
        let all: Vec<f64> = (0..corners).map(|i| i as f64).collect();
        // one face may go without
        let indices = if indices.is_empty() && positions.len() == corners { &all } else { indices };
        if indices.is_empty() || indices.len() % corners != 0 {
            let found = format!("{} indices", indices.len());
            return Err(LoadError::syntax(place(), &found, format!("a multiple of {corners}")));
        }
        let mesh = Mesh {
            material: self.material,
            first: index(self.scene.vertices.len()),
            normals: self.add_normals(&normals),
            has_bad_normals: normals.iter().any(|normal| normal.is_nan()),
            triangulate: self.triangulate,
        };
        self.add_positions(&positions, place)?;
        let unusable = |all: &[DVec3]| all.iter().filter(|v| v.is_nan()).count();
        let (bad_positions, bad_normals) = (unusable(&positions), unusable(&normals));
        (0..bad_positions).for_each(|_| self.counts.vertices.add(place));
        (0..bad_normals).for_each(|_| self.counts.normals.add(place));
        let size = indices.len() / corners;
        check_size(self.scene, size, place)?;
        for face in indices.chunks_exact(corners) {
            let mut picked = [0; 4];
            for (slot, &index) in picked.iter_mut().zip(face) {
                *slot = valid_index(index, positions.len(), place)?;
            }
            // a patch's corners are (0,0), (1,0), (0,1), (1,1)
            if corners == 4 {
                picked.swap(2, 3);
            }
            let corners = picked.get(..corners).unwrap_or_default();
            mesh.add(corners, self.scene, self.counts, place)?;
        }
        if bad_positions + bad_normals > 0 {
            mesh.replace_unusable(self.scene);
        }
        Ok(())
    }

    /// `sphere`, whole; false where the transform does not keep it one.
    pub fn sphere(&mut self, params: &Params) -> Result<bool, LoadError> {
        let radius = params.number("radius", 1.0)?;
        if radius <= 0.0 {
            return Err(LoadError::out_of_range(params.place(), "radius", radius, "above 0"));
        }
        check_size(self.scene, 1, || params.place())?;
        let Some(scale) = uniform_scale(&self.transform) else { return Ok(false) };
        let center = self.transform.transform_point3(DVec3::ZERO);
        checked(center + DVec3::splat(radius * scale), || params.place())?;
        self.scene.push_sphere(self.material, center, radius * scale);
        Ok(true)
    }

    /// Transforms the vertices and normals that `add_ply` added beyond these lengths.
    pub fn place_since(
        &mut self,
        vertices: usize,
        normals: usize,
        path: &Path,
    ) -> Result<(), LoadError> {
        for vertex in self.scene.vertices.iter_mut().skip(vertices) {
            *vertex = checked(self.transform.transform_point3(*vertex), || FilePlace::file(path))?;
        }
        let turn = cofactor(self.transform);
        for normal in self.scene.normals.iter_mut().skip(normals) {
            *normal = (turn * *normal).normalize_or_zero();
        }
        Ok(())
    }

    /// An instance of the object of that number: its shapes once more, at another place. How many
    /// were left out.
    pub fn instance(
        &mut self,
        object: &Scene,
        number: u32,
        place: impl Fn() -> FilePlace,
    ) -> Result<usize, LoadError> {
        let before = self.scene.primitives.len();
        let more = object.vertices.len().max(object.normals.len()).max(object.primitives.len());
        check_size(self.scene, more, &place)?;
        let first = index(self.scene.vertices.len());
        let first_n = self.add_normals(&object.normals).unwrap_or(0);
        self.add_positions(&object.vertices, &place)?;
        let scale = uniform_scale(&self.transform);
        let mut left_out = 0;
        for primitive in &object.primitives {
            let material = primitive.material;
            let shape = match primitive.shape {
                Shape::Triangle { v } => Shape::Triangle { v: v.map(|i| i.saturating_add(first)) },
                Shape::Patch { v, n } => Shape::Patch {
                    v: v.map(|i| i.saturating_add(first)),
                    n: n.map(|i| i.saturating_add(first_n)),
                },
                Shape::Polygon { first: of, count } => {
                    Shape::Polygon { first: of.saturating_add(first), count }
                }
                Shape::Sphere(i) => {
                    let sphere = object.spheres.get(i as usize);
                    let (Some(sphere), Some(scale)) = (sphere, scale) else {
                        left_out += 1;
                        continue;
                    };
                    let center = self.transform.transform_point3(sphere.center);
                    let radius = sphere.radius * scale;
                    checked(center + DVec3::splat(radius), &place)?;
                    self.scene.push_sphere(material, center, radius);
                    continue;
                }
                Shape::Cone(_) => continue,
            };
            self.scene.primitives.push(Primitive { shape, material });
        }
        self.scene.placed_since(before, number, self.transform);
        Ok(left_out)
    }

    fn add_positions(
        &mut self,
        positions: &[DVec3],
        place: impl Fn() -> FilePlace,
    ) -> Result<(), LoadError> {
        self.scene.vertices.reserve(positions.len());
        for &position in positions {
            let placed = self.transform.transform_point3(position);
            let placed = if position.is_nan() { DVec3::NAN } else { checked(placed, &place)? };
            self.scene.vertices.push(placed);
        }
        Ok(())
    }

    /// The place of the first, where there are any.
    fn add_normals(&mut self, normals: &[DVec3]) -> Option<u32> {
        let first = u32::try_from(self.scene.normals.len()).ok()?;
        let turn = cofactor(self.transform);
        let turned = normals.iter().map(|normal| {
            if normal.is_nan() { DVec3::NAN } else { (turn * *normal).normalize_or_zero() }
        });
        self.scene.normals.extend(turned);
        (!normals.is_empty()).then_some(first)
    }
}

fn checked(point: DVec3, place: impl Fn() -> FilePlace) -> Result<DVec3, LoadError> {
    for value in point.to_array() {
        coordinate(value, "a transformed coordinate", &place)?;
    }
    Ok(point)
}

/// Points or normals; NaN where a number cannot be worked with.
fn points(params: &Params, name: &str) -> Result<Vec<DVec3>, LoadError> {
    let numbers = params.any_numbers(name)?;
    let (points, []) = numbers.as_chunks::<3>() else {
        let found = format!("{} numbers", numbers.len());
        return Err(LoadError::syntax(params.place(), &found, format!("three a point ({name})")));
    };
    Ok(points.iter().map(|point| DVec3::from_array(point.map(usable))).collect())
}

fn valid_index(index: f64, count: usize, place: impl Fn() -> FilePlace) -> Result<u32, LoadError> {
    if index >= 0.0 && index < count as f64 && index.fract() == 0.0 {
        return Ok(index as u32);
    }
    let valid = format!("{count} vertices, counted from 0");
    Err(LoadError::bad_index(place(), "vertex", index, valid))
}
