//! Conclusions of a run: the fastest row by question, and the smallest.
//!
//! A row that is known to be wrong, or whose answers were not all compared, never leads. What a
//! plugin says of its own memory is not counted. Rows that answer ray by ray stand against one
//! another; where others answer batches and one of those is faster than all, that is a second
//! answer.

use std::collections::BTreeSet;

use measurement::record::query::Query;
use measurement::record::{
    AnsweredRays, Conclusion, Defective, LeastTime, NextRow, Question, RowRecord, RunRecord,
    SceneRecord, Verdict, with_query,
};

use crate::run::costs::{Cost, Profile, all_rays_s, count_interval, envelope, profiles, reference};
use crate::run::kind_tables::kinds_of;
use crate::run::leads::{Ranking, TimedRow, lead};
use crate::run::time_to_image::TimesToImage;

use statistics::estimate::Estimate;
use statistics::series::geometric_mean_of;

pub fn conclude_scene(scene: &mut SceneRecord, seed: u64) {
    scene.conclusions = conclusions(&[scene], seed);
    scene.least_time = least_time(&profiles(scene), seed);
}

/// Concludes from each scene, and from all together.
pub fn conclude(run: &mut RunRecord) {
    let seed = run.settings.seed;
    run.scenes.iter_mut().for_each(|scene| conclude_scene(scene, seed));
    conclude_run(run);
}

/// Concludes from all scenes together, where there are several.
pub fn conclude_run(run: &mut RunRecord) {
    run.conclusions = match &run.scenes[..] {
        [] | [_] => Vec::new(),
        scenes => conclusions(&scenes.iter().collect::<Vec<_>>(), run.settings.seed),
    };
}

fn conclusions(scenes: &[&SceneRecord], seed: u64) -> Vec<Conclusion> {
    let kinds = kinds_of(scenes.iter().copied());
    let traces = kinds.into_iter().map(|kind| Question::Trace(kind.to_owned()));
    let questions = std::iter::once(Question::FirstImage).chain(traces).chain([Question::Memory]);
    questions.flat_map(|question| answers(question, scenes, seed)).collect()
}

/// Values of rows for a question, by scene; scenes without values are left out.
fn answers(question: Question, scenes: &[&SceneRecord], seed: u64) -> Vec<Conclusion> {
    let is_asked = |scene: &&&SceneRecord| match &question {
        Question::Trace(kind) => scene.rays.contains_key(kind),
        Question::FirstImage | Question::Memory => true,
    };
    let mut all: Vec<Vec<TimedRow>> =
        scenes.iter().filter(is_asked).map(|scene| timed(&question, scene)).collect();
    let defective: Vec<Vec<Suspect<'_>>> =
        scenes.iter().filter(is_asked).map(|scene| suspects(&question, scene)).collect();
    let is_batch = |t: &&TimedRow| t.query == Query::Batch;
    let batches: BTreeSet<String> =
        all.iter().flatten().filter(is_batch).map(|t| t.label.clone()).collect();
    let conclusion = |query, lead: Ranking, all: &[Vec<TimedRow>]| Conclusion {
        question: question.clone(),
        query,
        defective: closer_than_next(&lead, query, all, &defective, seed),
        row: lead.first,
        figure: lead.took,
        not_different: lead.ties,
        next: lead.next.map(|(row, times)| NextRow { row, times }),
    };
    let is_one_ray = |t: &&TimedRow| !batches.contains(&t.label);
    let ray_by_ray = || {
        let one_ray = |scene: &Vec<TimedRow>| scene.iter().filter(is_one_ray).cloned().collect();
        lead(&all.iter().map(one_ray).collect::<Vec<Vec<TimedRow>>>(), seed)
    };
    if batches.is_empty() {
        let first = lead(&all, seed);
        return first.map(|lead| conclusion(Query::OneRay, lead, &all)).into_iter().collect();
    }
    let one_ray = all.clone();
    let first = ray_by_ray().filter(|_| question != Question::Memory);
    for row in all.iter_mut().flatten().filter(|t| batches.contains(&t.label)) {
        row.label = with_query(std::mem::take(&mut row.label), true);
    }
    let is_faster = |lead: &Ranking| first.as_ref().is_none_or(|first| first.first != lead.first);
    let second = lead(&all, seed).filter(is_faster);
    let first = first.map(|lead| conclusion(Query::OneRay, lead, &one_ray));
    first.into_iter().chain(second.map(|lead| conclusion(Query::Batch, lead, &all))).collect()
}

