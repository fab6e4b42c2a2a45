//! Sheets of triangles, on which layers are found, against brute force; and sheets that leak.

use glam::{DVec2, DVec3, dvec2, dvec3};

use crate::occluders::find;
use crate::occluders::light_buffer::layers::Layers;
use crate::occluders::light_buffer::margins::Margins;
use crate::occluders::light_buffer::*;
use crate::params::config::Settings;
use crate::primitives::{Ball, TriangleSet};
use crate::structures::test_scenes::{Random, occlusions};

/// Cells of a sheet along x and y.
const SIDE: u32 = 24;

type Corners<S> = [[S; 3]; 3];

/// A bumpy sheet over [-1, 1] x [-1, 1] at that height; its triangles share their corners.
fn sheet<S: Scalar>(height: f64, bumps: f64, out: &mut Vec<Corners<S>>) {
    let mut random = Random(4);
    let mut corners = Vec::new();
    for i in 0..(SIDE + 1) * (SIDE + 1) {
        let inner = |k: u32| (1..SIDE).contains(&k);
        let (x, y) = (i % (SIDE + 1), i / (SIDE + 1));
        let mut shift = || if inner(x) && inner(y) { random.unit() * 0.6 - 0.3 } else { 0.0 };
        let on = |k: u32, by: f64| (f64::from(k) + by) * 2.0 / f64::from(SIDE) - 1.0;
        let p = dvec3(on(x, shift()), on(y, shift()), height + shift() * bumps);
        corners.push(Vec3::<S>::from_dvec3(p).to_array());
    }
    for i in 0..SIDE * SIDE {
        let (x, y) = (i % SIDE, i / SIDE);
        let at = |dx: u32, dy: u32| corners[((y + dy) * (SIDE + 1) + x + dx) as usize];
        // turned this way and that
        out.push([at(0, 0), at(1, 0), at(1, 1)]);
        out.push([at(0, 0), at(0, 1), at(1, 1)]);
    }
}

/// Two sheets one above the other, a triangle on edge before them and one without area.
fn sheets<S: Scalar>() -> Vec<Corners<S>> {
    let mut all = Vec::new();
    sheet(0.0, 0.1, &mut all);
    sheet(-0.5, 0.4, &mut all);
    let point = |x: f64, y: f64, z: f64| [x, y, z].map(S::from_f64);
    all.push([point(0.1, 0.1, 0.2), point(0.1, 0.6, 0.2), point(0.1, 0.1, 0.5)]);
    all.push([point(0.0, 0.0, 0.3), point(0.1, 0.1, 0.3), point(0.2, 0.2, 0.3)]);
    all
}

fn rays<S: Scalar>(triangles: &[Corners<S>], light: DVec3, n: usize) -> Vec<Ray<S>> {
    let mut random = Random(8);
    let mut rays = Vec::new();
    for i in 0..n {
        let of = |k: usize| {
            let triangle = triangles[(i * 7) % triangles.len()];
            Vec3::<S>::from_array(triangle[k % 3]).to_dvec3()
        };
        // behind corners and edges of the sheets, on them, and anywhere below
        let from = match i % 4 {
            0 => of(i) + (of(i) - light) * (0.1 / (of(i) - light).length()),
            1 => {
                let p = of(i).lerp(of(i + 1), random.unit());
                p + (p - light) * (0.02 / (p - light).length())
            }
            2 => (of(0) + of(1) + of(2)) / 3.0,
            _ => dvec3(random.unit() * 2.4 - 1.2, random.unit() * 2.4 - 1.2, -1.5 * random.unit()),
        };
        let (distance, direction) = ((light - from).length(), (light - from).normalize());
        let (from, direction) = (Vec3::<S>::from_dvec3(from), Vec3::<S>::from_dvec3(direction));
        let mut ray = Ray::<S>::new(from, direction);
        ray.t_max = S::from_f64(distance);
        ray.t_min = S::from_f64(if i % 3 == 0 { 0.0 } else { 1e-4 });
        rays.push(ray);
    }
    rays
}

