//! Build against trace: who wins for how many rays, and from how many rays on each structure is
//! worth it against each other.

use crate::report::material::Material;
use crate::report::page::Page;
use crate::report::plots;
use presentation::html::Html;
use presentation::numbers::{milliseconds, short};
use presentation::table::{Cell, Style, Table, words};
use studies::run::conclusions::least_time;
use studies::run::costs::{BreakEven, break_even};
use studies::run::costs::{Profile, lead_for};
use studies::run::lines::{count, names, seconds};

/// Powers of ten that are asked about.
const DECADES: std::ops::RangeInclusive<i32> = 0..=9;

pub fn write(material: &Material, page: &mut Page) {
    if material.profiles.iter().all(|p| p.len() < 2) {
        return;
    }
    page.html.paragraph(
        "The time for n rays is the build and n times the time per ray, on the mix of rays of this \
         run. A slow build pays off from the break-even count on. Counts with wide intervals are \
         uncertain.",
    );
    let seed = material.run.settings.seed;
    for (scene, profiles) in material.scenes() {
        if profiles.len() < 2 {
            continue;
        }
        page.html.element("h3", &[], &scene.name);
        let plot = plots::scatter(&material.run, scene, profiles);
        page.plot(&format!("build-against-rays-{}", scene.name), &plot);
        page.table(&reigns(&scene.name, profiles, seed));
        page.table(&decades(&scene.name, profiles, seed));
        matrix(&mut page.html, &scene.name, profiles);
    }
}

/// Lower envelope of the cost lines.
fn reigns(scene: &str, profiles: &[Profile], seed: u64) -> Table {
    let rows = least_time(profiles, seed).into_iter().filter_map(|least| {
        let profile = profiles.iter().find(|p| p.label == least.row)?;
        let high = least.high.map_or("never".to_owned(), count);
        Some(vec![
            least.row,
            count(least.from_rays),
            match least.from_rays {
                0.0 => "-".into(),
                _ => format!("[{}, {high}]", count(least.low)),
            },
            milliseconds(profile.cost.build_s),
            short(profile.cost.ray_s * 1e9),
        ])
    });
    let header = vec!["least time", "from rays", "95%", "build ms", "ns per ray"];
    words(format!("{scene}: fastest structure by number of rays (medians)"), header, rows)
}

/// Winners for 1, 10, 100... rays, and rows not significantly different.
fn decades(scene: &str, profiles: &[Profile], seed: u64) -> Table {
    let rows = DECADES.filter_map(|decade| {
        let rays = 10f64.powi(decade);
        let lead = lead_for(profiles, rays, seed)?;
        let winner = profiles.iter().find(|p| p.label == lead.first)?;
        Some(vec![
            count(rays),
            lead.first.clone(),
            seconds(winner.cost.total_s(rays)),
            names("", &lead.ties).trim().to_owned(),
        ])
    });
    let header =
        vec!["for rays", "least time, build included", "time", "not significantly different"];
    words(format!("{scene}: the winner by the number of rays"), header, rows)
}

/// The most rows of which all pairs are shown: 40,000 cells.
const LARGEST_MATRIX: usize = 200;

/// From how many rays on the row beats the column.
fn matrix(html: &mut Html, scene: &str, profiles: &[Profile]) {
    if profiles.len() > LARGEST_MATRIX {
        html.paragraph(&format!(
            "The break-even counts of every pair are left out: {} rows have too many. \
             A run of {LARGEST_MATRIX} rows or fewer shows them.",
            profiles.len()
        ));
        return;
    }
    html.open_details(&[], &format!("{scene}: the break-even count of every pair"));
    html.paragraph(
        "From how many rays on the structure of the row takes less time than that of the column, \
         build included. 0: always; < n: up to that many only; -: never. Italic: the rounds do \
         not agree on which of both traces faster, so the count may be anything.",
    );
    let title = format!("{scene}: break-even counts");
    html.open_scroll(&title);
    html.open("table", &[("class", "matrix")]);
    html.element("caption", &[], &title);
    html.open("thead", &[]);
    html.open("tr", &[]);
    html.element("th", &[("scope", "col")], "row beats column from");
    for profile in profiles {
        let number = profile.number.to_string();
        html.open("th", &[("scope", "col")]);
        html.element("abbr", &[("title", &profile.label)], &number);
        html.close();
    }
    html.close();
    html.close();
    html.open("tbody", &[]);
    for row in profiles {
        html.open("tr", &[]);
        html.element("th", &[("scope", "row")], &format!("{} {}", row.number, row.label));
        for column in profiles {
            let Cell { text, style } = pair(row, column);
            match style {
                Style::Dim => {
                    html.open("td", &[("class", "unsure")]);
                    html.element("i", &[], &text);
                    html.close();
                }
                _ => html.element("td", &[], &text),
            }
        }
        html.close();
    }
    html.close();
    html.close();
    html.close();
    html.close();
}

/// A cell of the matrix; dim where nothing is sure.
fn pair(row: &Profile, column: &Profile) -> Cell {
    if row.number == column.number {
        return String::new().into();
    }
    let text = match break_even(row.cost, column.cost) {
        BreakEven::Always => "0".to_owned(),
        BreakEven::Never => "-".to_owned(),
        BreakEven::Same => "=".to_owned(),
        BreakEven::From(n) => count(n),
        BreakEven::Until(n) => format!("< {}", count(n)),
    };
    let quotients = row.ray_quotients(column);
    // all rounds agree which of both traces faster
    let is_sure =
        quotients.values().iter().all(|q| *q < 1.0) || quotients.values().iter().all(|q| *q > 1.0);
    Cell { text, style: if is_sure { Style::Plain } else { Style::Dim } }
}
