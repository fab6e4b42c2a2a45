//! The cases of `rtbench verify` that came with the outside oracle: each catches a structure that
//! is wrong on purpose, in f32 and in f64; and a check that is cut short keeps what it has.

use std::time::Duration;

use crate::common::{
    BatchFault, Batched, Ended, Folder, SILENT, SILENT_SHADOWS, SilentAll, SilentShadows,
    answered_by_brute_force, planted_entry, run_with,
};
use accel_core::params::config::Settings;
use accel_core::primitives::{PrimSet, Primitives, TriangleSet};
use accel_core::query::sink::Sink;
use accel_core::structure::{BatchAnswers, BuildError, RayBatch, Structure, StructureStats};
use accel_core::structures::{Entry, brute_force, uniform_grid};
use accel_core::{Aabb, Hit, Ray, Scalar, Vec3, Vector};
use measurement::scenes::InstalledScenes;
use measurement::system::clock::{SteppingClock, SystemClock};
#[cfg(unix)]
use measurement::system::interrupt::GRACE;

/// A list of boxes; which of them a ray passes over wrongly is its fault.
pub struct Boxes<S: Scalar, F> {
    boxes: Vec<Aabb<S>>,
    kind: std::marker::PhantomData<F>,
}

pub trait Lapse: Send + Sync + 'static {
    fn skips<S: Scalar>(ray: &Ray<S>, own: &Aabb<S>, t_max: S) -> bool;
}

impl<S: Scalar, F: Lapse> Structure<S> for Boxes<S, F> {
    type Config = ();

    fn build(prims: &dyn Primitives<S>, _: &Settings<()>) -> Result<Self, BuildError> {
        let boxes = (0..prims.len() as u32).map(|id| prims.bounds(id)).collect();
        Ok(Self { boxes, kind: std::marker::PhantomData })
    }

    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        for (id, own) in (0..).zip(&self.boxes) {
            if !F::skips(ray, own, sink.t_max()) && sink.test(&[id]).is_break() {
                return;
            }
        }
    }

    fn stats(&self) -> StructureStats {
        StructureStats::default()
    }
}

/// Takes a ray that leaves a plane by next to nothing for one beyond it.
struct SkipsBelowPlanes;
impl Lapse for SkipsBelowPlanes {
    fn skips<S: Scalar>(ray: &Ray<S>, own: &Aabb<S>, _: S) -> bool {
        let (o, d, high) = (ray.origin.to_array(), ray.direction.to_array(), own.max.to_array());
        (0..3).any(|k| {
            let off = d[k].to_f64();
            -1e-5 < off && off < 0.0 && high[k] == o[k]
        })
    }
}

/// An adapter to a library whose rays begin at 0.
pub struct BeginsAtZero;
impl Lapse for BeginsAtZero {
    fn skips<S: Scalar>(ray: &Ray<S>, own: &Aabb<S>, t_max: S) -> bool {
        let pad = Vec3::<S>::splat(S::from_f64(1e-3));
        let grown = Aabb { min: own.min - pad, max: own.max + pad };
        let t_min = ray.t_min.greater(S::ZERO);
        t_min > t_max || grown.clip(ray.origin, ray.direction, t_min, t_max).is_none()
    }
}

/// Loses rays with denormal components.
struct LosesDenormals;
impl Lapse for LosesDenormals {
    fn skips<S: Scalar>(ray: &Ray<S>, _: &Aabb<S>, _: S) -> bool {
        let least_normal = if S::NAME == "f32" { -126.0_f64 } else { -1022.0 }.exp2();
        let size = ray.direction.to_array().map(|x| x.abs().to_f64());
        size.iter().any(|x| 0.0 < *x && *x < least_normal)
    }
}

/// Wrong at one size of the scene, between those that K1 tries.
struct LosesOneSize;
impl Lapse for LosesOneSize {
    fn skips<S: Scalar>(_: &Ray<S>, own: &Aabb<S>, _: S) -> bool {
        let largest = own.max.to_array().map(|x| x.abs().to_f64()).into_iter().fold(0.0, f64::max);
        let exponent = largest.log2().floor();
        if S::NAME == "f32" { exponent == -14.0 } else { (-150.0..-120.0).contains(&exponent) }
    }
}

