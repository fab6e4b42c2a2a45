//! Intel's Embree 3 as a second reference: what hand-written vector code reaches with one ray a
//! call. Only with the cargo feature `embree`; links the shared library of Debian's
//! `libembree-dev`.
//!
//! Paper: I. Wald, S. Woop, C. Benthin, G. Johnson, M. Ernst, "Embree: A Kernel Framework for
//! Efficient CPU Ray Tracing", ACM TOG 33(4), 2014.
//!
//! Two ways to use it. With `primitives=native` (the default) it tests triangles itself: the
//! ceiling. Its test is not ours: a ray along an edge may get the neighbour or nothing, a known defect
//! whose wrong hits are counted and shown. Sets of triangles in f32 are asked as its authors do
//! (`direct.rs`); of others, what it finds is tested again by the set. With `primitives=callbacks` it gets boxes alone and
//! every candidate goes to the sink: the answers are ours to the last bit. Primitives that are not
//! triangles, and those that move, always go the second way.
//!
//! But for that, rays and boxes are told to it as to obvhs (`obvhs/adapter.rs`): in units of the scene's
//! size, boxes padded. Its nodes cannot be looked at: shapes have no cells, and steps are those into
//! candidates.

mod callbacks;
mod direct;
mod ffi;
mod library;
mod query;
mod scene;

use crate::config;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::params::config::Settings;
use crate::params::{ParamSpec, Params};
use crate::primitives::{PrimSet, PrimitiveKind};
use crate::query::cells::{CellVisitor, NoCells};
use crate::query::kernel::ListBlocks;
use crate::query::sink::Sink;
use crate::structure::{
    BatchAnswers, Batches, BuildError, Structure, StructureInfo, StructureStats,
};
use crate::structures::obvhs::box_ray::RaySetup;
use crate::structures::obvhs::direct::is_served;
use crate::structures::obvhs::items::{Padding, boxes};
use library::{Input, Library};
use scene::Scene;

config! {
    /// How the scene is built.
    pub struct EmbreeConfig {
        /// build: Morton order, binned surface areas, or those with spatial splits
        quality: i32 = ParamSpec::choice("quality", "medium", &["low", "medium", "high"]) => |quality| match quality {
            "low" => ffi::QUALITY_LOW,
            "high" => ffi::QUALITY_HIGH,
            _ => ffi::QUALITY_MEDIUM,
        },
        /// native lets Embree test triangles at rest; callbacks tests all by our tests
        is_native: bool = ParamSpec::choice("primitives", "native", &["native", "callbacks"]) => |p| p == "native",
        /// threads that build
        threads: u64 = ParamSpec::integer("threads", "1", 1, 256),
    }
}

/// Registry line.
pub static INFO: StructureInfo = StructureInfo {
    name: "embree",
    summary: "Embree 3 of the system, one ray a call; its nodes are not seen",
    paper: "Wald, Woop, Benthin, Johnson, Ernst 2014; Embree 3.13",
    deviations: "library code; other sets than triangles in f32 are tested again by ours",
    params: EmbreeConfig::PARAMS,
    variants: &["", "quality=low", "primitives=callbacks"],
    also_tested: &["quality=high", "primitives=callbacks quality=low"],
    known_defect,
    sampled: false,
};

fn known_defect(params: &Params) -> Option<&'static str> {
    (params.text("primitives") == "native").then_some(
        "Embree's own triangle test: rays along edges may get the neighbour, or pass between",
    )
}

/// A scene of Embree over our primitives.
pub struct Embree<S: Scalar>(Scene<S>);

impl<S: Scalar> Structure<S> for Embree<S> {
    const DUPLICATES: bool = false;

    type Config = EmbreeConfig;

