//! Intel's Embree 3 as a second reference: what hand-written vector code reaches with one ray a
//! call. Only with the cargo feature `embree`; links the shared library of Debian's
//! `libembree-dev`.
//!
//! Paper: I. Wald, S. Woop, C. Benthin, G. Johnson, M. Ernst, "Embree: A Kernel Framework for
//! Efficient CPU Ray Tracing", ACM TOG 33(4), 2014.
//!
//! Two ways to use it. With `primitives=native` (the default) it tests triangles itself: the
//! ceiling. Its test is not ours, so the triangle that it finds is tested again by the set, which
//! makes `t` exact, but a ray along an edge may get the neighbour or nothing: a known defect,
//! whose wrong hits are counted and shown. With `primitives=callbacks` it gets boxes alone and
//! every candidate goes to the sink: the answers are ours to the last bit. Primitives that are not
//! triangles, and those that move, always go the second way.
//!
//! Rays and boxes are told to it as to obvhs (`obvhs_adapter.rs`): in units of the scene's size,
//! boxes padded. Its nodes cannot be looked at: shapes have no cells, and steps are those into
//! candidates.

mod callbacks;
mod ffi;
mod library;
mod query;
mod scene;

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::params::{ParamKind, ParamSpec, Params};
use crate::primitives::{PrimSet, PrimitiveKind};
use crate::query::sink::Sink;
use crate::structure::{BuildError, Shape, Structure, StructureInfo};
use crate::structures::obvhs::adapter::{Padding, boxes};
use library::{Input, Library};
use scene::Scene;

/// Registry line.
pub static INFO: StructureInfo = StructureInfo {
    name: "embree",
    summary: "Embree 3 of the system, one ray a call; its nodes are not seen",
    paper: "Wald, Woop, Benthin, Johnson, Ernst 2014; Embree 3.13",
    deviations: "library code; what its triangle test finds is tested again by ours",
    params: &[
        ParamSpec {
            name: "quality",
            summary: "build: Morton order, binned surface areas, or those with spatial splits",
            default: "medium",
            kind: ParamKind::Choice(&["low", "medium", "high"]),
        },
        ParamSpec {
            name: "primitives",
            summary: "native lets Embree test triangles at rest; callbacks tests all by our tests",
            default: "native",
            kind: ParamKind::Choice(&["native", "callbacks"]),
        },
        ParamSpec {
            name: "threads",
            summary: "threads that build",
            default: "1",
            kind: ParamKind::Integer { min: 1, max: 256 },
        },
    ],
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

    fn build<P: PrimSet<S>>(prims: &P, params: &Params) -> Result<Self, BuildError> {
        let structure = params.structure();
        let is_native = params.text("primitives") == "native";
        let (boxes, setup) = boxes(prims, structure, Padding::OfScene)?;
        let is_triangle =
            |id: &u32| is_native && prims.kind(*id) == PrimitiveKind::Triangle && !prims.moves(*id);
        let (triangle_ids, boxed_ids): (Vec<u32>, Vec<u32>) =
            (0..prims.len() as u32).partition(is_triangle);
        let (unit, mut corners) = (setup.unit(), Vec::with_capacity(3));
        let vertices = |&id: &u32| {
            corners.clear();
            prims.hull(id, &mut corners);
            // a triangle's hull is its three vertices, in order
            std::array::from_fn(|k| {
                let corner = corners.get(k).map_or(glam::DVec3::ZERO, |c| c.center);
                (corner * unit).as_vec3().to_array()
            })
        };
        let input = Input {
            triangles: triangle_ids.iter().map(vertices).collect(),
            boxes: boxed_ids.iter().map(|&id| &boxes[id as usize]).collect(),
            quality: match params.text("quality") {
                "low" => ffi::QUALITY_LOW,
                "high" => ffi::QUALITY_HIGH,
                _ => ffi::QUALITY_MEDIUM,
            },
            // its faster box test loses boxes of almost parallel rays, which native accepts
            robust: !is_native,
            threads: params.integer("threads"),
        };
        let library =
            Library::build(&input).map_err(|message| BuildError::Library { structure, message })?;
        Ok(Self(Scene { library, setup, triangle_ids, boxed_ids, is_native }))
    }

    #[inline(always)]
    fn walk<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        query::walk(&self.0, ray, sink);
    }

    fn shape(&self) -> Shape {
        let references = (self.0.triangle_ids.len() + self.0.boxed_ids.len()) as u64;
        let bytes = self.0.library.bytes() + references * 4;
        Shape { references, bytes, ..Shape::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::ray::Hit;
    use crate::primitives::PrimsRef;
    use crate::primitives::{TriangleSet, Watertight};
    use crate::structures::find;
    use crate::structures::test_scenes::{Random, closest_hits, occlusions};

    fn soup(n: usize) -> TriangleSet<f32, Watertight> {
        let mut random = Random(5);
        let triangles = (0..n).map(|_| {
            let at = random.point([1.0; 3]);
            [[0.0; 3], [0.2; 3], [0.2; 3]].map(|s| (at + random.point(s)).as_vec3().to_array())
        });
        TriangleSet::new(triangles.collect(), |id| id % 9 == 0).unwrap()
    }

    fn answers(
        set: &TriangleSet<f32>,
        name: &str,
        settings: &[(&str, &str)],
    ) -> Vec<(Hit<f32>, bool)> {
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
        assert!(name != "embree" || tracer.shape().bytes > 36 * set.len() as u64);
        closest_hits(&*tracer, &rays).into_iter().zip(occlusions(&*tracer, &rays)).collect()
    }

    #[test]
    fn native_triangles_differ_at_edges_at_most() {
        let set = soup(2000);
        let expected = answers(&set, "brute-force", &[]);
        assert!(expected.iter().filter(|(hit, _)| hit.is_hit()).count() > 500);
        for quality in ["low", "medium", "high"] {
            let got = answers(&set, "embree", &[("quality", quality)]);
            let wrong = got.iter().zip(&expected).filter(|(a, b)| a != b).count();
            assert!(wrong <= 3, "{quality}: {wrong}");
        }
        // planted fault: a set with one triangle less must be noticed
        let fewer = soup(1600);
        let got = answers(&fewer, "embree", &[]);
        assert!(got.iter().zip(&expected).filter(|(a, b)| a != b).count() > 30);
    }

    #[test]
    fn threads_change_no_answer() {
        let set = soup(20_000);
        let callbacks = ("primitives", "callbacks");
        let one = answers(&set, "embree", &[callbacks]);
        assert!(answers(&set, "embree", &[callbacks, ("threads", "2")]) == one);
    }
}
