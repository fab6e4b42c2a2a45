//! The meshes of glTF nodes: their primitives as triangles of a scene, posed and placed.

use ::gltf::Semantic;
use ::gltf::mesh::Mode;
use glam::{DMat3, DMat4, DVec3};

use crate::error::{LoadError, NOT_FINITE};
use crate::gltf::deform::{self, DeformedMesh, wide};
use crate::gltf::nodes::NodeWalker;
use crate::gltf::tree::{self, PlacedNode};
use crate::limits::{self, MAX_ELEMENTS};
use crate::mesh::cofactor;
use crate::polygon::area_vector;
use crate::progress;
use crate::scene::{Material, Texcoords};

/// The most instances of `EXT_mesh_gpu_instancing` of a scene.
const MAX_INSTANCES: usize = 16 << 20;

/// A primitive as it is at its node, before it is placed in the world.
struct ReadPrimitive {
    /// How errors and warnings name it.
    object: String,
    positions: Vec<[f32; 3]>,
    /// As many as positions, or none.
    normals: Vec<[f32; 3]>,
    mode: Mode,
    indices: Vec<u32>,
    material: u32,
    texcoords: Option<Vec<[f32; 2]>>,
    deformed: Option<DeformedMesh>,
}

impl ReadPrimitive {
    fn triangles(&self) -> impl ExactSizeIterator<Item = [u32; 3]> {
        triangles(self.mode, &self.indices)
    }
}

