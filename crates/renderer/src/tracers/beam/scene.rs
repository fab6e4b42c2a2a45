//! Settings of beam tracing, the scenes that it does not support (curved surfaces, area lights,
//! blurred reflections), a scene made ready for it, and the numbers of beams of an image.

use accel_core::primitives::newell_normal;
use glam::DVec3;
use scene_loading::{Primitive, Rgb, Scene, Shape};

use super::faces::{self, Faces};
use crate::camera::{EyeRays, Sampling};
use crate::effects::lights;
use crate::ray_offset::magnitude;
use crate::surface::Surfaces;
use crate::tracers::info::{Frame, Refusal, Structures, TracerInfo, counts};

pub static INFO: TracerInfo = TracerInfo {
    name: "beam",
    summary: "pyramids cut exactly by the polygons they meet: antialiasing without samples",
    paper: "Heckbert, Hanrahan 1984",
    assumptions: "flat polygons with simple outlines; shading is constant over a pixel's part of \
                  a face; refracted directions are off by up to a tenth of a pixel's angle",
    deviations: "beams stay in image coordinates; no beam tree and no depth order: cycles and \
                 intersections are cut; candidates come from a structure",
    refuses: "spheres, cones, lights with a radius, lenses, motion, textures, rough mirrors, \
              mirrors and glass with smooth normals, polygons that cross themselves",
};

/// How beams are cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Edge of the tiles that beams start with, pixels, at least 1.
    pub tile: u32,
    /// With more candidates than these, a piece larger than a pixel is halved, not cut by them.
    pub candidates: usize,
    /// By how much a ray may be bent wrong at one refraction, in angles that a pixel spans.
    pub bend: f64,
    /// Pieces with less area, square pixels, are dropped.
    pub least_area: f64,
    /// Pieces of a beam that are cut before all others are decided at their centres.
    pub most_cuts: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { tile: 16, candidates: 32, bend: 0.1, least_area: 1e-13, most_cuts: 1_000_000 }
    }
}

/// The sine of the angle between a mirror's normals and its face beyond which it is not flat.
const FLAT: f64 = 1e-9;

/// Refuses a scene that beams cannot trace.
///
/// # Errors
/// [`Refusal`] naming what the scene has, and how many.
pub fn refusal(scene: &Scene) -> Result<(), Refusal> {
    let none = |count: usize, what: &str| Refusal::of(&INFO, scene, count, what);
    let primitives =
        |test: &dyn Fn(&Primitive) -> bool| scene.primitives.iter().filter(|p| test(p)).count();
    let material = |p: &Primitive| scene.materials.get(p.material as usize);
    none(primitives(&|p| matches!(p.shape, Shape::Sphere(_))), "spheres")?;
    none(primitives(&|p| matches!(p.shape, Shape::Cone(_))), "cones")?;
    none(scene.lights.iter().filter(|l| l.radius > 0.0).count(), "lights with a radius")?;
    none(usize::from(scene.camera.aperture > 0.0), "lens with an aperture")?;
    let opens = scene.camera.angle > 0.0 && scene.camera.angle < 180.0;
    none(usize::from(!opens), "field of view outside 0 to 180 degrees")?;
    let moves = scene.velocities.iter().filter(|v| **v != DVec3::ZERO).count();
    none(if scene.camera.shutter > 0.0 { moves } else { 0 }, "moving primitives")?;
    let is_textured = |(p, id): (&Primitive, u32)| {
        scene.texcoords_of(id).is_some() && material(p).is_some_and(|m| m.texture.is_some())
    };
    let textured = scene.primitives.iter().zip(0..).filter(|&p| is_textured(p)).count();
    none(textured, "textured primitives")?;
    let is_rough =
        |p: &Primitive| material(p).is_some_and(|m| m.specular > 0.0 && m.roughness > 0.0);
    none(primitives(&is_rough), "primitives that are rough mirrors")?;
    let bends = |p: &Primitive| {
        material(p).is_some_and(|m| m.specular > 0.0 || m.transmittance > 0.0)
            && !is_flat(scene, p.shape)
    };
    none(primitives(&bends), "mirrors or glasses with smooth normals")?;
    none(faces::crossing_outlines(scene), "polygons that cross themselves")
}

/// True unless it is a patch whose normals differ from that of its face.
fn is_flat(scene: &Scene, shape: Shape) -> bool {
    let Shape::Patch { n, .. } = shape else { return true };
    let face = newell_normal(&scene.outline(shape));
    n.iter().all(|&i| {
        let normal = scene.normals.get(i as usize).copied().unwrap_or(DVec3::ZERO);
        normal.normalize_or_zero().cross(face).length() <= FLAT
    })
}

