//! The effect plan: what an image must simulate, found in the scene alone, and the stages that do
//! so and nothing else.

use scene_loading::Scene;

use super::effect::{EFFECTS, Effect, EffectInfo, RenderSettings, samples};
use super::eye::{Lens, Pinhole, Sampling, sampled};
use super::hits::{ImageColors, MovedSurfaces};
use super::lights::{DiscLights, PointLights};
use super::scatter::{Lobe, Scatter};
use super::stages::{EyeStage, LightStage, ScatterStage, Stages};
use crate::camera::EyeRays;

pub const MOST_SAMPLES_PER_PIXEL: u64 = 1 << 22;

#[derive(Debug, Clone)]
pub struct RequestedEffect {
    pub info: &'static EffectInfo,
    /// The reason in the scene.
    pub by: String,
}

/// Effects that an image must simulate.
#[derive(Debug, Clone)]
pub struct EffectPlan {
    /// Effects that are called for, in the order of [`EFFECTS`].
    pub called: Vec<RequestedEffect>,
    /// Samples of each effect, called for or not.
    samples: [u32; Effect::COUNT],
    settings: RenderSettings,
    /// Some material mirrors or transmits, and rays are long enough to show it.
    scatters: bool,
    lit: bool,
    gating: Gating,
}

/// True if effects that nothing calls for are left out. In an image they change nothing, since
/// nothing has their extent: this is here to show what leaving them out saves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Gating {
    /// Only what the scene calls for is simulated.
    #[default]
    AsCalledFor,
    /// Every eye ray has a moment of the exposure, too.
    Eye,
    /// Lights are asked as discs, mirrors as rough ones, surfaces as textured and moving ones, too.
    All,
}

