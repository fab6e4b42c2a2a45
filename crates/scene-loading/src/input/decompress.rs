//! Undoing gzip and zstd, with a budget that follows from the size of the packed file.

use std::io::Read;
use std::path::Path;

use crate::error::{FilePlace, LoadError};
use crate::input::read::extension;
use crate::limits::MAX_BYTES;

/// Unpacked size allowed for any packed file: 64 MiB; less for fuzzers, which would spend their
/// time on unpacking.
const FREE: u64 = if cfg!(fuzzing) { 64 << 10 } else { 64 << 20 };

/// Unpacked bytes allowed per packed byte beyond that. Text scenes shrink by up to about 20 times.
const MAX_RATIO: u64 = if cfg!(fuzzing) { 2 } else { 200 };

/// Undoes the compression that the file's ending names (`.gz`, `.zst`), or returns the bytes as
/// they are.
///
/// # Errors
/// [`LoadError::Decompress`] on a damaged stream, [`LoadError::Inflated`] when it unpacks to more
/// than 64 MiB and 200 times its size, [`LoadError::TooLarge`] above [`MAX_BYTES`].
pub(crate) fn decompress(path: &Path, bytes: Vec<u8>) -> Result<Vec<u8>, LoadError> {
    let packed = bytes.len() as u64;
    let budget = (FREE + MAX_RATIO * packed).min(MAX_BYTES);
    let unpacked = match extension(path).as_str() {
        "gz" => gunzip(path, &bytes, budget)?,
        "zst" => unzstd(path, &bytes, budget)?,
        _ => return Ok(bytes),
    };
    match unpacked.len() as u64 {
        length if length <= budget => Ok(unpacked),
        _ if budget == MAX_BYTES => Err(LoadError::too_large(path, budget)),
        _ => Err(LoadError::Inflated { place: FilePlace::file(path), packed, limit: budget }),
    }
}

/// Unpacks until there is more than `budget`.
fn gunzip(path: &Path, bytes: &[u8], budget: u64) -> Result<Vec<u8>, LoadError> {
    let mut out = Vec::new();
    flate2::read::MultiGzDecoder::new(bytes)
        .take(budget + 1)
        .read_to_end(&mut out)
        .map_err(|e| damaged(path, "gzip", &e))?;
    Ok(out)
}

/// As [`gunzip`]. A `.zst` file may hold several frames one after the other, and skippable ones
/// between them.
fn unzstd(path: &Path, bytes: &[u8], budget: u64) -> Result<Vec<u8>, LoadError> {
    use ruzstd::decoding::StreamingDecoder;
    use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};

    let mut rest = bytes;
    let mut out = Vec::new();
    loop {
        match StreamingDecoder::new(&mut rest) {
            Ok(decoder) => {
                let room = (budget + 1).saturating_sub(out.len() as u64);
                decoder.take(room).read_to_end(&mut out).map_err(|e| damaged(path, "zstd", &e))?;
            }
            Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                length,
                ..
            })) => {
                let skip = usize::try_from(length).unwrap_or(usize::MAX);
                rest = rest.get(skip..).unwrap_or_default();
            }
            Err(e) => return Err(damaged(path, "zstd", &e)),
        }
        if rest.is_empty() || out.len() as u64 > budget {
            return Ok(out);
        }
    }
}

fn damaged(path: &Path, format: &'static str, error: &dyn std::fmt::Display) -> LoadError {
    LoadError::Decompress { place: FilePlace::file(path), format, message: error.to_string() }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn gz(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn gzip_is_undone() {
        let path = Path::new("x.nff.gz");
        assert_eq!(decompress(path, gz(b"hello")).unwrap(), b"hello");
        let error = decompress(path, b"not gzip".to_vec()).unwrap_err();
        assert!(matches!(error, LoadError::Decompress { format: "gzip", .. }), "{error}");
    }

    #[test]
    fn bombs_end_at_their_budget() {
        use ruzstd::encoding::{CompressionLevel, compress_to_vec};
        let zeros = vec![0; 96 << 20];
        let packed =
            [("gz", gz(&zeros)), ("zst", compress_to_vec(&zeros[..], CompressionLevel::Fastest))];
        for (ending, bytes) in packed {
            let path = Path::new("x.obj").with_extension(format!("obj.{ending}"));
            let found = decompress(&path, bytes.clone());
            let error = found.map(|unpacked| unpacked.len()).unwrap_err();
            assert!(matches!(error, LoadError::Inflated { .. }), "{error}");
            // ... of which no more than that was unpacked
            let budget = FREE + MAX_RATIO * bytes.len() as u64;
            let unpacked = match ending {
                "gz" => gunzip(&path, &bytes, budget),
                _ => unzstd(&path, &bytes, budget),
            };
            assert_eq!(unpacked.unwrap().len() as u64, budget + 1);
        }
    }

    #[test]
    fn zstd_frames_are_joined() {
        use ruzstd::encoding::{CompressionLevel, compress_to_vec};
        let path = Path::new("x.obj.zst");
        let mut bytes = compress_to_vec(&b"one "[..], CompressionLevel::Fastest);
        bytes.extend([0x50, 0x2a, 0x4d, 0x18, 3, 0, 0, 0, 9, 9, 9]); // a skippable frame
        bytes.extend(compress_to_vec(&b"two"[..], CompressionLevel::Fastest));
        assert_eq!(decompress(path, bytes.clone()).unwrap(), b"one two");
        assert_eq!(unzstd(path, &bytes, 5).unwrap(), b"one tw");
        bytes.truncate(bytes.len() - 3);
        assert!(matches!(decompress(path, bytes), Err(LoadError::Decompress { .. })));
    }
}
