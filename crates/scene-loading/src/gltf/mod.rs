//! glTF 2.0: `.glb`, and `.gltf` with `.bin` files or data URIs, through the crate `gltf`.
//!
//! Taken: triangles (lists, strips, fans) under the transforms of their nodes, base colours, the
//! textures of base colours (`textures`), the first perspective camera, point and spot lights
//! (`KHR_lights_punctual`); of a scene that moves (`animated`) skins and morph targets, too. Not taken: other
//! textures, points and lines (counted in a warning), orthographic cameras and directional lights (a warning). Files that *require* another extension are refused.
//!
//! The crate panics on some invalid files and believes lengths that it reads. So the GLB header,
//! URIs, buffer views and accessors are checked here before it reads through them; images it never
//! touches; and as a last belt a panic inside the crate is caught and becomes
//! [`LoadError::Parser`] (the command line keeps the panic's own message from stderr).

pub(crate) mod animated;
pub(crate) mod buffers;
mod clip;
mod deform;
mod keys;
mod materials;
mod nodes;
mod pose;
mod textures;
mod tree;
pub(crate) mod vectors;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use ::gltf::Document;

use crate::error::{FilePlace, LoadError, quote};
use crate::gltf::buffers::Buffers;
use crate::gltf::nodes::Walker;
use crate::input::read::{read_file, scene_name};
use crate::scene::Scene;

/// Loads a `.gltf` or `.glb` file, and the buffer files below its folder.
///
/// # Errors
/// Any [`LoadError`] of reading files, and of [`parse_gltf`].
pub fn load_gltf(path: &Path) -> Result<Scene, LoadError> {
    parse_gltf(path, &read_file(path)?)
}

/// Parses glTF bytes, binary or JSON. `path` gives the scene its name and the folder of its
/// buffers, and appears in errors. A scene without a camera is framed.
///
/// # Errors
/// [`LoadError::GlbLength`], [`LoadError::Parser`] (malformed JSON, unsupported required
/// extensions), [`LoadError::Gltf`], [`LoadError::PastBuffer`], [`LoadError::OutsideFolder`],
/// [`LoadError::IndexOutOfRange`], [`LoadError::NotFinite`], [`LoadError::NodeReachedTwice`],
/// [`LoadError::CountTooLarge`] and [`LoadError::NoPrimitives`].
pub fn parse_gltf(path: &Path, bytes: &[u8]) -> Result<Scene, LoadError> {
    guarded(path, || {
        let opened = Opened::read(path, bytes)?;
        let mut walker = opened.walker();
        walker.walk(&opened.scene()?)?;
        walker.finish(None)
    })
}

/// Turns a panic inside the crate `gltf` into an error.
fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T, LoadError>) -> Result<T, LoadError> {
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("unknown");
        Err(parser_error(path, format!("panic: {text}")))
    })
}

fn parser_error(path: &Path, message: String) -> LoadError {
    LoadError::Parser { place: FilePlace::file(path), parser: "gltf", message }
}

/// A file, its parts checked as far as the crate does not.
struct Opened {
    path: PathBuf,
    document: Document,
    buffers: Buffers,
}

impl Opened {
    fn read(path: &Path, bytes: &[u8]) -> Result<Self, LoadError> {
        check_glb_header(path, bytes)?;
        check_objects(path, bytes)?;
        let fail = |error: ::gltf::Error| parser_error(path, error.to_string());
        let ::gltf::Gltf { document, blob } = ::gltf::Gltf::from_slice_without_validation(bytes)
            .map_err(|error| first_version(path, bytes).unwrap_or_else(|| fail(error)))?;
        let json = document.into_json();
        check_extensions(path, &json)?;
        check_before_validation(path, &json)?;
        let document = Document::from_json(json).map_err(fail)?;
        let buffers = Buffers::load(path, &document, blob)?;
        Ok(Self { path: path.to_path_buf(), document, buffers })
    }

    fn scene(&self) -> Result<::gltf::Scene<'_>, LoadError> {
        let scene = self.document.default_scene().or_else(|| self.document.scenes().next());
        scene.ok_or_else(|| LoadError::Gltf {
            place: FilePlace::file(&self.path),
            object: "document".into(),
            found: "no scene".into(),
            expected: "at least one".into(),
        })
    }

    fn walker(&self) -> Walker<'_> {
        let scene = Scene::new(scene_name(&self.path));
        Walker::new(&self.path, &self.document, &self.buffers, scene)
    }
}

/// The most JSON objects of a document. Each becomes up to a few hundred bytes in memory, from as
/// few as three in the file.
const MAX_OBJECTS: usize = 2 << 20;

