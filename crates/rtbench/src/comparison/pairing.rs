//! Pairs the scenes and rows of two records, and lists those that only one has.

use serde::Serialize;

use measurement::record::{RowRecord, RunRecord, SceneRecord};

/// A row of both records, the older first.
#[derive(Debug, Clone, Copy)]
pub struct RowPair<'r> {
    pub scenes: [&'r SceneRecord; 2],
    pub rows: [&'r RowRecord; 2],
}

/// A scene of both records, the older first.
#[derive(Debug, Clone)]
pub struct ScenePair<'r> {
    pub scenes: [&'r SceneRecord; 2],
    /// Rows of both, in the order of the newer.
    pub rows: Vec<RowPair<'r>>,
    /// Rows of the older alone, and of the newer alone.
    pub only: [Vec<&'r RowRecord>; 2],
}

#[derive(Debug, Clone)]
pub struct Pairing<'r> {
    /// Scenes of both, in the order of the older.
    pub scenes: Vec<ScenePair<'r>>,
    /// Scenes of the older alone, and of the newer alone.
    pub only: [Vec<&'r SceneRecord>; 2],
}

/// A row that one of two records lacks.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct MissingRow {
    pub scene: String,
    pub row: String,
    /// Only the newer record has it: it was added, not removed.
    pub is_new: bool,
}

/// Rows that one side lacks, a line for each side and row with the scenes.
pub fn in_words(missing: &[MissingRow]) -> Vec<String> {
    let line = |((is_new, row), scenes): ((bool, &str), Vec<&str>)| {
        let what = if is_new { "new, nothing to compare with" } else { "missing now" };
        format!("{what}: {row} ({})", scenes.join(", "))
    };
    let by_row = missing.iter().map(|m| ((m.is_new, &*m.row), &*m.scene));
    grouped(by_row).into_iter().map(line).collect()
}

/// Values by their keys, in the order in which these come first.
pub fn grouped<K: PartialEq, V>(pairs: impl IntoIterator<Item = (K, V)>) -> Vec<(K, Vec<V>)> {
    let mut groups: Vec<(K, Vec<V>)> = Vec::new();
    for (key, value) in pairs {
        match groups.iter_mut().find(|(known, _)| *known == key) {
            Some((_, values)) => values.push(value),
            None => groups.push((key, vec![value])),
        }
    }
    groups
}

impl<'r> Pairing<'r> {
    /// Pairs an older and a newer record: scenes by name, rows by structure and settings.
    pub fn of(old: &'r RunRecord, new: &'r RunRecord) -> Self {
        let lacks = |run: &RunRecord, scene: &SceneRecord| {
            run.scenes.iter().all(|other| other.name != scene.name)
        };
        let both = old.scenes.iter().filter_map(|scene| {
            let other = new.scenes.iter().find(|other| other.name == scene.name)?;
            Some(ScenePair::of([scene, other]))
        });
        Self {
            scenes: both.collect(),
            only: [
                old.scenes.iter().filter(|scene| lacks(new, scene)).collect(),
                new.scenes.iter().filter(|scene| lacks(old, scene)).collect(),
            ],
        }
    }

    /// All rows of both records.
    pub fn rows(&self) -> impl Iterator<Item = &RowPair<'r>> {
        self.scenes.iter().flat_map(|scene| &scene.rows)
    }

    /// All rows that one side lacks, those of scenes that it lacks included.
    pub fn missing(&self) -> Vec<MissingRow> {
        let missing = |scene: &SceneRecord, row: &RowRecord, is_new| MissingRow {
            scene: scene.name.clone(),
            row: row.label(),
            is_new,
        };
        let mut all = Vec::new();
        for (side, is_new) in [(0, false), (1, true)] {
            for pair in &self.scenes {
                let own = pair.only[side].iter();
                all.extend(own.map(|row| missing(pair.scenes[side], row, is_new)));
            }
            for scene in &self.only[side] {
                all.extend(scene.rows.iter().map(|row| missing(scene, row, is_new)));
            }
        }
        all
    }
}

impl<'r> ScenePair<'r> {
    /// The rows of a scene in two records.
    pub fn of(scenes: [&'r SceneRecord; 2]) -> Self {
        let [old, new] = scenes;
        let pair = |row| Some(RowPair { scenes, rows: [row_like(old, row)?, row] });
        let rows = new.rows.iter().filter_map(pair);
        let only = |scene: &'r SceneRecord, other: &SceneRecord| -> Vec<&'r RowRecord> {
            scene.rows.iter().filter(|row| row_like(other, row).is_none()).collect()
        };
        Self { scenes, rows: rows.collect(), only: [only(old, new), only(new, old)] }
    }
}

/// The row of a scene that is the same as a row of another record.
pub fn row_like<'r>(scene: &'r SceneRecord, row: &RowRecord) -> Option<&'r RowRecord> {
    scene.rows.iter().find(|other| other.is_same(row))
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::record::made_up::run;

    #[test]
    fn rows_and_scenes_of_one_side_are_named() {
        let times: &[f64] = &[1.0];
        let old = run(&[
            ("tetra", &[("bvh", times), ("grid", times), ("hug a=1", times)]),
            ("balls", &[("bvh", times)]),
        ]);
        let new = run(&[
            ("rings", &[("bvh", times)]),
            ("tetra", &[("hug a=2", times), ("grid", times), ("bvh", times)]),
        ]);
        let pairing = Pairing::of(&old, &new);
        let both: Vec<String> = pairing.rows().map(|pair| pair.rows[1].label()).collect();
        assert_eq!(both, ["grid", "bvh"]);
        assert!(pairing.rows().all(|pair| pair.rows[0].is_same(pair.rows[1])));
        let missing = pairing.missing().into_iter();
        let missing = missing.map(|m| format!("{}: {} {}", m.scene, m.row, m.is_new));
        let expected =
            "tetra: hug a=1 false, balls: bvh false, tetra: hug a=2 true, rings: bvh true";
        assert_eq!(missing.collect::<Vec<_>>().join(", "), expected);
    }
}
