//! The images of `map_Kd` lines, with their options.
//!
//! Images lie in the folder of the MTL file or below it. One that is missing, damaged or elsewhere
//! leaves the plain colour, with a warning that names the line and the material.

use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;

use crate::error::shortened;
use crate::images::{TextureError, TextureReader, file_key, warning};
use crate::input::{confined, read_at_most};
use crate::limits::MAX_WARNINGS;
use crate::obj::material::ColorMap;
use crate::scene::{Scene, Texcoords, Wrap};

/// Placement of an image on a surface: texture coordinates times `scale`, plus `offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placement {
    pub scale: [f32; 2],
    pub offset: [f32; 2],
}

/// Reads the images of materials that are used, by their index in the scene, in the order of their
/// first use. Returns those that lie otherwise than texture coordinates say.
pub(super) fn read_maps(
    maps: &HashMap<u32, ColorMap>,
    used: impl Iterator<Item = u32>,
    scene: &mut Scene,
) -> HashMap<u32, Placement> {
    let mut reader = TextureReader::default();
    let (mut failed, mut placements) = (0, HashMap::new());
    for id in used {
        let Some(map) = maps.get(&id) else { continue };
        let texture = read_one(map, scene, &mut reader);
        let Some(material) = scene.materials.get_mut(id as usize) else { continue };
        match texture {
            Ok((texture, placement)) => {
                material.texture = Some(texture);
                placements.extend(placement.map(|placement| (id, placement)));
            }
            Err(error) => {
                failed += 1;
                if failed <= MAX_WARNINGS {
                    let text = warning(&map.place, &material.name, &map.text, &error);
                    scene.warnings.push(text);
                }
            }
        }
    }
    if failed > MAX_WARNINGS {
        let more = failed - MAX_WARNINGS;
        scene.warn(format!("{more} more materials have their plain colour for similar reasons"));
    }
    placements
}

/// Reads the image of a map and returns its index.
fn read_one(
    map: &ColorMap,
    scene: &mut Scene,
    reader: &mut TextureReader,
) -> Result<(u32, Option<Placement>), Rc<TextureError>> {
    let Options { name, wrap, placement } = Options::of(&map.text).map_err(Rc::new)?;
    // exporters of one system write its separators
    let name = name.replace('\\', "/");
    let path = confined(map.place.file.parent().unwrap_or(Path::new("")), &name)
        .ok_or_else(|| Rc::new(TextureError::OutsideFolder))?;
    let name = path.display().to_string();
    let key = file_key(&path);
    let texture =
        reader.add(scene, key, &name, [wrap; 2], |most| Ok(read_at_most(&path, most)?))?;
    Ok((texture, placement))
}

#[derive(Debug, PartialEq)]
struct Options<'a> {
    name: &'a str,
    wrap: Wrap,
    placement: Option<Placement>,
}

impl<'a> Options<'a> {
    /// Reads the options that place an image, and passes over those that do not change it here.
    fn of(text: &'a str) -> Result<Self, TextureError> {
        let mut rest = text;
        let (mut scale, mut offset, mut wrap) = ([1.0; 2], [0.0; 2], Wrap::Repeat);
        let mut turbulence = [0.0; 2];
        while let Some((option, after)) = split_word(rest).filter(|(word, _)| word.starts_with('-'))
        {
            rest = after;
            let fail = || TextureError::Options(shortened(option));
            match option {
                "-s" | "-o" | "-t" => {
                    let slot = match option {
                        "-s" => &mut scale,
                        "-o" => &mut offset,
                        _ => &mut turbulence,
                    };
                    let mut place = 0;
                    // one to three numbers, then at least the name
                    while let Some((word, after)) = split_word(rest)
                        && let Ok(value) = word.parse::<f32>()
                        && place < 3
                    {
                        if !value.is_finite() || (option == "-t" && value != 0.0) {
                            return Err(fail());
                        }
                        if let Some(slot) = slot.get_mut(place) {
                            *slot = value;
                        }
                        rest = after;
                        place += 1;
                    }
                    if place == 0 {
                        return Err(fail());
                    }
                }
                "-clamp" | "-blendu" | "-blendv" | "-cc" | "-bm" | "-texres" | "-boost" => {
                    let value;
                    (value, rest) = split_word(rest).ok_or_else(fail)?;
                    match (option, value) {
                        ("-clamp", "on") => wrap = Wrap::Clamp,
                        ("-cc", "on") => return Err(fail()),
                        _ => {}
                    }
                }
                "-mm" => {
                    let (base, gain);
                    (base, rest) = split_word(rest).ok_or_else(fail)?;
                    (gain, rest) = split_word(rest).ok_or_else(fail)?;
                    if (base.parse(), gain.parse()) != (Ok(0.0), Ok(1.0)) {
                        return Err(fail());
                    }
                }
                _ => return Err(fail()),
            }
        }
        let is_moved = scale != [1.0; 2] || offset != [0.0; 2];
        let placement = is_moved.then_some(Placement { scale, offset });
        Ok(Self { name: rest, wrap, placement })
    }
}

