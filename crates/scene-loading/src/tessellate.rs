//! Turns every primitive of a scene into triangles, for structures that know nothing else.
//!
//! At resolution `n`, a sphere has `n^2` quadrilaterals on each of the six faces of the cube that is
//! projected onto it, a cone has `4 n` segments around. A sphere gives `12 n^2` triangles, a cone or
//! cylinder `8 n` (`4 n` if it has a tip), a polygon of `k` vertices `k - 2`, a triangle or patch
//! itself.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::DVec3;
use serde::Deserialize;

pub use crate::polygon::ear_clipping::{SelfCrossing, triangulate};
use crate::scene::{Cone, Scene, Shape, Sphere};

/// How finely curved primitives become triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Tessellate", deny_unknown_fields)]
pub struct TessellationOptions {
    /// The tessellator's resolution, at least 1.
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    pub resolution: u32,
}

impl Default for TessellationOptions {
    fn default() -> Self {
        Self { resolution: 4 }
    }
}

/// The most triangles, and the most vertices, of a result: as of loaders.
const MOST: u64 = 64 << 20;

/// Why a scene cannot be tessellated.
#[allow(missing_docs, reason = "the message of a variant says what its fields are")]
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TessellationError {
    /// The resolution is 0.
    #[error("the tessellation resolution must be at least 1")]
    ZeroResolution,
    /// The result would have more triangles or vertices than any loader accepts.
    #[error(
        "tessellated at resolution {resolution}, the scene would have {triangles} triangles; \
         at most {MOST} are accepted"
    )]
    TooLarge { resolution: u32, triangles: u64 },
    /// A polygon is not cut up.
    #[error("primitive {primitive} is {source}")]
    Entangled { primitive: usize, source: SelfCrossing },
}

/// Converts the scene to triangles.
///
/// The result has the same view, lights, materials and name; its triangles are in the order of
/// the primitives they come from and keep their materials. Spheres and cones become flat
/// triangles inscribed in them, with shared vertices, that face outward (inward for negative
/// radii, as the cones themselves); cones stay open. Polygons, concave ones too, are
/// cut up between their own vertices and keep their orientation. Triangles and patches (with their
/// normals) stay as they are.
///
/// Primitives without area give no triangles but a warning in [`Scene::warnings`].
///
/// # Errors
/// [`TessellationError`] when the resolution is 0 or the result would be too large.
pub fn tessellate(
    scene: &Scene,
    options: &TessellationOptions,
) -> Result<Scene, TessellationError> {
    let n = options.resolution;
    if n == 0 {
        return Err(TessellationError::ZeroResolution);
    }
    let [triangles, vertices] = check_size(scene, n)?;
    let mut out = Scene {
        spheres: Vec::new(),
        cones: Vec::new(),
        primitives: Vec::new(),
        velocities: Vec::new(),
        texcoords: Vec::new(),
        ..scene.clone()
    };
    // without room made at once, a list that grows has up to twice what it needs
    out.primitives.reserve_exact(triangles as usize);
    out.vertices.reserve_exact((vertices as usize).saturating_sub(scene.vertices.len()));
    let ball = if scene.spheres.is_empty() { Default::default() } else { unit_sphere(n) };
    for (id, &primitive) in scene.primitives.iter().enumerate() {
        let material = primitive.material;
        let before = out.primitives.len();
        match primitive.shape {
            Shape::Sphere(i) => {
                let Sphere { center, radius } = scene.spheres[i as usize];
                if radius != 0.0 {
                    let positions = ball.0.iter().map(|&p| center + p * radius.abs());
                    out.push_mesh(material, positions, ball.1.iter().copied());
                }
            }
            Shape::Cone(i) => push_cone(&mut out, material, n, scene.cones[i as usize]),
            Shape::Polygon { first, count } => {
                let outline = &scene.vertices[first as usize..][..count as usize];
                let pieces = triangulate(outline)
                    .map_err(|source| TessellationError::Entangled { primitive: id, source })?;
                for piece in pieces {
                    out.push_corners(material, piece.map(|i| first + i), None);
                }
            }
            Shape::Triangle { .. } | Shape::Patch { .. } => out.primitives.push(primitive),
        }
        if out.primitives.len() == before {
            out.warn(format!("primitive {id} has no area and was left out"));
        }
        if let Some(corners) = scene.texcoords_of(id as u32) {
            // only triangles have them, and those stay as they are
            out.last_is_textured(corners);
        }
        out.moves_since(before, scene.velocity(id as u32));
    }
    Ok(out)
}

