//! The plots of a run: bars with intervals, and builds against rays.

use measurement::record::{
    AnsweredRays, RowRecord, RunRecord, SceneRecord, SummaryRow, Verdict, reference,
};
use presentation::numbers::short;
use presentation::svg_plot::bars::{Bar, BarChart, BarRow};
use presentation::svg_plot::{Axis, Mark, Plot, Point, Ring, Scale, Series};
use statistics::estimate::Estimate;
use studies::run::costs::Profile;
use studies::run::lines::wrong_rays;

/// Data of a bar chart for a row, of a scene or of all.
struct Ratios {
    name: String,
    verdict: Verdict,
    /// Effect of its known defect: `1 wrong ray of 203,423`.
    defect: Option<String>,
    answers: AnsweredRays,
    /// It may be called the fastest.
    may_lead: bool,
    trace: Option<Estimate>,
    build: Option<Estimate>,
}

/// Trace and build time of each row of a scene over the reference's.
pub fn scene_bars(run: &RunRecord, scene: &SceneRecord) -> BarChart {
    let reference = reference::of_scene(scene).unwrap_or_else(|| run.settings.reference.clone());
    let of = |row: &RowRecord| {
        let RowRecord { verdict, answers, ratio: trace, build_ratio: build, .. } = *row;
        let (name, may_lead) = (row.label_with_query(), scene.may_lead(row));
        let is_defect = verdict == Verdict::WrongAsShipped;
        let defect = is_defect.then(|| wrong_rays(row.mismatches, row.checked_rays));
        Ratios { name, verdict, defect, answers, may_lead, trace, build }
    };
    let rows = scene.rows.iter().map(of).collect();
    bars(format!("{}: times over those of {reference}", scene.name), rows)
}

/// The same over all scenes.
pub fn summary_bars(run: &RunRecord) -> BarChart {
    let reference = reference::of_means(&run.scenes, &run.settings.reference);
    let scenes = reference::scenes_over(&run.scenes, &reference);
    let title = format!("Times over those of {reference}, geometric means over {scenes} scene(s)");
    let of = |row: &SummaryRow| {
        let SummaryRow { verdict, answers, ratio: trace, build_ratio: build, .. } = *row;
        let (name, may_lead) = (row.label_with_query(), row.may_lead(&run.scenes));
        let own = |row: &&RowRecord| row.label_with_query() == name;
        let rows = || run.scenes.iter().flat_map(|scene| &scene.rows).filter(own);
        let is_defect = verdict == Verdict::WrongAsShipped;
        let defect = is_defect.then(|| {
            wrong_rays(rows().map(|r| r.mismatches).sum(), rows().map(|r| r.checked_rays).sum())
        });
        Ratios { name: name.clone(), verdict, defect, answers, may_lead, trace, build }
    };
    bars(title, run.summary.iter().map(of).collect())
}

fn bars(title: String, mut rows: Vec<Ratios>) -> BarChart {
    // what is wrong, and what answers shadow rays only, comes last
    let key = |r: &Ratios| (!is_comparable(r), r.trace.map_or(f64::INFINITY, |e| e.median));
    rows.sort_by(|a, b| {
        let (a, b) = (key(a), key(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let best = rows.iter().find(|r| r.may_lead && is_comparable(r)).and_then(|r| r.trace);
    let ring = |row: &Ratios, e: Estimate| match best.filter(|_| row.may_lead) {
        Some(best) if e == best => Ring::Best,
        Some(best) if is_comparable(row) && e.low <= best.high => Ring::AsGood,
        _ => Ring::None,
    };
    BarChart {
        title,
        subtitle:
            "medians with 95% intervals; shorter to the left is faster; ringed: the fastest with right \
             answers, dashed: its interval overlaps; arrow: beyond 10 times the best"
                .to_owned(),
        columns: ["trace time, ratio", "build time, ratio"].map(str::to_owned).into(),
        rows: rows
            .iter()
            .map(|row| BarRow {
                // what is wrong by design says how much
                name: match (&row.defect, row.answers) {
                    (Some(defect), _) => format!("{} ({defect})", row.name),
                    (None, AnsweredRays::AllRays) => row.name.clone(),
                    (None, AnsweredRays::ShadowRays) => format!("{} (shadow rays)", row.name),
                },
                color: 0,
                bars: vec![
                    bar(row.verdict, row.trace, |e| ring(row, e)),
                    bar(row.verdict, row.build, |_| Ring::None),
                ],
            })
            .collect(),
    }
}

fn is_comparable(row: &Ratios) -> bool {
    row.verdict == Verdict::Ok && row.answers == AnsweredRays::AllRays && row.trace.is_some()
}

/// A figure, or why there is none.
pub fn bar(verdict: Verdict, value: Option<Estimate>, ring: impl FnOnce(Estimate) -> Ring) -> Bar {
    match value {
        _ if !verdict.is_timed() => Bar::Words(verdict.name().to_owned()),
        None => Bar::Words("-".to_owned()),
        Some(e) => Bar::Of(e, short(e.median), ring(e)),
    }
}

/// Build time against time per ray: what is not dominated is ringed and named, the others are named
/// while a pointer is over them.
pub fn scatter(run: &RunRecord, scene: &SceneRecord, profiles: &[Profile]) -> Plot {
    let marks = profiles.iter().filter_map(|profile| {
        let ray = profile.ray_s(run.settings.seed)?;
        let is_on_front = !profiles.iter().any(|other| dominates(other, profile));
        Some(Mark {
            point: Point { x: profile.cost.build_s, y: ray.median, low: ray.low, high: ray.high },
            label: if is_on_front { profile.label.clone() } else { String::new() },
            hover: profile.label.clone(),
            ring: if is_on_front { Ring::Best } else { Ring::None },
            is_in_series: is_on_front,
        })
    });
    let marks: Vec<Mark> = marks.collect();
    let mut front: Vec<Point> = marks.iter().filter(|m| m.is_in_series).map(|m| m.point).collect();
    front.sort_by(|a, b| a.x.total_cmp(&b.x));
    Plot {
        title: format!("{}: build against rays", scene.name),
        subtitle:
            "medians, 95% intervals of the time per ray; the front is named, the table has all rows"
                .to_owned(),
        x: Axis { label: "build (seconds)".to_owned(), scale: Scale::Log },
        y: Axis { label: "time per ray (seconds)".to_owned(), scale: Scale::Log },
        series: vec![Series {
            name: "Pareto front: nothing builds and traces faster".to_owned(),
            points: front,
            is_joined: true,
        }],
        marks,
        marks_name: "dominated".to_owned(),
        ..Plot::default()
    }
}

/// As fast in both, and faster in one of them.
fn dominates(one: &Profile, other: &Profile) -> bool {
    let (a, b) = (one.cost, other.cost);
    let is_no_worse = a.build_s <= b.build_s && a.ray_s <= b.ray_s;
    is_no_worse && (a.build_s < b.build_s || a.ray_s < b.ray_s)
}
