//! glTF files that tests write.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use scene_loading::gltf::parse_gltf;
use scene_loading::second_opinion::{SecondOpinion, second_opinion};
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

    /// Adds an accessor and returns its number.
    pub fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        views.push(view);
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let all = self.json["accessors"].as_array_mut().unwrap();
        all.push(json!({
            "bufferView": all.len(), "componentType": component, "count": count, "type": kind
        }));
        all.len() - 1
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

    /// The file, its buffer in a data URI.
    pub fn text(&self) -> String {
        let mut json = self.json.clone();
        let uri = format!("data:;base64,{}", STANDARD.encode(&self.bytes));
        json["buffers"] = json!([{"byteLength": self.bytes.len(), "uri": uri}]);
        json.to_string()
    }

    /// The file at rest.
    pub fn load(&self) -> Result<Scene, LoadError> {
        parse_gltf(Path::new("a.gltf"), self.text().as_bytes())
    }

    /// Its triangles and bounds, after the second reader has found the same.
    pub fn found(&self) -> (usize, [[f64; 3]; 2]) {
        let scene = self.load().unwrap_or_else(|error| panic!("{error}: {}", self.json));
        let opinion = second_opinion(Path::new("a.gltf"), self.text().into_bytes()).unwrap();
        let SecondOpinion::Asked { triangles, differences, .. } = &opinion else {
            panic!("{opinion:?}");
        };
        assert_eq!(differences, &Vec::<String>::new());
        assert_eq!(*triangles as usize, scene.primitives.len());
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
