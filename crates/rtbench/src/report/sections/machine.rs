//! Data needed to repeat the run: machine, compiler, settings, commands, scenes, raw data. And the
//! caveats of its times: warnings, and outliers, which are counted and never dropped.

use crate::report::material::{DataFile, Material};
use crate::report::page::Page;
use measurement::record::{Outliers, RunRecord, SceneRecord, reference};
use presentation::html::Html;
use presentation::numbers::{mebibytes, utc};
use presentation::table::{Table, words};

const UNKNOWN: &str = "unknown";

/// When, on what and with what: below the title.
pub fn one_line(material: &Material, html: &mut Html) {
    let run = &material.run;
    let rows = run.scenes.iter().map(|s| s.rows.len()).max().unwrap_or(0);
    let rounds = |scene: &SceneRecord| scene.rows.iter().map(|r| r.samples.len()).max();
    let rounds = run.scenes.iter().filter_map(rounds).min().unwrap_or(0);
    html.paragraph(&format!(
        "{rows} structures and settings, {} scene(s), {rounds} rounds at least; {} thread(s) of {}; {}. \
         Ratios are to {}.{}",
        run.scenes.len(),
        run.settings.threads,
        run.machine.cpu.as_deref().unwrap_or("an unknown processor"),
        utc(run.started_unix_s),
        reference::in_words(run),
        if run.settings.quick { " A quick first look, not a measurement." } else { "" },
    ));
}

pub fn write(material: &Material, page: &mut Page) {
    let (run, html) = (&material.run, &mut page.html);
    html.definitions(facts(run));
    html.element("h3", &[], "Commands");
    let mut commands = vec![run.command_line.join(" ")];
    commands.extend(material.accuracy.iter().map(|a| a.command_line.join(" ")));
    commands.extend(material.tracers.iter().map(|t| t.command_line.join(" ")));
    html.items(&[], commands, |html, command| html.element("code", &[], &command));
    html.element("h3", &[], "Raw data");
    html.open("p", &[]);
    html.text("Every sample of every round is in ");
    let DataFile { name, bytes, sha256 } = &material.data;
    if page.is_beside_record {
        html.element("a", &[("href", name)], name);
        html.text(" beside this page");
    } else {
        html.element("code", &[], &material.folder.join(name).to_string_lossy());
    }
    html.text(&format!(" ({bytes} bytes, SHA-256 {sha256}). The page was made from it by "));
    html.element("code", &[], "rtbench report DIR");
    html.text(".");
    html.close();
    page.table(&scenes(&run.scenes));
}

fn facts(run: &RunRecord) -> Vec<(&'static str, String)> {
    let unknown = |text: &Option<String>| text.clone().unwrap_or_else(|| UNKNOWN.to_owned());
    let memory = |bytes: Option<u64>| bytes.map_or(UNKNOWN.to_owned(), |n| mebibytes(n) + " MiB");
    let [width, height] = run.settings.resolution;
    let (view, tool, compiler) = (&run.settings.view, &run.tool, &run.compiler);
    let [profile, level] = [&compiler.profile, &compiler.opt_level].map(unknown);
    let profile = format!("{profile}, optimisation {level}");
    let given = (!view.is_empty()).then(|| ("camera and lights given", view.to_string()));
    let mut facts = vec![
        ("started", utc(run.started_unix_s)),
        ("program", format!("{} {} at {}", tool.name, tool.version, unknown(&tool.git_revision))),
        ("processor", unknown(&run.machine.cpu)),
        ("threads there", run.machine.threads.to_string()),
        ("memory", memory(run.machine.memory_bytes)),
        ("system", run.machine.os.clone()),
        ("compiler", unknown(&compiler.rustc)),
        ("target", unknown(&compiler.target)),
        ("target features", compiler.target_features.join(" ")),
        ("profile", profile),
        ("threads used", run.settings.threads.to_string()),
        ("precision", run.settings.precision.clone()),
        ("seed", run.settings.seed.to_string()),
        ("image", format!("{width} x {height}, chains of {} rays", run.settings.max_depth)),
        ("kinds of rays", run.settings.rays.join(", ")),
        ("order of rays", run.settings.order.clone()),
        ("lights asked", run.settings.lights.clone()),
        ("reference", reference::in_words(run)),
        ("processes", run.settings.processes.to_string()),
        ("timed by", run.settings.timed_by.clone()),
        ("largest resident set", memory(run.peak_rss_bytes)),
    ];
    facts.extend(given);
    facts
}

fn scenes(scenes: &[SceneRecord]) -> Table {
    let rows = scenes.iter().map(|scene| {
        vec![
            scene.name.clone(),
            scene.primitives.to_string(),
            scene.source.clone(),
            scene.licence.clone().unwrap_or_else(|| UNKNOWN.to_owned()),
            scene.sha256.clone(),
        ]
    });
    let header = vec!["scene", "primitives", "source", "licence", "SHA-256"];
    words("Scenes", header, rows)
}

pub fn write_warnings(material: &Material, page: &mut Page) {
    let scenes = &material.run.scenes;
    let mut all: Vec<String> = material.run.warnings.iter().map(ToString::to_string).collect();
    for scene in scenes {
        all.extend(scene.warnings.iter().map(|w| format!("{}: {w}", scene.name)));
        let refused = scene.oracle.refused.iter();
        all.extend(refused.map(|r| format!("{}: not asked first: {r}", scene.name)));
    }
    if all.is_empty() {
        page.html.paragraph("The run had no warnings.");
    }
    page.html.list(all);
    let table = outlier_table(scenes);
    let (rows, with) = (scenes.iter().map(|s| s.rows.len()).sum::<usize>(), table.rows.len());
    page.html.paragraph(&format!(
        "Outliers lie more than 1.5 interquartile ranges beyond the quartiles (Tukey 1977): {with} of \
         {rows} rows have some. They are counted and shown here, and none is left out of any figure."
    ));
    if with > 0 {
        page.html.open_details(&[], "Rows with outliers");
        page.table(&table);
        page.html.close();
    }
}

/// Rows that have some: how many of how many samples, below and above.
fn outlier_table(scenes: &[SceneRecord]) -> Table {
    let mut rows = Vec::new();
    for scene in scenes {
        for row in &scene.rows {
            // counted anew: records from before have no counts
            let Outliers { build, trace } = Outliers::of(&row.samples);
            if [build, trace].as_flattened().iter().sum::<u64>() > 0 {
                let cell = |[below, above]: [u64; 2]| {
                    format!("{below} below, {above} above, of {}", row.samples.len())
                };
                rows.push(vec![scene.name.clone(), row.label(), cell(build), cell(trace)]);
            }
        }
    }
    words("Outliers", vec!["scene", "structure", "build", "trace"], rows)
}
