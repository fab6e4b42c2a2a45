//! Buffers and accessors of glTF files, checked before the crate `gltf` reads through them.

use std::path::{Path, PathBuf};

use ::gltf::accessor::{DataType, Dimensions, Item, Iter};
use ::gltf::buffer::{Source, View};
use ::gltf::{Accessor, Document};
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use crate::error::{FilePlace, LoadError, quote};
use crate::gltf::extensions;
use crate::input::{confined, read_file};
use crate::limits::MAX_BYTES;

/// The most elements that one accessor may have.
const MAX_ELEMENTS: u64 = 64 << 20;

/// The most elements of an accessor without a buffer view: zero but for sparse values, so that the
/// file need not hold them.
const MAX_ZEROS: u64 = 1 << 20;

/// Base64 with or without padding at its end, as browsers take it.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The bytes of all buffers of a document.
pub(crate) struct Buffers {
    path: PathBuf,
    data: Vec<Vec<u8>>,
}

impl Buffers {
    /// Reads every buffer: the GLB's own, data URIs, and files below the folder of `path`.
    pub fn load(
        path: &Path,
        document: &Document,
        mut binary: Option<&[u8]>,
    ) -> Result<Self, LoadError> {
        let mut buffers = Self { path: path.to_path_buf(), data: Vec::new() };
        let mut total: u64 = 0;
        for buffer in document.buffers() {
            let object = format!("buffer {}", buffer.index());
            let bytes = match buffer.source() {
                Source::Bin => binary.take().map(<[u8]>::to_vec).ok_or_else(|| {
                    let unread = extensions::packing(document.as_json());
                    let unread = unread.map(|name| format!(" ({name} is not read)"));
                    let found = "neither a URI nor a GLB chunk".to_owned();
                    buffers.invalid(&object, &(found + &unread.unwrap_or_default()), "one of them")
                })?,
                Source::Uri(uri) => buffers.read_uri(&object, uri)?,
            };
            buffers.fits(&object, buffer.length() as u64, bytes.len())?;
            total += bytes.len() as u64;
            if total > MAX_BYTES {
                return Err(LoadError::too_large(path, MAX_BYTES));
            }
            buffers.data.push(bytes);
        }
        Ok(buffers)
    }

    /// The bytes of a data URI, or of a file below the folder.
    pub fn read_uri(&self, object: &str, uri: &str) -> Result<Vec<u8>, LoadError> {
        if !uri.starts_with("data:") {
            return read_file(&self.file_of(object, uri)?);
        }
        let encoded = uri.split_once(";base64,").map(|(_, data)| data);
        match encoded.map(|data| BASE64.decode(data)) {
            Some(Ok(bytes)) => Ok(bytes),
            Some(Err(error)) => {
                let found = format!("a data URI with {error}");
                Err(self.invalid(object, &found, "base64 data"))
            }
            None => Err(self.invalid(object, "a data URI of another kind", "base64 data")),
        }
    }

    /// The file, below the folder, that a URI other than a data URI names.
    pub fn file_of(&self, object: &str, uri: &str) -> Result<PathBuf, LoadError> {
        let outside = || LoadError::OutsideFolder {
            place: FilePlace::file(&self.path),
            uri: uri.chars().take(80).collect(),
        };
        let decoded = percent_decode(uri).ok_or_else(|| {
            self.invalid(object, &format!("URI {}", quote(uri)), "UTF-8 in %XX codes")
        })?;
        if decoded.contains([':', '\\']) {
            return Err(outside());
        }
        confined(self.path.parent().unwrap_or(Path::new("")), &decoded).ok_or_else(outside)
    }

    /// Positions, normals or what moves them: `VEC3` of floats, or of bytes or shorts
    /// (`KHR_mesh_quantization`). They need not be finite.
    pub fn vectors(&self, accessor: Accessor<'_>, what: &str) -> Result<Vec<[f32; 3]>, LoadError> {
        self.quantizable(accessor, what, Dimensions::Vec3)
    }