impl NodeWalker<'_> {
    /// Adds the mesh of a node.
    pub(super) fn mesh(&mut self, placed: &PlacedNode<'_>) -> Result<(), LoadError> {
        let PlacedNode { node, world, .. } = placed;
        let Some(mesh) = node.mesh() else { return Ok(()) };
        if placed.is_hidden {
            self.counts.hidden.add(|| self.file.place());
            return Ok(());
        }
        if self.file.extensions.instancing.contains_key(&node.index()) {
            match node.skin() {
                None => return self.instances(placed, &mesh),
                Some(_) => self.warn(format!("node {} has a skin: no instances", node.index())),
            }
        }
        let first = self.scene.primitives.len();
        let mut is_deformed = false;
        for primitive in mesh.primitives() {
            let Some(read) = self.read(placed, &mesh, &primitive)? else { continue };
            self.check_room(read.positions.len(), read.triangles().len())?;
            is_deformed |= read.deformed.is_some();
            self.place(&read, *world)?;
        }
        if !self.is_soft(placed, &mesh, is_deformed) {
            self.claim(placed, mesh.index(), first, *world);
        }
        Ok(())
    }

    /// Adds the instances of the mesh of a node.
    fn instances(
        &mut self,
        placed: &PlacedNode<'_>,
        mesh: &::gltf::Mesh<'_>,
    ) -> Result<(), LoadError> {
        let mut all = Vec::new();
        let (mut vertices, mut triangles) = (0, 0);
        for primitive in mesh.primitives() {
            let Some(read) = self.read(placed, mesh, &primitive)? else { continue };
            vertices += read.positions.len();
            triangles += read.triangles().len();
            self.check_room(vertices, triangles)?;
            all.push(read);
        }
        if all.is_empty() {
            return Ok(());
        }
        let node = &placed.node;
        let placements = tree::placements(self.file, node)?;
        let placements = placements.unwrap_or_else(|| vec![DMat4::IDENTITY]);
        self.instances += placements.len();
        limits::check(self.instances, MAX_INSTANCES, "the number of instances", || {
            self.file.place()
        })?;
        let count = placements.len();
        self.check_room(vertices.saturating_mul(count), triangles.saturating_mul(count))?;
        let is_deformed = all.iter().any(|read| read.deformed.is_some());
        let is_soft = self.is_soft(placed, mesh, is_deformed);
        for placement in placements {
            let world = placed.world * placement;
            if DMat3::from_mat4(world) == DMat3::ZERO {
                self.counts.hidden.add(|| self.file.place());
                continue;
            }
            let first = self.scene.primitives.len();
            all.iter().try_for_each(|read| self.place(read, world))?;
            if !is_soft {
                self.claim(placed, mesh.index(), first, world);
            }
        }
        Ok(())
    }

    /// Returns whether a mesh has another shape here than elsewhere, or has in another pose.
    fn is_soft(&self, placed: &PlacedNode<'_>, mesh: &::gltf::Mesh<'_>, is_deformed: bool) -> bool {
        is_deformed || self.pose.is_some() && deform::is_soft(&placed.node, mesh)
    }

    /// Claims the primitives from `first` on as an instance of a mesh, if they are so in all poses.
    fn claim(&mut self, placed: &PlacedNode<'_>, mesh: usize, first: usize, world: DMat4) {
        let determinant = DMat3::from_mat4(world).determinant();
        // mirrored, corners are in another order
        let object = 2 * mesh as u32 + u32::from(determinant < 0.0);
        if self.pose.is_none() || placed.is_steady && determinant != 0.0 {
            self.scene.placed_since(first, object, world);
        }
    }

    /// Reads a primitive; none where there is nothing to be seen of it.
    fn read(
        &mut self,
        placed: &PlacedNode<'_>,
        mesh: &::gltf::Mesh<'_>,
        primitive: &::gltf::Primitive<'_>,
    ) -> Result<Option<ReadPrimitive>, LoadError> {
        let object = format!("mesh {} primitive {}", mesh.index(), primitive.index());
        let mode = primitive.mode();
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            self.counts.points_and_lines.add(|| self.file.place());
            return Ok(None);
        }
        let Some(accessor) = primitive.get(&Semantic::Positions) else {
            self.counts.without_positions.add(|| self.file.place());
            return Ok(None);
        };
        let count = |accessor: &::gltf::Accessor<'_>| accessor.count();
        if accessor.count() == 0 || primitive.indices().as_ref().is_some_and(|i| count(i) == 0) {
            self.counts.empty.add(|| self.file.place());
            return Ok(None);
        }
        let position_accessor = accessor.index();
        let mut positions = self.file.buffers.vectors(accessor, "positions")?;
        let indices = match primitive.indices() {
            Some(accessor) => self.file.buffers.indices(accessor, positions.len())?,
            None => (0..positions.len() as u32).collect(),
        };
        self.check_positions(position_accessor, &mut positions, &indices)?;
        if triangles(mode, &indices).len() == 0 {
            self.counts.empty.add(|| self.file.place());
            return Ok(None);
        }
        if mode == Mode::Triangles && indices.len() % 3 != 0 {
            self.counts.incomplete.add(|| self.file.place());
        }
        let normals = self.normals(&object, primitive, positions.len())?;
        let scene = &mut self.scene;
        let material = match primitive.material().index() {
            // the crate's validation keeps the index within the table
            Some(index) => index as u32,
            // glTF's default: white, metallic 1, roughness 1
            None => *self.default_material.get_or_insert_with(|| {
                scene.push_material(Material { color: [1.0; 3], ..Material::default() })
            }),
        };
        let texcoords = self.texcoords(&object, primitive, positions.len())?;
        if primitive.get(&Semantic::Colors(0)).is_some() {
            self.counts.coloured.add(|| self.file.place());
        }
        let node = &placed.node;
        let (deformed, unbent) = self.deformer.deformed(node, primitive, &positions, &normals)?;
        if let Some(why) = unbent {
            let node = node.index();
            self.warn(format!("{object} {why}, so at node {node} it follows no skin"));
        }
        Ok(Some(ReadPrimitive {
            object,
            positions,
            normals,
            mode,
            indices,
            material,
            texcoords,
            deformed,
        }))
    }

    /// Refuses a triangle whose corner is not finite; puts other such vertices in the origin.
    fn check_positions(
        &mut self,
        accessor: usize,
        positions: &mut [[f32; 3]],
        indices: &[u32],
    ) -> Result<(), LoadError> {
        let is_bad = |position: &[f32; 3]| position.iter().any(|x| !x.is_finite());
        if !positions.iter().any(is_bad) {
            return Ok(());
        }
        for &i in indices {
            let corner = positions.get(i as usize).into_iter().flatten();
            if let Some(&found) = corner.into_iter().find(|x| !x.is_finite()) {
                let (i, found) = (i as usize, f64::from(found));
                return Err(self.file.buffers.not_finite(accessor, "positions", i, found));
            }
        }
        for position in positions.iter_mut().filter(|position| is_bad(position)) {
            *position = [0.0; 3];
            self.counts.unused_vertices.add(|| self.file.place());
        }
        Ok(())
    }

    /// The normals of the vertices; 0 where the file has one that is not finite.
    fn normals(
        &mut self,
        object: &str,
        primitive: &::gltf::Primitive<'_>,
        vertices: usize,
    ) -> Result<Vec<[f32; 3]>, LoadError> {
        let Some(accessor) = primitive.get(&Semantic::Normals) else { return Ok(Vec::new()) };
        let mut normals = self.file.buffers.vectors(accessor, "normals")?;
        if normals.len() != vertices {
            let found = format!("{} normals for {vertices} positions", normals.len());
            let expected = "as many normals as positions";
            return Err(LoadError::gltf(&self.file.path, object, found, expected));
        }
        for normal in &mut normals {
            if !normal.iter().all(|x| x.is_finite()) {
                *normal = [0.0; 3];
                self.counts.normals.add(|| self.file.place());
            }
        }
        Ok(normals)
    }

    /// Texture coordinates of the vertices, where the material has a texture.
    fn texcoords(
        &mut self,
        object: &str,
        primitive: &::gltf::Primitive<'_>,
        vertices: usize,
    ) -> Result<Option<Vec<[f32; 2]>>, LoadError> {
        let Some(set) = self.textures.of(&primitive.material(), &mut self.scene) else {
            return Ok(None);
        };
        let Some(accessor) = primitive.get(&Semantic::TexCoords(set)) else {
            self.warn(format!("{object}: no TEXCOORD_{set}, so its texture is ignored"));
            return Ok(None);
        };
        let mut texcoords = self.file.buffers.texcoords(accessor)?;
        if texcoords.len() != vertices {
            let found = format!("{} texture coordinates for {vertices}", texcoords.len());
            return Err(LoadError::gltf(&self.file.path, object, found, "as many as positions"));
        }
        for texcoord in texcoords.iter_mut().filter(|uv| !uv.iter().all(|x| x.is_finite())) {
            *texcoord = [0.0; 2];
            self.counts.texcoords.add(|| self.file.place());
        }
        Ok(Some(texcoords))
    }

    fn check_room(&self, vertices: usize, triangles: usize) -> Result<(), LoadError> {
        let vertices = self.scene.vertices.len().saturating_add(vertices);
        let triangles = self.scene.primitives.len().saturating_add(triangles);
        let what = "the number of vertices or triangles of all instances";
        limits::check(vertices.max(triangles), MAX_ELEMENTS, what, || self.file.place())
    }

    /// Adds the triangles of a primitive under a transform.
    fn place(&mut self, read: &ReadPrimitive, world: DMat4) -> Result<(), LoadError> {
        let ReadPrimitive { positions, normals, texcoords, deformed, .. } = read;
        let (world, is_mirrored) = match deformed.as_ref().and_then(|d| d.is_mirrored) {
            // the vertices of a skinned mesh are in the world: its node's transform is ignored
            Some(is_mirrored) => (DMat4::IDENTITY, is_mirrored),
            None => (world, DMat3::from_mat4(world).determinant() < 0.0),
        };
        let first = match deformed {
            Some(DeformedMesh { positions, normals, .. }) => {
                self.push_vertices(positions.iter().copied(), normals.iter().copied(), world)
            }
            None => self.push_vertices(positions.iter().map(wide), normals.iter().map(wide), world),
        };
        let Some((first, first_normal)) = first else {
            let what = format!("{}: a transformed position", read.object);
            return Err(LoadError::not_finite(self.file.place(), what, NOT_FINITE));
        };
        let all = read.triangles();
        progress::begin(all.len());
        for (i, [a, b, c]) in all.enumerate() {
            progress::step(i);
            let corners = if is_mirrored { [a, c, b] } else { [a, b, c] };
            let v = corners.map(|i| first + i);
            let n = (!normals.is_empty()).then(|| corners.map(|i| first_normal + i));
            let uv = |i: u32| texcoords.as_deref()?.get(i as usize).copied();
            let uv = match corners.map(uv) {
                [Some(a), Some(b), Some(c)] => Some([a, b, c]),
                _ => None,
            };
            // one that moves is kept in all frames or in none
            let points = match self.pose {
                Some(_) => corners.map(|i| positions.get(i as usize).map(wide).unwrap_or_default()),
                None => v.map(|i| self.scene.vertices.get(i as usize).copied().unwrap_or_default()),
            };
            match area_vector(&points) {
                Some(_) => self.triangle(read.material, v, n, uv),
                None => self.counts.without_area.add(|| self.file.place()),
            }
        }
        progress::end();
        Ok(())
    }

    /// Adds transformed vertices; `None` when one is not finite. Returns the first indices.
    fn push_vertices(
        &mut self,
        positions: impl Iterator<Item = DVec3>,
        normals: impl Iterator<Item = DVec3>,
        world: DMat4,
    ) -> Option<(u32, u32)> {
        let first = u32::try_from(self.scene.vertices.len()).ok()?;
        let first_normal = u32::try_from(self.scene.normals.len()).ok()?;
        for p in positions {
            let p = world.transform_point3(p);
            if !p.is_finite() {
                return None;
            }
            self.scene.vertices.push(p);
        }
        // normals transform by the cofactor matrix, which also exists for flattening transforms
        let cofactor = cofactor(world);
        self.scene.normals.extend(normals.map(|n| (cofactor * n).normalize_or_zero()));
        Some((first, first_normal))
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
        let n = n.filter(usable);
        scene.push_corners(material, v, n);
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
