//! Rays, triangles and hits as files, for programs that are no plugins.
//!
//! All numbers are little-endian. A file is a header of 128 bytes, of version 2 of 152, and
//! records, one after another:
//!
//! | offset | type | what |
//! | ---: | --- | --- |
//! | 0 | 8 bytes | `RTBRAYS` , `RTBTRIS` or `RTBHITS`, each with a line feed |
//! | 8 | u32 | version: 1, or 2 where the scene was moved near the origin |
//! | 12 | u32 | bytes of a record: 32, 40 or 8 |
//! | 16 | 5 x u64 | rays: primary, shadow, reflected, refracted, diffuse; in this order |
//! | 56 | u64 | triangles of the scene |
//! | 64 | u32 | width and height of the image, pixels |
//! | 68 | u32 | 1 where shadow rays run to the first light alone, else 0 |
//! | 72 | u64 | seed of the rays |
//! | 80 | 32 bytes | SHA-256 of the scene |
//! | 112 | 16 bytes | zero |
//! | 128 | 3 x f64 | version 2 alone: the origin of all coordinates, in those of the scene's file |
//!
//! | file | a record |
//! | --- | --- |
//! | rays | `rtbench_ray`: origin, t_min, direction, t_max; eight f32 |
//! | triangles | nine f32, the corners; u32, 1 where shadow rays pass, else 0 |
//! | hits | `rtbench_hit`: t as f32, id as u32: 0xffffffff for no hit; any other for a blocked ray |
//!
//! The header of a file of hits is that of its rays, but for the first 16 bytes; the version stays.
//!
//! A scene far from the origin of its coordinates is moved near it before it is rounded to f32, and
//! so are its rays: in f32, 5,400 km away, they would be half a metre off. A point of the file is
//! the origin plus what the record says, added in f64.

use std::path::PathBuf;

use bytemuck::{Pod, Zeroable};

use crate::abi;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Header {
    magic: [u8; 8],
    version: u32,
    record_bytes: u32,
    rays: [u64; 5],
    triangles: u64,
    size: u32,
    first_light: u32,
    seed: u64,
    scene: [u8; 32],
    zero: [u8; 16],
}

#[cfg(target_endian = "big")]
compile_error!("files of rays and hits are read and written as they are in memory: little-endian");

/// Bytes of a header of version 1.
const HEADER: usize = size_of::<Header>();
/// Bytes of the origin behind it.
const ORIGIN: usize = 24;
const VERSION: u32 = 1;
/// The version of headers with an origin.
const WITH_ORIGIN: u32 = 2;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    Rays,
    Triangles,
    Hits,
}

impl Content {
    fn magic(self) -> &'static [u8; 8] {
        match self {
            Self::Rays => b"RTBRAYS\n",
            Self::Triangles => b"RTBTRIS\n",
            Self::Hits => b"RTBHITS\n",
        }
    }

    pub fn record_bytes(self) -> usize {
        match self {
            Self::Rays => 32,
            Self::Triangles => 40,
            Self::Hits => 8,
        }
    }
}

/// The rays that a file refers to.
#[derive(Debug, Clone, PartialEq)]
pub struct FileSubject {
    /// Rays of each kind: primary, shadow, reflected, refracted, diffuse.
    pub rays: [u64; 5],
    pub triangles: u64,
    /// Width and height of the image, pixels.
    pub size: u32,
    /// Shadow rays run to the first light alone.
    pub first_light: bool,
    pub seed: u64,
    /// SHA-256 of the scene.
    pub scene: [u8; 32],
    /// The origin of all coordinates, in those of the scene's file.
    pub origin: [f64; 3],
}

/// Why a file of hits cannot be used. Offsets are bytes from the start of the file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}: byte {offset}: {what}", file.display())]
pub struct FileError {
    pub file: PathBuf,
    pub offset: usize,
    /// Description of the fault.
    pub what: String,
}

impl FileSubject {
    pub fn header_bytes(&self) -> usize {
        HEADER + if self.has_origin() { ORIGIN } else { 0 }
    }

    fn has_origin(&self) -> bool {
        self.origin != [0.0; 3]
    }

