//! Variants that no other dominates: the Pareto front of time and error.
//!
//! V. Pareto, *Manuale di economia politica*, 1906: a variant is dominated where another is as
//! accurate and as fast, and better in one of both.

use crate::accuracy::record::{VariantRecord, VariantStanding};
use statistics::estimate::Estimate;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrontPoint {
    /// Time over that of the cheapest.
    pub time: Estimate,
    pub error: f64,
}

impl FrontPoint {
    /// Point of a row. Errors below that of the reference cannot be distinguished from it.
    pub fn of(row: &VariantRecord, reference_error: f64) -> Self {
        let error = row.error.value();
        let error = if row.is_below_reference { reference_error } else { error };
        Self { time: row.ratio, error }
    }

    fn dominates(&self, other: &Self) -> bool {
        let (time, error) = (self.time.median, self.error);
        let is_no_worse = time <= other.time.median && error <= other.error;
        is_no_worse && (time < other.time.median || error < other.error)
    }

    fn is_told_apart(&self, other: &Self) -> bool {
        self.time.high < other.time.low || other.time.high < self.time.low
    }
}

pub fn standings(places: &[FrontPoint]) -> Vec<VariantStanding> {
    let of = |place: &FrontPoint| {
        let mut by = places.iter().filter(|other| other.dominates(place)).peekable();
        if by.peek().is_none() {
            return VariantStanding::OnFront;
        }
        if by.any(|other| other.is_told_apart(place)) {
            VariantStanding::Dominated
        } else {
            VariantStanding::NotToldApart
        }
    };
    places.iter().map(of).collect()
}

/// Checks a front: none of its members is beaten, everything else is. The
/// fault in words otherwise. (By sorting, not by [`standings`].)
pub fn fault(places: &[FrontPoint], standings: &[VariantStanding]) -> Option<String> {
    let mut order: Vec<usize> = (0..places.len()).collect();
    let key = |i: usize| places.get(i).map_or((f64::NAN, f64::NAN), |p| (p.time.median, p.error));
    order.sort_by(|&a, &b| {
        let (a, b) = (key(a), key(b));
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut least = (f64::INFINITY, f64::NAN);
    for i in order {
        let (time, error) = key(i);
        let is_beaten = error > least.0 || (error == least.0 && time > least.1);
        let is_on_front = standings.get(i) == Some(&VariantStanding::OnFront);
        if is_beaten == is_on_front {
            let what = if is_beaten { "is on the front but beaten" } else { "is not on the front" };
            return Some(format!("variant {i} at time {time} and error {error} {what}"));
        }
        if error < least.0 {
            least = (error, time);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(time: f64, spread: f64, error: f64) -> FrontPoint {
        let time = Estimate { median: time, low: time - spread, high: time + spread };
        FrontPoint { time, error }
    }

    #[test]
    fn the_front_has_all_undominated_members() {
        use VariantStanding::{Dominated, NotToldApart, OnFront};
        let places = [
            place(1.0, 0.02, 9.0),
            place(1.5, 0.02, 3.0),
            place(1.6, 0.02, 3.0),
            place(1.52, 0.02, 3.5),
            place(2.0, 0.02, 0.0),
            place(1.0, 0.02, 9.0),
        ];
        let found = standings(&places);
        assert_eq!(found, [OnFront, OnFront, Dominated, NotToldApart, OnFront, OnFront]);
        assert_eq!(fault(&places, &found), None);
    }

    #[test]
    fn a_front_that_keeps_a_dominated_member_is_caught() {
        let places = [place(1.0, 0.0, 2.0), place(1.2, 0.0, 2.0), place(1.4, 0.0, 1.0)];
        let mut planted = standings(&places);
        planted[1] = VariantStanding::OnFront;
        assert!(fault(&places, &planted).unwrap().contains("beaten"));
        let mut planted = standings(&places);
        planted[2] = VariantStanding::Dominated;
        assert!(fault(&places, &planted).unwrap().contains("not on the front"));
    }
}
