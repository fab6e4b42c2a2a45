//! A program outside as a row of a run's results: `rtbench rays check --into`.

use std::path::{Path, PathBuf};

use measurement::rays::order::{distinct, kind_of};
use measurement::record::file::{self, RecordError};
use measurement::record::{RowRecord, RunRecord, SceneRecord};
use measurement::settings::Lights;
use plugins::files::FileSubject;
use renderer::RayKind;

/// Why results take no foreign row.
#[derive(Debug, thiserror::Error)]
pub enum ForeignRowError {
    #[error(transparent)]
    Record(#[from] RecordError),
    #[error("{}: the run is not finished; finish it with `rtbench run --resume`", path.display())]
    Incomplete { path: PathBuf },
    #[error("{}: no scene {scene} with this content; it has: {valid}", path.display())]
    NoScene { path: PathBuf, scene: String, valid: String },
    #[error("{}: its rays differ: {what}; export those of the run, with its options", path.display())]
    OtherRays { path: PathBuf, what: String },
    #[error("{}: scene {scene} has a row '{name}'; choose another --name, or replace a foreign row with --overwrite", path.display())]
    Taken { path: PathBuf, scene: String, name: String },
}

/// The results in a folder with a foreign row more, of the scene that is called `name` here and has
/// this content. One of its name is replaced where `overwrite` is set.
pub fn merged(
    folder: &Path,
    (name, sha256): (&str, &str),
    about: &FileSubject,
    row: RowRecord,
    overwrite: bool,
) -> Result<RunRecord, ForeignRowError> {
    let path = file::path_of(folder);
    let mut record = file::read(folder)?;
    if !record.complete {
        return Err(ForeignRowError::Incomplete { path });
    }
    let valid: Vec<&str> = record.scenes.iter().map(|scene| &*scene.name).collect();
    let valid = valid.join(", ");
    let what = other_settings(&record, about);
    let Some(scene) = record.scenes.iter_mut().find(|scene| scene.sha256 == sha256) else {
        return Err(ForeignRowError::NoScene { path, scene: name.to_owned(), valid });
    };
    if let Some(what) = what.or_else(|| other_counts(scene, about)) {
        return Err(ForeignRowError::OtherRays { path, what });
    }
    let is_same = |other: &RowRecord| other.label() == row.label();
    if scene.rows.iter().any(is_same) || scene.foreign.iter().any(is_same) && !overwrite {
        let (scene, name) = (scene.name.clone(), row.label());
        return Err(ForeignRowError::Taken { path, scene, name });
    }
    scene.foreign.retain(|other| !is_same(other));
    scene.foreign.push(row);
    Ok(record)
}

/// Differences of the settings of rays.
fn other_settings(record: &RunRecord, about: &FileSubject) -> Option<String> {
    let lights = if about.first_light { Lights::First } else { Lights::Each };
    let of = &record.settings;
    let pairs = [
        ("--size", format!("{}", of.resolution[0]), about.size.to_string()),
        ("--seed", of.seed.to_string(), about.seed.to_string()),
        ("--lights", of.lights.clone(), lights.name().to_owned()),
        ("--precision", of.precision.clone(), "f32".to_owned()),
    ];
    let differs = pairs.into_iter().find(|(_, run, file)| run != file);
    differs.map(|(name, run, file)| format!("{name} {file}, the run had {run}"))
}

/// A kind of which there are more or fewer rays.
fn other_counts(scene: &SceneRecord, about: &FileSubject) -> Option<String> {
    let asked = RayKind::ALL.into_iter().zip(about.rays).filter(|(_, n)| *n > 0);
    asked.into_iter().find_map(|(kind, n)| {
        let own = distinct(&scene.rays).find(|(name, _)| kind_of(name) == kind.name());
        let own = own.map_or(0, |(_, n)| n);
        (own != n).then(|| format!("{n} {} rays, the run had {own}", kind.name()))
    })
}
