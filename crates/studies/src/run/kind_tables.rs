//! Tables of each kind of ray and order by itself, and of the time to a picture.
//!
//! A sum over all kinds hides that a structure is fast on the rays of one kind and slow on
//! another's. These tables give rays per second over the reference's, as benchmarks of ray tracers
//! do: above 1 is faster, the inverse of the ratios of times in the other tables.

use std::collections::BTreeMap;

use crate::run::tables::{left_out, row_names};
use crate::run::time_to_image::{self, TimeToImage, TimesToImage};
use measurement::rays::order::kind_of;
use measurement::record::metrics::{METRICS, Reading};
use measurement::record::query::{self, Query};
use measurement::record::{RowRecord, RunRecord, SceneRecord, label, reference};
use presentation::csv;
use presentation::csv::number;
use presentation::numbers;
use presentation::table::{Cell, Table, dash};
use statistics::estimate::Estimate;

/// The kinds of rays of a run, each in its orders, as records call them.
pub fn kinds(run: &RunRecord) -> Vec<&'static str> {
    kinds_of(run.scenes.iter())
}

pub fn kinds_of<'s>(scenes: impl Iterator<Item = &'s SceneRecord> + Clone) -> Vec<&'static str> {
    let is_asked = |name: &str| scenes.clone().any(|scene| scene.rays.contains_key(name));
    let all = METRICS.iter().filter_map(|metric| match metric.reading {
        Reading::RatioOf(name) => Some(name),
        _ => None,
    });
    all.filter(|name| is_asked(name)).collect()
}

/// A scene: rows down in any order, kinds of rays across.
pub fn scene_table<'r>(
    run: &RunRecord,
    scene: &SceneRecord,
    shown_rows: impl IntoIterator<Item = &'r RowRecord>,
    indent: bool,
) -> Table {
    let kinds = kinds(run);
    let mut header = vec!["structure", "query"];
    header.extend(&kinds);
    header.extend(["time to image ms", "to obvhs [95%]"]);
    let reference = reference::of_scene(scene).unwrap_or_else(|| run.settings.reference.clone());
    let times = TimesToImage::of(scene);
    let obvhs = times.fastest_obvhs();
    let mut name = row_names(indent);
    let rows = shown_rows.into_iter().map(|row| {
        let query = row.query.name().to_owned().into();
        let mut cells = vec![name(&row.structure, &row.settings), query];
        cells.extend(kinds.iter().map(|kind| speed(row.ratio_by_kind.get(*kind))));
        let time = times.of_row(&row.label());
        cells.push(time.map_or_else(dash, |t| numbers::milliseconds(t.timed.middle).into()));
        cells.push(to_obvhs(time, obvhs, run.settings.seed));
        cells
    });
    Table {
        title: format!("{}: by kind of ray", scene.name),
        header,
        rows: rows.collect(),
        notes: notes(&reference, scene.rows.iter().any(|row| row.query == Query::Batch)),
    }
}

/// Geometric means over the scenes, and the scene where each row is slowest.
pub fn summary_table(run: &RunRecord, indent: bool) -> Table {
    let kinds = kinds(run);
    let mut header = vec!["structure", "query", "scenes"];
    for kind in &kinds {
        header.extend([kind, "least"]);
    }
    header.extend(["time to image to obvhs [95%]", "most"]);
    let reference = reference::of_means(&run.scenes, &run.settings.reference);
    let pictures: Vec<TimesToImage<'_>> = run.scenes.iter().map(TimesToImage::of).collect();
    let of_means = run.scenes.iter().filter(|s| reference::is_over(s, &reference));
    let of_means: Vec<(&SceneRecord, RowsByName<'_>)> =
        of_means.map(|scene| (scene, by_name(scene))).collect();
    let mut name = row_names(indent);
    let rows = run.summary.iter().map(|row| {
        let query = Query::over_scenes(row.batch_scenes, row.scenes).into();
        let scenes = row.scenes.to_string().into();
        let mut cells = vec![name(&row.structure, &row.settings), query, scenes];
        for kind in &kinds {
            cells.push(speed(row.ratio_by_kind.get(*kind)));
            let of = |(scene, rows): &(&SceneRecord, RowsByName<'_>)| {
                let same = rows.get(&(&*row.structure, &*row.settings))?;
                let ratio = same.ratio_by_kind.get(*kind)?;
                Some((scene.name.clone(), ratio.inverse().median))
            };
            let by_scene = of_means.iter().filter_map(of);
            cells.push(named(by_scene.min_by(|a, b| a.1.total_cmp(&b.1))));
        }
        let label = label(&row.structure, &row.settings);
        match time_to_image::over_scenes(&pictures, &label, run.settings.seed) {
            Some((by_scene, mean)) => {
                cells.push(numbers::ratio(&mean).into());
                cells.push(named(by_scene.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))));
            }
            None => cells.extend([dash(), dash()]),
        }
        cells
    });
    let mut notes = notes(&reference, run.summary.iter().any(|row| row.batch_scenes > 0));
    notes.extend(left_out(run));
    Table { title: "All scenes: by kind of ray".into(), header, rows: rows.collect(), notes }
}

