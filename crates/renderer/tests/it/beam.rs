//! Beams cover what samples cover, exactly.

use std::collections::BTreeMap;

use accel_core::structures::frustum_queries;
use accel_core::{Hit, Ray, Vector};
use glam::{DVec2, DVec3, dvec3};
use renderer::Image;
use renderer::camera::{EyeRays, Sampling};
use renderer::ray_offset::{OffsetRule, RayOffset};
use renderer::surface::{Surfaces, reflect};
use renderer::tracers::beam::{CoveredArea, Settings, coverage, draw};
use renderer::tracers::{DrawnImage, Frame, Structures};
use scene_loading::{SampleWishes, Scene};

use crate::flat_scenes::*;
use crate::{bits, by_rays, over, rmse, settings};

type Coverage = Vec<Vec<CoveredArea>>;

fn frame(size: u32, max_depth: u32) -> Frame {
    Frame { resolution: [size; 2], max_depth }
}

fn covered(scene: &Scene, frame: Frame, settings: &Settings) -> Coverage {
    over(scene, "uniform-grid", |over| coverage(scene, frame, settings, over).unwrap())
}

fn drawn(scene: &Scene, frame: Frame) -> DrawnImage {
    over(scene, "uniform-grid", |over| draw(scene, frame, &Settings::default(), over).unwrap())
}

fn count(drawn: &DrawnImage, what: &str) -> u64 {
    drawn.counts.iter().find(|(name, _)| *name == what).expect("a count of that name").1
}

/// Edge of the square of samples of a pixel.
const EDGE: u32 = 64;

/// How often paths of mirrored rays meet each primitive, by pixel: 4096 jittered samples, one a
/// cell. `from_mirrors`: rays leave mirrors, else, a planted fault, the eye's image behind them.
fn sampled(
    scene: &Scene,
    frame: Frame,
    from_mirrors: bool,
) -> Vec<BTreeMap<(u32, Option<u32>), u32>> {
    let eye = EyeRays::new(&scene.camera, frame.resolution, Sampling::PixelCentres);
    let surfaces = Surfaces::new(scene, false);
    let offset = RayOffset::new(OffsetRule::default(), 10.0);
    let mut state = 7_u64;
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let [width, height] = frame.resolution;
    let mut pixels = vec![BTreeMap::new(); (width * height) as usize];
    over(scene, "brute-force", |over| {
        for (pixel, at) in pixels.iter_mut().zip(0..) {
            let mut rays: Vec<Ray<f64>> = (0..EDGE * EDGE)
                .map(|k| {
                    let cell = DVec2::new(f64::from(k % EDGE), f64::from(k / EDGE));
                    let within = (cell + DVec2::new(random(), random())) / f64::from(EDGE);
                    let direction = eye.direction_within(at % width, at / width, within);
                    Ray::from_dvec3(eye.origin(), direction)
                })
                .collect();
            for depth in 1..=frame.max_depth {
                let mut hits = vec![Hit::NONE; rays.len()];
                over.rays.closest_hits(&rays, &mut hits);
                let mut next = Vec::new();
                for (ray, hit) in rays.iter().zip(&hits) {
                    let id = hit.is_hit().then_some(hit.id);
                    *pixel.entry((depth, id)).or_insert(0) += 1;
                    let Some(id) = id else { continue };
                    let (from, d) = (ray.origin.to_dvec3(), ray.direction.to_dvec3());
                    let point = surfaces.at(id, from + d * hit.t);
                    if point.material.specular > 0.0 {
                        let direction = reflect(d, point.normal);
                        let mut leaves: Ray<f64> = offset.along(&point, direction);
                        if !from_mirrors {
                            leaves.origin = Vector::from_dvec3(point.position - direction * hit.t);
                        }
                        next.push(leaves);
                    }
                }
                rays = next;
            }
        }
    });
    pixels
}

