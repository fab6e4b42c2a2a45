//! The time to an image: the build, one million primary rays, and the shadow rays of their hits.
//!
//! A structure that traces fast but is built slowly is no gain where the scene changes with every
//! image. The sum says what an image without reflections costs, so that build and trace need not be
//! weighed by taste. It is derived from what rounds measured: rays in the order of the image, each
//! kind scaled to that of a million primary rays. A row that was timed on a sample stands for all
//! rays by its ratio to the reference on that sample, as in [`costs`].
//!
//! It is compared with the fastest row of obvhs in the same scene, whatever its preset and its
//! known wrong hits.

use std::collections::BTreeMap;

use accel_core::structures::obvhs::{bvh2, cwbvh};

use crate::run::costs::{self, all_rays_s};
use crate::run::leads::TimedRow;
use measurement::record::query::Query;
use measurement::record::{AnsweredRays, RowRecord, Sample, SceneRecord, Verdict};
use statistics::estimate::Estimate;
use statistics::series::geometric_mean_of;

/// Primary rays of the image.
pub const PRIMARY_RAYS: f64 = 1e6;

#[derive(Debug, Clone, PartialEq)]
pub struct TimeToImage {
    pub timed: TimedRow,
    pub is_obvhs: bool,
    /// It may be called the best of anything.
    pub may_lead: bool,
}

impl TimeToImage {
    /// Time of a correct row, or of obvhs with a known defect; `None` unless primary and shadow
    /// rays were both timed in the order of the image.
    fn of(scene: &SceneRecord, row: &RowRecord, reference: Option<&RowRecord>) -> Option<Self> {
        let is_obvhs = [bvh2::INFO.name, cwbvh::INFO.name].contains(&&*row.structure);
        let serves = row.verdict == Verdict::Ok || is_obvhs && row.verdict.is_timed();
        if !serves || row.answers != AnsweredRays::AllRays {
            return None;
        }
        let of = |sample: &Sample| {
            let seconds = seconds(scene, row, reference, sample)?;
            Some(((sample.process, sample.round), seconds))
        };
        let rounds = row.samples.iter().filter_map(of).collect();
        let timed = TimedRow::new(row.label(), row.query, rounds)?;
        Some(Self { timed, is_obvhs, may_lead: scene.may_lead(row) })
    }
}

#[derive(Debug)]
pub struct TimesToImage<'a> {
    scene: &'a SceneRecord,
    /// Times of all rows that have one, in the scene's order.
    times: Vec<TimeToImage>,
}

impl<'a> TimesToImage<'a> {
    /// Times of all rows of a scene that have one.
    pub fn of(scene: &'a SceneRecord) -> Self {
        let reference = costs::reference(scene);
        let times = scene.rows.iter().filter_map(|row| TimeToImage::of(scene, row, reference));
        Self { scene, times: times.collect() }
    }

    pub fn leading(&self) -> impl Iterator<Item = &TimedRow> {
        self.times.iter().filter(|time| time.may_lead).map(|time| &time.timed)
    }

    pub fn of_row(&self, label: &str) -> Option<&TimeToImage> {
        self.times.iter().find(|time| time.timed.label == label)
    }

    pub fn fastest_obvhs(&self) -> Option<&TimeToImage> {
        self.fastest(|time| time.is_obvhs)
    }

    pub fn fastest_other(&self, query: Query) -> Option<&TimeToImage> {
        self.fastest(|time| !time.is_obvhs && time.timed.query == query)
    }

    fn fastest(&self, is_meant: impl Fn(&TimeToImage) -> bool) -> Option<&TimeToImage> {
        let meant = self.times.iter().filter(|time| is_meant(time));
        meant.min_by(|a, b| a.timed.middle.total_cmp(&b.timed.middle))
    }
}

