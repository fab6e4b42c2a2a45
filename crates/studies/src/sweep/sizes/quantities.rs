//! Quantities plotted over the number of primitives, and their growth.

use measurement::record::scale::SlopeRecord;
use measurement::record::{RowRecord, SceneRecord};
use statistics::estimate::Estimate;
use statistics::power_law::power_law;

#[derive(Debug, Clone, Copy)]
pub struct Quantity {
    /// In records and CSV.
    pub name: &'static str,
    /// For plots, with its unit.
    pub label: &'static str,
    /// Its value with an interval, where the row has one.
    pub of: fn(&RowRecord) -> Option<Estimate>,
}

pub static QUANTITIES: [Quantity; 4] = [
    Quantity { name: "build", label: "build time (s)", of: |row| row.build_s },
    Quantity { name: "trace", label: "trace time per ray (s)", of: trace_s_per_ray },
    Quantity {
        name: "memory",
        label: "memory of the structure (bytes)",
        of: |row| Some(Estimate::exactly(row.stats.as_ref()?.memory_bytes as f64)),
    },
    Quantity {
        name: "peak",
        label: "peak memory of the build (bytes)",
        of: |row| Some(Estimate::exactly(row.peak_build_bytes? as f64)),
    },
];

/// Trace time of all kinds of rays over their number.
pub fn trace_s_per_ray(row: &RowRecord) -> Option<Estimate> {
    Some(row.trace_s?.map(|time| time / row.rays.max(1) as f64))
}

/// The points of a row over finished sizes: primitives and the quantity. Rows that are wrong, were
/// not built or are over a limit have none.
pub fn points(scenes: &[SceneRecord], like: &RowRecord, what: &Quantity) -> Vec<(f64, Estimate)> {
    let point = |scene: &SceneRecord| {
        let row = scene.rows.iter().find(|row| row.is_same(like))?;
        let value = (what.of)(row).filter(|_| row.verdict.is_timed())?;
        Some((scene.primitives as f64, value))
    };
    scenes.iter().filter_map(point).collect()
}

/// The rows of the scenes, each once.
pub fn rows(scenes: &[SceneRecord]) -> Vec<&RowRecord> {
    let mut rows: Vec<&RowRecord> = Vec::new();
    for row in scenes.iter().flat_map(|scene| &scene.rows) {
        if !rows.iter().any(|known| known.is_same(row)) {
            rows.push(row);
        }
    }
    rows
}

/// How all quantities of all rows grow over finished sizes, where there are two or more.
pub fn slopes(scenes: &[SceneRecord]) -> Vec<SlopeRecord> {
    let mut slopes = Vec::new();
    for row in rows(scenes) {
        for quantity in &QUANTITIES {
            let medians: Vec<(f64, f64)> =
                points(scenes, row, quantity).iter().map(|(x, y)| (*x, y.median)).collect();
            let Some(law) = power_law(&medians) else { continue };
            slopes.push(SlopeRecord {
                structure: row.structure.clone(),
                settings: row.settings.clone(),
                quantity: quantity.name.to_owned(),
                sizes: law.points as u64,
                slope: law.exponent,
                low: law.interval.map(|[low, _]| low),
                high: law.interval.map(|[_, high]| high),
            });
        }
    }
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::record::{Verdict, made_up};

    /// A row with build times n^2 and trace times that do not grow, in scenes of n primitives.
    fn scenes() -> Vec<SceneRecord> {
        let mut scenes = Vec::new();
        for n in [100_u64, 1000, 10_000, 100_000] {
            let mut scene =
                made_up::run(&[("s", &[("a", &[1.0]), ("b x=1", &[1.0])])]).scenes.remove(0);
            scene.primitives = n;
            for row in &mut scene.rows {
                row.build_s = Some(Estimate::exactly(1e-9 * (n * n) as f64));
                row.trace_s = Some(Estimate { median: 2.0, low: 1.0, high: 4.0 });
                row.stats.as_mut().unwrap().memory_bytes = 16 * n;
            }
            scenes.push(scene);
        }
        scenes
    }

    fn slope(scenes: &[SceneRecord], row: &str, quantity: &str) -> Option<SlopeRecord> {
        let all = slopes(scenes);
        let is = |s: &SlopeRecord| s.structure == row && s.quantity == quantity;
        all.into_iter().find(is)
    }

    #[test]
    fn quadratic_times_have_the_slope_two() {
        let scenes = scenes();
        let build = slope(&scenes, "b", "build").unwrap();
        assert!(build.low.unwrap() <= 2.0 + 1e-9 && build.high.unwrap() >= 2.0 - 1e-9, "{build:?}");
        assert!((build.slope - 2.0).abs() < 1e-9 && build.sizes == 4, "{build:?}");
        assert!(slope(&scenes, "b", "trace").unwrap().slope.abs() < 1e-9);
        assert!((slope(&scenes, "a", "memory").unwrap().slope - 1.0).abs() < 1e-9);
        assert_eq!(slope(&scenes, "a", "peak"), None, "nothing was measured");
        let per_ray = trace_s_per_ray(&scenes[0].rows[0]).unwrap();
        assert_eq!((per_ray.low, per_ray.high), (1.0 / 256.0, 4.0 / 256.0));
    }

    #[test]
    fn wrong_rows_and_rows_over_a_limit_have_no_points() {
        let mut scenes = scenes();
        scenes[1].rows[0].verdict = Verdict::Wrong;
        scenes[3].rows[0].verdict = Verdict::OverLimit;
        // what such a row took does not count, whatever it was
        scenes[1].rows[0].build_s = Some(Estimate::exactly(9e9));
        let build = slope(&scenes, "a", "build").unwrap();
        assert_eq!((build.sizes, build.low), (2, None));
        assert!((build.slope - 2.0).abs() < 1e-9);
        assert_eq!(slope(&scenes[..1], "a", "build"), None);
    }
}
