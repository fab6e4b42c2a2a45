//! Images by samples, by cones and by beams: what each takes, and how far each is from the right
//! one.
//!
//! The question is the lecture's, which calls beams and cones "not really practical, far too
//! expensive" (G. Zachmann, "Computer Graphics", Bremen 2007). Samples are traced in f32 through
//! the fastest structure, as their users would; cones and beams in f64, where areas need it.

use std::collections::BTreeMap;

use crate::accuracy::pareto::{FrontPoint, standings};
use crate::images::{ConvergedImage, edge_rmse, edges, rmse};
use accel_core::query::region::FrustumWork;
use accel_core::query::tracer::Tracer;
use measurement::rounds::interleaved::{Visit, interleaved};
use measurement::system::clock::{Clock, timed};
use record::{ImageMeasurement, ImageRecord, Outcome, RowName, SampledImage, at_error};
use renderer::tracers::{DrawnImage, Frame, Refusal, Structures, TracerInfo, beam, cone, whitted};
use renderer::{EffectPlan, Image, RenderSettings, render_plan};
use scene_loading::{SampleWishes, Scene, Shape};
use statistics::series::Series;

pub mod queries;
pub mod record;
pub mod report;

/// A way to draw with cones or beams.
pub struct DrawingMethod {
    pub info: &'static TracerInfo,
    /// Its settings where they are not the default ones.
    pub settings: &'static str,
    /// The tracer with these settings.
    pub draw: fn(&Scene, Frame, Structures<'_>) -> Result<DrawnImage, Refusal>,
}

impl DrawingMethod {
    pub fn label(&self) -> String {
        format!("{} {}", self.info.name, self.settings).trim_end().to_owned()
    }
}

/// The ways without samples, in the order of the table: one entry each.
static WAYS: &[DrawingMethod] = &[
    DrawingMethod {
        info: &cone::INFO,
        settings: "",
        draw: |scene, frame, over| cone::draw(scene, frame, &cone::Settings::default(), over),
    },
    DrawingMethod {
        info: &cone::INFO,
        settings: "subdivisions=0",
        draw: |scene, frame, over| {
            let plain = cone::Settings { subdivisions: 0, ..Default::default() };
            cone::draw(scene, frame, &plain, over)
        },
    },
    DrawingMethod {
        info: &beam::INFO,
        settings: "",
        draw: |scene, frame, over| beam::draw(scene, frame, &beam::Settings::default(), over),
    },
];

/// The ways of the tracers that are asked for.
pub fn drawing_methods(
    is_asked: impl Fn(&TracerInfo) -> bool,
) -> impl Iterator<Item = &'static DrawingMethod> {
    WAYS.iter().filter(move |way| is_asked(way.info))
}

pub struct ComparisonInput<'a> {
    pub scene: &'a Scene,
    /// Structure that samples are traced through.
    pub sampler: &'a dyn Tracer<f32>,
    /// Structures that cones and beams query.
    pub structures: Structures<'a>,
    /// Size, depth and seed.
    pub frame: RenderSettings,
    /// Numbers of samples per pixel, in rising order.
    pub samples: &'a [u32],
    pub tracers: &'a [&'static str],
    pub rounds: u32,
}

