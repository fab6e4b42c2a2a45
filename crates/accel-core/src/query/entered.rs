//! Maps trace steps to cells.
//!
//! A step is known by the primitives that it tests. Where several cells on the ray list just those,
//! or none, the ray's parameter decides: the counted traversal is asked again and again with a
//! nearer end of the ray's interval, until it is known from which end on it makes that many steps.

use std::collections::{HashMap, HashSet};

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::query::cells::{Cell, CellKind, NoCells};
use crate::query::trace::TraversalTrace;
use crate::query::tracer::Tracer;

/// A cell that a ray meets.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossedCell {
    /// Its box, world units.
    pub bounds: Aabb<f64>,
    /// 0 for the outermost.
    pub depth: u32,
    pub kind: CellKind,
    /// The primitives that it lists.
    pub ids: Vec<u32>,
    /// Between which parameters the ray is within its box.
    pub span: [f64; 2],
    /// The cell around it, by its place among all that are crossed.
    pub parent: Option<usize>,
}

/// The cells whose boxes a ray meets within its interval, hit or not, in the order of
/// [`Tracer::cells`].
///
/// # Errors
/// [`NoCells`].
pub fn crossed<S: Scalar>(
    tracer: &dyn Tracer<S>,
    ray: &Ray<S>,
) -> Result<Vec<CrossedCell>, NoCells> {
    // hierarchies of boxes are traversed from the ray's origin on
    let ray = Ray { t_min: ray.t_min.to_f64().min(0.0), ..ray.widened() };
    let mut all: Vec<CrossedCell> = Vec::new();
    // the cell that was crossed last at each depth; none where one was passed by since
    let mut around: Vec<Option<usize>> = Vec::new();
    tracer.cells(&mut |cell: Cell<'_>| {
        let depth = cell.depth as usize;
        around.truncate(depth);
        let parent = around.iter().rev().find_map(|cell| *cell);
        let span = span(&cell.bounds, &ray);
        around.resize(depth, None);
        around.push(span.map(|_| all.len()));
        if let Some(span) = span {
            let Cell { bounds, depth, kind, ids } = cell;
            all.push(CrossedCell { bounds, depth, kind, ids: ids.to_vec(), span, parent });
        }
    })?;
    Ok(all)
}

/// Parameter interval of a ray within a box, up to rounding.
fn span(bounds: &Aabb<f64>, ray: &Ray<f64>) -> Option<[f64; 2]> {
    if bounds.min.is_finite() && bounds.max.is_finite() {
        let from = ray.origin.abs().max_element();
        let margin = f64::from(f32::EPSILON) * 128.0 * bounds.magnitude().max(from);
        let bounds = bounds.expanded(margin);
        let clipped = bounds.clip(ray.origin, ray.direction, ray.t_min, ray.t_max);
        return clipped.map(|(t_in, t_out)| [t_in, t_out]);
    }
    Some([ray.t_min, ray.t_max])
}

