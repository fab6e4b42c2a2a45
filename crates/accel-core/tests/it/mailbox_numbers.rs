//! Mailboxes whose numbers run out (HARD_CASES Gr8): rays are numbered up to 255, so that a
//! thousand of them start again several times. A primitive may be tested again, but never skipped
//! wrongly.

use accel_core::params::Params;
use accel_core::params::config::Settings;
use accel_core::primitives::{PrimsRef, TriangleSet, Watertight};
use accel_core::query::mailbox::{Mailbox, MailboxSource, Slots, Stamps};
use accel_core::query::tracer::Bound;
use accel_core::registry::Buildable;
use accel_core::structure::Structure;
use accel_core::structures::uniform_grid::{INFO, UniformGrid};
use accel_core::{Hit, Ray};

use crate::common::{Random, build, triangle_set};

/// Triangles; most stand in several cells. Most are met by one ray in some hundreds: a stamp left
/// from before is not renewed in time.
const TRIANGLES: usize = 2000;
/// Large ones among them.
const LARGE: usize = 10;

fn scene<S: Buildable>(random: &mut Random) -> TriangleSet<S, Watertight> {
    let triangles = (0..TRIANGLES).map(|i| {
        let (at, size) = (random.point(), if i < LARGE { 0.6 } else { 0.05 });
        [at, at + random.signed() * size, at + random.signed() * size]
    });
    triangle_set(triangles, |_| false)
}

/// Rays through the scene; every other is an earlier one when its number comes again: what that
/// left is met.
fn rays<S: Buildable>(random: &mut Random) -> Vec<Ray<S>> {
    let mut rays: Vec<Ray<S>> = Vec::new();
    for i in 0..1500_usize {
        let back = 255 + random.one_of(&[0_usize, 1]);
        let again = i.checked_sub(back).filter(|_| random.unit() < 0.5).map(|i| rays[i]);
        rays.push(again.unwrap_or_else(|| {
            let (from, to) = (random.signed() * 2.0, random.point());
            Ray::from_dvec3(from, to - from)
        }));
    }
    rays
}

/// Number of closest hits in a grid with this mailbox that differ from brute force, and of the tests
/// that it saved.
fn wrong_and_saved<S: Buildable>(mailbox: impl MailboxSource) -> (usize, u64) {
    let mut random = Random::new(1);
    let (set, rays) = (scene::<S>(&mut random), rays::<S>(&mut random));
    let params = Params::new(INFO.name, INFO.params, [("density", "8")]).unwrap();
    let grid = UniformGrid::build(&set, &Settings::of(&params)).unwrap();
    let mut hits = vec![Hit::NONE; rays.len()];
    let work = Bound::<_, _, _, true>::new(&set, grid).count_closest(&rays, &mut hits, mailbox);
    let mut expected = vec![Hit::NONE; rays.len()];
    let brute_force = build(PrimsRef::Watertight(&set), "brute-force", "").unwrap();
    brute_force.closest_hits(&rays, &mut expected);
    assert!(expected.iter().filter(|hit| hit.is_hit()).count() > 500);
    let differs = |(hit, right): &(&Hit<S>, &Hit<S>)| {
        hit.id != right.id || right.is_hit() && hit.t != right.t
    };
    (hits.iter().zip(&expected).filter(differs).count(), work.tests_saved)
}

fn none_is_wrong<S: Buildable>() {
    let found = [
        wrong_and_saved::<S>(Stamps::<255>::dense(TRIANGLES)),
        wrong_and_saved::<S>(Stamps::<255>::in_records(TRIANGLES, 40)),
        wrong_and_saved::<S>(<Stamps>::dense(TRIANGLES)),
        wrong_and_saved::<S>(Slots::<255>::new(1 << 14)),
        wrong_and_saved::<S>(Slots::<255>::new(64)),
        wrong_and_saved::<S>(Slots::<255>::new(1)),
    ];
    assert!(found.iter().all(|(wrong, _)| *wrong == 0), "{found:?}");
    // few slots forget
    let saved = found.map(|(_, saved)| saved);
    assert!(saved[0] > 0 && saved[..4].iter().all(|&all| all == saved[0]), "{saved:?}");
    assert!(saved[5] < saved[0], "{saved:?}");
}

#[test]
fn reused_ray_numbers_skip_no_test() {
    none_is_wrong::<f32>();
    none_is_wrong::<f64>();
}

/// Stamps of 8 bits that start again without being cleared.
struct Stale {
    stamps: Vec<u8>,
    ray: u8,
}

impl Mailbox for &mut Stale {
    const ENABLED: bool = true;
    fn is_new(&mut self, id: u32) -> bool {
        std::mem::replace(&mut self.stamps[id as usize], self.ray) != self.ray
    }
}

impl MailboxSource for Stale {
    type Mailbox<'r> = &'r mut Self;
    fn next_ray(&mut self) -> &mut Self {
        self.ray = self.ray.wrapping_add(1);
        self
    }
}

#[test]
fn a_planted_mailbox_that_skips_wrongly_is_found() {
    assert!(wrong_and_saved::<f32>(Stale { stamps: vec![0; TRIANGLES], ray: 0 }).0 > 0);
}
