//! The lecture's product: what an image costs, factor by factor, with the scene's own numbers.
//!
//! Source: G. Zachmann, lecture "Computer Graphics", Bremen 2007: pixels x primitives x ray tree x
//! shadow rays x supersamples x glossy x temporal x focal samples.
//!
//! Each factor is switched on after those before it. Beside what the product says stand a
//! prediction ([`model`]: the numbers of rays, tests and steps are counted on a small image of the
//! scene, the time of a test is measured in it ([`test_time`]), those of a ray and a step on two
//! other scenes) and the measured time.

pub mod model;

use accel_core::query::tracer::Tracer;
use renderer::work::CountingTracer;
use renderer::{Effect, EffectPlan, RenderSettings, render_plan};
use scene_loading::Scene;

use measurement::rounds::interleaved::timed;
use measurement::system::clock::Clock;
use statistics::estimate::median;

use model::{CountedWork, Model};

/// Pixels of the image that work is counted on, an axis.
const PROBE: u32 = 64;

/// Fewest and most rounds over the images of a scene, of which the medians count.
const ROUNDS: (usize, usize) = (3, 9);
/// Seconds after which the fewest are enough.
const ENOUGH: f64 = 5.0;

/// A structure over a scene, and what a test of the scene's primitives takes.
#[derive(Clone, Copy)]
pub struct TracedStructure<'t> {
    pub tracer: &'t dyn Tracer<f32>,
    pub seconds_per_test: f64,
}

/// A factor of the product, with all factors before it.
#[derive(Debug, Clone)]
pub struct Factor {
    pub name: &'static str,
    pub nominal: f64,
    pub says: String,
    /// The image with it.
    pub plan: EffectPlan,
}

/// The factors of a scene, in the order of the product; those it does not call for are left out.
pub fn factors(scene: &Scene, settings: &RenderSettings) -> Vec<Factor> {
    let sampled = [
        (Effect::Gloss, "glossy samples"),
        (Effect::Motion, "temporal samples"),
        (Effect::Focus, "focal samples"),
        (Effect::Supersampling, "supersamples"),
    ];
    let full = EffectPlan::of(scene, settings);
    let sharp = |plan: EffectPlan| sampled.iter().fold(plan, |plan, (e, _)| plan.without(*e));
    let flat = EffectPlan::of(scene, &RenderSettings { max_depth: 1, ..*settings });
    let [width, height] = settings.resolution;
    let (pixels, primitives) = (f64::from(width) * f64::from(height), scene.primitives.len());
    let mut all = vec![Factor {
        name: "pixels x primitives",
        nominal: pixels * primitives as f64,
        says: format!("{pixels} x {primitives}"),
        plan: sharp(flat).unlit(),
    }];
    let mut add = |name, nominal: f64, says: String, plan| {
        all.push(Factor { name, nominal, says, plan });
    };
    let tree = tree(&full, settings.max_depth);
    if tree > 1.0 {
        let says = format!("{tree} of depth {}", settings.max_depth);
        add("ray tree", tree, says, sharp(full.clone()).unlit());
    }
    let lights = scene.lights.len();
    if lights > 0 {
        let hard = sharp(full.clone()).without(Effect::SoftShadows);
        add("shadow rays", 1.0 + lights as f64, format!("1 + {lights}"), hard);
    }
    if full.calls_for(Effect::SoftShadows) {
        let n = full.factor(Effect::SoftShadows);
        let discs = scene.lights.iter().filter(|light| light.radius > 0.0).count();
        let rays = 1 + lights - discs + discs * n as usize;
        let nominal = rays as f64 / (1 + lights) as f64;
        add("shadow samples", nominal, format!("{rays} / {}", 1 + lights), sharp(full.clone()));
    }
    for (i, (effect, name)) in sampled.iter().enumerate() {
        let n = full.factor(*effect);
        if n > 1 {
            let later = &sampled[i + 1..];
            let plan = later.iter().fold(full.clone(), |plan, (e, _)| plan.without(*e));
            add(name, f64::from(n), n.to_string(), plan);
        }
    }
    all
}

/// Closest-hit rays of a full ray tree for an eye ray: two children where anything refracts, one
/// where things only mirror.
fn tree(plan: &EffectPlan, depth: u32) -> f64 {
    if plan.calls_for(Effect::Refraction) {
        2.0_f64.powi(depth as i32) - 1.0
    } else if plan.calls_for(Effect::Mirror) || plan.calls_for(Effect::Gloss) {
        f64::from(depth)
    } else {
        1.0
    }
}

/// The work of an image: counted on one of few pixels, scaled to its own.
pub fn counted(scene: &Scene, traced: TracedStructure<'_>, plan: &EffectPlan) -> CountedWork {
    let [width, height] = plan.settings().resolution;
    let probe = [width, height].map(|n| n.min(PROBE));
    let counter = CountingTracer::new(traced.tracer);
    let counts = render_plan(scene, &counter, &plan.clone().at(probe)).counts;
    let total = counter.total();
    let work = CountedWork {
        rays: counts.total() as f64,
        tests: total.intersection_tests as f64,
        steps: total.traversal_steps as f64,
        seconds_per_test: traced.seconds_per_test,
    };
    let pixels = |[w, h]: [u32; 2]| f64::from(w) * f64::from(h);
    work.times(pixels([width, height]) / pixels(probe))
}

