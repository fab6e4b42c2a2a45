//! `rtbench reproduce havran1999`: the published figures beside ours.
//!
//! V. Havran, F. Sixta, "Comparison of Hierarchical Grids", Ray Tracing News 12(1), 1999. What
//! the counters mean was found by experiment; `results/published/README.md` has the rules.
//! Everything is computed in f64 on coordinates as SPD prints them. Nothing is tuned per scene.

use published::{Count, Figure, PaperCounters, Setting, table};
use rayon::prelude::*;
use verdict::{Verdict, judge};

pub mod lecture;
pub mod published;
mod settings;
pub mod verdict;

pub use published::{PublishedScene, ReproduceError};

/// The structures of both tables as the paper names them, one line each.
static STRUCTURES: &[(&str, Count)] = &[
    ("invariants", |scene, _| Ok(scene.invariants(&settings::count_uniform(scene, None)?))),
    ("uniform", settings::uniform),
    ("recursive", settings::recursive),
    ("hug", settings::hug),
    ("adaptive", settings::adaptive),
    ("adaptive-orphan", settings::adaptive),
    (settings::OCTREES[0], settings::octree),
    (settings::OCTREES[1], settings::octree),
    (settings::OCTREES[2], settings::octree),
    (settings::OCTREES[3], settings::octree),
    (settings::OCTREES[4], settings::octree),
];

/// One figure, published and ours.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ReproducedRow {
    pub scene: String,
    pub structure: String,
    pub params: String,
    pub counter: String,
    pub published: String,
    pub ours: f64,
    pub ratio: f64,
    #[serde(serialize_with = "as_text")]
    pub verdict: Verdict,
}

fn as_text<S: serde::Serializer>(v: &Verdict, s: S) -> Result<S::Ok, S::Error> {
    s.collect_str(v)
}

/// Names of what can be reproduced: the structures, and the table of their best settings.
pub fn structures() -> Vec<&'static str> {
    STRUCTURES.iter().map(|(name, _)| *name).chain([TABLE]).collect()
}

/// Reproduces the figures of one scene for the structures asked for, in the paper's order.
pub fn reproduce_scene(
    scene: &str,
    structures: &[&str],
    figures: &[Figure],
) -> Result<Vec<ReproducedRow>, ReproduceError> {
    let published = PublishedScene::new(scene)?;
    let mut tasks = Vec::new();
    for (structure, count) in STRUCTURES.iter().filter(|(name, _)| structures.contains(name)) {
        for (params, figures) in table(figures, structure, scene) {
            let setting = Setting { structure, params, scene, figures };
            tasks.push(Task { count: *count, of: setting, shown_as: None });
        }
    }
    if structures.contains(&TABLE) {
        for (params, of_best) in table(figures, TABLE, scene) {
            let best = Setting { structure: TABLE, params, scene, figures: of_best };
            let unknown = || ReproduceError::UnknownSetting(format!("best {params}"));
            let (count, of) = repeated(figures, &best).ok_or_else(unknown)?;
            tasks.push(Task { count, of, shown_as: Some(best) });
        }
    }
    let rows = tasks
        .par_iter()
        .map(|task| Ok(task.compare(&(task.count)(&published, &task.of)?)))
        .collect::<Result<Vec<_>, ReproduceError>>()?;
    Ok(rows.concat())
}

struct Task<'f> {
    count: Count,
    of: Setting<'f>,
    /// The setting of the table of the best that repeats it.
    shown_as: Option<Setting<'f>>,
}

impl Task<'_> {
    /// Puts our counters beside the published ones; what is repeated is judged as what it repeats.
    fn compare(&self, ours: &PaperCounters) -> Vec<ReproducedRow> {
        let shown = self.shown_as.as_ref().unwrap_or(&self.of);
        ours.iter()
            .filter_map(|&(counter, ours)| {
                let text = shown.figures.get(counter)?;
                let value: f64 = text.parse().unwrap_or(f64::NAN);
                let Setting { structure, params, scene, .. } = self.of;
                Some(ReproducedRow {
                    scene: scene.to_owned(),
                    structure: shown.structure.to_owned(),
                    params: shown.params.to_owned(),
                    counter: counter.to_owned(),
                    published: (*text).to_owned(),
                    ours,
                    ratio: if value == 0.0 && ours == 0.0 { 1.0 } else { ours / value },
                    verdict: judge(structure, params, scene, counter, text, ours),
                })
            })
            .collect()
    }
}

pub(super) const TABLE: &str = "best";

/// The setting with the most figures in common, and how it is counted; all but one must be.
fn repeated<'f>(all: &'f [Figure], best: &Setting<'f>) -> Option<(Count, Setting<'f>)> {
    let name = best.params.split_whitespace().next()?;
    let mut candidates = Vec::new();
    for (structure, count) in STRUCTURES.iter().filter(|s| s.0.starts_with(name)) {
        for (params, figures) in table(all, structure, best.scene) {
            let setting = Setting { structure, params, scene: best.scene, figures };
            let in_common = |(c, v): &(&&str, &&str)| setting.figures.get(**c) == Some(*v);
            let equal = best.figures.iter().filter(in_common).count();
            candidates.push((equal, *count, setting));
        }
    }
    let (equal, count, setting) = candidates.into_iter().max_by_key(|c| c.0)?;
    (equal + 1 >= best.figures.len()).then_some((count, setting))
}

#[cfg(test)]
mod tests {
    use super::published::{SCENES, figures};
    use super::*;

    #[test]
    fn every_best_setting_is_found_in_its_own_table() {
        let all = figures().unwrap();
        for scene in SCENES {
            for (params, figures) in table(&all, TABLE, scene) {
                let mut best = Setting { structure: TABLE, params, scene, figures };
                assert!(repeated(&all, &best).is_some(), "{scene} {params}");
                for counter in ["N_V", "N_IT"] {
                    best.figures.insert(counter, "1.5");
                }
                assert!(repeated(&all, &best).is_none(), "{scene} {params}: two differ");
            }
        }
    }
}
