//! Kinds of cases that public reports of bugs in ray tracers are about.

use super::{
    copies, crowds, far_intervals, frames, glass, lights, moving, normals, polygons, slender_cones,
    threads,
};
use crate::verify::registry::Group;

pub static GROUP: Group = Group {
    name: "reported",
    cases: &[
        polygons::Q1,
        polygons::Q2,
        polygons::Q2_SLIVERS,
        slender_cones::Q3,
        slender_cones::Q3_FLAT,
        far_intervals::Q4,
        polygons::Q6,
        moving::Q7,
        moving::Q7_SEGMENTS,
        copies::Q8,
        glass::Q9,
        lights::Q10,
        lights::Q10_OCCLUDERS,
        frames::Q11,
        crowds::Q12_POINTS,
        crowds::Q12_EQUAL,
        crowds::Q12_FAN,
        crowds::Q12_DENORMAL,
        threads::K3,
        normals::S8,
    ],
};
