//! The pages of the site: the first (what changed at which commit, the scenes, the runs, the
//! machines); one per scene, with every row's latest ratios and what changed last; and one per
//! structure and kind of ray, with the line of each setting, its changes and points.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use crate::history::layout::{
    INDEX, Names, PageKey, anchor, bench_name, change_cell, class_of, day, from_below, in_words,
    page_of, start_page, verdict,
};
use crate::history::lines::{Change, History, Key, Line, Quantity};
use crate::report::file_name;
use measurement::record::label;
use presentation::html::Html;
use presentation::numbers::{ratio, short, utc};
use presentation::page::{TableStyle, figure, finished, write_table};
use presentation::svg_plot::{Axis, Mark, Plot, Point as PlotPoint, Ring, Scale, Series};
use presentation::table::{Cell, Table, dash, words};

pub fn index_page(history: &History, names: &Names) -> String {
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
    index_changes(&mut html, history, names);
    scenes(&mut html, history, names);
    runs(&mut html, history);
    html.open_section("machines", "Machines");
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
fn index_changes(html: &mut Html, history: &History, names: &Names) {
    html.open_section("changes", "Changes");
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
        write_table(html, &table, TableStyle { links: &links, ..TableStyle::default() });
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
    html.open_section("scenes", "Scenes");
    let (mut rows, mut links) = (Vec::new(), Vec::new());
    for (scene, path) in &names.scenes {
        let of = |key: &Key| key.scene == *scene;
        let series = history.lines.keys().filter(|key| of(key)).count();
        let changes = history.changes().filter(|(key, ..)| of(key)).count();
        rows.push(vec![scene.clone(), series.to_string(), changes.to_string()]);
        links.push(vec![path.clone()]);
    }
    let table = words("every scene", vec!["scene", "series", "changes"], rows);
    write_table(html, &table, TableStyle { links: &links, ..TableStyle::default() });
    html.close();
}

/// Every run, the newest first; each can be linked.
fn runs(html: &mut Html, history: &History) {
    html.open_section("runs", "Runs");
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
    write_table(html, &table, TableStyle { ids: &ids, ..TableStyle::default() });
    html.close();
}

fn method(html: &mut Html) {
    html.open_section("method", "How changes are found");
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

pub fn row_page(history: &History, names: &Names, own: &PageKey) -> String {
    let (scene, structure, quantity) = own;
    let rows: Vec<(&Key, &Vec<Line>)> =
        history.lines.iter().filter(|(key, _)| page_of(key) == *own).collect();
    let up = [("All scenes", from_below(INDEX)), (scene.as_str(), from_below(names.scene(scene)))];
    let title = format!("{scene}: {structure}, {}", quantity.in_words());
    let intro = "Ratios to the reference of the same run, with their 95% intervals: below 1 is faster than the \
                 reference. A line is of one machine with its settings.";
    let mut html = start_page(&title, intro, &up);
    siblings(&mut html, names, own);
    for (key, lines) in rows {
        html.open_section(&anchor(&key.settings), &label(structure, &key.settings));
        row_changes(&mut html, history, lines);
        figure(&mut html, "ratio over commits", &plot(history, key, lines));
        let (table, links) = points(history, lines);
        write_table(&mut html, &table, TableStyle { links: &links, ..TableStyle::default() });
        html.close();
    }
    finished(html)
}

/// The same structure in the same scene: other kinds of rays.
fn siblings(html: &mut Html, names: &Names, own: &PageKey) {
    let is_sibling = |other: &PageKey| (&other.0, &other.1) == (&own.0, &own.1);
    html.open("p", &[]);
    html.text("Of the same structure: ");
    for (i, (other, path)) in names.pages.iter().filter(|(other, _)| is_sibling(other)).enumerate()
    {
        html.text(if i == 0 { "" } else { ", " });
        if other == own {
            html.element("strong", &[], other.2.head())
        } else {
            html.element("a", &[("href", &from_below(path))], other.2.head())
        }
    }
    html.text(".");
    html.close();
}

/// Table of changes, with the command that finds the commit if several lie between two runs.
fn row_changes(html: &mut Html, history: &History, lines: &[Line]) {
    let all: Vec<(&Line, &Change)> =
        lines.iter().flat_map(|line| line.changes.iter().map(move |c| (line, c))).collect();
    if all.is_empty() {
        html.paragraph("No change was found.");
        return;
    }
    let around = all.into_iter().filter_map(|(line, c)| Some((line, c, line.around(c)?)));
    html.items(&[], around, |html, (line, change, [before, after])| {
        html.element("strong", &[("class", class_of(&change.times))], verdict(&change.times));
        html.text(&format!(" {}. ", in_words(history, line, change)));
        let command =
            format!("git bisect start {} {}", history.id(after.visit), history.id(before.visit));
        html.element("code", &[], &command);
    });
}

/// The runs that some line has a point of, in their order.
fn shown(lines: &[Line]) -> Vec<usize> {
    let visits: BTreeSet<usize> = lines.iter().flat_map(|l| &l.points).map(|p| p.visit).collect();
    visits.into_iter().collect()
}

fn plot(history: &History, key: &Key, lines: &[Line]) -> Plot {
    let shown = shown(lines);
    let across = |visit: usize| shown.binary_search(&visit).unwrap_or(0) as f64;
    let place = |point: &crate::history::lines::Point| PlotPoint {
        x: across(point.visit),
        y: point.ratio.median,
        low: point.ratio.low,
        high: point.ratio.high,
    };
    let marks = lines.iter().flat_map(|line| {
        line.changes.iter().filter_map(move |change| {
            let [_, after] = line.around(change)?;
            Some(Mark {
                hover: String::new(),
                point: place(&after),
                label: format!("{} {} x", history.id(after.visit), short(change.times.median)),
                ring: Ring::AsGood,
                is_in_series: true,
            })
        })
    });
    let series = lines.iter().map(|line| Series {
        name: bench_name(line.bench),
        points: line.points.iter().map(place).collect(),
        is_joined: true,
    });
    Plot {
        title: format!("{}: {}", label(&key.structure, &key.settings), key.quantity.in_words()),
        subtitle: "ratio to the reference, medians with 95% intervals; ringed: changes".to_owned(),
        x: Axis {
            label: "commits, oldest first".to_owned(),
            scale: Scale::Words(shown.iter().map(|visit| history.id(*visit)).collect()),
        },
        y: Axis { label: "ratio".to_owned(), scale: Scale::Linear },
        series: series.collect(),
        marks: marks.collect(),
        ..Plot::default()
    }
}

/// Every point, the newest first, and where its commit stands in the index.
fn points(history: &History, lines: &[Line]) -> (Table, Vec<Vec<String>>) {
    let mut rows: Vec<(usize, Vec<Cell>)> = Vec::new();
    for line in lines {
        for (place, point) in line.points.iter().enumerate() {
            let Some(visit) = history.visits.get(point.visit) else { continue };
            let change = line.changes.iter().find(|change| change.place == place);
            let changed = change.map(|change| {
                change_cell(ratio(&change.times).trim_end().to_owned(), &change.times)
            });
            let cells = vec![
                visit.id().into(),
                ratio(&point.ratio).into(),
                changed.unwrap_or_else(|| String::new().into()),
                utc(visit.unix_s()).into(),
                bench_name(line.bench).into(),
                visit.name.clone().into(),
                visit.subject().to_owned().into(),
            ];
            rows.push((point.visit, cells));
        }
    }
    rows.sort_by_key(|(visit, _)| std::cmp::Reverse(*visit));
    let link = |(visit, _): &(usize, _)| vec![format!("../{INDEX}#run-{}", visit + 1)];
    let links = rows.iter().map(link).collect();
    let header = vec!["commit", "ratio [95%]", "change", "when", "machine", "folder", "subject"];
    let rows = rows.into_iter().map(|(_, cells)| cells).collect();
    let title = "All runs, the newest first".to_owned();
    (Table { title, header, rows, notes: Vec::new() }, links)
}

pub fn scene_page(history: &History, names: &Names, scene: &str) -> String {
    let intro = "The latest ratio of each row to the reference of its run; figures link to their histories. A change is \
                 the last one that was found, newer figures over older ones.";
    let mut html = start_page(scene, intro, &[("All scenes", from_below(INDEX))]);
    let keys = || history.lines.keys().filter(|key| key.scene == scene);
    let quantities: BTreeSet<Quantity> = keys().map(|key| key.quantity).collect();
    let rows: BTreeSet<(&str, &str)> =
        keys().map(|key| (key.structure.as_str(), key.settings.as_str())).collect();
    let mut header = vec!["structure"];
    header.extend(quantities.iter().map(|quantity| quantity.head()));
    let (mut cells, mut links, mut ids) = (Vec::new(), Vec::new(), Vec::new());
    for (structure, settings) in rows {
        let name = label(structure, settings);
        ids.push(file_name(&name));
        let mut own: Vec<Cell> = vec![name.into()];
        let mut targets = vec![String::new()];
        for quantity in &quantities {
            let key = Key {
                scene: scene.to_owned(),
                structure: structure.to_owned(),
                quantity: *quantity,
                settings: settings.to_owned(),
            };
            let lines = history.lines.get(&key);
            own.push(lines.map_or_else(dash, |lines| cell(lines)));
            targets.push(lines.map_or(String::new(), |_| from_below(&names.row(&key))));
        }
        cells.push(own);
        links.push(targets);
    }
    let title = "latest ratios [95%]".to_owned();
    let table = Table { title, header, rows: cells, notes: Vec::new() };
    let look = TableStyle { links: &links, ids: &ids, is_open: true, ..TableStyle::default() };
    write_table(&mut html, &table, look);
    finished(html)
}

/// The newest point, and the last change.
fn cell(lines: &[Line]) -> Cell {
    let newest = lines.iter().filter_map(|line| line.points.last());
    let Some(point) = newest.max_by_key(|point| point.visit) else { return dash() };
    let text = ratio(&point.ratio).trim_end().to_owned();
    let changes = lines.iter().flat_map(|line| {
        line.changes.iter().filter_map(|c| Some((line.around(c)?.last()?.visit, c.times)))
    });
    match changes.max_by_key(|(visit, _)| *visit) {
        None => text.into(),
        Some((_, times)) => {
            change_cell(format!("{text}, changed {} x", short(times.median)), &times)
        }
    }
}
