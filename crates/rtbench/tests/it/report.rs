//! The page of `rtbench report`: its structure, what it says of wrong rows, what it lacks.

use crate::common::{Ended, Folder, run_stepping};
use measurement::record::Warning;
use roxmltree::{Document, Node, ParsingOptions};
use rtbench::report::SECTIONS;
use serde_json::{Value, json};

/// A small run in a folder, one of its rows wrong.
fn folder() -> Folder {
    let folder = Folder::new();
    let ended = run_stepping(&format!(
        "run tetra:2 balls:1 --size 16 --rounds 3 -s brute-force,uniform-grid,obvhs-cwbvh,dropper -o {}",
        folder.path()
    ));
    assert_eq!(ended.code, 4, "{}", ended.err);
    folder
}

/// Changes the record.
fn change(folder: &Folder, change: impl FnOnce(&mut Value)) {
    let mut record: Value = serde_json::from_str(&folder.text("results.json")).unwrap();
    change(&mut record);
    std::fs::write(format!("{}/results.json", folder.path()), record.to_string()).unwrap();
}

fn write(folder: &Folder, name: &str, content: impl AsRef<[u8]>) {
    let path = std::path::PathBuf::from(folder.path()).join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, content).unwrap();
}

fn report(folder: &Folder) -> Ended {
    run_stepping(&format!("report {}", folder.path()))
}

/// The page, made anew.
fn page(folder: &Folder) -> String {
    let ended = report(folder);
    assert_eq!((ended.code, ended.out.as_str()), (0, ""), "{}", ended.err);
    assert!(ended.err.starts_with("wrote "), "{}", ended.err);
    folder.text("report.html")
}

fn parsed(page: &str) -> Document<'_> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    Document::parse_with_options(page, options).expect("a page that is well-formed XML")
}

fn by_name<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.descendants().filter(move |n| n.tag_name().name() == name)
}

fn text(node: Node<'_, '_>) -> String {
    node.descendants().filter(|n| n.is_text()).filter_map(|n| n.text()).collect()
}

fn section<'a, 'i>(page: &'a Document<'i>, id: &str) -> Node<'a, 'i> {
    let found = by_name(page.root(), "section").find(|n| n.attribute("id") == Some(id));
    found.unwrap_or_else(|| panic!("no section {id}"))
}

