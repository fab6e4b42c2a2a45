//! `rtbench rays trace`: the hits of rays from a file.

use accel_core::primitives::PrimsRef;
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use accel_core::{Ray, Scalar, Vector};
use measurement::plan::error::PlanError;
use measurement::plan::rows::{self, Row};
use measurement::rays::batches::{Answers, trace, trace_chunked};
use measurement::rays::text::{self, hexadecimal};
use measurement::rounds::error::MeasureError;
use measurement::scenes::LoadedScene;
use measurement::settings::Precision;
use measurement::system::machine;
use measurement::system::pools::deep_pool;
use plugins::abi;
use plugins::files::{self, Content, FileError, FileSubject};
use presentation::outside::line;
use renderer::{Geometry, RayKind};

use crate::args::TraceArgs;
use crate::commands::by_files::{digest, write};
use crate::commands::render::one_scene;
use crate::context::Context;
use crate::error::Error;

/// Rays by kind, in the order of the file.
type AskedRays = Vec<(RayKind, Vec<Ray<f64>>)>;

/// Traces the rays, and prints the hits or writes them.
pub fn run(context: &mut Context<'_>, args: &TraceArgs) -> Result<(), Error> {
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
        Precision::F32 => traced::<f32>(context, args, &rows, &loaded),
        Precision::F64 => traced::<f64>(context, args, &rows, &loaded),
    }
}

fn traced<S: Buildable>(
    context: &mut Context<'_>,
    args: &TraceArgs,
    rows: &[Row<'_>],
    loaded: &LoadedScene,
) -> Result<(), Error> {
    let geometry = Geometry::<S>::of(&loaded.scene)?;
    let (about, by_kind) = read(args, loaded, geometry.len())?;
    let mut file = about.header(Content::Hits);
    for row in rows {
        let answers = answers::<S>(geometry.prims(), row, &by_kind)
            .map_err(|source| MeasureError::Build { scene: loaded.scene.name.clone(), source })?;
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
    context.out.flush()?;
    match &args.output {
        Some(path) => write(path, &file),
        None => Ok(()),
    }
}

/// The rays of the file, and the header for their hits.
fn read(
    args: &TraceArgs,
    loaded: &LoadedScene,
    primitives: usize,
) -> Result<(FileSubject, AskedRays), Error> {
    let read = |source| plugins::PluginError::Read { file: args.rays.clone(), source };
    let bytes = std::fs::read(&args.rays).map_err(read)?;
    let wrong = |offset, what| FileError { file: args.rays.clone(), offset, what };
    let scene = digest(&loaded.sha256);
    if !bytes.starts_with(b"RTB") {
        let text = std::str::from_utf8(&bytes).map_err(|error| {
            wrong(error.valid_up_to(), "neither a file of `rays export` nor text".into())
        })?;
        let mut rays = text::read(&args.rays, text)?;
        // text has the coordinates of the scene's file
        rays.iter_mut().for_each(|ray| ray.origin -= loaded.scene.origin);
        let about = FileSubject {
            rays: [rays.len() as u64, 0, 0, 0, 0],
            triangles: primitives as u64,
            size: 1,
            first_light: false,
            seed: 0,
            scene,
            origin: loaded.scene.origin.to_array(),
        };
        return Ok((about, vec![(RayKind::Primary, rays)]));
    }
    let about = FileSubject::read(&args.rays, &bytes, Content::Rays)?;
    if about.scene != scene {
        let what = format!("the rays belong to another scene than {}", args.scene);
        return Err(wrong(80, what).into());
    }
    let mut all = files::rays(&about, &bytes).map(|ray| Ray::<f32>::from(&ray).widened());
    let kinds = RayKind::ALL.into_iter().zip(about.rays);
    let by_kind = kinds.map(|(kind, n)| (kind, all.by_ref().take(n as usize).collect()));
    Ok((about.clone(), by_kind.collect()))
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
