//! Visible face at every point of a piece of the image: exact cutting, front to back.
//!
//! Papers: J. Warnock, "A Hidden Surface Algorithm for Computer Generated Halftone Pictures",
//! thesis, University of Utah, 1969 (a piece with much in it is halved, a face that covers a piece
//! hides all behind it); K. Weiler, P. Atherton, "Hidden Surface Removal Using Polygon Area
//! Sorting", SIGGRAPH 1977 (a piece is cut by the outline of a face, both parts go on), which is
//! what Heckbert and Hanrahan (1984) took for their beams. Deviations: pieces are convex, so that a
//! cut leaves several; faces that go through each other are cut where they do, so that cycles and
//! intersections need no order of depth. Of faces in one plane the lowest id is seen, as elsewhere.

use glam::DVec2;

use super::convex::{Affine, ConvexPolygon, CutSide};
use super::outline::{Outline, Relation};
use super::scene::{Counts, Settings};

/// Depths (1/s) that differ by less than this part are equal.
const SAME_DEPTH: f64 = 1e-10;

/// A piece of the image, and what is seen all over it: an index into the outlines, or nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Fragment {
    pub piece: ConvexPolygon,
    pub seen: Option<usize>,
}

/// A face that may be seen in a piece.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    index: usize,
    covers: bool,
}

struct Task {
    piece: ConvexPolygon,
    candidates: Vec<Candidate>,
}

/// Decides what is seen in a piece.
pub struct Visibility<'a> {
    outlines: &'a [Outline],
    settings: &'a Settings,
    todo: Vec<Task>,
    /// Pieces of this one that were cut.
    cut: u64,
    counts: &'a mut Counts,
    out: Vec<Fragment>,
}

/// Cuts `piece` into fragments, in each of which one of `outlines` or nothing is seen.
pub fn resolve(
    piece: ConvexPolygon,
    outlines: &[Outline],
    settings: &Settings,
    counts: &mut Counts,
) -> Vec<Fragment> {
    let candidates = (0..outlines.len()).map(|index| Candidate { index, covers: false }).collect();
    let todo = vec![Task { piece, candidates }];
    let mut this = Visibility { outlines, settings, todo, cut: 0, counts, out: Vec::new() };
    while let Some(task) = this.todo.pop() {
        this.step(task);
    }
    this.counts.cut += this.cut;
    this.out
}

