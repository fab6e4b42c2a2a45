//! Input of a light buffer: bounding balls of the opaque primitives, and their view from a face.

use glam::DVec3;

use crate::geometry::scalar::Scalar;
use crate::occluders::light_buffer::direction_cube::in_frame;
use crate::primitives::{Ball, PrimSet, PrimitiveKind};

#[derive(Debug, Clone, Copy)]
pub(super) struct Body {
    pub(super) id: u32,
    /// The end of its balls.
    last: u32,
    pub(super) is_outline: bool,
}

/// The opaque primitives of a set as balls; what the cubes of all lights are filled from.
pub(super) struct Bodies {
    pub(super) bodies: Vec<Body>,
    balls: Vec<Ball>,
    /// All are triangles that share edges without a gap.
    are_tight: bool,
}

impl Bodies {
    /// Balls around all opaque primitives, grown by `margin`.
    pub(super) fn of<S: Scalar, P: PrimSet<S>>(prims: &P, margin: f64) -> Self {
        let are_tight = prims.is_watertight();
        let mut this =
            Self { bodies: Vec::with_capacity(prims.len()), balls: Vec::new(), are_tight };
        for id in (0..prims.len() as u32).filter(|&id| prims.is_opaque(id)) {
            prims.hull(id, &mut this.balls);
            let is_flat =
                matches!(prims.kind(id), PrimitiveKind::Triangle | PrimitiveKind::Polygon);
            let is_outline = is_flat && !prims.moves(id);
            this.bodies.push(Body { id, last: this.balls.len() as u32, is_outline });
        }
        for ball in &mut this.balls {
            ball.radius += margin;
        }
        this
    }

    pub(super) fn own(&self, body: usize) -> &[Ball] {
        let first = body.checked_sub(1).map_or(0, |before| self.bodies[before].last);
        &self.balls[first as usize..self.bodies[body].last as usize]
    }
}

/// All bodies, as seen in the frame of a face.
pub(super) struct FaceView<'a> {
    pub(super) bodies: &'a Bodies,
    pub(super) light: DVec3,
    pub(super) face: usize,
}

impl FaceView<'_> {
    pub(super) fn local(&self, ball: &Ball) -> Ball {
        Ball { center: in_frame(self.face, ball.center - self.light), ..*ball }
    }

    /// Returns whether bodies that share edges leave no gap there.
    pub(super) fn is_tight(&self) -> bool {
        self.bodies.are_tight
    }

    /// The corners of a triangle, in world space and in the frame of the face.
    pub(super) fn triangle(&self, body: u32) -> Option<([DVec3; 3], [Ball; 3])> {
        let balls: &[Ball; 3] = self.bodies.own(body as usize).try_into().ok()?;
        Some((balls.map(|b| b.center), balls.each_ref().map(|b| self.local(b))))
    }
}
