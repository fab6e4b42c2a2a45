//! The axes, one line each.

use crate::accuracy::axes;
use crate::accuracy::record::SceneOutcome;
use crate::accuracy::stage::{Prepared, Stage};
use crate::error::StudyError;
use measurement::plan::error::PlanError;
use measurement::settings::suggest;

/// One way to be more or less accurate.
#[derive(Debug)]
pub struct Axis {
    /// As typed: `voxel-traversal`.
    pub name: &'static str,
    /// What varies, one line.
    pub summary: &'static str,
    /// Where the variants come from.
    pub paper: &'static str,
    /// What an error is, with its unit.
    pub metric: &'static str,
    /// What says which answer is right.
    pub reference: &'static str,
    /// Scenes where none are named: two of SPD and a modelled one.
    pub scenes: &'static [&'static str],
    /// Which setting of the product varies.
    pub setting: &'static str,
    /// All variants on a scene, timed and judged.
    pub measure: Measure,
}

/// How an axis is measured on a scene.
#[derive(Debug, Clone, Copy)]
pub enum Measure {
    /// At once.
    Whole(fn(&Stage<'_>) -> Result<SceneOutcome, StudyError>),
    /// Subject by subject, each with variants, ratios and a front of its own: structures with
    /// settings, as `run -s` takes them.
    Each {
        /// All there are.
        subjects: &'static [&'static str],
        /// Whether one tells more of a scene than others do.
        serves: fn(&Prepared, &str) -> bool,
        /// The outcome of one.
        measure: fn(&Stage<'_>, &str) -> Result<SceneOutcome, StudyError>,
    },
}

impl Measure {
    /// The subjects for a scene; an empty name where there is no choice of them.
    pub fn subjects(self, prepared: &Prepared) -> Vec<&'static str> {
        match self {
            Self::Whole(_) => vec![""],
            Self::Each { subjects, serves, .. } => {
                subjects.iter().copied().filter(|subject| serves(prepared, subject)).collect()
            }
        }
    }

    /// The outcome of a subject.
    ///
    /// # Errors
    /// [`StudyError`] for a scene that does not serve.
    pub fn outcome(self, stage: &Stage<'_>, subject: &str) -> Result<SceneOutcome, StudyError> {
        match self {
            Self::Whole(measure) => measure(stage),
            Self::Each { measure, .. } => {
                Ok(SceneOutcome { subject: subject.replace(':', " "), ..measure(stage, subject)? })
            }
        }
    }
}

/// Every axis: one line each.
pub static AXES: &[&Axis] = &[
    &axes::triangle_test::AXIS,
    &axes::box_test::AXIS,
    &axes::cell_insertion::AXIS,
    &axes::voxel_traversal::AXIS,
    &axes::sphere_test::AXIS,
    &axes::ray_offset::AXIS,
    &axes::smallest_offset::AXIS,
    &axes::refracted_shift::AXIS,
    &axes::shadow_terminator::AXIS,
    &axes::mailbox::AXIS,
    &axes::light_buffer::AXIS,
    &axes::precision::AXIS,
    &axes::cone_and_beam::AXIS,
    &axes::effects::SOFT_SHADOWS,
    &axes::effects::GLOSS,
    &axes::effects::MOTION,
    &axes::effects::FOCUS,
    &axes::time_segments::AXIS,
    &axes::gating::AXIS,
    #[cfg(feature = "compiled-tests")]
    &axes::right_answers::AXIS,
];

/// The axes of these names, each once; all when there are none.
///
/// # Errors
/// [`PlanError::UnknownAxis`] naming what is valid.
pub fn select(names: &[String]) -> Result<Vec<&'static Axis>, PlanError> {
    if let Some(name) = names.iter().find(|name| AXES.iter().all(|axis| axis.name != *name)) {
        let valid: Vec<&str> = AXES.iter().map(|axis| axis.name).collect();
        return Err(PlanError::UnknownAxis {
            hint: suggest::hint(name, valid.iter().copied()),
            name: name.clone(),
            valid: valid.join(", "),
        });
    }
    let is_asked = |axis: &&&Axis| names.is_empty() || names.iter().any(|n| n == axis.name);
    Ok(AXES.iter().filter(is_asked).copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_and_others_refused() {
        let names = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
        assert_eq!(select(&[]).unwrap().len(), AXES.len());
        assert_eq!(select(&names(&["mailbox", "mailbox"])).unwrap().len(), 1);
        let error = select(&names(&["mailboxes"])).unwrap_err().to_string();
        assert!(error.contains("did you mean 'mailbox'?") && error.contains("focus"), "{error}");
    }

    #[test]
    fn every_axis_has_two_scenes_of_spd_and_a_modelled_one() {
        for axis in AXES {
            let of_spd = |s: &&&str| {
                let family = s.split([':', '-']).next().unwrap_or_default();
                scene_loading::procedural::SPD.iter().any(|f| f.name == family)
            };
            assert!(axis.scenes.iter().filter(of_spd).count() >= 2, "{}", axis.name);
            assert!(axis.scenes.contains(&"pavilion"), "{}", axis.name);
        }
    }
}