/// What is wrong with a coverage, if anything: the sum of a pixel, or one that samples deny.
fn fault(areas: &Coverage, samples: &[BTreeMap<(u32, Option<u32>), u32>]) -> Option<String> {
    let n = f64::from(EDGE * EDGE);
    let mut totals: BTreeMap<(u32, Option<u32>), [f64; 2]> = BTreeMap::new();
    for (number, (pixel, counts)) in areas.iter().zip(samples).enumerate() {
        let sum: f64 = pixel.iter().filter(|c| c.depth == 1).map(|c| c.area).sum();
        if (sum - 1.0).abs() > 1e-9 {
            return Some(format!("pixel {number}: areas sum to {sum}"));
        }
        let mut both: BTreeMap<_, [f64; 2]> = BTreeMap::new();
        for c in pixel {
            both.entry((c.depth, c.id)).or_default()[0] += c.area;
        }
        for (key, count) in counts {
            both.entry(*key).or_default()[1] += f64::from(*count) / n;
        }
        for (key, [area, share]) in both {
            // five standard errors, and five samples where hardly any are expected
            let bound = 5.0 * (area * (1.0 - area).max(0.0) / n).sqrt() + 5.0 / n;
            if (area - share).abs() > bound {
                return Some(format!("pixel {number} {key:?}: {area}, {share} of the samples"));
            }
            let total = totals.entry(key).or_default();
            total[0] += area - share;
            total[1] += area * (1.0 - area).max(0.0) / n + 1.0 / (n * n);
        }
    }
    let biased = totals.iter().find(|(_, [sum, variance])| sum.abs() > 5.0 * variance.sqrt());
    biased.map(|(key, [sum, variance])| format!("{key:?}: off by {sum}, variance {variance}"))
}

/// Covers part of a pixel, neither hardly any nor nearly all.
fn is_part(covered: &CoveredArea) -> bool {
    covered.area > 0.1 && covered.area < 0.9
}

#[test]
fn eye_beams_cover_what_samples_cover() {
    for scene in [tetra(3), bare_mount(3), concave(), cycle(), intersecting()] {
        let frame = frame(16, 1);
        let samples = sampled(&scene, frame, true);
        for candidates in [0, 8, 1000] {
            let settings =
                Settings { candidates, tile: 4 + candidates as u32, ..Settings::default() };
            let areas = covered(&scene, frame, &settings);
            assert_eq!(fault(&areas, &samples), None, "{} {candidates}", scene.name);
        }
        // planted faults: a polygon dropped; given to what lies behind; a tenth too small
        let areas = covered(&scene, frame, &Settings::default());
        let split: Vec<usize> =
            (0..areas.len()).filter(|&i| areas[i].iter().any(is_part)).collect();
        assert!(split.len() > 20, "{}", scene.name);
        for &pixel in split.iter().step_by(9) {
            let mut dropped = areas.clone();
            let large = dropped[pixel].iter().position(is_part).unwrap();
            let taken = dropped[pixel].remove(large);
            assert!(fault(&dropped, &samples).is_some(), "{} {pixel}", scene.name);
            dropped[pixel].push(CoveredArea { id: Some(u32::MAX), ..taken });
            assert!(fault(&dropped, &samples).is_some(), "{} {pixel}", scene.name);
        }
    }
}

#[test]
fn eye_beams_part_the_image_exactly() {
    for scene in [tetra(6), bare_mount(6), concave(), cycle(), intersecting(), soup(5, 200)] {
        let areas = covered(&scene, frame(48, 1), &Settings::default());
        let sums = areas.iter().map(|pixel| pixel.iter().map(|c| c.area).sum::<f64>());
        let worst = sums.map(|sum| (sum - 1.0).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-9, "{}: {worst:e}", scene.name);
        let parts = areas.iter().map(Vec::len).max();
        assert!(parts > Some(1), "{}: {parts:?}", scene.name);
        let inside = areas.iter().flatten().all(|c| c.area >= 0.0 && c.lit <= 2.0 * c.area + 1e-9);
        assert!(inside, "{}", scene.name);
    }
}