impl Visibility<'_> {
    fn outline(&self, candidate: Candidate) -> &Outline {
        &self.outlines[candidate.index]
    }

    /// Emits the piece, or cuts it.
    fn step(&mut self, task: Task) {
        let Task { piece, mut candidates } = task;
        candidates.retain_mut(|c| {
            let relation =
                if c.covers { Relation::Covers } else { self.outline(*c).relation(&piece) };
            c.covers = relation == Relation::Covers;
            relation != Relation::Disjoint
        });
        let front = self.front_cover(&piece, &candidates);
        if let Some(front) = front {
            candidates.retain(|&c| c.index != front.index && self.is_before(c, front, &piece));
        }
        if candidates.is_empty() {
            return self.out.push(Fragment { piece, seen: front.map(|c| c.index) });
        }
        if self.cut >= self.settings.most_cuts {
            self.counts.unresolved += 1;
            let centre = piece.centroid();
            candidates.extend(front);
            let seen = self.front_at(centre, &candidates).map(|c| c.index);
            return self.out.push(Fragment { piece, seen });
        }
        if candidates.len() > self.settings.candidates
            && let Some(line) = halving_line(&piece)
        {
            candidates.extend(front);
            return self.cut_in_two(piece, &line, candidates);
        }
        if let (Some(front), Some(&other)) = (front, candidates.iter().find(|c| c.covers)) {
            // both cover the piece and go through each other
            let crossing = self.outline(other).depth.minus(&self.outline(front).depth).as_line();
            let is_cut = crossing.is_some_and(|line| matches!(piece.cut(&line), CutSide::Both(..)));
            let all = candidates.iter().copied().chain([front]);
            return match crossing {
                Some(line) if is_cut => self.cut_in_two(piece, &line, all.collect()),
                // as near as rounding can tell
                _ => {
                    let candidates = all.filter(|c| c.index != other.index).collect();
                    self.todo.push(Task { piece, candidates });
                }
            };
        }
        let Some(chosen) = self.chosen(&piece, &candidates) else { return };
        candidates.extend(front);
        self.cut_out(piece, chosen, candidates);
    }

    fn cut_in_two(&mut self, piece: ConvexPolygon, line: &Affine, candidates: Vec<Candidate>) {
        self.cut += 1;
        match piece.cut(line) {
            CutSide::Both(a, b) => {
                self.push(a, candidates.clone());
                self.push(b, candidates);
            }
            CutSide::Inside | CutSide::Outside => self.push(piece, candidates),
        }
    }

    fn cut_out(&mut self, piece: ConvexPolygon, chosen: Candidate, candidates: Vec<Candidate>) {
        let without: Vec<Candidate> =
            candidates.iter().copied().filter(|c| c.index != chosen.index).collect();
        let (inside, outside) = cut_along(&piece, &self.outline(chosen).lines);
        let Some(inside) = inside.filter(|i| i.area() > self.settings.least_area) else {
            return self.todo.push(Task { piece, candidates: without });
        };
        self.cut += 1;
        for part in outside {
            self.push(part, without.clone());
        }
        let mut candidates = without;
        candidates.push(Candidate { covers: true, ..chosen });
        self.push(inside, candidates);
    }

    fn push(&mut self, piece: ConvexPolygon, candidates: Vec<Candidate>) {
        if piece.area() > self.settings.least_area {
            self.todo.push(Task { piece, candidates });
        }
    }

    /// The covering face in front at the centre of the piece.
    fn front_cover(&self, piece: &ConvexPolygon, candidates: &[Candidate]) -> Option<Candidate> {
        let centre = piece.centroid();
        self.nearest(centre, candidates.iter().copied().filter(|c| c.covers))
    }

    fn front_at(&self, p: DVec2, candidates: &[Candidate]) -> Option<Candidate> {
        let holds =
            |c: &Candidate| c.covers || self.outline(*c).lines.iter().all(|line| line.at(p) >= 0.0);
        self.nearest(p, candidates.iter().copied().filter(holds))
    }

    fn nearest(&self, p: DVec2, candidates: impl Iterator<Item = Candidate>) -> Option<Candidate> {
        candidates.reduce(|best, other| {
            let (first, second) = (self.outline(best), self.outline(other));
            let (a, b) = (first.depth.at(p), second.depth.at(p));
            let same = (a - b).abs() <= SAME_DEPTH * a.abs();
            let wins = if same { second.id < first.id } else { b > a };
            if wins { other } else { best }
        })
    }

    /// False when the candidate is hidden by `front`, which covers the piece, wherever it may be.
    fn is_before(&self, candidate: Candidate, front: Candidate, piece: &ConvexPolygon) -> bool {
        let (own, other) = (self.outline(candidate), self.outline(front));
        let mut same = true;
        for p in piece.corners() {
            let (a, b) = (own.depth.at(*p), other.depth.at(*p));
            let tolerance = SAME_DEPTH * b.abs();
            if a - b > tolerance {
                return true;
            }
            same &= (a - b).abs() <= tolerance;
        }
        same && own.id < other.id
    }

    /// The candidate to cut along next: that in front at the centre, else that which would be.
    fn chosen(&self, piece: &ConvexPolygon, candidates: &[Candidate]) -> Option<Candidate> {
        let centre = piece.centroid();
        self.front_at(centre, candidates)
            .or_else(|| self.nearest(centre, candidates.iter().copied()))
    }
}

/// The part of a piece within some lines, if there is any, and the parts cut off.
pub fn cut_along(
    piece: &ConvexPolygon,
    lines: &[Affine],
) -> (Option<ConvexPolygon>, Vec<ConvexPolygon>) {
    let mut outside = Vec::new();
    let mut inside = piece.clone();
    for line in lines {
        match inside.cut(line) {
            CutSide::Inside => {}
            CutSide::Outside => return (None, outside),
            CutSide::Both(within, beyond) => {
                outside.push(beyond);
                inside = within;
            }
        }
    }
    (Some(inside), outside)
}

/// The border between pixels nearest to the middle of the longer side of a piece; none within a
/// pixel.
pub fn halving_line(piece: &ConvexPolygon) -> Option<Affine> {
    let [low, high] = piece.bounds();
    let size = high - low;
    let along = |axis: DVec2| {
        let (low, high) = (low.dot(axis), high.dot(axis));
        let border = ((low + high) * 0.5).round();
        (border > low + 1e-6 && border < high - 1e-6)
            .then_some(Affine { slope: axis, offset: -border })
    };
    let (longer, shorter) =
        if size.x >= size.y { (DVec2::X, DVec2::Y) } else { (DVec2::Y, DVec2::X) };
    along(longer).or_else(|| along(shorter))
}

#[cfg(test)]
mod tests {
    use super::super::faces::Face;
    use super::super::pyramid::Pyramid;
    use super::*;
    use glam::{DMat3, DVec3};

    /// An eye at the origin that sees (x, y, 1) at (x, y).
    fn outlines(faces: &[&[[f64; 3]]]) -> Vec<Outline> {
        let eye = Pyramid::new(DVec3::ZERO, DMat3::IDENTITY, 10.0).unwrap();
        let face = |(id, corners): (u32, &&[[f64; 3]])| Face {
            id,
            corners: corners.iter().map(|&c| DVec3::from_array(c)).collect(),
        };
        (0..)
            .zip(faces)
            .filter_map(|f| Outline::of(&face(f), &eye, [DVec2::ZERO, DVec2::splat(8.0)]))
            .collect()
    }

