//! `rtbench verify`: structures pass a fast subset, planted faults are caught, lines replay.

use crate::common::{Ended, Folder, PLANTED, planted_entry, run_with};
use accel_core::params::config::Settings;
use accel_core::primitives::Primitives;
use accel_core::query::sink::Sink;
use accel_core::structure::{BuildError, Structure, StructureStats};
use accel_core::structures::{Entry, REGISTRY};
use accel_core::{Ray, Scalar, Vector};
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SystemClock;
use renderer::ray_offset::OffsetRule;
use rtbench::context::Context;
use statistics::random::Random;
use studies::verify::cases::secondary::draws;
use studies::verify::judge::{Judge, RoundVerdict};
use studies::verify::subject::Subject;

/// Brute force that does not answer some rays: which ones is its fault.
struct Faulty<S, F> {
    ids: Vec<u32>,
    kind: std::marker::PhantomData<(S, F)>,
}

/// Rays that a faulty structure answers wrongly.
trait Fault: Send + Sync + 'static {
    fn loses(direction: [f64; 3]) -> bool;
}

struct NegativeZeros;
impl Fault for NegativeZeros {
    fn loses(direction: [f64; 3]) -> bool {
        direction.iter().any(|x| *x == 0.0 && x.is_sign_negative())
    }
}

struct LongDirections;
impl Fault for LongDirections {
    fn loses(direction: [f64; 3]) -> bool {
        direction.iter().any(|x| x.abs() > 1e6)
    }
}

struct ShortDirections;
impl Fault for ShortDirections {
    fn loses(direction: [f64; 3]) -> bool {
        direction.iter().all(|x| x.abs() < 1e-2)
    }
}

struct Panics;
impl Fault for Panics {
    fn loses(_: [f64; 3]) -> bool {
        panic!("planted")
    }
}

impl<S: Scalar, F: Fault> Structure<S> for Faulty<S, F> {
    type Config = ();

    fn build(prims: &dyn Primitives<S>, _: &Settings<()>) -> Result<Self, BuildError> {
        Ok(Self { ids: (0..prims.len() as u32).collect(), kind: std::marker::PhantomData })
    }

    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        if !F::loses(ray.direction.to_array().map(S::to_f64)) {
            let _ = sink.test(&self.ids);
        }
    }

    fn stats(&self) -> StructureStats {
        StructureStats::default()
    }
}

static FAULTS: &[Entry] = &[
    planted_entry!("negative-zeros", Faulty<S, NegativeZeros>),
    planted_entry!("long-directions", Faulty<S, LongDirections>),
    planted_entry!("short-directions", Faulty<S, ShortDirections>),
    planted_entry!("panics", Faulty<S, Panics>),
];

fn verify(registry: &[Entry], arguments: &str) -> Ended {
    run_with(
        registry,
        &InstalledScenes,
        &SystemClock::default(),
        &format!("verify -j 2 {arguments}"),
    )
}

fn replay(registry: &[Entry], line: &str) -> Ended {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let (clock, world) = (SystemClock::default(), rtbench::program::world());
    let mut context = Context::new(registry, &InstalledScenes, &clock, &world, &mut out, &mut err);
    let code = rtbench::run(&mut context, ["rtbench", "verify", "--replay", line]);
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Ended { code, out: text(out), err: text(err) }
}

/// The first line that a run offers for a replay.
fn offered(out: &str) -> String {
    out.split_once("--replay '").unwrap().1.split_once('\'').unwrap().0.to_owned()
}

/// Without G8, whose ten thousand triangles take longer than all others together.
#[test]
fn all_structures_pass_a_fast_subset() {
    let ended = verify(
        REGISTRY,
        "--cases ray,G1,G1far,G2,G3,G4,G5,G6,G7,G9,G10,G11,G11rim,G12,G13,G13scaled,K1,P1,grid,traversal,secondary \
         --rays 60",
    );
    let table = ended.out.lines().take(40).collect::<Vec<_>>().join("\n");
    assert_eq!(ended.code, 0, "{table}\n{}", ended.err);
    assert!(ended.out.contains("obvhs-cwbvh preset=fastest"), "{table}");
    let subject = "hashed-grid hash=constant";
    assert!(ended.out.lines().any(|l| l.starts_with(subject)), "{subject}: {table}");
    let words = ended.out.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("f32 serves 2^-30 to 2^32"), "{table}");
}

#[test]
fn all_structures_pass_motion_copies_glass_lights_frames_and_crowds() {
    let cases = "Q7,Q7segments,Q8,Q9,Q10,Q10occluders,Q11,Q12points,Q12denormal,S8";
    let ended = verify(REGISTRY, &format!("--cases {cases} --rays 60"));
    assert_eq!(ended.code, 0, "{}\n{}", ended.out, ended.err);
    for row in ["light-buffer", "wide-bvh time-segments=4", "hashed-grid update=incremental"] {
        assert!(ended.out.lines().any(|line| line.starts_with(row)), "{row}: {}", ended.out);
    }
}

