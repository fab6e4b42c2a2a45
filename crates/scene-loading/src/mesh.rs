//! Faces over a list of vertices: what becomes of each, and what is counted. A triangle stays one;
//! a larger flat face is a polygon unless it has normals or triangles are asked for; one that
//! crosses itself is split; faces without area, or with a corner that is NaN, are left out.

use std::collections::HashMap;
use std::path::Path;

use glam::{DMat3, DMat4, DVec3};

use crate::error::{FileLocation, FilePlace, LoadError};
use crate::input::scene_name;
use crate::limits::{self, MAX_ELEMENTS};
use crate::polygon::ear_clipping::{triangulate, triangulate_bent};
use crate::polygon::{Outline, area_vector};
use crate::scene::{Material, Scene, index};

/// Coordinates above this cannot be worked with: their cubes must stay finite.
pub(crate) const MAX_COORDINATE: f64 = 1e100;

/// Declares kinds of things that are not as a file has them, each with the words of its warning.
macro_rules! first_and_counts {
    ($(#[$about:meta])* struct $name:ident {
        $($(#[$kind:meta])* $field:ident: $what:literal,)*
    }) => {
        $(#[$about])*
        #[derive(Debug, Default)]
        pub(crate) struct $name {
            $($(#[$kind])* pub $field: $crate::mesh::FirstAndCount,)*
        }

        impl $name {
            /// One warning for each kind.
            pub fn warn(&self, scene: &mut $crate::scene::Scene) {
                $(self.$field.warn($what, scene);)*
            }
        }
    };
}
pub(crate) use first_and_counts;

first_and_counts! {
    /// Faces that were not taken as they are.
    struct FaceCounts {
        without_area: "faces without area left out",
        /// A corner is NaN, infinite or too large.
        unusable: "faces with a corner that is not usable left out",
        bent: "faces that are not flat split",
        crossing: "faces that cross themselves split at the crossing",
        /// No face can have them.
        vertices: "vertices with a coordinate that is not usable",
        /// They are NaN, infinite or too large, or as many as do not fit.
        normals: "invalid normals: their faces are flat",
    }
}

/// A count, and the place of the first item.
#[derive(Debug, Default)]
pub(crate) struct FirstAndCount {
    count: usize,
    first: Option<FilePlace>,
}

impl FirstAndCount {
    pub fn add(&mut self, place: impl FnOnce() -> FilePlace) {
        self.count += 1;
        self.first.get_or_insert_with(place);
    }

    pub fn is_any(&self) -> bool {
        self.count > 0
    }

    /// A warning where there is anything: how many of what, and where the first is.
    pub fn warn(&self, what: &str, scene: &mut Scene) {
        let Some(FilePlace { file, within }) = &self.first else { return };
        let first = match within {
            FileLocation::Whole => String::new(),
            FileLocation::Line(line) => format!(" (first: line {line})"),
            FileLocation::Byte(byte) => format!(" (first: byte {byte})"),
        };
        scene.warn(format!("{}: {} {what}{first}", file.display(), self.count));
    }
}

/// Range of the vertices of a mesh in a scene, and properties shared by its faces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mesh {
    pub material: u32,
    /// The first vertex in `Scene::vertices`.
    pub first: u32,
    /// The first normal in `Scene::normals`, where each vertex has one.
    pub normals: Option<u32>,
    /// Some of the normals are NaN: faces that have them are flat.
    pub has_bad_normals: bool,
    /// Larger faces are split into triangles.
    pub triangulate: bool,
}

impl Mesh {
    /// A mesh of triangles without normals, whose vertices are the scene's.
    pub fn of_triangles(material: u32) -> Self {
        Self { material, first: 0, normals: None, has_bad_normals: false, triangulate: false }
    }

    /// Adds a face by the places of its corners in the mesh, which must be valid.
    pub fn add(
        &self,
        corners: &[u32],
        scene: &mut Scene,
        counts: &mut FaceCounts,
        place: impl Fn() -> FilePlace,
    ) -> Result<(), LoadError> {
        let point = |&i: &u32| scene.vertices.get(self.first as usize + i as usize).copied();
        let (three, more): ([DVec3; 3], Vec<DVec3>);
        let points = if let [a, b, c] = corners {
            three = [a, b, c].map(|i| point(i).unwrap_or_default());
            &three[..]
        } else {
            more = corners.iter().filter_map(point).collect();
            // a face makes at most as many vertices and primitives as it has corners
            let size = scene.vertices.len().max(scene.primitives.len()) + 3 * corners.len();
            limits::check(size, MAX_ELEMENTS, "the number of vertices or triangles", &place)?;
            &more
        };
        let may_stay = self.normals.is_none() && !self.triangulate;
        add_face(self.material, points, may_stay, scene, counts, place, |piece, scene| {
            self.push(piece.map(|i| corners.get(i).copied().unwrap_or_default()), scene);
        })?;
        Ok(())
    }

    fn push(&self, corners: [u32; 3], scene: &mut Scene) {
        let v = corners.map(|i| self.first.saturating_add(i));
        let first_n = self.normals.filter(|&first| !self.has_bad_normal(corners, first, scene));
        let n = first_n.map(|first| corners.map(|i| first.saturating_add(i)));
        scene.push_corners(self.material, v, n);
    }

    fn has_bad_normal(&self, corners: [u32; 3], first: u32, scene: &Scene) -> bool {
        let normal = |i: u32| scene.normals.get(first as usize + i as usize);
        self.has_bad_normals && corners.iter().any(|&i| normal(i).is_none_or(|n| n.is_nan()))
    }

    /// Puts other points in the places of vertices and normals that are NaN, once no face can have
    /// them: whoever looks at all of them finds finite ones.
    pub fn replace_unusable(&self, scene: &mut Scene) {
        let replace = |all: &mut [DVec3]| {
            let usable = all.iter().find(|v| !v.is_nan()).copied().unwrap_or_default();
            all.iter_mut().filter(|v| v.is_nan()).for_each(|v| *v = usable);
        };
        replace(scene.vertices.get_mut(self.first as usize..).unwrap_or_default());
        if let Some(first) = self.normals {
            replace(scene.normals.get_mut(first as usize..).unwrap_or_default());
        }
    }
}

/// Adds a face: a larger one than a triangle whole where it is flat and `may_stay`, one that crosses
/// itself as the triangles that it encloses, and others by `push`, which gets the places in the
/// face of the corners of each of its triangles. False for one that crosses itself or is left out.
pub(crate) fn add_face(
    material: u32,
    points: &[DVec3],
    may_stay: bool,
    scene: &mut Scene,
    counts: &mut FaceCounts,
    place: impl Fn() -> FilePlace,
    mut push: impl FnMut([usize; 3], &mut Scene),
) -> Result<bool, LoadError> {
    if points.len() == 3 && area_vector(points).is_some() {
        push([0, 1, 2], scene);
        return Ok(true);
    }
    let pieces = match Outline::of(points) {
        Outline::Flat if may_stay => {
            scene.push_polygon(material, points);
            return Ok(true);
        }
        Outline::Flat => triangulate(points),
        Outline::Bent(area) => {
            counts.bent.add(&place);
            triangulate_bent(points, area)
        }
        Outline::Crossing(triangles) => {
            counts.crossing.add(place);
            push_all(material, triangles, scene);
            return Ok(false);
        }
        Outline::Unusable => {
            counts.unusable.add(place);
            return Ok(false);
        }
        Outline::WithoutArea => {
            counts.without_area.add(place);
            return Ok(false);
        }
    };
    let pieces = pieces.map_err(|source| LoadError::Entangled { place: place(), source })?;
    for piece in pieces {
        let piece = piece.map(|i| i as usize);
        if area_vector(&piece.map(|i| points.get(i).copied().unwrap_or_default())).is_some() {
            push(piece, scene);
        }
    }
    Ok(true)
}

/// Adds a polygon with vertices of its own: triangles where it is bent or crosses itself.
pub(crate) fn push_outline(
    material: u32,
    outline: &[DVec3],
    scene: &mut Scene,
    counts: &mut FaceCounts,
    place: impl Fn() -> FilePlace,
) -> Result<(), LoadError> {
    match Outline::of(outline) {
        Outline::Crossing(triangles) => {
            counts.crossing.add(place);
            push_all(material, triangles, scene);
        }
        Outline::Bent(_) => {
            let first = index(scene.vertices.len());
            scene.vertices.extend_from_slice(outline);
            let corners: Vec<u32> = (0..).take(outline.len()).collect();
            let mesh = Mesh { first, ..Mesh::of_triangles(material) };
            return mesh.add(&corners, scene, counts, place);
        }
        _ => scene.push_polygon(material, outline),
    }
    Ok(())
}

/// Adds triangles with vertices of their own.
pub(crate) fn push_all(material: u32, triangles: Vec<[DVec3; 3]>, scene: &mut Scene) {
    triangles.into_iter().for_each(|triangle| scene.push_triangle(material, triangle));
}

/// The scene of a file that lists triangles without indices: corners in the same place become one
/// vertex.
pub(crate) struct TriangleList {
    pub scene: Scene,
    pub counts: FaceCounts,
    mesh: Mesh,
    /// By the bits of their coordinates.
    vertices: HashMap<[u64; 3], u32>,
}

impl TriangleList {
    pub fn new(path: &Path) -> Self {
        let mut scene = Scene::new(scene_name(path));
        let mesh = Mesh::of_triangles(scene.push_material(Material::default()));
        Self { scene, counts: FaceCounts::default(), mesh, vertices: HashMap::new() }
    }

    pub fn add(
        &mut self,
        corners: [[f64; 3]; 3],
        place: impl Fn() -> FilePlace,
    ) -> Result<(), LoadError> {
        let size = self.scene.vertices.len().max(self.scene.primitives.len()) + 3;
        limits::check(size, MAX_ELEMENTS, "the number of vertices or triangles", &place)?;
        let corners = corners.map(|corner| {
            // 0 and -0 are the same place
            let key = corner.map(|x| (x + 0.0).to_bits());
            *self.vertices.entry(key).or_insert_with(|| {
                self.scene.vertices.push(DVec3::from_array(corner));
                index(self.scene.vertices.len() - 1)
            })
        });
        self.mesh.add(&corners, &mut self.scene, &mut self.counts, place)
    }

    /// The scene with its warnings, seen by a camera that frames it.
    ///
    /// # Errors
    /// [`LoadError::NoPrimitives`] where no triangle is left.
    pub fn finish(mut self, path: &Path) -> Result<Scene, LoadError> {
        self.counts.warn(&mut self.scene);
        if self.scene.primitives.is_empty() {
            return Err(LoadError::no_primitives(path, "triangle with an area"));
        }
        self.scene.frame_camera();
        Ok(self.scene)
    }
}

/// Matrix that transforms normals: the cofactors, which keep their orientation under mirroring.
pub(crate) fn cofactor(world: DMat4) -> DMat3 {
    let m = DMat3::from_mat4(world);
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
        * sign
}

/// True for coordinates that can be worked with.
pub(crate) fn is_usable(value: f64) -> bool {
    value.abs() <= MAX_COORDINATE
}

/// A coordinate that can be worked with, or NaN.
pub(crate) fn usable(value: f64) -> f64 {
    if is_usable(value) { value } else { f64::NAN }
}

/// A coordinate that can be worked with.
pub(crate) fn coordinate(
    value: f64,
    what: &str,
    place: impl Fn() -> FilePlace,
) -> Result<f64, LoadError> {
    if is_usable(value) {
        return Ok(value);
    }
    if !value.is_finite() {
        return Err(LoadError::not_finite(place(), what, value));
    }
    let expected = format!("at most {MAX_COORDINATE:e} in size");
    Err(LoadError::out_of_range(place(), what, value, expected))
}
