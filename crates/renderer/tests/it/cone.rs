//! Cone tracing: coverage, the limit of rays, independence of structure and threads, and how near
//! its images are to many samples.

use std::ops::ControlFlow;

use accel_core::query::region::{Candidates, Frustum, FrustumQueries};
use accel_core::structure::StructureStats;
use accel_core::structures::frustum_queries;
use glam::{DVec2, DVec3, dvec3};
use renderer::tracers::cone::circular_cone::{Cone, DepartedSurface};
use renderer::tracers::cone::compose::{Fragment, compose};
use renderer::tracers::cone::forms::Forms;
use renderer::tracers::cone::{Settings, draw, refusal};
use renderer::tracers::{DrawnImage, Frame, Structures};
use renderer::{Image, RenderSettings};
use scene_loading::procedural::generate;
use scene_loading::{Camera, Light, Material, SampleWishes, Scene};

use crate::convergence::penumbra_errors;
use crate::{bits, by_rays, effect_scene, image, over, rmse, settings};

/// The image by cones, the candidates from the structure of that name.
fn cones(scene: &Scene, frame: Frame, settings: &Settings, structure: &str) -> DrawnImage {
    over(scene, structure, |over| draw(scene, frame, settings, over).unwrap())
}

fn frame(resolution: [u32; 2]) -> Frame {
    Frame { resolution, max_depth: 5 }
}

/// By samples of the pixel's area, and of lights.
fn sampled(scene: &Scene, size: [u32; 2], pixel: u32, light: u32) -> Image {
    let samples =
        SampleWishes { supersamples: Some(pixel), shadow: Some(light), ..SampleWishes::default() };
    image(scene, &settings(size, samples)).image
}

/// A small generator of test numbers.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as f64 / (1u64 << 31) as f64
    }

    fn point(&mut self, half: f64) -> DVec3 {
        (dvec3(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0) * half
    }

    /// From 10^-a to 10^b.
    fn size(&mut self, a: f64, b: f64) -> f64 {
        10f64.powf(self.unit() * (a + b) - a)
    }
}

#[test]
fn without_width_every_cone_is_a_ray() {
    for name in ["balls:2", "mount:3", "rings:2", "gears:1"] {
        let scene = generate(name).unwrap();
        let size = [40, 32];
        let drawn =
            cones(&scene, frame(size), &Settings { width: 0.0, ..Settings::default() }, "kd-tree");
        let whitted = by_rays(&scene, &settings(size, SampleWishes::default()));
        for (a, b) in drawn.image.pixels.as_flattened().iter().zip(whitted.pixels.as_flattened()) {
            assert!((a - b).abs() < 1e-12, "{name}: {a} {b}");
        }
        assert_eq!(drawn.work.queries, 0, "{name}");
    }
}

#[test]
fn thin_cones_hit_what_rays_hit() {
    for name in ["balls:2", "mount:3", "rings:2", "gears:1"] {
        let scene = generate(name).unwrap();
        let size = [64, 64];
        let thin = Settings { width: 1e-6, subdivisions: 0, ..Settings::default() };
        let drawn = cones(&scene, Frame { resolution: size, max_depth: 1 }, &thin, "uniform-grid");
        let settings = RenderSettings { max_depth: 1, ..settings(size, SampleWishes::default()) };
        let whitted = by_rays(&scene, &settings);
        let differ = |a: &[f64; 3], b: &[f64; 3]| (0..3).any(|k| (a[k] - b[k]).abs() > 1e-3);
        let pixels = drawn.image.pixels.iter().zip(&whitted.pixels);
        let wrong = pixels.filter(|(a, b)| differ(a, b)).count();
        // where a cone's edge is on an edge: one pixel in a million in theory
        assert!(wrong <= 1, "{name}: {wrong} of {}", whitted.pixels.len());
    }
}