    /// Texture coordinates: `VEC2` of floats, or of bytes or shorts. They need not be finite.
    pub fn texcoords(&self, accessor: Accessor<'_>) -> Result<Vec<[f32; 2]>, LoadError> {
        self.quantizable(accessor, "texture coordinates", Dimensions::Vec2)
    }

    /// Elements of floats, or of bytes or shorts, normalized or not.
    fn quantizable<const N: usize>(
        &self,
        accessor: Accessor<'_>,
        what: &str,
        dimensions: Dimensions,
    ) -> Result<Vec<[f32; N]>, LoadError>
    where
        [f32; N]: Item,
    {
        let is_known = match accessor.data_type() {
            DataType::F32 => !accessor.normalized(),
            kind => kind != DataType::U32,
        };
        let known = "F32, or of I8, U8, I16 or U16";
        let object = self.typed(&accessor, what, dimensions, is_known, known)?;
        if accessor.data_type() == DataType::F32 {
            return self.read(&object, accessor);
        }
        let numbers = self.scaled(&object, accessor)?;
        Ok(numbers.as_chunks().0.iter().map(|element| element.map(|x| x as f32)).collect())
    }

    /// The error for a number that is NaN or infinite.
    pub fn not_finite(&self, accessor: usize, what: &str, element: usize, found: f64) -> LoadError {
        let what = format!("accessor {accessor} ({what}), element {element}");
        LoadError::not_finite(FilePlace::file(&self.path), what, found)
    }

    /// Finite numbers, those of an element behind one another: floats, or where `normalized` ones
    /// may be, shares of the largest byte or short too.
    pub fn numbers(
        &self,
        accessor: Accessor<'_>,
        what: &str,
        dimensions: Dimensions,
        normalized: bool,
    ) -> Result<Vec<f64>, LoadError> {
        let is_known = match accessor.data_type() {
            DataType::F32 => !accessor.normalized(),
            DataType::U32 => false,
            _ => normalized && accessor.normalized(),
        };
        let known = if normalized { "F32, or of normalized bytes or shorts" } else { "F32" };
        let object = self.typed(&accessor, what, dimensions, is_known, known)?;
        let index = accessor.index();
        let numbers = self.scaled(&object, accessor)?;
        let width = dimensions.multiplicity();
        match numbers.iter().position(|x| !x.is_finite()) {
            None => Ok(numbers),
            Some(i) => {
                let found = numbers.get(i).copied().unwrap_or_default();
                Err(self.not_finite(index, what, i / width, found))
            }
        }
    }

    /// The components of all elements; normalized ones as shares of the largest.
    fn scaled(&self, object: &str, accessor: Accessor<'_>) -> Result<Vec<f64>, LoadError> {
        let is_normalized = accessor.normalized();
        let (mut numbers, most): (_, f64) = match accessor.data_type() {
            DataType::I8 => (self.flat::<i8>(object, accessor)?, i8::MAX.into()),
            DataType::U8 => (self.flat::<u8>(object, accessor)?, u8::MAX.into()),
            DataType::I16 => (self.flat::<i16>(object, accessor)?, i16::MAX.into()),
            DataType::U16 => (self.flat::<u16>(object, accessor)?, u16::MAX.into()),
            DataType::U32 => return self.flat::<u32>(object, accessor),
            DataType::F32 => return self.flat::<f32>(object, accessor),
        };
        if is_normalized {
            numbers.iter_mut().for_each(|x| *x = (*x / most).max(-1.0));
        }
        Ok(numbers)
    }

    /// Four joints for each vertex.
    pub fn joints(&self, accessor: Accessor<'_>) -> Result<Vec<[u16; 4]>, LoadError> {
        let is_known = matches!(accessor.data_type(), DataType::U8 | DataType::U16);
        let (is_known, known) = (is_known && !accessor.normalized(), "[U8, U16], not normalized");
        let object = self.typed(&accessor, "joints", Dimensions::Vec4, is_known, known)?;
        let joints = self.scaled(&object, accessor)?;
        Ok(joints.as_chunks().0.iter().map(|joints| joints.map(|joint| joint as u16)).collect())
    }

