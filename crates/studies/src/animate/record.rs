//! Record of an animation, and figures derived from its times.

use measurement::record::{Compiler, Machine, OracleRecord, Tool, Verdict, WorkRecord, label};
use serde::Serialize;
use statistics::estimate::{Estimate, estimate, median};

#[derive(Debug, Clone, Default, Serialize)]
pub struct AnimationRecord {
    pub tool: Tool,
    /// The command line, program first.
    pub command_line: Vec<String>,
    pub machine: Machine,
    pub compiler: Compiler,
    pub scene: String,
    /// Structures of a row, each updated and timed.
    pub rounds: usize,
    /// Seed of orders and samples.
    pub seed: u64,
    /// Pixels of the image whose rays are asked.
    pub resolution: [u32; 2],
    pub precision: String,
    pub kinds: Vec<String>,
    /// The whole, seconds.
    pub took_s: f64,
    /// All frames asked for were measured.
    pub complete: bool,
    pub frames: Vec<FrameRecord>,
    pub lanes: Vec<LaneRecord>,
}

#[derive(Debug, Clone, Serialize)]
pub struct FrameRecord {
    pub frame: u32,
    pub primitives: u64,
    /// Number of these that changed since the previous frame; `None` in the first, and if the sets
    /// of primitives differ.
    pub moved: Option<u64>,
    /// Rays of all kinds.
    pub rays: u64,
    /// How the right answers were found.
    pub oracle: OracleRecord,
}

/// A row with a number of threads.
#[derive(Debug, Clone, Default, Serialize)]
pub struct LaneRecord {
    pub structure: String,
    /// Settings that differ from the defaults.
    pub settings: String,
    /// Threads that update and trace.
    pub threads: usize,
    pub known_defect: Option<String>,
    /// Why it ended early.
    pub error: Option<String>,
    /// Wrong answers in all frames.
    pub mismatches: u64,
    /// The first of them.
    pub example: Option<String>,
    /// Stride of the rays that were timed.
    pub stride: usize,
    pub frames: Vec<LaneFrame>,
}

#[derive(Debug, Clone, Default, Serialize)]
pub struct LaneFrame {
    pub frame: u32,
    /// Number of rounds that updated it; the others rebuilt it.
    pub updated: usize,
    /// Seconds of the update or build, a round each.
    pub update_s: Vec<f64>,
    /// Seconds of all rays, a round each; where every n-th ray was timed, n times what they took.
    pub trace_s: Vec<f64>,
    pub bytes: u64,
    /// The work of the counting pass; with one thread alone.
    pub work: Option<WorkRecord>,
    /// Expected steps and tests of a ray; with one thread alone: see [`crate::animate::quality`].
    pub expected_cost: Option<f64>,
    pub overlap: Option<f64>,
}

/// A row's times over all frames that follow another one; of an animation of one frame, over that.
#[derive(Debug, Clone, PartialEq)]
pub struct Totals {
    /// Seconds a frame of updates, a round each.
    pub update_s: Vec<f64>,
    /// Seconds a frame of rays, a round each.
    pub trace_s: Vec<f64>,
    pub rays: f64,
}

/// A row with what it takes; nothing of one whose times may not be shown.
#[derive(Debug, Clone)]
pub struct RankedLane<'a> {
    pub lane: &'a LaneRecord,
    pub totals: Option<Totals>,
    /// Frames per second.
    pub rate: Option<Estimate>,
}

impl AnimationRecord {
    /// The rows with that many threads: those with the most frames per second first, those without
    /// times last.
    pub fn ranked(&self, threads: usize) -> Vec<RankedLane<'_>> {
        let lanes = self.lanes.iter().filter(|lane| lane.threads == threads).map(|lane| {
            let totals = lane.totals(self);
            let rate = totals.as_ref().and_then(|totals| totals.frames_per_second(self.seed));
            RankedLane { lane, totals, rate }
        });
        let mut lanes: Vec<RankedLane<'_>> = lanes.collect();
        let median = |lane: &RankedLane<'_>| lane.rate.map_or(-1.0, |rate| rate.median);
        lanes.sort_by(|a, b| median(b).total_cmp(&median(a)));
        lanes
    }
}

impl LaneRecord {
    pub fn label(&self) -> String {
        label(&self.structure, &self.settings)
    }

    pub fn verdict(&self) -> Verdict {
        match (&self.error, self.mismatches, &self.known_defect) {
            (Some(_), ..) => Verdict::NotBuilt,
            (None, 0, _) => Verdict::Ok,
            (None, _, Some(_)) => Verdict::WrongAsShipped,
            (None, _, None) => Verdict::Wrong,
        }
    }