/// How many of the rays are answered otherwise than by brute force, how many lists are cut off,
/// and how many triangles were tested.
fn compared<S: Buildable>(
    triangles: Vec<Corners<S>>,
    light: DVec3,
    settings: &str,
) -> (usize, u64, u64) {
    let rays = rays(&triangles, light, 1500);
    let set = TriangleSet::<S>::new(triangles, |_| false).unwrap();
    let any = PrimsRef::Watertight(&set);
    let pairs = settings.split_whitespace().filter_map(|s| s.split_once('='));
    let params = find(INFO.name).unwrap().params(pairs).unwrap();
    let buffer = LightBuffer::new(&set, any, &[light], &Settings::of(&params)).unwrap();
    let entry = crate::structures::find("brute-force").unwrap();
    let right = entry.build(any, &entry.params([]).unwrap()).unwrap();
    let a = occlusions(&*right, &rays);
    // what is not written is wrong
    let mut b: Vec<bool> = a.iter().map(|blocked| !blocked).collect();
    buffer.occlusions(&rays, &vec![0; rays.len()], &mut b);
    let work = buffer.count_occlusions(&rays, &vec![0; rays.len()], &mut vec![false; rays.len()]);
    let wrong = a.iter().zip(&b).filter(|(a, b)| a != b).count();
    (wrong, buffer.cells.tally.covered, work.intersection_tests)
}

fn agrees<S: Buildable>() {
    let lights = [
        dvec3(0.2, 0.1, 2.0),
        dvec3(3.0, -2.0, 1.0),
        dvec3(3000.0, -2000.0, 4000.0),
        dvec3(0.0, 0.0, 0.05),
        dvec3(0.3, 0.2, -0.2),
    ];
    for light in lights {
        // wide cells, which no triangle covers
        let whole = "resolution=64 divide=40 longest=1000000";
        let (wrong, covered, tests) = compared(sheets::<S>(), light, whole);
        assert_eq!(wrong, 0, "{} {light}", S::NAME);
        let (_, none, more) = compared(sheets::<S>(), light, &format!("{whole} cut-off=none"));
        assert_eq!(none, 0);
        // seen from the side, sheets are too uneven to hide much
        let is_above = light.z == 2.0;
        assert!(!is_above || covered > 20 && tests * 5 < more * 4, "{covered} {tests} {more}");
        // planted holes: what is not there hides nothing
        let torn: Vec<_> = sheets().into_iter().enumerate().filter(|(i, _)| i % 11 != 0).collect();
        let torn = torn.into_iter().map(|(_, t)| t).collect();
        let (wrong, ..) = compared::<S>(torn, light, whole);
        assert_eq!(wrong, 0, "{} {light} with holes", S::NAME);
    }
}

#[test]
fn layers_hide_what_brute_force_finds_hidden() {
    agrees::<f32>();
    agrees::<f64>();
}

/// Two triangles that make a square of half extent 1 at a depth of 2, the second one's corners on
/// the shared edge moved.
fn square(by: DVec3) -> Option<f64> {
    let at = |x: f64, y: f64| dvec3(x, y, 2.0);
    let triangles =
        [[at(-1., -1.), at(1., -1.), at(1., 1.)], [at(-1., -1.) + by, at(1., 1.), at(-1., 1.)]];
    let margins = Margins::new::<f32>(2.0);
    let balls = |t: [DVec3; 3]| t.map(|center| Ball { center, radius: margins.position });
    let triangles = triangles.into_iter().map(|t| (t, balls(t)));
    let (center, half) = (dvec2(0.01, 0.03), DVec2::splat(0.1));
    Layers::default().hidden_beyond(triangles, center, half, &margins)
}

#[test]
fn a_seam_that_does_not_close_is_caught() {
    let whole = square(DVec3::ZERO);
    assert!(whole.is_some_and(|far| (2.0..2.001).contains(&far)), "{whole:?}");
    // planted fault: one corner off by the last place of an f32
    assert_eq!(square(dvec3(f64::from(f32::EPSILON), 0.0, 0.0)), None);
    assert_eq!(square(DVec3::NAN), None);
}
