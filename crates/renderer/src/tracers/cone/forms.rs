//! The surfaces of a scene, made ready for cones: how much of a cone each covers, and at which
//! depth a ray of the cone meets it. One file per kind of surface.

use accel_core::primitives::newell_normal;
use glam::{DVec2, DVec3};
use scene_loading::{Scene, Shape};

use super::circular_cone::Cone;
use super::cover_flat::FlatCoverage;
use super::cover_side::Side;
use super::cover_sphere::Ball;
use super::coverage::Coverage;

/// A primitive, by what cones ask of it.
enum Form {
    Ball(Ball),
    Side(Box<Side>),
    Flat(FlatCoverage),
}

/// All primitives of a scene.
pub struct Forms {
    forms: Vec<Form>,
    corners: Vec<DVec3>,
    /// Transmissive primitives, which let light pass.
    clear: Vec<bool>,
}

impl Forms {
    pub fn new(scene: &Scene) -> Self {
        let mut corners = Vec::new();
        let form = |(primitive, id): (&scene_loading::Primitive, u32)| match primitive.shape {
            Shape::Sphere(i) => Form::Ball(Ball::new(id, &scene.spheres[i as usize])),
            Shape::Cone(i) => Form::Side(Box::new(Side::new(id, &scene.cones[i as usize]))),
            Shape::Polygon { .. } | Shape::Triangle { .. } | Shape::Patch { .. } => {
                let outline = scene.outline(primitive.shape);
                let (normal, first) = (newell_normal(&outline), corners.len());
                corners.extend_from_slice(&outline);
                Form::Flat(FlatCoverage { normal, first, count: outline.len() })
            }
        };
        let forms = scene.primitives.iter().zip(0..).map(form).collect();
        let is_clear = |p: &scene_loading::Primitive| {
            scene.materials.get(p.material as usize).is_some_and(|m| m.transmittance > 0.0)
        };
        Self { forms, corners, clear: scene.primitives.iter().map(is_clear).collect() }
    }

    /// Returns whether the primitive lets light pass.
    pub fn is_clear(&self, id: u32) -> bool {
        self.clear[id as usize]
    }

    pub fn is_flat(&self, id: u32) -> bool {
        matches!(self.forms[id as usize], Form::Flat(_))
    }

    /// Returns whether the primitive is a sphere.
    pub fn is_ball(&self, id: u32) -> bool {
        matches!(self.forms[id as usize], Form::Ball(_))
    }

    /// Share of the cone covered by a primitive; `None` for nothing.
    pub fn cover(&self, cone: &Cone, id: u32) -> Option<Coverage> {
        match &self.forms[id as usize] {
            Form::Ball(ball) => ball.cover(cone),
            Form::Side(side) => side.cover(cone),
            Form::Flat(_) if cone.left_surface(id).is_some() => None,
            Form::Flat(flat) => flat.cover(cone, self.outline(flat)),
        }
    }

    /// The depth at which the ray through a place meets a primitive; of a flat one, its plane.
    pub fn depth(&self, cone: &Cone, id: u32, place: DVec2) -> Option<f64> {
        match &self.forms[id as usize] {
            Form::Ball(ball) => ball.depth(cone, place),
            Form::Side(side) => side.depth(cone, place),
            Form::Flat(flat) => flat.depth(cone, *self.outline(flat).first()?, place),
        }
    }

    /// About how deep the primitive lies, for places that just miss it.
    pub fn middle(&self, cone: &Cone, id: u32) -> f64 {
        let center = match &self.forms[id as usize] {
            Form::Ball(ball) => ball.sphere.center,
            Form::Side(side) => side.middle(),
            Form::Flat(flat) => self.outline(flat).iter().sum::<DVec3>() / flat.count.max(1) as f64,
        };
        cone.locate(center).0.clamp(cone.begin, cone.end)
    }

    fn outline(&self, flat: &FlatCoverage) -> &[DVec3] {
        &self.corners[flat.first..][..flat.count]
    }
}
