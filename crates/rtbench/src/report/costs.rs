//! What each row of a scene costs: the build, and a ray.
//!
//! A row that is too slow for all rays is timed on every k-th. Its time per ray is then its ratio to
//! the reference on these rays, times what the reference takes per ray over all of its own: so all
//! rows stand for the same rays.

use std::collections::BTreeMap;

use measurement::record::{Answered, RowRecord, Sample, SceneRecord, Verdict};
use statistics::estimate::{Estimate, geometric_mean, median};
use statistics::series::{Series, geometric_mean_of};

/// Seconds of a round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// To build.
    pub build_s: f64,
    /// For a ray.
    pub ray_s: f64,
}

impl Cost {
    /// Building and tracing so many rays.
    pub fn total_s(&self, rays: f64) -> f64 {
        self.build_s + rays * self.ray_s
    }
}

/// A row that answers all kinds of rays, all of them rightly.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Its number in the scene's table, from 1.
    pub number: usize,
    /// Structure and settings.
    pub label: String,
    /// By process and round.
    pub rounds: BTreeMap<(u32, u32), Cost>,
    /// Medians over the rounds.
    pub cost: Cost,
}

impl Profile {
    /// Of rounds; none without any.
    pub fn new(number: usize, label: String, rounds: BTreeMap<(u32, u32), Cost>) -> Option<Self> {
        let of = |f: fn(&Cost) -> f64| median(&rounds.values().map(f).collect::<Vec<_>>());
        let cost = Cost { build_s: of(|c| c.build_s)?, ray_s: of(|c| c.ray_s)? };
        Some(Self { number, label, rounds, cost })
    }

    /// Both costs of the rounds that both have, with their process.
    pub fn paired<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = (u32, [Cost; 2])> + 'a {
        let both = |(visit, cost): (&(u32, u32), &Cost)| {
            Some((visit.0, [*cost, *other.rounds.get(visit)?]))
        };
        self.rounds.iter().filter_map(both)
    }

    /// Seconds for a ray, with their interval.
    pub fn ray_s(&self, seed: u64) -> Option<Estimate> {
        let rounds = self.rounds.iter().map(|((process, _), c)| (*process, c.ray_s));
        rounds.collect::<Series>().estimate(seed)
    }

    /// Time per ray over that of another row, paired by round.
    pub fn ray_quotients(&self, other: &Self) -> Series {
        self.quotients(other, |[own, other]| own.ray_s / other.ray_s)
    }

    /// Time for so many rays, build included, over that of another row, paired by round.
    pub fn total_quotients(&self, other: &Self, rays: f64) -> Series {
        self.quotients(other, |[own, other]| own.total_s(rays) / other.total_s(rays))
    }

    fn quotients(&self, other: &Self, of: impl Fn([Cost; 2]) -> f64) -> Series {
        let quotients = self.paired(other).map(|(process, both)| (process, of(both)));
        quotients.filter(|(_, q)| q.is_finite()).collect()
    }
}

/// The rows of a scene that may be compared, in its order.
pub fn profiles(scene: &SceneRecord) -> Vec<Profile> {
    let reference = scene.rows.iter().find(|row| row.is_reference && row.verdict.is_timed());
    let of = |(i, row): (usize, &RowRecord)| {
        if row.verdict != Verdict::Ok || row.answers != Answered::AllRays || row.rays == 0 {
            return None;
        }
        let rounds =
            row.samples.iter().map(|s| ((s.process, s.round), cost(s, row, reference))).collect();
        Profile::new(i + 1, row.label_with_query(), rounds)
    };
    scene.rows.iter().enumerate().filter_map(of).collect()
}

/// The seconds of a visit.
fn cost(sample: &Sample, row: &RowRecord, reference: Option<&RowRecord>) -> Cost {
    let all_rays = |reference: &RowRecord| {
        let own = reference.samples.iter().find(|s| s.round == sample.round)?;
        let on_same_rays = sample.reference_trace_s.filter(|s| *s > 0.0)?;
        Some(own.total_trace_s() / reference.rays.max(1) as f64 / on_same_rays)
    };
    let a_second = reference.and_then(all_rays).unwrap_or(1.0 / row.rays.max(1) as f64);
    Cost { build_s: sample.build_s, ray_s: sample.total_trace_s() * a_second }
}

