//! Scenes that come in sizes: generated ones, as they are or as a scene file describes them.

use crate::error::LoadError;
use crate::procedural::{SpdEntry, generators, size_of};
use crate::scene_file::{SceneFile, Source};
use crate::source::catalogue::SceneCatalogue;
use crate::source::scene_ref::DescribedScene;

/// The most primitives of a size: what the tessellator accepts.
const MOST: u64 = 64 << 20;

/// The sizes of a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneSizes {
    name: String,
    /// Primitives at the size factors 1, 2, 3...: ascending, never empty.
    primitives: Vec<u64>,
}

impl SceneSizes {
    fn new(name: &str, largest: u32, primitives: impl Fn(u32) -> u64) -> Self {
        let first = primitives(1);
        let more = (2..=largest).map(primitives).take_while(|&n| n <= MOST);
        Self { name: name.to_owned(), primitives: std::iter::once(first).chain(more).collect() }
    }

    /// The scene's name, without a size.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Primitives of the smallest and of the largest size.
    pub fn ends(&self) -> [u64; 2] {
        let [first, .., last] = self.primitives.as_slice() else {
            return [self.primitives.first().copied().unwrap_or(0); 2];
        };
        [*first, *last]
    }

    /// The size whose number of primitives is nearest to `wanted` by ratio, the smaller one of two
    /// that are as near: its name, as `balls:5`, and its primitives.
    pub fn nearest(&self, wanted: u64) -> (String, u64) {
        let off = |n: u64| (n.max(1) as f64 / wanted.max(1) as f64).ln().abs();
        let sizes = self.primitives.iter().copied().enumerate();
        let nearest = sizes.min_by(|a, b| off(a.1).total_cmp(&off(b.1)));
        let (i, primitives) = nearest.unwrap_or((0, 0));
        (format!("{}:{}", self.name, i + 1), primitives)
    }
}

impl SceneCatalogue {
    /// The sizes of a scene, by its name without a size.
    ///
    /// # Errors
    /// [`LoadError::NoSizes`] with those that have some, [`LoadError::UnknownScene`].
    pub fn sizes(&self, name: &str) -> Result<SceneSizes, LoadError> {
        let file = self.scenes.get(name).map(|described| &described.file);
        let generated = || generators().find(|family| family.name == name);
        let Some(family) = file.map_or_else(generated, family_of) else {
            self.resolve(&[name.to_owned()])?;
            return Err(self.no_sizes(name));
        };
        let resolution = file.and_then(|file| file.tessellate).map(|options| options.resolution);
        Ok(SceneSizes::new(name, family.max_size, |size| {
            let counts = (family.count)(size);
            resolution.map_or(counts.primitives(), |n| counts.tessellated(n))
        }))
    }

    /// A described scene at another size, where the name says one: `balls-tess:5`.
    pub(super) fn of_size(&self, name: &str) -> Result<Option<DescribedScene>, LoadError> {
        let Some((head, size)) = name.split_once(':') else { return Ok(None) };
        let Some(described) = self.scenes.get(head) else { return Ok(None) };
        let Some(family) = family_of(&described.file) else {
            // else it may be a path
            let is_size = size.bytes().all(|b| b.is_ascii_digit());
            return if is_size { Err(self.no_sizes(head)) } else { Ok(None) };
        };
        size_of(family.name, Some(size), family.default_size, family.max_size)
            .map_err(|error| LoadError::procedural(name, error))?;
        let mut described = described.clone();
        described.file.source = Source::Spd(format!("{}:{size}", family.name));
        Ok(Some(described))
    }

    /// The error that names what has sizes.
    fn no_sizes(&self, name: &str) -> LoadError {
        let described = self.scenes.iter().filter(|(_, d)| family_of(&d.file).is_some());
        let described = described.map(|(name, _)| name.as_str());
        let valid: Vec<&str> = generators().map(|family| family.name).chain(described).collect();
        LoadError::NoSizes { name: name.to_owned(), valid: valid.join(", ") }
    }
}

/// The generator behind a scene file, if it is one.
fn family_of(file: &SceneFile) -> Option<&'static SpdEntry> {
    let Source::Spd(spec) = &file.source else { return None };
    let name = spec.split(':').next()?;
    generators().find(|family| family.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sizes(name: &str) -> Result<SceneSizes, String> {
        SceneCatalogue::embedded().unwrap().sizes(name).map_err(|e| e.to_string())
    }

    #[test]
    fn the_nearest_size_by_ratio_is_found() {
        let balls = sizes("balls").unwrap();
        assert_eq!(balls.nearest(1), ("balls:1".into(), 11));
        assert_eq!(balls.nearest(1000), ("balls:3".into(), 821));
        assert_eq!(balls.nearest(u64::MAX), ("balls:7".into(), 5_380_841));
        assert_eq!(balls.ends(), [11, 5_380_841]);
        let tess = sizes("balls-tess").unwrap();
        assert_eq!(tess.nearest(1_000_000), ("balls-tess:4".into(), 1_417_154));
        assert_eq!(tess.nearest(10_000_000), ("balls-tess:5".into(), 12_754_562));
        assert_eq!(sizes("tree-tess").unwrap().nearest(917_282).1, 917_282);
    }

    #[test]
    fn a_described_scene_has_the_primitives_of_the_size_in_its_name() {
        let catalogue = SceneCatalogue::embedded().unwrap();
        let scene = catalogue.resolve(&["balls-tess:2".to_owned()]).unwrap().remove(0);
        let loaded = scene.load().unwrap().scene;
        assert_eq!([loaded.name.as_str(), scene.name.as_str()], ["balls-tess:2"; 2]);
        let expected = sizes("balls-tess").unwrap().nearest(17_000).1;
        assert_eq!(loaded.primitives.len() as u64, expected);
        for bad in ["balls-tess:0", "balls-tess:x", "balls-tess:8"] {
            let error = catalogue.resolve(&[bad.to_owned()]).unwrap_err().to_string();
            assert!(error.contains("from 1 to 7"), "{error}");
        }
    }

    #[test]
    fn scenes_without_sizes_are_errors_that_name_those_with() {
        for name in ["kitchen", "spd", "balls:5", "pavilion"] {
            let error = sizes(name).unwrap_err();
            let is_named = error.contains("`balls:5`") || error.contains("does not come in sizes");
            assert!(is_named, "{error}");
            assert!(error.contains("hare") && error.contains("tree-tess"), "{error}");
        }
        let catalogue = SceneCatalogue::embedded().unwrap();
        let error = catalogue.resolve(&["kitchen:5".to_owned()]).unwrap_err().to_string();
        assert!(error.contains("`kitchen` does not come in sizes"), "{error}");
        assert!(sizes("bals").unwrap_err().contains("did you mean `balls`"), "unknown names too");
    }
}
