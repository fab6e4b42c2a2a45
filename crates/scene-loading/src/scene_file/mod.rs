//! JSON scene files (`scenes/*.json`): where a scene comes from, and the view, lights and
//! materials that its source lacks.
//!
//! ```json
//! {
//!   "name": "kitchen", "title": "A kitchen", "why": "One sentence on what it tests.",
//!   "source": {"crate": {"name": "obvhs", "version": "0.4.0", "path": "assets/kitchen.obj.zst"}},
//!   "sha256": "b6c3...", "licence": "MIT OR Apache-2.0",
//!   "camera": {"from": [0, 1, 2], "at": [0, 1, 0], "up": [0, 1, 0], "angle": 60},
//!   "lights": [{"position": [0, 2, 0], "radius": 0.1}],
//!   "materials": {"steel": {"specular": 0.8, "roughness": 0.1}},
//!   "motion": [{"material": "steel", "velocity": [1, 0, 0]}],
//!   "effects": {"shadow": 32}
//! }
//! ```
//!
//! A light with a radius calls for soft shadows, a material with a roughness for glossy
//! reflection, a camera with an `aperture` for depth of field, a `velocity` and a camera with a
//! `shutter` for motion blur; `effects` says how finely they are sampled.

mod json;
pub mod set;
pub mod shapes;

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;

use glam::DVec3;
use serde::Deserialize;

use crate::error::{FilePlace, LoadError};
use crate::fetch::PackageAsset;
use crate::limits::{self, MAX_LIGHTS, MAX_MATERIALS};
use crate::scene::{Camera, Light, Material, Rgb, SampleWishes, Scene, at_least_0};
use crate::scene_file::json::{above_0, share};
use crate::scene_file::json::{check_name, from_json, unknown_material};
use crate::scene_file::shapes::{ShapeEntry, push_all};
use crate::tessellate::TessellationOptions;

/// A scene file. Keys that are not listed here are errors.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// The address of this schema, for editors; not read.
    #[serde(rename = "$schema")]
    pub schema: Option<String>,
    /// Name on the command line; the same as the file's stem.
    pub name: String,
    /// A few words for tables.
    pub title: String,
    /// One sentence: why the scene is worth measuring.
    pub why: String,
    /// Where the geometry comes from.
    pub source: Source,
    /// SHA-256 of the source file in hexadecimal; compared on each load.
    pub sha256: Option<String>,
    /// Licence of the geometry.
    pub licence: Option<String>,
    /// Turn spheres, cones and polygons into triangles.
    pub tessellate: Option<TessellationOptions>,
    /// Split polygons of an OBJ source into triangles.
    #[serde(default)]
    pub triangulate: bool,
    /// Replaces the source's camera.
    pub camera: Option<CameraEntry>,
    /// Replaces the source's lights.
    pub lights: Option<Vec<Light>>,
    /// Replaces the source's background colour.
    pub background: Option<Rgb>,
    /// Changes materials of the source, by their names; defines those of inline shapes.
    #[serde(default)]
    pub materials: BTreeMap<String, MaterialEntry>,
    /// Lets all primitives of a material move.
    #[serde(default)]
    pub motion: Vec<MotionEntry>,
    /// How finely effects are sampled.
    #[serde(default)]
    pub effects: SampleWishes,
}

/// Where the geometry of a scene file comes from.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// A generator's specification: `balls:4`.
    Spd(String),
    /// A file; relative paths count from the scene file's folder.
    File(String),
    /// A file inside a package of the cargo registry.
    Crate(PackageAsset),
    /// The shapes themselves.
    Shapes(Vec<ShapeEntry>),
}

/// A camera in NFF's terms; see [`Camera`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CameraEntry {
    /// Eye.
    pub from: [f64; 3],
    /// Point in the middle of the image.
    pub at: [f64; 3],
    /// Up.
    pub up: [f64; 3],
    /// Full field of view in degrees.
    pub angle: f64,
    /// Distance to the near plane; informative.
    #[serde(default)]
    pub hither: f64,
    /// Width and height in pixels; 512 by 512 when absent.
    pub resolution: Option<[u32; 2]>,
    /// Radius of the lens in world units; 0 is a pinhole.
    #[serde(default, deserialize_with = "at_least_0")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub aperture: f64,
    /// Distance along the view at which the image is sharp; that of `at` when absent.
    #[serde(default, deserialize_with = "above_0")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub focal_distance: Option<f64>,
    /// How long the shutter is open, in the unit of time of velocities.
    #[serde(default, deserialize_with = "at_least_0")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub shutter: f64,
}

/// All primitives of a material move.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MotionEntry {
    /// Name of the material.
    pub material: String,
    /// World units per unit of time.
    pub velocity: [f64; 3],
}

/// The properties of a material that a scene file changes; the others stay.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct MaterialEntry {
    /// Base colour.
    pub color: Option<Rgb>,
    /// Diffuse share.
    pub diffuse: Option<f64>,
    /// Specular share.
    pub specular: Option<f64>,
    /// Phong exponent.
    pub shine: Option<f64>,
    /// Transmitted share.
    pub transmittance: Option<f64>,
    /// Index of refraction.
    pub refraction_index: Option<f64>,
    /// Roughness of what reflects; see [`Material::roughness`].
    #[serde(deserialize_with = "share")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 1.0)))]
    pub roughness: Option<f64>,
}