#[test]
fn the_page_is_complete_accessible_and_loads_nothing() {
    let folder = folder();
    let page = page(&folder);
    let tree = parsed(&page);
    let sections: Vec<_> = by_name(tree.root(), "section").collect();
    let shown =
        SECTIONS.iter().filter(|s| sections.iter().any(|n| n.attribute("id") == Some(s.id)));
    let shown: Vec<&str> = shown.map(|s| s.title).collect();
    let titles: Vec<String> =
        sections.iter().map(|n| text(by_name(*n, "h2").next().unwrap())).collect();
    assert_eq!(titles, shown, "in their order, the answers first");
    assert_eq!(titles[0], "Answers");
    for table in by_name(tree.root(), "table") {
        assert!(!text(by_name(table, "caption").next().expect("a caption")).is_empty());
        assert!(by_name(table, "th").all(|th| th.attribute("scope").is_some()));
        let widths = by_name(table, "tr").map(|tr| tr.children().filter(Node::is_element).count());
        let widths: std::collections::BTreeSet<usize> = widths.collect();
        assert_eq!(widths.len(), 1, "{}", text(table));
        assert_eq!(table.parent().unwrap().attribute("class"), Some("scroll"));
    }
    for svg in by_name(tree.root(), "svg") {
        assert_eq!(svg.attribute("role"), Some("img"));
        assert!(svg.attribute("aria-label").is_some_and(|l| !l.is_empty()));
    }
    let svgs = by_name(tree.root(), "svg").count();
    assert!(svgs >= 10, "summary, bars and scatter of both scenes, wide and narrow");
    let foreign = ["link", "iframe", "object", "embed", "base"];
    assert!(foreign.iter().all(|name| by_name(tree.root(), name).next().is_none()));
    assert_eq!(by_name(tree.root(), "script").count(), 1, "the one whose hash the policy has");
    let images = by_name(section(&tree, "scenes"), "img").count();
    assert_eq!(images, 2, "a picture of each scene");
    for tr in by_name(section(&tree, "scenes"), "thead") {
        let heads: Vec<String> = by_name(tr, "th").map(text).take(5).collect();
        assert_eq!(heads, ["#", "structure", "ratio [range]", "build ms", "verdict"]);
    }
    for node in tree.descendants() {
        for attribute in node.attributes() {
            let (name, value) = (attribute.name(), attribute.value());
            assert!(!name.starts_with("on"), "{name}");
            if ["src", "href"].contains(&name) {
                let is_within = value.starts_with("data:image/");
                assert!(is_within || !value.contains("//"), "{name}={value}");
            }
        }
    }
    let style = text(by_name(tree.root(), "style").next().unwrap());
    assert!(!style.contains("url(") && !style.contains("@import"));
    for rule in ["prefers-color-scheme: dark", "@media print", "size: A4"] {
        assert!(style.contains(rule), "{rule}");
    }
    let plain = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!plain.contains("http:") && !plain.contains("https:"));
    // links within the page lead somewhere
    for link in by_name(tree.root(), "a").filter_map(|a| a.attribute("href")) {
        if let Some(id) = link.strip_prefix('#') {
            assert!(tree.descendants().any(|n| n.attribute("id") == Some(id)), "{link}");
        }
    }
}

#[test]
fn the_same_record_gives_the_same_page_and_its_plots_as_files() {
    let folder = folder();
    let page = page(&folder);
    let plots = format!("{}/plots", folder.path());
    let other = format!("{}/other.html", folder.path());
    let ended = run_stepping(&format!("report {} -o {other} --plots {plots}", folder.path()));
    assert_eq!((ended.code, ended.out.as_str()), (0, ""), "{}", ended.err);
    assert!(ended.err.starts_with("wrote "), "{}", ended.err);
    assert!(folder.text("other.html") == page);
    // elsewhere, a link to the record would lead nowhere
    let ended = run_stepping(&format!("report {}/results.json -o -", folder.path()));
    assert_eq!((ended.code, ended.err.as_str()), (0, ""));
    let link = "<a href=\"results.json\">";
    assert!(page.contains(link) && !ended.out.contains(link));
    let lines = |page: &str| page.lines().count();
    assert_eq!(lines(&ended.out), lines(&page), "the same page but for that");
    let files: Vec<_> = std::fs::read_dir(plots).unwrap().map(|f| f.unwrap().path()).collect();
    assert_eq!(2 * files.len(), by_name(parsed(&page).root(), "svg").count());
    for file in files {
        assert!(Document::parse(&std::fs::read_to_string(&file).unwrap()).is_ok(), "{file:?}");
    }
}

#[test]
fn names_that_are_markup_stay_text() {
    let folder = folder();
    let name = "</title><script>alert('1')</script>\"&";
    change(&folder, |record| {
        record["scenes"][0]["name"] = json!(name);
        record["scenes"][0]["warnings"] = json!([name]);
        record["scenes"][0]["rows"][1]["settings"] = json!(name);
        record["summary"][1]["settings"] = json!(name);
        record["command_line"] = json!([name]);
        record["machine"]["cpu"] = json!(name);
        record["warnings"] = json!([Warning::Drift { change: 1.5, governor: Some(name.into()) }]);
    });
    let page = page(&folder);
    let tree = parsed(&page);
    assert_eq!(by_name(tree.root(), "script").count(), 1);
    assert!(!page.contains("<script>alert"));
    let sections = by_name(tree.root(), "section");
    assert!(sections.filter(|section| text(*section).contains(name)).count() >= 5);
    assert!(text(section(&tree, "warnings")).matches(name).count() >= 2);
}