impl EffectPlan {
    pub fn of(scene: &Scene, settings: &RenderSettings) -> Self {
        let called = |info: &'static EffectInfo| {
            (info.called_by)(scene, settings).map(|by| RequestedEffect { info, by })
        };
        let called: Vec<RequestedEffect> = EFFECTS.iter().filter_map(called).collect();
        let scattering = [Effect::Mirror, Effect::Gloss, Effect::Refraction];
        let scatters = called.iter().any(|called| scattering.contains(&called.info.effect));
        Self {
            called,
            samples: EFFECTS.each_ref().map(|info| samples(scene, settings, info.effect)),
            settings: *settings,
            scatters,
            lit: true,
            gating: Gating::AsCalledFor,
        }
    }

    /// The same under another rule for effects that nothing calls for.
    pub fn gated(self, gating: Gating) -> Self {
        Self { gating, ..self }
    }

    /// The same without an effect: its rays are not sent. Soft shadows become hard, rough mirrors
    /// perfect; what moves stands where it is when the shutter opens; what is textured has the
    /// plain colour of its material.
    pub fn without(mut self, effect: Effect) -> Self {
        self.called.retain(|called| called.info.effect != effect);
        self
    }

    /// The same for an image of another size.
    pub fn at(mut self, resolution: [u32; 2]) -> Self {
        self.settings.resolution = resolution;
        self
    }

    /// The same without any light.
    pub fn unlit(mut self) -> Self {
        self.lit = false;
        self.without(Effect::SoftShadows).without(Effect::HardShadows)
    }

    pub fn calls_for(&self, effect: Effect) -> bool {
        self.called.iter().any(|called| called.info.effect == effect)
    }

    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }

    /// Number of samples of an effect: 1 where it has none or is not called for.
    pub fn factor(&self, effect: Effect) -> u32 {
        if self.calls_for(effect) { self.samples[effect as usize] } else { 1 }
    }

    pub fn rays_per_pixel(&self) -> u32 {
        [Effect::Supersampling, Effect::Motion, Effect::Focus]
            .into_iter()
            .fold(1_u32, |n, effect| n.saturating_mul(self.factor(effect)))
    }

    /// Samples that one pixel may take at once: eye rays x glossy x shadow samples. Callers must
    /// refuse more than [`MOST_SAMPLES_PER_PIXEL`]: they would fill the memory.
    pub fn samples_per_pixel(&self) -> u64 {
        let factor = |effect| u64::from(self.factor(effect));
        u64::from(self.rays_per_pixel())
            .saturating_mul(factor(Effect::Gloss))
            .saturating_mul(factor(Effect::SoftShadows))
    }

    /// The stages of the tracer.
    ///
    /// The features of `scripts/effect-gating.sh` leave those of sampled effects out, or plant them
    /// where nothing calls for them.
    pub fn stages<'a>(&self, scene: &'a Scene, eye: EyeRays) -> Stages<'a> {
        if cfg!(feature = "delete-effects") {
            return plain_stages(scene, eye, true);
        }
        let mut stages = Stages {
            eye: self.eye(scene, eye),
            fan_out: self.factor(Effect::Gloss),
            hits: Vec::new(),
            lights: self.lights(scene),
            scatter: self.scatter(),
        };
        let all = self.gating == Gating::All;
        if all || self.calls_for(Effect::Motion) {
            stages.hits.push(Box::new(MovedSurfaces::new(scene)));
        }
        if all || self.calls_for(Effect::Textures) {
            stages.hits.push(Box::new(ImageColors(scene)));
        }
        stages
    }

    fn eye(&self, scene: &Scene, eye: EyeRays) -> Box<dyn EyeStage> {
        let flags = [Effect::Supersampling, Effect::Focus, Effect::Motion];
        let sampling = Sampling {
            rays: self.rays_per_pixel(),
            lens: Lens::new(&scene.camera),
            shutter: scene.camera.shutter,
            seed: self.settings.seed,
        };
        let planted = cfg!(feature = "plant-effect-cost");
        let timed = |effect| effect == Effect::Motion && self.gating != Gating::AsCalledFor;
        sampled(eye, sampling, flags.map(|e| planted || timed(e) || self.calls_for(e)))
    }

    fn lights(&self, scene: &Scene) -> Option<Box<dyn LightStage>> {
        let all = self.gating == Gating::All && self.lit && !scene.lights.is_empty();
        if all || self.calls_for(Effect::SoftShadows) {
            let samples = self.samples[Effect::SoftShadows as usize];
            return Some(Box::new(DiscLights::new(scene, samples, self.settings.seed)));
        }
        let lit = self.lit && !scene.lights.is_empty();
        lit.then(|| Box::new(PointLights::new(scene, true)) as _)
    }

    fn scatter(&self) -> Option<Box<dyn ScatterStage>> {
        let lobe = Lobe { samples: self.samples[Effect::Gloss as usize], seed: self.settings.seed };
        let [gloss, glass] =
            [Effect::Gloss, Effect::Refraction].map(|effect| self.calls_for(effect));
        let all = self.gating == Gating::All;
        let (gloss, glass) = (all || gloss, all || glass);
        match (glass, gloss) {
            (true, true) => Some(Box::new(Scatter::<true, true>(lobe))),
            (true, false) => Some(Box::new(Scatter::<true, false>(lobe))),
            (false, true) => Some(Box::new(Scatter::<false, true>(lobe))),
            (false, false) if self.scatters => Some(Box::new(Scatter::<false, false>(lobe))),
            (false, false) => None,
        }
    }
}

/// The stages of measurement: one ray per pixel, lights at their centres, perfect mirrors, whatever
/// the scene calls for.
pub fn plain_stages<'a>(scene: &'a Scene, eye: EyeRays, both_sides: bool) -> Stages<'a> {
    let lobe = Lobe { samples: 1, seed: 0 };
    Stages {
        eye: Box::new(Pinhole(eye)),
        fan_out: 1,
        hits: Vec::new(),
        lights: (!scene.lights.is_empty())
            .then(|| Box::new(PointLights::new(scene, both_sides)) as _),
        scatter: Some(Box::new(Scatter::<true, false>(lobe))),
    }
}
