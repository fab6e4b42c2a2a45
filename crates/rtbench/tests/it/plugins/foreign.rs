//! A program outside as a row of a run's results.

use std::fs;
use std::path::Path;

use measurement::record::Verdict;

use super::by_files::answered;
use super::rtbench;
use crate::common::Folder;

/// The results of a run, and files of right answers to its rays.
struct Outside {
    results: Folder,
    files: Folder,
}

impl Outside {
    fn new() -> Self {
        let outside = Self { results: Folder::new(), files: Folder::new() };
        let run = ["run", "tetra:3", "--quick", "--size", "24", "--rays", "primary,diffuse,shadow"];
        let rows = ["-s", "wide-bvh,hug", "-o", &outside.results.path()];
        let ended = rtbench(&[&run[..], &rows].concat());
        assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
        outside
    }

    fn file(&self, name: &str) -> String {
        Path::new(&self.files.path()).join(name).to_str().unwrap().to_owned()
    }

    /// A file of hits to the rays of these options, with the ids changed by `fault`.
    fn hits(&self, name: &str, options: &[&str], fault: fn(&mut [u8])) -> String {
        let [rays, triangles, hits] =
            ["rays", "tris", "hits"].map(|e| self.file(&format!("{name}.{e}")));
        let export = ["rays", "export", "tetra:3", "-o", &rays, "--triangles", &triangles];
        let ended = rtbench(&[&export[..], options].concat());
        assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
        let mut answers = answered(&fs::read(rays).unwrap(), &fs::read(triangles).unwrap());
        answers[128..].chunks_mut(8).for_each(|record| fault(&mut record[4..8]));
        fs::write(&hits, answers).unwrap();
        hits
    }

    /// Result of merging a file.
    fn merged(&self, hits: &str, more: &[&str]) -> (i32, String) {
        let into = self.results.path();
        let check = ["rays", "check", "tetra:3", hits, "--into", &into, "--time-ms", "0.5"];
        let ended = rtbench(&[&check[..], more].concat());
        let said = String::from_utf8_lossy(&[ended.stdout, ended.stderr].concat()).into_owned();
        (ended.status.code().unwrap(), said)
    }

    fn written(&self, name: &str) -> String {
        fs::read_to_string(Path::new(&self.results.path()).join(name)).unwrap()
    }
}

const KINDS: [&str; 4] = ["--kind", "primary,diffuse,shadow", "--size", "24"];

#[test]
fn foreign_rows_are_marked_and_never_compared() {
    let outside = Outside::new();
    let before = outside.results.record();
    let good = outside.hits("good", &KINDS, |_| {});
    let (code, said) = outside.merged(&good, &["--name", "gpu tracer", "--build-ms", "2"]);
    assert_eq!(code, 0, "{said}");
    let record = outside.results.record();
    let [row] = &record.scenes[0].foreign[..] else { panic!("{:?}", record.scenes[0].foreign) };
    assert_eq!((row.structure.as_str(), row.verdict), ("gpu tracer", Verdict::Ok));
    assert_eq!(row.checked_rays, before.scenes[0].distinct_rays());
    assert_eq!((row.trace_s.unwrap().median, row.build_s.unwrap().median), (0.0005, 0.002));
    assert!(row.ratio.is_none() && row.samples.is_empty());
    // rows, means and all else are what they were
    assert_eq!(record.scenes[0].rows, before.scenes[0].rows);
    assert_eq!(record.summary, before.summary);
    let line = |name: &str| -> String {
        let text = outside.written(name);
        text.lines().find(|line| line.contains("gpu tracer")).unwrap_or_default().to_owned()
    };
    assert!(line("results.csv").contains(",foreign"), "{}", line("results.csv"));
    assert!(line("results.md").contains("| ok"), "{}", line("results.md"));
    assert!(outside.written("results.md").contains("tetra:3: foreign rows"));
    // a page of them
    let ended = rtbench(&["report", &outside.results.path()]);
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let mut files = fs::read_dir(outside.results.path()).unwrap().map(|e| e.unwrap().path());
    let page = files.find(|p| p.extension().is_some_and(|e| e == "html")).unwrap();
    let page = fs::read_to_string(page).unwrap();
    assert!(page.contains("program (foreign)") && page.contains("gpu tracer"));
    // the name is taken: by itself, and by a row of the run
    let (code, said) = outside.merged(&good, &["--name", "gpu tracer"]);
    assert!(code == 1 && said.contains("has a row 'gpu tracer'"), "{said}");
    let (code, said) = outside.merged(&good, &["--name", "wide-bvh", "--overwrite"]);
    assert!(code == 1 && said.contains("has a row 'wide-bvh'"), "{said}");
    let (code, said) = outside.merged(&good, &["--name", "gpu tracer", "--overwrite"]);
    assert_eq!(code, 0, "{said}");
    assert_eq!(outside.results.record().scenes[0].foreign.len(), 1);
}

#[test]
fn wrong_answers_have_no_time() {
    let outside = Outside::new();
    let bad = outside.hits("bad", &KINDS, |id| id.fill(255));
    let (code, said) = outside.merged(&bad, &["--name", "liar"]);
    assert_eq!(code, 4, "{said}");
    let record = outside.results.record();
    let row = &record.scenes[0].foreign[0];
    assert_eq!(row.verdict, Verdict::Wrong);
    assert!(row.trace_s.is_none() && row.mismatches > 0);
    let markdown = outside.written("results.md");
    let line = markdown.lines().find(|line| line.contains("| liar")).unwrap();
    assert!(line.contains("wrong") && !line.contains("0.5"), "{line}");
    assert!(markdown.contains("drops a hit"), "{markdown}");
}

#[test]
fn results_of_other_rays_take_no_row() {
    let outside = Outside::new();
    let before = outside.written("results.json");
    let others: [(&[&str], &str); 3] = [
        (&["--kind", "primary", "--size", "16"], "--size 16, the run had 24"),
        (&["--kind", "primary", "--size", "24", "--seed", "9"], "--seed 9, the run had 1"),
        (&["--kind", "primary,shadow", "--size", "24", "--lights", "first"], "--lights first"),
    ];
    for (i, (options, why)) in others.into_iter().enumerate() {
        let hits = outside.hits(&format!("other-{i}"), options, |_| {});
        let (code, said) = outside.merged(&hits, &["--name", "other"]);
        assert!(code == 1 && said.contains(why), "{code} {said}");
        assert_eq!(outside.written("results.json"), before);
    }
    let good = outside.hits("good", &KINDS, |_| {});
    let path = Path::new(&outside.results.path()).join("results.json");
    for (was, is, why) in [
        ("\"complete\": true", "\"complete\": false", "the run is not finished"),
        ("\"sha256\": \"", "\"sha256\": \"0", "no scene tetra:3 with this content"),
    ] {
        assert!(before.contains(was));
        fs::write(&path, before.replace(was, is)).unwrap();
        let (code, said) = outside.merged(&good, &["--name", "other"]);
        assert!(code == 1 && said.contains(why), "{said}");
    }
    // a name and a time go with a place
    let ended = rtbench(&["rays", "check", "tetra:3", &good, "--into", &outside.results.path()]);
    assert_eq!(ended.status.code(), Some(2));
}
