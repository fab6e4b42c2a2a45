//! Copies of an object within a set: the same primitives several times, each time moved as a whole.
//!
//! The set holds all copies, so that every structure and every oracle sees the same primitives;
//! what is said here is which of them are copies of which. Structures of two levels divide an
//! object once.

use glam::{DAffine3, DMat3};

/// Consecutive primitives that are an object at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// Object number, shared by all copies of the object.
    pub object: u32,
    /// The id of its first primitive.
    pub first: u32,
    pub count: u32,
    /// From the object's own space to the world.
    pub placement: DAffine3,
}

/// A copy that was found to be one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ConfirmedCopy {
    /// The id of its first primitive.
    pub first: u32,
    /// From this copy to the first copy of its object; none for that itself.
    pub to_first: Option<DAffine3>,
}

/// An object and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Object {
    /// Primitives of each copy.
    pub count: u32,
    /// The copies, two at least; the first one is at its own place.
    pub copies: Vec<ConfirmedCopy>,
}

/// Objects that stand in a set several times.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Instances {
    pub(super) objects: Vec<Object>,
    /// All that is said to move as a whole, whether it stands several times or not; ascending,
    /// disjoint.
    pub(super) parts: Vec<Instance>,
}

impl Instances {
    /// Number of objects with several copies.
    pub fn objects(&self) -> usize {
        self.objects.len()
    }

    /// Total number of copies.
    pub fn copies(&self) -> usize {
        self.objects.iter().map(|object| object.copies.len()).sum()
    }

    /// Primitives that are copies of others.
    pub fn copied_primitives(&self) -> u64 {
        let more = |object: &Object| (object.copies.len() as u64 - 1) * u64::from(object.count);
        self.objects.iter().map(more).sum()
    }

    pub(crate) fn all(&self) -> &[Object] {
        &self.objects
    }

    pub(crate) fn parts(&self) -> &[Instance] {
        &self.parts
    }

    /// The part that a primitive belongs to.
    pub(crate) fn part_of(&self, id: u32) -> Option<&Instance> {
        let behind = self.parts.partition_point(|part| part.first <= id);
        let part = self.parts.get(behind.checked_sub(1)?)?;
        (id - part.first < part.count).then_some(part)
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.parts.as_slice())
            + self.copies() * size_of::<ConfirmedCopy>()
            + size_of_val(self.objects.as_slice())
    }
}

/// The largest sum of absolute entries of a row: how much longer a vector becomes, at most, in the
/// largest of its components.
pub(crate) fn stretch(matrix: &DMat3) -> f64 {
    let rows = matrix.transpose().to_cols_array_2d();
    rows.iter().map(|row| row.iter().map(|x| x.abs()).sum()).fold(0.0, f64::max)
}