/// Primitives of every kind and size, many around the origin.
fn shapes(random: &mut Random) -> Scene {
    let (mut scene, m) = Scene::of_one_material("shapes");
    for _ in 0..12 {
        let at = random.point(3.0);
        let size = random.size(3.0, 1.0);
        scene.push_sphere(m, at, size);
        let (r0, r1) = (random.size(3.0, 0.5), random.size(3.0, 0.5));
        let apex = at + random.point(2.0);
        scene
            .push_cone(m, scene_loading::Cone { base: at, base_radius: r0, apex, apex_radius: r1 });
        let (a, b) = (random.point(size), random.point(size));
        scene.push_triangle(m, [at, at + a, at + b]);
        // concave
        scene.push_polygon(m, &[at, at + a, at + (a + b) * 0.2, at + b]);
    }
    scene
}

/// What is wrong with a coverage.
fn fault(share: f64, centroid: DVec2) -> Option<String> {
    let is_right = (0.0..=1.0).contains(&share) && centroid.length() <= 1.0 + 1e-12;
    (!is_right).then(|| format!("{share} at {centroid}"))
}

#[test]
fn coverage_stays_within_its_bounds() {
    let mut random = Random(7);
    let (mut tested, mut partial, mut whole, mut unclamped) = (0, 0, 0, 0);
    for _ in 0..150 {
        let scene = shapes(&mut random);
        let forms = Forms::new(&scene);
        for _ in 0..140 {
            let target = random.point(3.0);
            let origin = random.point(5.0);
            let axis = (target - origin).normalize_or(DVec3::Z);
            let radius = if random.unit() < 0.5 { 0.0 } else { random.size(6.0, 0.5) };
            let spread = random.size(6.0, 0.0) * if random.unit() < 0.3 { -1.0 } else { 1.0 };
            let mut cone = Cone::new(origin, axis, radius, spread);
            if random.unit() < 0.3 {
                cone.end = origin.distance(target);
            }
            let plane = (random.unit() < 0.3).then(|| (axis, axis.dot(origin)));
            let inwards = random.unit() < 0.5;
            cone.left = Some(DepartedSurface { id: 0, inwards, plane });
            let mut sum = 0.0;
            for id in 0..scene.primitives.len() as u32 {
                tested += 1;
                let Some(found) = forms.cover(&cone, id) else { continue };
                let overlap = found.overlap;
                assert_eq!(fault(overlap.share, overlap.centroid), None, "{cone:?} {id}");
                assert!(!found.far.is_nan());
                partial += u32::from(overlap.share < 1.0);
                whole += u32::from(overlap.share >= 1.0);
                sum += overlap.share;
            }
            unclamped += u32::from(fault(sum, DVec2::ZERO).is_some());
        }
    }
    assert!(tested > 1_000_000 && partial > 20_000 && whole > 10_000, "{tested} {partial} {whole}");
    // planted fault: what is added and not clamped is found out
    assert!(unclamped > 1000, "{unclamped}");
}

#[test]
fn the_triangles_of_a_mesh_cover_a_cone_exactly_once() {
    let mut random = Random(3);
    let (mut scene, m) = Scene::of_one_material("hills");
    let n = 12;
    let corners: Vec<DVec3> = (0..(n + 1) * (n + 1))
        .map(|i| dvec3(f64::from(i % (n + 1)), f64::from(i / (n + 1)), 0.0) + random.point(0.15))
        .collect();
    let corner = |x: i32, y: i32| corners[(y * (n + 1) + x) as usize];
    for (x, y) in (0..n * n).map(|i| (i % n, i / n)) {
        scene.push_triangle(m, [corner(x, y), corner(x + 1, y), corner(x, y + 1)]);
        scene.push_triangle(m, [corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)]);
    }
    let forms = Forms::new(&scene);
    let (mut of_several, mut multiplied) = (0, 0);
    for _ in 0..500 {
        let from = dvec3(3.0 + 6.0 * random.unit(), 3.0 + 6.0 * random.unit(), 20.0);
        let axis = (DVec3::NEG_Z + random.point(0.05)).normalize();
        let cone = Cone::new(from, axis, 0.0, random.size(3.0, -1.3));
        let mut fragments: Vec<Fragment> = (0..scene.primitives.len() as u32)
            .filter_map(|id| {
                let coverage = forms.cover(&cone, id)?;
                let depth = forms.depth(&cone, id, coverage.overlap.centroid)?;
                Some(Fragment { id, depth, coverage })
            })
            .collect();
        let found = compose(&mut fragments, &|id, place| forms.depth(&cone, id, place));
        let sum: f64 = found.seen.iter().map(|s| s.share).sum();
        assert!(found.is_certain && (sum - 1.0).abs() < 1e-6, "{sum} {cone:?}");
        if fragments.len() > 1 {
            of_several += 1;
            // planted fault: as if they were independent
            let through: f64 = fragments.iter().map(|f| 1.0 - f.coverage.overlap.share).product();
            multiplied += u32::from(through > 1e-6);
        }
    }
    assert!(of_several > 150 && multiplied == of_several, "{of_several} {multiplied}");
}

