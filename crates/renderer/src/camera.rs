//! Eye rays.

use glam::{DVec2, DVec3};
use scene_loading::Camera;

/// How image samples are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampling {
    /// One ray through the centre of each pixel.
    PixelCentres,
    /// Rays through pixel corners, edges of the frustum included: an n x n setting sends
    /// (n + 1) x (n + 1) rays (Havran and Sixta 1999).
    PixelCorners,
}

/// Makes eye rays of a camera for an image of a given size.
#[derive(Debug, Clone, Copy)]
pub struct EyeRays {
    from: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    size: [u32; 2],
    sampling: Sampling,
}

impl EyeRays {
    /// `resolution` in pixels. The field of view spans the shorter image side.
    pub fn new(camera: &Camera, resolution: [u32; 2], sampling: Sampling) -> Self {
        let forward = (camera.at - camera.from).normalize_or(DVec3::NEG_Z);
        let side = forward.cross(camera.up);
        // an up vector along the view says nothing: take any perpendicular one
        let right = side.try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        let up = right.cross(forward);
        let half = (camera.angle.to_radians() * 0.5).tan();
        let [w, h] = resolution.map(f64::from);
        let (half_w, half_h) = if w >= h { (half * w / h, half) } else { (half, half * h / w) };
        Self {
            from: camera.from,
            forward,
            right: right * half_w,
            up: up * half_h,
            size: resolution,
            sampling,
        }
    }

    /// Rays per image row, and number of rows.
    pub fn grid(&self) -> [u32; 2] {
        match self.sampling {
            Sampling::PixelCentres => self.size,
            Sampling::PixelCorners => self.size.map(|n| n + 1),
        }
    }

    /// The unit direction through column `x` and row `y`; row 0 is the top.
    pub fn direction(&self, x: u32, y: u32) -> DVec3 {
        let shift = match self.sampling {
            Sampling::PixelCentres => 0.5,
            Sampling::PixelCorners => 0.0,
        };
        self.direction_within(x, y, DVec2::splat(shift))
    }

    /// The unit direction through a point of a pixel: (0, 0) is its upper left corner, (1, 1) its
    /// lower right one.
    pub fn direction_within(&self, x: u32, y: u32, within: DVec2) -> DVec3 {
        let u = 2.0 * (f64::from(x) + within.x) / f64::from(self.size[0]) - 1.0;
        let v = 1.0 - 2.0 * (f64::from(y) + within.y) / f64::from(self.size[1]);
        (self.forward + self.right * u + self.up * v).normalize()
    }

    /// The vectors U, V and D, so that D + x U + y V is along the ray through the point (x, y) of
    /// the image, pixels from its upper left corner; the part along the view has length 1.
    pub fn frame(&self) -> [DVec3; 3] {
        let [width, height] = self.size.map(f64::from);
        let (right, down) = (self.right * (2.0 / width), self.up * (-2.0 / height));
        [right, down, self.forward - self.right + self.up]
    }

    pub fn origin(&self) -> DVec3 {
        self.from
    }
}