/// For each step of a trace, the cells among those [`crossed`] that it is a step into: one, but for
/// structures that test primitives of several leaves at once; none for steps of a hierarchy, where
/// what was tested does not tell.
pub fn cells_entered<S: Scalar>(
    tracer: &dyn Tracer<S>,
    ray: &Ray<S>,
    trace: &TraversalTrace<S>,
    crossed: &[CrossedCell],
) -> Vec<Vec<usize>> {
    let mut by_list: HashMap<&[u32], Vec<usize>> = HashMap::new();
    let mut by_id: HashMap<u32, Vec<usize>> = HashMap::new();
    for (number, cell) in crossed.iter().enumerate() {
        if cell.kind != CellKind::Inner || !cell.ids.is_empty() {
            by_list.entry(&cell.ids).or_default().push(number);
        }
        for &id in &cell.ids {
            by_id.entry(id).or_default().push(number);
        }
    }
    let end = crossed.iter().filter(|c| c.kind != CellKind::Inner).map(|c| c.span[1]);
    let end = end.filter(|t| t.is_finite()).fold(ray.t_min.to_f64(), f64::max);
    let entries = Entries { tracer, ray, end };
    let mut parameters: Option<Vec<f64>> = None;
    let (mut used, mut elementary) = (HashSet::new(), 0);
    let mut found = Vec::with_capacity(trace.steps.len());
    for step in &trace.steps {
        let is_elementary = step.kind != CellKind::Inner;
        elementary += usize::from(is_elementary);
        let ids: Vec<u32> = step.tests.iter().map(|(id, _)| *id).collect();
        if !is_elementary && ids.is_empty() {
            found.push(Vec::new());
            continue;
        }
        let of_kind =
            |number: &&usize| (crossed[**number].kind != CellKind::Inner) == is_elementary;
        let listed = by_list.get(ids.as_slice()).into_iter().flatten().filter(of_kind);
        let alike: Vec<usize> = listed.copied().filter(|number| !used.contains(number)).collect();
        let cells = match alike.as_slice() {
            [] => {
                let mut cells: Vec<usize> =
                    ids.iter().filter_map(|id| by_id.get(id)).flatten().copied().collect();
                cells.sort_unstable();
                cells.dedup();
                cells
            }
            [only] => vec![*only],
            several if is_elementary => {
                let all = trace.counters.elementary_steps;
                let parameters = parameters.get_or_insert_with(|| entries.of(all));
                let t = parameters.get(elementary - 1).copied().unwrap_or(end);
                vec![at(several, crossed, t)]
            }
            [first, ..] => vec![*first],
        };
        used.extend(cells.iter().copied());
        found.push(cells);
    }
    found
}

/// The cell that the ray enters at a parameter: it is within it there, and longest from there on.
fn at(cells: &[usize], crossed: &[CrossedCell], t: f64) -> usize {
    let slack = f64::from(f32::EPSILON) * 16.0 * t.abs();
    let holds = |&&cell: &&usize| {
        let [t_in, t_out] = crossed[cell].span;
        t_in - slack <= t && t <= t_out + slack
    };
    let out = |cell: &&usize| crossed[**cell].span[1];
    let within = cells.iter().filter(holds).max_by(|a, b| out(a).total_cmp(&out(b)));
    let next = || cells.iter().min_by(|a, b| out(a).total_cmp(&out(b)));
    *within.or_else(next).unwrap_or(&0)
}

/// Asks a counted traversal with nearer ends.
struct Entries<'a, S: Scalar> {
    tracer: &'a dyn Tracer<S>,
    ray: &'a Ray<S>,
    end: f64,
}

impl<S: Scalar> Entries<'_, S> {
    /// Elementary steps of the ray that ends at `t`.
    fn steps_until(&self, t: f64) -> u64 {
        let ray = Ray { t_max: S::from_f64(t).lesser(self.ray.t_max), ..*self.ray };
        let mut hits = [Hit::NONE];
        self.tracer.count_closest_hits(&[ray], &mut hits).elementary_steps
    }

    /// For each of `n` elementary steps, the least end of the ray with which so many are made.
    fn of(&self, n: u64) -> Vec<f64> {
        let start = self.ray.t_min.to_f64();
        let mut found = vec![self.end; n as usize];
        let mut waiting = vec![(start, self.steps_until(start), self.end, n)];
        found.iter_mut().take(waiting[0].1 as usize).for_each(|t| *t = start);
        // between two ends that make `low` and `high` steps lie those after `low`, up to `high`
        while let Some((from, low, to, high)) = waiting.pop() {
            let middle = 0.5 * (from + to);
            let is_done = S::from_f64(middle).to_f64() <= S::from_f64(from).to_f64()
                || S::from_f64(middle).to_f64() >= S::from_f64(to).to_f64();
            if low >= high || is_done {
                let rest = found.iter_mut().take(high as usize).skip(low as usize);
                rest.for_each(|t| *t = to);
                continue;
            }
            let count = self.steps_until(middle).clamp(low, high);
            waiting.push((from, low, middle, count));
            waiting.push((middle, count, to, high));
        }
        found
    }
}
