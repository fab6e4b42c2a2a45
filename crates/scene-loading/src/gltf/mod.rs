//! glTF 2.0: `.glb`, and `.gltf` with `.bin` files or data URIs, through the crate `gltf`.
//!
//! Read: triangles (lists, strips, fans) under the transforms of their nodes, skins and morph
//! targets at rest or in an animation (`animated`), instances (`instancing`), base colours and
//! their textures (`textures`), the first perspective camera, point and spot lights
//! (`KHR_lights_punctual`). Left out with a warning: other textures, vertex colours, points and
//! lines, orthographic cameras, directional lights, and extensions that are not read
//! (`extensions`). A file that requires one of these that may be geometry is refused.
//!
//! The crate panics on some invalid files and believes lengths that it reads. So the container,
//! URIs, buffer views and accessors are checked here before it reads through them; images it never
//! touches; and a panic inside the crate is caught and becomes [`LoadError::Parser`] (the command
//! line keeps the panic's own message from stderr).

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use crate::error::LoadError;
use crate::gltf::buffers::Buffers;
use crate::gltf::container::Container;
use crate::gltf::extensions::NodeExtensions;
use crate::gltf::nodes::NodeWalker;
use crate::gltf::rules::parser_error;
use crate::input::read::{read_file, scene_name};
use crate::scene::Scene;
use ::gltf::Document;

pub(crate) mod animated;
pub(crate) mod buffers;
mod clip;
mod container;
mod deform;
pub(crate) mod extensions;
pub(crate) mod instancing;
mod meshes;
mod nodes;
mod rules;
mod textures;
mod tree;
pub(crate) mod vectors;

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
        let opened = OpenedFile::read(path, bytes)?;
        let mut walker = opened.walker();
        walker.walk(&opened.scene()?)?;
        walker.finish(None)
    })
}

/// Turns a panic inside the crate `gltf` into an error.
fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T, LoadError>) -> Result<T, LoadError> {
    catch_panic(read).unwrap_or_else(|text| Err(parser_error(path, text)))
}

/// Runs a reader that may panic; a panic becomes its text.
pub(crate) fn catch_panic<T>(read: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(read)).map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("unknown");
        format!("panic: {text}")
    })
}

/// A file, its parts checked as far as the crate does not.
pub(crate) struct OpenedFile {
    path: PathBuf,
    pub document: Document,
    pub buffers: Buffers,
    pub extensions: NodeExtensions,
}

impl OpenedFile {
    pub fn read(path: &Path, bytes: &[u8]) -> Result<Self, LoadError> {
        let container = Container::open(path, bytes)?;
        let json = container.parse(path)?;
        extensions::check(path, &json)?;
        rules::check(path, &json)?;
        let extensions = NodeExtensions::read(path, container.json, &json)?;
        let document = Document::from_json_without_validation(json);
        let buffers = Buffers::load(path, &document, container.binary)?;
        Ok(Self { path: path.to_path_buf(), document, buffers, extensions })
    }

    fn scene(&self) -> Result<::gltf::Scene<'_>, LoadError> {
        let scene = self.document.default_scene().or_else(|| self.document.scenes().next());
        scene.ok_or_else(|| LoadError::gltf(&self.path, "document", "no scene", "at least one"))
    }

    fn walker(&self) -> NodeWalker<'_> {
        let scene = Scene::new(scene_name(&self.path));
        NodeWalker::new(&self.path, &self.document, &self.buffers, &self.extensions, scene)
    }
}