/// A structure that says too early that nothing nearer will come, or brings the far first.
struct OutOfOrder<'a>(&'a dyn FrustumQueries);

impl FrustumQueries for OutOfOrder<'_> {
    fn query_in_order(
        &self,
        frustum: &Frustum,
        candidates: &mut Candidates,
        arrived: &mut dyn FnMut(&[u32], f64) -> ControlFlow<()>,
    ) {
        self.0.query(frustum, candidates);
        let ids: Vec<u32> = candidates.ids.iter().rev().copied().collect();
        for id in ids {
            if arrived(&[id], f64::MAX).is_break() {
                return;
            }
        }
    }

    fn stats(&self) -> StructureStats {
        self.0.stats()
    }
}

#[test]
fn the_image_does_not_depend_on_the_structure() {
    let scenes = [generate("rings:2"), generate("mount:3"), generate("balls:2")];
    for scene in scenes.into_iter().flatten().chain([effect_scene("effect-soft-shadows")]) {
        let small = Frame { resolution: [24, 20], max_depth: 3 };
        let settings = Settings { subdivisions: 1, ..Settings::default() };
        let expected = cones(&scene, small, &settings, "brute-force");
        for entry in frustum_queries::REGISTRY {
            let found = cones(&scene, small, &settings, entry.info.name);
            assert_eq!(bits(&found.image), bits(&expected.image), "{}", entry.info.name);
            assert_eq!(found.counts, expected.counts, "{}", entry.info.name);
        }
        let planted = over(&scene, "uniform-grid", |over| {
            let frusta = &OutOfOrder(over.frusta);
            draw(&scene, small, &settings, Structures { frusta, ..over }).unwrap()
        });
        assert!(rmse(&planted.image, &expected.image) > 1e-3, "{}", scene.name);
    }
}

#[test]
fn the_image_does_not_depend_on_threads() {
    let scene = effect_scene("effect-refraction");
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| cones(&scene, frame([40, 30]), &Settings::default(), "uniform-grid"))
    };
    let one = on(1);
    for threads in [2, 5] {
        let more = on(threads);
        assert_eq!(bits(&more.image), bits(&one.image));
        assert_eq!((more.counts, more.work), (one.counts.clone(), one.work));
    }
}

#[test]
fn scenes_that_cones_do_not_support_are_refused() {
    let refused = |name: &str| refusal(&effect_scene(name)).map_err(|e| e.to_string());
    for (name, what) in [
        ("effect-motion", "move while the shutter is open"),
        ("effect-focus", "1 lens with an extent"),
        ("effect-gloss", "with a rough mirror"),
    ] {
        let said = refused(name).unwrap_err();
        assert!(
            said.starts_with("cone tracing does not support scene") && said.contains(what),
            "{said}"
        );
    }
    for name in ["effect-plain", "effect-mirror", "effect-refraction", "effect-textures"] {
        assert_eq!(refused(name), Ok(()));
    }
}

