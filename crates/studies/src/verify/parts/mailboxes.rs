//! Mailboxes whose numbers run out, against no mailbox (HARD_CASES Gr8).
//!
//! Rays are numbered with 8 bits, so that at least a thousand of them start again several times. A
//! primitive may be tested again, but never skipped wrongly: the hits must be those of brute force.

use accel_core::params::Params;
use accel_core::params::config::Settings;
use accel_core::query::mailbox::{MailboxSource, Slots, Stamps};
use accel_core::query::tracer::{Bound, Tracer};
use accel_core::registry::Buildable;
use accel_core::structure::Structure;
use accel_core::structures::uniform_grid::{INFO, UniformGrid};
use accel_core::{Hit, Ray};

use super::{Findings, Part};
use crate::verify::cases::{point_within, toward};
use crate::verify::meshes::soup;
use crate::verify::model::Model;
use crate::verify::round::ray;
use crate::verify::subject::with_brute_force;
use statistics::random::Random;

/// Triangles of a scene; most stand in several cells.
const TRIANGLES: usize = 2000;

/// Large ones among them.
const LARGE: usize = 10;

/// Rays that need numbers again.
const AT_LEAST: usize = 1000;

/// A mailbox of 8-bit numbers.
macro_rules! mailbox {
    ($name:literal, $mailbox:expr) => {
        Part {
            name: $name,
            single: |random, rays| examine::<f32, _>(random, rays, $mailbox),
            double: |random, rays| examine::<f64, _>(random, rays, $mailbox),
        }
    };
}

/// Every kind of mailbox, numbered with 8 bits.
pub const WRAPPING: &[Part] = &[
    mailbox!("mailbox array, 8 bits", Stamps::<u8>::dense(TRIANGLES)),
    mailbox!("mailbox primitive, 8 bits", Stamps::<u8>::in_records(TRIANGLES, 40)),
    mailbox!("mailbox hash, 8 bits", Slots::<u8>::new(64)),
    mailbox!("mailbox hash of one slot, 8 bits", Slots::<u8>::new(1)),
];

/// Hits in a grid with that mailbox against those of brute force.
pub fn examine<S: Buildable, B: MailboxSource>(
    random: &mut Random,
    rays: usize,
    mailbox: B,
) -> Findings {
    // most are met by one ray in some hundreds: a stamp left from before is not renewed in time
    let mut triangles = soup(random, TRIANGLES - LARGE, 0.05);
    triangles.extend(soup(random, LARGE, 0.6));
    let mut rays_so_far: Vec<Ray<S>> = Vec::new();
    for i in 0..rays.max(AT_LEAST) {
        // the same ray when its number comes again: what it left is met
        let again = i.checked_sub(255 + random.below(2)).filter(|_| random.below(2) == 0);
        let again = again.and_then(|earlier| rays_so_far.get(earlier).copied());
        rays_so_far.push(again.unwrap_or_else(|| {
            let target = point_within(random, &triangles);
            let (origin, along) = toward(random, target, 2.0);
            ray(origin, along)
        }));
    }
    let rays = rays_so_far;
    let mut findings = Findings::default();
    let hits = answers(&triangles, &rays, mailbox);
    match hits {
        Ok([hits, expected]) => {
            for (hit, right) in hits.iter().zip(&expected) {
                let is_right = hit.id == right.id && (!hit.is_hit() || hit.t == right.t);
                let what = || format!("said {hit:?}, brute force {right:?}");
                findings.record(if is_right { Ok(0) } else { Err(what()) });
            }
        }
        Err(what) => findings.record(Err(what)),
    }
    findings
}

/// Hits with the mailbox, and hits of brute force.
fn answers<S: Buildable, B: MailboxSource>(
    triangles: &[crate::verify::model::Corners],
    rays: &[Ray<S>],
    mailbox: B,
) -> Result<[Vec<Hit<S>>; 2], String> {
    let model = Model::<S>::triangles(triangles).map_err(|e| e.to_string())?;
    let Model::Triangles(set) = &model else { return Err("no triangles".to_owned()) };
    let params = Params::new(INFO.name, INFO.params, [("density", "8")]);
    let params = params.map_err(|e| e.to_string())?;
    let grid = UniformGrid::build(set, &Settings::of(&params)).map_err(|e| e.to_string())?;
    let mut hits = vec![Hit::NONE; rays.len()];
    Bound::new(set, grid).count_closest(rays, &mut hits, mailbox);
    let mut expected = vec![Hit::NONE; rays.len()];
    with_brute_force(model.prims(), |t: &dyn Tracer<S>| t.closest_hits(rays, &mut expected))
        .map_err(|e| e.to_string())?;
    Ok([hits, expected])
}
