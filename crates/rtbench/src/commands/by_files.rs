//! `rtbench rays export` and `rtbench rays check`: the rays of a scene for any program, and its
//! answers.

use accel_core::primitives::Primitives;
use accel_core::{Hit, MISS};
use measurement::answers::by_files::{check, foreign_row, rays};
use measurement::plan::Plan;
use measurement::plan::error::PlanError;
use measurement::scenes::LoadedScene;
use measurement::settings::{Lights, RunSettings};
use measurement::system::created::WriteError;
use measurement::system::pools::Pools;
use measurement::system::{files, machine};
use plugins::abi;
use plugins::files::{Content, FileError, FileSubject, hits, ray_record, triangle_record};
use presentation::table::{Cell, Style, Table};
use renderer::{Geometry, RayKind};
use scene_loading::source_hash::sha256_of_bytes;

use crate::args::{CheckRaysArgs, Color, ExportArgs, ExportRaysArgs, RayFormat, settings_of};
use crate::commands::run_outputs;
use crate::context::Context;
use crate::error::Error;
use crate::exit_code::{SUCCESS, WRONG_HITS};
use crate::foreign_row::merged;

/// Writes rays and triangles.
pub fn export(context: &mut Context<'_>, args: &ExportRaysArgs) -> Result<(), Error> {
    let settings = settings_of(&args.scene, args.kind.clone(), args.size, args.seed, args.lights);
    let (plan, loaded, geometry) = prepared(context, &settings)?;
    let Geometry::Triangles(set) = &geometry else { return Err(no_triangles(&loaded)) };
    let pools = Pools::new(machine::threads())?;
    let by_kind = rays(&plan, &loaded, &geometry, &pools)?;
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
    Ok(())
}

/// Compares answers with ours; returns the exit code.
pub fn check_hits(
    context: &mut Context<'_>,
    args: &CheckRaysArgs,
    color: Color,
) -> Result<u8, Error> {
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
    let (plan, loaded, geometry) = prepared(context, &settings)?;
    if about.scene != digest(&loaded.sha256) {
        let what = format!("its rays belong to another scene than {}", args.scene);
        return Err(wrong(80, what).into());
    }
    let Geometry::Triangles(set) = &geometry else { return Err(no_triangles(&loaded)) };
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
    let pools = Pools::new(machine::threads())?;
    let judged = check(&plan, &loaded, &geometry, (&pools, context.clock), &by_kind)?;
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
    let screen = context.terminal.screen(color);
    screen.write_table(context.out, &Table { title, header, rows, notes })?;
    context.out.flush()?;
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

/// The plan of a run with these rays, its one scene and that one's geometry.
fn prepared<'c>(
    context: &Context<'c>,
    settings: &RunSettings,
) -> Result<(Plan<'c>, LoadedScene, Geometry<f32>), Error> {
    let plan = Plan::new(settings, context.registry, context.occluders, context.scenes)?;
    let scene = plan.scenes.first().ok_or(PlanError::NoRows)?;
    let loaded = context.load(&**scene)?;
    let geometry = Geometry::<f32>::of(&loaded.scene)?;
    Ok((plan, loaded, geometry))
}

fn no_triangles(loaded: &LoadedScene) -> Error {
    Error::NotOfTriangles { scene: loaded.scene.name.clone() }
}

pub(super) fn write(path: &std::path::Path, bytes: &[u8]) -> Result<(), Error> {
    files::put(path, bytes).map_err(|source| WriteError { path: path.into(), source }.into())
}

fn file_name(args: &CheckRaysArgs) -> String {
    args.file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// The bytes of a SHA-256 in hexadecimal.
pub(super) fn digest(hexadecimal: &str) -> [u8; 32] {
    let mut bytes = [0; 32];
    for (byte, i) in bytes.iter_mut().zip((0..).step_by(2)) {
        let digits = hexadecimal.get(i..i + 2).unwrap_or_default();
        *byte = u8::from_str_radix(digits, 16).unwrap_or_default();
    }
    bytes
}