/// How the fastest of several stands against the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Lead {
    /// The fastest, by its median.
    pub first: String,
    /// Those that it is not told apart from.
    pub ties: Vec<String>,
    /// The nearest that it is told apart from, and how many times as fast it is.
    pub next: Option<(String, Estimate)>,
}

/// The intervals of fewer samples hold all of them.
const FEW: usize = 6;

/// Another row than the fastest, and the quotients of the fastest one's times and its own.
struct Other {
    label: String,
    /// By scene, at the end of which they are resampled.
    groups: Vec<Series>,
}

impl Other {
    fn quotient(&self, seed: u64) -> Option<Estimate> {
        geometric_mean_of(&self.groups.iter().collect::<Vec<_>>(), seed)
    }

    /// The quotient without its interval.
    fn middle(&self) -> Option<f64> {
        let medians = self.groups.iter().map(Series::middle).collect::<Option<Vec<_>>>()?;
        match &medians[..] {
            [one] => Some(*one),
            _ => geometric_mean(&medians),
        }
    }

    /// Whether so few rounds of one scene say that it may be the faster one: their interval reaches to the
    /// largest quotient, as [`Estimate`] says, and need not be resampled.
    fn is_tied_by_few(&self) -> bool {
        match &self.groups[..] {
            [group] => {
                let is_one_process = group.by_process().len() < 2;
                is_one_process && group.len() < FEW && group.values().iter().any(|q| *q >= 1.0)
            }
            _ => false,
        }
    }

    /// Whether it is slower in every round: resampling them does not change that.
    fn is_always_slower(&self) -> bool {
        self.groups.iter().flat_map(Series::values).all(|quotient| *quotient < 1.0)
    }
}

impl Lead {
    /// From the others, in any order.
    fn new(first: String, others: Vec<Other>, seed: u64) -> Self {
        let mut others: Vec<(f64, Other)> =
            others.into_iter().filter_map(|other| Some((other.middle()?, other))).collect();
        others.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (mut ties, mut next) = (Vec::new(), None);
        for (_, other) in others {
            // intervals take long: of what is slower in any case only that of the nearest is shown
            if next.is_some() && other.is_always_slower() {
                continue;
            }
            if other.is_tied_by_few() {
                ties.push(other.label);
                continue;
            }
            match other.quotient(seed) {
                Some(quotient) if quotient.high >= 1.0 => ties.push(other.label),
                Some(quotient) if next.is_none() => next = Some((other.label, quotient.inverse())),
                _ => {}
            }
        }
        Self { first, ties, next }
    }
}

/// Who traces a scene fastest; none without rows.
pub fn lead(profiles: &[Profile], seed: u64) -> Option<Lead> {
    lead_by(profiles, |p| p.cost.ray_s, Profile::ray_quotients, seed)
}

/// Who is fastest for so many rays, build included.
pub fn lead_for(profiles: &[Profile], rays: f64, seed: u64) -> Option<Lead> {
    let total = |p: &Profile| p.cost.total_s(rays);
    lead_by(profiles, total, |a, b| a.total_quotients(b, rays), seed)
}

fn lead_by(
    profiles: &[Profile],
    time: impl Fn(&Profile) -> f64,
    quotients: impl Fn(&Profile, &Profile) -> Series,
    seed: u64,
) -> Option<Lead> {
    let first = profiles.iter().min_by(|a, b| time(a).total_cmp(&time(b)))?;
    let others = profiles.iter().filter(|p| p.number != first.number);
    let others =
        others.map(|p| Other { label: p.label.clone(), groups: vec![quotients(first, p)] });
    Some(Lead::new(first.label.clone(), others.collect(), seed))
}

