//! Rays of a batch in turns: all that wait are asked for the memory of the next stage before any of
//! them takes it.
//!
//! Cells, lists and triangles of a large scene are three loads, each waited for, and each of an
//! address that the one before says; of one ray after the other nothing can be fetched ahead.
//! Stages, answers and tests are those of one ray; to set eight rays up at once was slower, as many
//! test nothing. The rays that a structure has to answer go to it together.

use super::direction_cube::CubePoint;
use super::face_tree::{Face, FaceLookup, LONG};
use super::{Answer, LightBuffer};
use crate::geometry::ray::Ray;
use crate::memory::prefetch;
use crate::primitives::PrimSet;
use crate::query::counters::NoCounters;
use crate::registry::Buildable;

/// Rays that take turns.
const TURNS: usize = 16;

/// How far a ray has come.
#[derive(Clone, Copy)]
enum Stage<'f, S> {
    /// No query, or the answer is known.
    Over,
    /// Its place is known.
    Placed(CubePoint<S>, &'f Face<S>),
    /// Its place and its list are known.
    Found(CubePoint<S>, FaceLookup),
}

impl<S: Buildable, P: PrimSet<S>> LightBuffer<'_, S, P> {
    pub(super) fn occlusions_in_stages(
        &self,
        rays: &[Ray<S>],
        lights: &[u32],
        blocked: &mut [bool],
    ) {
        let mut unknown = Vec::new();
        let groups = rays.chunks(TURNS).zip(lights.chunks(TURNS)).zip(blocked.chunks_mut(TURNS));
        for (number, ((rays, lights), blocked)) in groups.enumerate() {
            let mut stages = [Stage::Over; TURNS];
            let mut leave = |i: usize| unknown.push((number * TURNS + i) as u32);
            for (i, (ray, &light)) in rays.iter().zip(lights).enumerate() {
                match self.place(ray, light) {
                    Some((place, face)) => {
                        face.prefetch(&self.cells.cells, place.at);
                        stages[i] = Stage::Placed(place, face);
                    }
                    None => leave(i),
                }
            }
            for (stage, blocked) in stages.iter_mut().zip(&mut *blocked) {
                let Stage::Placed(place, face) = *stage else { continue };
                *stage = match face.find(&self.cells.cells, place.at) {
                    Some(found) => {
                        if let Some(record) = self.cells.records.get(found.first as usize) {
                            prefetch(record);
                        }
                        Stage::Found(place, found)
                    }
                    None => {
                        *blocked = false;
                        Stage::Over
                    }
                };
            }
            for (stage, ray) in stages.iter().zip(rays) {
                if let Stage::Found(place, found) = stage
                    && let Ok(mut candidates) = self.candidates(ray, place, found)
                    && let Some(first) = candidates.next()
                    && first.id < LONG
                {
                    self.prims.prefetch(first.id);
                }
            }
            for (i, ((stage, ray), blocked)) in stages.iter().zip(rays).zip(blocked).enumerate() {
                let Stage::Found(place, found) = stage else { continue };
                match self.in_list(ray, place, found, &mut NoCounters) {
                    Answer::Free => *blocked = false,
                    Answer::Blocked => *blocked = true,
                    Answer::Unknown => leave(i),
                }
            }
        }
        self.remainder.answer(rays, &unknown, blocked);
    }
}
