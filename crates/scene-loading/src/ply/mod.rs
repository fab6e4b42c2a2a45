//! The Polygon File Format, PLY (G. Turk, "The PLY Polygon File Format", 1994): text and both
//! binary encodings, all types, and indices of 64 bits or of floats. Words of the header may be in
//! any case.
//!
//! Of the element `vertex`, `x`, `y`, `z` are read and, where all three are there, `nx`, `ny`,
//! `nz`: faces then have normals. Of `face`, the list `vertex_indices` or `vertex_index`, else its
//! only list of whole numbers; of `tristrips`, strips of triangles that -1 ends. Everything else is
//! left out: colours, texture coordinates, further elements. Lines of text may be broken anywhere.
//!
//! Vertices that are NaN are left alone where no face has them; faces that have them are left out.

mod header;
mod values;

use std::path::Path;

use glam::DVec3;

use crate::error::{FileLocation, FilePlace, LoadError};
use crate::input::{scene_name, without_mark};
use crate::limits::{self, MAX_ELEMENTS};
use crate::mesh::{FaceCounts, FirstAndCount, Mesh, usable};
use crate::ply::header::{Element, Encoding, Header, Kind, Property, Scalar, parse_header};
use crate::ply::values::{Binary, Text, Values};
use crate::polygon::ear_clipping::MAX_CORNERS;
use crate::progress;
use crate::scene::{Scene, index};

/// Names of the list of a face's corners.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Parses a PLY file. `path` gives the scene its name and appears in errors, with the line in the
/// header and in texts, with the byte in binary data. Scenes have no lights, one material, and a
/// camera that frames them. `triangulate` splits larger faces.
///
/// # Errors
/// [`LoadError::Syntax`], [`LoadError::UnexpectedEnd`], [`LoadError::OutOfRange`],
/// [`LoadError::CountTooLarge`], [`LoadError::IndexOutOfRange`], [`LoadError::NoPrimitives`].
pub fn parse_ply(path: &Path, bytes: &[u8], triangulate: bool) -> Result<Scene, LoadError> {
    let (mut scene, material) = Scene::of_one_material(scene_name(path));
    add_ply(path, bytes, triangulate, material, &mut scene)?;
    if scene.primitives.is_empty() {
        let expected = "face with an area (is the file a point cloud?)";
        return Err(LoadError::no_primitives(path, expected));
    }
    scene.frame_camera();
    Ok(scene)
}

/// Adds the faces of a PLY file to a scene, and warnings of what was left out.
pub(crate) fn add_ply(
    path: &Path,
    bytes: &[u8],
    triangulate: bool,
    material: u32,
    scene: &mut Scene,
) -> Result<(), LoadError> {
    let bytes = without_mark(path, bytes)?;
    let header = parse_header(path, bytes)?;
    let at = header.data;
    let mesh = Mesh { triangulate, ..Mesh::of_triangles(material) };
    match header.encoding {
        Encoding::Ascii => {
            let values = Text { path, bytes, at, line: header.line };
            Reader::new(path, values, mesh, scene).read(&header)
        }
        encoding => {
            let values = Binary { path, bytes, at, encoding };
            Reader::new(path, values, mesh, scene).read(&header)
        }
    }
}

struct Reader<'a, V> {
    path: &'a Path,
    values: V,
    mesh: Mesh,
    scene: &'a mut Scene,
    /// Vertices of the file, once they are read.
    vertices: Option<usize>,
    counts: FaceCounts,
    too_few: FirstAndCount,
    corners: Vec<u32>,
}

impl<'a, V: Values> Reader<'a, V> {
    fn new(path: &'a Path, values: V, mesh: Mesh, scene: &'a mut Scene) -> Self {
        Self {
            path,
            values,
            mesh,
            scene,
            vertices: None,
            counts: FaceCounts::default(),
            too_few: FirstAndCount::default(),
            corners: Vec::new(),
        }
    }

    fn read(mut self, header: &Header) -> Result<(), LoadError> {
        for element in &header.elements {
            self.check_count(element, header.encoding)?;
            match element.name.as_str() {
                "vertex" => self.vertices(element)?,
                "face" => self.faces(element)?,
                "tristrips" => self.strips(element)?,
                _ => self.each(element, |reader, property, _| reader.skip(property))?,
            }
        }
        progress::end();
        self.counts.warn(self.scene);
        self.too_few.warn("faces with fewer than 3 corners left out", self.scene);
        if self.counts.vertices.is_any() || self.counts.normals.is_any() {
            self.mesh.replace_unusable(self.scene);
        }
        Ok(())
    }

    fn place(&self, within: FileLocation) -> FilePlace {
        FilePlace { file: self.path.to_path_buf(), within }
    }

