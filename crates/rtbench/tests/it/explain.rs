//! `rtbench explain` end to end: factors that multiply to the whole, the same rays for all, planted
//! wrong rows, exports, errors.

use std::collections::HashMap;

use accel_core::params::config::Settings;
use accel_core::primitives::Primitives;
use accel_core::query::kernel;
use accel_core::query::sink::Sink;
use accel_core::structure::{BuildError, Structure, StructureInfo, StructureStats};
use accel_core::structures::{Entry, brute_force, obvhs};
use accel_core::{Ray, Scalar};
use measurement::record::Verdict;
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SystemClock;

use crate::common::{Dropper, Folder, planted, row, run, run_stepping, run_with};

type Row = HashMap<String, String>;

fn csv(folder: &Folder) -> Vec<Row> {
    csv::Reader::from_reader(folder.text("explain.csv").as_bytes())
        .deserialize()
        .collect::<Result<_, _>>()
        .expect("CSV that parses back")
}

/// By kind of ray: the factors' names, their product, the whole.
fn products(rows: &[Row]) -> HashMap<String, (Vec<String>, f64, f64)> {
    let mut found: HashMap<String, (Vec<String>, f64, f64)> = HashMap::new();
    for row in rows {
        let of = found.entry(row["rays"].clone()).or_insert((Vec::new(), 1.0, f64::NAN));
        let ratio = || row["ratio"].parse::<f64>().expect("a ratio");
        match row["part"].as_str() {
            "factor" => {
                of.0.push(row["name"].clone());
                of.1 *= ratio();
            }
            "whole" => of.2 = ratio(),
            _ => {}
        }
    }
    found
}

