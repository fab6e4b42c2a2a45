//! What the rays of each kind fetch from which cache: the asking half, which runs under callgrind.
//!
//! Callgrind simulates two levels of caches, so each run gives the lines that the first level misses
//! and those that one further level misses. Caches are those of this machine in size and ways, with
//! least recently used lines replaced, without prefetchers. A window of neighbouring rays from the
//! middle of each batch is counted, after a window before it has filled the caches.

use accel_core::registry::Buildable;
use rayon::ThreadPool;
use serde::{Deserialize, Serialize};

use crate::answers::check::count;
use crate::callgrind::counted::{counted_phase, with_rays};
use crate::plan::Plan;
use crate::plan::measured_row::Built;
use crate::rays::batches::{Answers, Batch};
use crate::rounds::error::MeasureError;
use crate::scenes::LoadedScene;
use crate::settings::Precision;
use crate::system::pools::pool;

/// Width and height of the image whose rays are taken; that of the record where it is smaller.
const SIZE: u32 = 256;

/// A batch of a row, and which call of [`counted_phase`] was its.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct AskedBatch {
    /// Scene.
    pub scene: String,
    /// Structure.
    pub structure: String,
    /// What differs from its defaults.
    pub settings: String,
    /// Kind of rays and order.
    pub name: String,
    /// Rays that were counted.
    pub rays: u64,
    /// Intersection tests of these rays, one ray after the other.
    pub tests: u64,
    /// Traversal steps likewise.
    pub steps: u64,
}

/// Builds all rows of the plan in all its scenes and asks at most so many rays of each batch.
///
/// # Errors
/// [`MeasureError`] for scenes that cannot be loaded and structures that cannot answer.
pub fn ask_all(plan: &Plan<'_>, rays: usize) -> Result<Vec<AskedBatch>, MeasureError> {
    let mut asked = Vec::new();
    let pool = pool(1)?;
    for known in &plan.scenes {
        let loaded = known.load()?;
        match plan.precision {
            Precision::F32 => ask_scene::<f32>(plan, &loaded, &pool, rays, &mut asked)?,
            Precision::F64 => ask_scene::<f64>(plan, &loaded, &pool, rays, &mut asked)?,
        }
    }
    Ok(asked)
}

fn ask_scene<S: Buildable>(
    plan: &Plan<'_>,
    loaded: &LoadedScene,
    pool: &ThreadPool,
    most: usize,
    asked: &mut Vec<AskedBatch>,
) -> Result<(), MeasureError> {
    let scene = &loaded.scene.name;
    with_rays::<S, ()>(plan, loaded, SIZE, pool, |geometry, lights, all| {
        let all = all.in_orders(plan.orders, plan.seed, scene);
        for row in &plan.rows {
            let built = pool.install(|| row.build(geometry.prims(), lights));
            // what cannot be built has no figures, as in the record
            let Ok(built) = built else { continue };
            for batch in &all.restricted(|kind| row.answers(kind)).batches {
                let counted = most.min(batch.rays.len());
                let start = (batch.rays.len() - counted) / 2;
                let before = batch.window(start.saturating_sub(counted / 2)..start);
                let window = batch.window(start..start + counted);
                let work = pool.install(|| {
                    trace(&built, &before);
                    counted_phase(&mut || trace(&built, &window));
                    count(&built, &window).1
                });
                asked.push(AskedBatch {
                    scene: scene.clone(),
                    structure: row.structure().into(),
                    settings: row.settings(),
                    name: batch.name(),
                    rays: counted as u64,
                    tests: work.intersection_tests,
                    steps: work.traversal_steps,
                });
            }
        }
    })
}

fn trace<S: Buildable>(built: &Built<'_, S>, batch: &Batch<'_, S>) {
    let mut answers = Answers::new(batch.kind, batch.rays.len());
    built.trace(batch, &mut answers);
    std::hint::black_box(&answers);
}
