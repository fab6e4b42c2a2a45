//! Samples, cones and beams on the command line.

use crate::common::{Folder, run, run_stepping};

#[test]
fn tracers_are_listed_with_unsupported_scenes() {
    let ended = run("list tracers");
    assert_eq!((ended.code, ended.err.as_str()), (0, ""));
    let listed_words = ended.out.split_whitespace().collect::<Vec<_>>().join(" ");
    for tracer in renderer::tracers::TRACERS {
        for text in [tracer.name, tracer.paper, tracer.assumptions, tracer.refuses] {
            assert!(!text.is_empty() && listed_words.contains(text), "{text}");
        }
    }
    let listed: serde_json::Value =
        serde_json::from_str(&run("list tracers --format json").out).unwrap();
    assert_eq!(listed.as_array().map(Vec::len), Some(renderer::tracers::TRACERS.len()));
}

#[test]
fn more_samples_reduce_the_error_and_all_files_are_written() {
    let folder = Folder::new();
    let ended = run_stepping(&format!(
        "compare-tracers effect-plain --tracers whitted --samples 64,1,16,1 --size 12 \
         --reference-samples 1024 --rounds 2 -o {}",
        folder.path()
    ));
    assert_eq!((ended.code, ended.err.as_str()), (0, ""), "{}", ended.out);
    let rows: Vec<std::collections::HashMap<String, String>> =
        csv::Reader::from_reader(folder.text("tracers.csv").as_bytes())
            .deserialize()
            .collect::<Result<_, _>>()
            .unwrap();
    let column = |name: &str| -> Vec<String> { rows.iter().map(|r| r[name].clone()).collect() };
    assert_eq!(column("samples"), ["1", "16", "64"]);
    let errors: Vec<f64> = column("rmse").iter().map(|e| e.parse().unwrap()).collect();
    assert!(errors[0] > 2.0 * errors[1] && errors[1] > errors[2] && errors[2] > 0.0, "{errors:?}");
    // on this clock all images take as long: the best one alone is on the front
    assert_eq!(column("on_front"), ["false", "false", "true"]);
    assert_eq!(column("ratio_to_cheapest"), ["1.000000000"; 3]);
    let json: serde_json::Value = serde_json::from_str(&folder.text("tracers.json")).unwrap();
    assert_eq!(json["images"].as_array().map(Vec::len), Some(3));
    let table = folder.text("tracers.md");
    let row = table.lines().find(|line| line.starts_with("| whitted 16 |")).unwrap();
    let head = table.lines().find(|line| line.starts_with("| tracer |")).unwrap();
    assert_eq!(row.matches(" |").count(), head.matches(" |").count(), "{row}");
    assert!(folder.text("tracers.svg").contains("root mean square error"));
    for image in ["reference", "whitted-1", "whitted-64"] {
        assert!(std::fs::metadata(format!("{}/{image}.png", folder.path())).is_ok(), "{image}");
    }
}

#[test]
fn invalid_options_of_compare_tracers_are_usage_errors() {
    for (arguments, said) in [
        ("compare-tracers effect-plain --tracers whited", "did you mean 'whitted'?"),
        ("compare-tracers effect-plain --without sphere", "did you mean 'spheres'?"),
        ("compare-tracers effect-plain --through octree", "unknown structure 'octree'"),
        ("compare-tracers effects", "one scene"),
        ("compare-tracers effect-plain --samples 0", "--samples"),
        ("compare-tracers effect-plain --size 0", "--size"),
    ] {
        let ended = run(arguments);
        assert_eq!(ended.code, 2, "{arguments}: {}", ended.err);
        assert!(ended.err.contains(said), "{arguments}: {}", ended.err);
    }
}