/// Boxes a little too small: the ends of long triangles stick out.
pub struct ShrinksBoxes;
impl Lapse for ShrinksBoxes {
    fn skips<S: Scalar>(ray: &Ray<S>, own: &Aabb<S>, t_max: S) -> bool {
        let pad = own.size() * S::from_f64(0.02);
        let shrunk = Aabb { min: own.min + pad, max: own.max - pad };
        shrunk.clip(ray.origin, ray.direction, ray.t_min, t_max).is_none()
    }
}

/// All triangles, tested by itself; which hit it hands on is its fault.
pub struct Own<S: Scalar, F> {
    set: TriangleSet<S>,
    kind: std::marker::PhantomData<F>,
}

pub trait Choice: Send + Sync + 'static {
    /// Chooses from all hits, sorted.
    fn of<S: Scalar>(ray: &Ray<S>, hits: &[Hit<S>]) -> Option<u32>;
}

impl<S: Scalar, F: Choice> Structure<S> for Own<S, F> {
    type Config = ();

    fn build(prims: &dyn Primitives<S>, settings: &Settings<()>) -> Result<Self, BuildError> {
        let corners = (0..prims.len() as u32).filter_map(|id| prims.corners(id));
        let triangles = corners.map(|t| t.map(|p| p.to_array())).collect();
        let none = BuildError::NoPrimitives { structure: settings.structure() };
        let set = TriangleSet::new(triangles, |_| false).map_err(|_| none)?;
        Ok(Self { set, kind: std::marker::PhantomData })
    }

    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        let setup = self.set.setup(ray);
        let hit = |id| self.set.intersect(id, ray, &setup, ray.t_max).map(|t| Hit { t, id });
        let mut hits: Vec<Hit<S>> = (0..self.set.len() as u32).filter_map(hit).collect();
        hits.sort_by(|a, b| a.t.to_f64().total_cmp(&b.t.to_f64()).then(a.id.cmp(&b.id)));
        if let Some(id) = F::of(ray, &hits) {
            let _ = sink.test(&[id]);
        }
    }

    fn stats(&self) -> StructureStats {
        StructureStats::default()
    }
}

/// Returns the highest id of equal hits.
pub struct HighestId;
impl Choice for HighestId {
    fn of<S: Scalar>(_: &Ray<S>, hits: &[Hit<S>]) -> Option<u32> {
        let first = hits.first()?;
        hits.iter().take_while(|hit| hit.t == first.t).last().map(|hit| hit.id)
    }
}

/// Right where a ray begins; on its way every second surface is passed over.
struct MissesOddCrossings;
impl Choice for MissesOddCrossings {
    fn of<S: Scalar>(ray: &Ray<S>, hits: &[Hit<S>]) -> Option<u32> {
        let skipped = usize::from(ray.t_min > S::ZERO && hits.len() % 2 == 1);
        hits.get(skipped).map(|hit| hit.id)
    }
}

/// Batches of one ray are lost.
struct LosesLoneRays;

impl BatchFault for LosesLoneRays {
    fn answer<S: Scalar, P: PrimSet<S>>(prims: &P, batch: &mut RayBatch<'_, S>) {
        match (batch.rays, &mut batch.answers) {
            ([ray], BatchAnswers::Closest([hit])) => *hit = Hit { t: ray.t_max, ..Hit::NONE },
            _ => answered_by_brute_force(prims, batch),
        }
    }
}

static FAULTS: &[Entry] = &[
    accel_core::entry!(brute_force::BruteForce, brute_force::INFO),
    accel_core::entry!(uniform_grid::UniformGrid, uniform_grid::INFO),
    planted_entry!("below-planes", Boxes<S, SkipsBelowPlanes>),
    planted_entry!("at-zero", Boxes<S, BeginsAtZero>),
    planted_entry!("denormals", Boxes<S, LosesDenormals>),
    planted_entry!("one-size", Boxes<S, LosesOneSize>),
    planted_entry!("highest", Own<S, HighestId>),
    planted_entry!("odd-crossings", Own<S, MissesOddCrossings>),
    planted_entry!("shrunk", Boxes<S, ShrinksBoxes>),
    planted_entry!("lone-rays", Batched<S, LosesLoneRays>),
    accel_core::entry!(SilentShadows, SILENT_SHADOWS, prepare_f32, true),
    accel_core::entry!(SilentAll, SILENT, prepare_f32, true),
];

