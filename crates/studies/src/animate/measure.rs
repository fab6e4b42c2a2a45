//! Measuring an animation: frames in their order, in each all rows and rounds in a seeded random
//! order.

use accel_core::registry::Buildable;
use measurement::answers::arbiter::Arbiter;
use measurement::answers::reference::{Reference, Stage};
use measurement::rays::batches::BatchSet;
use measurement::rounds::MeasureError;
use measurement::rounds::interleaved::round_order;
use measurement::rounds::scene_run::lights_asked;
use measurement::rounds::scope::Scope;
use measurement::system::clock::Clock;
use measurement::system::panics::caught;
use measurement::system::pools::{Pools, pool};
use measurement::system::progress::Progress;
use scene_loading::{LoadError, Scene};

use crate::animate::Animate;
use crate::animate::lane::{Frame, FrameInput, Lane};
use crate::animate::quality::surface_points;
use crate::animate::record::{AnimationRecord, FrameRecord};
use crate::error::StudyError;

/// Measures all frames, which `scene_of` makes by their numbers, into `record`; the bar has a step
/// for each. `watch` sees what there is after each.
pub fn measure<S: Buildable>(
    animate: &Animate<'_>,
    mut scene_of: impl FnMut(u32) -> Result<Scene, LoadError>,
    (clock, progress): (&dyn Clock, &Progress),
    record: &mut AnimationRecord,
    mut watch: impl FnMut(&mut AnimationRecord),
) -> Result<(), StudyError> {
    let plan = &animate.plan;
    let pools = Pools::new(plan.threads)?;
    let measured = animate.threads.iter();
    let measured = measured.map(|&n| Ok(pool(n)?)).collect::<Result<Vec<_>, StudyError>>()?;
    let mut lanes: Vec<Lane<'_>> = plan
        .rows
        .iter()
        .flat_map(|row| measured.iter().filter_map(|pool| Lane::new(row, pool, animate.rounds)))
        .collect();
    let mut first = None;
    let mut before = None;
    let [begin, end] = animate.frames;
    for number in begin..=end {
        progress.message(format!("{}: frame {number}", animate.scene));
        let scene = scene_of(number).map_err(MeasureError::from)?;
        let frame = Frame::<S>::new(number, scene, first.as_ref(), before.as_ref())?;
        if number > begin && frame.moved.is_none() {
            // no structure of the frame before can be updated
            lanes.iter_mut().for_each(|lane| lane.kept.fill_with(|| None));
        }
        let visited = visit_all(animate, &frame, &pools, (clock, progress), &mut lanes)?;
        record.frames.push(visited);
        record.lanes = lanes.iter().map(|lane| lane.record.clone()).collect();
        watch(record);
        progress.step(clock.now());
        let done = before.replace(frame.geometry);
        if first.is_none() {
            first = done;
        }
    }
    Ok(())
}

/// All rounds of all rows on a frame.
fn visit_all<S: Buildable>(
    animate: &Animate<'_>,
    frame: &Frame<S>,
    pools: &Pools,
    (clock, progress): (&dyn Clock, &Progress),
    lanes: &mut [Lane<'_>],
) -> Result<FrameRecord, StudyError> {
    let plan = &animate.plan;
    let arbiter = Arbiter::new(&frame.geometry, &frame.exact)
        .map_err(MeasureError::of_build(&frame.scene.name))?;
    let stage = Stage { scene: &frame.scene, geometry: &frame.geometry, arbiter: &arbiter };
    let Reference { rays, answers, record: mut judged } = stage.reference(plan, pools)?;
    let lights = lights_asked(&frame.scene, &plan.settings);
    let asked = BatchSet::new(&rays, answers, &lights);
    let asked = asked.in_orders(plan.orders, plan.seed, &frame.scene.name);
    let points = surface_points(frame.geometry.prims(), plan.seed);
    let on = FrameInput {
        frame,
        scope: Scope { plan, stage: &stage, lights: &lights, all: &asked, pools, clock, progress },
        points: &points,
    };
    let what = format!("{}/{}", animate.scene, frame.number);
    for round in 0..animate.rounds {
        for lane in round_order(plan.seed, &what, round, lanes.len()) {
            let Some(lane) = lanes.get_mut(lane).filter(|lane| lane.record.error.is_none()) else {
                continue;
            };
            lane.record.error = match caught(|| lane.visit(&on, round)) {
                Ok(Ok(())) => None,
                Ok(Err(error)) => Some(format!("frame {}: {error}", frame.number)),
                Err(panicked) => Some(format!("frame {}: {panicked}", frame.number)),
            };
        }
    }
    if let (Some(first), n @ 1..) = (&judged.reference, arbiter.contradicted()) {
        for lane in lanes.iter_mut().filter(|lane| lane.record.label() == *first) {
            lane.record.mismatches += n as u64;
        }
        judged.refused.push(format!("{first}: wrong on {n} rays that others answered otherwise"));
    }
    Ok(FrameRecord {
        frame: frame.number,
        primitives: frame.geometry.len() as u64,
        moved: frame.moved.as_ref().map(|moved| moved.len() as u64),
        rays: asked.total() as u64,
        oracle: judged,
    })
}
