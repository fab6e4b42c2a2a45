//! Scenes that are awkward for the cells of grids and trees.

use accel_core::Vector;
use accel_core::historical::bounds_rule::{BoundsOf, BoundsRule};
use accel_core::primitives::PrimitiveError;
use accel_core::registry::Buildable;
use glam::{DVec3, dvec3};

use super::{
    LATTICE, lattice_point, lattice_round, lattice_soup, nested_planes, point_within,
    sign_direction, soup_round, toward,
};
use crate::case;
use crate::verify::draw::{one_of, point, single, unit};
use crate::verify::meshes::{sheet, soup};
use crate::verify::model::{Corners, Model};
use crate::verify::registry::{Case, Group};
use crate::verify::round::{OracleAnswer, Round};
use statistics::random::Random;

pub static GROUP: Group = Group {
    name: "grid",
    cases: &[GR1, GR2, GR3, GR4, GR5, GR6, GR7, GR8, GR10, nested_planes::GR12],
};

const GR1: Case = case!(
    "Gr1",
    "exact",
    flat_scene,
    "a scene without extent along an axis, or of one tiny triangle"
);
const GR2: Case = case!("Gr2", "exact", long_scene, "a scene 10^9 times as long as wide");
const GR3: Case = case!(
    "Gr3",
    "exact",
    specks,
    "a virtual grid of 2048^3 = 2^33 cells",
    10,
    &["hashed-grid resolution=2048x2048x2048"]
);
const GR4: Case = case!("Gr4", "exact", stadium, "small triangles on a floor 10^6 times as large");
const GR5: Case = case!("Gr5", "exact", on_planes, "triangles within cell planes");
const GR6: Case = case!("Gr6", "exact", hit_points, "an interval of a few ulps around the hit");
const GR7: Case = case!(
    "Gr7",
    "exact",
    scattered,
    "a constant hash function, a full table",
    2,
    &[
        "hashed-grid load-factor=1",
        "hashed-grid hash=constant",
        "hashed-grid hash=constant load-factor=1"
    ]
);
const GR8: Case = case!(
    "Gr8",
    "exact",
    scattered,
    "mailboxes of one slot and of others",
    1,
    &[
        "uniform-grid density=20 mailbox=hash mailbox-slots=1",
        "uniform-grid density=20 mailbox=array",
        "uniform-grid density=20 mailbox=primitive",
        "hashed-grid mailbox=hash mailbox-slots=1",
        "recursive-grid mailbox=hash mailbox-slots=1",
        "kd-tree mailbox=hash mailbox-slots=1",
        "octree mailbox=hash mailbox-slots=1"
    ]
);
const GR10: Case = case!(
    "Gr10",
    "exact",
    along_cell_planes,
    "rays within planes of the very cells, repeated triangles in one of them",
    2,
    &[]
);

fn flat_scene<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let triangles = match random.below(3) {
        0 => vec![
            [dvec3(1.0, 1.0, 1.0), dvec3(1.0 + 1e-5, 1.0, 1.0), dvec3(1.0, 1.0 + 1e-5, 1.0)]
                .map(single),
        ],
        _ => soup(random, 300, 0.2).iter().map(|t| t.map(|p| p.with_y(0.0))).collect::<Vec<_>>(),
    };
    soup_round(random, rays, &triangles, |random| {
        let target = point_within(random, &triangles);
        toward(random, target, 1.0)
    })
}

fn long_scene<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let stretched = |p: DVec3| single(p * dvec3(1e9, 1.0, 1.0));
    let triangles: Vec<Corners> = soup(random, 200, 0.4).iter().map(|t| t.map(stretched)).collect();
    soup_round(random, rays, &triangles, |random| {
        let target = point_within(random, &triangles);
        let down = one_of(random, &[1.0, -1.0]);
        (single(target.with_z(-down * 3.0)), dvec3(0.0, 0.0, down))
    })
}

