//! Scenes that are awkward for the cells of grids and trees, and rays that are awkward to take through
//! them.

use accel_core::historical::bounds_rule::{BoundsOf, BoundsRule};

use super::*;

pub fn flat_scene<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let near = 1.0 + 1e-5;
    let triangles = match random.below(3) {
        0 => vec![[DVec3::ONE, dvec3(near, 1.0, 1.0), dvec3(1.0, near, 1.0)].map(single)],
        _ => soup(random, 300, 0.2).iter().map(|t| t.map(|p| p.with_y(0.0))).collect::<Vec<_>>(),
    };
    aimed_round(random, rays, &triangles, 1.0)
}

pub fn long_scene<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let stretched = |p: DVec3| single(p * dvec3(1e9, 1.0, 1.0));
    let triangles: Vec<Corners> = soup(random, 200, 0.4).iter().map(|t| t.map(stretched)).collect();
    exact_round(random, rays, &triangles, in_soup, |random| {
        let target = point_within(random, &triangles);
        let down = one_of(random, &[1.0, -1.0]);
        (single(target.with_z(-down * 3.0)), dvec3(0.0, 0.0, down))
    })
}

pub fn stadium<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let place = |t: &Corners| t.map(|p| single(p * 0.05 + dvec3(0.0, 0.0, 0.1)));
    let mut triangles: Vec<Corners> = soup(random, 1000, 0.2).iter().map(place).collect();
    let floor = |t: &Corners| t.map(|p| (p - dvec3(0.5, 0.5, 0.0)) * 1e4);
    triangles.extend(sheet(1, |_, _| 0.0).iter().map(floor));
    exact_round(random, rays, &triangles, in_soup, |random| {
        let target = point(random) * 0.06 + dvec3(0.0, 0.0, 0.1);
        let distance = one_of(random, &[0.1, 1.0, 30.0]);
        let (origin, along) = toward(random, target, distance);
        (origin.with_z(origin.z.abs() + 0.2), along)
    })
}

/// Sheets in planes of the lattice, which divides as cells do.
pub fn on_planes<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let mut triangles = lattice_soup(random, 10);
    for _ in 0..40 {
        let axis = random.below(3);
        let level = random.below(LATTICE as usize + 1) as f64;
        triangles.push([0; 3].map(|_| with(lattice_point(random), axis, level)));
    }
    exact_round(random, rays, &triangles, on_lattice, |random| {
        let d = sign_direction(random);
        (lattice_point(random) - d * random.below(20) as f64, d)
    })
}

pub fn hit_points<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = lattice_soup(random, 60);
    let mut round: Round<S> = exact_round(random, rays, &triangles, on_lattice, |random| {
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
pub fn scattered<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let mut triangles = soup(random, 80, 0.02);
    triangles.extend(soup(random, 80, 0.2));
    triangles.extend(soup(random, 4, 0.6));
    aimed_round(random, rays, &triangles, 1.5)
}

/// Triangles of a few cells of a very fine grid.
pub fn specks<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = soup(random, 150, 0.006);
    aimed_round(random, rays, &triangles, 1.5)
}

/// Rays within planes that divide the scene's padded box into 2 to 64 parts, computed as grids
/// compute them: the planes of the cells themselves, of children that share them with their parents
/// as well. A thousand equal triangles in a corner make nested structures divide to their limit.
pub fn along_cell_planes<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let mut triangles = soup(random, 150, 0.3);
    let same: Corners = one_of(random, &triangles);
    triangles.extend(std::iter::repeat_n(same, 1000));
    let model = model_of::<S>(&triangles)?;
    let Geometry::Triangles(set) = &model else { return Ok(Round::new(model)) };
    let Ok(boxes) = BoundsOf::new(set, BoundsRule::Padded) else { return Ok(Round::new(model)) };
    let (low, size) = (boxes.scene().min.to_array(), boxes.scene().size().to_array());
    exact_round(random, rays, &triangles, in_soup, |random| {
        let mut origin = point_within(random, &triangles);
        let axis = random.below(3);
        for k in (0..3).filter(|k| *k != axis) {
            let n = one_of(random, &[2, 3, 4, 5, 6, 8, 11, 16, 22, 32, 64]);
            let plane = S::from_i32(random.below(n + 1) as i32);
            let cell = size[k] / S::from_i32(n as i32);
            if random.below(3) > 0 {
                origin[k] = (low[k] + plane * cell).to_f64();
            }
        }
        let sign = one_of(random, &[1.0, -1.0]);
        (with(origin, axis, -3.0 * sign), with(DVec3::ZERO, axis, sign))
    })
}

pub fn lattice_ties<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = lattice_soup(random, 80);
    exact_round(random, rays, &triangles, on_lattice, |random| {
        // the largest component a power of two: all arithmetic stays exact
        let (a, b) = (random_integer(random, 4), random_integer(random, 4));
        let c = one_of(random, &[4.0, -4.0]);
        let d = one_of(random, &[dvec3(a, b, c), dvec3(b, c, a), dvec3(c, a, b)]);
        (lattice_point(random) - d * random.below(6) as f64, d)
    })
}

pub fn within_planes<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = lattice_soup(random, 80);
    let mut round: Round<S> = exact_round(random, rays, &triangles, on_lattice, |random| {
        let zero = one_of(random, &[0.0, -0.0]);
        let sign = one_of(random, &[1.0, -1.0]);
        let d = with(DVec3::splat(zero), random.below(3), sign);
        (lattice_point(random) - d * random.below(2 * LATTICE as usize) as f64, d)
    })?;
    round.pairs.extend(round.mirrored(random.below(8) as u8));
    Ok(round)
}

pub fn spanning<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let mut triangles = soup(random, 30, 2.0);
    triangles.extend(soup(random, 150, 0.1));
    aimed_round(random, rays, &triangles, 2.0)
}

pub fn any_and_closest<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = soup(random, 150, 0.3);
    let mut round: Round<S> = aimed_round(random, rays, &triangles, 2.0)?;
    for (ray, expected) in round.rays.iter_mut().zip(&mut round.expected) {
        let all = every_hit(&round.model, ray);
        let start = S::from_f64(unit(random) * 0.8);
        ray.t_min = match (random.below(4), all.get(random.below(all.len()))) {
            (0, Some(hit)) => hit.t,
            (1, Some(hit)) => hit.t.next_up(),
            (2, Some(hit)) => hit.t.next_down(),
            _ => start,
        };
        ray.t_max = ray.t_min + S::from_f64(0.1 + unit(random));
        *expected = first_within(&all, ray.t_min, ray.t_max);
    }
    Ok(round)
}
