//! A round drawn by a case from a seed: a scene, rays, and the expected answers.

use accel_core::{Hit, Ray, Scalar};
use glam::DVec3;

use super::metamorphic::MetamorphicPair;
use super::model::Model;

/// The fewest rays that a round is drawn with, when so many are asked for: few, so that there are
/// many scenes.
pub const FEWEST_RAYS: usize = 500;

/// The most: many, so that large runs do not spend their time on building.
pub const MOST_RAYS: usize = 20_000;

/// Answer of a case's oracle for the closest hit of a ray. Agreement with brute force is required
/// in any case.
#[derive(Debug, Clone, PartialEq)]
pub enum OracleAnswer {
    /// Nothing: agreement is the only oracle.
    Anything,
    Miss,
    /// The tests of primitives break a law of geometry here, said in words: no answer is right.
    Broken(String),
    Hit {
        /// Primitive that is hit; any if `None`.
        id: Option<u32>,
        /// At a parameter in this closed interval.
        t: [f64; 2],
    },
}

impl OracleAnswer {
    /// A hit of whichever primitive, at `t` but for `slack`.
    pub fn hit_at(t: f64, slack: f64) -> Self {
        Self::Hit { id: None, t: [t - slack, t + slack] }
    }

    /// Returns whether an answer is what is expected.
    pub fn admits<S: Scalar>(&self, hit: &Hit<S>) -> bool {
        match *self {
            Self::Anything => true,
            Self::Miss => !hit.is_hit(),
            Self::Broken(_) => false,
            Self::Hit { id, t: [low, high] } => {
                let t = hit.t.to_f64();
                hit.is_hit() && id.is_none_or(|id| id == hit.id) && low <= t && t <= high
            }
        }
    }
}

/// For each ray the only primitives that it can meet: a reference for scenes so large that asking
/// all of them would take too long.
#[derive(Debug, Default)]
pub struct NearbyPrimitives {
    /// Ids in rising order.
    pub lists: Vec<Vec<u32>>,
    /// Index of the list of each ray.
    pub of: Vec<usize>,
}

#[derive(Debug)]
pub struct Round<S: Scalar> {
    pub model: Model<S>,
    pub rays: Vec<Ray<S>>,
    pub expected: Vec<OracleAnswer>,
    /// True if each is blocked, where that is known otherwise than by its closest hit; or empty.
    pub blocked: Vec<bool>,
    /// Point lights, for what answers shadow rays alone.
    pub lights: Vec<DVec3>,
    /// Index of the light that each ray runs to.
    pub light_of: Vec<u32>,
    /// The frame before: structures are built over it, and then taken to the scene.
    pub before: Option<Model<S>>,
    /// Structures are built by each of these numbers of threads; by those there are where it is
    /// empty.
    pub threads: &'static [usize],
    /// The same in other guises, which must not change the answers.
    pub pairs: Vec<MetamorphicPair<S>>,
    /// Brute force is asked for those primitives alone; for all where there is none.
    pub near: Option<NearbyPrimitives>,
}

impl<S: Scalar> Round<S> {
    pub fn new(model: Model<S>) -> Self {
        Self {
            model,
            rays: Vec::new(),
            expected: Vec::new(),
            blocked: Vec::new(),
            lights: Vec::new(),
            light_of: Vec::new(),
            before: None,
            threads: &[],
            pairs: Vec::new(),
            near: None,
        }
    }

    /// No more than so many rays: chains may have added some.
    pub fn truncate(&mut self, rays: usize) {
        self.rays.truncate(rays);
        self.expected.truncate(rays);
    }

    pub fn push(&mut self, ray: Ray<S>, expected: OracleAnswer) {
        self.rays.push(ray);
        self.expected.push(expected);
    }
}