    /// Returns whether its times may be shown.
    pub fn is_timed(&self) -> bool {
        matches!(self.verdict(), Verdict::Ok | Verdict::WrongAsShipped)
    }

    /// Its frames that follow another one; of one frame, that.
    pub fn updates(&self) -> &[LaneFrame] {
        match self.frames.as_slice() {
            [_, rest @ ..] if !rest.is_empty() => rest,
            all => all,
        }
    }

    /// Part of the updates that were updates, and not builds.
    pub fn updated(&self) -> f64 {
        let of = |f: fn(&LaneFrame) -> usize| self.updates().iter().map(f).sum::<usize>() as f64;
        of(|frame| frame.updated) / of(|frame| frame.update_s.len()).max(1.0)
    }

    /// Over its frames; none where its times may not be shown.
    fn totals(&self, run: &AnimationRecord) -> Option<Totals> {
        let frames = self.updates();
        if !self.is_timed() || frames.is_empty() {
            return None;
        }
        let count = frames.len() as f64;
        let rounds = frames.iter().map(|f| f.update_s.len()).min()?;
        let mean = |of: fn(&LaneFrame) -> &Vec<f64>, round: usize| {
            frames.iter().filter_map(|frame| of(frame).get(round)).sum::<f64>() / count
        };
        let numbers = frames.iter().map(|frame| frame.frame);
        let rays = numbers.filter_map(|n| run.frames.iter().find(|f| f.frame == n));
        Some(Totals {
            update_s: (0..rounds).map(|round| mean(|f| &f.update_s, round)).collect(),
            trace_s: (0..rounds).map(|round| mean(|f| &f.trace_s, round)).collect(),
            rays: rays.map(|frame| frame.rays as f64).sum::<f64>() / count,
        })
    }

    /// Milliseconds of the slowest frame, update and rays: the frame's number and its median.
    pub fn worst(&self) -> Option<(u32, f64)> {
        let all = self.updates().iter().filter_map(|f| Some((f.frame, f.seconds()?)));
        all.max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

impl LaneFrame {
    /// Update and rays, the median of the rounds.
    pub fn seconds(&self) -> Option<f64> {
        let both = self.update_s.iter().zip(&self.trace_s).map(|(a, b)| a + b);
        median(&both.collect::<Vec<_>>())
    }
}

impl Totals {
    fn frames_per_second(&self, seed: u64) -> Option<Estimate> {
        let both = self.update_s.iter().zip(&self.trace_s).map(|(a, b)| 1.0 / (a + b));
        estimate(&both.collect::<Vec<_>>(), seed)
    }

    /// Rays a frame from which on this row is faster than one that is updated in less time and
    /// traced in more; none where it is never, or always.
    pub fn break_even(&self, other: &Self, seed: u64) -> Option<Estimate> {
        let of_round = |round: usize| {
            let at = |v: &Vec<f64>| v.get(round).copied();
            let saved = at(&other.trace_s)? / other.rays - at(&self.trace_s)? / self.rays;
            let spent = at(&self.update_s)? - at(&other.update_s)?;
            (saved > 0.0 && spent > 0.0).then_some(spent / saved)
        };
        let rounds = self.update_s.len().min(other.update_s.len());
        let all = (0..rounds).map(of_round).collect::<Option<Vec<_>>>()?;
        estimate(&all, seed)
    }

    /// Seconds of a frame with so many rays, by medians.
    pub fn seconds_of(&self, rays: f64) -> f64 {
        let of = |v: &[f64]| median(v).unwrap_or(f64::NAN);
        of(&self.update_s) + of(&self.trace_s) / self.rays.max(1.0) * rays
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_break_even_where_their_lines_cross() {
        let totals = |update: [f64; 3], ray: f64| Totals {
            update_s: update.to_vec(),
            trace_s: vec![ray * 1000.0; 3],
            rays: 1000.0,
        };
        // 10 ms and 2 us per ray against 1 ms and 5 us: at 3000 rays
        let (bvh, grid) = (totals([0.010; 3], 2e-6), totals([0.001; 3], 5e-6));
        let even = bvh.break_even(&grid, 1).unwrap();
        assert!((even.median - 3000.0).abs() < 1e-6, "{even:?}");
        assert!((bvh.seconds_of(3000.0) - grid.seconds_of(3000.0)).abs() < 1e-12);
        assert_eq!(grid.break_even(&bvh, 1), None);
        // not in every round
        assert_eq!(totals([0.01, 0.01, 0.0], 2e-6).break_even(&grid, 1), None);
        let fps = bvh.frames_per_second(1).unwrap();
        assert!((fps.median - 1.0 / 0.012).abs() < 1e-9);
    }
}
