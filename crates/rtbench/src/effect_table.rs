//! The effect plan of a scene as a table, with the rays that each effect adds.

use accel_core::query::tracer::Tracer;
use renderer::effects::EFFECTS;
use renderer::{Effect, EffectPlan, RayCounts, RenderSettings, render_plan};
use scene_loading::Scene;

use presentation::numbers::short;
use presentation::table::{Cell, Style, Table};

/// Pixels of the image that rays are counted on, an axis: enough for two digits.
const PROBE: u32 = 64;

/// One row an effect, called for or not.
pub fn of(scene: &Scene, tracer: &dyn Tracer<f32>, plan: &EffectPlan) -> Table {
    let probe = RenderSettings { resolution: [PROBE; 2], ..*plan.settings() };
    let plan = EffectPlan::of(scene, &probe);
    let counted = |plan: &EffectPlan| render_plan(scene, tracer, plan).counts;
    let all = counted(&plan);
    let mut table = Table {
        title: format!("{}: what it calls for", scene.name),
        header: vec!["effect", "samples", "rays/pixel", "called for by"],
        ..Table::default()
    };
    for info in EFFECTS {
        let row = match plan.called.iter().find(|c| c.info.effect == info.effect) {
            Some(called) => {
                let rays = added(info.effect, &all, || counted(&plan.clone().without(info.effect)));
                let samples = plan.factor(info.effect).to_string();
                vec![info.name.to_owned(), samples, per_pixel(rays), called.by.clone()]
            }
            None => vec![info.name.to_owned(), "-".into(), "0".into(), "nothing".into()],
        };
        let style = if plan.calls_for(info.effect) { Style::Plain } else { Style::Dim };
        table.rows.push(row.into_iter().map(|text| Cell { text, style }).collect());
    }
    table.notes = vec![
        format!(
            "all rays: {} per pixel, counted on {PROBE} x {PROBE} pixels",
            per_pixel(all.total())
        ),
        "rays/pixel: of shadows, mirrors and refraction their own; of what is sampled, all rays \
         that there would not be without it"
            .to_owned(),
    ];
    table
}

/// The rays an effect adds to an image.
fn added(effect: Effect, all: &RayCounts, without: impl FnOnce() -> RayCounts) -> u64 {
    match effect {
        Effect::HardShadows
        | Effect::Mirror
        | Effect::Refraction
        | Effect::SmoothNormals
        | Effect::Textures => all.effect(effect),
        Effect::SoftShadows
        | Effect::Gloss
        | Effect::Focus
        | Effect::Motion
        | Effect::Supersampling => all.total().saturating_sub(without().total()),
    }
}

fn per_pixel(rays: u64) -> String {
    short(rays as f64 / f64::from(PROBE * PROBE))
}
