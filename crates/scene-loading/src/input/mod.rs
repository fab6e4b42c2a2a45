//! Bytes and images from files, with limits.

pub(crate) mod decompress;
pub(crate) mod images;
pub(crate) mod read;
pub(crate) mod text;