/// Bounds what the JSON can grow to, before it is parsed.
fn check_objects(path: &Path, bytes: &[u8]) -> Result<(), LoadError> {
    let json = match bytes.strip_prefix(b"glTF").map(|rest| rest.get(8..12)) {
        Some(Some(&[a, b, c, d])) => {
            let length = u32::from_le_bytes([a, b, c, d]) as usize;
            bytes.get(20..).map(|rest| rest.get(..length).unwrap_or(rest)).unwrap_or_default()
        }
        _ => bytes,
    };
    let count = memchr::memchr_iter(b'{', json).count();
    if count <= MAX_OBJECTS {
        return Ok(());
    }
    Err(LoadError::CountTooLarge {
        place: FilePlace::file(path),
        what: "the number of JSON objects".into(),
        count: count as u64,
        limit: MAX_OBJECTS as u64,
    })
}

/// The error for a file of glTF 1.0, which has another structure: the parser would name something
/// that its author never got wrong. None for other files.
fn first_version(path: &Path, bytes: &[u8]) -> Option<LoadError> {
    #[derive(serde::Deserialize)]
    struct Document {
        asset: Option<Asset>,
    }
    #[derive(serde::Deserialize)]
    struct Asset {
        version: Option<serde_json::Value>,
    }
    let document: Document = serde_json::from_slice(bytes).ok()?;
    let version = document.asset.and_then(|asset| asset.version).unwrap_or_default();
    let version = version.as_str().map_or_else(|| version.to_string(), str::to_owned);
    (version.starts_with('1') || version == "null").then(|| LoadError::Gltf {
        place: FilePlace::file(path),
        object: "asset".into(),
        found: format!("version `{version}`"),
        expected: "version 2.0".into(),
    })
}

/// The extensions that a file may require.
const EXTENSIONS: [&str; 1] = ["KHR_lights_punctual"];

/// Refuses files that require what is not read here, before anything else is missed in them (a mesh
/// that is packed by an extension has no data of its own).
fn check_extensions(path: &Path, json: &::gltf::json::Root) -> Result<(), LoadError> {
    let missing = json.extensions_required.iter().map(String::as_str);
    let missing: Vec<&str> = missing.filter(|name| !EXTENSIONS.contains(name)).take(8).collect();
    if missing.is_empty() {
        return Ok(());
    }
    Err(LoadError::Gltf {
        place: FilePlace::file(path),
        object: "extensionsRequired".into(),
        found: missing.iter().map(|name| quote(name)).collect::<Vec<_>>().join(", "),
        expected: format!("none but {}", EXTENSIONS.join(", ")),
    })
}

/// What the crate's own validation (1.4.1) panics on, or lets pass to a panic later.
fn check_before_validation(path: &Path, json: &::gltf::json::Root) -> Result<(), LoadError> {
    use ::gltf::json::camera::Type;
    use ::gltf::json::validation::Checked;
    let invalid = |object: String, found: &str, expected: &str| LoadError::Gltf {
        place: FilePlace::file(path),
        object,
        found: found.into(),
        expected: expected.into(),
    };
    let accessors = json.accessors.len();
    for (m, mesh) in json.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let accessor = primitive.attributes.values().find(|i| i.value() >= accessors);
            if let Some(index) = accessor {
                return Err(LoadError::IndexOutOfRange {
                    place: FilePlace::file(path),
                    what: format!("mesh {m} primitive {p}: accessor"),
                    index: index.value().to_string(),
                    valid: format!("there are {accessors}, counted from 0"),
                });
            }
        }
    }
    for (c, camera) in json.cameras.iter().enumerate() {
        let described = match camera.type_ {
            Checked::Valid(Type::Perspective) => camera.perspective.is_some(),
            Checked::Valid(Type::Orthographic) => camera.orthographic.is_some(),
            Checked::Invalid => true,
        };
        if !described {
            let expected = "an object named as its type";
            return Err(invalid(format!("camera {c}"), "a type without its properties", expected));
        }
    }
    Ok(())
}

/// A GLB file states its length; the crate would believe it.
fn check_glb_header(path: &Path, bytes: &[u8]) -> Result<(), LoadError> {
    let Some(rest) = bytes.strip_prefix(b"glTF") else { return Ok(()) };
    let actual = bytes.len() as u64;
    let Some(&[_, _, _, _, a, b, c, d]) = rest.first_chunk::<8>() else {
        let expected = "a GLB header of 12 bytes".to_string();
        return Err(LoadError::UnexpectedEnd { place: FilePlace::file(path), expected });
    };
    if let Some(version @ [1, 0, 0, 0]) = rest.first_chunk::<4>() {
        return Err(LoadError::Gltf {
            place: FilePlace::file(path),
            object: "GLB header".into(),
            found: format!("version {}", u32::from_le_bytes(*version)),
            expected: "version 2".into(),
        });
    }
    let declared = u64::from(u32::from_le_bytes([a, b, c, d]));
    if declared != actual || declared < 20 {
        return Err(LoadError::GlbLength { place: FilePlace::file(path), declared, actual });
    }
    Ok(())
}
