//! `gears-turning`: the gears of the SPD ([`crate::procedural`]), each turning about its axis, the
//! other way round than those that it meshes with: by a tooth in four frames.

use std::f64::consts::TAU;

use glam::{DAffine3, DMat3};

use crate::animation::generated::mesh::Mesh;
use crate::animation::generated::stage::{Frames, Stage};
use crate::procedural::gears::{self, TEETH};
use crate::procedural::parts::ground;
use crate::tessellate::triangulate;

/// Frames in which a gear turns by one tooth.
const FRAMES_PER_TOOTH: f64 = 4.0;

/// The floor, and for each gear two faces of 144 vertices and 144 squares between them.
pub(super) fn count(size: u32) -> u64 {
    2 + u64::from(size).pow(3) * (2 * 142 + 2 * 144)
}

pub(super) fn frames(size: u32) -> Frames {
    let mut stage = Stage::new(gears::empty());
    let floor = stage.scene.push_material(gears::floor());
    stage.part_of(Mesh::quadrangle(ground(2.0, 0.0)), floor);
    let gear = stage.mesh(gear(size));
    let gears: Vec<gears::Gear> = gears::gears(size).collect();
    for gear_of in &gears {
        let material = stage.scene.push_material(gear_of.material.clone());
        stage.part(gear, material);
    }
    Box::new(move |frame| {
        let turned = TAU / TEETH as f64 * f64::from(frame) / FRAMES_PER_TOOTH;
        let places = gears.iter().map(|gear| {
            let sense = if gear.is_turned { -1.0 } else { 1.0 };
            let turn = gears::turn(gear.is_turned) + sense * turned;
            DAffine3::from_mat3_translation(DMat3::from_rotation_z(turn), gear.center)
        });
        stage.placed(std::iter::once(DAffine3::IDENTITY).chain(places))
    })
}

/// A gear in triangles.
fn gear(size: u32) -> Mesh {
    let scene = gears::one(size);
    let mut mesh = Mesh::default();
    for primitive in &scene.primitives {
        let outline = scene.outline(primitive.shape);
        let first = mesh.vertices.len() as u32;
        // the outlines are simple polygons: a test counts what they are cut into
        let triangles = triangulate(&outline).unwrap_or_default();
        mesh.vertices.extend(outline);
        mesh.triangles.extend(triangles.iter().map(|t| t.map(|i| first + i)));
    }
    mesh
}