#[test]
fn meshes_leave_no_gaps_and_no_overlaps() {
    // a bumpy sheet that fills the view, before a wall; lit from the side of the eye
    let mut scene = stage("sheet");
    scene.lights.clear();
    let m = matte(&mut scene, [0.5; 3]);
    let bump = |i: i32, k: i32| (f64::from(i * 37 + k * 91)).sin();
    let corner = |i: i32, k: i32| {
        let at = dvec3(f64::from(i), f64::from(k), 0.0) * 0.21;
        at + dvec3(bump(i, k), bump(k + 5, i), bump(i + 9, k)) * 0.06
    };
    for i in -15..15 {
        for k in -15..15 {
            let [a, b, c, d] =
                [corner(i, k), corner(i + 1, k), corner(i + 1, k + 1), corner(i, k + 1)];
            scene.push_triangle(m, [a, b, c]);
            scene.push_triangle(m, [c, d, a]);
        }
    }
    let sheet = scene.primitives.len() as u32;
    rectangle(&mut scene, m, dvec3(-9.0, -9.0, -1.0), DVec3::X * 18.0, DVec3::Y * 18.0);
    let behind = |scene: &Scene| -> f64 {
        let areas = covered(scene, frame(20, 1), &Settings::default());
        areas.iter().flatten().filter(|c| c.id.is_none_or(|id| id >= sheet)).map(|c| c.area).sum()
    };
    let gaps = behind(&scene);
    assert!(gaps < 1e-9, "{gaps:e}");
    // planted fault: a vertex of one triangle, in the middle, moved by a thousandth
    scene.vertices[6 * (15 * 30 + 15)].x += 1e-3;
    assert!(behind(&scene) > 1e-6);
}

#[test]
fn mirrored_beams_cover_what_mirrored_samples_cover() {
    for (scene, depth) in [(mirror(), 3), (two_mirrors(), 6)] {
        let frame = frame(16, depth);
        let samples = sampled(&scene, frame, true);
        let areas = covered(&scene, frame, &Settings::default());
        assert_eq!(fault(&areas, &samples), None, "{}", scene.name);
        let deep: f64 =
            areas.iter().flatten().filter(|c| c.depth == depth.min(4)).map(|c| c.area).sum();
        assert!(scene.name == "mirror" || deep > 10.0, "{}: {deep} pixels at depth 4", scene.name);
        // planted fault: the near plane ignored, so that what is behind a mirror is seen in it
        let through = sampled(&scene, frame, false);
        assert!(fault(&areas, &through).is_some(), "{}", scene.name);
        // planted fault: a beam that is not split at the edge of the mirror
        let is_edge = |c: &CoveredArea| c.depth == 1 && c.id == Some(0) && is_part(c);
        let edge = areas.iter().position(|pixel| pixel.iter().any(is_edge));
        let edge = edge.expect("the mirror's edge");
        let mut whole = areas.clone();
        let sum: f64 = whole[edge].iter().filter(|c| c.depth == 2).map(|c| c.area).sum();
        whole[edge].iter_mut().filter(|c| c.depth == 2).for_each(|c| c.area /= sum);
        assert!(fault(&whole, &samples).is_some(), "{}", scene.name);
    }
}

