//! `rtbench rays`: the rays of a scene for any program, its answers, and the hits of rays from a file.

use accel_core::primitives::{Primitives, PrimsRef};
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use accel_core::{Hit, MISS, Ray, Scalar, Vector};
use renderer::{Geometry, RayKind};
use scene_loading::source_hash::sha256_of_bytes;

use crate::args::{CheckRaysArgs, ExportArgs, ExportRaysArgs, RayFormat, TraceArgs};
use crate::commands::render::one_scene;
use crate::commands::run_outputs;
use crate::context::Context;
use crate::error::{Error, SUCCESS, WRONG_HITS};
use crate::foreign_row::{SceneRays, foreign_row, merged};
use measurement::plan::error::PlanError;
use measurement::plan::rows::{self, Row};
use measurement::rays::batches::{Answers, trace, trace_chunked};
use measurement::rays::text::{self, hexadecimal};
use measurement::rounds::MeasureError;
use measurement::scenes::LoadedScene;
use measurement::settings::{Lights, MeasuringSettings, Precision, RunSettings};
use measurement::system::files::{WriteError, put};
use measurement::system::machine;
use measurement::system::pools::deep_pool;
use plugins::abi;
use plugins::files::{self, Content, FileError, FileSubject, hits, ray_record, triangle_record};
use presentation::outside::line;
use presentation::table::{Cell, Style, Table};

pub fn export(context: &mut Context<'_>, args: &ExportRaysArgs) -> Result<u8, Error> {
    let settings = settings_of(&args.scene, args.kind.clone(), args.size, args.seed, args.lights);
    let scene = SceneRays::load(context, &settings)?;
    let (set, loaded) = (scene.triangles()?, &scene.loaded);
    let by_kind = scene.rays()?;
    let count = |kind: RayKind| {
        let own = by_kind.iter().find(|(own, _)| *own == kind);
        own.map_or(0, |(_, rays)| rays.len() as u64)
    };
    let about = FileSubject {
        rays: RayKind::ALL.map(count),
        triangles: set.len() as u64,
        size: args.size,
        first_light: args.lights == Lights::First,
        seed: args.seed,
        scene: digest(&loaded.sha256),
        origin: loaded.scene.origin.to_array(),
    };
    if let Some(path) = &args.output {
        let all = by_kind.iter().flat_map(|(_, rays)| rays).map(abi::Ray::from);
        let bytes: Vec<u8> = match args.format {
            RayFormat::Rtbench => {
                let mut bytes = about.header(Content::Rays);
                all.for_each(|ray| bytes.extend_from_slice(&ray_record(&ray)));
                bytes
            }
            RayFormat::Hagrid => {
                let [x, y, z] = about.origin;
                if about.origin != [0.0; 3] {
                    context.warn(format_args!(
                        "{}: rays are relative to the origin {x},{y},{z}, which this format does not store",
                        loaded.scene.name
                    ));
                }
                let six = |ray: abi::Ray| ray.origin.into_iter().chain(ray.direction);
                all.flat_map(six).flat_map(f32::to_le_bytes).collect()
            }
        };
        write(path, &bytes)?;
        for (kind, rays) in &by_kind {
            context.say(format_args!("{} {} rays", rays.len(), kind.name()));
        }
    }
    if let Some(path) = &args.triangles {
        let mut bytes = about.header(Content::Triangles);
        for (corners, id) in set.triangles().iter().zip(0..) {
            bytes.extend_from_slice(&triangle_record(corners, !set.is_opaque(id)));
        }
        write(path, &bytes)?;
    }
    Ok(SUCCESS)
}

