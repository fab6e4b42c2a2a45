//! Structures side by side, their cells coloured by references on one scale, with a legend that
//! names it.

use accel_core::Aabb;
use accel_core::structure::StructureStats;
use presentation::drawing::{Classes, Color, Drawing, Font, Item, PLAIN, Paint, color, wrapped};
use presentation::svg_plot::pen::{BEST, GREY, INK, MARK};

use super::ray_path::PathThrough;
use super::sections::{DrawnCell, Line};
use super::view::{Plane, Projection};

/// Room around and between.
const MARGIN: f64 = 18.0;
/// Height of a line of text.
const TEXT: f64 = 16.0;
/// The ground of panels, on light and dark pages alike: colours of cells stand on it.
const GROUND: Color = [252, 252, 250];
/// Sides of empty cells.
const FAINT: Color = [205, 205, 205];
const SIDE: Color = [250, 250, 250];
const SURFACE: Color = [20, 20, 20];
/// Half the width of a number beside a ray.
const NUMBER: f64 = 9.0;

#[derive(Debug, Clone, PartialEq)]
pub struct DrawnStructure {
    pub label: String,
    pub stats: StructureStats,
    pub cells: Vec<DrawnCell>,
    pub path: Option<PathThrough>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum View<'a> {
    /// Cut by a plane, with what that cuts of the scene.
    Cut(Plane, &'a [Line]),
    Boxes(Projection),
}

#[derive(Debug, Clone, PartialEq)]
pub struct Frame<'a> {
    pub title: String,
    pub view: View<'a>,
    pub scene: Aabb<f64>,
    /// The part that panels show: left, lower, right, upper; all of the scene if it is not said.
    pub focus: Option<[f64; 4]>,
    /// The longer side of a panel, in pixels.
    pub size: f64,
    /// References that the darkest colour stands for; the most of any cell if it is not said.
    pub scale: Option<u64>,
}

/// Coordinates of a view as places in a panel.
struct ViewTransform {
    low: [f64; 2],
    high: [f64; 2],
    scale: f64,
}

impl ViewTransform {
    fn new(frame: &Frame<'_>) -> Self {
        let [left, low, right, high] = match (frame.focus, frame.view) {
            (Some(ends), _) => ends,
            (None, View::Cut(plane, _)) => plane.cut(&frame.scene).unwrap_or([0.0, 0.0, 1.0, 1.0]),
            (None, View::Boxes(projection)) => projection.ends(&frame.scene),
        };
        let longest = (right - left).max(high - low).max(f64::MIN_POSITIVE);
        let margin = 0.02 * longest;
        let (low, high) = ([left - margin, low - margin], [right + margin, high + margin]);
        Self { low, high, scale: frame.size / (longest + 2.0 * margin) }
    }

    fn size(&self) -> [f64; 2] {
        [0, 1].map(|k| (self.high[k] - self.low[k]) * self.scale)
    }

    fn point(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [(x - self.low[0]) * self.scale, (self.high[1] - y) * self.scale]
    }

    /// The visible part of a rectangle, as left, top, width and height.
    fn rectangle(&self, [left, low, right, high]: [f64; 4]) -> Option<[f64; 4]> {
        let clamped = |x: f64, k: usize| x.clamp(self.low[k], self.high[k]);
        let [x0, y0] = self.point([clamped(left, 0), clamped(high, 1)]);
        let [x1, y1] = self.point([clamped(right, 0), clamped(low, 1)]);
        (x1 > x0 && y1 > y0).then_some([x0, y0, x1 - x0, y1 - y0])
    }

    /// The visible parts of a line of several points.
    fn polyline(&self, line: &Line) -> Vec<Vec<[f64; 2]>> {
        line.windows(2).filter_map(|ends| self.line([ends[0], ends[1]])).collect()
    }

    /// The visible part of a line.
    fn line(&self, [a, b]: [[f64; 2]; 2]) -> Option<Vec<[f64; 2]>> {
        let (mut from, mut to) = (0.0f64, 1.0f64);
        for k in 0..2 {
            let along = b[k] - a[k];
            let ends = [(self.low[k] - a[k]) / along, (self.high[k] - a[k]) / along];
            if along == 0.0 {
                if a[k] < self.low[k] || a[k] > self.high[k] {
                    return None;
                }
                continue;
            }
            from = from.max(ends[0].min(ends[1]));
            to = to.min(ends[0].max(ends[1]));
        }
        let at = |t: f64| [0, 1].map(|k| a[k] + (b[k] - a[k]) * t);
        (from <= to).then(|| vec![self.point(at(from)), self.point(at(to))])
    }
}