fn stadium<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let place = |t: &Corners| t.map(|p| single(p * 0.05 + dvec3(0.0, 0.0, 0.1)));
    let mut triangles: Vec<Corners> = soup(random, 1000, 0.2).iter().map(place).collect();
    let floor = |t: &Corners| t.map(|p| (p - dvec3(0.5, 0.5, 0.0)) * 1e4);
    triangles.extend(sheet(1, |_, _| 0.0).iter().map(floor));
    soup_round(random, rays, &triangles, |random| {
        let target = point(random) * 0.06 + dvec3(0.0, 0.0, 0.1);
        let distance = one_of(random, &[0.1, 1.0, 30.0]);
        let (origin, along) = toward(random, target, distance);
        (origin.with_z(origin.z.abs() + 0.2), along)
    })
}

/// Sheets in planes of the lattice, which divides as cells do.
fn on_planes<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let mut triangles = lattice_soup(random, 10);
    for _ in 0..40 {
        let axis = random.below(3);
        let level = random.below(LATTICE as usize + 1) as f64;
        let [mut a, mut b, mut c] = [0; 3].map(|_| lattice_point(random).to_array());
        for p in [&mut a, &mut b, &mut c] {
            p.iter_mut().skip(axis).take(1).for_each(|x| *x = level);
        }
        triangles.push([a, b, c].map(DVec3::from_array));
    }
    lattice_round(random, rays, &triangles, |random| {
        let d = sign_direction(random);
        (lattice_point(random) - d * random.below(20) as f64, d)
    })
}

fn hit_points<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let triangles = lattice_soup(random, 60);
    let mut round: Round<S> = lattice_round(random, rays, &triangles, |random| {
        let d = sign_direction(random);
        let d = d * (1.0 + 3.0 * f64::from(u8::from(unit(random) < 0.5)));
        (lattice_point(random) - d * random.below(6) as f64, d)
    })?;
    for (ray, expected) in round.rays.iter_mut().zip(&round.expected) {
        if let OracleAnswer::Hit { t: [low, high], .. } = expected {
            ray.t_min = S::from_f64(*low).next_down();
            ray.t_max = S::from_f64(*high).next_up();
        }
    }
    Ok(round)
}

/// Triangles from tiny to large.
fn scattered<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let mut triangles = soup(random, 80, 0.02);
    triangles.extend(soup(random, 80, 0.2));
    triangles.extend(soup(random, 4, 0.6));
    soup_round(random, rays, &triangles, |random| {
        let target = point_within(random, &triangles);
        toward(random, target, 1.5)
    })
}

/// Triangles of a few cells of a very fine grid.
fn specks<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let triangles = soup(random, 150, 0.006);
    soup_round(random, rays, &triangles, |random| {
        let target = point_within(random, &triangles);
        toward(random, target, 1.5)
    })
}

/// Rays within planes that divide the scene's padded box into 2 to 64 parts, computed as grids
/// compute them: the planes of the cells themselves, of children that share them with their parents
/// as well. A thousand equal triangles in a corner make nested structures divide to their limit.
fn along_cell_planes<S: Buildable>(
    random: &mut Random,
    rays: usize,
) -> Result<Round<S>, PrimitiveError> {
    let mut triangles = soup(random, 150, 0.3);
    let same: Corners = one_of(random, &triangles);
    triangles.extend(std::iter::repeat_n(same, 1000));
    let model = Model::<S>::triangles(&triangles)?;
    let Model::Triangles(set) = &model else { return Ok(Round::new(model)) };
    let Ok(boxes) = BoundsOf::new(set, BoundsRule::Padded) else { return Ok(Round::new(model)) };
    let (low, size) = (boxes.scene().min.to_array(), boxes.scene().size().to_array());
    soup_round(random, rays, &triangles, |random| {
        let mut origin = point_within(random, &triangles).to_array();
        let axis = random.below(3);
        for k in (0..3).filter(|k| *k != axis) {
            let n = one_of(random, &[2, 3, 4, 5, 6, 8, 11, 16, 22, 32, 64]);
            let plane = S::from_i32(random.below(n + 1) as i32);
            let cell = size[k] / S::from_i32(n as i32);
            if random.below(3) > 0 {
                origin[k] = (low[k] + plane * cell).to_f64();
            }
        }
        let mut along = [0.0; 3];
        along[axis] = one_of(random, &[1.0, -1.0]);
        origin[axis] = -3.0 * along[axis];
        (DVec3::from_array(origin), DVec3::from_array(along))
    })
}
