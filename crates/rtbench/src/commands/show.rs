//! `rtbench show`: pictures of structures, and one ray's way through them.

use std::path::Path;

use accel_core::query::cells::NoCells;
use accel_core::{Aabb, Ray, Vector};
use glam::{DVec2, DVec3};
use renderer::Geometry;
use renderer::camera::{EyeRays, Sampling};
use scene_loading::Scene;

use crate::args::ShowArgs;
use crate::args::show::{IMAGE, RayAt};
use crate::commands::render::one_scene;
use crate::context::Context;
use crate::error::{Error, SUCCESS};
use measurement::plan::error::PlanError;
use measurement::plan::rows::Row;
use measurement::rounds::MeasureError;
use measurement::system::files::{CreatedFiles, WriteError};
use measurement::system::machine;
use measurement::system::pools::pool;
use presentation::drawing::Drawing;
use presentation::table::{Cell, Style, Table};
use studies::showing::picture::{DrawnStructure, Frame, View, picture};
use studies::showing::ray_path::{focus, path_through};
use studies::showing::sections::{cells, outline};
use studies::showing::view::{Plane, Projection, scene_box};

/// Draws the picture, and lists the steps of a ray.
pub fn run(context: &mut Context<'_>, args: &ShowArgs) -> Result<u8, Error> {
    let rows: Vec<Row<'_>> =
        args.structures.iter().map(|text| row(context, text)).collect::<Result<_, _>>()?;
    let scene = one_scene(context.scenes, &args.scene)?;
    let mut created = CreatedFiles::default();
    if let Some(path) = &args.output {
        if path.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("svg")) {
            let (text, expected) = (path.display().to_string(), "a file name that ends in .svg");
            return Err(PlanError::Malformed { text, expected }.into());
        }
        created.file(path)?;
    }
    let loaded = context.load(&*scene)?.scene;
    context.warn_in_f32(&loaded);
    let geometry = Geometry::<f32>::of(&loaded)?;
    let ray = args.ray.map(|at| ray_at(at, &loaded));
    let bounds = args.window.map_or_else(
        || scene_box(&loaded),
        |corners| {
            let corner = |p| loaded.to_scene_coordinates(DVec3::from_array(p));
            let [one, other] = corners.map(corner);
            Aabb { min: one.min(other), max: one.max(other) }
        },
    );
    let camera = &loaded.camera;
    let plane = match (&ray, args.slice) {
        (Some(ray), _) => Plane::through(&ray.widened(), camera),
        (None, slice) => {
            let axis = slice.map_or_else(|| Plane::usual_axis(camera), |slice| slice.axis);
            let middle = (0.5 * (bounds.min + bounds.max)).to_array();
            let middle = middle.get(axis).copied().unwrap_or_default();
            let origin = loaded.origin.to_array().get(axis).copied().unwrap_or_default();
            let position = slice.and_then(|slice| slice.position);
            let at = position.map_or(middle, |position| position - origin);
            Plane::at(axis, at, camera)
        }
    };
    if args.window.is_some() && plane.cut(&bounds).is_none() {
        let expected = "a box that the plane of --slice cuts";
        return Err(PlanError::Malformed { text: "--window".into(), expected }.into());
    }
    let pool = pool(machine::threads())?;
    let mut shown = Vec::with_capacity(rows.len());
    for row in &rows {
        let build = MeasureError::of_build(&loaded.name);
        let no_cells = |source: NoCells| Error::NoCells { row: row.label(), source };
        let one = || {
            let tracer = row.entry.build(geometry.prims(), &row.params).map_err(build)?;
            let path = ray.as_ref().map(|ray| path_through(&*tracer, ray, &plane, &loaded));
            let path = path.transpose().map_err(no_cells)?;
            let cells = cells(&*tracer, (!args.project).then_some(&plane), args.depth);
            let cells = cells.map_err(no_cells)?;
            Ok::<_, Error>(DrawnStructure {
                label: row.label(),
                stats: tracer.stats(),
                cells,
                path,
            })
        };
        shown.push(pool.install(one)?);
    }
    if let Some(path) = &args.output {
        let surfaces = if args.project { Vec::new() } else { outline(&loaded, &plane) };
        let boxes = || View::Boxes(Projection::of(camera));
        let view = if args.project { boxes() } else { View::Cut(plane, &surfaces) };
        let title = title(args, &loaded, &plane);
        let way = shown.first().and_then(|shown| shown.path.as_ref());
        let focus = ray.zip(way).and_then(|(ray, way)| focus(&plane, &ray, &bounds, &way.hit));
        let frame = Frame {
            title,
            view,
            scene: bounds,
            focus,
            size: f64::from(args.size),
            scale: args.scale,
        };
        save(&picture(&frame, &shown), path)?;
        let rows: Vec<String> = rows.iter().map(Row::label).collect();
        context.wrote(path, format_args!("cells of {} over {}", rows.join(", "), loaded.name));
    }
    for shown in shown.iter().filter(|_| args.ray.is_some()) {
        context.screen().write_table(context.out, &steps(&loaded.name, shown))?;
    }
    Ok(SUCCESS)
}

