//! The row that the ratios of a scene refer to.
//!
//! It is the reference of the run, or in a scene where that gave nothing to compare with another
//! row in its place. Ratios over different rows answer different questions: nothing joins them in
//! one mean, and nothing compares one with the other.

use crate::record::{RunRecord, SceneRecord};

/// The label of that row; none where the scene has no ratios.
pub fn of_scene(scene: &SceneRecord) -> Option<String> {
    let row = scene.rows.iter().find(|row| row.is_reference)?;
    row.verdict.is_timed().then(|| row.label())
}

/// The label of the row that means over scenes are over: the reference of the run, `planned`, if it
/// serves in any of them, else the row in its place in the first.
pub fn of_means(scenes: &[SceneRecord], planned: &str) -> String {
    let mut first = None;
    for label in scenes.iter().filter_map(of_scene) {
        if label == planned {
            return label;
        }
        first.get_or_insert(label);
    }
    first.unwrap_or_else(|| planned.to_owned())
}

/// Returns whether the ratios of a scene are over the row of that label.
pub fn is_over(scene: &SceneRecord, label: &str) -> bool {
    of_scene(scene).is_some_and(|own| own == label)
}

/// Number of scenes whose ratios refer to the row of this label.
pub fn scenes_over(scenes: &[SceneRecord], label: &str) -> usize {
    scenes.iter().filter(|scene| is_over(scene, label)).count()
}

/// The scenes whose ratios are not over the row of that label, each with the one they are over.
pub fn elsewhere<'r>(
    scenes: &'r [SceneRecord],
    label: &str,
) -> impl Iterator<Item = (&'r str, String)> {
    let other = move |scene: &'r SceneRecord| {
        let own = of_scene(scene).filter(|own| own != label)?;
        Some((scene.name.as_str(), own))
    };
    scenes.iter().filter_map(other)
}

/// Describes the reference of a run, and the scenes with another reference.
pub fn in_words(run: &RunRecord) -> String {
    let planned = &run.settings.reference;
    let others: Vec<String> = elsewhere(&run.scenes, planned).map(in_scene).collect();
    if others.is_empty() { planned.clone() } else { format!("{planned} ({})", others.join(", ")) }
}

/// A row and the scene in which ratios are over it.
pub fn in_scene((scene, row): (&str, String)) -> String {
    format!("{row} in {scene}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Verdict;
    use crate::record::made_up::{Rows, run};

    const ROWS: Rows<'_> = &[("obvhs-cwbvh", &[1.0]), ("octree", &[2.0])];
    const OTHERS: Rows<'_> = &[("octree", &[2.0])];

    #[test]
    fn substitute_references_are_named() {
        let mut mixed = run(&[("tetra", ROWS), ("balls", OTHERS)]);
        assert_eq!(of_scene(&mixed.scenes[0]).as_deref(), Some("obvhs-cwbvh"));
        assert!(is_over(&mixed.scenes[1], "octree") && !is_over(&mixed.scenes[0], "octree"));
        assert_eq!(scenes_over(&mixed.scenes, "octree"), 1);
        assert_eq!(in_words(&mixed), "obvhs-cwbvh (octree in balls)");
        assert_eq!(of_means(&mixed.scenes, "obvhs-cwbvh"), "obvhs-cwbvh");
        assert_eq!(of_means(&mixed.scenes[1..], "obvhs-cwbvh"), "octree");
        mixed.scenes.truncate(1);
        assert_eq!(in_words(&mixed), "obvhs-cwbvh");
        // without ratios there is no other row
        mixed.scenes[0].rows[0].verdict = Verdict::NotBuilt;
        assert_eq!((of_scene(&mixed.scenes[0]), in_words(&mixed)), (None, "obvhs-cwbvh".into()));
        assert_eq!(of_means(&mixed.scenes, "obvhs-cwbvh"), "obvhs-cwbvh");
    }
}
