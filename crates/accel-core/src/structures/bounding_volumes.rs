//! Bounding volumes without a hierarchy: a filter before the test of primitives.
//!
//! Papers: T. Whitted, "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980
//! (spheres around objects); S. M. Rubin, T. Whitted, "A 3-Dimensional Representation for Fast
//! Rendering of Complex Scenes", SIGGRAPH 1980 (boxes); H. Weghorst, G. Hooper, D. P. Greenberg,
//! "Improved Computational Methods for Ray Tracing", ACM TOG 3(1), 1984 (which volume: its cost
//! against the space it leaves void); T. L. Kay, J. T. Kajiya, "Ray Tracing Complex Scenes",
//! SIGGRAPH 1986 (slabs).
//!
//! A ray tests every volume in turn, so it takes time in proportion to their number; what a
//! volume saves is the test of primitives that the ray passes at a distance, or that lie behind
//! what it has hit already.
//!
//! Deviations: boxes are axis-parallel in world space; volumes are padded by ulps; the kind of
//! volume is one for the whole scene, not the cheapest for each object; "objects" are primitives,
//! or groups of neighbours cut at medians of their centres, and never objects of a modeller.
//!
//! Counters: a volume met is an elementary step, a volume missed only a traversal step. So N_TS
//! is the number of volumes tested, N_ETS of those met, and N_EETS is 0, as none is empty.

mod ball;
pub(super) mod slabs;
pub(super) mod volume;

use self::ball::Ball;
use self::slabs::Slabs;
use self::volume::{BOX_TEST, ComparedBox, Volume, box_test};
use crate::geometry::aabb::Aabb;
use crate::geometry::box_test::BoxTest;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::historical::bounds_rule::{BoundsOf, BoundsRule};
use crate::memory::CountedItem;
use crate::memory::Limits;
use crate::parallel::collect;
use crate::params::config::{Config, Settings};
use crate::params::{ParamSpec, Params};
use crate::primitives::Primitives;
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::kernel;
use crate::query::sink::Sink;
use crate::structure::{BuildError, Structure, StructureInfo, StructureStats, bounds_of, too_many};
use crate::tree::median_cut::Centres;

/// Number of plane directions of slabs.
pub(super) const DIRECTIONS: ParamSpec = ParamSpec::choice("directions", "7", &["3", "4", "7"])
    .about("plane directions of slabs: 3 axes, 4 diagonals of the cube, or all 7");

pub(super) const MAX_CELLS: ParamSpec = ParamSpec::integer("max-cells", "67108864", 1, 1 << 31)
    .about("upper limit for the number of volumes");

pub static INFO: StructureInfo = StructureInfo {
    paper: "Whitted 1980; Rubin, Whitted 1980; Weghorst, Hooper, Greenberg 1984; \
            Kay, Kajiya 1986 (slabs)",
    deviations: "one kind of volume a scene; padded; groups cut at medians of centres",
    params: &[
        kernel::PARAM,
        ParamSpec::choice("volume", "box", &["box", "sphere", "slabs"])
            .about("kind of volume; slabs have the directions given"),
        DIRECTIONS,
        BOX_TEST,
        ParamSpec::integer("group", "1", 1, 1 << 20)
            .about("primitives in a volume: 1 for one around each, more for neighbours"),
        MAX_CELLS,
    ],
    variants: &["volume=sphere", "volume=slabs group=16"],
    also_tested: &[
        "kernel=block group=8",
        "",
        "volume=slabs directions=3",
        "volume=slabs directions=4 group=8",
    ],
    known_defect,
    sampled: true,
    ..StructureInfo::new(
        "bounding-volumes",
        "boxes, spheres or slabs around primitives or groups, each tested in turn",
    )
};

fn known_defect(params: &Params) -> Option<&'static str> {
    let is_compared = params.text("volume") == "box" && box_test(params).is_some();
    is_compared.then_some("boxes are tight: hits at their faces are lost to rounding")
}

/// Kind of a volume.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Box,
    Compared(BoxTest),
    Sphere,
    /// With so many directions.
    Slabs(u64),
}

/// Kinds of volumes, as configured.
#[derive(Debug, Clone)]
pub struct VolumesConfig {
    kind: Kind,
    group: usize,
    max_cells: u64,
}

impl Config for VolumesConfig {
    fn of(params: &Params) -> Self {
        let kind = match params.text("volume") {
            "box" => box_test(params).map_or(Kind::Box, Kind::Compared),
            "sphere" => Kind::Sphere,
            _ => Kind::Slabs(params.integer(DIRECTIONS.name)),
        };
        let [group, max_cells] = ["group", "max-cells"].map(|name| params.integer(name));
        Self { kind, group: group as usize, max_cells }
    }
}

/// A list of volumes.
pub struct BoundingVolumes<S: Scalar> {
    volumes: Volumes<S>,
    ids: Vec<u32>,
    /// Primitives in a volume; the last one may hold fewer.
    group: usize,
}

/// What is said of volumes of any kind.
macro_rules! of_any {
    ($volumes:expr, $all:ident => $said:expr) => {
        match $volumes {
            Volumes::Boxes($all) => $said,
            Volumes::Compared(_, $all) => $said,
            Volumes::Spheres($all) => $said,
            Volumes::Slabs3($all) => $said,
            Volumes::Slabs4($all) => $said,
            Volumes::Slabs7($all) => $said,
        }
    };
}

