//! What is drawn: the cells of a structure, elementary ones or those at a depth, and the surfaces of a
//! scene where a plane cuts them.

use accel_core::Aabb;
use accel_core::query::cells::{CellKind, NoCells};
use accel_core::query::tracer::Tracer;
use glam::DVec3;
use scene_loading::tessellate::{TessellationOptions, tessellate};
use scene_loading::{Scene, Shape, Sphere};

use crate::showing::view::Plane;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawnCell {
    pub bounds: Aabb<f64>,
    /// References in it, or below it.
    pub references: u64,
}

/// The cells of a structure that a plane cuts, or without one those that hold primitives: the
/// elementary ones or, with a depth, those at that depth and the elementary ones above.
pub fn cells(
    tracer: &dyn Tracer<f32>,
    plane: Option<&Plane>,
    depth: Option<u32>,
) -> Result<Vec<DrawnCell>, NoCells> {
    let mut all: Vec<DrawnCell> = Vec::new();
    // the cell that those below are part of
    let mut around: Option<usize> = None;
    tracer.cells(&mut |cell| {
        let references = cell.ids.len() as u64;
        let is_inner = cell.kind == CellKind::Inner;
        let is_drawn = match depth {
            // a voxel that holds grids may list primitives, too
            None => !is_inner || references > 0,
            Some(depth) if cell.depth > depth => {
                if let Some(around) = around.and_then(|i| all.get_mut(i)) {
                    around.references += references;
                }
                return;
            }
            Some(depth) => !is_inner || cell.depth == depth,
        };
        around = None;
        if is_drawn && plane.is_none_or(|plane| plane.cut(&cell.bounds).is_some()) {
            around = Some(all.len());
            all.push(DrawnCell { bounds: cell.bounds, references });
        }
    })?;
    all.retain(|cell| plane.is_some() || cell.references > 0);
    Ok(all)
}

/// Lines from point to point in a plane.
pub type Line = Vec<[f64; 2]>;

/// Section of all primitives by a plane. Cones and polygons of many corners are cut as triangles;
/// empty if a scene cannot be tessellated.
pub fn outline(scene: &Scene, plane: &Plane) -> Vec<Line> {
    let is_known =
        |shape: Shape| matches!(shape, Shape::Sphere(_)) || corners(scene, shape).is_some();
    let options = TessellationOptions::default();
    let is_tessellated = !scene.primitives.iter().all(|p| is_known(p.shape));
    let tessellated = is_tessellated.then(|| tessellate(scene, &options));
    let scene = match &tessellated {
        None => scene,
        Some(Ok(triangles)) => triangles,
        Some(Err(_)) => return Vec::new(),
    };
    (0..scene.primitives.len() as u32).filter_map(|id| outline_of(scene, id, plane)).collect()
}

/// Section of one primitive by a plane; empty for cones and polygons of many corners.
pub fn outline_of(scene: &Scene, id: u32, plane: &Plane) -> Option<Line> {
    let shape = scene.primitives.get(id as usize)?.shape;
    if let Shape::Sphere(i) = shape {
        let Sphere { center, radius } = scene.spheres.get(i as usize)?;
        let square = radius * radius - plane.distance(*center).powi(2);
        let ([x, y], r) = (plane.coordinates(*center), square.max(0.0).sqrt());
        let turn = |i: u32| std::f64::consts::TAU * f64::from(i) / 36.0;
        let point = |i| [x + turn(i).cos() * r, y + turn(i).sin() * r];
        return (square > 0.0).then(|| (0..=36).map(point).collect());
    }
    let corners = corners(scene, shape)?;
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    let mut met = edges.filter_map(|(&a, &b)| {
        // corners that are meant to be one lie on one side
        let distance = |p: DVec3| {
            let d = plane.distance(p);
            if d.abs() < 1e-9 * p.abs().max_element() { 0.0 } else { d }
        };
        let (from, to) = (distance(a), distance(b));
        let crosses = (from < 0.0) != (to < 0.0);
        crosses.then(|| plane.coordinates(a.lerp(b, from / (from - to))))
    });
    let first = met.next()?;
    Some(vec![first, met.last()?])
}

/// The corners of a triangle, or of a polygon of four.
fn corners(scene: &Scene, shape: Shape) -> Option<Vec<DVec3>> {
    let at = |i: u32| scene.vertices.get(i as usize).copied();
    match shape {
        Shape::Triangle { v } | Shape::Patch { v, .. } => v.into_iter().map(at).collect(),
        Shape::Polygon { first, count } if count <= 4 => (first..first + count).map(at).collect(),
        Shape::Polygon { .. } | Shape::Sphere(_) | Shape::Cone(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use scene_loading::Camera;

    use super::*;

    #[test]
    fn triangles_are_cut_to_lines_and_spheres_to_circles() {
        let mut scene = Scene::new("test");
        scene.push_triangle(0, [DVec3::ZERO, DVec3::X * 2.0, DVec3::new(0.0, 0.0, 2.0)]);
        scene.push_sphere(0, DVec3::new(5.0, 0.0, 3.0), 2.0);
        scene.push_triangle(0, [DVec3::Z * 9.0, DVec3::ONE * 9.0, DVec3::X + 9.0]);
        let camera =
            Camera { from: DVec3::NEG_Y, at: DVec3::ZERO, up: DVec3::Z, ..Camera::default() };
        let plane = Plane::at(2, 1.0, &camera);
        let all = outline(&scene, &plane);
        assert_eq!(all.len(), 1, "a plane that touches a sphere cuts nothing of it: {all:?}");
        let mut line = all[0].clone();
        line.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert_eq!(line, [[0.0, 0.0], [1.0, 0.0]]);
        let circle = outline_of(&scene, 1, &Plane::at(2, 2.0, &camera)).unwrap();
        let radius = |p: &[f64; 2]| (p[0] - 5.0).hypot(p[1]);
        assert!(circle.iter().all(|p| (radius(p) - 3f64.sqrt()).abs() < 1e-12));
        assert_eq!(circle.first().map(|p| p[0]), circle.last().map(|p| p[0]));
    }
}
