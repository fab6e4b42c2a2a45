//! Mailboxes: answers must not change, tests must become fewer.

use super::prelude::*;

pub static AXIS: Axis = Axis {
    name: "mailbox",
    summary: "tests saved of a primitive in several cells: none, slots of a hash, stamps",
    paper: "Arnaldi, Priol, Bouatouch 1987; Benthin 2006",
    metric: "answers in 10^6 that differ from those without a mailbox",
    reference: "the same grid without a mailbox, triangles one by one",
    scenes: &["teapot", "gears", "pavilion"],
    setting: "uniform-grid.mailbox, uniform-grid.mailbox-slots",
    measure: Measure::Whole(measure),
};

const VARIANTS: [(&str, &str); 6] = [
    ("none", "uniform-grid:density=8:kernel=scalar"),
    ("hash, 1 slot", "uniform-grid:density=8:mailbox=hash:mailbox-slots=1"),
    ("hash, 8 slots", "uniform-grid:density=8:mailbox=hash:mailbox-slots=8"),
    ("hash, 64 slots", "uniform-grid:density=8:mailbox=hash:mailbox-slots=64"),
    ("array per thread", "uniform-grid:density=8:mailbox=array"),
    ("stamp in the primitive", "uniform-grid:density=8:mailbox=primitive"),
];

fn measure(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let built = stage.built_all(&VARIANTS.map(|(_, label)| label))?;
    let batches = stage.all_batches();
    let rays = count(&batches);
    let replays = replays(&built, &batches);
    let error = |r: &Replay<'_, f32>| {
        let wrong = replays.first().map_or(0, |reference| r.differing(reference));
        ErrorOf::Counted { wrong, trials: rays as u64 }
    };
    let errors: Vec<ErrorOf> = replays.iter().map(error).collect();
    let variants = built.iter().zip(replays).zip(errors).zip(VARIANTS);
    let variants = variants.map(|(((built, replay), error), (name, _))| {
        let work = counted(&*built.tracer, &batches);
        let per_ray = |n: u64| n as f64 / rays.max(1) as f64;
        Variant {
            is_reference: name == "none",
            also: vec![
                ("tests per ray", per_ray(work.intersection_tests)),
                ("tests saved per ray", per_ray(work.tests_saved)),
            ],
            ..Variant::built(name, built, error, replay)
        }
    });
    let work = format!("{rays} rays of the scene through a uniform grid of 8 cells per primitive");
    Ok(timed(stage, SceneOutcome::new(work, "the same rays"), variants))
}