#[test]
fn the_shadow_of_a_square_has_exact_edges() {
    // the image shows the floor from -1 to 1; the light is 5 above it, the square 2
    let on_floor = |x: f64, light: f64| light + (x - light) * 5.0 / 3.0;
    let (low_x, high_x) = (on_floor(-0.3, 0.3), on_floor(0.2, 0.3));
    let (low_y, high_y) = (on_floor(-0.2, 0.1), on_floor(0.4, 0.1));
    for size in [1_u32, 7, 33] {
        let scene = square_shadow();
        let areas = covered(&scene, frame(size, 1), &Settings::default());
        let n = f64::from(size);
        let overlap =
            |from: f64, to: f64, low: f64, high: f64| (to.min(high) - from.max(low)).max(0.0);
        let (mut worst, mut part) = (0.0_f64, 0);
        for (pixel, i) in areas.iter().zip(0..) {
            let (x, y) = (f64::from(i % size), f64::from(size - 1 - i / size));
            let at = |k: f64| 2.0 * k / n - 1.0;
            let dark = overlap(at(x), at(x + 1.0), low_x, high_x)
                * overlap(at(y), at(y + 1.0), low_y, high_y)
                * (n * n / 4.0);
            assert_eq!(pixel.len(), 1);
            worst = worst.max((1.0 - pixel[0].lit - dark).abs());
            part += usize::from(dark > 1e-6 && dark < 1.0 - 1e-6);
        }
        assert!(worst < 1e-9, "{size}: {worst:e}");
        assert!(part > 0, "{size}: no pixel is partly in shadow");
    }
}

/// The image of single rays, with so many samples per pixel.
fn supersampled(scene: &Scene, size: u32, samples: u32) -> Image {
    let wishes = SampleWishes { supersamples: Some(samples), ..SampleWishes::default() };
    by_rays(scene, &settings([size; 2], wishes))
}

/// Root mean square and mean of the difference to the image of single rays.
fn difference(scene: &Scene, size: u32, samples: u32) -> [f64; 2] {
    let expected = supersampled(scene, size, samples);
    let image = drawn(scene, frame(size, 5)).image;
    let mean = |image: &Image| {
        let all = image.pixels.as_flattened();
        all.iter().sum::<f64>() / all.len() as f64
    };
    [rmse(&image, &expected), (mean(&image) - mean(&expected)).abs()]
}

#[test]
fn images_are_those_of_single_rays() {
    let mut smooth = stage("smooth");
    let m = matte(&mut smooth, [0.9, 0.6, 0.3]);
    let corners = [dvec3(-1.0, -1.0, 0.0), dvec3(1.5, -0.8, 0.5), dvec3(0.2, 1.4, -0.3)];
    let normals = [dvec3(-0.8, 0.0, 0.6), dvec3(0.6, 0.1, 0.8), dvec3(0.0, 1.0, 0.3)];
    smooth.push_patch(m, corners, normals);
    smooth.push_triangle(m, corners.map(|c| c * 0.3 + dvec3(0.6, 0.9, 1.0)));
    let scenes =
        [tetra(3), bare_mount(3), concave(), intersecting(), mirror(), two_mirrors(), smooth];
    for scene in scenes {
        let [rms, mean] = difference(&scene, 16, 1024);
        // shading at one point of a pixel: more of an error where normals turn within it
        let most = if scene.name == "smooth" { 3e-4 } else { 1e-4 };
        assert!(rms < 1e-3 && mean < most, "{}: {rms:e} {mean:e}", scene.name);
    }
    // the measure has power: one sample per pixel is another image
    let few = supersampled(&tetra(3), 16, 1);
    assert!(rmse(&few, &supersampled(&tetra(3), 16, 1024)) > 0.05);
}

#[test]
fn glass_bends_beams_as_rays_but_for_what_a_pixel_spans() {
    let scene = slab();
    let (expected, size) = (supersampled(&scene, 24, 2048), frame(24, 5));
    let error = |bend: f64| {
        let settings = Settings { bend, ..Settings::default() };
        let drawn =
            over(&scene, "uniform-grid", |over| draw(&scene, size, &settings, over).unwrap());
        assert!(count(&drawn, "refracted beams") > 20, "{:?}", drawn.counts);
        rmse(&drawn.image, &expected)
    };
    let [coarse, default, fine] = [0.5, Settings::default().bend, 0.03].map(error);
    // stripes of contrast 1 that are off by part of a pixel; samples alone leave 0.0003
    assert!(default < 3e-3 && fine < 1e-3, "{default} {fine}");
    // planted fault: a bound on the error that is not kept
    assert!(coarse > 1.5 * default && default > 1.5 * fine, "{coarse} {default} {fine}");
    // without glass the stripes are elsewhere
    let mut clear = scene.clone();
    clear.materials[0].refraction_index = 1.0;
    let bent = supersampled(&scene, 24, 16);
    assert!(rmse(&supersampled(&clear, 24, 16), &bent) > 0.1);
}