fn verify(arguments: &str) -> Ended {
    run_with(FAULTS, &InstalledScenes, &SystemClock::default(), &format!("verify {arguments}"))
}

/// The rows of the CSV file of a check with exit code `code`.
fn rows(code: u8, arguments: &str) -> Vec<std::collections::HashMap<String, String>> {
    let folder = Folder::new();
    let ended = verify(&format!("{arguments} -o {}", folder.path()));
    assert_eq!(ended.code, code, "{arguments}: {}{}", ended.out, ended.err);
    folder.csv_of("verify.csv")
}

#[test]
fn each_case_catches_its_fault_in_both_precisions() {
    for (case, structure, rays) in [
        ("Gr12", "below-planes", 1000),
        ("R8", "at-zero", 200),
        ("R9", "denormals", 400),
        ("K1dense", "one-size", 1000),
        ("G14", "highest", 1000),
        ("G15", "odd-crossings", 200),
        ("G16", "shrunk", 1000),
        ("R2", "lone-rays", 100),
    ] {
        let rows = rows(4, &format!("--cases {case} -s {structure} --rays {rays}"));
        assert_eq!(rows.len(), 2, "{case}");
        for row in rows {
            let of = (row["precision"].as_str(), row["mismatches"].as_str());
            assert!(of.1 != "0" && !of.1.is_empty(), "{case} {structure} {of:?}");
        }
    }
}

#[test]
fn unwritten_answers_are_wrong_for_every_ray() {
    // in these rays hit and miss
    for structure in ["silent", "silent-shadows"] {
        let rows = rows(4, &format!("--cases R1,R8 -s {structure} --rays 200"));
        assert_eq!(rows.len(), 4);
        for row in rows {
            assert_eq!(row["mismatches"], row["trials"], "{structure} {row:?}");
        }
    }
}

#[test]
fn the_sparse_scales_pass_what_the_dense_ones_catch() {
    let rows = rows(0, "--cases K1 -s one-size --rays 500");
    assert!(rows.iter().any(|row| row["mismatches"] == "0" && row["trials"] == "500"));
}

#[test]
fn equal_answers_have_equal_digests() {
    let case = "--cases R8,G15 -s brute-force,uniform-grid,odd-crossings --rays 200";
    let all = rows(4, case);
    let answers = |case: &str, structure: &str| {
        let of = |row: &&std::collections::HashMap<String, String>| {
            row["case"] == case && row["structure"] == structure && row["precision"] == "f64"
        };
        all.iter().find(of).unwrap()["answers"].clone()
    };
    assert_eq!(answers("R8", "brute-force"), answers("R8", "uniform-grid"));
    assert_ne!(answers("R8", "brute-force"), answers("G15", "brute-force"));
    assert_ne!(answers("G15", "brute-force"), answers("G15", "odd-crossings"));
    let said = |threads: u8| {
        let out = verify(&format!("-j {threads} --cases R8 -s uniform-grid --rays 1500")).out;
        out.lines().find(|l| l.contains("answers ")).unwrap().to_owned()
    };
    assert_eq!(said(1), said(2));
}

#[test]
fn out_of_time_prints_and_keeps_what_is_done() {
    let folder = Folder::new();
    let clock = SteppingClock::new(Duration::from_millis(1));
    let check = |limit: &str| {
        let arguments = format!(
            "verify -j 1 --cases R1,R2,R3 -s brute-force --rays 2000 --time-limit {limit} \
             --overwrite -o {}",
            folder.path()
        );
        run_with(FAULTS, &InstalledScenes, &clock, &arguments)
    };
    // the clock is read before each case, round and structure
    let ended = check("14ms");
    assert_eq!(ended.code, 5, "{}", ended.err);
    assert!(ended.out.contains("INCOMPLETE (out of time after "), "{}", ended.out);
    let rows = folder.csv_of("verify.csv");
    assert!(rows[0]["case"] == "R1" && rows[0]["rounds"] == "4", "{rows:?}");
    assert!(!rows.is_empty() && rows.len() < 6, "{rows:?}");
    let record: serde_json::Value = serde_json::from_str(&folder.text("verify.json")).unwrap();
    assert_eq!(record["cut"], "out-of-time");
    assert!(record["rounds_asked"].as_u64() < record["rounds"].as_u64());
    let ended = check("1h");
    assert!(ended.code == 0 && !ended.out.contains("INCOMPLETE"), "{}", ended.out);
    assert_eq!(folder.csv_of("verify.csv").len(), 6);
}