    pub fn header(&self, content: Content) -> Vec<u8> {
        let header = Header {
            magic: *content.magic(),
            version: if self.has_origin() { WITH_ORIGIN } else { VERSION },
            record_bytes: content.record_bytes() as u32,
            rays: self.rays,
            triangles: self.triangles,
            size: self.size,
            first_light: self.first_light.into(),
            seed: self.seed,
            scene: self.scene,
            zero: [0; 16],
        };
        let origin = if self.has_origin() { bytemuck::bytes_of(&self.origin) } else { &[] };
        [bytemuck::bytes_of(&header), origin].concat()
    }

    /// Reads the header of a file that holds `content`, and checks that its records are there.
    ///
    /// # Errors
    /// [`FileError`] naming the first byte that is wrong.
    pub fn read(file: &std::path::Path, bytes: &[u8], content: Content) -> Result<Self, FileError> {
        let wrong = |offset, what: String| FileError { file: file.into(), offset, what };
        let header: Header = behind(bytes, 0).unwrap_or_else(Header::zeroed);
        let is_moved = behind(bytes, 8) == Some(WITH_ORIGIN);
        let needs = if is_moved { HEADER + ORIGIN } else { HEADER };
        if bytes.len() < needs {
            let has = bytes.len();
            return Err(wrong(has, format!("the file ends within its header of {needs} bytes")));
        }
        if header.magic != *content.magic() {
            let name = String::from_utf8_lossy(content.magic());
            return Err(wrong(0, format!("expected {:?}", name)));
        }
        if ![VERSION, WITH_ORIGIN].contains(&header.version) {
            let expected = format!("expected {VERSION} or {WITH_ORIGIN}");
            return Err(wrong(8, format!("version {}, {expected}", header.version)));
        }
        let size = content.record_bytes();
        if header.record_bytes as usize != size {
            let has = header.record_bytes;
            return Err(wrong(12, format!("records of {has} bytes, expected {size}")));
        }
        if header.size == 0 || header.first_light > 1 {
            return Err(wrong(64, "invalid image size or choice of lights".into()));
        }
        let origin: [f64; 3] = behind(bytes, HEADER).filter(|_| is_moved).unwrap_or_default();
        if is_moved && origin == [0.0; 3] || !origin.iter().all(|x| x.is_finite()) {
            return Err(wrong(HEADER, format!("no origin: {origin:?}")));
        }
        let Header { rays, triangles, size: pixels, first_light, seed, scene, .. } = header;
        let first_light = first_light == 1;
        let about = Self { rays, triangles, size: pixels, first_light, seed, scene, origin };
        let records = match content {
            Content::Triangles => u128::from(about.triangles),
            Content::Rays | Content::Hits => about.rays.iter().map(|&n| u128::from(n)).sum(),
        };
        let expected = records * size as u128 + about.header_bytes() as u128;
        if bytes.len() as u128 != expected {
            let offset = bytes.len().min(usize::try_from(expected).unwrap_or(usize::MAX));
            let has = bytes.len();
            return Err(wrong(
                offset,
                format!("the file has {has} bytes, its header states {expected}"),
            ));
        }
        Ok(about)
    }
}

/// The item that lies at an offset; none where the bytes end before.
fn behind<T: Pod>(bytes: &[u8], offset: usize) -> Option<T> {
    bytes.get(offset..)?.get(..size_of::<T>()).map(bytemuck::pod_read_unaligned)
}

pub fn ray_record(ray: &abi::Ray) -> [u8; 32] {
    bytemuck::cast(*ray)
}

pub fn triangle_record(corners: &[[f32; 3]; 3], lets_light_pass: bool) -> [u8; 40] {
    let mut record = [0; 40];
    record[..36].copy_from_slice(bytemuck::bytes_of(corners));
    record[36] = lets_light_pass.into();
    record
}

pub fn hit_record(hit: &abi::Hit) -> [u8; 8] {
    bytemuck::cast(*hit)
}

/// The rays behind the header of a file, which [`FileSubject::read`] has read.
pub fn rays<'a>(about: &FileSubject, bytes: &'a [u8]) -> impl Iterator<Item = abi::Ray> + use<'a> {
    records(about, bytes)
}

