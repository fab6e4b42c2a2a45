//! The cases of the catalogue, by group.

use accel_core::primitives::PrimitiveError;
use renderer::ray_offset::OffsetRule;

use super::cases::{
    cells, crossings, crowds, edge_on, geometry, intervals, motion, nested_planes, normals,
    polygons, ray, secondary, shadow_rays, shapes, symmetry,
};
use super::round::Round;
use measurement::plan::error::PlanError;
use statistics::random::Random;

/// Draws a round of at most so many rays.
pub type Draw<S> = fn(&mut Random, usize) -> Result<Round<S>, PrimitiveError>;

#[derive(Debug)]
pub struct Case {
    pub id: &'static str,
    pub summary: &'static str,
    /// The oracle that decides which answer is right.
    pub oracle: &'static str,
    /// Rounds in single precision.
    pub single: Draw<f32>,
    /// Rounds in double precision.
    pub double: Draw<f64>,
    /// Structures with settings of the case's own, as labels; all that are asked for when there are
    /// none.
    pub rows: &'static [&'static str],
    /// One ray of so many asked for is drawn: for scenes that make rays dear.
    pub share: usize,
}

impl Case {
    const fn one_in(self, share: usize) -> Self {
        Self { share, ..self }
    }

    const fn asked_of(self, rows: &'static [&'static str]) -> Self {
        Self { rows, ..self }
    }
}

#[derive(Debug)]
pub struct Group {
    pub name: &'static str,
    pub cases: &'static [Case],
}

/// A case: its id, who draws its rounds (of rays that leave surfaces, by the default rule), its
/// oracle, its difficulty.
macro_rules! case {
    ($id:literal, by default $draw:path, $oracle:literal, $summary:literal) => {
        case!(@ $id, |random, rays| $draw(random, rays, OffsetRule::default()), $oracle, $summary)
    };
    ($id:literal, $draw:path, $oracle:literal, $summary:literal) => {
        case!(@ $id, $draw, $oracle, $summary)
    };
    (@ $id:literal, $draw:expr, $oracle:literal, $summary:literal) => {
        Case {
            id: $id,
            summary: $summary,
            oracle: $oracle,
            single: $draw,
            double: $draw,
            rows: &[],
            share: 1,
        }
    };
}