#[test]
fn further_settings_are_checked_on_request() {
    let labels = |arguments: &str| -> Vec<String> {
        rows(0, arguments).into_iter().map(|mut row| row.remove("structure").unwrap()).collect()
    };
    let usual = labels("--cases R4 --rays 10 -s uniform-grid");
    let all = labels("--cases R4 --rays 10 -s uniform-grid --also-tested");
    assert_eq!(usual.len(), 2);
    let further = uniform_grid::INFO.also_tested.len();
    assert_eq!(all.len(), 2 * (1 + further));
    assert!(all.contains(&"uniform-grid resolution=cubic".to_owned()), "{all:?}");
}

/// A check as a real process, which would take hours; it is watching for signals.
#[cfg(unix)]
fn long_check(folder: &Folder, out: std::process::Stdio) -> std::process::Child {
    use std::process::{Command, Stdio};
    let file = format!("{}/verify.csv", folder.path());
    let mut command = Command::new(env!("CARGO_BIN_EXE_rtbench"));
    let arguments = "verify -j 1 --cases R1,R2 -s uniform-grid --rays 30000000 -o";
    command.args(arguments.split(' ')).arg(folder.path()).stdout(out).stderr(Stdio::piped());
    let child = command.spawn().unwrap();
    // signals are watched before the file is there
    while !std::path::Path::new(&file).exists() {
        std::thread::sleep(Duration::from_millis(10));
    }
    child
}

/// Sends SIGINT so many times, one after the other: two at the same time would be one.
#[cfg(unix)]
fn interrupt(child: &std::process::Child, times: usize) {
    for _ in 0..times {
        let pid = child.id().to_string();
        assert!(
            std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap().success()
        );
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_check_prints_and_keeps_what_is_done() {
    // `timeout -s INT` sends it to the process and to its group
    for times in [1, 2] {
        let (output, folder) = loop {
            let folder = Folder::new();
            let child = long_check(&folder, std::process::Stdio::piped());
            let begin = std::time::Instant::now();
            interrupt(&child, times);
            // on a busy machine the second may be too late to be the same request
            let is_one_request = begin.elapsed() < GRACE / 2;
            let output = child.wait_with_output().unwrap();
            if is_one_request {
                break (output, folder);
            }
        };
        let out = String::from_utf8(output.stdout).unwrap();
        assert_eq!(output.status.code(), Some(130), "{times} times: {out}");
        assert!(out.contains("INCOMPLETE (interrupted by signal 2 after "), "{times} times: {out}");
        let rows = folder.csv_of("verify.csv");
        assert!(rows.iter().all(|row| row["case"] == "R1"), "{rows:?}");
    }
}

/// A check whose table nobody takes never ends by itself.
#[cfg(unix)]
#[test]
fn a_later_interrupt_ends_a_check_at_once() {
    use std::io::{Read, Write};
    let folder = Folder::new();
    let (mut reader, writer) = std::io::pipe().unwrap();
    let mut full = writer.try_clone().unwrap();
    // until there is no room, and then until nobody reads
    let filler = std::thread::spawn(move || while full.write_all(&[b'.'; 4096]).is_ok() {});
    let mut child = long_check(&folder, writer.into());
    let status = loop {
        interrupt(&child, 1);
        std::thread::sleep(Duration::from_millis(100));
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
    };
    assert_eq!(status.code(), Some(130));
    let mut some = vec![0; 1 << 16];
    let read = reader.read(&mut some).unwrap();
    assert!(read > 0 && some[..read].iter().all(|byte| *byte == b'.'), "its table was taken");
    drop(reader);
    filler.join().unwrap();
}
