//! What moves: triangles between frames, and while rays with a time are traced.

use super::*;

/// Structures are taken from one frame to the next, and not built anew.
pub fn frames<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let before = soup(random, 150, 0.4);
    let share = one_of(random, &[0.02, 0.3, 1.0]);
    let way = one_of(random, &[1e-3, 0.5, 30.0]);
    let kind = random.below(3);
    let moved = |random: &mut Random, triangle: &Corners| {
        if unit(random) >= share {
            return *triangle;
        }
        let by = point(random) * way;
        match kind {
            0 => triangle.map(|p| p + by),
            // points, and what was one before
            1 => [triangle[0]; 3],
            _ => [(); 3].map(|()| point(random) + by),
        }
        .map(single)
    };
    let after: Vec<Corners> = before.iter().map(|t| moved(random, t)).collect();
    let (before, after) = if random.below(2) == 0 { (before, after) } else { (after, before) };
    let mut round = exact_round(random, rays, &after, in_soup, |random| {
        let target: DVec3 = within_or_on_edge(random, &after);
        toward(random, target, 2.0)
    })?;
    round.before = Some(model_of(&before)?);
    Ok(round)
}

/// Times of a round: the scene is made anew for each.
const TIMES: usize = 12;

/// Rays with a time over triangles that move, neighbours in opposite directions.
pub fn moving<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let exposure = one_of(random, &[1.0, 0.75, (-80f64).exp2(), 80f64.exp2()]);
    let size = one_of(random, &[0.1, 0.4, 1.0]);
    let triangles = soup(random, 60, size);
    let way = direction(random) * one_of(random, &[1e-3, 0.5, 2.0]);
    let ways: Vec<DVec3> = (0..triangles.len())
        .map(|_| {
            let other = direction(random) * unit(random);
            let way = one_of(random, &[way, -way, way, -way, DVec3::ZERO, other]);
            // as it is held, in units of the exposure
            (way / exposure).as_vec3().as_dvec3()
        })
        .collect();
    let mut round = Round::new(mixed_model(|set| {
        triangles.iter().zip(&ways).try_for_each(|(triangle, way)| {
            set.triangle(*triangle)?;
            set.last_moves(*way, exposure)
        })
    })?);
    for _ in 0..TIMES {
        let time = time::<S>(random, exposure);
        // what moves stands still before its exposure and after it
        let moment = if time.to_f64() > 0.0 { time.to_f64().min(exposure) } else { 0.0 };
        let now: Vec<Corners> =
            triangles.iter().zip(&ways).map(|(t, way)| t.map(|p| p + *way * moment)).collect();
        let exact = Soup::new(&now);
        for _ in 0..rays.div_ceil(TIMES) {
            let target = within_or_on_edge(random, &now);
            let (origin, along) = toward(random, target, 3.0);
            let ray: Ray<S> = Ray { time, ..ray(origin, along) };
            round.push(ray, expected_in(&exact, &ray));
        }
    }
    round.truncate(rays);
    Ok(round)
}

/// At a border of equal parts of the exposure, an ulp beside, anywhere, outside, or no time.
fn time<S: Buildable>(random: &mut Random, exposure: f64) -> S {
    let parts = 1 + random.below(8);
    let border = S::from_f64(exposure * random.below(parts + 1) as f64 / parts as f64);
    let beyond = one_of(random, &[-1.0, -1e-30, 1.5, 1e6, f64::INFINITY, f64::NAN]);
    match random.below(6) {
        0 => border.next_up(),
        1 => border.next_down(),
        2 => S::from_f64(exposure * beyond),
        3 => S::from_f64(exposure * unit(random)),
        _ => border,
    }
}