#[test]
fn all_structures_pass_polygons_slender_cones_and_far_intervals() {
    let cases = "Q1,Q2,Q2slivers,Q3,Q3flat,Q4,Q6";
    let ended = verify(REGISTRY, &format!("--cases {cases} --rays 60"));
    assert_eq!(ended.code, 0, "{}\n{}", ended.out, ended.err);
}

#[test]
fn the_negative_control_misses_where_watertight_triangles_do_not() {
    let ended = verify(REGISTRY, "--cases G1 --rays 1500 -s brute-force,uniform-grid");
    assert_eq!(ended.code, 0, "{}", ended.out);
    let ended = verify(&REGISTRY[..1], "--cases G1 --rays 1500");
    let control = ended.out.lines().find(|l| l.starts_with("moeller-trumbore")).unwrap();
    assert!(ended.code == 0 && !control.contains(" 0/"), "{}", ended.out);
    let line = offered(&ended.out);
    assert!(line.ends_with("moeller-trumbore"), "{line}");
    let again = replay(REGISTRY, &line);
    assert!(again.code == 0 && again.out.contains("moeller-trumbore: said"), "{}", again.out);
}

#[test]
fn a_dropped_reference_is_caught_and_its_line_replays() {
    let folder = Folder::new();
    let arguments = format!("--cases geometry -s dropper --rays 300 -o {}", folder.path());
    let ended = verify(&PLANTED, &arguments);
    assert_eq!(ended.code, 4, "{}", ended.out);
    let line = offered(&ended.out);
    let again = replay(&PLANTED, &line);
    assert_eq!(again.code, 4, "{line}: {}", again.out);
    assert!(again.out.contains("dropper: said"), "{}", again.out);
    let right = replay(&PLANTED, &line.replace("dropper", "brute-force"));
    assert!(right.code == 0 && right.out.contains("brute-force: right"), "{}", right.out);
    let rows = folder.csv_of("verify.csv");
    assert!(rows.iter().any(|r| r["case"] == "G1" && r["mismatches"] != "0"));
}

#[test]
fn metamorphic_pairs_catch_what_agreement_alone_cannot() {
    let wrong = |case: &str, structure: &str| {
        let ended = verify(FAULTS, &format!("--cases {case} -s {structure} --rays 200"));
        assert_eq!(ended.code, 4, "{}", ended.out);
        ended.out
    };
    assert!(wrong("R1", "negative-zeros").contains("zeros of the other sign"));
    assert!(wrong("R3", "long-directions").contains("direction by 2^"));
    assert!(wrong("K1", "short-directions").contains("scaled by 2^-"));
    assert!(wrong("R1", "panics").contains("panicked"));
}

#[test]
fn unknown_cases_and_structures_are_errors_that_name_valid_ones() {
    let ended = verify(REGISTRY, "--cases G99");
    assert!(ended.code == 2 && ended.err.contains("G13"), "{}", ended.err);
    let ended = verify(REGISTRY, "-s unifrom-grid");
    assert!(ended.code == 2 && ended.err.contains("uniform-grid"), "{}", ended.err);
    let ended = verify(REGISTRY, "--cases Gr7 -s uniform-grid");
    assert!(ended.code == 2 && ended.err.contains("none of these cases applies"), "{}", ended.err);
    for line in [
        "G1",
        "G1 f32 seed=1 round=0 rays=500 ray=100000 brute-force",
        "G1 f32 seed=1 round=0 rays=50000000 ray=1 brute-force",
        "X f32 seed=1 round=0 rays=500 ray=0 a",
    ] {
        assert_eq!(replay(REGISTRY, line).code, 2, "{line}");
    }
}

#[test]
fn an_offset_of_zero_hits_the_surface_it_leaves() {
    let hits_with = |rule| {
        let mut random = Random::new(1, "offsets");
        let [(_, draw), ..] = draws::<f32>();
        let rounds = (0..40).map(|_| draw(&mut random, 500, rule).unwrap());
        let judged = rounds.map(|round| {
            let brute_force = Subject::parse(REGISTRY, "brute-force").unwrap();
            match Judge::new(&round).unwrap().judge(&brute_force) {
                RoundVerdict::Asked(wrong, _) => wrong.len(),
                other => panic!("{other:?}"),
            }
        });
        judged.sum::<usize>()
    };
    assert_eq!(hits_with(OffsetRule::default()), 0);
    assert!(hits_with(OffsetRule::None) > 1000);
    // absolute lengths are right at one scale only
    assert!(hits_with(OffsetRule::Fixed(1e-4)) > 100);
}
