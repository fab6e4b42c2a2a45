//! HARD_CASES S4: the critical angle, nested glass at the depth cap, lights in awkward places.
//! Whatever happens, no pixel is NaN.

use glam::{DVec3, dvec3};
use renderer::surface::refract;
use renderer::{Effect, RenderSettings};
use scene_loading::{Camera, Light, Material, Scene};

use crate::{image, samples, settings};

fn is_sound(color: &[f64; 3]) -> bool {
    color.iter().all(|x| x.is_finite() && *x >= 0.0)
}

fn check(scene: &Scene, settings: &RenderSettings) {
    let rendered = image(scene, settings);
    let unsound = rendered.image.pixels.iter().filter(|color| !is_sound(color)).count();
    assert_eq!(unsound, 0, "{}", scene.name);
}

#[test]
fn the_check_finds_invalid_colours() {
    for planted in [f64::NAN, f64::INFINITY, -1e-3] {
        assert!(!is_sound(&[0.5, planted, 0.5]));
    }
}

#[test]
fn an_ulp_around_the_critical_angle() {
    let sine = 1.0_f64 / 1.5;
    let mut outcomes = [0, 0];
    let mut x = sine;
    for _ in 0..64 {
        x = x.next_down();
    }
    for _ in 0..128 {
        // from within the glass (normal up) at an angle of that sine
        let d = dvec3(x, (1.0 - x * x).sqrt(), 0.0);
        match refract(d, DVec3::Y, 1.5) {
            Some(out) => {
                outcomes[0] += 1;
                assert!(out.is_finite() && out.y >= 0.0 && (out.length() - 1.0).abs() < 1e-7);
            }
            None => outcomes[1] += 1,
        }
        x = x.next_up();
    }
    assert!(outcomes.iter().all(|n| *n > 16), "{outcomes:?}");
}

fn glass(refraction_index: f64) -> Material {
    Material {
        specular: 0.2,
        shine: 50.0,
        transmittance: 0.8,
        refraction_index,
        ..Material::default()
    }
}

fn camera() -> Camera {
    Camera { from: dvec3(0.1, 0.2, 6.0), at: DVec3::ZERO, angle: 40.0, ..Camera::default() }
}

#[test]
fn nested_glass_ends_at_the_depth_cap() {
    let mut scene = Scene::new("nested");
    for (i, index) in [1.5, 2.4, 1.0, 0.5, 1.33].into_iter().enumerate() {
        let m = scene.push_material(glass(index));
        scene.push_sphere(m, DVec3::ZERO, 2.0 - 0.3 * i as f64);
    }
    scene.lights = vec![Light { position: dvec3(3.0, 3.0, 3.0), color: None, radius: 0.5 }];
    scene.camera = camera();
    scene.background = [0.3, 0.4, 0.5];
    let mut rays = Vec::new();
    for max_depth in [1, 2, 5, 9] {
        let settings = RenderSettings { max_depth, ..settings([24, 24], samples(1)) };
        check(&scene, &settings);
        rays.push(image(&scene, &settings).counts.effect(Effect::Refraction));
    }
    assert!(rays[0] == 0 && rays.windows(2).all(|w| w[0] < w[1]), "{rays:?}");
}

#[test]
fn lights_in_awkward_places() {
    let corner = dvec3(-1.0, -1.0, 0.0);
    let places = [
        // in the plane of the triangle, at its corner, at the eye, within the ball, at its centre
        DVec3::ZERO,
        corner,
        camera().from,
        dvec3(1.2, 0.0, 0.3),
        dvec3(1.0, 0.0, 0.0),
    ];
    for position in places {
        for radius in [0.0, 1e-300, 0.5, 100.0] {
            let mut scene = Scene::new(format!("light at {position} of radius {radius}"));
            let m = scene.push_material(Material { specular: 0.3, ..Material::default() });
            let g = scene.push_material(glass(1.5));
            let rough = scene.push_material(Material {
                specular: 0.5,
                roughness: 1.0,
                ..Material::default()
            });
            scene.push_triangle(m, [corner, dvec3(1.0, -1.0, 0.0), dvec3(0.0, 1.5, 0.0)]);
            // a triangle without area, a ball without a radius
            scene.push_triangle(rough, [corner, corner, corner]);
            scene.push_sphere(g, dvec3(1.0, 0.0, 0.0), 0.5);
            scene.push_sphere(rough, dvec3(-1.0, 0.5, 0.5), 0.3);
            scene.push_sphere(rough, dvec3(-1.0, 0.5, 1.5), 0.0);
            scene.lights = vec![Light { position, color: None, radius }];
            scene.camera = Camera { aperture: 0.1, shutter: 1.0, ..camera() };
            scene.last_moves(DVec3::X);
            check(&scene, &settings([16, 16], samples(2)));
        }
    }
}
