//! Surfaces within one cone, combined front to back: which share of it each is seen in.
//!
//! Paper: J. Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984, which keeps the nearest few
//! intersections sorted by depth and adds what they cover until the cone is full. Deviations:
//! adding is right where outlines lie side by side, and whether they do is tested; where they
//! overlap, the one behind is thought hidden in proportion (independent, as alpha compositing has
//! it: T. Porter, T. Duff, "Compositing Digital Images", SIGGRAPH 1984), and the combination says
//! that it is not certain.

use glam::DVec2;

use super::coverage::Coverage;

/// A cone is full when so little of it is left: the slack of as many abutting outlines.
const LEFT_OVER: f64 = 1e-6;

/// So many surfaces are compared pair by pair; more, in wide cones, are added as the paper does,
/// and that is not certain.
const MOST_COMPARED: usize = 64;

/// A surface within a cone.
#[derive(Debug, Clone, PartialEq)]
pub struct Fragment {
    pub id: u32,
    /// How deep it is in the middle of what it covers.
    pub depth: f64,
    pub coverage: Coverage,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VisibleSurface {
    /// Index into the fragments.
    pub fragment: usize,
    /// Share of the cone, in (0, 1].
    pub share: f64,
    /// The middle of what is seen of it.
    pub centroid: DVec2,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Composition {
    /// From front to back. The shares are at most 1 together; the rest is background.
    pub seen: Vec<VisibleSurface>,
    /// False where surfaces overlap or cross, so that the shares are guesses.
    pub is_certain: bool,
    /// Share that nothing covers.
    pub left_over: f64,
}

/// Combines fragments, which it sorts. `depth_at`: of a primitive at a place of the cone.
pub fn compose(
    fragments: &mut [Fragment],
    depth_at: &dyn Fn(u32, DVec2) -> Option<f64>,
) -> Composition {
    fragments.sort_by(|a, b| a.depth.total_cmp(&b.depth).then(a.id.cmp(&b.id)));
    let fragments = &*fragments;
    let is_whole = |f: &Fragment| f.coverage.overlap.share >= 1.0;
    let nearest_whole = fragments.iter().find(|f| is_whole(f));
    let are_compared = fragments.len() <= MOST_COMPARED;
    let mut seen: Vec<VisibleSurface> = Vec::new();
    // the whole one, which gets what is free in the end, has a place among those seen
    let (mut is_certain, mut free, mut whole) = (are_compared, 1.0, None);
    for (index, fragment) in fragments.iter().enumerate() {
        let Coverage { overlap, outline, doubtful, .. } = &fragment.coverage;
        if is_whole(fragment) {
            if let Some(nearest) = nearest_whole.filter(|nearest| nearest.id != fragment.id) {
                is_certain &= !crosses(nearest.id, fragment.id, depth_at);
            } else if whole.is_none() && free > 0.0 {
                is_certain &= !doubtful;
                whole = Some(seen.len());
                seen.push(VisibleSurface { fragment: index, share: 0.0, centroid: DVec2::ZERO });
            }
            continue;
        }
        // behind the whole one: hidden. A surface at a slant may be in front and yet sorted after
        if nearest_whole.is_some_and(|whole| in_front_of(whole, fragment, depth_at)) {
            continue;
        }
        // in front of a whole one that came first, or is still to come, there is room
        let has_room = whole.is_some() || free <= 0.0 && nearest_whole.is_some();
        if free <= LEFT_OVER && !has_room {
            let is_hidden = || {
                let covering = seen.iter().map(|s| &fragments[s.fragment]);
                let mut covering = covering.filter(|f| f.coverage.outline.covers(overlap.centroid));
                covering.next().is_none_or(|f| in_front_of(f, fragment, depth_at))
            };
            is_certain = is_certain && is_hidden();
            continue;
        }
        is_certain &= !doubtful;
        let mut hidden = 0.0;
        if are_compared {
            for s in &seen {
                let before = &fragments[s.fragment];
                if !is_whole(before) && !before.coverage.outline.is_beside(outline) {
                    hidden += s.share;
                    is_certain = false;
                }
            }
        }
        let wanted = overlap.share * (1.0 - f64::min(hidden, 1.0));
        let share = wanted.min(free);
        if share > 0.0 {
            seen.push(VisibleSurface { fragment: index, share, centroid: overlap.centroid });
            free -= share;
        }
    }
    if let Some(at) = whole {
        let others = seen.iter().enumerate().filter(|(k, _)| *k != at);
        let centroid = rest(others.map(|(_, s)| *s));
        seen[at] = VisibleSurface { share: free, centroid, ..seen[at] };
        free = 0.0;
    }
    seen.retain(|s| s.share > 0.0);
    Composition { seen, is_certain, left_over: free }
}

/// Returns whether a surface is in front of another where the middle of that one is.
fn in_front_of(
    front: &Fragment,
    behind: &Fragment,
    depth_at: &dyn Fn(u32, DVec2) -> Option<f64>,
) -> bool {
    let depth = depth_at(front.id, behind.coverage.overlap.centroid);
    depth.is_some_and(|depth| depth < behind.depth)
}

/// The middle of what others leave of the disc.
fn rest(others: impl Iterator<Item = VisibleSurface>) -> DVec2 {
    let (covered, moment) = others.fold((0.0, DVec2::ZERO), |(covered, moment), s| {
        (covered + s.share, moment + s.centroid * s.share)
    });
    let rest = 1.0 - covered;
    if rest > LEFT_OVER { (moment / -rest).clamp_length_max(1.0) } else { DVec2::ZERO }
}

/// Returns whether the one behind comes to the front anywhere within the cone: looked at in four
/// places.
fn crosses(front: u32, behind: u32, depth_at: &dyn Fn(u32, DVec2) -> Option<f64>) -> bool {
    [(0.7, 0.0), (-0.7, 0.0), (0.0, 0.7), (0.0, -0.7)].into_iter().any(|place| {
        let place = DVec2::from(place);
        match (depth_at(front, place), depth_at(behind, place)) {
            (Some(front), Some(behind)) => behind < front,
            _ => false,
        }
    })
}

/// Share of a cone covered by surfaces together, in any order, and whether that is certain.
pub fn union(fragments: &[Fragment]) -> (f64, bool) {
    let are_compared = fragments.len() <= MOST_COMPARED;
    let (mut covered, mut is_certain) = (0.0, are_compared);
    for (index, fragment) in fragments.iter().enumerate() {
        let Coverage { overlap, outline, .. } = &fragment.coverage;
        let overlapping = |f: &&Fragment| are_compared && !f.coverage.outline.is_beside(outline);
        let before = fragments[..index].iter().filter(overlapping);
        let hidden: f64 = before.map(|f| f.coverage.overlap.share).sum();
        is_certain &= hidden == 0.0;
        covered += overlap.share * (1.0 - hidden.min(1.0));
    }
    (covered.min(1.0), is_certain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracers::cone::coverage::Outline;
    use crate::tracers::cone::disc_overlap::{of_disc, of_polygon};

    fn fragment(id: u32, depth: f64, outline: Outline) -> Fragment {
        let overlap = match &outline {
            Outline::Disc { center, radius } => of_disc(*center, *radius),
            Outline::Polygon(corners) => of_polygon(corners),
        };
        Fragment { id, depth, coverage: Coverage { overlap, outline, far: depth, doubtful: false } }
    }

    fn band(id: u32, depth: f64, from: f64, to: f64) -> Fragment {
        let corners = [(from, -9.0), (to, -9.0), (to, 9.0), (from, 9.0)].map(DVec2::from);
        fragment(id, depth, Outline::Polygon(corners.to_vec()))
    }

    /// Surfaces across, each at its own depth.
    fn composed(mut fragments: Vec<Fragment>) -> (Vec<(u32, f64)>, Composition) {
        let depths: Vec<(u32, f64)> = fragments.iter().map(|f| (f.id, f.depth)).collect();
        let depth_at =
            |id: u32, _: DVec2| depths.iter().find(|d| d.0 == id).map(|&(_, depth)| depth);
        let found = compose(&mut fragments, &depth_at);
        (found.seen.iter().map(|s| (fragments[s.fragment].id, s.share)).collect(), found)
    }

    #[test]
    fn abutting_surfaces_add_up_and_hide_those_behind() {
        let halves =
            || vec![band(0, 1.0, -9.0, 0.2), band(1, 1.1, 0.2, 9.0), band(2, 2.0, -9.0, 9.0)];
        let (seen, found) = composed(halves());
        assert!(found.is_certain && seen.len() <= 3);
        let shares: f64 = seen.iter().filter(|s| s.0 < 2).map(|s| s.1).sum();
        assert!((shares - 1.0).abs() < 1e-9, "{seen:?}");
        // planted fault: abutting surfaces that are multiplied let the one behind through
        let multiplied: f64 =
            halves()[..2].iter().map(|f| 1.0 - f.coverage.overlap.share).product();
        assert!(multiplied > 0.2, "{multiplied}");
        // the order of arrival does not matter
        let mut reversed = halves();
        reversed.reverse();
        assert_eq!(composed(reversed).1, found);
    }

    #[test]
    fn partial_fragments_hide_their_share_of_the_one_behind() {
        let (seen, found) = composed(vec![band(7, 5.0, -9.0, 9.0), band(3, 1.0, 0.0, 9.0)]);
        assert_eq!(seen.iter().map(|s| s.0).collect::<Vec<_>>(), [3, 7]);
        assert!(found.is_certain && seen.iter().all(|s| (s.1 - 0.5).abs() < 1e-9), "{seen:?}");
        // what is seen of the one behind is the other half
        assert!((found.seen[0].centroid + found.seen[1].centroid).length() < 1e-9);
        // behind it: nothing
        let (seen, _) = composed(vec![band(7, 5.0, -9.0, 9.0), band(3, 6.0, 0.0, 9.0)]);
        assert_eq!(seen, [(7, 1.0)]);
    }

    #[test]
    fn overlaps_are_not_certain_and_never_more_than_all() {
        let (seen, found) = composed(vec![band(0, 1.0, -9.0, 0.3), band(1, 2.0, -0.3, 9.0)]);
        assert!(!found.is_certain);
        let sum: f64 = seen.iter().map(|s| s.1).sum();
        assert!(sum <= 1.0 && sum > 0.7, "{seen:?}");
        // planted fault: without clamping, more than all would be seen
        let unclamped = 2.0 * seen[0].1;
        assert!(unclamped > 1.0);
        let many: Vec<Fragment> = (0..9).map(|k| band(k, f64::from(k), -0.5, 0.9)).collect();
        let (seen, _) = composed(many.clone());
        assert!(seen.iter().map(|s| s.1).sum::<f64>() <= 1.0);
        let (share, is_certain) = union(&many);
        assert!(share <= 1.0 && !is_certain);
        assert!(union(&[band(0, 1.0, -9.0, 0.2), band(1, 1.1, 0.2, 9.0)]).1);
    }

    #[test]
    fn depths_of_slanted_fragments_are_compared_at_the_other_one() {
        // at the middle of the second the first one, a floor, is deeper than at its own middle
        let mut fragments = vec![band(0, 3.0, -9.0, 9.0), band(1, 4.0, 0.0, 9.0)];
        let depth_at =
            |id: u32, place: DVec2| Some(if id == 0 { 3.0 + 5.0 * place.x } else { 4.0 });
        let found = compose(&mut fragments, &depth_at);
        let seen: Vec<(u32, f64)> =
            found.seen.iter().map(|s| (fragments[s.fragment].id, s.share)).collect();
        assert_eq!(seen.len(), 2);
        assert!(seen.iter().all(|s| (s.1 - 0.5).abs() < 1e-9), "{seen:?}");
    }
}