/// Compares answers with ours; returns the exit code.
pub fn check_hits(context: &mut Context<'_>, args: &CheckRaysArgs) -> Result<u8, Error> {
    let read = |source| plugins::PluginError::Read { file: args.file.clone(), source };
    let bytes = std::fs::read(&args.file).map_err(read)?;
    let about = FileSubject::read(&args.file, &bytes, Content::Hits)?;
    let wrong = |offset, what| FileError { file: args.file.clone(), offset, what };
    let asked = || RayKind::ALL.into_iter().zip(about.rays).filter(|(_, n)| *n > 0);
    let kinds: Vec<String> = asked().map(|(kind, _)| kind.name().to_owned()).collect();
    if kinds.is_empty() {
        return Err(wrong(16, "the scene has no rays of any kind".into()).into());
    }
    let lights = if about.first_light { Lights::First } else { Lights::Each };
    let settings = settings_of(&args.scene, kinds, about.size, about.seed, lights);
    let scene = SceneRays::load(context, &settings)?;
    let loaded = &scene.loaded;
    if about.scene != digest(&loaded.sha256) {
        let what = format!("its rays belong to another scene than {}", args.scene);
        return Err(wrong(80, what).into());
    }
    let set = scene.triangles()?;
    let mut all = hits(&about, &bytes);
    let mut by_kind = Vec::new();
    let mut place = about.header_bytes();
    for (kind, count) in asked() {
        let mut own = Vec::new();
        for hit in all.by_ref().take(count as usize) {
            let is_hit = hit.id != abi::MISS;
            if is_hit && !kind.is_occlusion() && (hit.t.is_nan() || hit.id as usize >= set.len()) {
                let n = set.len();
                let what = format!("t = {}, id = {}: the scene has {n} triangles", hit.t, hit.id);
                return Err(wrong(place, what).into());
            }
            let id = if is_hit { hit.id } else { MISS };
            own.push(Hit { t: hit.t, id });
            place += Content::Hits.record_bytes();
        }
        by_kind.push((kind, own));
    }
    let judged = scene.check(&by_kind)?;
    for ((kind, n), place) in asked().zip(0..) {
        let is = judged.iter().find(|(own, _)| *own == kind).map_or(0, |(_, j)| j.compared as u64);
        if is != n {
            let what = format!("{n} {} rays, the scene has {is}", kind.name());
            return Err(wrong(16 + 8 * place, what).into());
        }
    }
    let mut notes = Vec::new();
    let rows = judged.iter().map(|(kind, judged)| {
        notes.extend(judged.example.clone());
        let is_wrong = judged.wrong > 0;
        let (text, style) = if is_wrong { ("wrong", Style::Bad) } else { ("ok", Style::Plain) };
        let rate = judged.edges as f64 / judged.compared.max(1) as f64;
        vec![
            kind.name().to_owned().into(),
            judged.compared.to_string().into(),
            judged.wrong.to_string().into(),
            format!("{} ({rate:.1e})", judged.edges).into(),
            Cell { text: text.into(), style },
        ]
    });
    let rows = rows.collect();
    let header = vec!["rays", "answers", "wrong", "at edges", "verdict"];
    let title = format!("{}: {}", args.scene, file_name(args));
    let screen = context.screen();
    screen.write_table(context.out, &Table { title, header, rows, notes })?;
    if let (Some(folder), Some(name), Some(ms)) = (&args.into, &args.name, args.time_ms) {
        let seconds = [Some(ms), args.build_ms].map(|ms| ms.map(|ms| ms / 1e3));
        let row = foreign_row(name, sha256_of_bytes(&bytes), seconds, &judged);
        let scene = (args.scene.as_str(), loaded.sha256.as_str());
        let record = merged(folder, scene, &about, row, context.overwrite)?;
        let exports = ExportArgs { output: Some(folder.clone()), ..ExportArgs::default() };
        run_outputs::of_run(&exports)?.write(&record, true)?;
    }
    Ok(if judged.iter().any(|(_, judged)| judged.wrong > 0) { WRONG_HITS } else { SUCCESS })
}

/// Settings of a run with these rays.
fn settings_of(
    scene: &str,
    kinds: Vec<String>,
    size: u32,
    seed: u64,
    lights: Lights,
) -> RunSettings {
    let (rays, size) = (kinds, Some(size));
    let measuring = MeasuringSettings { rays, size, seed, lights, ..MeasuringSettings::default() };
    RunSettings { scenes: vec![scene.to_owned()], measuring, ..RunSettings::default() }
}

fn write(path: &std::path::Path, bytes: &[u8]) -> Result<(), Error> {
    put(path, bytes).map_err(|source| WriteError { path: path.into(), source }.into())
}

