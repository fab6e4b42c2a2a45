//! The walk over the nodes of a glTF scene, which fills a [`Scene`]. Light colours are scaled so that the strongest light has intensity 1, because lights
//! here do not fall off with distance.

use std::path::Path;

use ::gltf::camera::Projection;
use ::gltf::khr_lights_punctual::Kind;
use ::gltf::mesh::Mode;
use ::gltf::{Document, Node, Semantic};
use glam::{DMat3, DMat4, DVec3};

use crate::error::{FilePlace, LoadError};
use crate::gltf::buffers::Buffers;
use crate::gltf::deform::{self, Deformed, Deformer};
use crate::gltf::materials::material_of;
use crate::gltf::pose::Pose;
use crate::gltf::textures::Textures;
use crate::gltf::tree::{self, Placed};
use crate::gltf::vectors::{cofactor, wide};
use crate::limits::{self, MAX_ELEMENTS, MAX_LIGHTS, MAX_WARNINGS};
use crate::polygon::area_vector;
use crate::progress;
use crate::scene::{Camera, Light, Material, Primitive, Scene, Shape, Texcoords, Warning};

/// Progress is told about this often.
const TOLD_EVERY: usize = 1 << 16;

/// Height in pixels of images from glTF cameras, which state only a ratio of the sides.
const HEIGHT: u32 = 512;

pub(crate) struct Walker<'a> {
    path: &'a Path,
    document: &'a Document,
    buffers: &'a Buffers,
    textures: Textures<'a>,
    scene: Scene,
    /// Scene material of each glTF material; the last is glTF's default, made when needed.
    default_material: Option<u32>,
    lights: Vec<(DVec3, [f64; 3], f64)>,
    /// Of a scene that moves, how it stands.
    pose: Option<&'a Pose>,
    /// Where its nodes are, by their number; none of those that are not in the scene.
    joints: Vec<Option<DMat4>>,
    has_camera: bool,
    without_area: usize,
    points_and_lines: usize,
    unsaid: usize,
}

impl<'a> Walker<'a> {
    pub fn new(
        path: &'a Path,
        document: &'a Document,
        buffers: &'a Buffers,
        mut scene: Scene,
    ) -> Self {
        scene.materials = document.materials().map(|m| material_of(&m)).collect();
        Self {
            path,
            document,
            buffers,
            textures: Textures::new(path, document, buffers),
            scene,
            default_material: None,
            lights: Vec::new(),
            pose: None,
            joints: Vec::new(),
            has_camera: false,
            without_area: 0,
            points_and_lines: 0,
            unsaid: 0,
        }
    }

    /// Has the nodes stand as a pose says.
    pub fn posed(mut self, pose: &'a Pose) -> Self {
        self.pose = Some(pose);
        self
    }

    /// Visits every node of a scene once, parents first.
    pub fn walk(&mut self, scene: &::gltf::Scene<'a>) -> Result<(), LoadError> {
        let placed = tree::placed(self.path, self.document, scene, self.pose)?;
        if self.pose.is_some() {
            self.joints = vec![None; self.document.nodes().len()];
            for node in &placed {
                if let Some(joint) = self.joints.get_mut(node.node.index()) {
                    *joint = Some(node.world);
                }
            }
        }
        placed.iter().try_for_each(|placed| self.visit(placed))
    }

