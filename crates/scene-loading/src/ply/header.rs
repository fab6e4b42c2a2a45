//! The header of a PLY file: which elements follow, how many of each, and what each consists of.

use std::path::Path;

use memchr::memchr2;

use crate::error::{FilePlace, LoadError, shortened};
use crate::limits;

/// The most elements of a header, and properties of all of them.
const MAX_DECLARED: usize = 4096;

/// The most bytes of a line of the header.
const MAX_LINE: usize = 1 << 12;

const KEYWORDS: &str = "one of format, element, property, comment, obj_info, end_header";

/// How the data after the header is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Makes [`Scalar`] of its variants: each with the type that has its numbers, and its names.
macro_rules! scalars {
    ($($variant:ident($type:ty): $($name:literal)|+,)*) => {
        /// A scalar type, by either of its names.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(super) enum Scalar {
            $($variant),*
        }

        impl Scalar {
            fn named(name: &str) -> Option<Self> {
                match name {
                    $($($name)|+ => Some(Self::$variant),)*
                    _ => None,
                }
            }

            /// Bytes in a binary file.
            pub fn size(self) -> usize {
                match self {
                    $(Self::$variant => size_of::<$type>(),)*
                }
            }

            /// The number that bytes of a binary file begin with, if there are enough.
            pub fn read(self, bytes: &[u8], is_little: bool) -> Option<f64> {
                match self {
                    $(Self::$variant => {
                        let bytes = *bytes.first_chunk()?;
                        let little = <$type>::from_le_bytes(bytes);
                        let value = if is_little { little } else { <$type>::from_be_bytes(bytes) };
                        Some(value as f64)
                    })*
                }
            }
        }
    };
}

scalars! {
    I8(i8): "char" | "int8",
    U8(u8): "uchar" | "uint8",
    I16(i16): "short" | "int16",
    U16(u16): "ushort" | "uint16",
    I32(i32): "int" | "int32",
    U32(u32): "uint" | "uint32",
    // numpy's default; not in the format
    I64(i64): "int64",
    U64(u64): "uint64",
    F32(f32): "float" | "float32",
    F64(f64): "double" | "float64",
}

impl Scalar {
    const NAMES: &str = "one of char, uchar, short, ushort, int, uint, float, double (or int8, uint8, \
                         int16, uint16, int32, uint32, int64, uint64, float32, float64)";

    pub fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// Type of a property of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    One(Scalar),
    /// A number of items, then the items.
    List {
        count: Scalar,
        item: Scalar,
    },
}

#[derive(Debug, Clone)]
pub(super) struct Property {
    pub name: String,
    pub kind: Kind,
}

#[derive(Debug, Clone)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
    /// The line that declares it.
    pub line: usize,
}

impl Element {
    /// Bytes that each takes in the file at least.
    pub fn least_bytes(&self, encoding: Encoding) -> u64 {
        let of = |property: &Property| match (encoding, property.kind) {
            // a digit and what ends it
            (Encoding::Ascii, _) => 2,
            (_, Kind::One(scalar) | Kind::List { count: scalar, .. }) => scalar.size() as u64,
        };
        self.properties.iter().map(of).sum()
    }
}

#[derive(Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Start of the data: byte, and line counted from 1.
    pub data: usize,
    pub line: usize,
}

/// Reads the header. Its words may be in any case.
pub(super) fn parse_header(path: &Path, bytes: &[u8]) -> Result<Header, LoadError> {
    let mut lines = Lines { path, bytes, at: 0, line: 0, has_pairs: false };
    let first = lines.next("ply")?;
    if !first.trim_ascii_end().eq_ignore_ascii_case("ply") {
        return Err(LoadError::syntax(lines.place(), &first, "ply"));
    }
    let (mut encoding, mut elements) = (None, Vec::<Element>::new());
    let mut declared = 0;
    loop {
        let text = lines.next("end_header")?;
        let line = lines.line;
        let place = || FilePlace::line(path, line);
        let lower = text.to_ascii_lowercase();
        let words: Vec<&str> = lower.split_ascii_whitespace().collect();
        let bad = |expected: &str| LoadError::syntax(place(), &text, expected);
        declared += 1;
        limits::check(declared, MAX_DECLARED, "the number of lines of the header", place)?;
        match words.as_slice() {
            [] | ["comment" | "obj_info", ..] => {}
            ["end_header"] => break,
            ["format", name, "1.0"] => {
                encoding = Some(match *name {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::LittleEndian,
                    "binary_big_endian" => Encoding::BigEndian,
                    _ => return Err(bad("ascii, binary_little_endian or binary_big_endian")),
                });
            }
            ["format", ..] => return Err(bad("format, its name and version 1.0")),
            ["element", name, count] => {
                let count = count.parse().map_err(|_| bad("element, a name and a number"))?;
                let name = (*name).to_owned();
                elements.push(Element { name, count, properties: Vec::new(), line });
            }
            ["element", ..] => return Err(bad("element, a name and a number")),
            ["property", rest @ ..] => {
                let scalar = |name: &str| Scalar::named(name).ok_or_else(|| bad(Scalar::NAMES));
                let (kind, name) = match rest {
                    ["list", count, item, name] => {
                        (Kind::List { count: scalar(count)?, item: scalar(item)? }, name)
                    }
                    [one, name] if *one != "list" => (Kind::One(scalar(one)?), name),
                    _ => return Err(bad("property TYPE NAME, or property list TYPE TYPE NAME")),
                };
                if let Kind::List { count, .. } = kind
                    && !count.is_integer()
                {
                    return Err(bad("a whole-number type for the length of a list"));
                }
                let element = elements.last_mut().ok_or_else(|| bad("element before property"))?;
                let name = (*name).to_owned();
                element.properties.push(Property { name, kind });
            }
            _ => return Err(bad(KEYWORDS)),
        }
    }
    let Some(encoding) = encoding else {
        return Err(LoadError::syntax(lines.place(), "end_header", "a format line before it"));
    };
    Ok(Header { encoding, elements, data: lines.at, line: lines.line + 1 })
}

/// The lines of a header: they end in LF, CR LF or CR, all alike, as binary data may begin with LF.
struct Lines<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
    line: usize,
    /// The first line ended in CR LF.
    has_pairs: bool,
}

impl Lines<'_> {
    fn place(&self) -> FilePlace {
        FilePlace::line(self.path, self.line.max(1))
    }

    /// The next line, without its end.
    fn next(&mut self, expected: &str) -> Result<String, LoadError> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let near = rest.get(..MAX_LINE.min(rest.len())).unwrap_or_default();
        self.line += 1;
        let Some(length) = memchr2(b'\n', b'\r', near) else {
            if rest.len() > MAX_LINE {
                let found = shortened(&String::from_utf8_lossy(near));
                return Err(LoadError::syntax(self.place(), &found, "the line of a PLY header"));
            }
            return Err(LoadError::unexpected_end(self.place(), expected));
        };
        let is_pair = rest.get(length..length + 2) == Some(b"\r\n");
        let is_pair = is_pair && (self.has_pairs || self.line == 1);
        self.has_pairs = is_pair;
        self.at += length + if is_pair { 2 } else { 1 };
        Ok(String::from_utf8_lossy(near.get(..length).unwrap_or_default()).into_owned())
    }
}