/// The hits behind the header of a file, which [`FileSubject::read`] has read.
pub fn hits<'a>(about: &FileSubject, bytes: &'a [u8]) -> impl Iterator<Item = abi::Hit> + use<'a> {
    records(about, bytes)
}

fn records<'a, T: Pod>(
    about: &FileSubject,
    bytes: &'a [u8],
) -> impl Iterator<Item = T> + use<'a, T> {
    let records = bytes.get(about.header_bytes()..).unwrap_or_default();
    records.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn read_hits(bytes: &[u8]) -> Result<FileSubject, FileError> {
        FileSubject::read(Path::new("f"), bytes, Content::Hits)
    }

    fn about() -> FileSubject {
        FileSubject {
            rays: [2, 0, 0, 0, 1],
            triangles: 7,
            size: 9,
            first_light: true,
            seed: 5,
            scene: [3; 32],
            origin: [0.0; 3],
        }
    }

    #[test]
    fn headers_are_read_as_written() {
        let mut bytes = about().header(Content::Hits);
        assert_eq!(bytes.len(), HEADER);
        bytes.extend([0, 0, 128, 63, 4, 0, 0, 0].repeat(3));
        assert_eq!(read_hits(&bytes), Ok(about()));
        let all: Vec<_> = hits(&about(), &bytes).collect();
        assert_eq!(all, [abi::Hit::new(1.0, 4); 3]);
        let ray = abi::Ray { origin: [1.0; 3], t_min: 0.0, direction: [2.0; 3], t_max: 3.0 };
        assert_eq!(ray_record(&ray)[28..], 3.0f32.to_le_bytes());
        let file = [about().header(Content::Rays), ray_record(&ray).to_vec()].concat();
        assert_eq!(rays(&about(), &file).collect::<Vec<_>>(), [ray]);
        assert_eq!(hit_record(&abi::Hit::new(1.0, 4)), [0, 0, 128, 63, 4, 0, 0, 0]);
        assert_eq!(triangle_record(&[[1.0; 3]; 3], true)[36..], [1, 0, 0, 0]);
    }

    #[test]
    fn headers_of_rebased_scenes_have_the_origin() {
        let about = FileSubject { origin: [448_000.0, 0.0, -1e-3], ..about() };
        let mut bytes = about.header(Content::Hits);
        assert_eq!((bytes.len(), bytes[8]), (152, 2));
        bytes.extend([0, 0, 128, 63, 4, 0, 0, 0].repeat(3));
        assert_eq!(read_hits(&bytes).as_ref(), Ok(&about));
        assert_eq!(hits(&about, &bytes).count(), 3);
        // planted: a number that is none, no origin, a header that ends within it
        let mut bad = bytes.clone();
        bad[128..136].copy_from_slice(&f64::NAN.to_le_bytes());
        assert_eq!(read_hits(&bad).unwrap_err().offset, 128);
        bad[128..152].fill(0);
        assert_eq!(read_hits(&bad).unwrap_err().offset, 128);
        assert_eq!(read_hits(&bytes[..140]).unwrap_err().offset, 140);
    }

    #[test]
    fn faults_are_named_with_their_offset() {
        let mut good = about().header(Content::Hits);
        good.resize(HEADER + 24, 0);
        let planted: [(usize, u8, usize); 6] =
            [(0, b'X', 0), (8, 3, 8), (12, 32, 12), (64, 0, 64), (68, 7, 64), (16, 9, HEADER + 24)];
        for (at, byte, offset) in planted {
            let mut bad = good.clone();
            bad[at] = byte;
            let error = read_hits(&bad).unwrap_err();
            assert_eq!(error.offset, offset, "{error}");
        }
        for length in [0, 100, HEADER, HEADER + 23] {
            let error = read_hits(&good[..length]).unwrap_err();
            assert_eq!(error.offset, length, "{error}");
        }
        // so many rays that their bytes are no number
        let mut bad = good.clone();
        bad[16..56].fill(255);
        assert!(read_hits(&bad).is_err());
        assert!(FileSubject::read(Path::new("f"), &good, Content::Rays).is_err());
    }
}
