//! Numbers of beams of an image.

use std::ops::AddAssign;

use super::visibility::CutLists;

#[derive(Debug, Clone, Copy, Default)]
pub struct Counts {
    /// Beams from the eye: tiles.
    pub beams: u64,
    /// Beams sent on by mirrors.
    pub mirrored: u64,
    /// Beams sent on by glass.
    pub refracted: u64,
    pub shadows: u64,
    /// Pieces that see one face, or nothing.
    pub fragments: u64,
    /// Parts of beams that are reflected totally.
    pub internal: u64,
    /// Beams that would have no volume.
    pub degenerate: u64,
    /// Cost of finding them.
    pub cuts: CutLists,
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.beams += other.beams;
        self.mirrored += other.mirrored;
        self.refracted += other.refracted;
        self.shadows += other.shadows;
        self.fragments += other.fragments;
        self.internal += other.internal;
        self.degenerate += other.degenerate;
        self.cuts += other.cuts;
    }
}

impl Counts {
    /// With the words for each.
    pub fn named(&self) -> Vec<(&'static str, u64)> {
        vec![
            ("eye beams", self.beams),
            ("mirrored beams", self.mirrored),
            ("refracted beams", self.refracted),
            ("shadow beams", self.shadows),
            ("fragments", self.fragments),
            ("pieces cut", self.cuts.pieces),
            ("pieces decided at their centre", self.cuts.unresolved),
            ("beams reflected totally", self.internal),
            ("beams without a volume", self.degenerate),
        ]
    }
}
