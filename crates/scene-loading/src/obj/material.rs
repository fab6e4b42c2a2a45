//! Materials of OBJ files (MTL).
//!
//! How MTL maps to [`Material`]:
//!
//! - colour = `Kd`, diffuse share 1;
//! - specular share = mean of `Ks`, but only for the illumination models that reflect (`illum`
//!   3 to 9): exporters write `Ks 0.5` for every matt surface, and here a share > 0 is a mirror;
//! - shine = `Ns`; a material that reflects and has none is a mirror without a visible highlight;
//!   transmittance = 1 - `d` (or `Tr`); index of refraction = `Ni` where transparent.
//!
//! Of textures, `map_Kd` is read, without options: its texels times `Kd` are the colour, as the
//! format says. Other maps are not read.

use std::path::Path;

use crate::error::{FilePlace, LoadError};
use crate::input::read::lossy_text;
use crate::limits::{self, MAX_MATERIALS, MAX_NAME};
use crate::obj::scan::number;
use crate::scene::Material;

/// The most bytes of the material files of one OBJ file, together.
pub(crate) const MAX_LIBRARY_BYTES: u64 = 256 << 20;

/// The most bytes of a line.
const MAX_LINE: usize = 1 << 16;

/// Phong exponent of a highlight too small to be seen. With 0 a mirror's would be everywhere: a
/// white disc instead of what it reflects.
const NO_HIGHLIGHT: f64 = 100_000.0;

/// A material of an MTL file, and its last `map_Kd` line.
pub(crate) type MtlEntry = (Material, Option<ColorMap>);

/// The image that colours a material.
pub(crate) struct ColorMap {
    /// Line in the file, counted from 1.
    pub line: usize,
    /// What stands after `map_Kd`: options and the name of a file.
    pub text: String,
}

/// Reads MTL text: the materials in its order.
///
/// # Errors
/// [`LoadError::Syntax`], [`LoadError::NotFinite`] and [`LoadError::CountTooLarge`] with the line.
pub(crate) fn parse_mtl(path: &Path, bytes: Vec<u8>) -> Result<Vec<MtlEntry>, LoadError> {
    let mut entries = Vec::new();
    let mut stated: Option<Stated> = None;
    for (i, row) in lossy_text(bytes).lines().enumerate() {
        let place = || FilePlace::line(path, i + 1);
        limits::check(row.len(), MAX_LINE, "the length of a line", place)?;
        let row = row.trim();
        let (keyword, rest) = row.split_once(char::is_whitespace).unwrap_or((row, ""));
        let rest = rest.trim();
        if keyword == "newmtl" {
            if rest.is_empty() {
                return Err(LoadError::syntax(place(), row, "newmtl and a name"));
            }
            limits::check(rest.len(), MAX_NAME, "the length of a name", place)?;
            limits::check(entries.len() + 1, MAX_MATERIALS, "the number of materials", place)?;
            let next = Stated { name: rest.to_owned(), ..Stated::default() };
            entries.extend(stated.replace(next).map(Stated::entry));
            continue;
        }
        let known = ["Kd", "Ks", "Ns", "Ni", "d", "Tr", "illum", "map_Kd"];
        if !known.contains(&keyword) {
            continue;
        }
        let Some(stated) = &mut stated else {
            return Err(LoadError::syntax(place(), row, "newmtl before the first property"));
        };
        if keyword == "map_Kd" {
            // as with all properties, the last one counts
            stated.map = Some(ColorMap { line: i + 1, text: rest.to_owned() });
        } else {
            stated.property(row, keyword, rest, place)?;
        }
    }
    entries.extend(stated.map(Stated::entry));
    Ok(entries)
}

/// What a file states of one material.
#[derive(Default)]
struct Stated {
    name: String,
    diffuse: Option<[f64; 3]>,
    specular: Option<[f64; 3]>,
    shininess: Option<f64>,
    optical_density: Option<f64>,
    dissolve: Option<f64>,
    model: Option<f64>,
    map: Option<ColorMap>,
}

impl Stated {
    /// Reads the numbers of a property.
    fn property(
        &mut self,
        row: &str,
        keyword: &str,
        rest: &str,
        place: impl Fn() -> FilePlace,
    ) -> Result<(), LoadError> {
        let words: Vec<&str> =
            rest.split_whitespace().take_while(|word| !word.starts_with('#')).collect();
        if let Some(&("spectral" | "xyz" | "-halo")) = words.first() {
            return Ok(());
        }
        let values = words
            .iter()
            .map(|word| number(word, keyword, &place))
            .collect::<Result<Vec<f64>, LoadError>>()?;
        let color = match values.as_slice() {
            // One number stands for three equal ones.
            [v] => Some([*v; 3]),
            [r, g, b] => Some([*r, *g, *b]),
            _ => None,
        };
        let expected = match keyword {
            "Kd" | "Ks" => format!("{keyword} and 1 or 3 numbers"),
            _ => format!("{keyword} and 1 number"),
        };
        let malformed = || LoadError::syntax(place(), row, expected);
        match (keyword, values.as_slice()) {
            ("Kd", _) => self.diffuse = Some(color.ok_or_else(malformed)?),
            ("Ks", _) => self.specular = Some(color.ok_or_else(malformed)?),
            ("Ns", [v]) => self.shininess = Some(*v),
            ("Ni", [v]) => self.optical_density = Some(*v),
            ("d", [v]) => self.dissolve = Some(*v),
            ("Tr", [v]) => self.dissolve = Some(1.0 - v),
            ("illum", [v]) if (0.0..=10.0).contains(v) && v.fract() == 0.0 => self.model = Some(*v),
            ("illum", [_]) => {
                return Err(LoadError::syntax(place(), row, "an illumination model, 0 to 10"));
            }
            _ => return Err(malformed()),
        }
        Ok(())
    }

    fn entry(self) -> MtlEntry {
        let default = Material::default();
        let reflects = self.model.is_some_and(|model| model >= 3.0);
        let specular = self.specular.map_or(0.0, |[r, g, b]| (r + g + b) / 3.0);
        let transmittance = 1.0 - self.dissolve.unwrap_or(1.0).clamp(0.0, 1.0);
        let material = Material {
            name: self.name,
            color: self.diffuse.unwrap_or(default.color),
            diffuse: default.diffuse,
            specular: if reflects { specular.clamp(0.0, 1.0) } else { 0.0 },
            shine: self.shininess.unwrap_or(if reflects { NO_HIGHLIGHT } else { 0.0 }).max(0.0),
            transmittance,
            refraction_index: match self.optical_density {
                Some(index) if transmittance > 0.0 && index > 0.0 => index,
                _ => default.refraction_index,
            },
            texture: None,
            roughness: 0.0,
        };
        (material, self.map)
    }
}
