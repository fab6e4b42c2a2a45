//! The axes of accuracy, and the list of them.

mod box_test;
mod cell_insertion;
mod compared_answers;
mod images;
mod primitive_tests;
mod ray_offset;
mod refracted_shift;
mod right_answers;
mod secondary_rays;
mod shadow_terminator;
mod smallest_offset;
mod time_segments;
mod triangle_aims;
pub mod voxel_traversal;

use crate::accuracy::axis::Axis;
use measurement::plan::error::{PlanError, chosen};

/// Every axis: one line each.
pub static AXES: &[&Axis] = &[
    &primitive_tests::TRIANGLES,
    &box_test::AXIS,
    &cell_insertion::AXIS,
    &voxel_traversal::AXIS,
    &primitive_tests::SPHERES,
    &ray_offset::AXIS,
    &compared_answers::MAILBOX,
    &compared_answers::LIGHT_BUFFER,
    &compared_answers::PRECISION,
    &images::CONE_AND_BEAM,
    &images::SOFT_SHADOWS,
    &images::GLOSS,
    &images::MOTION,
    &images::FOCUS,
    &time_segments::AXIS,
    &images::GATING,
    &right_answers::AXIS,
];

/// The axes of these names, each once; all when there are none.
pub fn select(names: &[String]) -> Result<Vec<&'static Axis>, PlanError> {
    chosen("axis", names, AXES, |axis| axis.name)
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
