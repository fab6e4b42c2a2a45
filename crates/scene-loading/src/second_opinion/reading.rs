//! Properties by which readers of a file are compared.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use crate::error::quote;
use crate::scene::{Bounds, Scene, Shape};

/// Bounds may differ by this share of the size of their coordinates: readers that work in single
/// precision round.
const TOLERANCE: f64 = 1e-6;

/// The most materials that a comparison names.
const MAX_NAMED: usize = 5;

/// Properties that a reader found in a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Reading {
    pub bounds: Bounds,
    /// Triangles that have an area by the name of their material. A polygon of `k` corners is `k -
    /// 2`.
    pub triangles: BTreeMap<String, u64>,
}

impl Reading {
    pub fn new() -> Self {
        Self { bounds: Bounds::EMPTY, triangles: BTreeMap::new() }
    }

    /// Properties found by our reader.
    pub fn of(scene: &Scene) -> Self {
        let mut triangles = vec![0; scene.materials.len()];
        for primitive in &scene.primitives {
            if let Some(count) = triangles.get_mut(primitive.material as usize) {
                *count += match primitive.shape {
                    Shape::Polygon { count, .. } => u64::from(count).saturating_sub(2),
                    _ => 1,
                };
            }
        }
        let mut reading = Self { bounds: scene.bounds(), ..Self::new() };
        for (material, count) in scene.materials.iter().zip(triangles) {
            reading.add(&material.name, count);
        }
        reading
    }

    /// Adds triangles of a material.
    pub fn add(&mut self, material: &str, triangles: u64) {
        if triangles > 0 {
            *self.triangles.entry(material.to_owned()).or_default() += triangles;
        }
    }

    pub fn total(&self) -> u64 {
        self.triangles.values().sum()
    }

    /// Counts what has a material that is not among the known ones as without one.
    pub fn know_only(&mut self, known: &BTreeSet<String>) {
        let all = std::mem::take(&mut self.triangles);
        for (name, count) in all {
            self.add(if known.contains(&name) { &name } else { "" }, count);
        }
    }

    /// Differences to the reading of another reader, of this name.
    pub fn differences(&self, other: &Self, reader: &str) -> Vec<String> {
        let mut found = Vec::new();
        let (here, there) = (self.total(), other.total());
        if here != there {
            found.push(format!("{here} triangles here, {there} by {reader}"));
        }
        let slack = TOLERANCE * self.bounds.reach();
        let near = |a: DVec3, b: DVec3| a == b || (a - b).abs().max_element() <= slack;
        let (a, b) = (&self.bounds, &other.bounds);
        if !(near(a.min, b.min) && near(a.max, b.max)) {
            let there = format!("{} to {} by {reader}", b.min, b.max);
            found.push(format!("bounds {} to {} here, {there}", a.min, a.max));
        }
        let names: BTreeSet<&String> =
            self.triangles.keys().chain(other.triangles.keys()).collect();
        let of = |reading: &Self, name: &str| reading.triangles.get(name).copied().unwrap_or(0);
        let differ: Vec<&String> =
            names.into_iter().filter(|name| of(self, name) != of(other, name)).collect();
        for name in differ.iter().take(MAX_NAMED) {
            let (here, there) = (of(self, name), of(other, name));
            let named = || format!("material {}", quote(name));
            let what = if name.is_empty() { "no material".to_owned() } else { named() };
            found.push(format!("{what}: {here} triangles here, {there} by {reader}"));
        }
        if differ.len() > MAX_NAMED {
            found.push(format!("{} more materials differ so", differ.len() - MAX_NAMED));
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_difference_is_reported() {
        let mut ours = Reading::new();
        ours.add("a", 3);
        ours.add("b", 2);
        ours.bounds.include(DVec3::ZERO);
        ours.bounds.include(DVec3::ONE);
        assert_eq!(ours.differences(&ours.clone(), "x"), Vec::<String>::new());
        let mut theirs = ours.clone();
        theirs.bounds.include(DVec3::splat(1.0 + 1e-9));
        assert!(ours.differences(&theirs, "x").is_empty(), "rounding is no difference");
        theirs.add("b", 1);
        theirs.bounds.include(DVec3::splat(1.1));
        let said = ours.differences(&theirs, "x");
        assert_eq!(said.len(), 3, "{said:?}");
        assert_eq!(said[0], "5 triangles here, 6 by x");
        assert!(said[1].starts_with("bounds [0, 0, 0] to [1, 1, 1] here"), "{said:?}");
        assert_eq!(said[2], "material `b`: 2 triangles here, 3 by x");
        theirs.know_only(&["a".to_owned()].into());
        let said = ours.differences(&theirs, "x");
        assert!(said.contains(&"no material: 0 triangles here, 3 by x".into()), "{said:?}");
        for i in 0..9 {
            theirs.add(&format!("m{i}"), 1);
        }
        assert!(ours.differences(&theirs, "x").last().unwrap().contains("more materials"));
    }
}