/// Cells of the rows of that structure in a section, heads left out.
fn cells(section: Node<'_, '_>, structure: &str) -> Vec<Vec<String>> {
    let rows = by_name(section, "tr").filter(|tr| {
        by_name(*tr, "th").any(|th| th.attribute("scope") == Some("row") && text(th) == structure)
    });
    rows.map(|tr| by_name(tr, "td").map(text).collect()).collect()
}

#[test]
fn a_wrong_row_shows_no_time_even_if_the_record_has_some() {
    let folder = folder();
    // planted: the row is wrong, and all its times are still there
    change(&folder, |record| {
        for scene in 0..2 {
            record["scenes"][scene]["rows"][1]["verdict"] = json!("wrong");
            record["scenes"][scene]["rows"][1]["mismatches"] = json!(7);
            assert!(record["scenes"][scene]["rows"][1]["trace_s"]["median"].is_f64());
        }
        record["summary"][1]["verdict"] = json!("wrong");
    });
    let page = page(&folder);
    let tree = parsed(&page);
    for structure in ["dropper", "uniform-grid"] {
        let of_scenes = cells(section(&tree, "scenes"), structure);
        assert_eq!(of_scenes.len(), 2);
        for row in of_scenes {
            // number, ratio, build, verdict, trace, memory, image, ...
            assert!([1, 2, 4, 6].iter().all(|&i| row[i] == "wrong"), "{row:?}");
            assert!(row[3].starts_with("wrong: "), "{row:?}");
        }
        let [summary] = &cells(section(&tree, "all-scenes"), structure)[..] else { panic!() };
        assert!(summary[2..4].iter().all(|cell| cell == "wrong"), "{summary:?}");
        let break_even = text(section(&tree, "break-even"));
        assert!(!break_even.contains(structure) && break_even.contains("obvhs-cwbvh"));
        assert!(text(section(&tree, "headlines")).contains(structure), "named as wrong");
    }
    let svg = by_name(section(&tree, "all-scenes"), "svg").next().unwrap();
    let words = by_name(svg, "text").filter(|t| t.text() == Some("wrong")).count();
    assert_eq!(words, 4, "trace and build of both wrong rows");
    assert!(by_name(section(&tree, "headlines"), "p").any(|p| text(p).contains("wrong hits of")));
}

#[test]
fn missing_sections_name_the_command_that_makes_them() {
    let folder = folder();
    change(&folder, |record| {
        record["complete"] = json!(false);
        record["planned"] = json!(["tetra:2", "balls:1", "tree"]);
    });
    let page = page(&folder);
    let tree = parsed(&page);
    let more = tree.descendants().find(|n| n.attribute("class") == Some("more")).unwrap();
    for id in ["counters", "lecture", "accuracy", "tracers", "sweeps", "heat-maps"] {
        let known = SECTIONS.iter().find(|s| s.id == id).unwrap();
        assert!(known.made_by.starts_with("rtbench "));
        assert!(text(more).contains(known.made_by), "{id}");
        let is_it = |n: &Node<'_, '_>| n.attribute("id") == Some(id);
        assert!(!tree.descendants().any(|n| is_it(&n)), "no section that has nothing");
    }
    assert_eq!(by_name(more, "li").count(), 6, "and of nothing else");
    assert!(text(section(&tree, "headlines")).contains("not finished: 2 of 3 scenes"));
}

