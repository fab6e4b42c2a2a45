//! Textures of OBJ files: the images of `map_Kd` lines, and the texture coordinates of faces.
//!
//! Images lie in the folder of the MTL file or below it. One that is missing, damaged or elsewhere
//! leaves the plain colour, with a warning that names the line and the material.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::error::{FilePlace, shortened};
use crate::input::images::{ImageKey, TextureError, TextureReader, warning};
use crate::input::read::{confined, read_at_most};
use crate::limits::MAX_WARNINGS;
use crate::obj::material::ColorMap;
use crate::obj::scan::{NONE, ObjScan};
use crate::scene::texture::Wrap;
use crate::scene::{Scene, Texcoords, Warning};

/// The colour maps of all materials.
#[derive(Default)]
pub(crate) struct ColorMaps {
    /// The MTL files.
    files: Vec<PathBuf>,
    /// By material of the scene: which of the files, and its map.
    maps: HashMap<u32, (usize, ColorMap)>,
}

impl ColorMaps {
    /// What comes now is of that MTL file.
    pub fn begin(&mut self, file: &Path) {
        self.files.push(file.to_path_buf());
    }

    /// The map of a material of the scene, instead of one that it had before.
    pub fn set(&mut self, material: u32, map: Option<ColorMap>) {
        match map {
            Some(map) => self.maps.insert(material, (self.files.len().saturating_sub(1), map)),
            None => self.maps.remove(&material),
        };
    }

    /// Reads the images of the materials that are used, in the order of their first use.
    pub fn read(&self, used: impl Iterator<Item = u32>, scene: &mut Scene) {
        let mut reader = TextureReader::default();
        let mut failed = 0;
        for material in used {
            let Some((file, map)) = self.maps.get(&material) else { continue };
            let Some(file) = self.files.get(*file) else { continue };
            let texture = read_one(file, map, scene, &mut reader);
            let Some(material) = scene.materials.get_mut(material as usize) else { continue };
            match texture {
                Ok(texture) => material.texture = Some(texture),
                Err(error) => {
                    failed += 1;
                    if failed <= MAX_WARNINGS {
                        let place = FilePlace::line(file, map.line);
                        scene.warnings.push(warning(&place, &material.name, &map.text, &error));
                    }
                }
            }
        }
        if failed > MAX_WARNINGS {
            let more = failed - MAX_WARNINGS;
            let text = format!("{more} more materials have their plain colour for such reasons");
            scene.warnings.push(Warning(text));
        }
    }
}

/// Reads the image of a map in the MTL file `file` and returns its index.
fn read_one(
    file: &Path,
    map: &ColorMap,
    scene: &mut Scene,
    reader: &mut TextureReader,
) -> Result<u32, Rc<TextureError>> {
    if let Some(option) = map.text.strip_prefix('-') {
        let name = option.split_whitespace().next().unwrap_or_default();
        return Err(Rc::new(TextureError::Options(format!("-{}", shortened(name)))));
    }
    // exporters of one system write its separators
    let name = map.text.replace('\\', "/");
    let path = confined(file.parent().unwrap_or(Path::new("")), &name)
        .ok_or_else(|| Rc::new(TextureError::OutsideFolder))?;
    let name = path.display().to_string();
    let key = ImageKey::of_file(&path);
    reader.add(scene, key, &name, [Wrap::Repeat; 2], |most| Ok(read_at_most(&path, most)?))
}

/// The texture coordinates of one face after the other.
pub(crate) struct FaceTexcoords<'a> {
    texcoords: &'a [[f32; 2]],
    rest: &'a [u32],
    face: &'a [u32],
}

impl<'a> FaceTexcoords<'a> {
    /// Before the first face of a file.
    pub fn new(scan: &'a ObjScan) -> Self {
        Self { texcoords: &scan.texcoords, rest: &scan.texcoord_corners, face: &[] }
    }

    /// Goes to the next face, which has so many corners.
    pub fn next_face(&mut self, corners: usize) {
        (self.face, self.rest) = self.rest.split_at_checked(corners).unwrap_or_default();
    }

    /// Whether all corners of the face have any.
    pub fn are_known(&self) -> bool {
        !self.face.is_empty() && !self.face.contains(&NONE)
    }

    /// Those of three of its corners, counted from the upper left of the image: in OBJ files v
    /// grows upwards.
    pub fn of(&self, piece: [usize; 3]) -> Option<Texcoords> {
        let corner = |i: usize| self.texcoords.get(*self.face.get(i)? as usize);
        let [a, b, c] = piece.map(corner);
        Some([a?, b?, c?].map(|&[u, v]| [u, 1.0 - v]))
    }
}
