//! An animation as CSV: a row for each frame, structure and number of threads.

use presentation::csv::{number, written};
use presentation::format_error::FormatError;
use statistics::estimate::median;

use crate::animate::record::AnimationRecord;

/// Everything of each frame.
///
/// # Errors
/// [`FormatError`].
pub fn frames(run: &AnimationRecord) -> Result<String, FormatError> {
    written(|writer| {
        writer.write_record([
            "scene",
            "frame",
            "primitives",
            "moved",
            "rays",
            "structure",
            "settings",
            "threads",
            "rounds",
            "updated",
            "update_s",
            "trace_s",
            "every_nth_ray",
            "bytes",
            "n_it",
            "n_ts",
            "expected_cost",
            "overlap",
            "mismatches_of_all_frames",
        ])?;
        for lane in &run.lanes {
            for frame in &lane.frames {
                let of = run.frames.iter().find(|f| f.frame == frame.frame);
                let count = |n: Option<u64>| n.map(|n| n.to_string()).unwrap_or_default();
                let shown = |samples: &[f64]| number(median(samples).filter(|_| lane.is_timed()));
                let a_ray = |of: fn(&measurement::record::WorkRecord) -> u64| {
                    number(frame.work.as_ref().map(|w| of(w) as f64 / w.rays.max(1) as f64))
                };
                writer.write_record([
                    run.scene.clone(),
                    frame.frame.to_string(),
                    count(of.map(|f| f.primitives)),
                    count(of.and_then(|f| f.moved)),
                    count(of.map(|f| f.rays)),
                    lane.structure.clone(),
                    lane.settings.clone(),
                    lane.threads.to_string(),
                    frame.update_s.len().to_string(),
                    frame.updated.to_string(),
                    shown(&frame.update_s),
                    shown(&frame.trace_s),
                    lane.stride.to_string(),
                    frame.bytes.to_string(),
                    a_ray(|work| work.intersection_tests),
                    a_ray(|work| work.traversal_steps),
                    number(frame.expected_cost),
                    number(frame.overlap),
                    lane.mismatches.to_string(),
                ])?;
            }
        }
        Ok(())
    })
}
