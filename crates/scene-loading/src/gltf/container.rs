//! The container of a glTF file: JSON alone, or a GLB file of chunks (sections 4.4 and 4.1 of the
//! glTF 2.0 specification), checked before the JSON is parsed; the rules of the format that its JSON
//! must keep; and the file that is read from it.

use std::path::{Path, PathBuf};

use ::gltf::Document;
use ::gltf::json::validation::{Checked, Error, Validate};
use ::gltf::json::{Root, camera::Type};
use serde::Deserialize;

use crate::error::{FilePlace, LoadError, quote};
use crate::gltf::buffers::Buffers;
use crate::gltf::extensions::{self, NodeExtensions};
use crate::input::without_mark;
use crate::limits;

/// The most JSON objects of a document. Each becomes up to a few hundred bytes in memory, from as
/// few as three in the file.
const MAX_OBJECTS: usize = 2 << 20;

/// The most faults that an error names.
const MAX_FAULTS: usize = 8;

/// A file, its parts checked as far as the crate does not.
pub(crate) struct OpenedFile {
    pub path: PathBuf,
    pub document: Document,
    pub buffers: Buffers,
    pub extensions: NodeExtensions,
}

impl OpenedFile {
    pub fn read(path: &Path, bytes: &[u8]) -> Result<Self, LoadError> {
        let (text, binary) = split(path, bytes)?;
        let json = parse(path, text)?;
        extensions::check(path, &json)?;
        check_rules(path, &json)?;
        let extensions = NodeExtensions::read(path, text, &json)?;
        let document = Document::from_json_without_validation(json);
        let buffers = Buffers::load(path, &document, binary)?;
        Ok(Self { path: path.to_path_buf(), document, buffers, extensions })
    }

    /// The scene to be loaded.
    pub fn scene(&self) -> Result<::gltf::Scene<'_>, LoadError> {
        let scene = self.document.default_scene().or_else(|| self.document.scenes().next());
        scene.ok_or_else(|| LoadError::gltf(&self.path, "document", "no scene", "at least one"))
    }

    pub fn place(&self) -> FilePlace {
        FilePlace::file(&self.path)
    }
}

/// The JSON of a file, and the binary chunk of a GLB file. Chunks of unknown types are skipped, as
/// the format asks.
fn split<'a>(path: &Path, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>), LoadError> {
    let bytes = without_mark(path, bytes)?;
    let Some(rest) = bytes.strip_prefix(b"glTF") else { return Ok((bytes, None)) };
    check_header(path, rest, bytes.len() as u64)?;
    let chunks = rest.get(8..).unwrap_or_default();
    let (kind, json, mut rest) = chunk(path, "the first GLB chunk", chunks)?;
    if kind != b"JSON" {
        let found = format!("type {}", quote(&String::from_utf8_lossy(kind)));
        return Err(LoadError::gltf(path, "the first GLB chunk", found, "type `JSON`"));
    }
    // some writers pad with zeros in place of spaces
    let end = json.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    let json = json.get(..end).unwrap_or_default();
    // what is left behind the last chunk is padding
    while rest.len() >= 8 {
        let (kind, data);
        (kind, data, rest) = chunk(path, "a GLB chunk", rest)?;
        if kind == b"BIN\0" {
            return Ok((json, Some(data)));
        }
    }
    Ok((json, None))
}

/// Parses the JSON; the values are not checked yet.
fn parse(path: &Path, json: &[u8]) -> Result<Root, LoadError> {
    // bounds what it can grow to
    let count = memchr::memchr_iter(b'{', json).count();
    limits::check(count, MAX_OBJECTS, "the number of JSON objects", || FilePlace::file(path))?;
    // compiled once, in the crate that it is of
    let error = match Root::from_slice(json) {
        Ok(root) => return Ok(root),
        Err(error) => error,
    };
    if let Some(error) = first_version(path, json) {
        return Err(error);
    }
    // the crate wants a node in each channel, where an extension may name something else
    let kept = node_channels(json).and_then(|json| Root::from_slice(&json).ok());
    kept.ok_or_else(|| LoadError::parser(path, error))
}

/// Kind, data, and the bytes behind, of the chunk at the start of `bytes`.
fn chunk<'a>(path: &Path, object: &str, bytes: &'a [u8]) -> Result<GlbChunk<'a>, LoadError> {
    let place = FilePlace::file(path);
    let header = bytes.split_first_chunk::<4>();
    let header = header.and_then(|(length, rest)| Some((length, rest.split_first_chunk::<4>()?)));
    let Some((length, (kind, rest))) = header else {
        return Err(LoadError::unexpected_end(place, format!("the header of {object}")));
    };
    let needed = u32::from_le_bytes(*length);
    let (data, after) = rest.split_at_checked(needed as usize).ok_or_else(|| {
        let (object, available) = (object.into(), rest.len() as u64);
        LoadError::PastBuffer { place, object, needed: needed.into(), available }
    })?;
    Ok((kind, data, after))
}

type GlbChunk<'a> = (&'a [u8; 4], &'a [u8], &'a [u8]);

