//! Rules for the number of voxels, safe for flat, tiny and stretched scenes.
//!
//! With N primitives, D voxels wanted per primitive, box sides s and volume V:
//! * *regular*: every axis gets (D N)^(1/3).
//! * *Woo* (A. Woo, "Ray tracing polygons using spatial subdivision", Graphics Interface 1992,
//!   as Havran and Sixta 1999 print it): the longest axis gets (D N)^(1/3), the others in
//!   proportion to their length.
//! * *heterogeneous* (K. Klimaszewski and T. Sederberg 1997, likewise): s_i (D N / V)^(1/3), so
//!   that voxels are cubes and there are D N of them.
//! * *density*: heterogeneous, but an axis too thin for one cube gets one voxel and the others
//!   share what it leaves, so that flat scenes have D N voxels as well.
//! * *average edge*: the voxel's side is the mean of the longest sides of the primitives' boxes.
//! * *cubic*: D N voxels that are cubes exactly: the longest axis gets a whole number of them, the
//!   others as many as cover the box, which [`divided_bounds`] grows to fit.
//! * *auto*: the D among 2^-4, 2^-3.5 ... 2^10 for which *density* costs least by this estimate. A
//!   random line that meets the box meets a voxel of surface A_v with probability A_v / A (Cauchy
//!   and Crofton), so it takes C A_v / A steps through C voxels and meets R A_v / A references,
//!   where R = N prod_i (w_i / c_i + 1) for boxes of side w in voxels of side c; w is the mean
//!   longest side, at most the scene's own. A test counts as much as [`TEST_COST`] steps. Where a
//!   ray ends early both shrink alike, so that is left out; so is clustering (as in J. Cleary and
//!   G. Wyvill, "Analysis of an algorithm for fast ray tracing using uniform space subdivision",
//!   The Visual Computer 4, 1988, from whom the idea is).
//!
//! Havran and Sixta's printed formulas do not give the resolutions they list, so reproducing
//! them takes the listed numbers ([`ResolutionRule::Fixed`]).

use std::fmt;
use std::str::FromStr;

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vec3, Vector};

/// A rule for the number of voxels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResolutionRule {
    /// Cubic voxels, D N of them, flat scenes too.
    Density,
    /// Longest axis (D N)^(1/3).
    Woo,
    /// s_i (D N / V)^(1/3).
    Heterogeneous,
    /// (D N)^(1/3) on every axis.
    Regular,
    /// Side = average longest side of a primitive's box.
    AverageEdge,
    Cubic,
    /// The cheapest by the estimate of the module's header.
    Auto,
    Fixed([u32; 3]),
}

impl ResolutionRule {
    /// Names of the rules that need no numbers.
    pub const NAMES: &'static [&'static str] =
        &["density", "woo", "heterogeneous", "regular", "average-edge", "cubic", "auto"];

    /// The rules of these names.
    const NAMED: [Self; 7] = [
        Self::Density,
        Self::Woo,
        Self::Heterogeneous,
        Self::Regular,
        Self::AverageEdge,
        Self::Cubic,
        Self::Auto,
    ];

    /// Returns whether the rule reads [`ResolutionInput::mean_longest_side`].
    pub fn reads_sides(self) -> bool {
        matches!(self, Self::AverageEdge | Self::Auto)
    }
}

impl FromStr for ResolutionRule {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(at) = Self::NAMES.iter().position(|name| *name == text) {
            return Ok(Self::NAMED[at]);
        }
        let parts: Option<Vec<u32>> =
            text.split('x').map(|n| n.parse().ok().filter(|&n| n > 0)).collect();
        match parts.as_deref() {
            Some(&[x, y, z]) => Ok(Self::Fixed([x, y, z])),
            Some(&[n]) => Ok(Self::Fixed([n; 3])),
            _ => Err(format!("expected one of {} or voxels like 64x64x16", Self::NAMES.join(", "))),
        }
    }
}

impl fmt::Display for ResolutionRule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Self::Fixed([x, y, z]) = self {
            return write!(f, "{x}x{y}x{z}");
        }
        let named = Self::NAMED.iter().zip(Self::NAMES).find(|(rule, _)| *rule == self);
        f.write_str(named.map_or("", |(_, name)| name))
    }
}