/// The row's time over that of the fastest row of obvhs, by scene: medians over the rounds by the
/// name of the scene, and their geometric mean. None where no scene has both.
pub fn over_scenes(
    scenes: &[TimesToImage<'_>],
    label: &str,
    seed: u64,
) -> Option<(BTreeMap<String, f64>, Estimate)> {
    let mut by_scene = BTreeMap::new();
    let mut groups = Vec::new();
    for times in scenes {
        let (Some(own), Some(obvhs)) = (times.of_row(label), times.fastest_obvhs()) else {
            continue;
        };
        let quotients = own.timed.quotients(&obvhs.timed);
        let Some(middle) = quotients.middle() else { continue };
        by_scene.insert(times.scene.name.clone(), middle);
        groups.push(quotients);
    }
    Some((by_scene, geometric_mean_of(&groups, seed)?))
}

/// The sum for a visit.
fn seconds(
    scene: &SceneRecord,
    row: &RowRecord,
    reference: Option<&RowRecord>,
    sample: &Sample,
) -> Option<f64> {
    let primary = *scene.rays.get("primary").filter(|n| **n > 0)? as f64;
    let traced = ["primary", "shadow"]
        .map(|kind| all_rays_s(scene, row, reference, sample, kind))
        .into_iter()
        .sum::<Option<f64>>()?;
    Some(sample.build_s + traced * (PRIMARY_RAYS / primary))
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::record::RunRecord;
    use measurement::record::made_up::run;

    /// Rows take their time for primary rays, twice that for shadow rays, a tenth to build.
    fn made(rows: &[(&str, &[f64])]) -> RunRecord {
        let mut record = run(&[("tetra", rows)]);
        let scene = &mut record.scenes[0];
        scene.rays = [("primary".into(), 500_000), ("shadow".into(), 300_000)].into();
        for row in &mut scene.rows {
            row.rays_by_kind = scene.rays.clone();
            for sample in &mut row.samples {
                for seconds in [&mut sample.trace_s, &mut sample.reference_by_kind] {
                    let primary = seconds["primary"];
                    seconds.insert("shadow".into(), 2.0 * primary);
                }
            }
        }
        record
    }

    #[test]
    fn time_to_image_is_build_plus_a_million_primary_rays_and_shadow_rays() {
        let record = made(&[("obvhs-cwbvh", &[1.0, 1.0, 1.0])]);
        let times = TimesToImage::of(&record.scenes[0]).times;
        // 0.1 to build; of half a million rays 1 and of their shadow rays 2, both twice
        assert!((times[0].timed.middle - 6.1).abs() < 1e-12, "{times:?}");
    }

    #[test]
    fn the_fastest_are_found_and_batches_stand_apart() {
        let mut record = made(&[
            ("obvhs-cwbvh", &[2.0, 2.2]),
            ("obvhs-bvh2 preset=fastest", &[1.0, 1.1]),
            ("uniform-grid", &[3.0, 3.3]),
            ("irregular-grid query=batch", &[0.5, 0.55]),
            ("hug", &[0.1, 0.1]),
        ]);
        record.scenes[0].rows[3].query = Query::Batch;
        // what is wrong is never the fastest
        record.scenes[0].rows[4].verdict = Verdict::WrongAsShipped;
        let scenes = [TimesToImage::of(&record.scenes[0])];
        let times = &scenes[0];
        assert_eq!(times.times.len(), 4);
        assert_eq!(times.fastest_obvhs().unwrap().timed.label, "obvhs-bvh2 preset=fastest");
        assert_eq!(times.fastest_other(Query::OneRay).unwrap().timed.label, "uniform-grid");
        let batch = times.fastest_other(Query::Batch).unwrap();
        assert_eq!(batch.timed.label, "irregular-grid query=batch");
        let (by_scene, mean) = over_scenes(&scenes, &batch.timed.label, 1).unwrap();
        assert!((mean.median - 0.5).abs() < 1e-12 && (by_scene["tetra"] - 0.5).abs() < 1e-12);
        assert_eq!(over_scenes(&scenes, "hug", 1), None);
        // but obvhs with its known defects is what others are compared with
        let fastest = times.fastest_obvhs().unwrap().timed.label.clone();
        record.scenes[0].rows[1].verdict = Verdict::WrongAsShipped;
        let known = TimesToImage::of(&record.scenes[0]);
        assert_eq!(known.fastest_obvhs().unwrap().timed.label, fastest);
        record.scenes[0].rows[1].verdict = Verdict::Wrong;
        let wrong = TimesToImage::of(&record.scenes[0]);
        assert_eq!(wrong.fastest_obvhs().unwrap().timed.label, "obvhs-cwbvh");
    }

    #[test]
    fn a_sampled_row_stands_for_all_rays_by_its_ratio() {
        let mut record = made(&[("obvhs-cwbvh", &[1.0]), ("uniform-grid", &[5.0])]);
        // on every eighth ray, which the reference answers in 0.25 in place of an eighth of 1
        let row = &mut record.scenes[0].rows[1];
        row.stride = 8;
        row.rays_by_kind.values_mut().for_each(|n| *n /= 8);
        row.samples[0].reference_by_kind.values_mut().for_each(|s| *s /= 4.0);
        let times = TimesToImage::of(&record.scenes[0]).times;
        // 20 times the reference's 3 seconds for all rays, twice; 0.5 to build
        assert!(
            (times[1].timed.middle - (0.5 + 2.0 * (20.0 + 20.0 * 2.0))).abs() < 1e-9,
            "{times:?}"
        );
    }

    #[test]
    fn without_shadow_rays_there_is_no_image() {
        let mut record = made(&[("obvhs-cwbvh", &[1.0])]);
        record.scenes[0].rows[0].samples[0].trace_s.remove("shadow");
        assert_eq!(TimesToImage::of(&record.scenes[0]).times, []);
    }
}
