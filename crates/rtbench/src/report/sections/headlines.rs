//! Who wins, by how much, and how sure that is: in words.

use std::fmt::Write;

use crate::report::costs::{Lead, lead, lead_for, lead_over_all};
use crate::report::material::Material;
use crate::report::page::{Page, Shown};
use measurement::record::{SceneRecord, Verdict};
use presentation::html::Html;
use presentation::numbers::short;

/// The most names that are listed.
const NAMES: usize = 3;

/// Over all scenes, then each.
pub fn write(material: &Material, page: &mut Page) -> Shown {
    let (run, html) = (&material.run, &mut page.html);
    if !run.complete {
        alert(
            html,
            &format!(
                "This run was not finished: {} of {} scenes. `rtbench run --resume DIR` measures the \
                 others.",
                run.scenes.len(),
                run.planned.len()
            ),
        );
    }
    let seed = run.settings.seed;
    if run.scenes.len() > 1
        && let Some(lead) = lead_over_all(&material.profiles, seed)
    {
        html.element(
            "p",
            &[("class", "headline")],
            &sentence(&format!("Over all {} scenes", run.scenes.len()), &lead),
        );
    }
    html.open("ul", &[("class", "headlines")]);
    for (scene, profiles) in material.scenes() {
        html.open("li", &[]);
        html.element("strong", &[], &scene.name);
        let Some(fastest) = lead(profiles, seed) else {
            html.text(": no row was right and timed.");
            html.close();
            continue;
        };
        html.text(&sentence("", &fastest));
        let rays = scene.distinct_rays();
        let with_build = lead_for(profiles, rays as f64, seed);
        if let Some(lead) = with_build.filter(|lead| lead.first != fastest.first) {
            html.text(&format!(
                " With the build, for the {rays} rays of one image: {}{}.",
                lead.first,
                not_told_apart(&lead)
            ));
        }
        html.close();
    }
    html.close();
    for scene in &run.scenes {
        if let Some(text) = wrong_rows(scene) {
            alert(html, &text);
        }
    }
    Shown::Yes
}

fn alert(html: &mut Html, text: &str) {
    html.element("p", &[("class", "alert"), ("role", "note")], text);
}

/// The winner of a scene and how far ahead it is.
pub fn sentence(of: &str, lead: &Lead) -> String {
    let Lead { first, ties, next } = lead;
    let ahead = next.as_ref().map(|(label, times)| {
        format!(
            "{} times as fast [{}, {}] as {label}",
            short(times.median),
            short(times.low),
            short(times.high)
        )
    });
    match (ties.is_empty(), ahead) {
        (true, None) => format!("{of}: {first} alone was measured and right."),
        (true, Some(ahead)) => format!("{of}: {first} traces fastest, {ahead}, the next."),
        (false, None) => {
            format!(
                "{of}: no winner; {first} has the least median, {}.",
                names("not told apart from", ties)
            )
        }
        (false, Some(ahead)) => format!(
            "{of}: {first} has the least trace time, {}; {ahead}, the next that is told apart.",
            names("not told apart from", ties)
        ),
    }
}

fn not_told_apart(lead: &Lead) -> String {
    if lead.ties.is_empty() {
        return String::new();
    }
    format!(" ({})", names("not told apart from", &lead.ties))
}

/// A few names, and how many more there are.
pub fn names(before: &str, all: &[String]) -> String {
    let mut text = before.to_owned();
    for (i, name) in all.iter().take(NAMES).enumerate() {
        let _ = write!(text, "{} {name}", if i == 0 { "" } else { "," });
    }
    if all.len() > NAMES {
        let _ = write!(text, " and {} more", all.len() - NAMES);
    }
    text
}

fn wrong_rows(scene: &SceneRecord) -> Option<String> {
    let wrong = scene.rows.iter().filter(|row| row.verdict == Verdict::Wrong);
    let wrong: Vec<String> = wrong.map(|row| row.label()).collect();
    (!wrong.is_empty()).then(|| {
        format!("{}: {}. No times are shown of them.", scene.name, names("wrong hits of", &wrong))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use statistics::estimate::Estimate;

    #[test]
    fn what_is_not_told_apart_is_said() {
        let quotient = |label: &str, median: f64, high: f64| {
            (label.to_owned(), Estimate { median, low: median / 1.25, high })
        };
        let of = |ties: Vec<&str>, next: Option<(String, Estimate)>| {
            let next = next.map(|(label, quotient)| (label, quotient.inverse()));
            let ties = ties.into_iter().map(str::to_owned).collect();
            sentence("tetra", &Lead { first: "bvh".to_owned(), ties, next })
        };
        assert_eq!(
            of(vec![], Some(quotient("grid", 0.5, 0.8))),
            "tetra: bvh traces fastest, 2.00 times as fast [1.25, 2.50] as grid, the next."
        );
        assert_eq!(
            of(vec!["tree"], Some(quotient("grid", 0.5, 0.8))),
            "tetra: bvh has the least trace time, not told apart from tree; 2.00 times as fast \
             [1.25, 2.50] as grid, the next that is told apart."
        );
        let all = of(vec!["a"; 6], None);
        assert_eq!(
            all,
            "tetra: no winner; bvh has the least median, not told apart from a, a, a and 3 more."
        );
        assert_eq!(of(vec![], None), "tetra: bvh alone was measured and right.");
    }
}