/// The rows of a scene by structure and settings; of equal ones the first.
type RowsByName<'a> = BTreeMap<(&'a str, &'a str), &'a RowRecord>;

fn by_name(scene: &SceneRecord) -> RowsByName<'_> {
    let named = scene.rows.iter().map(|row| ((&*row.structure, &*row.settings), row));
    // the last one stays
    named.rev().collect()
}

/// Scene by scene: the first row to a picture, by the way it is asked, against the first of obvhs.
pub fn picture_table(run: &RunRecord) -> Table {
    let mut rows = Vec::new();
    for scene in &run.scenes {
        let times = TimesToImage::of(scene);
        let obvhs = times.fastest_obvhs();
        for query in [Query::OneRay, Query::Batch] {
            let Some(own) = times.fastest_other(query) else { continue };
            let ms = |time: &TimeToImage| Cell::from(numbers::milliseconds(time.timed.middle));
            rows.push(vec![
                scene.name.clone().into(),
                query.name().to_owned().into(),
                own.timed.label.clone().into(),
                ms(own),
                obvhs.map_or_else(dash, |time| time.timed.label.clone().into()),
                obvhs.map_or_else(dash, ms),
                to_obvhs(Some(own), obvhs, run.settings.seed),
            ]);
        }
    }
    let header =
        vec!["scene", "query", "fastest", "time to image ms", "of obvhs", "ms", "to obvhs [95%]"];
    Table {
        title: "Time to image: build, one million primary rays and their shadow rays".into(),
        header,
        rows,
        notes: vec![
            "fastest: the fastest row that is not of obvhs, one per kind of query; ratios of \
             times, below 1 is faster."
                .into(),
        ],
    }
}

/// Rays per second over the reference's, from the ratio of times.
fn speed(ratio: Option<&Estimate>) -> Cell {
    ratio.map_or_else(dash, |ratio| numbers::ratio(&ratio.inverse()).into())
}

/// A value and the scene it is of.
fn named(of_scene: Option<(String, f64)>) -> Cell {
    of_scene.map_or_else(dash, |(scene, value)| format!("{value:.2} {scene}").into())
}

fn to_obvhs(own: Option<&TimeToImage>, obvhs: Option<&TimeToImage>, seed: u64) -> Cell {
    let ratio = || own?.timed.quotients(&obvhs?.timed).estimate(seed);
    ratio().map_or_else(dash, |ratio| numbers::ratio(&ratio).into())
}

fn notes(reference: &str, has_batches: bool) -> Vec<String> {
    let mut notes = vec![
        format!(
            "Of each kind of ray: rays per second over those of {reference}, for the same rays in \
             the same round; above 1 is faster. NAME-shuffled: the same rays in a random order.",
        ),
        "time to image: build, one million primary rays and their shadow rays; to obvhs: time to \
         image over that of the fastest row of obvhs; below 1 is faster."
            .into(),
    ];
    if has_batches {
        notes.push(query::NOTE.into());
    }
    notes
}

/// Further columns of CSV files, in order.
pub fn csv_columns(kinds: &[&str]) -> Vec<String> {
    let column = |text: &str| text.replace('-', "_");
    let mut columns = vec!["query".to_owned()];
    for kind in kinds {
        columns.extend(["", "_low", "_high"].map(|end| column(&format!("ratio_{kind}{end}"))));
    }
    columns.extend(shuffled(kinds).map(|kind| column(&format!("{kind}_mrays"))));
    columns.extend(["picture_s", "picture_to_obvhs"].map(str::to_owned));
    columns
}

/// The fields of a row for them.
pub fn csv_fields(kinds: &[&str], row: &RowRecord, times: &TimesToImage<'_>) -> Vec<String> {
    let mut fields = vec![row.query.name().to_owned()];
    for kind in kinds {
        fields.extend(csv::estimate(row.ratio_by_kind.get(*kind).copied()));
    }
    fields.extend(shuffled(kinds).map(|kind| number(row.mrays.get(kind).copied())));
    let own = times.of_row(&row.label());
    fields.push(number(own.map(|time| time.timed.middle)));
    let ratio = own.zip(times.fastest_obvhs());
    let ratio = ratio.and_then(|(own, obvhs)| own.timed.quotients(&obvhs.timed).middle());
    fields.push(number(ratio));
    fields
}

