//! How a light buffer that is filled answers rays: one by one, or those of a batch in turns.

use super::LightBuffer;
use crate::geometry::ray::Ray;
use crate::memory::prefetch;
use crate::occluders::Occluder;
use crate::occluders::light_buffer::direction_cube::CubePoint;
use crate::occluders::light_buffer::face_tree::{COVERED, Face, FaceLookup, LONG, Record};
use crate::primitives::PrimSet;
use crate::query::counters::{Counters, NoCounters, WorkCounters};
use crate::registry::Buildable;
use crate::structure::{Batches, StructureStats};

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
    /// Whether a ray is blocked; `None` where the remainder has to be asked.
    #[inline(always)]
    pub(super) fn answer<C: Counters>(
        &self,
        ray: &Ray<S>,
        light: u32,
        counters: &mut C,
    ) -> Option<bool> {
        let (place, face) = self.cubes.place(ray, light)?;
        let Some(found) = face.find(&self.cells.cells, place.at) else {
            counters.elementary_step(true);
            return Some(false);
        };
        if C::ENABLED {
            (1..found.levels).for_each(|_| counters.inner_step());
            counters.elementary_step(found.first == 0);
        }
        self.in_list(ray, &place, &found, counters)
    }

    /// Candidates of the list that was found, nearest first; or the answer, as of
    /// [`LightBuffer::answer`], if an occluder covers the cell.
    #[inline(always)]
    fn candidates(
        &self,
        ray: &Ray<S>,
        place: &CubePoint<S>,
        found: &FaceLookup,
    ) -> Result<impl Iterator<Item = &Record<S>>, Option<bool>> {
        let mut list = self.cells.records.get(found.first as usize..).ok_or(None)?;
        if let [head, rest @ ..] = list
            && head.id == COVERED
        {
            if place.depth > head.near {
                // what covers the cell is hit at a parameter of at least t_min
                let room = (place.depth - head.near) * ray.t_max;
                let certain = room > ray.t_min * place.depth * S::from_f64(1.001);
                return Err(certain.then_some(true));
            }
            list = rest;
        }
        let (depth, spot) = (place.depth, found.spot);
        let before = list.iter().take_while(move |record| record.near <= depth);
        Ok(before.filter(move |record| record.part.holds(spot)))
    }

    /// One ray, whose list was found.
    #[inline(always)]
    fn in_list<C: Counters>(
        &self,
        ray: &Ray<S>,
        place: &CubePoint<S>,
        found: &FaceLookup,
        counters: &mut C,
    ) -> Option<bool> {
        let candidates = match self.candidates(ray, place, found) {
            Ok(candidates) => candidates,
            Err(answer) => return answer,
        };
        let mut setup = None;
        for record in candidates {
            if record.id >= LONG {
                return None;
            }
            counters.intersection_tests(1);
            let setup = setup.get_or_insert_with(|| self.prims.setup(ray));
            if self.prims.intersect(record.id, ray, setup, ray.t_max).is_some() {
                return Some(true);
            }
        }
        Some(false)
    }

    /// Answers the rays of a batch in turns: all that wait are asked for the memory of the next
    /// stage before any of them takes it.
    ///
    /// Cells, lists and triangles of a large scene are three loads, each waited for, and each of
    /// an address that the one before says; of one ray after the other nothing can be fetched
    /// ahead. Stages, answers and tests are those of one ray; to set eight rays up at once was
    /// slower, as many test nothing. The rays that a structure has to answer go to it together.
    fn occlusions_in_stages(&self, rays: &[Ray<S>], lights: &[u32], blocked: &mut [bool]) {
        let mut unknown = Vec::new();
        let groups = rays.chunks(TURNS).zip(lights.chunks(TURNS)).zip(blocked.chunks_mut(TURNS));
        for (number, ((rays, lights), blocked)) in groups.enumerate() {
            let mut stages = [Stage::Over; TURNS];
            let mut leave = |i: usize| unknown.push((number * TURNS + i) as u32);
            for (i, (ray, &light)) in rays.iter().zip(lights).enumerate() {
                match self.cubes.place(ray, light) {
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
                    Some(answer) => *blocked = answer,
                    None => leave(i),
                }
            }
        }
        self.remainder.answer(rays, &unknown, blocked);
    }
}

impl<S: Buildable, P: PrimSet<S>> Occluder<S> for LightBuffer<'_, S, P> {
    fn occlusions(&self, rays: &[Ray<S>], lights: &[u32], blocked: &mut [bool]) {
        if self.is_batch {
            return self.occlusions_in_stages(rays, lights, blocked);
        }
        for ((ray, &light), blocked) in rays.iter().zip(lights).zip(blocked) {
            let answer = self.answer(ray, light, &mut NoCounters);
            *blocked = answer.unwrap_or_else(|| self.remainder.is_blocked(ray));
        }
    }

    fn count_occlusions(
        &self,
        rays: &[Ray<S>],
        lights: &[u32],
        blocked: &mut [bool],
    ) -> WorkCounters {
        let mut work = WorkCounters::default();
        for ((ray, &light), blocked) in rays.iter().zip(lights).zip(blocked) {
            let answer = self.answer(ray, light, &mut work);
            *blocked = answer.unwrap_or_else(|| self.remainder.count_blocked(ray, &mut work));
        }
        work
    }

    fn stats(&self) -> StructureStats {
        let (cells, tally) = (&self.cells, &self.cells.tally);
        let bytes = cells.bytes() + size_of_val(self.cubes.all.as_slice());
        StructureStats {
            inner_cells: tally.inner,
            cells: tally.leaves,
            empty_cells: tally.empty,
            references: tally.references,
            bytes: bytes as u64 + self.remainder.bytes(),
            ..StructureStats::default()
        }
    }

    fn batches(&self) -> Batches {
        if self.is_batch { Batches::Together } else { Batches::RayByRay }
    }
}