    /// Areas of what is seen of an 8 x 8 image: nothing, then every face.
    fn areas(faces: &[&[[f64; 3]]], candidates: usize) -> Vec<f64> {
        let settings = Settings { candidates, ..Settings::default() };
        let piece = ConvexPolygon::rectangle(DVec2::ZERO, DVec2::splat(8.0));
        let mut counts = Counts::default();
        let mut areas = vec![0.0; faces.len() + 1];
        let outlines = outlines(faces);
        for f in resolve(piece, &outlines, &settings, &mut counts) {
            areas[f.seen.map_or(0, |i| outlines[i].id as usize + 1)] += f.piece.area();
        }
        assert_eq!(counts.unresolved, 0);
        areas
    }

    fn check(faces: &[&[[f64; 3]]], expected: &[f64]) {
        for candidates in [0, 1, 100] {
            let areas = areas(faces, candidates);
            for (a, e) in areas.iter().zip(expected) {
                assert!((a - e).abs() < 1e-9, "{areas:?} {expected:?}");
            }
        }
    }

    /// A square from (x, y) to (x + size, y + size) as seen, at a depth.
    fn square(x: f64, y: f64, size: f64, z: f64) -> [[f64; 3]; 4] {
        [(x, y), (x + size, y), (x + size, y + size), (x, y + size)].map(|(x, y)| [x * z, y * z, z])
    }

    #[test]
    fn squares_hide_squares() {
        let (near, far) = (square(1.0, 1.0, 4.0, 1.0), square(3.0, 3.0, 4.0, 2.0));
        check(&[&near, &far], &[64.0 - 28.0, 16.0, 12.0]);
        check(&[&far, &near], &[64.0 - 28.0, 12.0, 16.0]);
        // twins in one plane: the lowest id
        let twin = square(3.0, 3.0, 4.0, 1.0);
        check(&[&near, &twin], &[36.0, 16.0, 12.0]);
        check(&[&twin, &near], &[36.0, 16.0, 12.0]);
        check(&[&near, &near], &[48.0, 16.0, 0.0]);
    }

    #[test]
    fn intersecting_faces_are_cut_at_the_intersection() {
        // at x = 4 both have depth 1
        let fall = [[0.0, 0.0, 0.5], [16.0, 0.0, 2.0], [16.0, 16.0, 2.0], [0.0, 4.0, 0.5]];
        let wall = square(0.0, 0.0, 8.0, 1.0);
        // 1/z of the first is affine: from 2 at u = 0 to 0.5 at u = 8: 1 at 16/3
        check(&[&fall, &wall], &[0.0, 64.0 * 2.0 / 3.0, 64.0 / 3.0]);
    }

    #[test]
    fn cycles_need_no_order() {
        // three bars, each over the next: depth 1 at one end, 3 at the other
        let bar = |angle: f64| {
            let turned = |(x, y, z): (f64, f64, f64)| {
                let p = DVec2::from_angle(angle).rotate(DVec2::new(x, y)) + DVec2::splat(4.0);
                [p.x * z, p.y * z, z]
            };
            [(-3.0, 0.5, 1.0), (3.0, 0.5, 3.0), (3.0, 1.2, 3.0), (-3.0, 1.2, 1.0)].map(turned)
        };
        let third = std::f64::consts::TAU / 3.0;
        let bars = [bar(0.0), bar(third), bar(2.0 * third)];
        let faces: Vec<&[[f64; 3]]> = bars.iter().map(|b| b.as_slice()).collect();
        let seen = areas(&faces, 100);
        assert!((seen.iter().sum::<f64>() - 64.0).abs() < 1e-9);
        // each is over one and under another, so that all show alike, and none all of its 4.2
        assert!((seen[1] - seen[2]).abs() < 1e-9 && (seen[1] - seen[3]).abs() < 1e-9, "{seen:?}");
        assert!(seen[1] < 4.1, "{seen:?}");
        check(&faces, &seen);
    }

    #[test]
    fn a_dropped_cut_is_caught() {
        let piece = ConvexPolygon::rectangle(DVec2::ZERO, DVec2::splat(8.0));
        let outline = &outlines(&[&square(1.0, 1.0, 4.0, 1.0)])[0];
        let (inside, outside) = cut_along(&piece, &outline.lines);
        let whole = inside.unwrap().area() + outside.iter().map(ConvexPolygon::area).sum::<f64>();
        assert!((whole - 64.0).abs() < 1e-12 && outside.len() == 4);
        // planted fault
        let dropped: f64 = outside.iter().skip(1).map(ConvexPolygon::area).sum();
        assert!((16.0 + dropped - 64.0).abs() > 1.0);
    }
}