/// Rates in the order of the image have columns of their own.
fn shuffled<'k>(kinds: &[&'k str]) -> impl Iterator<Item = &'k str> {
    kinds.iter().copied().filter(|name| kind_of(name) != *name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::record::made_up::{Rows, run};
    use measurement::record::metrics::kind_ratios;
    use measurement::record::summary::summarize;

    fn made() -> RunRecord {
        let rows: Rows<'_> = &[
            ("obvhs-cwbvh", &[1.0, 2.0, 4.0]),
            ("uniform-grid", &[2.0, 4.0, 8.0]),
            ("irregular-grid query=batch", &[0.5, 1.0, 2.0]),
        ];
        let slower: Rows<'_> = &[
            ("obvhs-cwbvh", &[1.0, 1.0, 1.0]),
            ("uniform-grid", &[8.0, 8.0, 8.0]),
            ("irregular-grid query=batch", &[0.125, 0.125, 0.125]),
        ];
        let mut record = run(&[("tetra", rows), ("balls", slower)]);
        for row in record.scenes.iter_mut().flat_map(|s| &mut s.rows) {
            let ratio = kind_ratios(row, "primary").estimate(1).unwrap();
            row.ratio_by_kind = [("primary".to_owned(), ratio)].into();
            if row.settings == "query=batch" {
                row.query = Query::Batch;
            }
        }
        record.summary = summarize(&record.scenes, &record.settings);
        record
    }

    fn first_scene(record: &RunRecord) -> Table {
        scene_table(record, &record.scenes[0], &record.scenes[0].rows, false)
    }

    fn texts(table: &Table) -> Vec<Vec<&str>> {
        table.rows.iter().map(|r| r.iter().map(|c| c.text.trim()).collect()).collect()
    }

    #[test]
    fn speeds_are_inverse_ratios_and_batches_are_marked() {
        let record = made();
        let table = first_scene(&record);
        assert_eq!(table.header[..3], ["structure", "query", "primary"]);
        let rows = texts(&table);
        assert_eq!(rows[0][1..3], ["one ray", "1.00 [1.00, 1.00] ="]);
        assert_eq!(rows[1][1..3], ["one ray", "0.50 [0.50, 0.50]"]);
        assert_eq!(rows[2][1..3], ["batch", "2.00 [2.00, 2.00]"]);
        assert!(table.notes.iter().any(|note| note.starts_with("query: batch")));
        assert!(table.rows.iter().all(|row| row.len() == table.header.len()));
    }

    #[test]
    fn the_summary_has_the_mean_and_the_least_scene() {
        let record = made();
        let table = summary_table(&record, false);
        let rows = texts(&table);
        // 1/2 and 1/8
        assert_eq!(rows[1][1..5], ["one ray", "2", "0.25 [0.25, 0.25]", "0.12 balls"]);
        assert_eq!(rows[2][1..5], ["batch", "2", "4.00 [4.00, 4.00]", "2.00 tetra"]);
        assert!(table.rows.iter().all(|row| row.len() == table.header.len()));
        let mut mixed = record.clone();
        mixed.scenes[1].rows[2].query = Query::OneRay;
        mixed.summary = summarize(&mixed.scenes, &mixed.settings);
        assert_eq!(texts(&summary_table(&mixed, false))[2][1], "batch in 1 of 2");
    }

    #[test]
    fn wrong_rows_have_no_speed() {
        let mut record = made();
        record.scenes[0].rows[1].ratio_by_kind.clear();
        let table = first_scene(&record);
        assert_eq!(texts(&table)[1][2], "-");
        assert_eq!(table.rows[1][2], dash());
    }

    #[test]
    fn columns_and_fields_are_as_many() {
        let mut record = made();
        record.scenes[0].rays.insert("primary-shuffled".into(), 256);
        let kinds = kinds(&record);
        assert_eq!(kinds, ["primary", "primary-shuffled"]);
        let columns = csv_columns(&kinds);
        let fields =
            csv_fields(&kinds, &record.scenes[0].rows[2], &TimesToImage::of(&record.scenes[0]));
        assert_eq!(columns.len(), fields.len());
        assert!(columns.contains(&"ratio_primary_shuffled_low".to_owned()), "{columns:?}");
        assert_eq!((fields[0].as_str(), fields[1].as_str()), ("batch", "0.500000000"));
    }
}
