//! `gears-turning`: the gears of the SPD ([`crate::procedural`]), each turning about its axis, the
//! other way round than those that it meshes with: by a tooth in four frames.

use std::f64::consts::TAU;

use glam::{DAffine3, DMat3};

use crate::animation::generated::stage::{Frames, Mesh, Stage};
use crate::procedural::counts;
use crate::procedural::gears::{self, TEETH};
use crate::procedural::parts::ground;
use crate::tessellate::triangulate;

/// Frames in which a gear turns by one tooth.
const FRAMES_PER_TOOTH: f64 = 4.0;

/// As many as the gears of the SPD are cut into.
pub(super) fn count(size: u32) -> u64 {
    counts::gears(size).flat_triangles
}

pub(super) fn frames(size: u32) -> Frames {
    let mut stage = Stage::new(gears::empty());
    stage.part_at_rest(Mesh::quadrangle(ground(2.0, 0.0)), gears::floor());
    let gear = stage.mesh(gear(size));
    let gears: Vec<gears::Gear> = gears::gears(size).collect();
    for gear_of in &gears {
        let material = stage.scene.push_material(gear_of.material.clone());
        stage.part(gear, material);
    }
    Box::new(move |frame| {
        let turned = TAU / TEETH as f64 * f64::from(frame) / FRAMES_PER_TOOTH;
        stage.placed(gears.iter().map(|gear| {
            let sense = if gear.is_turned { -1.0 } else { 1.0 };
            let turn = gears::turn(gear.is_turned) + sense * turned;
            DAffine3::from_mat3_translation(DMat3::from_rotation_z(turn), gear.center)
        }))
    })
}

/// A gear in triangles.
fn gear(size: u32) -> Mesh {
    let scene = gears::one(size);
    scene.primitives.iter().fold(Mesh::default(), |mesh, primitive| {
        let vertices = scene.outline(primitive.shape);
        // the outlines are simple polygons: a test counts what they are cut into
        let triangles = triangulate(&vertices).unwrap_or_default();
        mesh.with(&Mesh { vertices, triangles, ..Mesh::default() })
    })
}
