//! Caveats of times: warnings of the run and of its scenes, and outliers, which are counted and
//! never dropped.

use crate::report::glossary::look;
use crate::report::material::Material;
use crate::report::page::{Page, SectionOutcome};
use measurement::record::{Outliers, SceneRecord};
use presentation::page::tables::{self, words};
use presentation::table::Table;

pub fn write(material: &Material, page: &mut Page) -> SectionOutcome {
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
        page.html.open("details", &[]);
        page.html.element("summary", &[], "Rows with outliers");
        tables::write(&mut page.html, &table, look());
        page.html.close();
    }
    SectionOutcome::Yes
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
    words("Outliers".to_owned(), vec!["scene", "structure", "build", "trace"], rows)
}
