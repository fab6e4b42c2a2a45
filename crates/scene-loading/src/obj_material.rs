//! Materials of OBJ files (MTL).
//!
//! tobj 4.0 panics on `Kd 0.5`, so each line is checked first and only lines of a form that it
//! reads safely are passed on. How MTL maps to [`Material`]:
//!
//! - colour = `Kd`, diffuse share 1;
//! - specular share = mean of `Ks`, but only for the illumination models that reflect (`illum`
//!   3 to 9): exporters write `Ks 0.5` for every matt surface, and here a share > 0 is a mirror;
//! - shine = `Ns`; transmittance = 1 - `d` (or `Tr`); index of refraction = `Ni` where transparent.
//!
//! Of textures, `map_Kd` is read, without options: its texels times `Kd` are the colour, as the
//! format says. Other maps are not read.

use std::path::Path;

use crate::error::{LoadError, Place};
use crate::obj_scan::number;
use crate::scene::Material;
use crate::source_read::lossy_text;

/// What an MTL file says.
pub(crate) struct Mtl {
    /// Its materials, in order.
    pub materials: Vec<Material>,
    /// Its `map_Kd` lines, at most one a material.
    pub maps: Vec<ColorMap>,
}

/// The image that colours a material.
pub(crate) struct ColorMap {
    /// Index of the material within the file.
    pub material: usize,
    /// Line in the file, counted from 1.
    pub line: usize,
    /// What stands after `map_Kd`: options and the name of a file.
    pub text: String,
}

/// Reads MTL text.
///
/// # Errors
/// [`LoadError::Syntax`] and [`LoadError::NotFinite`] with the line.
pub(crate) fn parse_mtl(path: &Path, bytes: Vec<u8>) -> Result<Mtl, LoadError> {
    let mut maps = Vec::new();
    let clean = checked(path, &lossy_text(bytes), &mut maps)?;
    let (materials, _) = tobj::load_mtl_buf(&mut clean.as_bytes()).map_err(|e| {
        LoadError::Parser { place: Place::file(path), parser: "tobj", message: e.to_string() }
    })?;
    Ok(Mtl { materials: materials.iter().map(convert).collect(), maps })
}

/// The lines that matter, each in the one form that tobj reads; colour maps go into `maps`.
fn checked(path: &Path, text: &str, maps: &mut Vec<ColorMap>) -> Result<String, LoadError> {
    let mut clean = String::with_capacity(text.len());
    let mut named = 0_usize;
    for (i, row) in text.lines().enumerate() {
        let place = || Place::line(path, i + 1);
        let row = row.trim();
        let (keyword, rest) = row.split_once(char::is_whitespace).unwrap_or((row, ""));
        let rest = rest.trim();
        if keyword == "newmtl" {
            if rest.is_empty() {
                return Err(LoadError::syntax(place(), row, "newmtl and a name"));
            }
            named += 1;
            clean.push_str(&format!("newmtl {rest}\n"));
            continue;
        }
        if keyword == "map_Kd" {
            let material = named.checked_sub(1).ok_or_else(|| {
                LoadError::syntax(place(), row, "newmtl before the first property")
            })?;
            // as with all properties, the last one counts
            maps.retain(|map| map.material != material);
            maps.push(ColorMap { material, line: i + 1, text: rest.to_owned() });
            continue;
        }
        let counts: &[usize] = match keyword {
            "Kd" | "Ks" => &[1, 3],
            "Ns" | "Ni" | "d" | "Tr" | "illum" => &[1],
            _ => continue,
        };
        if named == 0 {
            return Err(LoadError::syntax(place(), row, "newmtl before the first property"));
        }
        let words: Vec<&str> =
            rest.split_whitespace().take_while(|word| !word.starts_with('#')).collect();
        if let (Some("spectral" | "xyz" | "-halo"), _) = (words.first().copied(), ()) {
            continue;
        }
        let values = words
            .iter()
            .map(|word| number(word, keyword, place))
            .collect::<Result<Vec<f64>, LoadError>>()?;
        match (keyword, values.as_slice()) {
            // One number stands for three equal ones.
            ("Kd" | "Ks", [v]) => clean.push_str(&format!("{keyword} {v} {v} {v}\n")),
            ("Kd" | "Ks", [r, g, b]) => clean.push_str(&format!("{keyword} {r} {g} {b}\n")),
            ("Tr", [v]) => clean.push_str(&format!("d {}\n", 1.0 - v)),
            ("illum", [v]) if (0.0..=10.0).contains(v) && v.fract() == 0.0 => {
                clean.push_str(&format!("illum {v}\n"));
            }
            ("illum", [_]) => {
                return Err(LoadError::syntax(place(), row, "an illumination model, 0 to 10"));
            }
            (_, [v]) => clean.push_str(&format!("{keyword} {v}\n")),
            _ => {
                let expected = match counts {
                    [one] => format!("{keyword} and {one} number"),
                    _ => format!("{keyword} and 1 or 3 numbers"),
                };
                return Err(LoadError::syntax(place(), row, expected));
            }
        }
    }
    Ok(clean)
}

fn convert(mtl: &tobj::Material) -> Material {
    let default = Material::default();
    let reflects = mtl.illumination_model.is_some_and(|model| model >= 3);
    let specular = mtl.specular.map_or(0.0, |[r, g, b]| (r + g + b) / 3.0);
    let transmittance = 1.0 - mtl.dissolve.unwrap_or(1.0).clamp(0.0, 1.0);
    Material {
        name: mtl.name.clone(),
        color: mtl.diffuse.unwrap_or(default.color),
        diffuse: default.diffuse,
        specular: if reflects { specular.clamp(0.0, 1.0) } else { 0.0 },
        shine: mtl.shininess.unwrap_or(0.0).max(0.0),
        transmittance,
        refraction_index: match mtl.optical_density {
            Some(index) if transmittance > 0.0 && index > 0.0 => index,
            _ => default.refraction_index,
        },
        texture: None,
        roughness: 0.0,
    }
}