pub struct BeamScene<'a> {
    pub scene: &'a Scene,
    pub over: Structures<'a>,
    pub settings: Settings,
    pub frame: Frame,
    pub eye: EyeRays,
    pub faces: Faces,
    pub surfaces: Surfaces<'a>,
    pub lights: Vec<(DVec3, Rgb, f64)>,
    /// Largest coordinate, world units.
    pub magnitude: f64,
}

impl<'a> BeamScene<'a> {
    /// Refuses what beams cannot do.
    ///
    /// # Errors
    /// [`Refusal`] naming what the scene has.
    pub fn new(
        scene: &'a Scene,
        frame: Frame,
        settings: &Settings,
        over: Structures<'a>,
    ) -> Result<Self, Refusal> {
        refusal(scene)?;
        Ok(Self {
            scene,
            over,
            settings: Settings { tile: settings.tile.max(1), ..*settings },
            frame,
            eye: EyeRays::new(&scene.camera, frame.resolution, Sampling::PixelCentres),
            faces: Faces::of(scene),
            surfaces: Surfaces::new(scene, false),
            lights: lights(scene),
            magnitude: magnitude(scene),
        })
    }
}

counts! {
    /// One for each tile.
    beams: "eye beams",
    mirrored: "mirrored beams",
    refracted: "refracted beams",
    shadows: "shadow beams",
    /// Pieces that see one face, or nothing.
    fragments: "fragments",
    /// Pieces that were cut in two or more.
    cut: "pieces cut",
    /// Pieces that were decided by the face in front of their centre, as too many cuts were made.
    unresolved: "pieces decided at their centre",
    /// Parts of beams that are reflected totally.
    internal: "beams reflected totally",
    degenerate: "beams without a volume",
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene_loading::{Camera, Light, Material};

    fn what(change: impl FnOnce(&mut Scene)) -> Option<String> {
        let mut scene = Scene::new("odd");
        let m = scene.push_material(Material { specular: 0.5, ..Material::default() });
        scene.push_triangle(m, [DVec3::ZERO, DVec3::X, DVec3::Y]);
        change(&mut scene);
        refusal(&scene).err().map(|refusal| refusal.what)
    }

    #[test]
    fn curved_or_soft_scenes_are_refused_with_counts() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        assert_eq!(what(|_| ()), None);
        assert_eq!(what(|s| s.push_sphere(0, DVec3::ZERO, 1.0)).as_deref(), Some("1 spheres"));
        let disc = Light { position: DVec3::ZERO, color: None, radius: 0.5 };
        assert_eq!(what(|s| s.lights = vec![disc; 3]).as_deref(), Some("3 lights with a radius"));
        let lens = Camera { aperture: 0.1, ..Camera::default() };
        assert_eq!(what(|s| s.camera = lens).as_deref(), Some("1 lens with an aperture"));
        let closed = Camera { angle: 0.0, ..Camera::default() };
        let refused = what(|s| s.camera = closed);
        assert_eq!(refused.as_deref(), Some("1 field of view outside 0 to 180 degrees"));
        let moves = |s: &mut Scene| {
            s.camera.shutter = 1.0;
            s.last_moves(DVec3::X);
        };
        assert_eq!(what(moves).as_deref(), Some("1 moving primitives"));
        let rough = |s: &mut Scene| s.materials[0].roughness = 0.2;
        assert_eq!(what(rough).as_deref(), Some("1 primitives that are rough mirrors"));
        let smooth = |s: &mut Scene| s.push_patch(0, corners, [DVec3::Z, DVec3::X, DVec3::Z]);
        assert_eq!(what(smooth).as_deref(), Some("1 mirrors or glasses with smooth normals"));
        assert_eq!(what(|s| s.push_patch(0, corners, [DVec3::Z * -2.0; 3])), None);
        let textured = |s: &mut Scene| {
            s.materials[0].texture = Some(0);
            s.last_is_textured([[0.0; 2]; 3]);
        };
        assert_eq!(what(textured).as_deref(), Some("1 textured primitives"));
        let tie = |s: &mut Scene| {
            let corners = [(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 1.0)];
            s.push_polygon(0, &corners.map(|(x, y)| DVec3::new(x, y, 0.0)));
        };
        assert_eq!(what(tie).as_deref(), Some("1 polygons that cross themselves"));
    }
}