fn file_name(args: &CheckRaysArgs) -> String {
    args.file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// The bytes of a SHA-256 in hexadecimal.
fn digest(hexadecimal: &str) -> [u8; 32] {
    let mut bytes = [0; 32];
    for (byte, i) in bytes.iter_mut().zip((0..).step_by(2)) {
        let digits = hexadecimal.get(i..i + 2).unwrap_or_default();
        *byte = u8::from_str_radix(digits, 16).unwrap_or_default();
    }
    bytes
}

/// Rays by kind, in the order of the file.
type AskedRays = Vec<(RayKind, Vec<Ray<f64>>)>;

/// Traces the rays, and prints the hits or writes them.
pub fn trace_rays(context: &mut Context<'_>, args: &TraceArgs) -> Result<u8, Error> {
    let mut structures = args.structures.clone();
    if structures.is_empty() {
        structures = context.plugins.names();
    }
    context.plugins.add_rows(&mut structures);
    let rows = rows::select(context.registry, &structures, &[])?;
    if args.output.is_some() && rows.len() > 1 {
        let labels: Vec<String> = rows.iter().map(Row::label).collect();
        let expected = "one structure: a file of hits has one answer per ray";
        return Err(PlanError::Malformed { text: labels.join(","), expected }.into());
    }
    let scene = one_scene(context.scenes, &args.scene)?;
    let loaded = context.load(&*scene)?;
    match args.precision {
        Precision::F32 => traced::<f32>(context, args, &rows, &loaded)?,
        Precision::F64 => traced::<f64>(context, args, &rows, &loaded)?,
    }
    Ok(SUCCESS)
}

fn traced<S: Buildable>(
    context: &mut Context<'_>,
    args: &TraceArgs,
    rows: &[Row<'_>],
    loaded: &LoadedScene,
) -> Result<(), Error> {
    let geometry = Geometry::<S>::of(&loaded.scene)?;
    let (mut file, by_kind) = read(args, loaded)?;
    for row in rows {
        let answers = answers::<S>(geometry.prims(), row, &by_kind)
            .map_err(MeasureError::of_build(&loaded.scene.name))?;
        let label = line(&row.label()).into_owned();
        let all = answers.iter().flat_map(|answers| (0..answers.len()).map(move |i| (answers, i)));
        for (number, (answers, i)) in all.enumerate() {
            if args.output.is_some() {
                file.extend_from_slice(&files::hit_record(&record_of(answers, i)));
            } else {
                let exact = match answers {
                    Answers::Hits(hits) => hits.get(i).filter(|hit| hit.is_hit()),
                    Answers::Blocked(_) => None,
                };
                let exact = exact.map(|hit| format!(" ({})", hexadecimal(hit.t.to_f64())));
                let exact = exact.unwrap_or_default();
                writeln!(context.out, "{label}: ray {number}: {}{exact}", answers.describe(i))?;
            }
        }
    }
    match &args.output {
        Some(path) => write(path, &file),
        None => Ok(()),
    }
}

/// The header for the hits, which those of rays in text have none of, and the rays of the file.
fn read(args: &TraceArgs, loaded: &LoadedScene) -> Result<(Vec<u8>, AskedRays), Error> {
    let read = |source| plugins::PluginError::Read { file: args.rays.clone(), source };
    let bytes = std::fs::read(&args.rays).map_err(read)?;
    let wrong = |offset, what| FileError { file: args.rays.clone(), offset, what };
    if !bytes.starts_with(b"RTB") {
        let text = std::str::from_utf8(&bytes).map_err(|error| {
            wrong(error.valid_up_to(), "neither a file of `rays export` nor text".into())
        })?;
        if args.output.is_some() {
            let what =
                "text: hits are written for a file of `rays export`, as `rays check` reads them";
            return Err(wrong(0, what.into()).into());
        }
        let mut rays = text::read(&args.rays, text)?;
        // text has the coordinates of the scene's file
        rays.iter_mut().for_each(|ray| ray.origin -= loaded.scene.origin);
        return Ok((Vec::new(), vec![(RayKind::Primary, rays)]));
    }
    let about = FileSubject::read(&args.rays, &bytes, Content::Rays)?;
    if about.scene != digest(&loaded.sha256) {
        let what = format!("the rays belong to another scene than {}", args.scene);
        return Err(wrong(80, what).into());
    }
    let mut all = files::rays(&about, &bytes).map(|ray| Ray::<f32>::from(&ray).widened());
    let kinds = RayKind::ALL.into_iter().zip(about.rays);
    let by_kind = kinds.map(|(kind, n)| (kind, all.by_ref().take(n as usize).collect()));
    Ok((about.header(Content::Hits), by_kind.collect()))
}

/// The answers of a row to the rays of each kind.
fn answers<S: Buildable>(
    prims: PrimsRef<'_, S>,
    row: &Row<'_>,
    by_kind: &AskedRays,
) -> Result<Vec<Answers<S>>, BuildError> {
    let pool = deep_pool(machine::threads())
        .map_err(|e| BuildError::Library { structure: row.structure(), message: e.to_string() })?;
    pool.install(|| {
        let tracer = row.entry.build(prims, &row.params)?;
        let mut all = Vec::new();
        for (kind, rays) in by_kind {
            let rays: Vec<Ray<S>> = rays.iter().map(rounded).collect();
            let mut answers = Answers::new(*kind, rays.len());
            match tracer.foreign() {
                Some(_) => trace(&*tracer, &rays, &mut answers),
                None => trace_chunked(&*tracer, &rays, &mut answers),
            }
            all.push(answers);
        }
        let failure = tracer.foreign().and_then(|foreign| foreign.failure());
        failure.map_or(Ok(all), |how| Err(BuildError::Died(how)))
    })
}

fn rounded<S: Scalar>(ray: &Ray<f64>) -> Ray<S> {
    let (t_min, t_max) = (S::from_f64(ray.t_min), S::from_f64(ray.t_max));
    Ray { t_min, t_max, ..Ray::from_dvec3(ray.origin, ray.direction) }
}

/// An answer as a record; of a shadow ray that is blocked any primitive's.
fn record_of<S: Scalar>(answers: &Answers<S>, i: usize) -> abi::Hit {
    let none = abi::Hit::new(0.0, abi::MISS);
    match answers {
        Answers::Hits(hits) => match hits.get(i) {
            Some(hit) if hit.is_hit() => abi::Hit::new(hit.t.to_f64() as f32, hit.id),
            _ => none,
        },
        Answers::Blocked(blocked) if blocked.get(i) == Some(&true) => abi::Hit::new(0.0, 0),
        Answers::Blocked(_) => none,
    }
}