/// The volumes, one for each group.
enum Volumes<S: Scalar> {
    Boxes(Vec<Aabb<S>>),
    Compared(BoxTest, Vec<ComparedBox<S>>),
    Spheres(Vec<Ball>),
    Slabs3(Vec<Slabs<S, 3>>),
    Slabs4(Vec<Slabs<S, 4>>),
    Slabs7(Vec<Slabs<S, 7>>),
}

impl<S: Scalar> Volumes<S> {
    fn new(groups: &Groups<S>, kind: Kind) -> Self {
        match kind {
            Kind::Box => Self::Boxes(groups.volumes()),
            Kind::Compared(test) => Self::Compared(test, groups.volumes()),
            Kind::Sphere => Self::Spheres(groups.volumes()),
            Kind::Slabs(3) => Self::Slabs3(groups.volumes()),
            Kind::Slabs(4) => Self::Slabs4(groups.volumes()),
            Kind::Slabs(_) => Self::Slabs7(groups.volumes()),
        }
    }

    /// A box around one of them.
    fn bounds(&self, number: usize) -> Aabb<f64> {
        of_any!(self, all => Volume::<S>::bounds(&all[number]))
    }

    fn bytes(&self) -> usize {
        of_any!(self, all => size_of_val(all.as_slice()))
    }
}

/// Groups of ids, and where they lie.
struct Groups<'a, S: Scalar> {
    ids: &'a [u32],
    size: usize,
    boxes: BoundsOf<'a, S>,
}

impl<S: Scalar> Groups<'_, S> {
    fn volumes<V: Volume<S>>(&self) -> Vec<V> {
        collect(self.ids.len().div_ceil(self.size), |group| {
            let end = self.ids.len().min((group + 1) * self.size);
            V::around(&self.ids[group * self.size..end], &self.boxes)
        })
    }
}

impl<S: Scalar> Structure<S> for BoundingVolumes<S> {
    const HAS_LISTS: bool = true;
    const DUPLICATES: bool = false;

    type Config = VolumesConfig;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<VolumesConfig>,
    ) -> Result<Self, BuildError> {
        let boxes = bounds_of(prims, BoundsRule::Padded, settings.structure())?;
        let group = settings.group;
        check_cells(prims.len().div_ceil(group), settings.limits(), settings.max_cells)?;
        let mut ids: Vec<u32> = (0..prims.len() as u32).collect();
        if group > 1 {
            Centres::of(prims).group(&mut ids, group);
        }
        let volumes = Volumes::new(&Groups { ids: &ids, size: group, boxes }, settings.kind);
        Ok(Self { volumes, ids, group })
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        match &self.volumes {
            Volumes::Boxes(volumes) => self.filter(volumes, ray, sink),
            // a loop of its own for each, where the test is compiled in
            Volumes::Compared(BoxTest::Plain, volumes) => {
                self.filter_with(volumes, (BoxTest::Plain, *ray), ray, sink);
            }
            Volumes::Compared(BoxTest::Padded, volumes) => {
                self.filter_with(volumes, (BoxTest::Padded, *ray), ray, sink);
            }
            Volumes::Compared(BoxTest::Double, volumes) => {
                self.filter_with(volumes, (BoxTest::Double, *ray), ray, sink);
            }
            Volumes::Spheres(volumes) => self.filter(volumes, ray, sink),
            Volumes::Slabs3(volumes) => self.filter(volumes, ray, sink),
            Volumes::Slabs4(volumes) => self.filter(volumes, ray, sink),
            Volumes::Slabs7(volumes) => self.filter(volumes, ray, sink),
        }
    }

    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32])) {
        self.ids.chunks(self.group).for_each(each);
    }

    fn stats(&self) -> StructureStats {
        StructureStats {
            cells: self.ids.len().div_ceil(self.group) as u64,
            references: self.ids.len() as u64,
            bytes: (self.volumes.bytes() + size_of_val(self.ids.as_slice())) as u64,
            ..StructureStats::default()
        }
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        for (number, ids) in self.ids.chunks(self.group).enumerate() {
            each(Cell::elementary(self.volumes.bounds(number), 0, ids));
        }
        Ok(())
    }
}

impl<S: Scalar> BoundingVolumes<S> {
    /// Tests the primitives of every volume that the ray meets no later than its nearest hit.
    fn filter<V: Volume<S>, K: Sink<S>>(&self, volumes: &[V], ray: &Ray<S>, sink: &mut K) {
        self.filter_with(volumes, V::setup(ray), ray, sink);
    }

    #[inline(always)]
    fn filter_with<V: Volume<S>, K: Sink<S>>(
        &self,
        volumes: &[V],
        setup: V::RaySetup,
        ray: &Ray<S>,
        sink: &mut K,
    ) {
        for (volume, ids) in volumes.iter().zip(self.ids.chunks(self.group)) {
            if volume.entry(&setup, ray.t_min, sink.t_max()).is_none() {
                sink.inner_step();
                continue;
            }
            sink.elementary_step(false);
            if sink.test(ids).is_break() {
                return;
            }
        }
    }
}

/// Refuses more volumes than [`MAX_CELLS`] allows.
pub(super) fn check_cells(needed: usize, limits: Limits, max_cells: u64) -> Result<(), BuildError> {
    // six slabs of 8 bytes and what they hold
    const VOLUMES: CountedItem = CountedItem::cells("number of volumes", 64);
    if needed as u64 <= limits.most(&VOLUMES, max_cells) {
        Ok(())
    } else {
        Err(too_many(limits, &VOLUMES, max_cells, needed as u64))
    }
}