    fn build<P: PrimSet<S>>(
        prims: &P,
        settings: &Settings<EmbreeConfig>,
    ) -> Result<Self, BuildError> {
        let (structure, is_native) = (settings.structure(), settings.is_native);
        let (boxes, setup) = boxes(prims, structure, Padding::OfScene)?;
        let is_triangle =
            |id: &u32| is_native && prims.kind(*id) == PrimitiveKind::Triangle && !prims.moves(*id);
        let (triangle_ids, boxed_ids): (Vec<u32>, Vec<u32>) =
            (0..prims.len() as u32).partition(is_triangle);
        let is_direct = is_native && is_served::<S, P>(prims) && boxed_ids.is_empty();
        let (triangle_ids, glass_ids): (Vec<u32>, Vec<u32>) =
            triangle_ids.into_iter().partition(|&id| !is_direct || prims.is_opaque(id));
        let setup = if is_direct { RaySetup::AsShipped } else { setup };
        let (unit, mut corners) = (setup.unit(), Vec::with_capacity(3));
        let mut vertices = |&id: &u32| {
            corners.clear();
            prims.hull(id, &mut corners);
            // a triangle's hull is its three vertices, in order
            std::array::from_fn(|k| {
                let corner = corners.get(k).map_or(glam::DVec3::ZERO, |c| c.center);
                (corner * unit).as_vec3().to_array()
            })
        };
        let input = Input {
            triangles: triangle_ids.iter().map(&mut vertices).collect(),
            glass: glass_ids.iter().map(&mut vertices).collect(),
            boxes: boxed_ids.iter().map(|&id| &boxes[id as usize]).collect(),
            quality: settings.quality,
            // its faster box test loses boxes of almost parallel rays, which native accepts
            robust: !is_native,
            has_filter: !is_direct,
            threads: settings.threads,
        };
        let library =
            Library::build(&input).map_err(|message| BuildError::Library { structure, message })?;
        Ok(Self(Scene { library, setup, triangle_ids, boxed_ids, is_native, is_direct, glass_ids }))
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        query::traverse(&self.0, ray, sink);
    }

    #[inline(always)]
    fn batches<P: PrimSet<S>>(&self, prims: &P, _: Option<&ListBlocks<S>>) -> Batches {
        // a set under another test may be asked, too
        match self.0.is_direct && is_served::<S, P>(prims) {
            true => Batches::Library,
            false => Batches::RayByRay,
        }
    }

    #[inline(always)]
    fn answer_batch<P: PrimSet<S>>(
        &self,
        _: &P,
        _: Option<&ListBlocks<S>>,
        rays: &[Ray<S>],
        _: S,
        answers: BatchAnswers<'_, S>,
    ) {
        match answers {
            BatchAnswers::Closest(hits) => direct::closest_hits(&self.0, rays, hits),
            BatchAnswers::Occlusion(blocked) => direct::occlusions(&self.0, rays, blocked),
        }
    }

    fn stats(&self) -> StructureStats {
        let references =
            (self.0.triangle_ids.len() + self.0.glass_ids.len() + self.0.boxed_ids.len()) as u64;
        let bytes = self.0.library.bytes() + references * 4;
        StructureStats { references, bytes, ..StructureStats::default() }
    }