/// The most triangles and vertices that the result may have. Refuses what is too large, before
/// anything is allocated.
fn check_size(scene: &Scene, n: u32) -> Result<[u64; 2], TessellationError> {
    let n = u64::from(n);
    let (mut triangles, mut vertices) = (0_u64, scene.vertices.len() as u64);
    for primitive in &scene.primitives {
        let (t, v) = match primitive.shape {
            Shape::Sphere(_) => {
                (12_u64.saturating_mul(n * n), 6_u64.saturating_mul(n * n).saturating_add(2))
            }
            Shape::Cone(_) => (8 * n, 8 * n),
            Shape::Polygon { count, .. } => (u64::from(count).saturating_sub(2), 0),
            Shape::Triangle { .. } | Shape::Patch { .. } => (1, 0),
        };
        triangles = triangles.saturating_add(t);
        vertices = vertices.saturating_add(v);
    }
    if triangles.max(vertices) > MOST {
        let resolution = u32::try_from(n).unwrap_or(u32::MAX);
        return Err(TessellationError::TooLarge { resolution, triangles });
    }
    Ok([triangles, vertices])
}

fn push_cone(out: &mut Scene, material: u32, n: u32, cone: Cone) {
    let Some(axis) = (cone.apex - cone.base).try_normalize() else { return };
    let (x, y) = axis.any_orthonormal_pair();
    let inward = cone.base_radius < 0.0 || cone.apex_radius < 0.0;
    let segments = 4 * n;
    let mut rim = |center: DVec3, radius: f64| {
        // `check_size` has made sure that it fits
        let first = out.vertices.len() as u32;
        let count = if radius == 0.0 { 1 } else { segments };
        out.vertices.extend((0..count).map(|i| {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(segments)).sin_cos();
            center + (x * cos + y * sin) * radius.abs()
        }));
        move |i: u32| first + i % count
    };
    let base = rim(cone.base, cone.base_radius);
    let apex = rim(cone.apex, cone.apex_radius);
    for i in 0..segments {
        let (low, low_next) = (base(i), base(i + 1));
        let (high, high_next) = (apex(i), apex(i + 1));
        for (degenerate, [a, b, c]) in [
            (low == low_next, [low, low_next, high_next]),
            (high == high_next, [low, high_next, high]),
        ] {
            if !degenerate {
                out.push_corners(material, if inward { [a, c, b] } else { [a, b, c] }, None);
            }
        }
    }
}

