//! The first page: what changed at which commit, the scenes, the runs, the machines.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use crate::history::lines::{Change, History, Key, Line};
use crate::history::names::Names;
use crate::history::shell::{bench_name, change_cell, day, section, start_page, verdict};
use crate::report::utc;
use measurement::record::label;
use presentation::html::Html;
use presentation::numbers::ratio;
use presentation::page::finished;
use presentation::page::tables::{self, TableStyle};
use presentation::table::{Cell, Table, words};

pub fn page(history: &History, names: &Names) -> String {
    let visits = &history.visits;
    let days = visits.first().zip(visits.last());
    let days = days.map_or(String::new(), |(first, last)| {
        format!(", {} to {}", day(first.unix_s()), day(last.unix_s()))
    });
    let commits: std::collections::BTreeSet<String> = visits.iter().map(|v| v.id()).collect();
    let intro = format!(
        "{} runs of {} commits on {} machine(s){days}. Ratios are to the reference of the same run.",
        visits.len(),
        commits.len(),
        history.benches.len()
    );
    let mut html = start_page("history", &intro, &[]);
    changes(&mut html, history, names);
    scenes(&mut html, history, names);
    runs(&mut html, history);
    section(&mut html, "machines", "Machines");
    html.open("ol", &[]);
    for bench in &history.benches {
        html.element("li", &[], &bench.words);
    }
    html.close();
    html.close();
    method(&mut html);
    finished(html)
}

type ChangedLine<'a> = (&'a Key, &'a Line, &'a Change);

/// Commit by commit, the newest first.
fn changes(html: &mut Html, history: &History, names: &Names) {
    section(html, "changes", "Changes");
    let mut by_visit: BTreeMap<Reverse<usize>, Vec<ChangedLine<'_>>> = BTreeMap::new();
    for found in history.changes() {
        let (_, line, change) = found;
        if let Some([_, after]) = line.around(change) {
            by_visit.entry(Reverse(after.visit)).or_default().push(found);
        }
    }
    if by_visit.is_empty() {
        html.paragraph("No change was found.");
    }
    for (Reverse(visit), mut found) in by_visit {
        let Some(run) = history.visits.get(visit) else { continue };
        let size = |found: &ChangedLine<'_>| found.2.times.median.ln().abs();
        found.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let count = |what: &str| found.iter().filter(|(.., c)| verdict(&c.times) == what).count();
        let id = format!("change-{}", visit + 1);
        html.element(
            "h3",
            &[("id", &id)],
            &format!("{} {} ({})", run.id(), run.subject(), day(run.unix_s())),
        );
        html.paragraph(&format!(
            "{} series changed: {} slower, {} faster.",
            found.len(),
            count("slower"),
            count("faster")
        ));
        let (table, links) = table_of(history, names, &found);
        tables::write(html, &table, TableStyle { links: &links, ..TableStyle::default() });
    }
    html.close();
}

fn table_of(
    history: &History,
    names: &Names,
    found: &[ChangedLine<'_>],
) -> (Table, Vec<Vec<String>>) {
    let row = |(key, line, change): &ChangedLine<'_>| {
        let before = line.around(change).and_then(|[before, _]| history.visits.get(before.visit));
        vec![
            Cell::from(label(&key.structure, &key.settings)),
            change_cell(ratio(&change.times).trim_end().to_owned(), &change.times),
            key.scene.clone().into(),
            key.quantity.head().to_owned().into(),
            verdict(&change.times).to_owned().into(),
            before.map_or(String::new(), |visit| visit.id()).into(),
            bench_name(line.bench).into(),
        ]
    };
    let links = found.iter().map(|(key, ..)| vec![names.row(key)]);
    let header = vec!["structure", "change [95%]", "scene", "of", "so", "after", "machine"];
    let table = Table {
        title: "changes, the largest first".to_owned(),
        header,
        rows: found.iter().map(row).collect(),
        notes: Vec::new(),
    };
    (table, links.collect())
}

fn scenes(html: &mut Html, history: &History, names: &Names) {
    section(html, "scenes", "Scenes");
    let (mut rows, mut links) = (Vec::new(), Vec::new());
    for (scene, path) in names.scenes() {
        let of = |key: &Key| key.scene == *scene;
        let series = history.lines.keys().filter(|key| of(key)).count();
        let changes = history.changes().filter(|(key, ..)| of(key)).count();
        rows.push(vec![scene.clone(), series.to_string(), changes.to_string()]);
        links.push(vec![path.clone()]);
    }
    let table = words("every scene", vec!["scene", "series", "changes"], rows);
    tables::write(html, &table, TableStyle { links: &links, ..TableStyle::default() });
    html.close();
}

/// Every run, the newest first; each can be linked.
fn runs(html: &mut Html, history: &History) {
    section(html, "runs", "Runs");
    let all = history.visits.iter().zip(&history.bench_of).enumerate().rev();
    let (mut rows, mut ids) = (Vec::new(), Vec::new());
    for (place, (visit, bench)) in all {
        ids.push(format!("run-{}", place + 1));
        rows.push(vec![
            visit.id(),
            utc(visit.unix_s()),
            bench_name(*bench),
            visit.run.scenes.len().to_string(),
            if visit.run.complete { "whole" } else { "not finished" }.to_owned(),
            visit.name.clone(),
            visit.subject().to_owned(),
        ]);
    }
    let header = vec!["commit", "when", "machine", "scenes", "run", "folder", "subject"];
    let table = words("all runs, the newest first", header, rows);
    tables::write(html, &table, TableStyle { ids: &ids, ..TableStyle::default() });
    html.close();
}

fn method(html: &mut Html) {
    section(html, "method", "How changes are found");
    html.paragraph(
        "By E-divisive on the logarithms of the ratios: a series is divided where both sides \
         differ most, by the distances of their values, as long as a permutation test finds the \
         difference significant. About one in a thousand series without a change is reported to \
         have one. A change needs three runs on each side; nothing is reported about the newest \
         commit yet: that is what rtbench check is for.",
    );
    html.list(
        [
            "D. S. Matteson, N. A. James, A Nonparametric Approach for Multiple Change Point Analysis of Multivariate \
             Data, Journal of the American Statistical Association 109(505), 2014.",
            "D. Daly, W. Brown, H. Ingo, J. O'Leary, D. Bradford, The Use of Change Point Detection to Identify \
             Software Performance Regressions in a Continuous Integration System, ICPE 2020.",
        ]
        .map(str::to_owned),
    );
    html.close();
}
