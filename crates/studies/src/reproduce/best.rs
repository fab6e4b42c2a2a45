//! The table of the best setting of each structure. It repeats figures of the other tables (one
//! was left out there, one printed differently), so the setting is the one that it repeats.

use super::published::{Figure, table};
use super::setting::{Count, Setting};
use super::structures::STRUCTURES;

/// The name of the table.
pub(super) const TABLE: &str = "best";

/// The setting with the most figures in common, and how it is counted; all but one must be.
pub(super) fn repeated<'f>(all: &'f [Figure], best: &Setting<'f>) -> Option<(Count, Setting<'f>)> {
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
    use super::super::published::{SCENES, figures};
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