/// Input of a resolution rule.
#[derive(Debug, Clone, Copy)]
pub struct ResolutionInput<S: Scalar> {
    /// Box to be divided.
    pub bounds: Aabb<S>,
    /// Number of primitives, N.
    pub primitives: usize,
    /// Voxels per primitive, D.
    pub density: f64,
    /// Mean of the longest box sides of the primitives; read by *average edge* and *auto*, for
    /// which 0 means that primitives count as points.
    pub mean_longest_side: f64,
    /// Upper limit for the product.
    pub max_cells: u64,
    /// Smallest side of a cell, world units: below it rounding could not tell cells apart.
    pub smallest_cell: f64,
}

/// Largest number of voxels on one axis (indices must be exact in f32).
pub const MAX_PER_AXIS: u32 = 1 << 20;

/// [`resolve`] by the rule *density*, which is never refused: it keeps within `max_cells`.
pub(crate) fn resolve_by_density<S: Scalar>(
    bounds: Aabb<S>,
    primitives: usize,
    density: f64,
    max_cells: u64,
    smallest_cell: f64,
) -> [u32; 3] {
    let mean_longest_side = 0.0;
    let input = ResolutionInput {
        bounds,
        primitives,
        density,
        mean_longest_side,
        max_cells,
        smallest_cell,
    };
    resolve(ResolutionRule::Density, &input).unwrap_or([1; 3])
}

/// The number of voxels on each axis: at least 1, at most [`MAX_PER_AXIS`], the product at most
/// `max_cells` for every rule that computes them; `Err(product)` when a fixed one asks for more.
/// No rule makes cells smaller than `smallest_cell`: a flat axis gets one cell. What a formula asks
/// of flat scenes beyond 8 D N voxels (256 N for *average edge*) is scaled down.
pub fn resolve<S: Scalar>(
    rule: ResolutionRule,
    input: &ResolutionInput<S>,
) -> Result<[u32; 3], u128> {
    let size = input.bounds.size().to_array().map(|s| s.to_f64().max(0.0));
    let wanted = (input.density * input.primitives as f64).max(1.0);
    let longest = size.iter().copied().fold(0.0, f64::max);
    if !(longest > 0.0 && longest.is_finite()) {
        return Ok([1; 3]);
    }
    let most = size.map(|s| {
        let n = if input.smallest_cell > 0.0 { s / input.smallest_cell } else { f64::INFINITY };
        n.clamp(1.0, f64::from(MAX_PER_AXIS)) as u32
    });
    // a flat axis gets one voxel where a formula wants a fraction of one: the others must not make
    // up for it without end
    let in_proportion = match rule {
        ResolutionRule::AverageEdge => (256.0 * input.primitives as f64).max(f64::from(1 << 20)),
        _ => 8.0 * wanted + 64.0,
    };
    let max_cells = input.max_cells.min(in_proportion as u64);
    let real = match rule {
        ResolutionRule::Fixed(n) => {
            let product = n.iter().map(|&n| u128::from(n)).product::<u128>();
            return if product > u128::from(input.max_cells) || n.iter().any(|&n| n > MAX_PER_AXIS) {
                Err(product)
            } else {
                Ok(std::array::from_fn(|k| n[k].min(most[k])))
            };
        }
        ResolutionRule::Regular => [wanted.cbrt(); 3],
        ResolutionRule::Woo => size.map(|s| wanted.cbrt() * s / longest),
        ResolutionRule::Heterogeneous => {
            let side = (size.iter().product::<f64>() / wanted).cbrt();
            size.map(|s| if side > 0.0 { s / side } else { 1.0 })
        }
        ResolutionRule::Density => {
            let side = cube_side(size, wanted);
            size.map(|s| s / side)
        }
        ResolutionRule::AverageEdge => {
            let side =
                if input.mean_longest_side > 0.0 { input.mean_longest_side } else { longest };
            size.map(|s| s / side)
        }
        ResolutionRule::Cubic => return Ok(cubic(size, wanted, input.max_cells)),
        ResolutionRule::Auto => return Ok(cheapest(size, input)),
    };
    Ok(limited(std::array::from_fn(|k| real[k].min(f64::from(most[k]))), max_cells))
}

/// The box that a grid of `n` voxels under `rule` divides: `bounds`, grown at its upper end where
/// *cubic* voxels stand out.
pub fn divided_bounds<S: Scalar>(rule: ResolutionRule, bounds: Aabb<S>, n: [u32; 3]) -> Aabb<S> {
    if rule != ResolutionRule::Cubic {
        return bounds;
    }
    let size = bounds.size().to_array().map(S::to_f64);
    let side = (0..3).map(|k| size[k] / f64::from(n[k])).fold(0.0, f64::max);
    let (lo, hi) = (bounds.min.to_array(), bounds.max.to_array());
    let grown: [S; 3] = std::array::from_fn(|k| {
        S::from_f64(lo[k].to_f64() + side * f64::from(n[k])).greater(hi[k])
    });
    let grown = Aabb::<S> { min: bounds.min, max: Vec3::<S>::from_array(grown) };
    if grown.size().is_finite() { grown } else { bounds }
}