/// A mirror ball that fills the image, and a checkerboard below it.
fn mirror_ball() -> Scene {
    let mut scene = Scene::new("mirror ball");
    let dark = scene.push_material(Material { color: [0.1; 3], ..Material::default() });
    let light = scene.push_material(Material { color: [0.9; 3], ..Material::default() });
    let mirror = Material { diffuse: 0.0, specular: 0.9, shine: 1e6, ..Material::default() };
    let mirror = scene.push_material(mirror);
    for i in 0..30 * 30 {
        let (x, z) = (i % 30, i / 30);
        let at = dvec3(f64::from(x) - 15.0, -1.5, f64::from(z) - 15.0);
        let material = if (x + z) % 2 == 0 { dark } else { light };
        scene.push_polygon(material, &[at, at + DVec3::X, at + DVec3::X + DVec3::Z, at + DVec3::Z]);
    }
    scene.push_sphere(mirror, DVec3::ZERO, 1.0);
    scene.background = [0.3, 0.5, 0.9];
    scene.lights = vec![Light::point(dvec3(9.0, 20.0, 12.0), Some([1.0; 3]))];
    scene.camera = Camera {
        from: dvec3(0.0, 0.5, 6.0),
        at: dvec3(0.0, -0.2, 0.9),
        angle: 12.0,
        ..Camera::default()
    };
    scene
}

#[test]
fn reflections_in_a_ball_are_as_wide_as_they_should_be() {
    let scene = mirror_ball();
    let size = [32, 32];
    let reference = sampled(&scene, size, 256, 1);
    let error = |subdivisions: u32, widening: bool| {
        let settings = Settings { subdivisions, widening, ..Settings::default() };
        rmse(&cones(&scene, frame(size), &settings, "uniform-grid").image, &reference)
    };
    let plain = error(0, true);
    let flat = error(0, false);
    let ray = rmse(&sampled(&scene, size, 1, 1), &reference);
    println!(
        "widened {plain:.4}, cut {:.4}, not widened {flat:.4}, a ray {ray:.4}",
        error(2, true)
    );
    assert!(plain < 0.03, "{plain}");
    // planted fault: a spread that is not widened
    assert!(flat > 2.0 * plain, "{flat} {plain}");
}

#[test]
fn the_penumbra_of_a_half_plane_is_the_closed_form() {
    let size = [64, 4];
    let draw = |scene: &Scene| cones(scene, frame(size), &Settings::default(), "brute-force").image;
    let (within, worst, planted) = penumbra_errors(size, draw);
    assert!(within > 40, "{within} pixels within the penumbra");
    // the cosine at the floor, which the closed form leaves out: 0.003; the footprint of the pixel
    assert!(worst < 0.008, "{worst}");
    assert!(planted > 0.02, "{planted}");
}

#[test]
fn soft_shadows_are_those_of_many_samples() {
    let scene = effect_scene("effect-soft-shadows");
    let size = [32, 32];
    let reference = sampled(&scene, size, 64, 16);
    let found =
        rmse(&cones(&scene, frame(size), &Settings::default(), "kd-tree").image, &reference);
    let few = rmse(&sampled(&scene, size, 4, 4), &reference);
    println!("cones {found:.4}, 4 samples of the pixel by 4 of the light {few:.4}");
    assert!(found < 0.015 && found < few, "{found} {few}");
}

#[test]
fn one_cone_is_nearer_to_balls_than_four_samples() {
    let scene = generate("balls:3").unwrap();
    let size = [40, 40];
    let reference = sampled(&scene, size, 1024, 1);
    let error = |subdivisions: u32| {
        let settings = Settings { subdivisions, ..Settings::default() };
        rmse(&cones(&scene, frame(size), &settings, "kd-tree").image, &reference)
    };
    let [one, four, sixteen] = [1, 4, 16].map(|n| rmse(&sampled(&scene, size, n, 1), &reference));
    let (plain, cut) = (error(0), error(2));
    println!("samples: 1 {one:.4}, 4 {four:.4}, 16 {sixteen:.4}; cones {plain:.4}, cut {cut:.4}");
    assert!(plain < four && cut < 0.6 * four, "{plain} {cut} {four}");
}