    /// Ends the walk: lights, warnings, and where the file has no camera this one or one that frames the scene.
    pub fn finish(mut self, camera: Option<Camera>) -> Result<Scene, LoadError> {
        if self.scene.primitives.is_empty() {
            let expected = "triangle with an area";
            return Err(LoadError::NoPrimitives { place: FilePlace::file(self.path), expected });
        }
        let strongest = self.lights.iter().map(|light| light.2).fold(0.0, f64::max);
        for (position, color, intensity) in &self.lights {
            let scale = if strongest > 0.0 { intensity / strongest } else { 0.0 };
            let color = Some(color.map(|c| c * scale));
            self.scene.lights.push(Light::Point { position: *position, color });
        }
        if self.without_area > 0 {
            self.warn(format!("{} triangles without area left out", self.without_area));
        }
        if self.points_and_lines > 0 {
            self.warn(format!("{} meshes of points or lines left out", self.points_and_lines));
        }
        let unsaid = self.unsaid + self.textures.unsaid;
        if unsaid > 0 {
            let text = format!("{}: {unsaid} more warnings", self.path.display());
            self.scene.warnings.push(Warning(text));
        }
        match camera {
            _ if self.has_camera => {}
            Some(camera) => self.scene.camera = camera,
            None => self.scene.frame_camera(),
        }
        Ok(self.scene)
    }

    fn warn(&mut self, text: String) {
        if self.scene.warnings.len() >= MAX_WARNINGS {
            self.unsaid += 1;
            return;
        }
        self.scene.warnings.push(Warning(format!("{}: {text}", self.path.display())));
    }

    fn not_finite(&self, what: String) -> LoadError {
        let found = "NaN or infinite".to_string();
        LoadError::NotFinite { place: FilePlace::file(self.path), what, found }
    }

    fn invalid(&self, object: String, found: String, expected: &str) -> LoadError {
        let expected = expected.to_string();
        LoadError::Gltf { place: FilePlace::file(self.path), object, found, expected }
    }

    fn visit(&mut self, placed: &Placed<'_>) -> Result<(), LoadError> {
        let Placed { node, world, is_steady } = placed;
        let world = *world;
        if let Some(camera) = node.camera() {
            self.camera(&camera, world)?;
        }
        if let Some(light) = node.light() {
            let count = self.lights.len() + 1;
            limits::check(count, MAX_LIGHTS, "the number of lights", || {
                FilePlace::file(self.path)
            })?;
            let color = light.color().map(f64::from);
            let intensity = f64::from(light.intensity());
            if !(intensity.is_finite() && intensity >= 0.0 && color.iter().all(|c| c.is_finite())) {
                return Err(self.not_finite(format!("light {}", light.index())));
            }
            match light.kind() {
                Kind::Directional => {
                    self.warn(format!("directional light {} left out", light.index()));
                }
                Kind::Point => self.lights.push((world.w_axis.truncate(), color, intensity)),
                Kind::Spot { .. } => {
                    self.warn(format!("spot light {} taken as a point light", light.index()));
                    self.lights.push((world.w_axis.truncate(), color, intensity));
                }
            }
        }
        if let Some(mesh) = node.mesh() {
            let first = self.scene.primitives.len();
            for primitive in mesh.primitives() {
                self.primitive(node, mesh.index(), &primitive, world)?;
            }
            let determinant = DMat3::from_mat4(world).determinant();
            // mirrored, corners are in another order
            let object = 2 * mesh.index() as u32 + u32::from(determinant < 0.0);
            let is_rigid = *is_steady && determinant != 0.0 && !deform::is_soft(node, &mesh);
            if self.pose.is_none() || is_rigid {
                self.scene.placed_since(first, object, world);
            }
        }
        Ok(())
    }

    fn camera(&mut self, camera: &::gltf::Camera<'_>, world: DMat4) -> Result<(), LoadError> {
        if self.has_camera {
            return Ok(());
        }
        let Projection::Perspective(view) = camera.projection() else {
            self.warn(format!("orthographic camera {} left out", camera.index()));
            return Ok(());
        };
        let aspect = f64::from(view.aspect_ratio().unwrap_or(1.0)).clamp(0.01, 100.0);
        let from = world.w_axis.truncate();
        let converted = Camera {
            from,
            at: from - world.z_axis.truncate().normalize_or_zero(),
            up: world.y_axis.truncate().normalize_or_zero(),
            angle: f64::from(view.yfov()).to_degrees(),
            hither: f64::from(view.znear()),
            // At most 51,200.
            resolution: [(aspect * f64::from(HEIGHT)).round().max(1.0) as u32, HEIGHT],
            ..Camera::default()
        };
        converted.check(|| FilePlace::file(self.path))?;
        self.scene.camera = converted;
        self.has_camera = true;
        Ok(())
    }