/// Cubes: as many on the longest axis as fit, on the others as many as cover the box.
fn cubic(size: [f64; 3], wanted: f64, max_cells: u64) -> [u32; 3] {
    let longest = size.iter().copied().fold(0.0, f64::max);
    let most = f64::from(MAX_PER_AXIS);
    let mut along = (longest / cube_side(size, wanted)).floor().clamp(1.0, most);
    loop {
        // a ratio that is whole but for its rounding is whole
        let n = size.map(|s| (s / longest * along - 1e-6).ceil().clamp(1.0, most) as u32);
        let product = n.iter().map(|&n| u128::from(n)).product::<u128>();
        if product <= u128::from(max_cells.max(1)) || along <= 1.0 {
            return n;
        }
        along = (along * 0.95).floor().max(1.0);
    }
}

/// Cost of a primitive test in traversal steps, for the estimate of *auto*.
pub const TEST_COST: f64 = 4.0;

/// Steps and tests that a random line is expected to take through `n` voxels, tests weighted.
fn estimated_cost(size: [f64; 3], n: [u32; 3], primitives: f64, mean_side: f64) -> f64 {
    let area = |s: [f64; 3]| s[0] * s[1] + s[1] * s[2] + s[2] * s[0];
    let cell: [f64; 3] = std::array::from_fn(|k| size[k] / f64::from(n[k]));
    let cells: f64 = n.iter().map(|&n| f64::from(n)).product();
    let spread = |k: usize| {
        if cell[k] > 0.0 {
            (mean_side.min(size[k]) / cell[k] + 1.0).min(f64::from(n[k]))
        } else {
            1.0
        }
    };
    let references = primitives * spread(0) * spread(1) * spread(2);
    area(cell) / area(size) * (cells + TEST_COST * references)
}

/// The resolution of the density that costs least.
fn cheapest<S: Scalar>(size: [f64; 3], input: &ResolutionInput<S>) -> [u32; 3] {
    // relative sizes: products of three would overflow or vanish in huge and tiny scenes
    let longest = size.iter().copied().fold(0.0, f64::max);
    let (size, mean_side) = (size.map(|s| s / longest), input.mean_longest_side / longest);
    let primitives = input.primitives as f64;
    let candidates = (-8..=20).map(|i| {
        let wanted = (f64::from(i) / 2.0).exp2() * primitives;
        let side = cube_side(size, wanted.max(1.0));
        let n = limited(size.map(|s| s / side), input.max_cells);
        (estimated_cost(size, n, primitives, mean_side), n)
    });
    candidates.min_by(|a, b| a.0.total_cmp(&b.0)).map_or([1; 3], |(_, n)| n)
}

/// The side of a cube such that `wanted` of them fill the box, when an axis thinner than a cube
/// holds one layer.
fn cube_side(size: [f64; 3], wanted: f64) -> f64 {
    let mut sorted = size;
    sorted.sort_by(f64::total_cmp);
    let [thin, middle, long] = sorted;
    let side3 = (thin * middle * long / wanted).cbrt();
    if side3 > 0.0 && side3 <= thin {
        return side3;
    }
    let side2 = (middle * long / wanted).sqrt();
    if side2 > 0.0 && side2 <= middle {
        return side2;
    }
    long / wanted
}