    /// Refuses what the rest of the file cannot hold, before memory is taken.
    fn check_count(&self, element: &Element, encoding: Encoding) -> Result<(), LoadError> {
        let least = element.least_bytes(encoding).max(1);
        // the last number of a text needs nothing behind it
        let fits = (self.values.remaining() as u64 + 1) / least;
        let limit = fits.min(MAX_ELEMENTS as u64);
        if element.count <= limit || element.properties.is_empty() {
            return Ok(());
        }
        let place = FilePlace::line(self.path, element.line);
        Err(LoadError::too_many(place, format!("element {}", element.name), element.count, limit))
    }

    /// Reads all of an element, property by property.
    fn each(
        &mut self,
        element: &Element,
        mut read: impl FnMut(&mut Self, &Property, usize) -> Result<(), LoadError>,
    ) -> Result<(), LoadError> {
        if element.properties.is_empty() {
            return Ok(());
        }
        progress::begin(usize::try_from(element.count).unwrap_or(usize::MAX));
        for i in 0..element.count {
            progress::step(usize::try_from(i).unwrap_or(usize::MAX));
            for (position, property) in element.properties.iter().enumerate() {
                read(self, property, position).map_err(|error| numbered(error, element, i))?;
            }
        }
        Ok(())
    }

    fn skip(&mut self, property: &Property) -> Result<(), LoadError> {
        match property.kind {
            Kind::One(scalar) => self.values.skip(scalar, 1, &property.name),
            Kind::List { count, item } => {
                let count = self.length(count, &property.name)?;
                self.values.skip(item, count, &property.name)
            }
        }
    }

    /// The length of a list, which the rest of the file can hold.
    fn length(&mut self, scalar: Scalar, what: &str) -> Result<u64, LoadError> {
        let place = self.values.place();
        let length = self.values.next(scalar, what)?;
        let limit = self.values.remaining();
        if length >= 0.0 && length <= limit as f64 {
            return Ok(length as u64);
        }
        let (place, what) = (self.place(place), format!("the length of the list {what}"));
        if length >= 0.0 {
            return Err(LoadError::too_many(place, what, length as u64, limit as u64));
        }
        Err(LoadError::out_of_range(place, what, length, "at least 0"))
    }

    fn vertices(&mut self, element: &Element) -> Result<(), LoadError> {
        let place = || FilePlace::line(self.path, element.line);
        if self.vertices.is_some() {
            return Err(LoadError::syntax(place(), "element vertex", "one element vertex only"));
        }
        let count = usize::try_from(element.count).unwrap_or(usize::MAX);
        let all = self.scene.vertices.len().saturating_add(count);
        limits::check(all, MAX_ELEMENTS, "the number of vertices", place)?;
        let scalar = |name: &str| {
            let is_it = |p: &Property| p.name == name && matches!(p.kind, Kind::One(_));
            element.properties.iter().position(is_it)
        };
        let (positions, normals) = (["x", "y", "z"].map(scalar), ["nx", "ny", "nz"].map(scalar));
        if positions.contains(&None) {
            let expected = "an element vertex with properties x, y and z";
            return Err(LoadError::syntax(place(), "element vertex", expected));
        }
        let has_normals = !normals.contains(&None);
        self.mesh.first = index(self.scene.vertices.len());
        self.mesh.normals = has_normals.then_some(index(self.scene.normals.len()));
        self.scene.vertices.reserve(count);
        self.scene.normals.reserve(if has_normals { count } else { 0 });
        let wanted = [positions, if has_normals { normals } else { [None; 3] }];
        let slot_of = |at| wanted.as_flattened().iter().position(|&place| place == Some(at));
        let slots: Vec<Option<usize>> = (0..element.properties.len()).map(slot_of).collect();
        let mut numbers = [0.0; 6];
        let mut begin = FileLocation::Whole;
        self.each(element, |reader, property, at| {
            if at == 0 {
                begin = reader.values.place();
            }
            let slot = slots.get(at).copied().flatten().and_then(|slot| numbers.get_mut(slot));
            match (slot, property.kind) {
                (Some(slot), Kind::One(scalar)) => {
                    *slot = usable(reader.values.next(scalar, &property.name)?);
                }
                _ => reader.skip(property)?,
            }
            if at + 1 == slots.len() {
                let place = || FilePlace { file: reader.path.to_path_buf(), within: begin };
                let [x, y, z, nx, ny, nz] = numbers;
                let (position, normal) = (DVec3::new(x, y, z), DVec3::new(nx, ny, nz));
                if position.is_nan() {
                    reader.counts.vertices.add(place);
                }
                reader.scene.vertices.push(position);
                if has_normals {
                    if normal.is_nan() {
                        reader.mesh.has_bad_normals = true;
                        reader.counts.normals.add(place);
                    }
                    reader.scene.normals.push(normal);
                }
            }
            Ok(())
        })?;
        self.vertices = Some(count);
        Ok(())
    }

