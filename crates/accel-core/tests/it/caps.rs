//! Every structure of the registry builds what is large, flat, uneven or repeated within a stated
//! memory cap, or says with a typed error which limit it would break. None takes the machine down.

use accel_core::primitives::{PrimSet, TriangleSet, Watertight};
use accel_core::structures::{BuildError, Entry, PrimsRef, REGISTRY};
use accel_core::{Hit, Ray};

type Corners = [[f32; 3]; 3];

/// The cap: so many bytes for a primitive, and so many for any scene.
const BYTES_A_PRIMITIVE: u64 = 640;
const BYTES_IN_ANY_CASE: u64 = 16 << 20;

/// A relief of 2 * side * side triangles over the unit square, `height` high.
fn relief(side: usize, height: f32, corner: [f32; 3], size: f32) -> Vec<Corners> {
    let point = |x: usize, y: usize| {
        let (u, v) = (x as f32 / side as f32, y as f32 / side as f32);
        let z = (u * 37.0).sin() * (v * 29.0).cos() * height;
        [corner[0] + u * size, corner[1] + v * size, corner[2] + z * size]
    };
    let mut triangles = Vec::with_capacity(2 * side * side);
    for y in 0..side {
        for x in 0..side {
            let [a, b, c, d] = [point(x, y), point(x + 1, y), point(x, y + 1), point(x + 1, y + 1)];
            triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    triangles
}

fn set(triangles: Vec<Corners>) -> TriangleSet<f32, Watertight> {
    TriangleSet::new(triangles, |_| false).unwrap()
}

/// Bytes of the structure, or the limit that it named.
fn build(entry: &Entry, set: &TriangleSet<f32, Watertight>) -> Result<u64, BuildError> {
    let tracer = entry.build(PrimsRef::Watertight(set), &entry.params([]).unwrap())?;
    // it can be asked, too: straight down into the middle
    let ray = Ray::new([0.5004, 0.5003, 10.0].into(), [0.0, 0.0, -1.0].into());
    let mut hit = [Hit::NONE];
    tracer.closest_hits(&[ray], &mut hit);
    assert!(hit[0].is_hit(), "{}", entry.info.name);
    Ok(tracer.shape().bytes)
}

/// Builds with the defaults of every structure; `refused` may answer with a limit.
fn all_build(scene: &str, triangles: Vec<Corners>) {
    let set = set(triangles);
    let cap = BYTES_A_PRIMITIVE * set.len() as u64 + BYTES_IN_ANY_CASE;
    for entry in REGISTRY {
        let name = entry.info.name;
        let start = std::time::Instant::now();
        match build(entry, &set) {
            Ok(bytes) => assert!(bytes <= cap, "{scene} {name}: {bytes} bytes, cap {cap}"),
            Err(BuildError::TooLarge { .. }) => {}
            Err(e) => panic!("{scene} {name}: {e}"),
        }
        // shown with --nocapture: which structure takes long
        println!("{scene} {name}: {:.2} s", start.elapsed().as_secs_f64());
    }
}

#[test]
fn a_million_triangles() {
    all_build("a million", relief(708, 0.05, [0.0; 3], 1.0));
}

#[test]
fn flat_scenes() {
    all_build("flat", relief(160, 0.0, [0.0; 3], 1.0));
}

#[test]
fn a_teapot_in_a_stadium() {
    let mut triangles = relief(2, 0.0, [-5000.0, -5000.0, 0.0], 10_000.0);
    triangles.extend(relief(160, 0.3, [0.5; 3], 0.001));
    all_build("stadium", triangles);
}

#[test]
fn ten_thousand_duplicates() {
    let one = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [1.0, 1.0, 0.5]];
    let mut triangles = vec![one; 10_000];
    triangles.extend(relief(2, 0.1, [0.0; 3], 1.0));
    all_build("duplicates", triangles);
}

#[test]
fn limits_are_typed_errors() {
    let set = set(relief(64, 0.05, [0.0; 3], 1.0));
    for entry in REGISTRY {
        for limit in ["max-cells", "max-references"] {
            if !entry.info.params.iter().any(|p| p.name == limit) {
                continue;
            }
            let params = entry.params([(limit, "5")]).unwrap();
            // a structure may also do with what it is given, by dividing less
            match entry.build(PrimsRef::Watertight(&set), &params) {
                Err(BuildError::TooLarge { structure, .. }) => {
                    assert_eq!(structure, entry.info.name);
                }
                Err(e) => panic!("{} {limit}: {e}", entry.info.name),
                Ok(tracer) => {
                    let shape = tracer.shape();
                    let held = if limit == "max-cells" { shape.cells } else { shape.references };
                    assert!(held <= 5, "{} {limit}: {held}", entry.info.name);
                }
            }
        }
    }
}
