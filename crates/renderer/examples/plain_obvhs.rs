//! obvhs without us, as its README and its examples use it, beside rows of ours: the same rays in
//! interleaved rounds of seeded random order. What is timed of it is a loop that knows of us the
//! triangles and the rays, and nothing else.
//!
//! `plain_obvhs SCENE [--size N] [--rounds N] [--seed N] [ROW...]`, a row as
//! `obvhs-cwbvh`; prints rays per second of `plain-cwbvh`, `plain-bvh2` and the
//! rows, by kind of ray, and the rows' over those of the plain program with the same tree: the
//! median over the rounds, the quartiles, and that of the fastest passes, which other load disturbs
//! least.

use std::error::Error;
use std::time::{Duration, Instant};

use accel_core::primitives::Primitives;
use accel_core::query::tracer::Tracer;
use accel_core::structures::find;
use accel_core::{Hit, Ray};
use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::{Ray as ObvhsRay, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use renderer::{Geometry, RayBatches, RayKind, RaySettings, ShadowRays, generate_rays};
use scene_loading::SceneCatalogue;

/// The answer of the plain program.
#[derive(Clone, Copy)]
struct Answer {
    t: f32,
    id: u32,
}

fn own_ray(ray: &Ray<f32>) -> ObvhsRay {
    ObvhsRay::new(ray.origin.into(), ray.direction.into(), ray.t_min, ray.t_max)
}

/// The plain program over one of obvhs's trees.
macro_rules! plain {
    ($name:ident, $tree:ty, $build:path) => {
        struct $name {
            tree: $tree,
            triangles: Vec<RtTriangle>,
            /// Which of them are of glass; empty where none is.
            glass: Vec<bool>,
        }

        impl $name {
            #[inline(never)]
            fn build(triangles: &[[[f32; 3]; 3]], is_glass: &[bool]) -> Self {
                let triangles: Vec<Triangle> = triangles
                    .iter()
                    .map(|t| t.map(Vec3A::from_array))
                    .map(|[v0, v1, v2]| Triangle { v0, v1, v2 })
                    .collect();
                let time = &mut Duration::default();
                let tree = $build(&triangles, BvhBuildParams::medium_build(), time);
                let in_order = tree.primitive_indices.iter();
                let in_order = in_order.map(|i| *i as usize);
                let has_glass = is_glass.contains(&true);
                let glass = in_order.clone().filter(|_| has_glass);
                let glass = glass.map(|i| is_glass[i]).collect();
                let triangles = in_order.map(|i| (&triangles[i]).into()).collect();
                Self { tree, triangles, glass }
            }

            #[inline(never)]
            fn closest(&self, rays: &[Ray<f32>], answers: &mut [Answer]) {
                for (ray, answer) in rays.iter().zip(answers) {
                    let mut hit = RayHit::none();
                    let test = |ray: &ObvhsRay, i: usize| self.triangles[i].intersect(ray);
                    *answer = if self.tree.ray_traverse(own_ray(ray), &mut hit, test) {
                        let id = self.tree.primitive_indices[hit.primitive_id as usize];
                        Answer { t: hit.t, id }
                    } else {
                        Answer { t: f32::INFINITY, id: u32::MAX }
                    };
                }
            }

            #[inline(never)]
            fn blocked(&self, rays: &[Ray<f32>], blocked: &mut [bool]) {
                let test = |ray: &ObvhsRay, i: usize| self.triangles[i].intersect(ray);
                for (ray, blocked) in rays.iter().zip(blocked) {
                    *blocked = !if self.glass.is_empty() {
                        self.tree.ray_traverse_miss(own_ray(ray), test)
                    } else {
                        self.tree.ray_traverse_miss(own_ray(ray), |ray, i| match test(ray, i) {
                            t if t < ray.tmax && self.glass[i] => f32::INFINITY,
                            t => t,
                        })
                    };
                }
            }
        }

        impl Timed for $name {
            fn closest(&mut self, rays: &[Ray<f32>], hits: &mut [Hit<f32>], own: &mut [Answer]) {
                $name::closest(self, rays, own);
                let _ = hits;
            }

            fn blocked(&mut self, rays: &[Ray<f32>], blocked: &mut [bool]) {
                $name::blocked(self, rays, blocked);
            }
        }
    };
}

/// What is timed: the plain program, or a row of ours.
trait Timed {
    fn closest(&mut self, rays: &[Ray<f32>], hits: &mut [Hit<f32>], own: &mut [Answer]);
    fn blocked(&mut self, rays: &[Ray<f32>], blocked: &mut [bool]);
}

plain!(PlainCwBvh, CwBvh, build_cwbvh_from_tris);
plain!(PlainBvh2, Bvh2, build_bvh2_from_tris);

struct Ours<'a>(Box<dyn Tracer<f32> + 'a>);

impl Timed for Ours<'_> {
    fn closest(&mut self, rays: &[Ray<f32>], hits: &mut [Hit<f32>], _: &mut [Answer]) {
        self.0.closest_hits(rays, hits);
    }

    fn blocked(&mut self, rays: &[Ray<f32>], blocked: &mut [bool]) {
        self.0.occlusions(rays, blocked);
    }
}

const KINDS: [RayKind; 3] = [RayKind::Primary, RayKind::Diffuse, RayKind::Shadow];

/// Room for answers.
struct Buffers {
    hits: Vec<Hit<f32>>,
    own: Vec<Answer>,
    blocked: Vec<bool>,
}

