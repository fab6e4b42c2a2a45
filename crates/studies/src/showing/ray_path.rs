//! One ray's way through a structure, in the plane that holds it.

use accel_core::query::cells::{CellKind, NoCells};
use accel_core::query::counters::WorkCounters;
use accel_core::query::entered::{cells_entered, crossed};
use accel_core::query::trace::{TestResult, TraceStep};
use accel_core::query::tracer::Tracer;
use accel_core::{Aabb, Hit, Ray, Scalar};
use scene_loading::Scene;

use super::sections::{Line, outline_of};
use super::view::Plane;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnteredCell {
    /// Numbers of the first and the last step into it, from 1.
    pub steps: [usize; 2],
    /// End points of the section.
    pub ends: [f64; 4],
    pub depth: u32,
    pub middle: [f64; 2],
}

/// A ray's way, as it is drawn and listed.
#[derive(Debug, Clone, PartialEq)]
pub struct PathThrough {
    /// The elementary cells entered, in the order of their first steps.
    pub entered: Vec<EnteredCell>,
    /// The inner cells that hold those.
    pub around: Vec<[f64; 4]>,
    /// Sections of primitives that were tested and not hit.
    pub missed: Vec<Line>,
    /// The same of the one that was hit.
    pub struck: Option<Line>,
    /// Start of the ray's interval, and its hit or a point far beyond the scene.
    pub line: [[f64; 2]; 2],
    /// The steps, and for each the depth of the cell entered where that is known.
    pub steps: Vec<(TraceStep, Option<u32>)>,
    pub hit: Hit<f32>,
    pub counters: WorkCounters,
}

pub fn path_through(
    tracer: &dyn Tracer<f32>,
    ray: &Ray<f32>,
    plane: &Plane,
    scene: &Scene,
) -> Result<PathThrough, NoCells> {
    // first: cells that are made on demand are there after it
    let way = tracer.trace(ray)?;
    let crossed = crossed(tracer, ray)?;
    let cells = cells_entered(tracer, ray, &way, &crossed);
    let wide = ray.widened();
    let last = if way.hit.is_hit() {
        way.hit.t.to_f64()
    } else {
        crossed.iter().map(|cell| cell.span[1]).filter(|t| t.is_finite()).fold(1.0, f64::max)
    };
    let mut entered: Vec<EnteredCell> = Vec::new();
    let mut known: Vec<usize> = Vec::new();
    let mut around: Vec<usize> = Vec::new();
    for (number, cells) in (1..).zip(&cells) {
        for &place in cells {
            if let Some(i) = known.iter().position(|&other| other == place) {
                entered[i].steps[1] = number;
                continue;
            }
            let cell = &crossed[place];
            let mut parent = cell.parent;
            while let Some(inner) = parent.filter(|inner| !around.contains(inner)) {
                around.push(inner);
                parent = crossed[inner].parent;
            }
            let Some(ends) = plane.cut(&cell.bounds) else { continue };
            let [t_in, t_out] = cell.span;
            let middle = 0.5 * (t_in.max(0.0) + t_out.min(last).max(t_in));
            known.push(place);
            entered.push(EnteredCell {
                steps: [number; 2],
                ends,
                depth: cell.depth,
                middle: plane.coordinates(wide.at(middle)),
            });
        }
    }
    let tests = || way.steps.iter().flat_map(|step| &step.tests);
    let mut ids: Vec<u32> =
        tests().filter(|(_, o)| *o != TestResult::Spared).map(|(id, _)| *id).collect();
    ids.sort_unstable();
    ids.dedup();
    let is_struck = |id: &u32| way.hit.is_hit() && *id == way.hit.id;
    let struck = ids.iter().find(|id| is_struck(id)).and_then(|&id| outline_of(scene, id, plane));
    let missed = ids.iter().filter(|id| !is_struck(id));
    let missed = missed.filter_map(|&id| outline_of(scene, id, plane)).collect();
    let depth_of = |cells: &Vec<usize>| cells.first().map(|&cell| crossed[cell].depth);
    let around = around.into_iter().filter_map(|inner| plane.cut(&crossed[inner].bounds)).collect();
    let line = [wide.t_min, last].map(|t| plane.coordinates(wide.at(t)));
    let depths = cells.iter().map(depth_of);
    let steps = way.steps.iter().cloned().zip(depths).collect();
    let (hit, counters) = (way.hit, way.counters);
    Ok(PathThrough { entered, around, missed, struck, line, steps, hit, counters })
}

/// A square around what a ray meets of a box until its hit, in the plane that holds it.
pub fn focus(plane: &Plane, ray: &Ray<f32>, scene: &Aabb<f64>, hit: &Hit<f32>) -> Option<[f64; 4]> {
    let ray = ray.widened();
    let (t_in, t_out) = scene.clip(ray.origin, ray.direction, ray.t_min, ray.t_max)?;
    let last = if hit.is_hit() { hit.t.to_f64().max(t_in) } else { t_out };
    let ends = [t_in, last].map(|t| plane.coordinates(ray.at(t)));
    let middle = [0, 1].map(|k| 0.5 * (ends[0][k] + ends[1][k]));
    let longest = [0, 1].map(|k| (ends[0][k] - ends[1][k]).abs()).into_iter().fold(0.0, f64::max);
    let half = (0.68 * longest).max(0.03 * scene.size().max_element());
    let [x, y] = middle;
    Some([x - half, y - half, x + half, y + half])
}

impl PathThrough {
    /// In a few words: steps, tests, the hit.
    pub fn summary(&self) -> String {
        let c = &self.counters;
        let inner = c.traversal_steps - c.elementary_steps;
        let hit = if self.hit.is_hit() {
            format!("hits primitive {}", self.hit.id)
        } else {
            "no hit".to_owned()
        };
        let spared = match c.tests_saved {
            0 => String::new(),
            n => format!(" ({n} spared)"),
        };
        format!(
            "{} steps (inner {inner}, leaf {}, empty {}); {} tests{spared}; {hit}",
            c.traversal_steps,
            c.elementary_steps - c.empty_elementary_steps,
            c.empty_elementary_steps,
            c.intersection_tests,
        )
    }

    /// Cells entered in each step and primitives tested: spared ones in brackets, hits with a star.
    pub fn listed(&self) -> Vec<[String; 4]> {
        let row = |(number, (step, depth)): (usize, &(TraceStep, Option<u32>))| {
            let kind = match step.kind {
                CellKind::Inner => "inner",
                CellKind::Leaf => "leaf",
                CellKind::Empty => "empty",
            };
            let test = |(id, outcome): &(u32, TestResult)| match outcome {
                TestResult::Missed => id.to_string(),
                TestResult::Hit => format!("{id}*"),
                TestResult::Spared => format!("({id})"),
            };
            let tests: Vec<String> = step.tests.iter().map(test).collect();
            let depth = depth.map_or("-".to_owned(), |depth| depth.to_string());
            [number.to_string(), kind.to_owned(), depth, tests.join(" ")]
        };
        (1..).zip(&self.steps).map(row).collect()
    }
}