/// Draws with every tracer that is asked for, `rounds` times in seeded random order, in the
/// current rayon pool. Times are those of the image alone: structures are built before.
pub fn compare(
    question: &ComparisonInput<'_>,
    reference: &ConvergedImage,
    clock: &dyn Clock,
) -> Vec<ImageRecord> {
    let ComparisonInput { scene, frame, .. } = *question;
    let is_asked = |info: &TracerInfo| question.tracers.contains(&info.name);
    let mut drawings = Vec::new();
    let mut add = |info: &TracerInfo, settings: &str, samples, draw| {
        let row = RowName { tracer: info.name.into(), settings: settings.into(), samples };
        drawings.push(Drawing { row, draw, made: None, seconds: Vec::new() });
    };
    for &samples in question.samples.iter().filter(|_| is_asked(&whitted::INFO)) {
        let plan = sampled_plan(scene, frame, samples);
        let draw = move || {
            let rendered = render_plan(scene, question.sampler, &plan);
            Ok((rendered.image, BTreeMap::from([("rays", rendered.counts.total())])))
        };
        add(&whitted::INFO, "", Some(samples), Box::new(draw) as Draw<'_>);
    }
    let size = Frame { resolution: frame.resolution, max_depth: frame.max_depth };
    for way in drawing_methods(is_asked) {
        let draw = move || (way.draw)(scene, size, question.structures).map(with_counts);
        add(way.info, way.settings, None, Box::new(draw));
    }
    let is_left = |round| round < question.rounds as usize;
    interleaved(0, drawings.len(), frame.seed, &scene.name, is_left, |Visit { row, .. }| {
        let Drawing { draw, made, seconds, .. } = &mut drawings[row];
        if !matches!(made, Some(Err(_))) {
            let (image, own) = timed(clock, draw);
            seconds.push(own);
            made.get_or_insert(image);
        }
    });
    let edges = edges(&reference.image);
    let finished = drawings.into_iter().filter_map(|Drawing { row, made, seconds, .. }| {
        let outcome = match made? {
            Err(refusal) => Outcome::Refused { refused: refusal.to_string(), what: refusal.what },
            Ok((image, counts)) => {
                let error = rmse(&image, &reference.image);
                Outcome::Made(ImageMeasurement {
                    seconds,
                    error,
                    edge_error: edge_rmse(&image, &reference.image, &edges),
                    is_below_reference: reference.hides(error),
                    counts: counts.into_iter().map(|(kind, n)| (kind.to_owned(), n)).collect(),
                    image: Some(image),
                    ..ImageMeasurement::default()
                })
            }
        };
        Some(ImageRecord { row, outcome })
    });
    let mut rows: Vec<ImageRecord> = finished.collect();
    judge(&mut rows, reference, frame.seed);
    rows
}

/// An image and what was counted.
type ImageWithCounts = (Image, BTreeMap<&'static str, u64>);

type Draw<'a> = Box<dyn Fn() -> Result<ImageWithCounts, Refusal> + 'a>;

/// An image that is drawn in every round, unless its tracer refuses the scene.
struct Drawing<'a> {
    row: RowName,
    draw: Draw<'a>,
    /// Of the first round.
    made: Option<Result<ImageWithCounts, Refusal>>,
    seconds: Vec<f64>,
}

fn with_counts(drawn: DrawnImage) -> ImageWithCounts {
    let FrustumWork { queries, found, tests, .. } = drawn.work;
    let mut counts =
        BTreeMap::from([("queries", queries), ("candidates", found), ("hull tests", tests)]);
    counts.extend(drawn.counts);
    (drawn.image, counts)
}

/// Finds the Pareto front, and what samples take for the errors of the others.
fn judge(rows: &mut [ImageRecord], reference: &ConvergedImage, seed: u64) {
    let cheapest = rows.iter().filter_map(ImageRecord::made);
    let cheapest = cheapest.min_by(|a, b| a.median().total_cmp(&b.median()));
    let cheapest = cheapest.map(|m| m.seconds.clone()).unwrap_or_default();
    let series: Vec<SampledImage> = rows
        .iter()
        .filter_map(|image| {
            let (samples, m) = (f64::from(image.row.samples?), image.made()?);
            Some(SampledImage { samples, error: m.error, seconds: m.median() })
        })
        .collect();
    let (mut places, mut placed) = (Vec::new(), Vec::new());
    for image in rows {
        let Outcome::Made(m) = &mut image.outcome else { continue };
        if image.row.samples.is_none() {
            m.by_samples = at_error(&series, m.error);
        }
        m.ratio = Series::of_pairs(&m.seconds, &cheapest, 1, |s, least| s / least).estimate(seed);
        let Some(time) = m.ratio else { continue };
        // errors below the reference's are indistinguishable from it
        let error = if m.is_below_reference { reference.own_error } else { m.error };
        places.push(FrontPoint { time, error });
        placed.push(m);
    }
    for (m, standing) in placed.into_iter().zip(standings(&places)) {
        m.standing = standing;
    }
}

/// Kinds of primitives that a comparison can leave out.
pub const KINDS: [&str; 5] = ["spheres", "cones", "polygons", "triangles", "patches"];

/// The scene without the primitives of these kinds of [`KINDS`]; ids move up.
pub fn without(mut scene: Scene, kinds: &[String]) -> Scene {
    let kind = |shape: Shape| match shape {
        Shape::Sphere(_) => KINDS[0],
        Shape::Cone(_) => KINDS[1],
        Shape::Polygon { .. } => KINDS[2],
        Shape::Triangle { .. } => KINDS[3],
        Shape::Patch { .. } => KINDS[4],
    };
    let stays: Vec<bool> =
        scene.primitives.iter().map(|p| kinds.iter().all(|k| k != kind(p.shape))).collect();
    fn keep<T>(list: &mut Vec<T>, stays: &[bool]) {
        let mut i = 0;
        list.retain(|_| {
            i += 1;
            stays[i - 1]
        });
    }
    keep(&mut scene.primitives, &stays);
    keep(&mut scene.velocities, &stays);
    keep(&mut scene.texcoords, &stays);
    if !kinds.is_empty() {
        scene.name = format!("{} without {}", scene.name, kinds.join(" and "));
    }
    scene
}

/// The converged image of a scene: two images of `samples` a pixel, in the current rayon pool.
/// The seeds are none that a measured image has.
pub fn converged(
    scene: &Scene,
    tracer: &dyn Tracer<f32>,
    frame: RenderSettings,
    samples: u32,
) -> ConvergedImage {
    let [first, second] = [0x5265_6665_7265_6e63, 0x6552_6665_7265_6e63].map(|other| {
        let frame = RenderSettings { seed: frame.seed ^ other, ..frame };
        render_plan(scene, tracer, &sampled_plan(scene, frame, samples)).image
    });
    ConvergedImage::of(&first, &second)
}

/// The plan of an image with that many eye rays per pixel; what has a lens, a shutter or a light
/// with an extent has one sample of each for every eye ray.
pub fn sampled_plan(scene: &Scene, frame: RenderSettings, samples: u32) -> EffectPlan {
    let samples = SampleWishes { supersamples: Some(samples), ..SampleWishes::ONE_OF_EACH };
    EffectPlan::of(scene, &RenderSettings { samples, ..frame })
}

#[cfg(test)]
mod tests {
    use super::record::AtError;
    use super::*;
    use crate::accuracy::record::VariantStanding;

    fn row(samples: Option<u32>, seconds: f64, error: f64) -> ImageRecord {
        let measured =
            ImageMeasurement { seconds: vec![seconds; 3], error, ..ImageMeasurement::default() };
        let row = RowName { tracer: "whitted".into(), settings: String::new(), samples };
        ImageRecord { row, outcome: Outcome::Made(measured) }
    }

    #[test]
    fn dominated_rows_are_not_on_the_front() {
        let mut rows = vec![
            row(Some(1), 1.0, 0.4),
            row(Some(4), 4.0, 0.2),
            row(Some(16), 16.0, 0.1),
            // planted: slower and worse than 4 samples
            row(None, 5.0, 0.21),
            // better than 16 samples for less
            row(None, 8.0, 0.05),
        ];
        let blank = Image { width: 0, height: 0, pixels: Vec::new() };
        judge(&mut rows, &ConvergedImage::of(&blank, &blank), 1);
        let made = |i: usize| rows[i].made().unwrap();
        let front = [0, 1, 2, 3, 4].map(|i| made(i).standing == VariantStanding::OnFront);
        assert_eq!(front, [true, true, false, false, true]);
        let by_samples = |i: usize| made(i).by_samples;
        assert!(matches!(by_samples(3), Some(AtError::Reached { seconds, .. }) if seconds < 4.0));
        assert_eq!(by_samples(4), Some(AtError::Never { samples: 16.0, seconds: 16.0 }));
        assert_eq!(by_samples(0), None);
    }

    #[test]
    fn kinds_are_left_out_with_all_that_belongs_to_them() {
        let mut scene = Scene::new("three");
        let m = scene.push_material(scene_loading::Material::default());
        scene.push_sphere(m, glam::DVec3::ZERO, 1.0);
        scene.push_triangle(m, [glam::DVec3::X, glam::DVec3::Y, glam::DVec3::Z]);
        scene.last_moves(glam::DVec3::X);
        scene.push_sphere(m, glam::DVec3::ONE, 1.0);
        let scene = without(scene, &["spheres".to_owned()]);
        assert_eq!(scene.primitives.len(), 1);
        assert_eq!(scene.velocity(0), glam::DVec3::X);
        assert_eq!(scene.name, "three without spheres");
    }
}
