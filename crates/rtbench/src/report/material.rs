//! Input of a page: the record of a run, and the results of other commands beside it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{fs, io};

use measurement::record::file::{self, RecordError};
use measurement::record::{RunRecord, SceneRecord};
use presentation::numbers::utc;
use scene_loading::source_hash::sha256_of_bytes;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use statistics::estimate::Estimate;
use studies::accuracy::record::AccuracyRecord;
use studies::run::conclusions::conclude;
use studies::run::costs::{Profile, profiles};
use studies::tracer_comparison::record::TracersRecord;

/// How PNG files begin.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
/// How the SVG files that this program writes begin.
const SVG: &[u8] = b"<svg ";

#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    #[error(transparent)]
    Record(#[from] RecordError),
    #[error("cannot read {}: {source}", path.display())]
    Folder { path: PathBuf, source: io::Error },
    #[error("{}: {message}; expected what `{written_by}` writes", path.display())]
    Csv { path: PathBuf, message: String, written_by: &'static str },
    #[error("{}: not {format}; expected what `{written_by}` draws", path.display())]
    NotAPicture { path: PathBuf, format: &'static str, written_by: &'static str },
}

/// Everything that a folder has.
pub struct Material {
    pub folder: PathBuf,
    pub data: DataFile,
    pub run: RunRecord,
    /// By scene: its picture, a PNG file.
    pub pictures: BTreeMap<String, Vec<u8>>,
    /// By scene: what its rows cost.
    pub profiles: Vec<Vec<Profile>>,
    pub accuracy: Option<AccuracyRecord>,
    /// Records of `rtbench compare-tracers`, by scene.
    pub tracers: Vec<TracersRecord>,
    /// Pictures of the work of each pixel, by scene: quantities (`tests`, `steps`, `time`) and images.
    pub heat_maps: Vec<(String, NamedImages)>,
    /// Plots of sweeps, by the names of their folders.
    pub sweeps: NamedImages,
    /// Figures of `rtbench reproduce havran1999`.
    pub counters: Option<Vec<ReproducedFigure>>,
    /// Rows of `rtbench reproduce zachmann2007`.
    pub lecture: Option<Vec<LectureRow>>,
}

/// A file that a page was made from.
pub struct DataFile {
    /// Its name within the folder.
    pub name: String,
    pub bytes: usize,
    pub sha256: String,
}

type NamedImages = Vec<(String, ImageFile)>;

/// A picture as it is in its file.
pub struct ImageFile {
    /// `svg+xml` or `png`, as in a data URL.
    pub kind: &'static str,
    pub bytes: Vec<u8>,
}

impl Material {
    /// Reads a record and what lies beside it.
    pub fn read(record: &Path) -> Result<Self, ReportError> {
        let text = file::bytes(record)?;
        let mut run = file::record(record, &text)?;
        // what a record says of itself is not believed, and those from before say nothing
        conclude(&mut run);
        let folder = record.parent().filter(|folder| *folder != Path::new(""));
        let folder = folder.unwrap_or(Path::new(".")).to_owned();
        let data = DataFile {
            name: record.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            bytes: text.len(),
            sha256: sha256_of_bytes(&text),
        };
        let accuracy = folder.join("accuracy").join("accuracy.json");
        let lecture = folder.join("zachmann2007.csv");
        let mut tracers = Vec::new();
        for scene in folders(&folder.join("tracers"))? {
            tracers.extend(json(&scene.join("tracers.json"), "rtbench compare-tracers -o DIR")?);
        }
        Ok(Self {
            accuracy: json(&accuracy, "rtbench accuracy -o DIR")?,
            tracers,
            heat_maps: heat_maps(&folder.join("heat-maps"))?,
            sweeps: sweeps(&folder)?,
            counters: csv(&folder.join("havran1999.csv"), "rtbench reproduce havran1999 -o DIR")?,
            lecture: csv(&lecture, "rtbench reproduce zachmann2007 -o DIR")?,
            pictures: pictures(&folder.join("pictures"), &["png"], "rtbench render -o FILE")?
                .into_iter()
                .map(|(scene, image)| (scene, image.bytes))
                .collect(),
            profiles: run.scenes.iter().map(profiles).collect(),
            folder,
            data,
            run,
        })
    }

    /// Short description of the run: machine, date, commit.
    pub fn in_words(&self) -> String {
        let run = &self.run;
        let cpu = run.machine.cpu.as_deref().unwrap_or("unknown processor");
        let commit = run.tool.git_revision.as_deref().unwrap_or("unknown commit");
        let commit: String = commit.chars().take(12).collect();
        format!("{cpu}, {} thread(s), {}, {commit}", run.machine.threads, utc(run.started_unix_s))
    }

    /// Each scene with what its rows cost.
    pub fn scenes(&self) -> impl Iterator<Item = (&SceneRecord, &[Profile])> {
        self.run.scenes.iter().zip(self.profiles.iter().map(Vec::as_slice))
    }
}

fn if_there(path: &Path) -> Result<Option<Vec<u8>>, RecordError> {
    path.exists().then(|| file::bytes(path)).transpose()
}

/// A JSON file, where there is one.
fn json<T: DeserializeOwned>(
    path: &Path,
    written_by: &'static str,
) -> Result<Option<T>, ReportError> {
    let text = if_there(path)?;
    Ok(text.map(|text| file::parsed(path, &text, written_by)).transpose()?)
}

/// A CSV file, where there is one.
fn csv<T: DeserializeOwned>(
    path: &Path,
    written_by: &'static str,
) -> Result<Option<Vec<T>>, ReportError> {
    let Some(text) = if_there(path)? else { return Ok(None) };
    let rows: Result<_, csv::Error> = csv::Reader::from_reader(&text[..]).deserialize().collect();
    let error = |message| ReportError::Csv { path: path.to_owned(), message, written_by };
    rows.map(Some).map_err(|e| error(e.to_string()))
}

/// Sorted entries of a folder; empty if it does not exist.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, ReportError> {
    let error = |source| ReportError::Folder { path: folder.to_owned(), source };
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(source) => return Err(error(source)),
    };
    let paths = entries.map(|entry| entry.map(|e| e.path()));
    let mut paths = paths.collect::<Result<Vec<_>, _>>().map_err(error)?;
    paths.sort();
    Ok(paths)
}