/// Vertices and triangles of the unit sphere: a cube with `n` by `n` squares on each face, projected
/// from its centre. Faces share the vertices on their common edges.
fn unit_sphere(n: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    // by their place in the cube's grid, 0 to n on each axis
    let mut known = HashMap::new();
    let mut vertex = |grid: [u32; 3]| {
        *known.entry(grid).or_insert_with(|| {
            let p = grid.map(|i| 2.0 * f64::from(i) / f64::from(n) - 1.0);
            vertices.push(DVec3::from_array(p).normalize());
            vertices.len() as u32 - 1
        })
    };
    for (axis, level) in (0..3).flat_map(|axis| [(axis, 0), (axis, n)]) {
        for (u, v) in (0..n).flat_map(|u| (0..n).map(move |v| (u, v))) {
            let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(du, dv)| {
                let mut grid = [level; 3];
                grid[(axis + 1) % 3] = u + du;
                grid[(axis + 2) % 3] = v + dv;
                vertex(grid)
            });
            let [a, b, c, d] =
                if level == 0 { [0, 3, 2, 1] } else { [0, 1, 2, 3] }.map(|i| corners[i]);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    (vertices, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedural::generate;

    fn tessellated(spec: &str, resolution: u32) -> Scene {
        tessellate(&generate(spec).unwrap(), &TessellationOptions { resolution }).unwrap()
    }

    fn corners(scene: &Scene, shape: Shape) -> [DVec3; 3] {
        scene.outline(shape).try_into().unwrap()
    }

    fn area([a, b, c]: [DVec3; 3]) -> DVec3 {
        (b - a).cross(c - a) * 0.5
    }

    #[test]
    fn counts_follow_the_rule() {
        // The first three are what other tessellators that follow the same rule report.
        for (spec, resolution, triangles) in [
            ("gears:8", 2, 292_866),
            ("tree:11", 4, 917_282),
            ("balls:4", 4, 1_417_154),
            ("lattice:2", 1, 27 * 12 + 54 * 8),
            ("teapot:2", 4, 240 + 8),
        ] {
            let scene = tessellated(spec, resolution);
            assert_eq!(scene.primitives.len(), triangles, "{spec}");
            assert!(scene.is_triangles_only());
            assert!(scene.warnings.is_empty());
        }
    }

    #[test]
    fn polygons_keep_their_area_and_side() {
        let scene = generate("gears:2").unwrap();
        let cut = tessellate(&scene, &TessellationOptions::default()).unwrap();
        let mut triangles = cut.primitives.iter();
        for (id, primitive) in scene.primitives.iter().enumerate() {
            let outline = scene.outline(primitive.shape);
            let next = outline.iter().cycle().skip(1);
            let whole: DVec3 = outline.iter().zip(next).map(|(a, b)| a.cross(*b) * 0.5).sum();
            let (mut sum, mut vector) = (0.0, DVec3::ZERO);
            for part in triangles.by_ref().take(outline.len() - 2) {
                assert_eq!(part.material, primitive.material);
                let area = area(corners(&cut, part.shape));
                sum += area.length();
                vector += area;
            }
            assert!((sum - whole.length()).abs() < 1e-13, "polygon {id}: {sum} {whole}");
            assert!((vector - whole).length() < 1e-13, "polygon {id}: {vector} {whole}");
        }
        assert_eq!(triangles.count(), 0);
    }

    #[test]
    fn spheres_are_closed_and_face_outward() {
        let (mut scene, material) = Scene::of_one_material("ball");
        let center = DVec3::new(1.0, 2.0, 3.0);
        scene.push_sphere(material, center, 2.0);
        for n in [1, 2, 3, 7] {
            let cut = tessellate(&scene, &TessellationOptions { resolution: n }).unwrap();
            let n = n as usize;
            assert_eq!(cut.primitives.len(), 12 * n * n);
            assert_eq!(cut.vertices.len(), 6 * n * n + 2);
            assert!(cut.vertices.iter().all(|v| ((*v - center).length() - 2.0).abs() < 1e-14));
            let mut edges = std::collections::HashSet::new();
            for primitive in &cut.primitives {
                let Shape::Triangle { v: [a, b, c] } = primitive.shape else { panic!() };
                assert!(edges.insert((a, b)) && edges.insert((b, c)) && edges.insert((c, a)));
                let t = corners(&cut, primitive.shape);
                assert!(area(t).dot(t[0] - center) > 0.0);
            }
            assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))));
        }
    }

    #[test]
    fn cones_are_open_strips_that_face_their_side() {
        let base = DVec3::new(1.0, 0.0, 0.0);
        let apex = DVec3::new(1.0, 2.0, 2.0);
        let axis = (apex - base).normalize();
        for (base_radius, apex_radius, per_segment) in
            [(0.5, 0.25, 2), (0.5, 0.5, 2), (0.5, 0.0, 1), (0.0, 0.5, 1), (-0.5, -0.25, 2)]
        {
            let (mut scene, material) = Scene::of_one_material("cone");
            scene.push_cone(material, Cone { base, base_radius, apex, apex_radius });
            let cut = tessellate(&scene, &TessellationOptions { resolution: 3 }).unwrap();
            assert_eq!(cut.primitives.len(), 12 * per_segment);
            assert_eq!(cut.vertices.len(), if per_segment == 2 { 24 } else { 13 });
            let side = if base_radius + apex_radius < 0.0 { -1.0 } else { 1.0 };
            for primitive in &cut.primitives {
                let t = corners(&cut, primitive.shape);
                let middle = (t[0] + t[1] + t[2]) / 3.0 - base;
                let outward = middle - axis * middle.dot(axis);
                assert!(area(t).dot(outward) * side > 0.0);
            }
        }
    }

    #[test]
    fn shapes_without_area_are_left_out_with_a_warning() {
        let (mut scene, material) = Scene::of_one_material("odd");
        scene.push_sphere(material, DVec3::ZERO, 0.0);
        let point = Cone { base: DVec3::ONE, base_radius: 1.0, apex: DVec3::ONE, apex_radius: 1.0 };
        scene.push_cone(material, point);
        scene.push_polygon(material, &[DVec3::ZERO, DVec3::X, DVec3::X * 2.0]);
        scene.push_triangle(material, [DVec3::ZERO, DVec3::X, DVec3::Y]);
        let cut = tessellate(&scene, &TessellationOptions::default()).unwrap();
        assert_eq!(cut.primitives.len(), 1);
        assert_eq!(cut.warnings.len(), 3);
    }

    #[test]
    fn impossible_resolutions_are_errors() {
        let scene = generate("balls:1").unwrap();
        for (resolution, expected) in [(0, "at least 1"), (20_000, "48000000002"), (u32::MAX, "")] {
            let options = TessellationOptions { resolution };
            let error = tessellate(&scene, &options).unwrap_err();
            assert!(error.to_string().contains(expected), "{error}");
        }
    }
}
