//! One page per scene: every row with its latest ratios, and what changed last.

use std::collections::BTreeSet;

use crate::history::lines::{History, Key, Line, Quantity};
use crate::history::names::{INDEX, Names};
use crate::history::shell::{from_below, start_page};
use crate::report::file_name;
use measurement::record::label;
use presentation::numbers::{ratio, short};
use presentation::page::finished;
use presentation::page::tables::{self, TableStyle};
use presentation::table::{Cell, Style, Table, dash};

pub fn page(history: &History, names: &Names, scene: &str) -> String {
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
    tables::write(&mut html, &table, look);
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
        Some((_, times)) => Cell {
            text: format!("{text}, changed {} x", short(times.median)),
            style: if times.low > 1.0 { Style::Bad } else { Style::Best },
        },
    }
}