    fn cells(&self, _: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        Err(NoCells("Embree does not show its nodes"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::ray::Hit;
    use crate::primitives::PrimsRef;
    use crate::primitives::{TriangleSet, Watertight};
    use crate::query::tracer::{ShadowCount, ShadowRule};
    use crate::structures::find;
    use crate::structures::test_scenes::{Random, closest_hits, occlusions};

    /// The closest hit, and whether the ray is blocked.
    type Answer = (Hit<f32>, bool);

    fn soup(n: usize) -> TriangleSet<f32, Watertight> {
        soup_of(n, |id| id % 9 == 0)
    }

    fn soup_of(n: usize, is_transmissive: fn(u32) -> bool) -> TriangleSet<f32, Watertight> {
        let mut random = Random(5);
        let triangles = (0..n).map(|_| {
            let at = random.point([1.0; 3]);
            [[0.0; 3], [0.2; 3], [0.2; 3]].map(|s| (at + random.point(s)).as_vec3().to_array())
        });
        TriangleSet::new(triangles.collect(), is_transmissive).unwrap()
    }

    fn answers(set: &TriangleSet<f32>, name: &str, settings: &[(&str, &str)]) -> Vec<Answer> {
        let mut random = Random(6);
        let rays: Vec<_> = (0..3000)
            .map(|_| {
                let (a, b) = (random.point([1.0; 3]), random.point([1.0; 3]));
                Ray::<f32>::new((a * 3.0 - 1.0).as_vec3(), (b - a * 3.0 + 1.0).as_vec3())
            })
            .collect();
        let entry = find(name).unwrap();
        let params = entry.params(settings.iter().copied()).unwrap();
        let tracer = entry.build(PrimsRef::Watertight(set), &params).unwrap();
        assert!(name != "embree" || tracer.stats().bytes > 36 * set.len() as u64);
        closest_hits(&*tracer, &rays).into_iter().zip(occlusions(&*tracer, &rays)).collect()
    }

    /// How many answers are not those: another triangle, or its parameter by more than rounding.
    fn wrong(got: &[Answer], expected: &[Answer]) -> usize {
        let is_near = |a: &Hit<f32>, b: &Hit<f32>| (a.t - b.t).abs() <= 1e-4 * b.t.abs();
        let differs = |((a, a_blocked), (b, b_blocked)): &(&Answer, &Answer)| {
            a.id != b.id || a_blocked != b_blocked || a.is_hit() && !is_near(a, b)
        };
        got.iter().zip(expected).filter(differs).count()
    }

    #[test]
    fn native_triangles_differ_at_edges_at_most() {
        // some of glass, then none
        for is_transmissive in [|id| id % 9 == 0, |_| false] {
            let set = soup_of(2000, is_transmissive);
            let expected = answers(&set, "brute-force", &[]);
            assert!(expected.iter().filter(|(hit, _)| hit.is_hit()).count() > 500);
            assert!(expected.iter().filter(|(_, blocked)| *blocked).count() > 500);
            for quality in ["low", "medium", "high"] {
                let got = answers(&set, "embree", &[("quality", quality)]);
                assert!(wrong(&got, &expected) <= 3, "{quality}");
            }
            // planted fault: a set with one triangle in five less must be noticed
            let got = answers(&soup_of(1600, is_transmissive), "embree", &[]);
            assert!(wrong(&got, &expected) > 30);
        }
    }

    #[test]
    fn batches_are_the_library_s_and_counted_answers_the_same() {
        let (set, mut random) = (soup(2000), Random(7));
        let ray = |_| {
            let (a, b) = (random.point([1.0; 3]), random.point([1.0; 3]));
            Ray::<f32>::new((a * 3.0 - 1.0).as_vec3(), (b - a * 3.0 + 1.0).as_vec3())
        };
        let rays: Vec<_> = (0..2000).map(ray).collect();
        let entry = find("embree").unwrap();
        let tracer = entry.build(PrimsRef::Watertight(&set), &entry.params([]).unwrap()).unwrap();
        assert_eq!(tracer.batches(), Batches::Library);
        let timed: Vec<_> =
            closest_hits(&*tracer, &rays).into_iter().zip(occlusions(&*tracer, &rays)).collect();
        let mut hits = vec![Hit::NONE; rays.len()];
        let mut blocked = vec![ShadowCount { blocked: false, glass: 0 }; rays.len()];
        tracer.count_closest_hits(&rays, &mut hits);
        tracer.count_occlusions(&rays, ShadowRule::OpaqueBlocks, &mut blocked);
        let counted: Vec<_> = hits.into_iter().zip(blocked.iter().map(|b| b.blocked)).collect();
        assert!(wrong(&counted, &timed) <= 3);
    }

    #[test]
    fn threads_change_no_answer() {
        let set = soup(20_000);
        let callbacks = ("primitives", "callbacks");
        let one = answers(&set, "embree", &[callbacks]);
        assert!(answers(&set, "embree", &[callbacks, ("threads", "2")]) == one);
    }
}