/// The structures, from left to right and row by row, and the legend.
pub fn picture(frame: &Frame<'_>, structures: &[DrawnStructure]) -> Drawing {
    let placed = ViewTransform::new(frame);
    let [width, height] = placed.size();
    let columns = match structures.len() {
        n @ 0..=3 => n.max(1),
        4 => 2,
        _ => 3,
    };
    let cells = structures.iter().flat_map(|shown| &shown.cells);
    let most = cells.map(|cell| cell.references).max().unwrap_or(1).max(1);
    let classes = Classes::up_to(frame.scale.unwrap_or(most));
    let titles = |shown: &DrawnStructure| wrapped(&shown.label, width, 14.0);
    let notes = |shown: &DrawnStructure| {
        let path = shown.path.as_ref().map(|path| wrapped(&path.summary(), width, 12.0));
        [wrapped(&counted(shown), width, 12.0), path.unwrap_or_default()].concat()
    };
    let lines = |of: &dyn Fn(&DrawnStructure) -> Vec<String>| {
        structures.iter().map(|shown| of(shown).len()).max().unwrap_or(0) as f64
    };
    let head = TEXT * lines(&titles) + 6.0;
    let foot = TEXT * lines(&notes) + 6.0;
    let wide = (width + MARGIN) * columns as f64 - MARGIN;
    let mut drawing = Drawing { alternative: frame.title.clone(), ..Drawing::default() };
    let mut top = MARGIN;
    for line in wrapped(&frame.title, wide.max(300.0), 15.0) {
        top += TEXT + 2.0;
        drawing.text([MARGIN, top - 4.0], Font { size: 15.0, is_bold: true, ..PLAIN }, line);
    }
    top += 4.0;
    for (i, shown) in structures.iter().enumerate() {
        let left = MARGIN + (width + MARGIN) * (i % columns) as f64;
        let y = top + (head + height + foot + MARGIN) * (i / columns) as f64;
        // names stand just above their panels
        let titles = titles(shown);
        let begin = y + head - 6.0 - TEXT * titles.len() as f64;
        for (line, text) in (1..).zip(titles) {
            let font = Font { size: 14.0, is_bold: true, ..PLAIN };
            drawing.text([left, begin + TEXT * f64::from(line) - 2.0], font, text);
        }
        drawing.add(panel(frame, &placed, shown, classes), [left, y + head]);
        for (line, text) in (1..).zip(notes(shown)) {
            let font = Font { color: GREY, ..PLAIN };
            drawing.text([left, y + head + height + TEXT * f64::from(line)], font, text);
        }
    }
    let rows = structures.len().div_ceil(columns);
    let below = top + (head + height + foot + MARGIN) * rows as f64;
    let wide = wide.max(420.0);
    let has_path = structures.iter().any(|shown| shown.path.is_some());
    let is_exceeded = classes != Classes::up_to(most.max(frame.scale.unwrap_or(most)));
    let is_cut = matches!(frame.view, View::Cut(..));
    let shown = [is_cut, has_path, is_exceeded];
    let end = legend(&mut drawing, [MARGIN, below], wide, classes, shown);
    drawing.size = [wide + 2.0 * MARGIN, end + MARGIN];
    drawing
}

fn counted(shown: &DrawnStructure) -> String {
    let stats = &shown.stats;
    let inner = match stats.inner_cells {
        0 => String::new(),
        n => format!("{n} inner cells, "),
    };
    let cells = if stats.cells == 1 { "cell" } else { "cells" };
    format!(
        "{inner}{} {cells}, {} empty, {} references",
        stats.cells, stats.empty_cells, stats.references
    )
}

fn panel(
    frame: &Frame<'_>,
    placed: &ViewTransform,
    shown: &DrawnStructure,
    classes: Classes,
) -> Drawing {
    let [width, height] = placed.size();
    let ground = Paint { fill: Some((GROUND, 1.0)), stroke: Some((FAINT, 0.75)) };
    let mut drawing = Drawing::default();
    drawing.items.push(Item::Boxes(vec![[0.0, 0.0, width, height]], ground));
    match frame.view {
        View::Cut(plane, surfaces) => {
            sections(&mut drawing, placed, &shown.cells, &plane, classes);
            let surfaces = surfaces.iter().flat_map(|line| placed.polyline(line));
            lines(&mut drawing, surfaces.collect(), SURFACE, 0.7);
            if let Some(path) = &shown.path {
                overlay(&mut drawing, placed, path);
            }
        }
        View::Boxes(projection) => {
            boxes(&mut drawing, placed, &shown.cells, &projection, classes);
        }
    }
    drawing
}