/// A word that something follows, and what that is.
fn split_word(text: &str) -> Option<(&str, &str)> {
    text.split_once(char::is_whitespace).map(|(word, after)| (word, after.trim_start()))
}

/// Returns whether all corners of a face, which has indices of texture coordinates, have any.
pub(super) fn are_known(corners: &[u32], texcoords: &[[f32; 2]]) -> bool {
    let is_known = |uv: &[f32; 2]| !uv.iter().any(|x| x.is_nan());
    let mut all = corners.iter().map(|&i| texcoords.get(i as usize));
    !corners.is_empty() && all.all(|uv| uv.is_some_and(is_known))
}

/// Texture coordinates of three corners of a face in an image placed by `placement`, from the upper
/// left: in OBJ files v grows upwards.
pub(super) fn texcoords_of(
    piece: [usize; 3],
    corners: &[u32],
    texcoords: &[[f32; 2]],
    placement: Option<&Placement>,
) -> Option<Texcoords> {
    let [a, b, c] = piece.map(|i| texcoords.get(*corners.get(i)? as usize));
    let placed = |[u, v]: [f32; 2]| match placement {
        Some(Placement { scale: [x, y], offset: [right, up] }) => {
            [(u * x + right).clamp(f32::MIN, f32::MAX), (v * y + up).clamp(f32::MIN, f32::MAX)]
        }
        None => [u, v],
    };
    Some([a?, b?, c?].map(|&corner| placed(corner)).map(|[u, v]| [u, 1.0 - v]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_place_the_image_or_are_refused() {
        let read = |text| {
            Options::of(text).map(|o| (o.name, o.wrap, o.placement.map(|p| (p.scale, p.offset))))
        };
        for (text, expected) in [
            ("wall one.png", ("wall one.png", Wrap::Repeat, None)),
            ("-s 2 3 1 -clamp off t.png", ("t.png", Wrap::Repeat, Some(([2., 3.], [0., 0.])))),
            ("-o .5 -clamp on 7.png", ("7.png", Wrap::Clamp, Some(([1., 1.], [0.5, 0.])))),
            ("-s 1 1 1 -o 0 0 0 -t 0 t.png", ("t.png", Wrap::Repeat, None)),
            ("-o 1 2 3 4 t.png", ("4 t.png", Wrap::Repeat, Some(([1., 1.], [1., 2.])))),
            ("-blendu on -mm 0 1  -cc off -bm 2 t.png", ("t.png", Wrap::Repeat, None)),
            ("-.png", ("-.png", Wrap::Repeat, None)),
        ] {
            assert_eq!(read(text).unwrap(), expected, "{text}");
        }
        for (text, option) in [
            ("-s wall.png", "-s"),
            ("-s x wall.png", "-s"),
            ("-t 0.1 wall.png", "-t"),
            ("-o nan wall.png", "-o"),
            ("-mm 0.2 1 wall.png", "-mm"),
            ("-cc on wall.png", "-cc"),
            ("-clamp wall.png", "-clamp"),
            ("-imfchan r wall.png", "-imfchan"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert_eq!(error, format!("has options that are not read: {option}"), "{text}");
        }
    }
}