#[test]
fn structures_and_threads_change_no_bit() {
    for scene in [tetra(4), mirror()] {
        let frame = frame(24, 4);
        let of = |frusta: &str, threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let draw =
                |over: Structures<'_>| draw(&scene, frame, &Settings::default(), over).unwrap();
            bits(&pool.install(|| over(&scene, frusta, draw)).image)
        };
        let expected = of("brute-force", 1);
        for entry in frustum_queries::REGISTRY {
            assert!(of(entry.info.name, 1) == expected, "{} {}", scene.name, entry.info.name);
        }
        for threads in [2, 5] {
            assert!(of("uniform-grid", threads) == expected, "{} {threads}", scene.name);
        }
    }
}

#[test]
fn tiles_change_areas_by_rounding_alone_and_nothing_is_left_undecided() {
    for scene in [tetra(4), intersecting(), two_mirrors()] {
        let frame = frame(20, 3);
        let expected = covered(&scene, frame, &Settings::default());
        // light at a grazing angle magnifies the rounding of what casts the shadow
        for (tile, candidates) in [(1, 8), (3, 0), (32, 2)] {
            let settings = Settings { tile, candidates, ..Settings::default() };
            let other = covered(&scene, frame, &settings);
            for (a, b) in expected.iter().flatten().zip(other.iter().flatten()) {
                let near = (a.area - b.area).abs() < 1e-9 && (a.lit - b.lit).abs() < 1e-7;
                assert!((a.depth, a.id) == (b.depth, b.id) && near, "{}: {a:?} {b:?}", scene.name);
            }
        }
        let drawn = drawn(&scene, frame);
        assert_eq!(count(&drawn, "pieces decided at their centre"), 0);
        assert_eq!(count(&drawn, "beams without a volume"), 0);
        // planted fault: no cuts at all, so that edges are decided at the centres of pieces
        let settings = Settings { most_cuts: 0, ..Settings::default() };
        let coarse = covered(&scene, frame, &settings);
        assert!(coarse != expected);
    }
}

#[test]
fn scenes_that_beams_do_not_support_are_refused() {
    let scene = scene_loading::procedural::generate("balls:1").unwrap();
    let refused = over(&scene, "brute-force", |over| {
        draw(&scene, frame(4, 5), &Settings::default(), over).unwrap_err()
    });
    let expected = "beam tracing does not support scene balls:1: it has 10 spheres";
    assert_eq!(refused.to_string(), expected);
}

#[test]
fn polygons_around_the_eye_are_clipped_like_samples_see_them() {
    // of 1024 samples the mean scatters by 1.4e-4 from seed to seed: too much for the bounds
    const SAMPLES: u32 = 2048;
    for seed in 0..4 {
        let mut scene = soup(seed, 60);
        let frame = frame(8, 3);
        let areas = covered(&scene, frame, &Settings::default());
        assert_eq!(fault(&areas, &sampled(&scene, frame, true)), None, "seed {seed}");
        let [rms, mean] = difference(&scene, 8, SAMPLES);
        assert!(rms < 2e-3 && mean < 3e-4, "{seed}: {rms:e} {mean:e}");
        // mirrors that let light through as well
        scene.materials[1].transmittance = 0.5;
        scene.materials[1].refraction_index = 1.3;
        let [rms, mean] = difference(&scene, 8, SAMPLES);
        assert!(rms < 3e-3 && mean < 4e-4, "{seed}: {rms:e} {mean:e}");
    }
}
