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

use crate::abi;

/// Bytes of a header of version 1.
pub const HEADER: usize = 128;
/// Bytes of the origin behind it.
const ORIGIN: usize = 24;
const VERSION: u32 = 1;
/// The version of headers with an origin.
const WITH_ORIGIN: u32 = 2;

/// Kind of content of a file.
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

    /// Bytes of a record.
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
    /// Triangles of the scene.
    pub triangles: u64,
    /// Width and height of the image, pixels.
    pub size: u32,
    /// Shadow rays run to the first light alone.
    pub first_light: bool,
    /// Seed of the rays.
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
    /// Bytes of its header.
    pub fn header_bytes(&self) -> usize {
        HEADER + if self.has_origin() { ORIGIN } else { 0 }
    }

    fn has_origin(&self) -> bool {
        self.origin != [0.0; 3]
    }

    /// The header of a file.
    pub fn header(&self, content: Content) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(HEADER);
        bytes.extend_from_slice(content.magic());
        let version = if self.has_origin() { WITH_ORIGIN } else { VERSION };
        bytes.extend(version.to_le_bytes());
        bytes.extend((content.record_bytes() as u32).to_le_bytes());
        bytes.extend(self.rays.iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend(self.triangles.to_le_bytes());
        bytes.extend(self.size.to_le_bytes());
        bytes.extend(u32::from(self.first_light).to_le_bytes());
        bytes.extend(self.seed.to_le_bytes());
        bytes.extend(self.scene);
        bytes.resize(HEADER, 0);
        if self.has_origin() {
            bytes.extend(self.origin.iter().flat_map(|x| x.to_le_bytes()));
        }
        bytes
    }

    /// Reads the header of a file that holds `content`, and checks that its records are there.
    ///
    /// # Errors
    /// [`FileError`] naming the first byte that is wrong.
    pub fn read(file: &std::path::Path, bytes: &[u8], content: Content) -> Result<Self, FileError> {
        let wrong = |offset, what: String| FileError { file: file.into(), offset, what };
        let part = |offset: usize| bytes.get(offset..).and_then(|rest| rest.first_chunk::<8>());
        let long =
            |offset| part(offset).map(|bytes| u64::from_le_bytes(*bytes)).unwrap_or_default();
        let short = |offset: usize| {
            let part = bytes.get(offset..).and_then(|rest| rest.first_chunk::<4>());
            part.map(|bytes| u32::from_le_bytes(*bytes)).unwrap_or_default()
        };
        let needs = if short(8) == WITH_ORIGIN { HEADER + ORIGIN } else { HEADER };
        if bytes.len() < needs {
            let has = bytes.len();
            return Err(wrong(has, format!("the file ends within its header of {needs} bytes")));
        }
        let name = String::from_utf8_lossy(content.magic());
        if bytes.first_chunk() != Some(content.magic()) {
            return Err(wrong(0, format!("expected {:?}", name)));
        }
        if ![VERSION, WITH_ORIGIN].contains(&short(8)) {
            let expected = format!("expected {VERSION} or {WITH_ORIGIN}");
            return Err(wrong(8, format!("version {}, {expected}", short(8))));
        }
        let size = content.record_bytes();
        if short(12) as usize != size {
            return Err(wrong(12, format!("records of {} bytes, expected {size}", short(12))));
        }
        if short(64) == 0 || short(68) > 1 {
            return Err(wrong(64, "invalid image size or choice of lights".into()));
        }
        let origin = match short(8) {
            WITH_ORIGIN => [0, 1, 2].map(|k| f64::from_bits(long(HEADER + 8 * k))),
            _ => [0.0; 3],
        };
        if short(8) == WITH_ORIGIN && origin == [0.0; 3] || !origin.iter().all(|x| x.is_finite()) {
            return Err(wrong(HEADER, format!("no origin: {origin:?}")));
        }
        let about = Self {
            rays: std::array::from_fn(|kind| long(16 + 8 * kind)),
            triangles: long(56),
            size: short(64),
            first_light: short(68) == 1,
            seed: long(72),
            scene: bytes.get(80..).and_then(|rest| rest.first_chunk()).copied().unwrap_or_default(),
            origin,
        };
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

/// A ray as a record.
pub fn ray_record(ray: &abi::Ray) -> [u8; 32] {
    let [x, y, z] = ray.origin;
    let [a, b, c] = ray.direction;
    record([x, y, z, ray.t_min, a, b, c, ray.t_max].map(f32::to_le_bytes))
}

/// A triangle as a record.
pub fn triangle_record(corners: &[[f32; 3]; 3], lets_light_pass: bool) -> [u8; 40] {
    let flag = u32::from(lets_light_pass).to_le_bytes();
    record(corners.as_flattened().iter().map(|x| x.to_le_bytes()).chain([flag]))
}

fn record<const N: usize>(numbers: impl IntoIterator<Item = [u8; 4]>) -> [u8; N] {
    let mut record = [0; N];
    for (to, bytes) in record.chunks_exact_mut(4).zip(numbers) {
        to.copy_from_slice(&bytes);
    }
    record
}

/// A hit as a record.
pub fn hit_record(hit: &abi::Hit) -> [u8; 8] {
    record([hit.t.to_le_bytes(), hit.id.to_le_bytes()])
}

/// The rays behind the header of a file, which [`FileSubject::read`] has read.
pub fn rays<'a>(about: &FileSubject, bytes: &'a [u8]) -> impl Iterator<Item = abi::Ray> + use<'a> {
    let records = bytes.get(about.header_bytes()..).unwrap_or_default().as_chunks::<32>().0;
    records.iter().map(|record| {
        let mut numbers = record.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
        let [x, y, z, t_min, a, b, c, t_max] =
            std::array::from_fn(|_| numbers.next().unwrap_or_default());
        abi::Ray { origin: [x, y, z], t_min, direction: [a, b, c], t_max }
    })
}

/// The hits behind the header of a file, which [`FileSubject::read`] has read.
pub fn hits<'a>(about: &FileSubject, bytes: &'a [u8]) -> impl Iterator<Item = abi::Hit> + use<'a> {
    let records = bytes.get(about.header_bytes()..).unwrap_or_default().as_chunks::<8>().0;
    records.iter().map(|&[a, b, c, d, e, f, g, h]| {
        abi::Hit::new(f32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h]))
    })
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