fn lines(drawing: &mut Drawing, lines: Vec<Vec<[f64; 2]>>, color: Color, width: f64) {
    if !lines.is_empty() {
        let paint = Paint { fill: None, stroke: Some((color, width)) };
        drawing.items.push(Item::Lines { lines, are_closed: false, paint });
    }
}

/// Cells where the plane cuts them, large ones first: those of a hierarchy of boxes overlap, and
/// none hides a smaller one. Runs of one class are one item.
fn sections(
    drawing: &mut Drawing,
    placed: &ViewTransform,
    cells: &[DrawnCell],
    plane: &Plane,
    classes: Classes,
) {
    let cut = |cell: &DrawnCell| Some((plane.cut(&cell.bounds)?, cell.references));
    let mut all: Vec<([f64; 4], u64)> = cells.iter().filter_map(cut).collect();
    let area = |(s, _): &([f64; 4], u64)| (s[2] - s[0]) * (s[3] - s[1]);
    all.sort_by(|a, b| area(b).total_cmp(&area(a)));
    let class = |references: u64| (references > 0).then(|| classes.of(references));
    let mut visible: Vec<_> =
        all.iter().filter_map(|&(s, n)| Some((class(n), placed.rectangle(s)?))).collect();
    // cells that do not overlap can be drawn class by class
    let total: f64 = visible.iter().map(|(_, r)| r[2] * r[3]).sum();
    let [width, height] = placed.size();
    if total <= 1.001 * width * height {
        visible.sort_by_key(|(class, _)| *class);
    }
    for run in visible.chunk_by(|a, b| a.0 == b.0) {
        let boxes: Vec<[f64; 4]> = run.iter().map(|(_, r)| *r).collect();
        // sides do not hide what small cells hold
        let smallest = boxes.iter().map(|r| r[2].min(r[3])).fold(f64::INFINITY, f64::min);
        let side = (0.12 * smallest).clamp(0.08, 0.6);
        let paint = match run.first().and_then(|(class, _)| *class) {
            None => Paint { fill: None, stroke: Some((FAINT, side)) },
            Some(class) => {
                Paint { fill: Some((classes.color(class), 1.0)), stroke: Some((SIDE, side)) }
            }
        };
        drawing.items.push(Item::Boxes(boxes, paint));
    }
}

/// Boxes, far ones first, faces that are turned away darker.
fn boxes(
    drawing: &mut Drawing,
    placed: &ViewTransform,
    cells: &[DrawnCell],
    projection: &Projection,
    classes: Classes,
) {
    const SHADES: [f64; 3] = [1.0, 0.86, 0.74];
    let mut cells: Vec<&DrawnCell> = cells.iter().filter(|c| c.bounds.is_finite()).collect();
    let depth = |c: &&DrawnCell| projection.depth(0.5 * (c.bounds.min + c.bounds.max));
    cells.sort_by(|a, b| depth(b).total_cmp(&depth(a)));
    for cell in cells {
        let base = classes.color(classes.of(cell.references));
        for (axis, corners) in projection.faces(&cell.bounds) {
            let shade = SHADES[(axis + 1) % 3];
            let fill = base.map(|x| (f64::from(x) * shade) as u8);
            let paint = Paint { fill: Some((fill, 1.0)), stroke: Some((SURFACE, 0.15)) };
            let corners = corners.map(|p| placed.point(p)).to_vec();
            drawing.items.push(Item::Lines { lines: vec![corners], are_closed: true, paint });
        }
    }
}