    /// The components of all elements as they are.
    fn flat<T: Item + Copy + Into<f64>>(
        &self,
        object: &str,
        accessor: Accessor<'_>,
    ) -> Result<Vec<f64>, LoadError> {
        let all: Vec<T> = match accessor.dimensions() {
            Dimensions::Scalar => self.read(object, accessor)?,
            Dimensions::Vec2 => self.read::<[T; 2]>(object, accessor)?.into_flattened(),
            Dimensions::Vec3 => self.read::<[T; 3]>(object, accessor)?.into_flattened(),
            Dimensions::Vec4 => self.read::<[T; 4]>(object, accessor)?.into_flattened(),
            Dimensions::Mat4 => {
                self.read::<[[T; 4]; 4]>(object, accessor)?.into_flattened().into_flattened()
            }
            other => {
                let expected = "Scalar, Vec2, Vec3, Vec4 or Mat4";
                return Err(self.invalid(object, &format!("{other:?}"), expected));
            }
        };
        Ok(all.into_iter().map(Into::into).collect())
    }

    /// All bytes of a buffer.
    pub fn bytes(&self, index: usize) -> Option<&[u8]> {
        self.data.get(index).map(Vec::as_slice)
    }

    /// The bytes of a buffer view, which `object` refers to.
    pub fn view(&self, object: &str, view: &View<'_>) -> Result<&[u8], LoadError> {
        self.check(object, view, 0, view.length() as u64, 1)?;
        let data = self.data.get(view.buffer().index()).map(Vec::as_slice).unwrap_or_default();
        let bytes = data.get(view.offset()..view.offset().saturating_add(view.length()));
        bytes.ok_or_else(|| self.invalid(object, "unreadable data", "bytes inside its buffer"))
    }

    /// Vertex indices, each checked to be below `vertices`.
    pub fn indices(&self, accessor: Accessor<'_>, vertices: usize) -> Result<Vec<u32>, LoadError> {
        let is_known = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        let (is_known, known) =
            (is_known && !accessor.normalized(), "[U8, U16, U32], not normalized");
        let object = self.typed(&accessor, "indices", Dimensions::Scalar, is_known, known)?;
        let indices: Vec<u32> =
            self.scaled(&object, accessor)?.into_iter().map(|index| index as u32).collect();
        match indices.iter().position(|&i| i as usize >= vertices) {
            None => Ok(indices),
            Some(i) => {
                let place = FilePlace::file(&self.path);
                let what = format!("{object}, element {i}: vertex");
                let valid = format!("there are {vertices} vertices, counted from 0");
                let index = indices.get(i).copied().unwrap_or_default();
                Err(LoadError::bad_index(place, what, index, valid))
            }
        }
    }

    /// Checks what an accessor is made of; answers with how errors name it.
    fn typed(
        &self,
        accessor: &Accessor<'_>,
        what: &str,
        dimensions: Dimensions,
        is_known: bool,
        known: &str,
    ) -> Result<String, LoadError> {
        let object = format!("accessor {} ({what})", accessor.index());
        if accessor.dimensions() == dimensions && is_known {
            return Ok(object);
        }
        let note = if accessor.normalized() { " normalized" } else { "" };
        let found = format!("{:?} of {:?}{note}", accessor.dimensions(), accessor.data_type());
        Err(self.invalid(&object, &found, &format!("{dimensions:?} of {known}")))
    }

