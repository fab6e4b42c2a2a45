//! Geometry inside a scene file, for scenes too small to deserve a file of their own:
//!
//! ```json
//! "source": {"shapes": [
//!   {"sphere": {"center": [0, 1, 0], "radius": 1, "material": "red", "velocity": [1, 0, 0]}},
//! {"polygon": {"vertices": [[-5, 0, -5], [-5, 0, 5], [5, 0, 5], [5, 0, -5]], "material": "floor"}}
//! ]}
//! ```
//!
//! Materials are those of the scene file, which defines them instead of changing them.

use std::collections::HashMap;

use glam::DVec3;
use serde::Deserialize;

use crate::error::{FilePlace, LoadError};
use crate::mesh::{FaceCounts, push_outline};
use crate::scene::{Cone, Scene, at_least_0};
use crate::scene_file::json::unknown_material;

/// A shape with its material and, if it moves, its velocity in world units per unit of time.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum ShapeEntry {
    /// A sphere.
    Sphere(SphereEntry),
    /// A truncated cone; see [`Cone`].
    Cone(ConeEntry),
    /// A planar polygon; concave ones too. One that is bent or crosses itself becomes triangles.
    Polygon(PolygonEntry),
}

/// A sphere.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SphereEntry {
    /// Its centre.
    pub center: [f64; 3],
    /// Its radius.
    #[serde(deserialize_with = "at_least_0")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub radius: f64,
    /// Name of its material.
    pub material: String,
    /// World units per unit of time.
    #[serde(default)]
    pub velocity: [f64; 3],
}

/// A truncated cone, seen from outside.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ConeEntry {
    /// Centre of the base disc.
    pub base: [f64; 3],
    /// Radius of the base.
    #[serde(deserialize_with = "at_least_0")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub base_radius: f64,
    /// Centre of the apex disc.
    pub apex: [f64; 3],
    /// Radius of the apex.
    #[serde(deserialize_with = "at_least_0")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub apex_radius: f64,
    /// Name of its material.
    pub material: String,
    /// World units per unit of time.
    #[serde(default)]
    pub velocity: [f64; 3],
}

/// A polygon.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PolygonEntry {
    /// Its outline, three vertices or more.
    pub vertices: Vec<[f64; 3]>,
    /// Name of its material.
    pub material: String,
    /// World units per unit of time.
    #[serde(default)]
    pub velocity: [f64; 3],
}

/// Adds all shapes to a scene that has the materials.
pub(crate) fn push_all(
    file: &std::path::Path,
    shapes: &[ShapeEntry],
    scene: &mut Scene,
) -> Result<(), LoadError> {
    // of several materials of a name the first
    let names = scene.materials.iter().enumerate().rev();
    let ids: HashMap<String, usize> = names.map(|(id, m)| (m.name.clone(), id)).collect();
    let mut counts = FaceCounts::default();
    let place = || FilePlace::file(file);
    for shape in shapes {
        let (name, velocity) = match shape {
            ShapeEntry::Sphere(s) => (&s.material, s.velocity),
            ShapeEntry::Cone(c) => (&c.material, c.velocity),
            ShapeEntry::Polygon(p) => (&p.material, p.velocity),
        };
        let Some(&id) = ids.get(name) else {
            return Err(unknown_material(file, name, scene, "a material of this file"));
        };
        let (material, before) = (id as u32, scene.primitives.len());
        match shape {
            ShapeEntry::Sphere(s) => {
                scene.push_sphere(material, DVec3::from_array(s.center), s.radius);
            }
            &ShapeEntry::Cone(ConeEntry { base, base_radius, apex, apex_radius, .. }) => {
                let [base, apex] = [base, apex].map(DVec3::from_array);
                scene.push_cone(material, Cone { base, base_radius, apex, apex_radius });
            }
            ShapeEntry::Polygon(PolygonEntry { vertices, .. }) if vertices.len() < 3 => {
                let found = format!("{} vertices", vertices.len());
                return Err(LoadError::syntax(place(), &found, "a polygon of at least 3"));
            }
            ShapeEntry::Polygon(p) => {
                let vertices: Vec<DVec3> =
                    p.vertices.iter().map(|&v| DVec3::from_array(v)).collect();
                push_outline(material, &vertices, scene, &mut counts, place)?;
            }
        }
        scene.moves_since(before, DVec3::from_array(velocity));
    }
    counts.warn(scene);
    Ok(())
}
