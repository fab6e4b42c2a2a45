//! glTF files that tests write.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use scene_loading::gltf::parse_gltf;
use scene_loading::{LoadError, Scene};
use serde_json::{Value, json};

/// A document and the bytes of its only buffer, four a number.
#[derive(Clone)]
pub struct File {
    pub json: Value,
    pub bytes: Vec<u8>,
}

impl File {
    /// Two nodes with a triangle from (0, 0, 0) to (1, 0, 0) and (0, 1, 0), the second 5 units up.
    pub fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0, 1]}],
            "nodes": [{"mesh": 0}, {"mesh": 0, "translation": [0, 0, 5]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [], "bufferViews": [],
            "animations": [{"samplers": [], "channels": []}]
        });
        let mut file = Self { json, bytes: Vec::new() };
        file.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
        file.json["accessors"][0]["min"] = json!([0, 0, 0]);
        file.json["accessors"][0]["max"] = json!([1, 1, 0]);
        file
    }

    /// The first node alone, without animations.
    pub fn triangle() -> Self {
        let mut file = Self::new();
        file.json["scenes"][0]["nodes"] = json!([0]);
        file.json.as_object_mut().unwrap().remove("animations");
        file
    }

    /// Adds a value to a list and returns its number.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    /// Adds a view of these bytes and returns its number.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let (offset, length) = (self.bytes.len(), bytes.len());
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
        self.push("bufferViews", view)
    }

    /// Adds an accessor and returns its number.
    pub fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor =
            json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
        self.push("accessors", accessor)
    }

    /// Adds an accessor of so many vectors without data.
    pub fn zeros(&mut self, count: usize) -> usize {
        self.push("accessors", json!({"componentType": 5126, "count": count, "type": "VEC3"}))
    }

    /// The attributes of its triangle.
    pub fn attributes(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]["attributes"]
    }

    pub fn floats(&mut self, kind: &str, numbers: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(kind, 5126, numbers.len() / width, &bytes)
    }

    /// The document, its buffer in a data URI.
    pub fn document(&self) -> Value {
        let mut json = self.json.clone();
        let uri = format!("data:;base64,{}", STANDARD.encode(&self.bytes));
        json["buffers"] = json!([{"byteLength": self.bytes.len(), "uri": uri}]);
        json
    }

    pub fn text(&self) -> String {
        self.document().to_string()
    }

    /// The file at rest.
    pub fn load(&self) -> Result<Scene, LoadError> {
        parse_gltf(Path::new("a.gltf"), self.text().as_bytes())
    }

    /// Its triangles and bounds, after the second reader has found the same.
    pub fn found(&self) -> (usize, [[f64; 3]; 2]) {
        let scene = self.load().unwrap_or_else(|error| panic!("{error}: {}", self.json));
        let triangles = scene.primitives.len() as u64;
        let asked = crate::asked(Path::new("a.gltf"), self.text().into_bytes());
        assert_eq!(asked, (triangles, Vec::new()));
        let bounds = scene.bounds();
        (scene.primitives.len(), [bounds.min, bounds.max].map(|corner| corner.to_array()))
    }

    /// Its warnings, in one text.
    pub fn warnings(&self) -> String {
        let scene = self.load().unwrap_or_else(|error| panic!("{error}: {}", self.json));
        scene.warnings.iter().map(|warning| format!("{warning}\n")).collect()
    }

    /// Why it is refused.
    pub fn refusal(&self) -> String {
        let text = self.load().expect_err(&self.json.to_string()).to_string();
        assert!(text.starts_with("a.gltf: ") && !text.contains("panic"), "{text}");
        text
    }
}

/// A chunk of a GLB file.
pub fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    [&(data.len() as u32).to_le_bytes()[..], kind, data].concat()
}

/// A GLB file of chunks.
pub fn glb(chunks: &[Vec<u8>]) -> Vec<u8> {
    let all = chunks.concat();
    let length = (12 + all.len() as u32).to_le_bytes();
    [&b"glTF\x02\0\0\0"[..], &length, &all].concat()
}

/// A document with the value at a JSON pointer set, whose last key may be new.
pub fn set(mut document: Value, pointer: &str, value: Value) -> Value {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    let parent = document.pointer_mut(parent).unwrap();
    match parent {
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
        _ => parent[key] = value,
    }
    document
}