/// All cases, in the order of records.
#[rustfmt::skip]
pub static GROUPS: &[Group] = &[
    Group { name: "ray", cases: &[
        case!("R1", ray::signs, "exact, mirrored", "directions of -1, -0, 0 and 1"),
        case!("R2", ray::tiny_components, "closed form",
            "a component of 1e-45 to 1e-7, a small far target"),
        case!("R3", ray::scaled_directions, "scaled", "directions times 2^-60 to 2^60"),
        case!("R4", ray::meaningless, "must miss", "zero, infinite or NaN rays, empty intervals"),
        case!("R5", ray::interval_ends, "exact", "t_min or t_max at the hit, and an ulp beside it"),
        case!("R6", ray::far_origins, "exact", "origins 10^7 scene sizes away"),
        case!("R7", ray::on_the_box, "exact, mirrored",
            "origins on faces, edges and corners of the scene's box"),
        case!("R8", intervals::intervals, "all tests",
            "intervals below 0, of one ulp, of one number; chains of hits: each once, in order"),
        case!("R9", ray::extreme_components, "exact",
            "one or two components that are denormal or huge, also in the plane of a flat scene"),
    ] },
    Group { name: "geometry", cases: &[
        case!("G1", geometry::closed_mesh, "exact", "rays at vertices and edges of a closed mesh"),
        case!("G1far", geometry::closed_mesh_far, "exact",
            "the same far from the origin of coordinates"),
        case!("G2", geometry::bumpy_sheet, "exact",
            "rays at vertices and edges within a bumpy sheet"),
        case!("G3", geometry::flat_sheet, "exact",
            "axis-parallel and diagonal rays through a lattice's vertices"),
        case!("G4", geometry::needle, "exact", "a triangle 10^8 times as long as wide"),
        case!("G5", geometry::degenerate, "exact, without them",
            "points and lines among triangles"),
        case!("G6", geometry::nearly_parallel, "construction",
            "rays nearly in the plane of a triangle, beside it or above it"),
        case!("G7", geometry::coplanar, "exact, renumbered",
            "triangles in the same place: the lowest id wins"),
        case!("G8", geometry::duplicates, "exact",
            "ten thousand times the same triangle").one_in(25),
        case!("G9", shapes::small_far_sphere, "closed form", "a small sphere seen from afar"),
        case!("G10", shapes::spheres_within, "closed form",
            "rays from within a sphere, just above a huge one, at a point, along a tangent"),
        case!("G11", shapes::cones, "twice the digits",
            "cones and cylinders: along the axis, through the apex, from within, without height"),
        case!("G11rim", shapes::rims, "twice the digits",
            "rays at the rim where two parts of a cone or cylinder meet: no gap"),
        case!("G12", polygons::alone, "own projection",
            "concave polygons, collinear and repeated vertices, slightly bent ones"),
        case!("G13", geometry::fine_detail_far_away, "exact",
            "details of 0.01 at coordinates of 10^6"),
        case!("G13scaled", geometry::tiny_or_huge, "exact, or refused",
            "coordinates of about 10^-25, 10^-8, 10^8 or 10^20: right, or a typed error"),
        case!("G14", edge_on::tilted_planes, "all tests, own bounds",
            "rays within a plane of triangles at any slant: the lowest id of equal parameters").one_in(2),
        case!("G15", crossings::crossings, "parity, all tests",
            "closed meshes crossed from outside, through corners and edges too: an even number of times"),
        case!("G16", edge_on::slivers, "exact, own bounds",
            "slivers, and rays half a degree off their plane: no hit beyond their bounds"),
        case!("K1", symmetry::scaled, "scaled",
            "the whole scene times 2^-27 to 2^28 (f64: 2^-200 to 2^200): identical bits"),
        case!("K1dense", symmetry::scaled_densely, "scaled",
            "the whole scene times every power of two that is served: identical bits").one_in(20),
        case!("P1", symmetry::turned, "mirrored, permuted",
            "the 48 mirrorings and orders of axes: identical bits, identical ids"),
    ] },
    Group { name: "grid", cases: &[
        case!("Gr1", cells::flat_scene, "exact",
            "a scene without extent along an axis, or of one tiny triangle"),
        case!("Gr2", cells::long_scene, "exact", "a scene 10^9 times as long as wide"),
        case!("Gr3", cells::specks, "exact",
            "a virtual grid of 2048^3 = 2^33 cells").one_in(10).asked_of(&["hashed-grid resolution=2048x2048x2048"]),
        case!("Gr4", cells::stadium, "exact", "small triangles on a floor 10^6 times as large"),
        case!("Gr5", cells::on_planes, "exact", "triangles within cell planes"),
        case!("Gr6", cells::hit_points, "exact", "an interval of a few ulps around the hit"),
        case!("Gr7", cells::scattered, "exact",
            "a constant hash function, a full table").one_in(2).asked_of(&[
                "hashed-grid load-factor=1", "hashed-grid hash=constant",
                "hashed-grid hash=constant load-factor=1",
            ]),
        case!("Gr8", cells::scattered, "exact", "mailboxes of one slot and of others").asked_of(&[
                "uniform-grid density=20 mailbox=hash mailbox-slots=1",
                "uniform-grid density=20 mailbox=array",
                "uniform-grid density=20 mailbox=primitive",
                "hashed-grid mailbox=hash mailbox-slots=1",
                "recursive-grid mailbox=hash mailbox-slots=1",
                "kd-tree mailbox=hash mailbox-slots=1", "octree mailbox=hash mailbox-slots=1",
            ]),
        case!("Gr10", cells::along_cell_planes, "exact",
            "rays within planes of the very cells, repeated triangles in one of them").one_in(2),
        case!("Gr12", nested_planes::nested_planes, "whole numbers",
            "rays 10^-45 to 10^-3 off the planes of nested cells, in blocks of unit cubes").one_in(5),
    ] },
    Group { name: "traversal", cases: &[
        case!("T2", cells::lattice_ties, "exact",
            "lattice origins, directions of whole numbers: ties of planes"),
        case!("T5", cells::within_planes, "exact, mirrored",
            "rays within cell planes, all axes and signs"),
        case!("T6", cells::spanning, "exact",
            "triangles across many cells, hit beyond the current one"),
        case!("T7", cells::any_and_closest, "all tests",
            "the closest hit is the least of all, any hit is one of them; intervals that begin at hits"),
    ] },
    Group { name: "secondary", cases: &[
        case!("S1", by default secondary::from_a_shape, "convexity",
            "rays that leave a convex shape of a size of 10^-8 to 10^8"),
        case!("S2", by default secondary::from_far_away, "convexity",
            "rays that leave a ball or a mesh up to 10^6 of its sizes from the origin"),
        case!("S3", by default secondary::between_planes, "closed form",
            "shadow rays through a gap of 10^-3, none may leak"),
        case!("S3ball", by default secondary::under_a_ball, "closed form",
            "shadow rays where a ball touches its plane"),
        case!("S4", by default secondary::to_a_light_on_a_surface, "closed form",
            "shadow rays to a light on a triangle"),
        case!("S7", by default secondary::shells, "counting, closed form",
            "shells a few ulps apart: none skipped, none met twice"),
    ] },
    Group { name: "reported", cases: &[
        case!("Q1", polygons::at_edges, "own projection",
            "polygons that share edges and vertices, closed bodies, both windings: no gap"),
        case!("Q2", polygons::nearly_in_plane, "own projection, own bounds",
            "rays 10^-1 to 10^-9 off a polygon's plane, and within it: hits lie where polygons are"),
        case!("Q2slivers", polygons::slivers, "own projection, own bounds",
            "polygons up to 10^4 times as long as wide, and rays near their plane"),
        case!("Q3", shapes::slender_cones, "twice the digits, own bounds",
            "cones and cylinders of 100:1 to 100,000:1, seen near an end and at their silhouette"),
        case!("Q3flat", shapes::flat_cones, "twice the digits, own bounds",
            "cones up to 100,000 times as wide as long, and rays along their surface"),
        case!("Q4", intervals::far_intervals, "exact, the told parameter asked again",
            "far origins: t_min below 0, t_max finite, and intervals that begin or end at the hit"),
        case!("Q6", polygons::tangled_alone, "own projection",
            "outlines that cross themselves, go round twice, have a hole by a bridge"),
        case!("Q7", motion::moving, "exact at each time",
            "rays with a time: opposite velocities, exposures of 2^-80 to 2^80, borders of segments, NaN"),
        case!("Q7segments", motion::moving, "exact at each time",
            "the same with several structures, each over a part of the exposure").asked_of(&[
                "wide-bvh time-segments=4", "obvhs-cwbvh time-segments=3",
                "uniform-grid time-segments=8", "kd-tree time-segments=5",
                "octree time-segments=2", "irregular-grid time-segments=4",
            ]),
        case!("Q8", crowds::copies, "exact",
            "copies of an object: mirrored, sheared, of sizes 1 to 10^-6, far away, in one place"),
        case!("Q9", shadow_rays::glass, "all tests",
            "shadow rays through transmissive primitives, equal to opaque ones, before and behind them"),
        case!("Q10", shadow_rays::lights, "all tests",
            "shadow rays to a light on a surface, at a vertex, in a plane, inside, or 10^9 away"),
        case!("Q10occluders", shadow_rays::lights, "all tests",
            "the same, asked of structures for shadow rays alone").one_in(2).asked_of(&[
                "light-buffer", "light-buffer query=batch", "light-buffer resolution=64",
                "light-buffer resolution=128 cut-off=none",
            ]),
        case!("Q11", motion::frames, "exact",
            "refits and updates between frames: few or all triangles moved, far away, shrunk to points").asked_of(&[
                "wide-bvh update=refit", "wide-bvh update=refit rebuild-at=1000000000",
                "obvhs-bvh2 update=refit", "obvhs-bvh2 update=refit rebuild-at=1000000000",
                "uniform-grid update=incremental", "hashed-grid update=incremental",
                "two-level-grid update=incremental", "instanced-bvh update=instances",
                "instanced-grid update=instances",
            ]),
        case!("Q12points", crowds::points, "must miss",
            "sets of points alone, several in one place"),
        case!("Q12equal", crowds::equal, "exact",
            "100,000 equal triangles: the lowest id, and a build that ends").one_in(100).asked_of(&[
                "wide-bvh", "kd-tree", "octree", "uniform-grid", "hashed-grid", "recursive-grid",
                "two-level-grid", "hug", "adaptive-grid", "irregular-grid", "kay-kajiya",
                "bounding-volumes", "obvhs-cwbvh",
            ]),
        case!("Q12fan", crowds::fan, "exact, all tests",
            "1,000 triangles around a vertex: rays at it, from it and just beside").one_in(10),
        case!("Q12denormal", crowds::denormal, "exact",
            "denormal coordinates among ordinary ones, of vertices and of origins"),
        case!("K3", crowds::threads, "exact, one thread",
            "13,000 triangles, built by one thread and by three: the same answers").one_in(100).asked_of(&[
                "wide-bvh", "wide-bvh preset=morton", "kd-tree", "octree", "uniform-grid",
                "two-level-grid", "recursive-grid", "hug", "adaptive-grid", "irregular-grid",
                "hashed-grid", "proximity-clouds", "kay-kajiya", "bounding-volumes",
                "obvhs-cwbvh",
            ]),
        case!("S8", normals::normals, "closed form",
            "normals of spheres, slender cones, and polygons whose outlines cross themselves"),
    ] },
];