    fn read<T: Item>(&self, object: &str, accessor: Accessor<'_>) -> Result<Vec<T>, LoadError> {
        let (count, size) = (accessor.count() as u64, std::mem::size_of::<T>());
        if count == 0 {
            return Err(self.invalid(object, "count 0", "at least 1"));
        }
        let limit = if accessor.view().is_some() { MAX_ELEMENTS } else { MAX_ZEROS };
        if count > limit {
            return Err(LoadError::too_many(FilePlace::file(&self.path), object, count, limit));
        }
        if let Some(view) = accessor.view() {
            self.check(object, &view, accessor.offset(), count, size)?;
        }
        match accessor.sparse() {
            Some(sparse) => {
                let replaced = sparse.count() as u64;
                if replaced == 0 || replaced > count {
                    let found = format!("sparse count {replaced}");
                    return Err(self.invalid(object, &found, &format!("1 to {count}")));
                }
                let indices = sparse.indices();
                let index_size = indices.index_type().size();
                self.check(object, &indices.view(), indices.offset(), replaced, index_size)?;
                let values = sparse.values();
                self.check(object, &values.view(), values.offset(), replaced, size)?;
            }
            None if accessor.view().is_none() => {
                return Ok(std::iter::repeat_with(T::zero).take(accessor.count()).collect());
            }
            None => {}
        }
        let elements =
            Iter::<T>::new(accessor, |buffer| self.data.get(buffer.index()).map(Vec::as_slice));
        let elements: Vec<T> = match elements {
            Some(elements) => elements.collect(),
            None => return Err(self.invalid(object, "unreadable data", "bytes inside its buffer")),
        };
        if elements.len() as u64 != count {
            return Err(self.invalid(object, &format!("{} elements", elements.len()), "its count"));
        }
        Ok(elements)
    }

    /// Checks that `count` elements of `size` bytes lie inside the view, and the view inside its
    /// buffer.
    fn check(
        &self,
        object: &str,
        view: &View<'_>,
        offset: usize,
        count: u64,
        size: usize,
    ) -> Result<(), LoadError> {
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            let found = format!("a stride of {stride} bytes");
            return Err(self.invalid(object, &found, &format!("at least {size}")));
        }
        let needed = (stride as u64)
            .checked_mul(count.saturating_sub(1))
            .and_then(|bytes| bytes.checked_add(size as u64))
            .and_then(|bytes| bytes.checked_add(offset as u64))
            .unwrap_or(u64::MAX);
        self.fits(&format!("{object} in bufferView {}", view.index()), needed, view.length())?;
        let end = (view.offset() as u64).saturating_add(view.length() as u64);
        let buffer = view.buffer().index();
        let available = self.data.get(buffer).map_or(0, Vec::len);
        self.fits(&format!("bufferView {} in buffer {buffer}", view.index()), end, available)
    }

    fn fits(&self, object: &str, needed: u64, available: usize) -> Result<(), LoadError> {
        let available = available as u64;
        if needed <= available {
            return Ok(());
        }
        let place = FilePlace::file(&self.path);
        Err(LoadError::PastBuffer { place, object: object.to_string(), needed, available })
    }

    /// The error for what breaks a rule of the format.
    pub fn invalid(&self, object: &str, found: &str, expected: &str) -> LoadError {
        LoadError::gltf(&self.path, object, found, expected)
    }
}

/// Undoes `%20` and the like; `None` when the result is not UTF-8.
fn percent_decode(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        rest = after;
        let code = after.first_chunk::<2>().and_then(|hex| {
            let hex = std::str::from_utf8(hex).ok()?;
            u8::from_str_radix(hex, 16).ok().filter(|_| !hex.starts_with('+'))
        });
        match (byte, code) {
            (b'%', Some(code)) => {
                bytes.push(code);
                rest = after.get(2..).unwrap_or_default();
            }
            _ => bytes.push(byte),
        }
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_codes() {
        assert_eq!(percent_decode("a%20b.bin").as_deref(), Some("a b.bin"));
        assert_eq!(percent_decode("100%"), Some("100%".into()));
        assert_eq!(percent_decode("%2e%2E/x").as_deref(), Some("../x"));
        assert_eq!(percent_decode("%FF"), None);
    }
}
