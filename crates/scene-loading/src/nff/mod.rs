//! Neural File Format (NFF), the format of the Standard Procedural Databases (SPD).
//!
//! Reads `b`, `v`, `l` (with or without a colour), `f`, `s`, `c`, `p`, `pp` and `#` comments, as
//! free-form text: line breaks count as any other white space. Deviations from the format:
//!
//! - A sphere of negative radius (the format: seen from inside) is an error; cones may have two
//!   negative radii.
//! - `pp` with more than three vertices is fanned into triangular patches, with a warning.
//! - A polygon that is not plane, or crosses itself, is split into triangles, with a warning.
//! - A patch with a normal that is NaN is a flat triangle, with a warning.
//! - Surface properties are not clamped: the file is believed.

use std::fmt;
use std::path::Path;

use glam::DVec3;

use crate::error::{FilePlace, LoadError};
use crate::input::{parse_number, scene_name, unified};
use crate::limits::{self, MAX_ELEMENTS, MAX_LIGHTS, MAX_MATERIALS};
use crate::mesh::{FaceCounts, push_outline, usable};
use crate::polygon::ear_clipping::MAX_CORNERS;
use crate::scene::{Camera, Cone, Light, Material, Scene};
use crate::words::{Word, Words};

const ENTITIES: &str = "one of b, v, l, f, s, c, p, pp, #";

/// Parses NFF text. `path` gives the scene its name and appears in errors.
///
/// # Errors
/// [`LoadError::Syntax`], [`LoadError::UnexpectedEnd`], [`LoadError::NotFinite`],
/// [`LoadError::OutOfRange`], [`LoadError::CountTooLarge`], each with the line, and
/// [`LoadError::NoPrimitives`].
pub fn parse_nff(path: &Path, text: &str) -> Result<Scene, LoadError> {
    let text = unified(text);
    let mut reader = Reader {
        words: Words::new(path, &text),
        scene: Scene::new(scene_name(path)),
        material: None,
        counts: FaceCounts::default(),
        fanned: 0,
        first_fanned: None,
    };
    let mut has_view = false;
    while let Some(word) = reader.words.next() {
        reader.check_size(word)?;
        match word.text {
            "b" => reader.scene.background = reader.words.vector("background colour")?.to_array(),
            "v" => {
                reader.scene.camera = view(&mut reader.words, word)?;
                has_view = true;
            }
            "l" => reader.scene.lights.push(light(&mut reader.words)?),
            "f" => {
                let material = surface(&mut reader.words)?;
                reader.material = Some(reader.scene.push_material(material));
            }
            "s" => reader.sphere(word)?,
            "c" => {
                let cone = cone(&mut reader.words, word)?;
                let material = reader.material();
                reader.scene.push_cone(material, cone);
            }
            "p" => reader.polygon(word)?,
            "pp" => reader.patch(word)?,
            _ => {
                let place = reader.words.place(word.line);
                return Err(LoadError::syntax(place, word.text, ENTITIES));
            }
        }
    }
    let mut scene = reader.scene;
    reader.counts.warn(&mut scene);
    if let Some((line, count)) = reader.first_fanned {
        let place = FilePlace::line(path, line);
        scene.warn(match reader.fanned {
            1 => format!("{place}: a patch of {count} vertices was split into a fan of triangles"),
            n => format!(
                "{place}: {n} patches of more than 3 vertices were split into fans of triangles"
            ),
        });
    }
    if scene.primitives.is_empty() {
        let expected = "sphere, cone, polygon or patch (s, c, p, pp)";
        return Err(LoadError::no_primitives(path, expected));
    }
    if !has_view {
        scene.frame_camera();
        scene.warn(format!("{}: no view (`v`): the camera frames the scene", path.display()));
    }
    Ok(scene)
}

struct Reader<'a> {
    words: Words<'a>,
    scene: Scene,
    material: Option<u32>,
    counts: FaceCounts,
    /// Patches of more than three vertices, and line and vertices of the first.
    fanned: usize,
    first_fanned: Option<(usize, u64)>,
}