/// Checks the version and the length that a GLB file states behind its first four bytes.
fn check_header(path: &Path, rest: &[u8], actual: u64) -> Result<(), LoadError> {
    let place = FilePlace::file(path);
    let Some(&[v0, v1, v2, v3, a, b, c, d]) = rest.first_chunk::<8>() else {
        return Err(LoadError::unexpected_end(place, "a GLB header of 12 bytes"));
    };
    let version = u32::from_le_bytes([v0, v1, v2, v3]);
    if version != 2 {
        return Err(LoadError::gltf(path, "GLB header", format!("version {version}"), "version 2"));
    }
    let declared = u64::from(u32::from_le_bytes([a, b, c, d]));
    if declared != actual || declared < 20 {
        return Err(LoadError::GlbLength { place, declared, actual });
    }
    Ok(())
}

/// The error for a file of glTF 1.0, which has another structure: the parser would name something
/// that its author never got wrong. None for other files.
fn first_version(path: &Path, json: &[u8]) -> Option<LoadError> {
    #[derive(Deserialize)]
    struct Document {
        asset: Option<Asset>,
    }
    #[derive(Deserialize)]
    struct Asset {
        version: Option<serde_json::Value>,
    }
    let document: Document = serde_json::from_slice(json).ok()?;
    let version = document.asset.and_then(|asset| asset.version).unwrap_or_default();
    let version = version.as_str().map_or_else(|| version.to_string(), str::to_owned);
    (version.starts_with('1') || version == "null")
        .then(|| LoadError::gltf(path, "asset", format!("version `{version}`"), "version 2.0"))
}

/// The JSON without the channels of animations that name no node (`KHR_animation_pointer`). The
/// format asks that they are ignored. None where there are no such channels.
fn node_channels(json: &[u8]) -> Option<Vec<u8>> {
    use serde_json::value::{RawValue, to_raw_value};
    use std::collections::BTreeMap;
    #[derive(Deserialize)]
    struct Channel {
        target: Target,
    }
    #[derive(Deserialize)]
    struct Target {
        node: Option<u32>,
    }
    type Object<'a> = BTreeMap<&'a str, &'a RawValue>;
    let mut root: Object<'_> = serde_json::from_slice(json).ok()?;
    let mut animations: Vec<Object<'_>> =
        serde_json::from_str(root.get("animations")?.get()).ok()?;
    let (mut kept_lists, mut left_out) = (Vec::new(), 0);
    for animation in &animations {
        let all: Vec<&RawValue> = serde_json::from_str(animation.get("channels")?.get()).ok()?;
        let names_node = |channel: &&&RawValue| {
            let channel = serde_json::from_str(channel.get());
            channel.is_ok_and(|channel: Channel| channel.target.node.is_some())
        };
        let kept: Vec<&&RawValue> = all.iter().filter(names_node).collect();
        left_out += all.len() - kept.len();
        kept_lists.push(to_raw_value(&kept).ok()?);
    }
    if left_out == 0 {
        return None;
    }
    for (animation, kept) in animations.iter_mut().zip(&kept_lists) {
        animation.insert("channels", kept);
    }
    let animations = to_raw_value(&animations).ok()?;
    root.insert("animations", &animations);
    serde_json::to_vec(&root).ok()
}

/// Refuses what breaks a rule of the format that the crate `gltf` checks, but for those of its checks
/// that do not count: where it is stricter than the specification, and where what is missing is not
/// needed.
fn check_rules(path: &Path, json: &Root) -> Result<(), LoadError> {
    check_before_validation(path, json)?;
    let mut faults = Vec::new();
    json.validate(json, ::gltf::json::Path::new, &mut |place, error| {
        let place = place();
        if faults.len() < MAX_FAULTS && !is_allowed(place.as_str(), error) {
            faults.push(format!("{place}: {error}"));
        }
    });
    if faults.is_empty() {
        return Ok(());
    }
    Err(LoadError::parser(path, format!("invalid glTF: {}", faults.join("; "))))
}

/// Returns whether the crate finds a fault where the file can be read all the same.
fn is_allowed(place: &str, error: Error) -> bool {
    let is_position = place.starts_with("meshes[") && place.contains("attributes[\"POSITION\"]");
    match error {
        // `extensions` decides about these
        Error::Unsupported => true,
        // an accessor without data is all zeros; a texture may have its image in an extension; a
        // primitive without positions is to be skipped; bounds of positions are not used
        Error::Missing => {
            is_position
                || place.starts_with("accessors[") && place.ends_with(".bufferView")
                || place.starts_with("textures[") && place.ends_with(".source")
        }
        // attributes of one's own begin with an underscore; extensions have paths of their own
        Error::Invalid => {
            is_position
                || place.ends_with("attributes[\"<invalid semantic name>\"]")
                || place.starts_with("animations[") && place.ends_with(".target.path")
        }
        _ => false,
    }
}

/// Checks that prevent panics in the crate's own validation (1.4.1) or later.
fn check_before_validation(path: &Path, json: &Root) -> Result<(), LoadError> {
    let accessors = json.accessors.len();
    for (m, mesh) in json.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let accessor = primitive.attributes.values().find(|i| i.value() >= accessors);
            if let Some(index) = accessor {
                let what = format!("mesh {m} primitive {p}: accessor");
                let valid = format!("there are {accessors}, counted from 0");
                let place = FilePlace::file(path);
                return Err(LoadError::bad_index(place, what, index.value(), valid));
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
            let (found, expected) =
                ("a type without its properties", "an object named as its type");
            return Err(LoadError::gltf(path, format!("camera {c}"), found, expected));
        }
    }
    Ok(())
}