#[test]
fn results_of_other_commands_are_shown() {
    let folder = folder();
    let dir = folder.path();
    for arguments in [
        format!(
            "accuracy precision --scene tetra:2 --quick --rounds 3 --trials 100 -o {dir}/accuracy"
        ),
        format!(
            "compare-tracers effect-plain --tracers whitted --samples 1,4 --size 8 \
             --reference-samples 16 --rounds 2 -o {dir}/tracers/effect-plain"
        ),
    ] {
        let ended = run_stepping(&arguments);
        assert_eq!(ended.code, 0, "{}", ended.err);
    }
    let ended = run_stepping(&format!(
        "sweep tetra:1 -s uniform-grid -p density --values 1,4 --size 8 --rounds 2 \
         -o {dir}/sweep-density"
    ));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let png: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\0\x40\0\0\0\x20";
    write(&folder, "heat-maps/tetra:2/tests.svg", "<svg xmlns=\"http://www.w3.org/2000/svg\"/>");
    // as before November 2026
    write(&folder, "heat-maps/tetra:2/time.png", png);
    write(&folder, "pictures/tetra:2.png", png);
    write(
        &folder,
        "havran1999.csv",
        "scene,structure,params,counter,published,ours,ratio,verdict\n\
         balls,best,hug,N_IT,18.80,22.03,1.17,differs: unexplained\n\
         tree,best,hug,N_IT,12.03,12.03,1,exact\n",
    );
    write(
        &folder,
        "zachmann2007.csv",
        "scene,lecture,ours,verdict,build_then,build_now,build_low,build_high,run_then,run_now,\
         run_low,run_high\nballs,hug,hug,ok,2,5,4,6,0.1,0.25,0.2,0.3\nballs,adaptive,adaptive-grid,\
         wrong,,7.5,7,8,,0.125,0.1,0.2\n",
    );
    let page = page(&folder);
    let tree = parsed(&page);
    assert!(!page.contains("class=\"more\""));
    let shown = by_name(section(&tree, "scenes"), "img").next().unwrap();
    assert!(shown.attribute("src").unwrap().ends_with("SUhEUgAAAEAAAAAg"), "the one in the folder");
    assert!(text(section(&tree, "accuracy")).contains("precision: tetra:2"));
    let tracers = section(&tree, "tracers");
    assert!(text(tracers).contains("whitted 4 samples") && by_name(tracers, "svg").count() == 2);
    let mut images = by_name(section(&tree, "heat-maps"), "img");
    let image = images.next().unwrap();
    assert!(image.attribute("src").unwrap().starts_with("data:image/svg+xml;base64,PHN2Zy"));
    assert_eq!(image.attribute("alt"), Some("tetra:2: intersection tests of each pixel"));
    let older = images.next().unwrap().attribute("src").unwrap();
    assert!(older.starts_with("data:image/png;base64,iVBORw0KGgo"));
    let sweep = by_name(section(&tree, "sweeps"), "img").next().unwrap();
    assert!(sweep.attribute("src").unwrap().starts_with("data:image/svg+xml;base64,PHN2Zy"));
    let counters = text(section(&tree, "counters"));
    assert!(counters.contains("22.03") && counters.contains("exact"), "{counters}");
    let lecture = text(section(&tree, "lecture"));
    assert!(lecture.contains("0.25 [0.20, 0.30]") && !lecture.contains("7.5"), "{lecture}");
}

#[test]
fn unreadable_files_are_errors_that_name_them() {
    let empty = Folder::new();
    let ended = report(&empty);
    assert_eq!(ended.code, 1);
    assert!(ended.err.contains("results.json"), "{}", ended.err);
    for (name, content, said) in [
        ("accuracy/accuracy.json", "{}", "rtbench accuracy"),
        ("tracers/tetra/tracers.json", "[", "rtbench compare-tracers"),
        ("havran1999.csv", "scene,nothing\nballs,1\n", "rtbench reproduce havran1999"),
        ("zachmann2007.csv", "scene\nballs\n", "rtbench reproduce zachmann2007"),
        ("sweep-density/sweep.svg", "<html>", "not an SVG"),
        ("heat-maps/tetra/time.svg", "GIF89a", "not an SVG"),
        ("heat-maps/tetra/steps.png", "GIF89a", "not a PNG"),
        ("pictures/tetra.png", "GIF89a", "rtbench render"),
    ] {
        let folder = Folder::new();
        write(&folder, "results.json", minimal());
        write(&folder, name, content);
        let ended = report(&folder);
        assert_eq!(ended.code, 1, "{name}");
        assert!(ended.err.contains(name) && ended.err.contains(said), "{}", ended.err);
        assert!(!std::path::Path::new(&folder.path()).join("report.html").exists());
    }
    let folder = Folder::new();
    write(&folder, "results.json", minimal());
    let page = page(&folder);
    assert!(page.contains("no finished scene"), "a run that was interrupted at once has a page");
    let ended = run_stepping(&format!("report {} -o /nowhere/report.html", folder.path()));
    assert_eq!(ended.code, 1);
    assert!(ended.err.contains("cannot write /nowhere/report.html"), "{}", ended.err);
}

