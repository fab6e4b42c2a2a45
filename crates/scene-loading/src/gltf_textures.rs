//! Textures of glTF files: `baseColorTexture` with its `texCoord` and the wrap modes of its sampler.
//!
//! Images come from buffer views, data URIs, and files below the file's folder. One that cannot be
//! read leaves the plain colour, with a warning that names the material. Filters of samplers are
//! not taken (the renderer has one), nor are alpha and `KHR_texture_transform` (a warning).
//! The crate's own `Image::source` panics on images without URI and view: it is not called.

use std::path::Path;

use ::gltf::Document;
use ::gltf::texture::{Info, WrappingMode};

use crate::gltf_buffers::Buffers;
use crate::scene::{Scene, Warning};
use crate::texture::Wrap;
use crate::texture_read::{TextureError, TextureReader, warning};

/// The extension that moves and scales texture coordinates.
const TRANSFORM: &str = "KHR_texture_transform";

/// The textures of a document, each read when a primitive needs it.
pub(crate) struct Textures<'a> {
    path: &'a Path,
    document: &'a Document,
    buffers: &'a Buffers<'a>,
    reader: TextureReader,
    /// Of each material: `None` before it is asked for, then its set of texture coordinates if it
    /// has a texture.
    sets: Vec<Option<Option<u32>>>,
    is_warned: bool,
}

impl<'a> Textures<'a> {
    /// Of a document; reads nothing yet.
    pub fn new(path: &'a Path, document: &'a Document, buffers: &'a Buffers<'a>) -> Self {
        let sets = vec![None; document.materials().len()];
        let reader = TextureReader::default();
        Self { path, document, buffers, reader, sets, is_warned: false }
    }

    /// The set of texture coordinates that a material wants; its texture is in the scene then.
    pub fn of(&mut self, material: &::gltf::Material<'_>, scene: &mut Scene) -> Option<u32> {
        let index = material.index()?;
        if let Some(known) = self.sets.get(index).copied().flatten() {
            return known;
        }
        let info = material.pbr_metallic_roughness().base_color_texture();
        let set = info.and_then(|info| self.read(&info, index, scene));
        if let Some(known) = self.sets.get_mut(index) {
            *known = Some(set);
        }
        set
    }

    fn read(&mut self, info: &Info<'_>, material: usize, scene: &mut Scene) -> Option<u32> {
        if !self.is_warned && self.document.extensions_used().any(|name| name == TRANSFORM) {
            self.is_warned = true;
            let text = format!("{}: {TRANSFORM} is not applied", self.path.display());
            scene.warnings.push(Warning(text));
        }
        let texture = info.texture();
        let (sampler, image) = (texture.sampler(), texture.source().index());
        let wrap = [sampler.wrap_s(), sampler.wrap_t()].map(|mode| match mode {
            WrappingMode::Repeat => Wrap::Repeat,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
            WrappingMode::ClampToEdge => Wrap::Clamp,
        });
        let name = format!("image {image}");
        let read = self
            .reader
            .add(scene, &name, wrap, || bytes_of(self.document, self.buffers, image, &name));
        let entry = scene.materials.get_mut(material)?;
        match read {
            Ok(index) => {
                entry.texture = Some(index);
                Some(info.tex_coord())
            }
            Err(error) => {
                let place = self.path.display();
                scene.warnings.push(warning(&place, &entry.name, &name, &error));
                None
            }
        }
    }
}

fn bytes_of(
    document: &Document,
    buffers: &Buffers<'_>,
    image: usize,
    name: &str,
) -> Result<Vec<u8>, TextureError> {
    let json = document.as_json().images.get(image);
    let view = json.and_then(|json| json.buffer_view);
    let view = view.and_then(|view| document.views().nth(view.value()));
    match (json.and_then(|json| json.uri.as_deref()), view) {
        (Some(uri), _) => Ok(buffers.read_uri(name, uri)?),
        (None, Some(view)) => Ok(buffers.view(name, &view)?.to_vec()),
        (None, None) => {
            Err(TextureError::Malformed("neither a URI nor a buffer view of the file".into()))
        }
    }
}