/// Seconds of images, in the current rayon pool: medians over interleaved rounds.
pub fn measured(
    scene: &Scene,
    tracer: &dyn Tracer<f32>,
    factors: &[Factor],
    clock: &dyn Clock,
) -> Vec<f64> {
    let work = |factor: &'_ Factor| -> Box<dyn FnMut() + '_> {
        let plan = factor.plan.clone();
        Box::new(move || {
            std::hint::black_box(render_plan(scene, tracer, &plan));
        })
    };
    let mut works: Vec<_> = factors.iter().map(work).collect();
    let start = clock.now();
    let goes_on =
        |round| round < ROUNDS.0 || round < ROUNDS.1 && clock.seconds_since(start) < ENOUGH;
    let seconds = timed(&mut works, 1, &format!("cost/{}", scene.name), clock, goes_on);
    seconds.iter().map(|seconds| median(seconds).unwrap_or(f64::NAN)).collect()
}

#[derive(Debug, Clone, PartialEq)]
pub struct CostRow {
    pub name: &'static str,
    pub nominal: f64,
    /// The same in words.
    pub says: String,
    /// Counted work with all factors so far.
    pub work: CountedWork,
    pub predicted: f64,
    pub measured: f64,
    /// By how much the time grew with this factor.
    pub grew: f64,
    /// By how much the prediction grew with it.
    pub predicted_growth: f64,
}

pub fn rows(
    scene: &Scene,
    traced: TracedStructure<'_>,
    settings: &RenderSettings,
    model: &Model,
    clock: &dyn Clock,
) -> Vec<CostRow> {
    let mut rows: Vec<CostRow> = Vec::new();
    let factors = factors(scene, settings);
    let seconds = measured(scene, traced.tracer, &factors, clock);
    for (Factor { name, nominal, says, plan }, measured) in factors.into_iter().zip(seconds) {
        let work = counted(scene, traced, &plan);
        let predicted = model.seconds(work);
        let before = rows.last().map_or((1.0, 1.0), |row| (row.predicted, row.measured));
        let (predicted_growth, grew) = (predicted / before.0, measured / before.1);
        rows.push(CostRow {
            name,
            nominal,
            says,
            work,
            predicted,
            measured,
            grew,
            predicted_growth,
        });
    }
    rows
}

/// Returns whether a prediction is as good as asked for: between half and twice the measured time.
pub fn is_near(predicted: f64, measured: f64) -> bool {
    (0.5..=2.0).contains(&(predicted / measured))
}

/// The factor that the prediction is most wrong about.
pub fn worst(rows: &[CostRow]) -> Option<&CostRow> {
    let wrong = |(i, row): (usize, &CostRow)| {
        let ratio = match i {
            0 => row.predicted / row.measured,
            _ => row.predicted_growth / row.grew,
        };
        ratio.ln().abs()
    };
    let worst = rows.iter().enumerate().max_by(|a, b| wrong(*a).total_cmp(&wrong(*b)));
    worst.map(|(_, row)| row)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(name: &'static str, predicted: f64, measured: f64, growth: [f64; 2]) -> CostRow {
        CostRow {
            name,
            nominal: 1.0,
            says: String::new(),
            work: CountedWork::default(),
            predicted,
            measured,
            grew: growth[1],
            predicted_growth: growth[0],
        }
    }

    #[test]
    fn the_factor_that_is_off_is_named() {
        let right = row("pixels", 1.0, 1.1, [1.0, 1.1]);
        let planted = row("ray tree", 6.0, 2.0, [6.0, 1.8]);
        let follows = row("shadow rays", 12.0, 4.0, [2.0, 2.0]);
        let rows = [right.clone(), planted, follows];
        assert_eq!(worst(&rows).map(|r| r.name), Some("ray tree"));
        assert!(is_near(rows[0].predicted, rows[0].measured));
        assert!(!is_near(rows[1].predicted, rows[1].measured));
        let too_fast = row("pixels", 0.1, 1.0, [0.1, 1.0]);
        assert_eq!(worst(&[too_fast, right]).map(|r| r.predicted), Some(0.1));
        assert!(worst(&[]).is_none());
    }

    #[test]
    fn every_factor_of_a_scene_is_switched_on_once() {
        let catalogue = scene_loading::SceneCatalogue::embedded().unwrap();
        let scenes = ["effect-all", "effect-plain", "effect-mirror"].map(String::from);
        let scenes = catalogue.resolve(&scenes).unwrap();
        let names = |i: usize| -> Vec<&str> {
            let scene = scenes[i].load().unwrap().scene;
            factors(&scene, &RenderSettings::default()).iter().map(|f| f.name).collect()
        };
        assert_eq!(
            names(0),
            [
                "pixels x primitives",
                "ray tree",
                "shadow rays",
                "shadow samples",
                "glossy samples",
                "temporal samples",
                "focal samples",
                "supersamples"
            ]
        );
        assert_eq!(names(1), ["pixels x primitives"]);
        assert_eq!(names(2), ["pixels x primitives", "ray tree", "shadow rays"]);
    }
}