#[test]
fn several_runs_stand_side_by_side() {
    let (a, b) = (folder(), folder());
    change(&b, |record| record["machine"]["cpu"] = json!("Another <Processor>"));
    let both = format!("{} {}", a.path(), b.path());
    let ended = run_stepping(&format!("report {both} --no-pictures -o -"));
    assert_eq!((ended.code, ended.err.as_str()), (0, ""));
    let tree = parsed(&ended.out);
    let answers = text(section(&tree, "headlines"));
    assert!(answers.contains("Run 1: ") && answers.contains("Run 2: Another <Processor>"));
    let beside = section(&tree, "side-by-side");
    assert_eq!(by_name(beside, "table").count(), 2, "a scene each");
    let [row] = &cells(by_name(beside, "table").next().unwrap(), "uniform-grid")[..] else {
        panic!()
    };
    assert!(row.len() == 2 && row[0] == row[1] && row[0].contains('['), "{row:?}");
    let [wrong] = &cells(by_name(beside, "table").next().unwrap(), "dropper")[..] else { panic!() };
    assert_eq!(wrong[..], ["wrong", "wrong"]);
    // each by itself, under names of its own
    let ids: Vec<&str> = tree.descendants().filter_map(|n| n.attribute("id")).collect();
    let distinct: std::collections::BTreeSet<&str> = ids.iter().copied().collect();
    assert_eq!(ids.len(), distinct.len(), "{ids:?}");
    for id in ["run-1-scenes", "run-2-break-even", "run-2-scene-tetra_2", "glossary"] {
        assert!(distinct.contains(id), "{id}: {ids:?}");
    }
    for link in by_name(tree.root(), "a").filter_map(|a| a.attribute("href")) {
        let id = link.strip_prefix('#');
        assert!(id.is_none_or(|id| distinct.contains(id)), "{link}");
    }
    // another scene of the same name is not the same
    change(&b, |record| record["scenes"][0]["sha256"] = json!("0"));
    let ended = run_stepping(&format!("report {both} --no-pictures -o -"));
    assert_eq!(by_name(section(&parsed(&ended.out), "side-by-side"), "table").count(), 1);
}

/// The record of a run that finished no scene.
fn minimal() -> String {
    json!({
        "schema_version": measurement::record::SCHEMA_VERSION,
        "tool": { "name": "rtbench", "version": "0", "git_revision": null },
        "command_line": ["rtbench", "run"],
        "started_unix_s": 0,
        "machine": { "cpu": null, "threads": 1, "memory_bytes": null, "os": "linux" },
        "compiler": { "rustc": null, "target": null, "target_features": [], "profile": null,
                      "opt_level": null },
        "settings": { "seed": 1, "threads": 1, "precision": "f32", "resolution": [1, 1],
                      "max_depth": 1, "rays": [], "reference": "obvhs-cwbvh", "quick": false },
        "scenes": [], "summary": [], "peak_rss_bytes": null, "planned": ["tetra"],
        "complete": false,
    })
    .to_string()
}
