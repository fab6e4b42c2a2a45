//! The material files of an OBJ file, and the materials that its faces name.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::error::{FilePlace, LoadError};
use crate::input::{confined, is_missing, read_at_most};
use crate::limits::{self, MAX_MATERIALS};
use crate::obj::contents::ObjScan;
use crate::obj::maps::{Placement, read_maps};
use crate::obj::material::{MAX_LIBRARY_BYTES, parse_mtl};
use crate::obj::scan::MAX_LIBRARIES;
use crate::scene::{Material, Scene};

/// The most names that a warning lists.
const MAX_NAMES: usize = 20;

/// The materials of an OBJ file's faces.
pub(super) struct Materials {
    /// Index in the scene for each name of [`ObjScan::used`].
    pub ids: Vec<u32>,
    /// By index in the scene, of images that lie otherwise than texture coordinates say.
    pub placements: HashMap<u32, Placement>,
}

/// Fills the scene's materials from the MTL files, each read once; of several materials of a name
/// the last counts. Names that are used but not defined get the default material under their name.
pub(super) fn read(path: &Path, scan: &ObjScan, scene: &mut Scene) -> Result<Materials, LoadError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut maps = HashMap::new();
    let mut ids: HashMap<String, u32> = HashMap::new();
    let (mut left, mut count) = (MAX_LIBRARY_BYTES, 0);
    for (line, libraries) in &scan.libraries {
        let place = || FilePlace::line(path, *line);
        for name in names(folder, libraries) {
            count += 1;
            limits::check(count, MAX_LIBRARIES, "the number of material files", place)?;
            let Some(file) = file_of(folder, &name) else {
                scene.warn(format!(
                    "{}: mtllib `{name}` leads out of the folder; not read",
                    place()
                ));
                continue;
            };
            if is_missing(&file) {
                scene.warn(format!("{}: material file {} is missing", place(), file.display()));
                continue;
            }
            let bytes = match read_at_most(&file, left) {
                Ok(bytes) => bytes,
                Err(error) => {
                    scene.warn(format!("{}: a material file is not read: {error}", place()));
                    continue;
                }
            };
            left -= bytes.len() as u64;
            let library = parse_mtl(&file, bytes)?;
            library.odd.warn(scene);
            for (material, map) in library.entries {
                let id = match ids.get(&material.name) {
                    Some(&known) => known,
                    None => {
                        let id = add(Material::default(), scene, place)?;
                        ids.insert(material.name.clone(), id);
                        id
                    }
                };
                if let Some(slot) = scene.materials.get_mut(id as usize) {
                    *slot = material;
                }
                match map {
                    Some(map) => maps.insert(id, map),
                    None => maps.remove(&id),
                };
            }
        }
    }
    let id_of = |name: &str| ids.get(name).or_else(|| ids.get(before_comment(name))).copied();
    let placements = read_maps(&maps, scan.used.iter().filter_map(|(_, name)| id_of(name)), scene);
    let (mut undefined, mut listed) = (0, Vec::new());
    let mut found = Vec::with_capacity(scan.used.len());
    for (line, name) in &scan.used {
        if let Some(id) = id_of(name) {
            found.push(id);
            continue;
        }
        let material = Material { name: name.clone(), ..Material::default() };
        found.push(add(material, scene, || FilePlace::line(path, *line))?);
        undefined += 1;
        if undefined <= MAX_NAMES {
            listed.push(format!("`{name}` (line {line})"));
        }
    }
    if undefined > 0 {
        let (file, count, more) = (path.display(), undefined, undefined - listed.len());
        let mut list = listed.join(", ");
        if more > 0 {
            list.push_str(&format!(" and {more} more"));
        }
        scene.warn(format!("{file}: {count} undefined materials get the default: {list}"));
    }
    Ok(Materials { ids: found, placements })
}

/// A file that a `mtllib` names, with the separators of any system, if it lies in the folder.
fn file_of(folder: &Path, name: &str) -> Option<PathBuf> {
    confined(folder, &name.replace('\\', "/"))
}

/// The names behind a `mtllib`. Names may have blanks, and a comment may follow: what is there
/// decides. Without any such file all of it is one name.
fn names(folder: &Path, text: &str) -> Vec<String> {
    let is_there = |name: &str| file_of(folder, name).is_some_and(|file| !is_missing(&file));
    let uncommented = before_comment(text);
    if let Some(one) = [text, uncommented].into_iter().find(|name| is_there(name)) {
        return vec![one.to_owned()];
    }
    // a name ends in .mtl, or is a word
    let mut groups = vec![String::new()];
    for word in uncommented.split_whitespace().take(MAX_LIBRARIES) {
        let Some(last) = groups.last_mut() else { break };
        let blank = if last.is_empty() { "" } else { " " };
        *last = format!("{last}{blank}{word}");
        if word.to_ascii_lowercase().ends_with(".mtl") {
            groups.push(String::new());
        }
    }
    let mut names = Vec::new();
    for group in groups.iter().filter(|group| !group.is_empty()) {
        let mut words = group.split_whitespace();
        if !is_there(group) && words.any(is_there) {
            names.extend(group.split_whitespace().map(str::to_owned));
        } else {
            names.push(group.clone());
        }
    }
    names
}

/// A name up to a word that begins with `#`.
fn before_comment(name: &str) -> &str {
    let comment = name
        .match_indices('#')
        .map(|(at, _)| at)
        .find(|&at| name.get(..at).is_some_and(|before| before.ends_with(char::is_whitespace)));
    comment.and_then(|at| name.get(..at)).unwrap_or(name).trim_end()
}

/// Adds a material and returns its index.
fn add(
    material: Material,
    scene: &mut Scene,
    place: impl FnOnce() -> FilePlace,
) -> Result<u32, LoadError> {
    limits::check(scene.materials.len() + 1, MAX_MATERIALS, "the number of materials", place)?;
    Ok(scene.push_material(material))
}
