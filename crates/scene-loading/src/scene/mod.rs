//! The one scene type that every loader and generator fills, in f64.
//!
//! Primitives keep the order of their source (their index is their id everywhere: in hits, in
//! tie-breaking, in counters). Vertices and normals are shared arrays that shapes index into.

mod appearance;
pub(crate) mod origin;

use glam::{DAffine3, DMat4, DVec3};

pub use crate::scene::appearance::{Camera, Light, Material, Rgb, SampleWishes, Texture, Wrap};
pub(crate) use crate::scene::appearance::{NO_HIGHLIGHT, at_least_0, checked};

/// Texture coordinates of the three corners of a triangle.
pub type Texcoords = [[f32; 2]; 3];

/// One primitive: its shape and the material it is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Primitive {
    pub shape: Shape,
    pub material: u32,
}

/// Geometry of a primitive: indices into the scene's arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    Sphere(u32),
    Cone(u32),
    /// A planar polygon, concave ones too: `count` vertices from `first` in `Scene::vertices`.
    Polygon {
        first: u32,
        /// Number of vertices, at least 3.
        count: u32,
    },
    /// A flat triangle: three indices into `Scene::vertices`.
    Triangle {
        v: [u32; 3],
    },
    /// A triangle with a shading normal at each vertex.
    Patch {
        /// Vertex indices into `Scene::vertices`.
        v: [u32; 3],
        /// Normal indices into `Scene::normals`.
        n: [u32; 3],
    },
}

/// A sphere; world units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    pub center: DVec3,
    pub radius: f64,
}

/// A truncated cone without caps; a cylinder when the radii are equal.
///
/// As in NFF, it is one-sided: positive radii show the outside, negative radii the inside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Centre of the base disc.
    pub base: DVec3,
    /// Radius at the base.
    pub base_radius: f64,
    /// Centre of the apex disc.
    pub apex: DVec3,
    /// Radius at the apex.
    pub apex_radius: f64,
}

/// A scene: camera, lights, materials and primitives, in one right-handed world space.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scene {
    /// Short name, used in tables: `balls`, `balls:5`, `kitchen`.
    pub name: String,
    /// The view. Loaders of formats without a camera leave [`Camera::default`]; see
    /// [`Scene::frame_camera`].
    pub camera: Camera,
    /// Colour of rays that hit nothing.
    pub background: Rgb,
    /// Light sources, in file order.
    pub lights: Vec<Light>,
    /// Materials; primitives index into this.
    pub materials: Vec<Material>,
    /// Vertex positions shared by polygons, triangles and patches.
    pub vertices: Vec<DVec3>,
    /// Shading normals shared by patches; not necessarily of unit length.
    pub normals: Vec<DVec3>,
    /// Spheres, indexed by [`Shape::Sphere`].
    pub spheres: Vec<Sphere>,
    /// Truncated cones and cylinders, indexed by [`Shape::Cone`].
    pub cones: Vec<Cone>,
    /// All primitives in source order; the position is the primitive's id.
    pub primitives: Vec<Primitive>,
    /// How fast primitives move, by id, in world units per unit of time; those beyond the end of
    /// the list are at rest. Positions in the scene are those of the moment the shutter opens.
    pub velocities: Vec<DVec3>,
    /// Images that materials refer to; empty where nothing is textured.
    pub textures: Vec<Texture>,
    /// Texture coordinates of the corners of triangles and patches, by id; those beyond the end of
    /// the list have none. (0, 0) is the upper left corner of the image, (1, 1) the lower right.
    pub texcoords: Vec<Option<Texcoords>>,
    /// Objects that stand several times, as the source said. Claims: what became of the primitives
    /// since, nobody looks after here.
    pub instances: Vec<Instance>,
    /// How finely the scene asks its effects to be sampled.
    pub samples: SampleWishes,
    /// Problems that a loader tolerated (missing material file, dropped faces, ...).
    pub warnings: Vec<Warning>,
    /// Origin of all coordinates here in those of the file: 0 unless the scene is far from the
    /// file's origin. Users give and see coordinates of the file, by
    /// [`Scene::to_file_coordinates`].
    pub origin: DVec3,
    /// Set where primitives are too small for f32; f64 resolves them.
    pub fine_detail: Option<Warning>,
}

/// Consecutive primitives that are an object at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// Object number, shared by all its instances.
    pub object: u32,
    /// The id of its first primitive.
    pub first: u32,
    pub count: u32,
    /// From the object's own space to the world.
    pub placement: DAffine3,
}

/// Something a loader noticed and went on from; the text names file and line where there are any.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning(pub String);

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

/// An axis-aligned box in f64 (`min > max` when empty).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    pub min: DVec3,
    pub max: DVec3,
}

