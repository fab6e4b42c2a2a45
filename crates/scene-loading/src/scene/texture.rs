//! Images that colour surfaces.
//!
//! Texels are the stored values of the image, 8 bits a channel, without alpha. Colours of a scene
//! are not linear-managed (NFF's and MTL's are numbers that the image shows as they are), so
//! texels are taken as such colours too: nothing is decoded from sRGB.

use std::sync::Arc;

/// An image, rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Texture {
    /// File name, or what the source calls it.
    pub name: String,
    /// Width and height in texels, each at least 1.
    pub size: [u32; 2],
    /// Wrap modes, horizontal and vertical.
    pub wrap: [Wrap; 2],
    /// Red, green and blue of each texel; shared by textures of the same image.
    pub texels: Arc<[[u8; 3]]>,
}

/// Wrap mode of a texture beyond its edges.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    #[default]
    Repeat,
    /// The image again, every other one mirrored.
    Mirror,
    /// The texels of the edge.
    Clamp,
}

impl Wrap {
    /// The texel within `0..size` that is seen at `index` texels from the edge; `size` is at
    /// least 1.
    pub fn texel(self, index: i64, size: u32) -> u32 {
        let size = i64::from(size.max(1));
        let within = match self {
            Self::Repeat => index.rem_euclid(size),
            Self::Clamp => index.clamp(0, size - 1),
            Self::Mirror => {
                let there_and_back = index.rem_euclid(2 * size);
                there_and_back.min(2 * size - 1 - there_and_back)
            }
        };
        within as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_beyond_the_edges() {
        let row = |wrap: Wrap| (-4..8).map(|i| wrap.texel(i, 3)).collect::<Vec<u32>>();
        assert_eq!(row(Wrap::Repeat), [2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1]);
        assert_eq!(row(Wrap::Mirror), [2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0, 1]);
        assert_eq!(row(Wrap::Clamp), [0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2, 2]);
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for index in [i64::MIN, i64::MAX] {
                assert!(wrap.texel(index, 3) < 3 && wrap.texel(index, 1) == 0);
            }
        }
    }
}
