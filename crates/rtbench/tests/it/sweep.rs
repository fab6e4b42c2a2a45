//! `rtbench sweep` end to end: rows, marks, exports, errors.

use std::collections::HashMap;

use crate::common::{Folder, PLANTED, WRONG_ONLY, run, run_stepping, run_with};
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SystemClock;

type Row = HashMap<String, String>;

fn csv(folder: &Folder) -> Vec<Row> {
    csv::Reader::from_reader(folder.text("sweep.csv").as_bytes())
        .deserialize()
        .collect::<Result<_, _>>()
        .expect("CSV that parses back")
}

/// All texts of the plot, which must be well-formed XML.
fn svg_texts(folder: &Folder) -> Vec<String> {
    let svg = folder.text("sweep.svg");
    let tree = roxmltree::Document::parse(&svg).expect("well-formed XML");
    let texts = tree.descendants().filter(|n| n.has_tag_name("text"));
    texts.map(|n| n.text().unwrap_or_default().to_owned()).collect()
}

#[test]
fn density_is_swept_with_the_rules_of_thumb_beside_it() {
    let folder = Folder::new();
    let arguments = "sweep tetra:2 balls:1 -s uniform-grid -p density --values 0.5..8:3";
    let ended = run_stepping(&format!("{arguments} --quick -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let rows = csv(&folder);
    // Three values, of which 2 is the default; six rules of thumb; the reference.
    assert_eq!(rows.len(), 2 * 10);
    let tetra = &rows[..10];
    let values: Vec<&str> = tetra[..3].iter().map(|r| r["value"].as_str()).collect();
    assert_eq!(values, ["0.5", "2", "8"]);
    // On the stepping clock all are equally fast: the first is the best, no other differs.
    let marks: Vec<&str> = tetra.iter().map(|r| r["marks"].as_str()).collect();
    assert_eq!(marks[..4], ["best", "~best; default", "~best", "rule: woo"]);
    assert!(marks.contains(&"rule: regular") && marks.contains(&"rule: auto"));
    assert_eq!(marks[9], "reference");
    assert_eq!((tetra[9]["structure"].as_str(), tetra[9]["value"].as_str()), ("obvhs-cwbvh", ""));
    for row in tetra {
        assert_eq!((row["parameter"].as_str(), row["verdict"].as_str()), ("density", "ok"));
        assert_eq!(row["to_best"].parse::<f64>(), Ok(1.0));
        for number in ["n_v", "n_oiv", "memory_bytes", "build_s", "trace_s", "n_it", "n_ts"] {
            assert!(row[number].parse::<f64>().is_ok_and(|x| x > 0.0), "{number}");
        }
    }
    let cells = |r: &Row| r["cells_per_primitive"].parse::<f64>().unwrap();
    assert!(cells(&tetra[0]) < cells(&tetra[1]) && cells(&tetra[1]) < cells(&tetra[2]));
    assert!(ended.out.contains("Best: density=0.5; not significantly different: 2, 8."));
    assert!(ended.out.contains("at an end of those measured"), "{}", ended.out);
    assert!(folder.text("sweep.md").contains("rule: woo"));
    let texts = svg_texts(&folder);
    for text in ["tetra:2: density of uniform-grid", "balls:1: density of uniform-grid"] {
        assert!(texts.iter().any(|t| t == text), "{texts:?}");
    }
    assert!(texts.iter().any(|t| t == "best: 0.5") && texts.iter().any(|t| t == "rule: cubic"));
    assert_eq!(folder.record().scenes.len(), 2);
}

#[test]
fn words_are_swept_as_typed_and_the_default_is_added() {
    let folder = Folder::new();
    let arguments = "sweep tetra:2 -s uniform-grid:resolution=woo:density=4 -p mailbox \
                     --values hash,array --rays primary";
    let ended = run_stepping(&format!("{arguments} --quick -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let rows = csv(&folder);
    let values: Vec<&str> = rows.iter().map(|r| r["value"].as_str()).collect();
    assert_eq!(values, ["hash", "array", "none", ""]);
    assert_eq!(rows[2]["marks"], "default");
    assert_eq!(rows[0]["settings"], "resolution=woo density=4 mailbox=hash");
    assert!(!ended.out.contains("at an end"), "words have no order");
    let texts = svg_texts(&folder);
    assert!(["hash", "array", "none"].iter().all(|word| texts.iter().any(|t| t == word)));
}

#[test]
fn whole_numbers_of_a_range_are_distinct() {
    let folder = Folder::new();
    let arguments = "sweep tetra:2 -s uniform-grid:mailbox=hash -p mailbox-slots --values 2..4:9 \
                     --rays primary";
    let ended = run_stepping(&format!("{arguments} --quick -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let rows = csv(&folder);
    let swept: Vec<&str> =
        rows.iter().filter(|r| r["marks"].contains("best")).map(|r| r["value"].as_str()).collect();
    assert_eq!(swept, ["2", "3", "4"]);
}

#[test]
fn invalid_sweeps_are_usage_errors_that_name_valid_values() {
    let range = "--values 1..4";
    for (arguments, said) in [
        (format!("tetra:2 -s unifrom-grid -p density {range}"), "did you mean 'uniform-grid'?"),
        (format!("tetra:2 -s uniform-grid -p densty {range}"), "did you mean 'density'?"),
        (format!("tetra:2 -s brute-force -p density {range}"), "it has time-segments"),
        (format!("tetrra -s uniform-grid -p density {range}"), "tetra"),
        (format!("tetra:2 -s uniform-grid -p mailbox {range}"), "one of none"),
        (format!("tetra:2 -s uniform-grid -p resolution {range}"), "--values"),
        (format!("tetra:2 -s uniform-grid:density=3 -p density {range}"), "is swept"),
        (format!("tetra:2 -s uniform-grid:mailbox -p density {range}"), "PARAM=VALUE"),
        (format!("tetra:2 -s uniform-grid:mailbox=x -p density {range}"), "one of none"),
        (format!("tetra:2 -s uniform-grid:mailbix=x -p density {range}"), "'mailbox'?"),
        (format!("tetra:2 -s uniform-grid -p density {range}:1"), "a number from"),
        (format!("tetra:2 -s uniform-grid -p density {range} --reference x"), "unknown structure"),
        (format!("tetra:2 -s uniform-grid -p density {range} --rays primery"), "'primary'?"),
        (format!("-s uniform-grid -p density {range}"), "SCENE"),
        ("tetra:2 -s uniform-grid -p density --values 4..4".into(), "must be below"),
        ("tetra:2 -s uniform-grid -p density --values 0..4".into(), "a number from"),
        ("tetra:2 -s uniform-grid -p density --values nan..4".into(), "a number from"),
        ("tetra:2 -s uniform-grid -p density --values 1..".into(), "a number from"),
        ("tetra:2 -s uniform-grid -p density".into(), "--values"),
        ("tetra:2 -s uniform-grid -p density --values 1,many".into(), "a number from"),
        ("tetra:2 -s uniform-grid -p mailbox --values none,".into(), "one of none"),
        ("tetra:2 -s uniform-grid -p max-cells --values 1.5..9".into(), "a whole number from"),
    ] {
        let ended = run(&format!("sweep {arguments}"));
        assert_eq!(ended.code, 2, "{arguments}: {}", ended.err);
        assert!(ended.err.contains(said), "{arguments}: {}", ended.err);
        assert_eq!(ended.out, "", "{arguments}");
    }
}

#[test]
fn equal_ratios_need_a_start_above_zero() {
    let arguments = "sweep tetra:2 -s planted -p depth --values";
    for (values, code) in [("0..4", 2), ("-1..4", 2), ("1..4", 4), ("0,2,4", 4)] {
        let ended = run_with(
            WRONG_SWEPT,
            &InstalledScenes,
            &SystemClock::default(),
            &format!("{arguments}={values} --quick --rounds 1"),
        );
        assert_eq!(ended.code, code, "{values}: {}", ended.err);
        let is_told = ended.err.contains("list the values");
        assert_eq!(is_told, values == "0..4", "{}", ended.err);
    }
}

#[test]
fn an_unwritable_folder_is_found_before_measuring() {
    let folder = Folder::new();
    let file = format!("{}/file", folder.path());
    std::fs::write(&file, "").unwrap();
    let arguments = "sweep balls:7 -s uniform-grid -p density --values 1,2";
    let ended = run(&format!("{arguments} -o {file}/below"));
    assert_eq!(ended.code, 1, "{}", ended.err);
    assert!(ended.err.contains("cannot write"), "{}", ended.err);
}

/// Right at depth 1, wrong at any other.
struct Planted<S>(crate::common::Dropper<S>);

accel_core::config! {
    struct PlantedConfig {
        depth: u64 = accel_core::params::ParamSpec::integer("depth", "1", 0, 9),
    }
}

impl<S: accel_core::Scalar> accel_core::structure::Structure<S> for Planted<S> {
    type Config = PlantedConfig;

    fn build(
        prims: &dyn accel_core::primitives::Primitives<S>,
        settings: &accel_core::params::config::Settings<PlantedConfig>,
    ) -> Result<Self, accel_core::structure::BuildError> {
        Ok(Self(crate::common::Dropper::of(prims, settings.depth == 1)))
    }

    fn traverse<K: accel_core::query::sink::Sink<S>>(
        &self,
        ray: &accel_core::Ray<S>,
        sink: &mut K,
    ) {
        self.0.traverse(ray, sink);
    }

    fn stats(&self) -> accel_core::structure::StructureStats {
        accel_core::structure::Structure::<S>::stats(&self.0)
    }
}

static PLANTED_INFO: accel_core::structure::StructureInfo = accel_core::structure::StructureInfo {
    params: PlantedConfig::PARAMS,
    ..accel_core::structure::StructureInfo::new("planted", "wrong at all depths but 1")
};

static WRONG_SWEPT: &[accel_core::structures::Entry] = &[
    accel_core::entry!(
        accel_core::structures::obvhs::cwbvh::ObvhsCwBvh,
        accel_core::structures::obvhs::cwbvh::INFO
    ),
    accel_core::entry!(crate::sweep::Planted, PLANTED_INFO),
];

#[test]
fn a_wrong_value_is_shown_as_wrong_and_never_best() {
    let folder = Folder::new();
    let arguments = "sweep tetra:2 -s planted -p depth --values 1,2,3 --quick --rounds 1";
    let clock = SystemClock::default();
    let command = format!("{arguments} -o {}", folder.path());
    let ended = run_with(WRONG_SWEPT, &InstalledScenes, &clock, &command);
    assert_eq!(ended.code, 4, "{}{}", ended.out, ended.err);
    let rows = csv(&folder);
    let verdicts: Vec<&str> = rows.iter().map(|r| r["verdict"].as_str()).collect();
    assert_eq!(verdicts, ["ok", "wrong", "wrong", "ok"]);
    assert_eq!(rows[0]["marks"], "best; default");
    for row in &rows[1..3] {
        assert!(row["mismatches"].parse::<u64>().is_ok_and(|n| n > 0));
        for empty in ["marks", "to_best", "trace_s", "build_s", "ratio_to_reference"] {
            assert_eq!(row[empty], "", "{empty}");
        }
    }
    assert!(ended.out.contains("wrong: "), "{}", ended.out);
    let texts = svg_texts(&folder);
    assert!(texts.iter().any(|t| t.contains("wrong or not built: 2, 3")), "{texts:?}");
}

#[test]
fn a_wrong_reference_leaves_times_per_ray_to_compare() {
    let ended = run_with(
        WRONG_ONLY,
        &InstalledScenes,
        &SystemClock::default(),
        "sweep tetra:2 -s dropper -p any --values 1",
    );
    assert_eq!(ended.code, 2, "a structure without parameters: {}", ended.err);
    let arguments = "sweep tetra:2 -s uniform-grid -p density --values 1,2 --reference dropper";
    let ended = run_with(
        &PLANTED,
        &InstalledScenes,
        &SystemClock::default(),
        &format!("{arguments} --quick --rounds 1"),
    );
    assert_eq!(ended.code, 4, "{}", ended.err);
    assert!(ended.out.contains("Best: density="), "by time per ray: {}", ended.out);
}
