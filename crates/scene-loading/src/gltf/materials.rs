//! glTF's materials as ours: how the metallic-roughness model maps to [`Material`] (an
//! approximation).
//!
//! Colour = base colour, times the base colour texture (`textures`); specular share = metallic *
//! (1 - roughness); diffuse share = 1 - specular share; shine = the Phong exponent
//! 2 / roughness^4 - 2; transmittance = 1 - alpha where the alpha mode is BLEND.

use ::gltf::material::AlphaMode;
use glam::Vec4;

use crate::scene::Material;

/// The nearest of our materials.
pub(crate) fn material_of(material: &::gltf::Material<'_>) -> Material {
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
        texture: None,
        roughness: 0.0,
    }
}
