//! Paths that are not UTF-8, as names.
//!
//! Names of scenes are text: they stand in tables and in records. A path need not be. Each byte
//! that is no UTF-8 becomes a character of the last private-use plane, and back again, so that
//! every path has a name that leads to it.

use std::ffi::OsStr;
use std::path::PathBuf;

/// The character of byte 0; only bytes from 0x80 on are ever written so.
const BASE: u32 = 0x10_fe00;

/// The name of a path as typed.
pub fn name_of_path(path: &OsStr) -> String {
    let mut name = String::new();
    for chunk in path.as_encoded_bytes().utf8_chunks() {
        for c in chunk.valid().chars() {
            match byte_of(c) {
                // The character itself, bytewise, or it would be taken for a byte.
                Some(_) => escape(c.encode_utf8(&mut [0; 4]).as_bytes(), &mut name),
                None => name.push(c),
            }
        }
        escape(chunk.invalid(), &mut name);
    }
    name
}

/// The path of a name.
#[cfg(unix)]
pub fn path_of_name(name: &str) -> PathBuf {
    use std::os::unix::ffi::OsStringExt;
    let mut bytes = Vec::with_capacity(name.len());
    for c in name.chars() {
        match byte_of(c) {
            Some(byte) => bytes.push(byte),
            None => bytes.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes()),
        }
    }
    PathBuf::from(std::ffi::OsString::from_vec(bytes))
}

/// The path of a name; where paths are no bytes, only those that are text have one.
#[cfg(not(unix))]
pub fn path_of_name(name: &str) -> PathBuf {
    PathBuf::from(name)
}

fn escape(bytes: &[u8], name: &mut String) {
    name.extend(bytes.iter().filter_map(|&byte| char::from_u32(BASE + u32::from(byte))));
}

fn byte_of(c: char) -> Option<u8> {
    u32::from(c).checked_sub(BASE).and_then(|byte| u8::try_from(byte).ok())
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::ffi::OsStrExt;

    use super::*;

    #[test]
    fn every_path_has_a_name_that_leads_to_it() {
        for bytes in [&b"a b.obj"[..], b"caf\xe9.obj", "café.obj".as_bytes(), b"\xff\xfe/\x80"] {
            let name = name_of_path(OsStr::from_bytes(bytes));
            assert_eq!(path_of_name(&name).as_os_str().as_bytes(), bytes);
        }
        let odd: String = [char::from_u32(BASE + 0xe9).unwrap(), 'x'].iter().collect();
        assert_eq!(path_of_name(&name_of_path(OsStr::new(&odd))), PathBuf::from(odd));
        assert_eq!(name_of_path(OsStr::new("balls:5")), "balls:5");
    }
}