/// Seconds for all rays of a kind.
fn seconds(
    timed: &mut dyn Timed,
    rays: &RayBatches<f32>,
    kind: RayKind,
    buffers: &mut Buffers,
) -> f64 {
    let rays = rays.rays(kind);
    let start = Instant::now();
    if kind.is_occlusion() {
        timed.blocked(rays, &mut buffers.blocked[..rays.len()]);
    } else {
        timed.closest(rays, &mut buffers.hits[..rays.len()], &mut buffers.own[..rays.len()]);
    }
    start.elapsed().as_secs_f64()
}

/// The value below which that part of the values lies.
fn quantile(values: &mut [f64], part: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * part).round() as usize]
}

struct Arguments {
    scene: String,
    size: u32,
    rounds: usize,
    seed: u64,
    rows: Vec<String>,
}

impl Arguments {
    fn read() -> Result<Self, Box<dyn Error>> {
        let mut this =
            Self { scene: "hare".into(), size: 256, rounds: 15, seed: 1, rows: Vec::new() };
        let (mut words, mut named) = (std::env::args().skip(1), false);
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or(format!("{word} wants a value"));
            match word.as_str() {
                "--size" => this.size = value()?.parse()?,
                "--rounds" => this.rounds = value()?.parse::<usize>()?.max(1),
                "--seed" => this.seed = value()?.parse()?,
                _ if !named => (this.scene, named) = (word, true),
                _ => this.rows.push(word),
            }
        }
        if this.rows.is_empty() {
            this.rows = ["obvhs-cwbvh", "obvhs-bvh2"].map(str::to_owned).into();
        }
        Ok(this)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::read()?;
    let names = [arguments.scene.clone()];
    let scene = SceneCatalogue::embedded()?.resolve(&names)?.remove(0).load()?.scene;
    let geometry = Geometry::<f32>::of(&scene)?;
    let Geometry::Triangles(set) = &geometry else { return Err("not of triangles alone".into()) };
    let is_glass: Vec<bool> = (0..set.len() as u32).map(|id| !set.is_opaque(id)).collect();
    let mut timed: Vec<(String, Box<dyn Timed + '_>)> = vec![
        ("plain-cwbvh".into(), Box::new(PlainCwBvh::build(set.triangles(), &is_glass))),
        ("plain-bvh2".into(), Box::new(PlainBvh2::build(set.triangles(), &is_glass))),
    ];
    for row in &arguments.rows {
        let mut words = row.split(':');
        let entry = find(words.next().unwrap_or_default()).ok_or(format!("no row {row}"))?;
        let settings = words.filter_map(|word| word.split_once('='));
        let tracer = entry.build(geometry.prims(), &entry.params(settings)?)?;
        timed.push((row.clone(), Box::new(Ours(tracer))));
    }
    // right answers, so that all are asked the same rays
    let entry = find("obvhs-bvh2").ok_or("no such structure")?;
    let settings = RaySettings {
        resolution: [arguments.size; 2],
        max_depth: 1,
        shadows: ShadowRays::FirstLight,
        seed: arguments.seed,
        ..RaySettings::default()
    };
    let tracer = entry.build(geometry.prims(), &entry.params([])?)?;
    let rays = generate_rays(&scene, &*tracer, &settings);
    drop(tracer);
    let most = KINDS.map(|kind| rays.rays(kind).len()).into_iter().max().unwrap_or_default();
    let mut buffers = Buffers {
        hits: vec![Hit::NONE; most],
        own: vec![Answer { t: 0.0, id: 0 }; most],
        blocked: vec![false; most],
    };
    let mut random = Xoshiro256PlusPlus::seed_from_u64(arguments.seed);
    let mut all = vec![vec![[0.0; KINDS.len()]; arguments.rounds]; timed.len()];
    // the first round warms up, and is measured again
    for round in std::iter::once(0).chain(0..arguments.rounds) {
        for (k, kind) in KINDS.into_iter().enumerate() {
            let mut order: Vec<usize> = (0..timed.len()).collect();
            for i in (1..order.len()).rev() {
                order.swap(i, (random.next_u64() % (i as u64 + 1)) as usize);
            }
            for row in order {
                all[row][round][k] = seconds(&mut *timed[row].1, &rays, kind, &mut buffers);
            }
        }
    }
    std::hint::black_box(buffers.own.iter().map(|a| a.t + a.id as f32).sum::<f32>());
    for (k, kind) in KINDS.into_iter().enumerate() {
        let n = rays.rays(kind).len() as f64;
        for (row, (label, _)) in timed.iter().enumerate() {
            let plain = usize::from(label.contains("bvh2"));
            let rounds = 0..arguments.rounds;
            let mut rates: Vec<_> = rounds.clone().map(|r| n / all[row][r][k] / 1e6).collect();
            let mut ratios: Vec<_> = rounds.map(|r| all[plain][r][k] / all[row][r][k]).collect();
            let least = |row: usize| {
                all[row].iter().map(|seconds| seconds[k]).fold(f64::INFINITY, f64::min)
            };
            println!(
                "{:<12} {:<8} {label:<44} {:7.3} Mrays/s  {:.3} [{:.3}, {:.3}] fastest {:.3}",
                scene.name,
                kind.name(),
                quantile(&mut rates, 0.5),
                quantile(&mut ratios, 0.5),
                quantile(&mut ratios, 0.25),
                quantile(&mut ratios, 0.75),
                least(plain) / least(row)
            );
        }
    }
    Ok(())
}