/// A row that is not the best of anything since answers of it may be wrong by a known defect.
struct Suspect<'r> {
    timed: TimedRow,
    row: &'r RowRecord,
}

fn suspects<'r>(question: &Question, scene: &'r SceneRecord) -> Vec<Suspect<'r>> {
    let is_suspect = |row: &&RowRecord| match row.verdict {
        Verdict::WrongAsShipped => true,
        verdict => verdict == Verdict::Ok && row.known_defect.is_some(),
    };
    let rows = scene.rows.iter().filter(is_suspect);
    let images = TimesToImage::of(scene);
    let timed = |row: &RowRecord| match question {
        Question::FirstImage => Some(images.of_row(&row.label())?.timed.clone()),
        Question::Trace(kind) => of_kind(scene, row, kind),
        Question::Memory => None,
    };
    rows.filter_map(|row| Some(Suspect { timed: timed(row)?, row })).collect()
}

/// The rows with a known defect that every scene has and that are not significantly slower than the
/// first, or closer to it than the next row.
fn closer_than_next(
    lead: &Ranking,
    query: Query,
    all: &[Vec<TimedRow>],
    suspects: &[Vec<Suspect<'_>>],
    seed: u64,
) -> Vec<Defective> {
    let firsts: Option<Vec<&TimedRow>> =
        all.iter().map(|scene| scene.iter().find(|timed| timed.label == lead.first)).collect();
    let is_closer =
        |times: &Estimate| lead.next.as_ref().is_none_or(|(_, next)| times.median < next.median);
    let (Some(firsts), Some(of_first)) = (firsts, suspects.first()) else { return Vec::new() };
    let is_asked_so = |s: &&Suspect<'_>| query == Query::Batch || s.timed.query == Query::OneRay;
    let found = of_first.iter().filter(is_asked_so).filter_map(|suspect| {
        let label = &suspect.timed.label;
        let own = suspects.iter().map(|scene| scene.iter().find(|s| s.timed.label == *label));
        let own = own.collect::<Option<Vec<_>>>()?;
        let quotients: Vec<_> =
            own.iter().zip(&firsts).map(|(own, first)| own.timed.quotients(first)).collect();
        let times = geometric_mean_of(&quotients, seed)?;
        (times.low <= 1.0 || is_closer(&times)).then(|| Defective {
            row: label.clone(),
            times,
            wrong: own.iter().map(|s| s.row.mismatches).sum(),
            rays: own.iter().map(|s| s.row.checked_rays).sum(),
        })
    });
    let mut found: Vec<Defective> = found.collect();
    found.sort_by(|a, b| a.times.median.total_cmp(&b.times.median));
    found
}

/// Values of the rows of a scene that may lead.
fn timed(question: &Question, scene: &SceneRecord) -> Vec<TimedRow> {
    let rows = scene.rows.iter().filter(|row| scene.may_lead(row));
    match question {
        Question::FirstImage => TimesToImage::of(scene).leading().cloned().collect(),
        Question::Trace(kind) => rows.filter_map(|row| of_kind(scene, row, kind)).collect(),
        Question::Memory => rows.filter_map(bytes).collect(),
    }
}

/// Seconds for a ray of a kind.
fn of_kind(scene: &SceneRecord, row: &RowRecord, kind: &str) -> Option<TimedRow> {
    let rays = *scene.rays.get(kind)? as f64;
    let reference = reference(scene);
    let of = |sample| {
        let seconds = all_rays_s(scene, row, reference, sample, kind)?;
        Some(((sample.process, sample.round), seconds / rays))
    };
    let label = match row.answers {
        AnsweredRays::AllRays => row.label(),
        AnsweredRays::ShadowRays => format!("{} (shadow rays only)", row.label()),
    };
    TimedRow::new(label, row.query, row.samples.iter().filter_map(of).collect())
}

/// Bytes of what was built.
fn bytes(row: &RowRecord) -> Option<TimedRow> {
    let counts = row.answers == AnsweredRays::AllRays && row.plugin.is_none();
    let bytes = row.stats.as_ref().filter(|_| counts)?.memory_bytes;
    TimedRow::new(row.label(), row.query, [((0, 0), bytes as f64)].into())
}

/// Lower envelope of the cost lines of rows that may lead: the cheapest row, build included, by
/// number of rays.
pub fn least_time(profiles: &[Profile], seed: u64) -> Vec<LeastTime> {
    let may_lead: Vec<&Profile> = profiles.iter().filter(|p| p.may_lead).collect();
    let costs: Vec<Cost> = may_lead.iter().map(|p| p.cost).collect();
    let mut found: Vec<LeastTime> = Vec::new();
    let mut before: Option<&Profile> = None;
    for reign in envelope(&costs) {
        let Some(profile) = may_lead.get(reign.index) else { continue };
        let interval = before.and_then(|other| count_interval(profile, other, seed));
        let [low, high] = interval.unwrap_or([reign.from; 2]);
        if !reign.from.is_finite() || !low.is_finite() {
            continue;
        }
        found.push(LeastTime {
            row: profile.label.clone(),
            from_rays: reign.from,
            low,
            high: Some(high).filter(|high| high.is_finite()),
        });
        before = Some(profile);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::record::made_up::run;

    const ROUNDS: [f64; 6] = [1.0, 1.1, 0.9, 1.2, 1.05, 0.95];

    fn scaled(by: f64) -> Vec<f64> {
        ROUNDS.map(|s| s * by).into()
    }

    /// A scene of which the reference is known to be wrong, with a sampled row, a plugin and a
    /// batch.
    fn made() -> RunRecord {
        let times = [0.2, 2.0, 2.0, 3.0, 0.1, 0.05, 1.0].map(scaled);
        let labels = ["known", "grid", "other", "slow", "sampled", "wrong", "grid query=batch"];
        let rows: Vec<(&str, &[f64])> =
            labels.iter().zip(&times).map(|(label, times)| (*label, &times[..])).collect();
        let mut run = run(&[("tetra", &rows)]);
        let rows = &mut run.scenes[0].rows;
        rows[0].known_defect = Some("loses hits".into());
        rows[4].checked_rays = 10;
        rows[5].verdict = Verdict::WrongAsShipped;
        rows[6].query = Query::Batch;
        for (row, bytes) in rows.iter_mut().zip([1, 200, 100, 300, 1, 1, 200]) {
            row.stats.as_mut().unwrap().memory_bytes = bytes;
        }
        run
    }

    fn of<'c>(scene: &'c SceneRecord, question: &Question) -> Vec<&'c Conclusion> {
        scene.conclusions.iter().filter(|c| c.question == *question).collect()
    }

    #[test]
    fn wrong_or_unchecked_rows_never_lead() {
        let mut run = made();
        let scene = &mut run.scenes[0];
        conclude_scene(scene, 1);
        let trace = of(scene, &Question::Trace("primary".into()));
        let [one_ray, batch] = trace[..] else { panic!("{trace:?}") };
        assert_eq!((one_ray.row.as_str(), one_ray.query), ("grid", Query::OneRay));
        assert_eq!(one_ray.not_different, ["other"]);
        // and is named: a fortieth of the time
        let [wrong, known] = &one_ray.defective[..] else { panic!("{one_ray:?}") };
        assert!(wrong.row == "wrong" && wrong.times.holds(0.025) && wrong.rays > 0, "{wrong:?}");
        // as is one whose known defect did not show
        assert_eq!((known.row.as_str(), known.wrong), ("known", 0));
        let next = one_ray.next.as_ref().unwrap();
        assert_eq!(next.row, "slow");
        assert!(next.times.holds(1.5) && next.times.low > 1.0, "{next:?}");
        assert!(one_ray.figure.holds(2.0 * 1.025 / 256.0), "{one_ray:?}");
        assert_eq!((batch.row.as_str(), batch.query), ("grid query=batch (batch)", Query::Batch));
        assert_eq!(batch.next.as_ref().unwrap().row, "grid");
        let memory = of(scene, &Question::Memory);
        assert_eq!((memory[0].row.as_str(), memory.len()), ("other", 1));
        assert_eq!(memory[0].next.as_ref().unwrap().times.median, 2.0);
        // no shadow rays, no image
        assert!(of(scene, &Question::FirstImage).is_empty());
        let least: Vec<&str> = scene.least_time.iter().map(|l| l.row.as_str()).collect();
        assert_eq!(least, ["grid query=batch (batch)"]);
    }

    #[test]
    fn a_planted_claim_of_no_memory_is_rejected() {
        let mut run = made();
        let plugin = serde_json::json!({
            "file": "a.so", "sha256": "", "version": "1", "own_process": true, "own_test": false,
            "empty_call_s": 0.0, "edge_mismatches": 0,
        });
        run.scenes[0].rows[2].plugin = Some(serde_json::from_value(plugin).unwrap());
        conclude_scene(&mut run.scenes[0], 1);
        assert!(of(&run.scenes[0], &Question::Memory)[0].row.starts_with("grid"));
        // but its times are measured like all others
        let trace = of(&run.scenes[0], &Question::Trace("primary".into()));
        assert_eq!(trace[0].not_different, ["other"]);
    }

    #[test]
    fn a_slow_build_breaks_even_at_a_number_of_rays() {
        let mut run = made();
        let scene = &mut run.scenes[0];
        for (i, row) in scene.rows.iter_mut().enumerate() {
            for sample in &mut row.samples {
                // the batch costs 4 s to build, others 1 s
                sample.build_s = if i == 6 { 4.0 } else { 1.0 };
            }
        }
        conclude_scene(scene, 1);
        let [cheap, dear] = &scene.least_time[..] else { panic!("{:?}", scene.least_time) };
        assert_eq!((cheap.row.as_str(), cheap.from_rays), ("grid", 0.0));
        // 3 s of build for 1.025 s less of 256 rays
        assert!((dear.from_rays - 3.0 / (1.025 / 256.0)).abs() < 1e-6, "{dear:?}");
        assert!(dear.low <= dear.from_rays && dear.high.unwrap() >= dear.from_rays);
    }

    #[test]
    fn several_scenes_use_the_geometric_mean_of_rows_valid_in_all() {
        let mut both = made();
        let mut second = both.scenes[0].clone();
        second.name = "balls".into();
        second.rows[1].mismatches = 1;
        second.rows[1].verdict = Verdict::Wrong;
        both.scenes.push(second);
        conclude_run(&mut both);
        let trace = &both.conclusions[0];
        assert_eq!(trace.question, Question::Trace("primary".into()));
        assert_eq!((trace.row.as_str(), trace.not_different.len()), ("other", 0));
        both.scenes.truncate(1);
        conclude_run(&mut both);
        assert!(both.conclusions.is_empty());
    }

    #[test]
    fn no_conclusions_without_a_valid_row() {
        let mut run = made();
        for row in &mut run.scenes[0].rows {
            row.checked_rays = 255;
        }
        conclude_scene(&mut run.scenes[0], 1);
        assert!(run.scenes[0].conclusions.is_empty() && run.scenes[0].least_time.is_empty());
    }

    #[test]
    fn conclusions_are_read_as_they_were_written() {
        let mut run = made();
        conclude_scene(&mut run.scenes[0], 1);
        // an upper end that is never reached is none, not a number that JSON lacks
        run.scenes[0].least_time[0].high = None;
        let text = serde_json::to_string(&run).unwrap();
        assert_eq!(serde_json::from_str::<RunRecord>(&text).unwrap(), run);
    }
}