/// A structure with settings; occluders are handled separately.
fn row<'r>(context: &Context<'r>, text: &str) -> Result<Row<'r>, PlanError> {
    let name = text.split([':', ' ']).next().unwrap_or_default();
    if context.occluders.iter().any(|occluder| occluder.info.name == name) {
        return Err(PlanError::Malformed {
            text: text.to_owned(),
            expected: "a structure: the cells of an occluder divide directions from a light, not space",
        });
    }
    Row::parse(context.registry, text)
}

fn ray_at(at: RayAt, scene: &Scene) -> Ray<f32> {
    let (origin, direction) = match at {
        RayAt::Pixel([x, y]) => {
            let eye = EyeRays::new(&scene.camera, [IMAGE; 2], Sampling::PixelCentres);
            (eye.origin(), eye.direction_within(x, y, DVec2::splat(0.5)))
        }
        RayAt::Points(points) => {
            let [from, towards] = points.map(|p| scene.to_scene_coordinates(DVec3::from_array(p)));
            (from, (towards - from).normalize_or(DVec3::X))
        }
    };
    Ray::new(origin.as_vec3(), direction.as_vec3())
}

fn title(args: &ShowArgs, scene: &Scene, plane: &Plane) -> String {
    let plane = plane.name(scene.origin);
    let scene = &scene.name;
    let cells = match args.depth {
        None => "cells".to_owned(),
        Some(depth) => format!("cells of depth {depth}, and leaves above,"),
    };
    match (args.ray, args.project) {
        (Some(_), _) => format!("{scene}: path of one ray; {cells} cut by {plane}"),
        (None, true) => format!("{scene}: {cells} that hold primitives"),
        (None, false) => format!("{scene}: {cells} cut by {plane}"),
    }
}

pub fn save(drawing: &Drawing, path: &Path) -> Result<(), Error> {
    let svg = drawing.svg().map_err(|source| Error::Undrawn { path: path.to_owned(), source })?;
    std::fs::write(path, svg).map_err(|source| WriteError { path: path.to_owned(), source }.into())
}

/// The steps of a ray, one line each.
fn steps(scene: &str, shown: &DrawnStructure) -> Table {
    let mut table = Table {
        title: format!("{scene} through {}", shown.label),
        header: vec!["step", "into", "depth", "tested"],
        ..Table::default()
    };
    let Some(path) = &shown.path else { return table };
    let cell = |text: String| Cell { text, style: Style::Plain };
    table.rows = path.listed().into_iter().map(|row| row.map(cell).to_vec()).collect();
    table.notes.push(path.summary());
    if path.hit.is_hit() {
        table.notes.push(format!("parameter of the ray: {}; * nearest hit so far", path.hit.t));
    }
    table
}
