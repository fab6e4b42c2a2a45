//! Textures of glTF files: `baseColorTexture` with its `texCoord` and the wrap modes of its
//! sampler.
//!
//! Images come from buffer views, data URIs, and files below the file's folder. One that cannot be
//! read leaves the plain colour, with a warning that names the material. Filters of samplers are
//! not taken (the renderer has one), nor is alpha. The crate's own `Image::source` and
//! `Texture::source` panic where there is nothing: they are not called.

use std::collections::HashMap;
use std::rc::Rc;

use ::gltf::texture::{Info, WrappingMode};

use crate::gltf::container::OpenedFile;
use crate::images::{TextureError, TextureReader, file_key, warning};
use crate::input::read_at_most;
use crate::limits::MAX_WARNINGS;
use crate::scene::{Scene, Wrap};

/// The textures of a document, each read when a primitive needs it.
pub(crate) struct Textures<'a> {
    file: &'a OpenedFile,
    reader: TextureReader,
    /// The set of texture coordinates of each material used so far, if it has a texture.
    sets: HashMap<usize, Option<u32>>,
    /// Warnings that are only counted.
    pub unsaid: usize,
}

impl<'a> Textures<'a> {
    /// Prepares the textures of a document; reads nothing yet.
    pub fn new(file: &'a OpenedFile) -> Self {
        Self { file, reader: TextureReader::default(), sets: HashMap::new(), unsaid: 0 }
    }

    /// The set of texture coordinates that a material wants; its texture is in the scene then.
    pub fn of(&mut self, material: &::gltf::Material<'_>, scene: &mut Scene) -> Option<u32> {
        let index = material.index()?;
        if let Some(known) = self.sets.get(&index) {
            return *known;
        }
        let info = material.pbr_metallic_roughness().base_color_texture();
        let set = info.and_then(|info| self.read(&info, index, scene));
        self.sets.insert(index, set);
        set
    }

    fn read(&mut self, info: &Info<'_>, material: usize, scene: &mut Scene) -> Option<u32> {
        let texture = info.texture();
        let sampler = texture.sampler();
        let wrap = [sampler.wrap_s(), sampler.wrap_t()].map(|mode| match mode {
            WrappingMode::Repeat => Wrap::Repeat,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
            WrappingMode::ClampToEdge => Wrap::Clamp,
        });
        let json = self.file.document.as_json();
        let image = json.textures.get(texture.index()).map(|texture| texture.source.value());
        let (name, read) = match image.filter(|&image| image < json.images.len()) {
            Some(image) => {
                let name = format!("image {image}");
                let read = self.add(image, &name, wrap, scene);
                (name, read)
            }
            None => {
                let why = "no image but what an extension may have".to_owned();
                let error = Rc::new(TextureError::Malformed(why));
                (format!("texture {}", texture.index()), Err(error))
            }
        };
        let entry = scene.materials.get_mut(material)?;
        match read {
            Ok(index) => {
                entry.texture = Some(index);
                Some(info.tex_coord())
            }
            Err(error) => {
                let place = self.file.path.display();
                if scene.warnings.len() < MAX_WARNINGS {
                    scene.warnings.push(warning(&place, &entry.name, &name, &error));
                } else {
                    self.unsaid += 1;
                }
                None
            }
        }
    }

    /// Adds an image, which is read if it was not before.
    fn add(
        &mut self,
        image: usize,
        name: &str,
        wrap: [Wrap; 2],
        scene: &mut Scene,
    ) -> Result<u32, Rc<TextureError>> {
        let OpenedFile { document, buffers, .. } = self.file;
        let json = document.as_json().images.get(image);
        let view = json.and_then(|json| json.buffer_view);
        let uri = json.and_then(|json| json.uri.as_deref());
        if let Some(uri) = uri.filter(|uri| !uri.starts_with("data:")) {
            let path = buffers.file_of(name, uri).map_err(|e| Rc::new(e.into()))?;
            let key = file_key(&path);
            return self.reader.add(scene, key, name, wrap, |most| Ok(read_at_most(&path, most)?));
        }
        // no path that a URI gives has a file name like this: those with a colon are refused
        let key = format!("data:{name}").into();
        self.reader.add(scene, key, name, wrap, |most| {
            if let Some(uri) = uri {
                return Ok(buffers.read_uri(name, uri)?);
            }
            let view = view.and_then(|view| document.views().nth(view.value()));
            let view = view.ok_or_else(|| {
                TextureError::Malformed("neither a URI nor a buffer view of the file".into())
            })?;
            let bytes = buffers.view(name, &view)?;
            if bytes.len() as u64 > most {
                return Err(TextureError::Malformed(format!("more than {most} bytes")));
            }
            Ok(bytes.to_vec())
        })
    }
}