/// Truncates to whole voxels, at least one per axis, and scales down what exceeds the limits.
fn limited(real: [f64; 3], max_cells: u64) -> [u32; 3] {
    let whole = |r: [f64; 3]| r.map(|x| x.clamp(1.0, f64::from(MAX_PER_AXIS)) as u32);
    let product = |n: [u32; 3]| n.iter().map(|&n| u128::from(n)).product::<u128>();
    let mut real = real.map(|x| x.clamp(1.0, f64::from(MAX_PER_AXIS)));
    let mut n = whole(real);
    while product(n) > u128::from(max_cells.max(1)) {
        // shrink the axes that still have more than one voxel
        let free = n.iter().filter(|&&n| n > 1).count().max(1) as f64;
        let excess = product(n) as f64 / max_cells.max(1) as f64;
        let factor = excess.powf(-1.0 / free).min(0.999);
        real = real.map(|x| (x * factor).max(1.0));
        n = whole(real);
    }
    n
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, dvec3};

    fn input(size: DVec3, primitives: usize, density: f64) -> ResolutionInput<f64> {
        ResolutionInput {
            bounds: Aabb { min: DVec3::ZERO, max: size },
            primitives,
            density,
            mean_longest_side: 0.5,
            max_cells: 1 << 26,
            smallest_cell: 1e-12,
        }
    }

    #[test]
    fn rules_on_a_plain_box() {
        let i = input(dvec3(4.0, 2.0, 1.0), 4096, 1.0);
        let n = |rule| resolve(rule, &i).unwrap();
        assert_eq!(n(ResolutionRule::Regular), [16, 16, 16]);
        assert_eq!(n(ResolutionRule::Woo), [16, 8, 4]);
        assert_eq!(n(ResolutionRule::Density), [32, 16, 8]);
        assert_eq!(n(ResolutionRule::AverageEdge), [8, 4, 2]);
        assert_eq!(n(ResolutionRule::Fixed([5, 6, 7])), [5, 6, 7]);
    }

    #[test]
    fn flat_stretched_and_point_like_scenes() {
        // HARD_CASES Gr1, Gr2
        let n = |size, rule| resolve(rule, &input(size, 1000, 2.0)).unwrap();
        for &rule in ResolutionRule::NAMES {
            let rule: ResolutionRule = rule.parse().unwrap();
            for size in [
                dvec3(10.0, 0.0, 10.0),
                dvec3(1e9, 1.0, 1.0),
                dvec3(0.0, 0.0, 0.0),
                dvec3(1e-30, 1e-30, 1e-30),
                dvec3(1e30, 1e30, 1e30),
            ] {
                let n = n(size, rule);
                let product: u64 = n.iter().map(|&n| u64::from(n)).product();
                assert!(n.iter().all(|&n| n >= 1) && product <= 1 << 26, "{rule} {size} {n:?}");
            }
        }
        assert_eq!(n(dvec3(10.0, 0.0, 10.0), ResolutionRule::Density), [44, 1, 44]);
    }

    #[test]
    fn fixed_beyond_the_limit_is_refused_and_text_round_trips() {
        let i = input(DVec3::ONE, 10, 1.0);
        assert_eq!(resolve(ResolutionRule::Fixed([4096; 3]), &i), Err(1 << 36));
        for &text in ResolutionRule::NAMES.iter().chain(&["46x46x3"]) {
            assert_eq!(text.parse::<ResolutionRule>().unwrap().to_string(), text);
        }
        for text in ["", "0x1x1", "1x2", "cubical", "-3"] {
            assert!(text.parse::<ResolutionRule>().is_err(), "{text}");
        }
    }

    #[test]
    fn cubic_voxels_are_cubes_that_cover_the_box() {
        for size in [dvec3(4.0, 2.0, 1.0), dvec3(3.7, 2.9, 0.4), dvec3(10.0, 0.0, 3.0)] {
            let i = input(size, 5000, 3.0);
            let n = resolve(ResolutionRule::Cubic, &i).unwrap();
            let b = divided_bounds(ResolutionRule::Cubic, i.bounds, n);
            let cell: Vec<f64> = (0..3).map(|k| b.max[k] / f64::from(n[k])).collect();
            let side = cell[0];
            assert!(cell.iter().all(|c| (c - side).abs() < 1e-4 * side), "{size} {n:?} {cell:?}");
            assert!(b.max.cmpge(size).all());
            let product: u64 = n.iter().map(|&n| u64::from(n)).product();
            assert!((7_000..25_000).contains(&product), "{size} {n:?}");
        }
    }

    #[test]
    fn auto_takes_the_cheapest_density_of_its_estimate() {
        let with_side = |side| ResolutionInput {
            mean_longest_side: side,
            ..input(dvec3(4.0, 2.0, 1.0), 10_000, 1.0)
        };
        let cells = |side| {
            let n = resolve(ResolutionRule::Auto, &with_side(side)).unwrap();
            n.iter().map(|&n| u64::from(n)).product::<u64>()
        };
        // points: C^(1/3) + 4 N C^(-2/3) is least at C = 8 N; primitives of side w want no voxel
        // smaller than w / 2
        assert!((60_000..110_000).contains(&cells(0.0)), "{}", cells(0.0));
        assert!(cells(0.5) < 2_000, "{}", cells(0.5));
    }
}
