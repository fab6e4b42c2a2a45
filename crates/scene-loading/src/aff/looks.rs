//! Materials of AFF files.

use crate::error::LoadError;
use crate::nff::tokens::Words;
use crate::scene::Material;

/// What stands behind an `fm`: ambient, diffuse and specular colour, exponent, transmittance, index
/// of refraction.
pub(super) fn extended(words: &mut Words<'_>) -> Result<Material, LoadError> {
    words.vector("ambient colour")?;
    let diffuse = words.vector("diffuse colour")?;
    let specular = words.vector("specular colour")?;
    let share = diffuse.max_element();
    Ok(Material {
        color: if share > 0.0 { (diffuse / share).to_array() } else { [0.0; 3] },
        diffuse: share,
        specular: specular.max_element(),
        shine: words.number("shine")?,
        transmittance: words.number("transmittance T")?,
        refraction_index: words.number("index of refraction")?,
        ..Material::default()
    })
}