#[test]
fn factors_multiply_to_the_whole_for_every_kind_of_ray() {
    let folder = Folder::new();
    let ended = run(&format!("explain tetra:2 --size 16 -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
    let rows = csv(&folder);
    let products = products(&rows);
    let mut kinds: Vec<&String> = products.keys().collect();
    kinds.sort();
    assert_eq!(kinds, ["all", "diffuse", "primary", "shadow"]);
    for (kind, (names, product, whole)) in &products {
        assert_eq!(
            names[..],
            [
                "adapter: direct to robust",
                "kernel: scalar to block",
                "structure: obvhs-cwbvh to uniform-grid"
            ]
        );
        assert!((product / whole - 1.0).abs() < 1e-6, "{kind}: {product} {whole}");
    }
    let crafts: Vec<(&str, &str)> = rows
        .iter()
        .filter(|r| r["rays"] == "all" && r["part"] == "row")
        .map(|r| (r["structure"].as_str(), r["craft"].as_str()))
        .collect();
    assert_eq!(
        crafts,
        [
            ("uniform-grid", "block"),
            ("uniform-grid", "scalar"),
            ("uniform-grid", "block, batch"),
            ("obvhs-cwbvh", "direct"),
            ("obvhs-cwbvh", "scalar"),
            ("obvhs-cwbvh", "block"),
        ]
    );
    let record = folder.record();
    assert!(record.scenes[0].rows.iter().all(|r| r.verdict == Verdict::Ok && r.checked_rays > 100));
    // the whole is the ratio that a run shows
    let ratio = row(&record, "uniform-grid").ratio.unwrap().median;
    assert!((products["all"].2 - ratio).abs() < 1e-6);
    assert!(folder.text("explain.md").contains("structure: obvhs-cwbvh to uniform-grid"));
    for said in
        ["obvhs-cwbvh has no query=batch.", "whole: uniform-grid", "primary rays: time over"]
    {
        assert!(ended.out.contains(said), "{said}: {}", ended.out);
    }
    // the results of another row are not replaced
    let again =
        run_stepping(&format!("explain tetra:2 -s brute-force --size 16 -o {}", folder.path()));
    assert_eq!(again.code, 1, "{}", again.err);
    assert!(again.err.contains("--overwrite"), "{}", again.err);
}

#[test]
fn all_rows_are_asked_the_rays_of_the_slowest() {
    let folder = Folder::new();
    let arguments = "teapot --quick --rays primary -s brute-force --reference obvhs-cwbvh";
    let ended = run(&format!("explain {arguments} -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
    let rows = &folder.record().scenes[0].rows;
    assert!(rows[0].stride > 1 && rows.iter().all(|r| r.stride == rows[0].stride));
    let asked: Vec<u64> = rows.iter().map(|r| r.rays).collect();
    assert!(asked.iter().all(|n| *n == asked[0]), "{asked:?}");
    assert!(ended.out.contains("All rows are timed on one ray in"), "{}", ended.out);
    // a run asks the others more
    let ended = run(&format!(
        "run {} -o {}",
        arguments.replace(" -s", " --overwrite -s obvhs-cwbvh -s"),
        folder.path()
    ));
    assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
    let record = folder.record();
    assert!(row(&record, "obvhs-cwbvh").stride < row(&record, "brute-force").stride);
}

#[test]
fn queries_and_unsupported_scenes_are_reported() {
    let ended = run_stepping("explain tetra:2 --size 16 -s irregular-grid:query=batch");
    assert_eq!(ended.code, 2, "not in that registry: {}", ended.err);
    let run = |arguments: &str| {
        let ended = run_with(
            accel_core::structures::REGISTRY,
            &InstalledScenes,
            &SystemClock::default(),
            &format!("explain {arguments} --size 16 --rounds 3"),
        );
        assert_eq!(ended.code, 0, "{arguments}: {}{}", ended.out, ended.err);
        ended.out
    };
    let out = run("tetra:2 -s wide-bvh:query=batch");
    for said in ["query: one ray to batch", "wide-bvh has no kernel=scalar.", "block, batch"] {
        assert!(out.contains(said), "{said}: {out}");
    }
    let out = run("tetra:2 -s brute-force");
    assert!(out.contains("brute-force has no kernel=block, no query=batch."), "{out}");
    assert!(!out.contains("kernel: "), "both are tested one by one: {out}");
    let out = run("tetra:2 -s brute-force --reference wide-bvh");
    assert!(
        out.contains("No row separates these factors: kernel: block to scalar; structure:"),
        "{out}"
    );
    let out = run("balls:2 -s kd-tree");
    for said in ["primitives other than static triangles", "(as-shipped)", "as-shipped to robust"] {
        assert!(out.contains(said), "{said}: {out}");
    }
    assert!(!out.contains("kernel: "), "{out}");
    let out = run("balls:2 -s kd-tree:kernel=block --reference kd-tree");
    assert!(out.contains("in this scene both rows are the same"), "{out}");
}

/// Wrong with blocks alone.
pub struct WrongBlocks<S: Scalar>(Dropper<S>);

accel_core::config! {
    /// Which kernel.
    pub struct KernelConfig {
        is_block: bool = kernel::PARAM => |kernel| kernel == "block",
    }
}

static WRONG_BLOCKS: StructureInfo = StructureInfo {
    params: KernelConfig::PARAMS,
    ..planted("wrong-blocks", "forgets a primitive with blocks")
};

impl<S: Scalar> Structure<S> for WrongBlocks<S> {
    type Config = KernelConfig;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<KernelConfig>,
    ) -> Result<Self, BuildError> {
        Ok(Self(Dropper::of(prims, !settings.is_block)))
    }

    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        self.0.traverse(ray, sink);
    }

    fn stats(&self) -> StructureStats {
        self.0.stats()
    }
}

static PLANTED_BLOCKS: &[Entry] = &[
    accel_core::entry!(brute_force::BruteForce, brute_force::INFO),
    accel_core::entry!(obvhs::cwbvh::ObvhsCwBvh, obvhs::cwbvh::INFO),
    accel_core::entry!(WrongBlocks, WRONG_BLOCKS),
];

#[test]
fn a_planted_wrong_kernel_has_no_time_and_is_in_no_factor() {
    let explain = |row: &str| {
        let folder = Folder::new();
        let arguments = format!("explain tetra:2 --quick -s {row} -o {}", folder.path());
        let ended = run_with(PLANTED_BLOCKS, &InstalledScenes, &SystemClock::default(), &arguments);
        assert_eq!(ended.code, 4, "{}{}", ended.out, ended.err);
        (ended.out, csv(&folder))
    };
    // the wrong craft is no corner of the way
    let (out, rows) = explain("wrong-blocks");
    let wrong = rows.iter().find(|r| r["name"] == "wrong-blocks kernel=block").unwrap();
    assert_eq!((wrong["verdict"].as_str(), wrong["ratio"].as_str()), ("wrong", ""));
    let (names, product, whole) = &products(&rows)["all"];
    assert_eq!(names[..], ["adapter: direct to robust", "structure: obvhs-cwbvh to wrong-blocks"]);
    assert!((product / whole - 1.0).abs() < 1e-6);
    assert!(out.contains("whole: wrong-blocks"), "{out}");
    // the wrong row itself is not explained
    let (out, rows) = explain("wrong-blocks:kernel=block");
    assert!(rows.iter().all(|r| r["part"] == "row"));
    assert!(out.contains("Nothing is explained: wrong-blocks kernel=block is wrong."), "{out}");
    assert!(!out.contains("whole:"), "{out}");
}

#[test]
fn rows_that_cannot_be_explained_are_usage_errors() {
    for (arguments, said) in [
        ("tetra:2 -s obvhs-cwbvh", "is also the reference"),
        ("tetra:2 -s uniform-grid --reference uniform-grid", "is also the reference"),
        ("tetra:2 -s unifrom-grid", "did you mean 'uniform-grid'?"),
        ("tetra:2 -s uniform-grid:triangle-test=pluecker", "default tests"),
        ("tetra:2 --reference obvhs-cwbhv", "did you mean 'obvhs-cwbvh'?"),
        ("tetrra", "tetra"),
        ("", "SCENE"),
    ] {
        let ended = run_stepping(&format!("explain {arguments}"));
        assert_eq!(ended.code, 2, "{arguments}: {}", ended.err);
        assert!(ended.err.contains(said), "{arguments}: {}", ended.err);
    }
}
