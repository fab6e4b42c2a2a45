//! The walk over the nodes of a glTF scene, which fills a [`Scene`]. Light colours are scaled so
//! that the strongest light has intensity 1, because lights here do not fall off with distance.

use crate::error::LoadError;
use crate::gltf::clip::Pose;
use crate::gltf::container::OpenedFile;
use crate::gltf::deform::Deformer;
use crate::gltf::extensions;
use crate::gltf::textures::Textures;
use crate::gltf::tree;
use crate::input::scene_name;
use crate::limits::{self, MAX_LIGHTS, MAX_WARNINGS};
use crate::mesh::first_and_counts;
use crate::scene::{Camera, Light, Material, Scene};
use ::gltf::camera::Projection;
use ::gltf::khr_lights_punctual::Kind;
use ::gltf::material::AlphaMode;
use glam::{DMat4, DVec3, Vec4};

/// Height in pixels of images from glTF cameras, which state only a ratio of the sides.
const HEIGHT: u32 = 512;

pub(crate) struct NodeWalker<'a> {
    pub(super) file: &'a OpenedFile,
    pub(super) textures: Textures<'a>,
    pub(super) deformer: Deformer<'a>,
    pub(super) scene: Scene,
    /// glTF's default material, once it is needed.
    pub(super) default_material: Option<u32>,
    lights: Vec<(DVec3, [f64; 3], f64)>,
    /// Pose of a moving scene.
    pub(super) pose: Option<&'a Pose>,
    has_camera: bool,
    pub(super) counts: NodeCounts,
    pub(super) instances: usize,
    unsaid: usize,
}

impl<'a> NodeWalker<'a> {
    /// A walk over the nodes as the file has them, or as a pose says.
    pub fn new(file: &'a OpenedFile, pose: Option<&'a Pose>) -> Self {
        let mut scene = Scene::new(scene_name(&file.path));
        scene.materials = file.document.materials().map(|m| material_of(&m)).collect();
        Self {
            file,
            textures: Textures::new(file),
            deformer: Deformer::new(file, pose),
            scene,
            default_material: None,
            lights: Vec::new(),
            pose,
            has_camera: false,
            counts: NodeCounts::default(),
            instances: 0,
            unsaid: 0,
        }
    }

    /// The scene: every node is visited once, parents first. Where the file has no camera it gets
    /// this one, or one that frames the scene.
    pub fn walk(mut self, camera: Option<Camera>) -> Result<Scene, LoadError> {
        for text in extensions::warnings(self.file.document.as_json()) {
            self.warn(text);
        }
        let placed = tree::placed(self.file, self.pose)?;
        let joints = placed.iter().map(|placed| (placed.node.index(), placed.world));
        self.deformer.joints = joints.collect();
        for placed in &placed {
            if let Some(camera) = placed.node.camera() {
                self.camera(&camera, placed.world)?;
            }
            if let Some(light) = placed.node.light() {
                self.light(&light, placed.world)?;
            }
            self.mesh(placed)?;
        }
        if self.scene.primitives.is_empty() {
            return Err(LoadError::no_primitives(&self.file.path, "triangle with an area"));
        }
        let strongest = self.lights.iter().map(|light| light.2).fold(0.0, f64::max);
        for (position, color, intensity) in &self.lights {
            let scale = if strongest > 0.0 { intensity / strongest } else { 0.0 };
            let color = Some(color.map(|c| c * scale));
            self.scene.lights.push(Light::point(*position, color));
        }
        self.counts.warn(&mut self.scene);
        let unsaid = self.unsaid + self.textures.unsaid;
        if unsaid > 0 {
            self.scene.warn(format!("{}: {unsaid} more warnings", self.file.path.display()));
        }
        match camera {
            _ if self.has_camera => {}
            Some(camera) => self.scene.camera = camera,
            None => self.scene.frame_camera(),
        }
        Ok(self.scene)
    }

    pub(super) fn warn(&mut self, text: String) {
        if self.scene.warnings.len() >= MAX_WARNINGS {
            self.unsaid += 1;
            return;
        }
        self.scene.warn(format!("{}: {text}", self.file.path.display()));
    }

    fn light(
        &mut self,
        light: &::gltf::khr_lights_punctual::Light<'_>,
        world: DMat4,
    ) -> Result<(), LoadError> {
        let count = self.lights.len() + 1;
        limits::check(count, MAX_LIGHTS, "the number of lights", || self.file.place())?;
        let (index, color) = (light.index(), light.color().map(f64::from));
        let intensity = f64::from(light.intensity());
        if !(intensity.is_finite() && intensity >= 0.0 && color.iter().all(|c| c.is_finite())) {
            self.warn(format!("light {index} left out: intensity {intensity}, colour {color:?}"));
            return Ok(());
        }
        match light.kind() {
            Kind::Directional => {
                self.warn(format!("directional light {index} left out"));
                return Ok(());
            }
            Kind::Point => {}
            Kind::Spot { .. } => self.warn(format!("spot light {index} taken as a point light")),
        }
        self.lights.push((world.w_axis.truncate(), color, intensity));
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
        if let Err(error) = converted.check(|| self.file.place()) {
            let (error, place) = (error.to_string(), format!("{}: ", self.file.path.display()));
            let why = error.strip_prefix(&place).unwrap_or(&error);
            self.warn(format!("camera {} left out: {why}", camera.index()));
            return Ok(());
        }
        self.scene.camera = converted;
        self.has_camera = true;
        Ok(())
    }
}

first_and_counts! {
    /// What is not in the scene as the file has it.
    struct NodeCounts {
        without_area: "triangles without area left out",
        points_and_lines: "meshes of points or lines left out",
        empty: "primitives without a triangle left out",
        without_positions: "primitives without positions left out",
        incomplete: "primitives whose last triangle lacks corners, which is left out",
        hidden: "meshes that are scaled to nothing or not visible left out",
        unused_vertices: "vertices are not finite; no triangle uses them",
        normals: "normals that are not finite left out",
        texcoords: "texture coordinates that are not finite are taken as 0",
        coloured: "primitives with vertex colours (COLOR_0), which are not shown",
    }
}

/// The nearest of our materials.
fn material_of(material: &::gltf::Material<'_>) -> Material {
    let pbr = material.pbr_metallic_roughness();
    let base = Vec4::from_array(pbr.base_color_factor())
        .as_dvec4()
        .clamp(glam::DVec4::ZERO, glam::DVec4::ONE);
    let roughness = f64::from(pbr.roughness_factor()).clamp(0.0, 1.0);
    let metallic = f64::from(pbr.metallic_factor()).clamp(0.0, 1.0);
    let specular = metallic * (1.0 - roughness);
    let blended = material.alpha_mode() == AlphaMode::Blend;
    Material {
        name: material.name().unwrap_or_default().to_string(),
        color: base.truncate().to_array(),
        diffuse: 1.0 - specular,
        specular,
        shine: (2.0 / roughness.powi(4).max(1e-5) - 2.0).max(0.0),
        transmittance: if blended { 1.0 - base.w } else { 0.0 },
        refraction_index: 1.0,
        ..Material::default()
    }
}