fn folders(folder: &Path) -> Result<Vec<PathBuf>, ReportError> {
    Ok(entries(folder)?.into_iter().filter(|path| path.is_dir()).collect())
}

/// The pictures in the folders of scenes; until November 2026 they were PNG files.
fn heat_maps(folder: &Path) -> Result<Vec<(String, NamedImages)>, ReportError> {
    let of_scene = |folder: PathBuf| {
        let maps = pictures(&folder, &["svg", "png"], "rtbench cost --heat-maps DIR")?;
        Ok((text(folder.file_name()), maps))
    };
    folders(folder)?.into_iter().map(of_scene).collect()
}

/// The files in a folder that have one of these extensions, with their names.
fn pictures(
    folder: &Path,
    extensions: &[&str],
    written_by: &'static str,
) -> Result<NamedImages, ReportError> {
    let is_one = |path: &PathBuf| {
        path.extension().is_some_and(|e| extensions.iter().any(|known| e == *known))
    };
    let of_file = |path: PathBuf| Ok((text(path.file_stem()), picture(path, written_by)?));
    entries(folder)?.into_iter().filter(is_one).map(of_file).collect()
}

/// A picture, which begins as its extension says: `svg`, else PNG.
fn picture(path: PathBuf, written_by: &'static str) -> Result<ImageFile, ReportError> {
    let bytes = file::bytes(&path)?;
    let (kind, signature, format) = if path.extension().is_some_and(|e| e == "svg") {
        ("svg+xml", SVG, "an SVG image")
    } else {
        ("png", PNG, "a PNG image")
    };
    if !bytes.starts_with(signature) {
        return Err(ReportError::NotAPicture { path, format, written_by });
    }
    Ok(ImageFile { kind, bytes })
}

fn text(part: Option<&std::ffi::OsStr>) -> String {
    part.unwrap_or_default().to_string_lossy().into_owned()
}

fn sweeps(folder: &Path) -> Result<NamedImages, ReportError> {
    let mut plots = Vec::new();
    for sweep in folders(folder)? {
        let (name, path) = (text(sweep.file_name()), sweep.join("sweep.svg"));
        if name.starts_with("sweep-") && path.exists() {
            plots.push((name, picture(path, "rtbench sweep -o DIR")?));
        }
    }
    Ok(plots)
}

/// A figure as `rtbench reproduce havran1999 -o` writes it.
#[derive(Debug, Clone, Deserialize)]
pub struct ReproducedFigure {
    pub(super) scene: String,
    pub(super) structure: String,
    pub(super) params: String,
    pub(super) counter: String,
    pub(super) published: String,
    pub(super) ours: f64,
    pub(super) verdict: String,
}

/// A row as `rtbench reproduce zachmann2007 -o` writes it.
#[derive(Debug, Clone, Deserialize)]
pub struct LectureRow {
    pub(super) scene: String,
    pub(super) lecture: String,
    pub(super) ours: String,
    pub(super) verdict: String,
    pub(super) build_then: Option<f64>,
    pub(super) build_now: Option<f64>,
    pub(super) build_low: Option<f64>,
    pub(super) build_high: Option<f64>,
    pub(super) run_then: Option<f64>,
    pub(super) run_now: Option<f64>,
    pub(super) run_low: Option<f64>,
    pub(super) run_high: Option<f64>,
}

impl LectureRow {
    pub(super) fn build(&self) -> Option<Estimate> {
        Some(Estimate { median: self.build_now?, low: self.build_low?, high: self.build_high? })
    }

    pub(super) fn run(&self) -> Option<Estimate> {
        Some(Estimate { median: self.run_now?, low: self.run_low?, high: self.run_high? })
    }
}