impl Reader<'_> {
    /// Refuses what is larger than any scene may be.
    fn check_size(&self, at: Word<'_>) -> Result<(), LoadError> {
        let scene = &self.scene;
        for (count, limit, what) in [
            (scene.primitives.len(), MAX_ELEMENTS, "the number of primitives"),
            (scene.vertices.len(), MAX_ELEMENTS, "the number of vertices"),
            (scene.materials.len(), MAX_MATERIALS, "the number of surfaces (f)"),
            (scene.lights.len(), MAX_LIGHTS, "the number of lights"),
        ] {
            limits::check(count, limit, what, || self.words.place(at.line))?;
        }
        Ok(())
    }

    /// The current `f`, or a default material where a primitive comes before the first one.
    fn material(&mut self) -> u32 {
        *self.material.get_or_insert_with(|| self.scene.push_material(Material::default()))
    }

    fn sphere(&mut self, start: Word<'_>) -> Result<(), LoadError> {
        let center = self.words.vector("sphere centre")?;
        let radius = self.words.number("sphere radius")?;
        if radius < 0.0 {
            let (place, what) = (self.words.place(start.line), "the radius of a sphere");
            return Err(LoadError::out_of_range(place, what, radius, "at least 0"));
        }
        let material = self.material();
        self.scene.push_sphere(material, center, radius);
        Ok(())
    }

    /// The vertex count of a `p` or `pp`, and how many vertices the rest of the file can hold (at
    /// six characters for three numbers). A count that is a little too high is left to the reader
    /// of the vertices, which names the one that is missing; one that is absurd ends here.
    fn vertex_count(
        &mut self,
        start: Word<'_>,
        what: &str,
        vectors: usize,
    ) -> Result<(u64, usize), LoadError> {
        const PLAUSIBLE: u64 = 1 << 16;
        let room = self.words.remaining() / (6 * vectors) + 1;
        let count = self.words.integer(what, 3, u64::MAX)?;
        let most = usize::try_from(count).unwrap_or(usize::MAX);
        limits::check(most, MAX_CORNERS, what, || self.words.place(start.line))?;
        if count > PLAUSIBLE.max(room as u64) {
            let place = self.words.place(start.line);
            return Err(LoadError::too_many(place, what, count, room as u64));
        }
        Ok((count, room.min(count as usize)))
    }

    fn polygon(&mut self, start: Word<'_>) -> Result<(), LoadError> {
        let (count, room) = self.vertex_count(start, "the vertex count of a polygon", 1)?;
        let mut outline = Vec::with_capacity(room);
        for i in 1..=count {
            outline.push(self.words.vector(format_args!("vertex {i} of {count} of a polygon"))?);
        }
        let material = self.material();
        let Self { words, scene, counts, .. } = self;
        push_outline(material, &outline, scene, counts, || words.place(start.line))
    }

    fn patch(&mut self, start: Word<'_>) -> Result<(), LoadError> {
        let (count, room) = self.vertex_count(start, "the vertex count of a patch", 2)?;
        let mut corners: Vec<(DVec3, DVec3)> = Vec::with_capacity(room);
        for i in 1..=count {
            let what = format_args!("vertex {i} of {count} of a patch");
            corners.push((self.words.vector(what)?, self.normal(what)?));
        }
        let material = self.material();
        if let [first, rest @ ..] = corners.as_slice() {
            for pair in rest.windows(2) {
                let [b, c] = pair else { continue };
                let (vertices, normals) = ([first.0, b.0, c.0], [first.1, b.1, c.1]);
                if normals.iter().any(|normal| normal.is_nan()) {
                    self.scene.push_triangle(material, vertices);
                } else {
                    self.scene.push_patch(material, vertices, normals);
                }
            }
        }
        if count > 3 {
            self.fanned += 1;
            self.first_fanned.get_or_insert((start.line, count));
        }
        Ok(())
    }

    /// Three numbers; NaN where one is, or is too large.
    fn normal(&mut self, what: fmt::Arguments<'_>) -> Result<DVec3, LoadError> {
        let mut normal = [0.0; 3];
        for value in &mut normal {
            let word = self.words.any(what)?;
            let place = || self.words.place(word.line);
            let number = parse_number(word.text).ok_or_else(|| {
                LoadError::syntax(place(), word.text, format!("a number ({what})"))
            })?;
            *value = usable(number);
            if value.is_nan() {
                self.counts.normals.add(place);
            }
        }
        Ok(DVec3::from_array(normal))
    }
}

/// Reads the arguments of a `v` statement.
pub(crate) fn view(words: &mut Words<'_>, start: Word<'_>) -> Result<Camera, LoadError> {
    let mut camera = Camera::default();
    let mut missing = vec!["resolution", "from", "at", "up", "angle"];
    while let Some(Word { text: key, .. }) = words.peek() {
        if !["from", "at", "up", "angle", "hither", "resolution"].contains(&key) {
            break;
        }
        words.next();
        missing.retain(|missing| *missing != key);
        match key {
            "from" => camera.from = words.vector("view `from`")?,
            "at" => camera.at = words.vector("view `at`")?,
            "up" => camera.up = words.vector("view `up`")?,
            "angle" => camera.angle = words.number("view `angle`")?,
            "hither" => camera.hither = words.number("view `hither`")?,
            _ => {
                // the range keeps both within u32
                let mut side = || words.integer("view `resolution`", 1, 65_536);
                camera.resolution = [side()? as u32, side()? as u32];
            }
        }
    }
    if let Some(key) = missing.first() {
        return Err(LoadError::Syntax {
            place: words.place(start.line),
            found: format!("a view without `{key}`"),
            expected: "v with from, at, up, angle, resolution (and hither)".into(),
        });
    }
    camera.check(|| words.place(start.line))?;
    Ok(camera)
}

/// Reads the arguments of an `l` statement.
pub(crate) fn light(words: &mut Words<'_>) -> Result<Light, LoadError> {
    let position = words.vector("light position")?;
    let color = match words.peek() {
        Some(word) if word.looks_numeric() => Some(words.vector("light colour")?.to_array()),
        _ => None,
    };
    Ok(Light::point(position, color))
}

/// Reads the arguments of an `f` statement.
pub(crate) fn surface(words: &mut Words<'_>) -> Result<Material, LoadError> {
    Ok(Material {
        color: words.vector("surface colour")?.to_array(),
        diffuse: words.number("diffuse share Kd")?,
        specular: words.number("specular share Ks")?,
        shine: words.number("shine")?,
        transmittance: words.number("transmittance T")?,
        refraction_index: words.number("index of refraction")?,
        ..Material::default()
    })
}

/// Reads the arguments of a `c` statement.
pub(crate) fn cone(words: &mut Words<'_>, start: Word<'_>) -> Result<Cone, LoadError> {
    let cone = Cone {
        base: words.vector("cone base")?,
        base_radius: words.number("cone base radius")?,
        apex: words.vector("cone apex")?,
        apex_radius: words.number("cone apex radius")?,
    };
    let (smaller, larger) =
        (cone.base_radius.min(cone.apex_radius), cone.base_radius.max(cone.apex_radius));
    if smaller < 0.0 && larger > 0.0 {
        let (place, what) = (words.place(start.line), "one of two radii of a cone");
        let expected = "both at least 0, or both at most 0 (seen from inside)";
        return Err(LoadError::out_of_range(place, what, smaller, expected));
    }
    Ok(cone)
}
