//! Share of a cone covered by a surface, its outline as the cone sees it, in units of its radius,
//! and whether two outlines lie side by side.
//!
//! Paper: none; a separating line (the separating axis theorem in the plane) is enough to tell
//! that two surfaces share nothing, so that what they cover may be added.

use glam::DVec2;

use super::disc_overlap::Overlap;

/// Outlines may overlap by so much and are still side by side, in radii: printed scenes have six
/// digits, and neighbours share their corners but for the rounding.
const SLACK: f64 = 1e-6;

/// Pairs of corners that are compared before a pair of outlines is given up as overlapping.
const MOST_PAIRS: usize = 1 << 14;

#[derive(Debug, Clone, PartialEq)]
pub struct Coverage {
    /// Share of the cone that it covers if nothing is in front, and where.
    pub overlap: Overlap,
    pub outline: Outline,
    /// A depth that no point of it within the cone lies beyond.
    pub far: f64,
    /// The estimate may be wrong by much.
    pub doubtful: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Outline {
    Disc { center: DVec2, radius: f64 },
    Polygon(Vec<DVec2>),
}

impl Outline {
    /// Lower and upper corner of the box around it.
    fn bounds(&self) -> (DVec2, DVec2) {
        match self {
            Self::Disc { center, radius } => (*center - *radius, *center + *radius),
            Self::Polygon(corners) => {
                let start = (DVec2::INFINITY, DVec2::NEG_INFINITY);
                corners.iter().fold(start, |(lo, hi), &p| (lo.min(p), hi.max(p)))
            }
        }
    }

    /// Smallest and largest distance along `normal` of its points.
    fn extent(&self, normal: DVec2) -> (f64, f64) {
        match self {
            Self::Disc { center, radius } => {
                let along = center.dot(normal);
                (along - radius, along + radius)
            }
            Self::Polygon(corners) => {
                let start = (f64::INFINITY, f64::NEG_INFINITY);
                corners
                    .iter()
                    .map(|p| p.dot(normal))
                    .fold(start, |(lo, hi), x| (lo.min(x), hi.max(x)))
            }
        }
    }

    /// Returns whether it holds a place.
    pub fn covers(&self, place: DVec2) -> bool {
        match self {
            Self::Disc { center, radius } => place.distance(*center) <= *radius,
            Self::Polygon(corners) => {
                let Some(&last) = corners.last() else { return false };
                let (mut inside, mut from) = (false, last);
                for &to in corners {
                    if (from.y > place.y) != (to.y > place.y) {
                        let share = (place.y - from.y) / (to.y - from.y);
                        inside ^= place.x < from.x + share * (to.x - from.x);
                    }
                    from = to;
                }
                inside
            }
        }
    }

    /// Returns whether they lie side by side for certain. Concave outlines may be said to overlap
    /// that do not.
    pub fn is_beside(&self, other: &Self) -> bool {
        let ((lo, hi), (other_lo, other_hi)) = (self.bounds(), other.bounds());
        if (lo - other_hi).max_element() >= -SLACK || (other_lo - hi).max_element() >= -SLACK {
            return true;
        }
        match (self, other) {
            (Self::Disc { center, radius }, Self::Disc { center: c, radius: r }) => {
                center.distance(*c) >= radius + r - SLACK
            }
            (Self::Polygon(own), _) if has_separating_edge(own, self, other) => true,
            (_, Self::Polygon(others)) => has_separating_edge(others, other, self),
            _ => false,
        }
    }
}

/// Returns whether the line through one of the edges has its own outline on one side and the other
/// outline on the other.
fn has_separating_edge(corners: &[DVec2], own: &Outline, other: &Outline) -> bool {
    let others = if let Outline::Polygon(others) = other { others.len() } else { 1 };
    let Some(&last) = corners.last() else { return true };
    if corners.len() * (corners.len() + others) > MOST_PAIRS {
        return false;
    }
    let mut from = last;
    corners.iter().any(|&to| {
        let normal = (to - from).perp().normalize_or_zero();
        let at = from.dot(normal);
        from = to;
        let ((lo, hi), (other_lo, other_hi)) = (own.extent(normal), other.extent(normal));
        normal != DVec2::ZERO
            && ((hi <= at + SLACK && other_lo >= at - SLACK)
                || (lo >= at - SLACK && other_hi <= at + SLACK))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[(f64, f64)]) -> Outline {
        Outline::Polygon(corners.iter().map(|&c| c.into()).collect())
    }

    #[test]
    fn side_by_side_or_not() {
        let a = polygon(&[(0.0, 0.0), (1.0, 0.2), (0.1, 0.9)]);
        let shares_an_edge = polygon(&[(1.0, 0.2), (0.1, 0.9), (1.2, 1.1)]);
        let shares_a_corner = polygon(&[(1.0, 0.2), (1.2, -0.9), (1.3, 1.1)]);
        let overlaps = polygon(&[(0.9, 0.1), (0.0, 0.8), (1.2, 1.1)]);
        assert!(a.is_beside(&shares_an_edge) && shares_an_edge.is_beside(&a));
        assert!(a.is_beside(&shares_a_corner) && !a.is_beside(&overlaps) && !a.is_beside(&a));
        let disc = |x: f64, y: f64, radius: f64| Outline::Disc { center: DVec2::new(x, y), radius };
        assert!(disc(0.0, 0.0, 1.0).is_beside(&disc(2.0, 0.0, 1.0)));
        assert!(!disc(0.0, 0.0, 1.0).is_beside(&disc(1.4, 1.4, 1.0)));
        assert!(a.is_beside(&disc(1.0, 1.0, 0.4)) && disc(1.0, 1.0, 0.4).is_beside(&a));
        assert!(!a.is_beside(&disc(1.0, 1.0, 0.7)) && !disc(0.2, 0.2, 0.1).is_beside(&a));
        assert!(a.covers(DVec2::new(0.3, 0.3)) && !a.covers(DVec2::new(0.7, 0.7)));
    }
}