    fn primitive(
        &mut self,
        node: &Node<'_>,
        mesh: usize,
        primitive: &::gltf::Primitive<'_>,
        world: DMat4,
    ) -> Result<(), LoadError> {
        let object = || format!("mesh {mesh} primitive {}", primitive.index());
        if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            self.points_and_lines += 1;
            return Ok(());
        }
        let Some(accessor) = primitive.get(&Semantic::Positions) else {
            return Err(self.invalid(object(), "no POSITION".into(), "an accessor of positions"));
        };
        let positions = self.buffers.vectors(accessor, "positions")?;
        let normals = match primitive.get(&Semantic::Normals) {
            Some(accessor) => self.buffers.vectors(accessor, "normals")?,
            None => Vec::new(),
        };
        if !normals.is_empty() && normals.len() != positions.len() {
            let found = format!("{} normals for {} positions", normals.len(), positions.len());
            return Err(self.invalid(object(), found, "as many normals as positions"));
        }
        let indices = match primitive.indices() {
            Some(accessor) => self.buffers.indices(accessor, positions.len())?,
            None => (0..positions.len() as u32).collect(),
        };
        if primitive.mode() == Mode::Triangles && indices.len() % 3 != 0 {
            let found = format!("{} indices", indices.len());
            return Err(self.invalid(object(), found, "a multiple of 3"));
        }
        self.check_room(positions.len(), triangles(primitive.mode(), &indices).len())?;
        let material = match primitive.material().index() {
            // The crate's validation keeps the index within the table.
            Some(index) => index as u32,
            None => self.default_material(),
        };
        let texcoords = self.texcoords(mesh, primitive, positions.len())?;
        let deformed = match self.pose {
            Some(pose) => {
                let place = Deformer { buffers: self.buffers, pose, joints: &self.joints };
                place.deformed(node, primitive, &positions, &normals, world)?
            }
            None => None,
        };
        let first = match &deformed {
            Some(Deformed { positions, normals, world }) => {
                self.push_vertices(positions.iter().copied(), normals.iter().copied(), *world)
            }
            None => self.push_vertices(positions.iter().map(wide), normals.iter().map(wide), world),
        };
        if first.is_none() {
            return Err(self.not_finite(format!("{}: a transformed position", object())));
        }
        let (first, first_n) = first.unwrap_or_default();
        let all = triangles(primitive.mode(), &indices);
        let (count, mirrored) = (all.len(), DMat3::from_mat4(world).determinant() < 0.0);
        progress::begin(count);
        for (i, [a, b, c]) in all.enumerate() {
            if i % TOLD_EVERY == 0 {
                progress::at(i);
            }
            let corners = if mirrored { [a, c, b] } else { [a, b, c] };
            let v = corners.map(|i| first + i);
            let n = (!normals.is_empty()).then(|| corners.map(|i| first_n + i));
            let uv = |i: u32| texcoords.as_deref()?.get(i as usize).copied();
            let uv = match corners.map(uv) {
                [Some(a), Some(b), Some(c)] => Some([a, b, c]),
                _ => None,
            };
            // one that moves is kept in all frames or in none
            let flat = match self.pose {
                Some(_) => corners.map(|i| positions.get(i as usize).map(wide).unwrap_or_default()),
                None => v.map(|i| self.scene.vertices.get(i as usize).copied().unwrap_or_default()),
            };
            match area_vector(&flat) {
                Some(_) => self.triangle(material, v, n, uv),
                None => self.without_area += 1,
            }
        }
        progress::end();
        Ok(())
    }

    /// Texture coordinates of the vertices, where the material has a texture.
    fn texcoords(
        &mut self,
        mesh: usize,
        primitive: &::gltf::Primitive<'_>,
        vertices: usize,
    ) -> Result<Option<Vec<[f32; 2]>>, LoadError> {
        let Some(set) = self.textures.of(&primitive.material(), &mut self.scene) else {
            return Ok(None);
        };
        let object = format!("mesh {mesh} primitive {}", primitive.index());
        let Some(accessor) = primitive.get(&Semantic::TexCoords(set)) else {
            self.warn(format!("{object}: no TEXCOORD_{set}, so its texture is not shown"));
            return Ok(None);
        };
        let texcoords = self.buffers.texcoords(accessor)?;
        if texcoords.len() != vertices {
            let found = format!("{} texture coordinates for {vertices}", texcoords.len());
            return Err(self.invalid(object, found, "as many as positions"));
        }
        Ok(Some(texcoords))
    }

    fn check_room(&self, vertices: usize, triangles: usize) -> Result<(), LoadError> {
        let vertices = self.scene.vertices.len() + vertices;
        let triangles = self.scene.primitives.len() + triangles;
        let what = "the number of vertices or triangles of all instances";
        limits::check(vertices.max(triangles), MAX_ELEMENTS, what, || FilePlace::file(self.path))
    }

    fn default_material(&mut self) -> u32 {
        let scene = &mut self.scene;
        *self.default_material.get_or_insert_with(|| {
            // glTF's default: white, metallic 1, roughness 1.
            scene.push_material(Material { color: [1.0; 3], ..Material::default() })
        })
    }

    /// Adds transformed vertices; `None` when one is not finite. Returns the first indices.
    fn push_vertices(
        &mut self,
        positions: impl Iterator<Item = DVec3>,
        normals: impl Iterator<Item = DVec3>,
        world: DMat4,
    ) -> Option<(u32, u32)> {
        let first = u32::try_from(self.scene.vertices.len()).ok()?;
        let first_n = u32::try_from(self.scene.normals.len()).ok()?;
        for p in positions {
            let p = world.transform_point3(p);
            if !p.is_finite() {
                return None;
            }
            self.scene.vertices.push(p);
        }
        // Normals transform by the cofactor matrix, which also exists for flattening transforms.
        let cofactor = cofactor(world);
        self.scene.normals.extend(normals.map(|n| (cofactor * n).normalize_or_zero()));
        Some((first, first_n))
    }

    fn triangle(
        &mut self,
        material: u32,
        v: [u32; 3],
        n: Option<[u32; 3]>,
        texcoords: Option<Texcoords>,
    ) {
        let scene = &mut self.scene;
        let usable = |n: &[u32; 3]| {
            n.iter().all(|&i| scene.normals.get(i as usize).is_some_and(|n| *n != DVec3::ZERO))
        };
        let shape = match n.filter(usable) {
            Some(n) => Shape::Patch { v, n },
            None => Shape::Triangle { v },
        };
        scene.primitives.push(Primitive { shape, material });
        if let Some(texcoords) = texcoords {
            scene.last_is_textured(texcoords);
        }
    }
}

/// The triangles of a list, strip or fan, each wound as the format asks.
fn triangles(mode: Mode, indices: &[u32]) -> impl ExactSizeIterator<Item = [u32; 3]> {
    let corner = |i: usize| indices.get(i).copied().unwrap_or(0);
    let count = match mode {
        Mode::TriangleStrip | Mode::TriangleFan => indices.len().saturating_sub(2),
        _ => indices.len() / 3,
    };
    (0..count).map(move |i| match mode {
        Mode::TriangleStrip => [corner(i), corner(i + 1 + i % 2), corner(i + 2 - i % 2)],
        Mode::TriangleFan => [corner(i + 1), corner(i + 2), corner(0)],
        _ => [corner(3 * i), corner(3 * i + 1), corner(3 * i + 2)],
    })
}