/// Who traces fastest over all scenes, by geometric means, of the rows that every scene has.
pub fn lead_over_all(scenes: &[Vec<Profile>], seed: u64) -> Option<Lead> {
    let by_label = |scene: &'_ Vec<Profile>| -> BTreeMap<String, usize> {
        // of rows with the same label the first counts
        scene.iter().enumerate().rev().map(|(i, p)| (p.label.clone(), i)).collect()
    };
    let places: Vec<BTreeMap<String, usize>> = scenes.iter().map(by_label).collect();
    let everywhere = |label: &str| -> Option<Vec<&Profile>> {
        let found = scenes.iter().zip(&places);
        found.map(|(scene, places)| scene.get(*places.get(label)?)).collect()
    };
    let candidates: Vec<Vec<&Profile>> =
        scenes.first()?.iter().filter_map(|p| everywhere(&p.label)).collect();
    let time = |rows: &Vec<&Profile>| rows.iter().map(|p| p.cost.ray_s.ln()).sum::<f64>();
    let first = candidates.iter().min_by(|a, b| time(a).total_cmp(&time(b)))?;
    let label = |rows: &[&Profile]| rows.first().map_or(String::new(), |p| p.label.clone());
    let others = candidates.iter().filter(|rows| label(rows) != label(first));
    let others = others.map(|rows| Other {
        label: label(rows),
        groups: first.iter().zip(rows).map(|(a, b)| a.ray_quotients(b)).collect(),
    });
    Some(Lead::new(label(first), others.collect(), seed))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(number: usize, costs: &[(f64, f64)]) -> Profile {
        let rounds =
            costs.iter().zip(0..).map(|(&(build_s, ray_s), i)| ((0, i), Cost { build_s, ray_s }));
        Profile::new(number, format!("row {number}"), rounds.collect()).unwrap()
    }

    #[test]
    fn intervals_of_few_samples_reach_to_the_largest() {
        for n in 1..FEW {
            for largest in [0.9, 1.0, 1.1] {
                let mut group: Vec<f64> = (1..n).map(|i| 0.5 + 0.05 * i as f64).collect();
                group.push(largest);
                let other = Other { label: String::new(), groups: vec![group.into()] };
                let interval = other.quotient(1).unwrap();
                assert_eq!(interval.high, largest, "{n}");
                assert_eq!(other.is_tied_by_few(), interval.high >= 1.0, "{n} {largest}");
            }
        }
        let many = Other { label: String::new(), groups: vec![vec![1.1; FEW].into()] };
        assert!(!many.is_tied_by_few());
    }

    #[test]
    fn leads_are_paired_by_round() {
        // rounds of very different speed: unpaired, nothing could be told
        let rows = [
            profile(1, &[(1.0, 1.0), (1.0, 5.0), (1.0, 9.0), (1.0, 2.0), (1.0, 3.0), (1.0, 4.0)]),
            profile(2, &[(1.0, 1.2), (1.0, 6.0), (1.0, 10.8), (1.0, 2.4), (1.0, 3.6), (1.0, 4.8)]),
            profile(3, &[(1.0, 1.1), (1.0, 4.9), (1.0, 9.9), (1.0, 2.1), (1.0, 2.9), (1.0, 4.8)]),
        ];
        let lead = lead(&rows, 1).unwrap();
        assert_eq!((lead.first.as_str(), lead.ties), ("row 1", vec!["row 3".to_owned()]));
        let (label, times) = lead.next.unwrap();
        assert_eq!(label, "row 2");
        assert!((times.median - 1.2).abs() < 1e-9 && times.low <= times.high, "{times:?}");
        let all = lead_over_all(&[rows.to_vec(), rows[..2].to_vec()], 1).unwrap();
        assert_eq!((all.first.as_str(), all.ties.len()), ("row 1", 0), "row 3 is not everywhere");
        assert_eq!(lead_over_all(&[Vec::new()], 1), None);
    }

    #[test]
    fn builds_count_where_rays_are_few() {
        let rows = [profile(1, &[(9.0, 1.0); 6]), profile(2, &[(1.0, 2.0); 6])];
        assert_eq!(lead_for(&rows, 1.0, 1).unwrap().first, "row 2");
        assert_eq!(lead_for(&rows, 100.0, 1).unwrap().first, "row 1");
        assert_eq!(lead_for(&rows, 8.0, 1).unwrap().ties.len(), 1);
    }
}