impl Bounds {
    pub const EMPTY: Self =
        Self { min: DVec3::splat(f64::INFINITY), max: DVec3::splat(f64::NEG_INFINITY) };

    /// Grows the box so that it holds `p`.
    pub fn include(&mut self, p: DVec3) {
        self.min = self.min.min(p);
        self.max = self.max.max(p);
    }

    /// Edge lengths; negative when empty.
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// The largest coordinate in size; infinite when empty.
    pub fn reach(&self) -> f64 {
        self.min.abs().max(self.max.abs()).max_element()
    }

    /// True when nothing was included.
    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }
}

impl Scene {
    /// An empty scene of that name.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    /// The same with the default material, and the index of that.
    pub fn of_one_material(name: impl Into<String>) -> (Self, u32) {
        let mut scene = Self::new(name);
        let material = scene.push_material(Material::default());
        (scene, material)
    }

    /// Adds a material and returns its index.
    pub fn push_material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        index(self.materials.len() - 1)
    }

    pub fn push_sphere(&mut self, material: u32, center: DVec3, radius: f64) {
        self.spheres.push(Sphere { center, radius });
        let shape = Shape::Sphere(index(self.spheres.len() - 1));
        self.primitives.push(Primitive { shape, material });
    }

    /// Adds a truncated cone (a cylinder when the radii are equal).
    pub fn push_cone(&mut self, material: u32, cone: Cone) {
        self.cones.push(cone);
        let shape = Shape::Cone(index(self.cones.len() - 1));
        self.primitives.push(Primitive { shape, material });
    }

    /// Adds a planar polygon with its own copies of the vertices.
    pub fn push_polygon(&mut self, material: u32, vertices: &[DVec3]) {
        let first = index(self.vertices.len());
        self.vertices.extend_from_slice(vertices);
        let shape = Shape::Polygon { first, count: index(vertices.len()) };
        self.primitives.push(Primitive { shape, material });
    }

    /// Adds a triangle with its own copies of the vertices.
    pub fn push_triangle(&mut self, material: u32, vertices: [DVec3; 3]) {
        self.push_mesh(material, vertices, [[0, 1, 2]]);
    }

    /// Adds vertices, and triangles over them: indices count from the first of the vertices.
    pub(crate) fn push_mesh(
        &mut self,
        material: u32,
        vertices: impl IntoIterator<Item = DVec3>,
        triangles: impl IntoIterator<Item = [u32; 3]>,
    ) {
        let first = index(self.vertices.len());
        self.vertices.extend(vertices);
        self.primitives.extend(triangles.into_iter().map(|triangle| {
            let v = triangle.map(|i| first.saturating_add(i));
            Primitive { shape: Shape::Triangle { v }, material }
        }));
    }

    /// Adds a triangle by the indices of its vertices; with those of normals it is a patch.
    pub(crate) fn push_corners(&mut self, material: u32, v: [u32; 3], n: Option<[u32; 3]>) {
        let shape = n.map_or(Shape::Triangle { v }, |n| Shape::Patch { v, n });
        self.primitives.push(Primitive { shape, material });
    }

    /// Adds a triangular patch (vertices with normals) with its own copies of both.
    pub fn push_patch(&mut self, material: u32, vertices: [DVec3; 3], normals: [DVec3; 3]) {
        let first = index(self.vertices.len());
        let first_n = index(self.normals.len());
        self.vertices.extend_from_slice(&vertices);
        self.normals.extend_from_slice(&normals);
        let [v, n] = [first, first_n].map(|first| [first, first + 1, first + 2]);
        self.push_corners(material, v, Some(n));
    }

    /// The vertices of a polygon, triangle or patch; empty for other shapes. What is not there
    /// is left out.
    pub fn outline(&self, shape: Shape) -> Vec<DVec3> {
        self.corners(shape).collect()
    }

    fn corners(&self, shape: Shape) -> impl Iterator<Item = DVec3> {
        let (whole, three) = match shape {
            Shape::Sphere(_) | Shape::Cone(_) => (None, None),
            Shape::Polygon { first, count } => {
                let (first, count) = (first as usize, count as usize);
                (self.vertices.get(first..first.saturating_add(count)), None)
            }
            Shape::Triangle { v } | Shape::Patch { v, .. } => (None, Some(v)),
        };
        let three = three.into_iter().flatten();
        let three = three.filter_map(|i| self.vertices.get(i as usize));
        whole.unwrap_or_default().iter().chain(three).copied()
    }

    pub(crate) fn warn(&mut self, text: impl Into<String>) {
        self.warnings.push(Warning(text.into()));
    }

    /// Notes that the primitives from `first` on are an instance of an object.
    pub fn placed_since(&mut self, first: usize, object: u32, placement: DMat4) {
        let (first, placement) = (index(first), DAffine3::from_mat4(placement));
        let count = index(self.primitives.len()).saturating_sub(first);
        if count > 0 {
            self.instances.push(Instance { object, first, count, placement });
        }
    }

    /// How fast a primitive moves, in world units per unit of time.
    pub fn velocity(&self, id: u32) -> DVec3 {
        self.velocities.get(id as usize).copied().unwrap_or(DVec3::ZERO)
    }

    /// Gives the last primitive a velocity, in world units per unit of time.
    pub fn last_moves(&mut self, velocity: DVec3) {
        self.moves_since(self.primitives.len().saturating_sub(1), velocity);
    }

    /// Gives the primitives from `first` on a velocity.
    pub fn moves_since(&mut self, first: usize, velocity: DVec3) {
        if velocity != DVec3::ZERO && first < self.primitives.len() {
            self.velocities.resize(first, DVec3::ZERO);
            self.velocities.resize(self.primitives.len(), velocity);
        }
    }

    /// Texture coordinates of the corners of a primitive.
    pub fn texcoords_of(&self, id: u32) -> Option<Texcoords> {
        self.texcoords.get(id as usize).copied().flatten()
    }

    /// Gives the last primitive, a triangle or patch, texture coordinates.
    pub fn last_is_textured(&mut self, texcoords: Texcoords) {
        if let Some(before) = self.primitives.len().checked_sub(1) {
            self.texcoords.resize(before, None);
            self.texcoords.push(Some(texcoords));
        }
    }

    /// Tight bounds of one shape (of a cone: of its two rim circles).
    pub fn shape_bounds(&self, shape: Shape) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        match shape {
            Shape::Sphere(i) => {
                let Some(s) = self.spheres.get(i as usize) else { return bounds };
                bounds.include(s.center - DVec3::splat(s.radius.abs()));
                bounds.include(s.center + DVec3::splat(s.radius.abs()));
            }
            Shape::Cone(i) => {
                let Some(c) = self.cones.get(i as usize) else { return bounds };
                let w = (c.apex - c.base).normalize_or_zero();
                let reach = (DVec3::ONE - w * w).max(DVec3::ZERO).map(f64::sqrt);
                for (center, radius) in [(c.base, c.base_radius), (c.apex, c.apex_radius)] {
                    bounds.include(center - reach * radius.abs());
                    bounds.include(center + reach * radius.abs());
                }
            }
            Shape::Polygon { .. } | Shape::Triangle { .. } | Shape::Patch { .. } => {
                self.corners(shape).for_each(|p| bounds.include(p));
            }
        }
        bounds
    }

    /// Bounds of all primitives, of moving ones over the time that the shutter is open.
    pub fn bounds(&self) -> Bounds {
        self.bounds_seen(|_| {})
    }

    /// [`Scene::bounds`]; `each` sees those of every primitive as the shutter opens.
    fn bounds_seen(&self, mut each: impl FnMut(&Bounds)) -> Bounds {
        let mut all = Bounds::EMPTY;
        for primitive in &self.primitives {
            let b = self.shape_bounds(primitive.shape);
            each(&b);
            all.include(b.min);
            all.include(b.max);
        }
        for (primitive, velocity) in self.primitives.iter().zip(&self.velocities) {
            let b = self.shape_bounds(primitive.shape);
            if *velocity != DVec3::ZERO && !b.is_empty() {
                all.include(b.min + *velocity * self.camera.shutter);
                all.include(b.max + *velocity * self.camera.shutter);
            }
        }
        all
    }

    /// True when every primitive is a triangle or a patch, so that a pure triangle set serves.
    pub fn is_triangles_only(&self) -> bool {
        self.primitives
            .iter()
            .all(|p| matches!(p.shape, Shape::Triangle { .. } | Shape::Patch { .. }))
    }

    /// Points the camera at the whole scene from the front, above and right of it: what scenes
    /// without a camera get.
    pub fn frame_camera(&mut self) {
        let bounds = self.bounds();
        if bounds.is_empty() {
            return;
        }
        let center = (bounds.min + bounds.max) * 0.5;
        // far from the origin the eye must still differ from the centre
        let radius =
            (bounds.size().length() * 0.5).max(bounds.reach() * 1e-9).max(f64::MIN_POSITIVE);
        let angle: f64 = 45.0;
        let distance = radius / (angle.to_radians() * 0.5).sin();
        self.camera = Camera {
            from: center + DVec3::new(0.5, 0.4, 1.0).normalize() * distance,
            at: center,
            up: DVec3::Y,
            angle,
            hither: 0.0,
            ..self.camera
        };
    }
}

/// The index of an element of a scene. Loaders check sizes first; beyond, it is that of nothing.
pub(crate) fn index(i: usize) -> u32 {
    u32::try_from(i).unwrap_or(u32::MAX)
}