fn overlay(drawing: &mut Drawing, placed: &ViewTransform, path: &PathThrough) {
    let outlined = |ends: &[[f64; 4]], color: Color, width: f64| {
        let boxes = ends.iter().filter_map(|ends| placed.rectangle(*ends)).collect();
        Item::Boxes(boxes, Paint { fill: None, stroke: Some((color, width)) })
    };
    let (mark, best, ink) = (color(MARK), color(BEST), SURFACE);
    drawing.items.push(outlined(&path.around, [110, 110, 110], 0.9));
    let entered: Vec<[f64; 4]> = path.entered.iter().map(|cell| cell.ends).collect();
    drawing.items.push(outlined(&entered, mark, 1.4));
    let visible = |line: &Line| placed.polyline(line);
    lines(drawing, path.missed.iter().flat_map(visible).collect(), mark, 2.2);
    lines(drawing, path.struck.iter().flat_map(visible).collect(), best, 3.2);
    if let Some(line) = placed.line(path.line) {
        lines(drawing, vec![line.clone()], [255; 3], 3.2);
        lines(drawing, vec![line.clone()], ink, 1.5);
        if let (Some(end), true) = (line.last(), path.hit.is_hit()) {
            let paint = Paint { fill: Some((best, 1.0)), stroke: Some(([255; 3], 1.2)) };
            drawing.items.push(Item::Disc { at: *end, radius: 4.2, paint });
        }
    }
    // numbers beside the ray, as far as there is room for them
    let [a, b] = path.line;
    let along = [b[0] - a[0], b[1] - a[1]];
    let length = along[0].hypot(along[1]).max(f64::MIN_POSITIVE);
    let aside = [along[1] / length, along[0] / length].map(|x| x * 1.35 * NUMBER);
    let aside = if aside[1] > 0.0 { aside.map(|x| -x) } else { aside };
    let [width, height] = placed.size();
    let mut taken: Vec<[f64; 2]> = Vec::new();
    for cell in &path.entered {
        let [x, y] = placed.point(cell.middle);
        let at = [x + aside[0], y + aside[1]];
        let is_inside =
            at[0] > NUMBER && at[0] < width - NUMBER && at[1] > NUMBER && at[1] < height - 4.0;
        let is_free = taken.iter().all(|t| (t[0] - at[0]).hypot(t[1] - at[1]) > 1.9 * NUMBER);
        if !is_inside || !is_free {
            continue;
        }
        taken.push(at);
        lines(drawing, vec![vec![[x, y], at]], ink, 0.5);
        let paint = Paint { fill: Some(([255; 3], 0.94)), stroke: Some((mark, 0.9)) };
        drawing.items.push(Item::Disc { at, radius: NUMBER, paint });
        let font = Font { size: 10.0, anchor: "middle", color: "#141414", ..PLAIN };
        drawing.text([at[0], at[1] + 3.6], font, cell.steps[0].to_string());
    }
}

/// The classes' colours, and what lines mean; where it ends. `is_exceeded` where a cell has more
/// references than the last class says.
fn legend(
    drawing: &mut Drawing,
    [left, top]: [f64; 2],
    wide: f64,
    classes: Classes,
    [is_cut, has_path, is_exceeded]: [bool; 3],
) -> f64 {
    let font = Font { size: 12.0, is_bold: true, ..PLAIN };
    let title = "references to primitives in a cell, one scale for all:";
    drawing.text([left, top + 11.0], font, title);
    let (mut x, mut y) = (left, top + TEXT + 6.0);
    let mut entry = |drawing: &mut Drawing, label: &str, paint: Paint| {
        let room = 24.0 + 7.0 * label.len() as f64 + 14.0;
        if x + room > left + wide {
            (x, y) = (left, y + TEXT + 6.0);
        }
        drawing.items.push(Item::Boxes(vec![[x, y, 18.0, 13.0]], paint));
        drawing.text([x + 24.0, y + 11.0], PLAIN, label);
        x += room;
    };
    let side = Some((color(GREY), 0.5));
    if is_cut {
        entry(drawing, "empty", Paint { fill: Some((GROUND, 1.0)), stroke: side });
    }
    for class in 0..classes.count() {
        let fill = Some((classes.color(class), 1.0));
        let is_open = is_exceeded && class + 1 == classes.count();
        let more = if is_open { " or more" } else { "" };
        entry(drawing, &(Classes::label(class) + more), Paint { fill, stroke: side });
    }
    let mut y = y + TEXT + 10.0;
    let of_surfaces = is_cut.then_some("black lines: surfaces of the scene");
    let of_path = has_path.then_some(
        "numbers: the step into a cell, in the order of the traversal; orange: cells entered and \
         primitives tested; grey: the inner cells around them; green: what is hit",
    );
    let words = of_surfaces.into_iter().chain(of_path);
    for line in words.flat_map(|words| wrapped(words, wide, 12.0)) {
        drawing.text([left, y + 11.0], Font { color: INK, ..PLAIN }, line);
        y += TEXT;
    }
    y
}