pub type CatalogueEntry = (&'static Group, &'static Case);

pub fn all() -> impl Iterator<Item = CatalogueEntry> {
    GROUPS.iter().flat_map(|g| g.cases.iter().map(move |c| (g, c)))
}

/// The cases and groups of these names; all when there are none.
pub fn select(names: &[String]) -> Result<Vec<CatalogueEntry>, PlanError> {
    let is_named = |name: &str, (group, case): &CatalogueEntry| {
        name.eq_ignore_ascii_case(group.name) || name.eq_ignore_ascii_case(case.id)
    };
    if let Some(name) = names.iter().find(|name| !all().any(|listed| is_named(name, &listed))) {
        return Err(unknown(name));
    }
    let is_wanted = |listed: &CatalogueEntry| {
        names.is_empty() || names.iter().any(|name| is_named(name, listed))
    };
    Ok(all().filter(is_wanted).collect())
}

pub fn find(id: &str) -> Result<CatalogueEntry, PlanError> {
    all().find(|(_, case)| case.id.eq_ignore_ascii_case(id)).ok_or_else(|| unknown(id))
}

fn unknown(name: &str) -> PlanError {
    PlanError::unknown("case", name, GROUPS.iter().map(|g| g.name).chain(all().map(|(_, c)| c.id)))
}
