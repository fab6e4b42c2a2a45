//! Pictures of the errors of cheap variants: the cheap variant on the left, the accurate one on the
//! right.

use std::path::Path;

use accel_core::query::tracer::Tracer;
use accel_core::structures::Entry;
use accel_core::{Hit, Ray};
use glam::{DVec3, dvec3};
use renderer::ray_offset::OffsetRule;
use renderer::{Geometry, Image, RaySettings, Whitted};
use scene_loading::{Camera, Light, Material, Scene};

use crate::accuracy::axes::voxel_traversal::LatticeRay;
use crate::accuracy::stage::{TRACER, build};
use crate::error::{StudyError, UnsavedImage};
use crate::verify::meshes::icosphere;

/// A picture: its file, what it shows, and how it is made.
struct Picture {
    file: &'static str,
    caption: &'static str,
    make: fn(&[Entry]) -> Result<Image, StudyError>,
}

const PICTURES: [Picture; 4] = [
    Picture {
        file: "leak.png",
        caption: "A leak: the rays at the corners and edges of a closed ball that pass through it, \
                  dark; Moeller-Trumbore's test, and the watertight one.",
        make: leak,
    },
    Picture {
        file: "acne.png",
        caption: "Acne: a ball on a floor whose shadow rays start on the surface itself, and under an \
                  error bound.",
        make: acne,
    },
    Picture {
        file: "missed-cell.png",
        caption: "Missed cells: of rays through 1024^3 cells, a row each, the cells they pierce in \
                  their order; those that the traversal passes by, red: accumulated, and recomputed in f64.",
        make: missed_cells,
    },
    Picture {
        file: "wrong-shadow.png",
        caption: "A wrong shadow: small balls on a floor under a fixed epsilon of 0.01, whose shadow \
                  rays begin beyond them, and under an error bound.",
        make: wrong_shadow,
    },
];

pub fn captions() -> String {
    let mut text = String::from("## What goes wrong\n\n");
    for Picture { file, caption, .. } in PICTURES {
        text.push_str(&format!("![{file}]({file})\n\n{caption}\n\n"));
    }
    text
}

pub fn write_all(folder: &Path, registry: &[Entry]) -> Result<(), StudyError> {
    for Picture { file, make, .. } in PICTURES {
        let path = folder.join(file);
        make(registry)?.save_png(&path).map_err(|source| UnsavedImage { path, source })?;
    }
    Ok(())
}

/// Pixels of a half, an axis.
const SIZE: u32 = 256;

/// Two images of the same height, a white line between them.
fn beside(left: &Image, right: &Image) -> Image {
    let mut pixels = Vec::new();
    let line = [[1.0; 3]; 4];
    let rows =
        left.pixels.chunks(left.width as usize).zip(right.pixels.chunks(right.width as usize));
    for (a, b) in rows {
        pixels.extend_from_slice(a);
        pixels.extend_from_slice(&line);
        pixels.extend_from_slice(b);
    }
    Image { width: left.width + right.width + 4, height: left.height, pixels }
}

/// Hands a structure over the scene to `ask`.
fn over<R>(
    registry: &[Entry],
    label: &str,
    scene: &Scene,
    ask: impl FnOnce(&dyn Tracer<f32>) -> R,
) -> Result<R, StudyError> {
    let geometry = Geometry::<f32>::of(scene)?;
    Ok(ask(&*build(registry, label, &scene.name, &geometry)?))
}

fn leak(registry: &[Entry]) -> Result<Image, StudyError> {
    let (mut scene, material) = Scene::of_one_material("a ball of triangles");
    let mesh = icosphere(3, DVec3::ZERO);
    mesh.iter().for_each(|corners| scene.push_triangle(material, *corners));
    let half = |test: &str| {
        let label = format!("{TRACER}:triangle-test={test}");
        over(registry, &label, &scene, |tracer| leaks(tracer, &mesh))
    };
    Ok(beside(&half("moeller-trumbore")?, &half("watertight")?))
}

/// Points at which far rays to corners and edges of the near side leak through.
fn leaks(tracer: &dyn Tracer<f32>, mesh: &[[DVec3; 3]]) -> Image {
    let mut pixels = vec![[0.85; 3]; (SIZE * SIZE) as usize];
    let eye = dvec3(0.31, 0.17, 4.0);
    for corners in mesh {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            for part in 0..=40 {
                let target = corners[a].lerp(corners[b], f64::from(part) / 40.0);
                // the outline is left out: there rays may pass
                if target.dot(eye) < 1.2 {
                    continue;
                }
                let from = eye.as_vec3();
                let ray = Ray::<f32>::new(from, target.as_vec3() - from);
                let mut hit = [Hit::NONE];
                tracer.closest_hits(&[ray], &mut hit);
                let place = |x: f64| ((x * 0.48 + 0.5) * f64::from(SIZE)) as usize;
                let passed = !hit.iter().all(|h| h.is_hit() && h.t < 1.5);
                let (x, y) = (place(target.x), place(-target.y));
                let size = if passed { 2 } else { 0 };
                for (dx, dy) in (0..=size).flat_map(|dy| (0..=size).map(move |dx| (dx, dy))) {
                    if let Some(pixel) = pixels.get_mut((y + dy) * SIZE as usize + x + dx) {
                        if passed {
                            *pixel = [0.6, 0.0, 0.0];
                        } else if pixel[1] > 0.0 {
                            *pixel = [0.5; 3];
                        }
                    }
                }
            }
        }
    }
    Image { width: SIZE, height: SIZE, pixels }
}

