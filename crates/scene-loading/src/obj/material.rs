//! Materials of OBJ files (MTL).
//!
//! How MTL maps to [`Material`]:
//!
//! - colour = `Kd`, diffuse share 1;
//! - specular share = mean of `Ks`, but only for the illumination models that reflect (`illum`
//!   3 to 9): exporters write `Ks 0.5` for every matt surface, and here a share > 0 is a mirror;
//! - shine = `Ns`; a material that reflects and has none is a mirror without a visible highlight;
//!   transmittance = 1 - `d`; index of refraction = `Ni` where transparent;
//! - `Tr` is not in the specification: it is 1 - `d` where there is no `d`. `Tr 1` without a model
//!   that refracts is opaque, which is what MeshLab means by it.
//!
//! Of textures, `map_Kd` is read (`maps`): its texels times `Kd` are the colour, as the format
//! says. Other maps are not read. Materials are no geometry: a damaged line is left out and
//! counted.

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::{FilePlace, LoadError};
use crate::input::text_of;
use crate::limits::{self, MAX_MATERIALS, MAX_NAME};
use crate::mesh::first_and_counts;
use crate::scene::{Material, NO_HIGHLIGHT};

/// The most bytes of the material files of one OBJ file, together.
pub(crate) const MAX_LIBRARY_BYTES: u64 = 256 << 20;

/// The most bytes of a line.
const MAX_LINE: usize = 1 << 16;

/// A material of an MTL file, and its last `map_Kd` line.
pub(crate) type MtlEntry = (Material, Option<ColorMap>);

/// The image that colours a material.
pub(crate) struct ColorMap {
    pub place: FilePlace,
    /// Arguments of `map_Kd`: options and a file name.
    pub text: String,
}

#[derive(Default)]
pub(crate) struct Library {
    /// The materials in its order.
    pub entries: Vec<MtlEntry>,
    pub odd: MaterialOddities,
}

first_and_counts! {
    /// What is not taken as it stands.
    struct MaterialOddities {
        damaged: "damaged lines left out",
        contradicting: "materials whose d and Tr differ: d counts",
        opaque: "materials with Tr 1 that do not refract taken as opaque",
        invisible: "materials with d 0 that do not refract: they are invisible",
    }
}

/// Reads MTL text.
///
/// # Errors
/// [`LoadError::CountTooLarge`] with the line, [`LoadError::Syntax`] for UTF-16.
pub(crate) fn parse_mtl(path: &Path, bytes: Vec<u8>) -> Result<Library, LoadError> {
    let mut library = Library::default();
    let mut stated: Option<MaterialStatement> = None;
    let mut count = 0;
    for (i, row) in text_of(path, bytes)?.lines().enumerate() {
        let place = || FilePlace::line(path, i + 1);
        limits::check(row.len(), MAX_LINE, "the length of a line", place)?;
        let row = row.trim();
        let (keyword, rest) = row.split_once(char::is_whitespace).unwrap_or((row, ""));
        let rest = rest.trim();
        if keyword == "newmtl" {
            limits::check(rest.len(), MAX_NAME, "the length of a name", place)?;
            count += 1;
            limits::check(count, MAX_MATERIALS, "the number of materials", place)?;
            if rest.is_empty() {
                library.odd.damaged.add(place);
            }
            let next = MaterialStatement {
                name: rest.to_owned(),
                line: i + 1,
                ..MaterialStatement::default()
            };
            if let Some(complete) = stated.replace(next) {
                complete.finish(path, &mut library);
            }
            continue;
        }
        let Some(keyword) = PROPERTIES.into_iter().find(|known| *known == keyword) else {
            continue;
        };
        let read = match &mut stated {
            None => None,
            Some(stated) if keyword == "map_Kd" => {
                // as with all properties, the last one counts
                stated.map = Some(ColorMap { place: place(), text: rest.to_owned() });
                Some(())
            }
            Some(stated) => stated.property(keyword, rest),
        };
        if read.is_none() {
            library.odd.damaged.add(place);
        }
    }
    if let Some(complete) = stated {
        complete.finish(path, &mut library);
    }
    Ok(library)
}

/// Keywords that are read.
const PROPERTIES: [&str; 8] = ["Kd", "Ks", "Ns", "Ni", "d", "Tr", "illum", "map_Kd"];

/// Statements of a file about one material.
#[derive(Default)]
struct MaterialStatement {
    name: String,
    line: usize,
    /// Colours and numbers by keyword; a number stands for three equal ones.
    values: BTreeMap<&'static str, [f64; 3]>,
    map: Option<ColorMap>,
}

impl MaterialStatement {
    /// Reads the numbers of a property; none where they are not what it takes.
    fn property(&mut self, keyword: &'static str, rest: &str) -> Option<()> {
        let words: Vec<&str> =
            rest.split_whitespace().take_while(|word| !word.starts_with('#')).collect();
        if let Some(&("spectral" | "xyz" | "-halo")) = words.first() {
            return Some(());
        }
        let number = |word: &&str| word.parse().ok().filter(|value: &f64| value.is_finite());
        let values = words.iter().map(number).collect::<Option<Vec<f64>>>()?;
        let value = match (keyword, values.as_slice()) {
            ("Kd" | "Ks", &[r, g, b]) => [r, g, b],
            ("illum", &[v]) if !(0.0..=10.0).contains(&v) || v.fract() != 0.0 => return None,
            (_, &[v]) => [v; 3],
            _ => return None,
        };
        self.values.insert(keyword, value);
        Some(())
    }

    /// Adds the material to its library; one without a name can be used by no face.
    fn finish(self, path: &Path, library: &mut Library) {
        if self.name.is_empty() {
            return;
        }
        let place = || FilePlace::line(path, self.line);
        let default = Material::default();
        let color = |keyword| self.values.get(keyword).copied();
        let number = |keyword| color(keyword).map(|[value, ..]| value);
        let model = number("illum").unwrap_or(0.0);
        let (reflects, refracts) = (model >= 3.0, [4.0, 6.0, 7.0, 9.0].contains(&model));
        let specular = color("Ks").map_or(0.0, |[r, g, b]| (r + g + b) / 3.0);
        let transparency = match (number("d"), number("Tr")) {
            (Some(d), transparency) => {
                if transparency.is_some_and(|other| (1.0 - d - other).abs() > 1e-3) {
                    library.odd.contradicting.add(place);
                }
                if d <= 0.0 && !refracts {
                    library.odd.invisible.add(place);
                }
                1.0 - d
            }
            (None, Some(transparency)) if transparency >= 1.0 && !refracts => {
                library.odd.opaque.add(place);
                0.0
            }
            (None, transparency) => transparency.unwrap_or(0.0),
        };
        let transmittance = transparency.clamp(0.0, 1.0);
        let material = Material {
            name: self.name,
            color: color("Kd").unwrap_or(default.color),
            specular: if reflects { specular.clamp(0.0, 1.0) } else { 0.0 },
            shine: number("Ns").unwrap_or(if reflects { NO_HIGHLIGHT } else { 0.0 }).max(0.0),
            transmittance,
            refraction_index: match number("Ni") {
                Some(index) if transmittance > 0.0 && index > 0.0 => index,
                _ => default.refraction_index,
            },
            ..default
        };
        library.entries.push((material, self.map));
    }
}
