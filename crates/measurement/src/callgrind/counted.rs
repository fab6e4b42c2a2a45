//! The counted work: each row of a record, built once and asked a fixed sample of rays, on one
//! thread.

use accel_core::registry::Buildable;
use glam::DVec3;
use rayon::ThreadPool;
use renderer::{Geometry, generate_rays};
use serde::{Deserialize, Serialize};

use crate::plan::Plan;
use crate::plan::measured_row::MeasuredRow;
use crate::rays::batches::{BatchSet, answer};
use crate::rounds::MeasureError;
use crate::rounds::scene_run::lights_asked;
use crate::scenes::LoadedScene;
use crate::settings::Precision;
use crate::system::panics::caught;
use crate::system::pools::pool;

/// Width and height of the image whose rays are taken; that of the record where it is smaller.
const SIZE: u32 = 32;
/// Rays of a kind, about.
const RAYS: usize = 256;
/// The same for structures that are always sampled.
const FEW_RAYS: usize = 16;

/// A row, and which calls of [`counted_phase`] were its.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CountedCalls {
    pub scene: String,
    pub structure: String,
    /// Settings that differ from the defaults.
    pub settings: String,
    pub rays: u64,
    /// The call that built it, from 0.
    pub build_call: Option<usize>,
    /// The call that asked it; none where it was not built.
    pub trace_call: Option<usize>,
}

/// The one function whose calls are counted.
#[inline(never)]
pub fn counted_phase(work: &mut dyn FnMut()) {
    work();
    // not a jump to the work, which would be a call of something else
    std::hint::black_box(());
}

/// Builds and asks all rows of the plan in all its scenes.
pub fn count_all(plan: &Plan<'_>) -> Result<Vec<CountedCalls>, MeasureError> {
    let mut counted = Vec::new();
    let mut calls = 0;
    // one pool for all scenes: threads that end while others begin change what allocating costs
    let pool = pool(1)?;
    for known in &plan.scenes {
        let loaded = known.load()?;
        match plan.precision {
            Precision::F32 => count_scene::<f32>(plan, &loaded, &pool, &mut calls, &mut counted)?,
            Precision::F64 => count_scene::<f64>(plan, &loaded, &pool, &mut calls, &mut counted)?,
        }
    }
    Ok(counted)
}

/// All rows in a scene, asked the rays of an image of at most [`SIZE`] pixels across, in its order.
fn count_scene<S: Buildable>(
    plan: &Plan<'_>,
    loaded: &LoadedScene,
    pool: &ThreadPool,
    calls: &mut usize,
    counted: &mut Vec<CountedCalls>,
) -> Result<(), MeasureError> {
    let scene = &loaded.scene;
    let geometry = Geometry::<S>::of(scene)?;
    let mut settings = plan.settings;
    settings.resolution = settings.resolution.map(|n| n.min(SIZE));
    let mut refused = Vec::new();
    let tracer = plan.answers.iter().find_map(|row| {
        let built = row.entry.build(geometry.prims(), &row.params);
        built.map_err(|e| refused.push(e.to_string())).ok()
    });
    let tracer = tracer.ok_or_else(|| MeasureError::NoAnswers {
        scene: scene.name.clone(),
        reasons: refused.join("; "),
    })?;
    let rays = pool.install(|| generate_rays(scene, &*tracer, &settings));
    let answers = pool.install(|| answer(&rays, &plan.kinds, &*tracer));
    let lights = lights_asked(scene, &plan.settings);
    let all = BatchSet::new(&rays, answers, &lights);
    for row in &plan.rows {
        let most = if row.is_sampled() { FEW_RAYS } else { RAYS };
        let asked = all.restricted(|kind| row.answers(kind));
        let stride = |rays: usize| rays.div_ceil(most).max(1);
        let thinned = asked.batches.iter().map(|b| b.thinned(stride(b.rays.len())));
        let set = BatchSet { stride: 1, batches: thinned.collect() };
        // within the pool: what is called from outside would run beside the counted function
        let phases = caught(|| pool.install(|| phases(row, &geometry, &lights, &set)));
        let [is_built, is_asked] = phases.unwrap_or([true, false]);
        let mut next = |happened: bool| {
            happened.then(|| {
                *calls += 1;
                *calls - 1
            })
        };
        counted.push(CountedCalls {
            scene: scene.name.clone(),
            structure: row.structure().into(),
            settings: row.settings(),
            rays: set.total() as u64,
            build_call: next(is_built),
            trace_call: next(is_asked),
        });
    }
    Ok(())
}

/// Builds and asks a row; which of both was done.
fn phases<S: Buildable>(
    row: &MeasuredRow<'_>,
    geometry: &Geometry<S>,
    lights: &[DVec3],
    set: &BatchSet<'_, S>,
) -> [bool; 2] {
    // once before it counts: the first asks the system for memory, which later ones find
    let build = row.prepare();
    drop(build(geometry.prims(), lights));
    let mut built = None;
    counted_phase(&mut || built = build(geometry.prims(), lights).ok());
    let Some(built) = built else { return [true, false] };
    let mut answers = set.answers();
    counted_phase(&mut || {
        for (batch, answers) in set.batches.iter().zip(&mut answers) {
            built.trace(batch, answers);
        }
    });
    std::hint::black_box(&answers);
    [true, true]
}
