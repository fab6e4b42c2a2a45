//! Cells of a primitive: by its box or by itself, with and without a margin.
//!
//! The points that are judged lie on primitives exactly: corners, points of edges and inner points
//! of triangles whose weights are 16ths, the six extreme points of spheres, corners of polygons.
//! Every other point of a triangle lies where an edge of it crosses a cell plane, but for rounding,
//! as hit points do. A point is wrong when its cell does not list the primitive: the cell that the
//! traversal in single precision takes it to be in, and for points that are exact the cell by exact
//! arithmetic.

use accel_core::grid::voxel_traversal::GridFrame;
use accel_core::params::config::Settings;
use accel_core::primitives::{Ball, PrimitiveKind, Primitives};
use accel_core::structure::Structure;
use accel_core::structures::uniform_grid::UniformGrid;
use accel_core::{Aabb, Vec3, Vector};
use glam::DVec3;
use measurement::plan::rows::Row;
use statistics::random::Random;

use crate::accuracy::axis::*;

pub static AXIS: Axis = Axis {
    name: "cell-insertion",
    summary: "cells of a primitive: of its box or those it overlaps, with and without a margin",
    paper: "Akenine-Moeller 2001; Arvo 1990",
    metric: "points of primitives in 10^6 whose cell does not list the primitive",
    reference: "points that lie on primitives exactly",
    scenes: &["teapot", "mount", "pavilion"],
    setting: "uniform-grid.insertion",
    measure: Measure::Whole(measure),
};

const INSERTIONS: [&str; 4] = ["box", "padded-box", "exact", "padded-exact"];

fn measure(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let settings = INSERTIONS.map(|i| (i, format!("uniform-grid:density=8:insertion={i}")));
    let geometry = &stage.prepared.geometry;
    let said = SceneOutcome::new(
        "of the scene through a grid of 8 cells per primitive",
        format!("{} points that lie on primitives", stage.trials()),
    );
    timed_settings(stage, &settings, "padded-box", &stage.all_batches(), said, |i, built, _| {
        let tally = judged(stage, geometry.prims().primitives(), &settings[i].1)?;
        let references = built.tracer.stats().references as f64 / geometry.len().max(1) as f64;
        let mut figures = vec![("references a primitive", references)];
        figures.extend(built.columns());
        Ok((tally.error(), figures))
    })
}

/// Points whose cells do not list their primitives.
fn judged(
    stage: &Stage<'_>,
    set: &dyn Primitives<f32>,
    label: &str,
) -> Result<TrialCounts, StudyError> {
    let row = Row::parse(stage.registry, label)?;
    let settings = Settings::of(&row.params);
    let grid = UniformGrid::<f32>::build(set, &settings).map_err(|e| stage.refused(e))?;
    let frame = grid.frame();
    let wide = frame.in_double();
    let mut random = stage.random("points");
    let (mut tally, mut balls) = (TrialCounts::default(), Vec::new());
    for _ in 0..stage.trials() {
        let id = random.below(set.len()) as u32;
        let Some(point) = point_on(set, id, &mut random, &mut balls) else { continue };
        let crossing = (random.below(2) == 0)
            .then(|| crossing(&wide, set.kind(id), &balls, &mut random))
            .flatten();
        let rounded = Vec3::<f32>::from_dvec3(crossing.unwrap_or(point));
        let (as_traversed, _) = frame.range(&Aabb { min: rounded, max: rounded });
        let (exactly, _) = wide.range(&Aabb { min: point, max: point });
        let lists = |cell| grid.list(cell).contains(&id);
        tally.add(!lists(as_traversed) || (crossing.is_none() && !lists(exactly)));
    }
    Ok(tally)
}

/// Point at which an edge of a triangle crosses a cell plane, if any.
fn crossing(
    frame: &GridFrame<f64>,
    kind: PrimitiveKind,
    corners: &[Ball],
    random: &mut Random,
) -> Option<DVec3> {
    let (PrimitiveKind::Triangle, [a, b, c]) = (kind, corners) else { return None };
    let ends = [(a, b), (b, c), (c, a)];
    let (a, b) = ends.get(random.below(3)).map(|(p, q)| (p.center, q.center))?;
    let k = random.below(3);
    let (low, cell) = (frame.bounds().min[k], frame.cell_size()[k]);
    let [first, last] = [a[k].min(b[k]), a[k].max(b[k])].map(|x| (x - low) / cell);
    let planes = (last.floor() - first.floor()) as usize;
    let plane = first.floor() + 1.0 + random.below(planes.max(1)) as f64;
    let part = (low + plane * cell - a[k]) / (b[k] - a[k]);
    (planes > 0 && (0.0..=1.0).contains(&part)).then(|| a + (b - a) * part)
}

/// A point of the primitive that f64 holds exactly; none for cones.
fn point_on(
    set: &dyn Primitives<f32>,
    id: u32,
    random: &mut Random,
    balls: &mut Vec<Ball>,
) -> Option<DVec3> {
    balls.clear();
    set.hull(id, balls);
    match (set.kind(id), balls.as_slice()) {
        (PrimitiveKind::Triangle, [a, b, c]) => {
            let i = random.below(17);
            let j = random.below(17 - i);
            let [i, j, k] = [i, j, 16 - i - j].map(|n| n as f64 / 16.0);
            Some(a.center * i + b.center * j + c.center * k)
        }
        (PrimitiveKind::Sphere, [ball]) => {
            let axis = [DVec3::X, DVec3::Y, DVec3::Z][random.below(3)];
            let sign = if random.below(2) == 0 { 1.0 } else { -1.0 };
            Some(ball.center + axis * (sign * ball.radius))
        }
        (PrimitiveKind::Polygon, corners) => {
            corners.get(random.below(corners.len())).map(|b| b.center)
        }
        _ => None,
    }
}