/// A floor, balls on it, a light above.
fn floor_with_balls(balls: &[(DVec3, f64)], view: f64) -> Scene {
    let mut scene = Scene::new("balls on a floor");
    let floor = scene.push_material(Material { color: [0.8, 0.77, 0.7], ..Material::default() });
    let ball = scene.push_material(Material { color: [0.3, 0.5, 0.8], ..Material::default() });
    let corner = |x: f64, z: f64| dvec3(x, 0.0, z) * (40.0 * view);
    scene.push_triangle(floor, [corner(-1., -1.), corner(1., 1.), corner(1., -1.)]);
    scene.push_triangle(floor, [corner(-1., -1.), corner(-1., 1.), corner(1., 1.)]);
    balls.iter().for_each(|(centre, radius)| scene.push_sphere(ball, *centre, *radius));
    let position = dvec3(3.0, 6.0, 4.0) * view;
    scene.lights = vec![Light::point(position, Some([1.0; 3]))];
    scene.background = [0.45, 0.6, 0.85];
    scene.camera = Camera {
        from: dvec3(0.0, 2.0, 4.0) * view,
        at: dvec3(0.0, 0.4, 0.0) * view,
        angle: 40.0,
        ..Camera::default()
    };
    scene
}

fn under(registry: &[Entry], scene: &Scene, rules: [OffsetRule; 2]) -> Result<Image, StudyError> {
    let image = |offset| {
        let settings = RaySettings {
            resolution: [SIZE; 2],
            diffuse: false,
            max_depth: 1,
            offset,
            ..RaySettings::default()
        };
        over(registry, TRACER, scene, |tracer| {
            Whitted::new(scene, &settings).image(tracer, &|| ()).image
        })
    };
    let [cheap, accurate] = rules;
    Ok(beside(&image(cheap)?, &image(accurate)?))
}

fn acne(registry: &[Entry]) -> Result<Image, StudyError> {
    let scene = floor_with_balls(&[(dvec3(0.0, 1.0, 0.0), 1.0)], 1.0);
    under(registry, &scene, [OffsetRule::None, OffsetRule::default()])
}

fn wrong_shadow(registry: &[Entry]) -> Result<Image, StudyError> {
    let centre = |i: u32| {
        let (x, z) = (f64::from(i % 5) - 2.0, f64::from(i / 5) - 2.0);
        (dvec3(x * 0.011, 0.004, z * 0.011), 0.004)
    };
    let balls: Vec<(DVec3, f64)> = (0..25).map(centre).collect();
    let scene = floor_with_balls(&balls, 0.016);
    under(registry, &scene, [OffsetRule::Fixed(0.01), OffsetRule::default()])
}

/// A row of pixels for each of so many rays.
fn missed_cells(_: &[Entry]) -> Result<Image, StudyError> {
    let n = 1024;
    // rays from a corner region across the grid, with numbers that have few common factors
    let drawn = (0..u64::from(SIZE) * 4).filter_map(|i| {
        let part = |k: u64| ((i * k) % 65_521) as f64;
        let origin = dvec3(part(7919), part(104_729), part(1_299_709)) / 1024.0;
        let direction = dvec3(40_000.0 + part(31), 30_000.0 + part(331), 20_000.0 + part(3331));
        LatticeRay::new(n, origin, direction)
    });
    let rays: Vec<LatticeRay> = drawn.take(SIZE as usize).collect();
    let half = |traversal: &str| {
        let mut pixels = Vec::new();
        for ray in &rays {
            let mut visited = ray.visited(traversal);
            visited.sort_unstable();
            let mut row: Vec<[f64; 3]> = vec![[0.95; 3]; SIZE as usize];
            let mut pierced = ray.pierced();
            pierced.sort_by_key(|[x, y, z]| x + y + z);
            let shown = pierced.len().max(1);
            for (i, cell) in pierced.iter().enumerate() {
                let column = i * SIZE as usize / shown;
                let is_missed = visited.binary_search(cell).is_err();
                for pixel in row.iter_mut().skip(column).take(2) {
                    if is_missed {
                        *pixel = [0.8, 0.0, 0.0];
                    } else if pixel[1] > 0.5 {
                        *pixel = [0.75, 0.8, 0.85];
                    }
                }
            }
            pixels.extend(row);
        }
        pixels.resize((SIZE * SIZE) as usize, [1.0; 3]);
        Image { width: SIZE, height: SIZE, pixels }
    };
    Ok(beside(&half("accumulate"), &half("f64")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use accel_core::structures::REGISTRY;

    /// Each picture shows a fault on the left that is not there on the right.
    #[test]
    fn halves_differ() {
        for picture in PICTURES {
            let image = (picture.make)(REGISTRY).unwrap();
            let differing = image
                .pixels
                .chunks(image.width as usize)
                .flat_map(|row| {
                    let half = SIZE as usize;
                    row[..half].iter().zip(&row[half + 4..])
                })
                .filter(|(a, b)| a != b)
                .count();
            assert!(differing > 20, "{}: {differing} pixels", picture.file);
        }
    }
}