    /// Reads each list of corners of an element by a function that gets where it begins, the type
    /// of its items, and their number.
    fn corner_lists(
        &mut self,
        element: &Element,
        mut read: impl FnMut(&mut Self, FileLocation, Scalar, u64) -> Result<(), LoadError>,
    ) -> Result<(), LoadError> {
        if element.count == 0 {
            return Ok(());
        }
        let missing = |expected: &str| {
            let found = format!("element {}", element.name);
            LoadError::syntax(FilePlace::line(self.path, element.line), &found, expected)
        };
        if self.vertices.is_none() {
            return Err(missing("element vertex before it"));
        }
        let lists = || {
            let all = element.properties.iter().enumerate();
            all.filter_map(|(at, property)| match property.kind {
                Kind::List { count, item } => Some((at, property, count, item)),
                Kind::One(_) => None,
            })
        };
        let named = lists().find(|(_, property, ..)| CORNERS.contains(&property.name.as_str()));
        let found = named.or_else(|| {
            let mut all = lists().filter(|(.., item)| item.is_integer());
            all.next().filter(|_| all.next().is_none())
        });
        let (list, _, count, item) = found.ok_or_else(|| {
            missing("a list vertex_indices or vertex_index, or one list of whole numbers")
        })?;
        self.each(element, |reader, property, at| {
            if at != list {
                return reader.skip(property);
            }
            let begin = reader.values.place();
            let length = reader.length(count, &property.name)?;
            read(reader, begin, item, length)
        })
    }

    fn faces(&mut self, element: &Element) -> Result<(), LoadError> {
        self.corner_lists(element, |reader, within, item, length| {
            let path = reader.path;
            let place = || FilePlace { file: path.to_path_buf(), within };
            let length = usize::try_from(length).unwrap_or(usize::MAX);
            limits::check(length, MAX_CORNERS, "the number of corners of a face", place)?;
            // reused from face to face: files have millions
            let mut corners = std::mem::take(&mut reader.corners);
            corners.clear();
            for _ in 0..length {
                corners.extend(reader.index(item, false)?);
            }
            if length < 3 {
                reader.too_few.add(place);
            } else {
                reader.add(&corners, place)?;
            }
            reader.corners = corners;
            Ok(())
        })
    }

    fn add(&mut self, corners: &[u32], place: impl Fn() -> FilePlace) -> Result<(), LoadError> {
        let size = self.scene.primitives.len() + 1;
        limits::check(size, MAX_ELEMENTS, "the number of faces", &place)?;
        self.mesh.add(corners, self.scene, &mut self.counts, place)
    }

    /// Strips: each corner after the second makes a triangle with the two before it, turned every
    /// other time; -1 begins a new strip.
    fn strips(&mut self, element: &Element) -> Result<(), LoadError> {
        self.corner_lists(element, |reader, _, item, length| {
            let mut strip: Option<[u32; 2]> = None;
            let (mut begun, mut turned) = (None, false);
            for _ in 0..length {
                let (path, within) = (reader.path, reader.values.place());
                let Some(corner) = reader.index(item, true)? else {
                    (strip, begun, turned) = (None, None, false);
                    continue;
                };
                let Some([a, b]) = strip else {
                    strip = begun.replace(corner).map(|first| [first, corner]);
                    continue;
                };
                let corners = if turned { [b, a, corner] } else { [a, b, corner] };
                reader.add(&corners, || FilePlace { file: path.to_path_buf(), within })?;
                (strip, turned) = (Some([b, corner]), !turned);
            }
            Ok(())
        })
    }

    /// The index of a vertex; none for the -1 that may end a strip.
    fn index(&mut self, item: Scalar, may_end: bool) -> Result<Option<u32>, LoadError> {
        let vertices = self.vertices.unwrap_or(0);
        let place = self.values.place();
        let what = if may_end { "the index of a vertex, or -1" } else { "the index of a vertex" };
        let index = self.values.next(item, what)?;
        let whole = index as u32;
        if index < vertices as f64 && f64::from(whole) == index {
            return Ok(Some(whole));
        }
        if may_end && index == -1.0 {
            return Ok(None);
        }
        let valid = match vertices {
            0 => "the file has no vertices".to_owned(),
            _ => format!("0 to {} are there", vertices - 1),
        };
        Err(LoadError::bad_index(self.place(place), "vertex", index, valid))
    }
}

/// Says which of an element is missing where the file ends.
fn numbered(error: LoadError, element: &Element, index: u64) -> LoadError {
    match error {
        LoadError::UnexpectedEnd { place, expected } => {
            let (name, count) = (&element.name, element.count);
            let expected = format!("{expected} ({name} {} of {count})", index + 1);
            LoadError::UnexpectedEnd { place, expected }
        }
        other => other,
    }
}
