//! Textures of OBJ files: the images of `map_Kd` lines, and the texture coordinates of faces.
//!
//! Images lie in the folder of the MTL file or below it. One that is missing, damaged or elsewhere
//! leaves the plain colour, with a warning that names the line and the material.

use std::path::{Path, PathBuf};

use crate::error::Place;
use crate::obj_material::ColorMap;
use crate::obj_scan::{NONE, ObjScan};
use crate::scene::{Scene, Texcoords};
use crate::source_read::{confined, read_file};
use crate::texture::Wrap;
use crate::texture_read::{TextureError, TextureReader, warning};

/// The colour maps of all materials.
#[derive(Default)]
pub(crate) struct ColorMaps {
    /// MTL file and map, the material counted within the scene.
    maps: Vec<(PathBuf, ColorMap)>,
}

impl ColorMaps {
    /// Adds those of an MTL file whose materials come after `before` others.
    pub fn found(&mut self, file: &Path, before: usize, maps: Vec<ColorMap>) {
        let within = |map: ColorMap| {
            (file.to_path_buf(), ColorMap { material: map.material + before, ..map })
        };
        self.maps.extend(maps.into_iter().map(within));
    }

    /// Reads the images of the materials that are used, in the order of their first use.
    pub fn read(&self, used: impl Iterator<Item = usize>, scene: &mut Scene) {
        let mut reader = TextureReader::default();
        for material in used {
            // in the order of the materials, as they were found
            let at = self.maps.partition_point(|(_, map)| map.material < material);
            let found = self.maps.get(at).filter(|(_, map)| map.material == material);
            let Some((file, map)) = found else { continue };
            let texture = read_one(file, map, scene, &mut reader);
            let Some(material) = scene.materials.get_mut(material) else { continue };
            match texture {
                Ok(texture) => material.texture = Some(texture),
                Err(error) => {
                    let place = Place::line(file, map.line);
                    scene.warnings.push(warning(&place, &material.name, &map.text, &error));
                }
            }
        }
    }
}

/// Reads the image of a map in the MTL file `file` and returns its index.
fn read_one(
    file: &Path,
    map: &ColorMap,
    scene: &mut Scene,
    reader: &mut TextureReader,
) -> Result<u32, TextureError> {
    if let Some(option) = map.text.strip_prefix('-') {
        let name = option.split_whitespace().next().unwrap_or_default();
        return Err(TextureError::Options(format!("-{name}")));
    }
    // exporters of one system write its separators
    let name = map.text.replace('\\', "/");
    let path = confined(file.parent().unwrap_or(Path::new("")), &name)
        .ok_or(TextureError::OutsideFolder)?;
    let name = path.display().to_string();
    reader.add(scene, &name, [Wrap::Repeat; 2], || Ok(read_file(&path)?))
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