impl SceneFile {
    /// Parses and checks a scene file. `path` appears in errors; its stem must be the name.
    ///
    /// # Errors
    /// [`LoadError::Json`] with line and column, [`LoadError::Syntax`] and
    /// [`LoadError::OutOfRange`] for values that JSON allows and a scene does not.
    pub fn parse(path: &Path, text: &str) -> Result<Self, LoadError> {
        let file: Self = from_json(path, text)?;
        check_name(path, &file.name)?;
        let place = || FilePlace::file(path);
        let is_hash = |h: &&String| h.len() == 64 && h.bytes().all(|b| b.is_ascii_hexdigit());
        if let Some(hash) = file.sha256.as_ref().filter(|hash| !is_hash(hash)) {
            return Err(LoadError::syntax(place(), hash, "sha256: 64 hexadecimal digits"));
        }
        if let Some(TessellationOptions { resolution: 0 }) = file.tessellate {
            return Err(LoadError::syntax(place(), "0", "tessellate: a resolution of at least 1"));
        }
        if let Source::Crate(asset) = &file.source {
            asset.check(path)?;
            if file.sha256.is_none() {
                let expected = "a scene from a package to state its sha256";
                return Err(LoadError::syntax(place(), "no sha256", expected));
            }
        }
        let lights = file.lights.as_ref().map_or(0, Vec::len);
        limits::check(lights, MAX_LIGHTS, "the number of lights", place)?;
        limits::check(file.materials.len(), MAX_MATERIALS, "the number of materials", place)?;
        if let Some(entry) = file.camera {
            Camera::from(entry).check(place)?;
        }
        Ok(file)
    }

    /// The scene of inline shapes, with the materials of the file.
    ///
    /// # Errors
    /// [`LoadError::Syntax`] for a material that the file does not have and for polygons with
    /// fewer than three vertices, [`LoadError::NoPrimitives`].
    pub fn inline(&self, path: &Path, shapes: &[ShapeEntry]) -> Result<Scene, LoadError> {
        let mut scene = Scene::new(self.name.as_str());
        for name in self.materials.keys() {
            scene.push_material(Material { name: name.clone(), ..Material::default() });
        }
        if shapes.is_empty() {
            return Err(LoadError::no_primitives(path, "shape"));
        }
        push_all(path, shapes, &mut scene)?;
        scene.frame_camera();
        Ok(scene)
    }

    /// Applies camera, lights, background, materials and motion to the loaded source.
    ///
    /// # Errors
    /// [`LoadError::Syntax`] when it names a material that the scene does not have.
    pub fn apply(&self, path: &Path, scene: &mut Scene) -> Result<(), LoadError> {
        let changed = self.materials.keys().chain(self.motion.iter().map(|m| &m.material));
        let known: HashSet<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
        if let Some(name) = changed.into_iter().find(|name| !known.contains(name.as_str())) {
            return Err(unknown_material(path, name, scene, "the name of a material"));
        }
        for material in &mut scene.materials {
            if let Some(entry) = self.materials.get(&material.name) {
                entry.apply(material);
            }
        }
        self.move_primitives(scene);
        if let Some(camera) = self.camera {
            scene.camera = camera.into();
        }
        if let Some(lights) = &self.lights {
            scene.lights.clone_from(lights);
        }
        if let Some(background) = self.background {
            scene.background = background;
        }
        scene.samples = self.effects;
        scene.name.clone_from(&self.name);
        Ok(())
    }

    /// Gives the primitives of each material of [`SceneFile::motion`] its velocity; the last
    /// counts.
    fn move_primitives(&self, scene: &mut Scene) {
        if self.motion.is_empty() {
            return;
        }
        let by_name: HashMap<&str, DVec3> = self
            .motion
            .iter()
            .map(|m| (m.material.as_str(), DVec3::from_array(m.velocity)))
            .collect();
        let by_material: Vec<Option<DVec3>> =
            scene.materials.iter().map(|m| by_name.get(m.name.as_str()).copied()).collect();
        scene.velocities.resize(scene.primitives.len(), DVec3::ZERO);
        for (primitive, velocity) in scene.primitives.iter().zip(&mut scene.velocities) {
            if let Some(&Some(moves)) = by_material.get(primitive.material as usize) {
                *velocity = moves;
            }
        }
    }
}

impl From<CameraEntry> for Camera {
    fn from(entry: CameraEntry) -> Self {
        Self {
            from: DVec3::from_array(entry.from),
            at: DVec3::from_array(entry.at),
            up: DVec3::from_array(entry.up),
            angle: entry.angle,
            hither: entry.hither,
            resolution: entry.resolution.unwrap_or(Self::default().resolution),
            aperture: entry.aperture,
            focal_distance: entry.focal_distance,
            shutter: entry.shutter,
        }
    }
}

impl MaterialEntry {
    fn apply(&self, material: &mut Material) {
        let set = |target: &mut f64, value: Option<f64>| *target = value.unwrap_or(*target);
        material.color = self.color.unwrap_or(material.color);
        set(&mut material.diffuse, self.diffuse);
        set(&mut material.specular, self.specular);
        set(&mut material.shine, self.shine);
        set(&mut material.transmittance, self.transmittance);
        set(&mut material.refraction_index, self.refraction_index);
        set(&mut material.roughness, self.roughness);
    }
}
