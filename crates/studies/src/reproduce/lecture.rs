//! The two tables of Zachmann's lecture (2007, after Havran and Sixta 1999): build and run times of
//! five structures on seven scenes, beside ours.
//!
//! Seconds of two machines are never compared. Every time is divided by that of uniform D=1 on the
//! same machine; beside the ratios stands the rank correlation, and a sentence says who won then
//! and who wins now. [`SecondsTable`] has the seconds as the slides lay them out.

use crate::reproduce::published::Figure;
use measurement::record::{RowRecord, SceneRecord, Verdict};
use presentation::numbers::short;
use statistics::estimate::{Estimate, rank_correlation};

static TABLES: &str = include_str!("../../published/zachmann2007_tables.csv");

pub const SCENES: [&str; 7] = ["balls", "gears", "mount", "rings", "teapot", "tetra", "tree"];

/// The structures of Zachmann 2007 and what we put beside them; the first is the reference.
pub const STRUCTURES: [(&str, &str); 5] = [
    ("uniform D=1.0", "uniform-grid:resolution=heterogeneous:density=1"),
    ("uniform D=20.0", "uniform-grid:resolution=heterogeneous:density=20"),
    ("recursive", "recursive-grid"),
    ("hug", "hug"),
    ("adaptive", "adaptive-grid"),
];

/// Structure newer than the lecture, measured with the others.
pub const MODERN: &str = "obvhs-cwbvh";

/// All times of the lecture: seconds of structures on scenes, whose counters are [`SYMBOLS`].
pub fn published() -> Result<Vec<Figure>, csv::Error> {
    csv::Reader::from_reader(TABLES.as_bytes()).deserialize().collect()
}

/// Seconds that the lecture has in the table of that symbol.
fn seconds(all: &[Figure], structure: &str, scene: &str, symbol: &str) -> Option<f64> {
    let is_asked =
        |t: &&Figure| t.structure == structure && t.scene == scene && t.counter == symbol;
    all.iter().find(is_asked)?.value.parse().ok()
}

/// A time as the lecture has it and as measured, both divided by uniform D=1's.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Ratios {
    /// The lecture's, where it has one.
    pub then: Option<f64>,
    /// Ours, where the structure was built and right.
    pub now: Option<Estimate>,
}

/// The symbols of the slides' two tables: build, run.
pub const SYMBOLS: [&str; 2] = ["T_B[s]", "T_R[s]"];

/// Seconds by structure, each for all scenes in their order; none where there is no time.
pub type SecondsTable = Vec<(&'static str, Vec<Option<f64>>)>;

/// One of the slides' tables.
pub fn published_seconds(times: &[Figure], scenes: &[&str], symbol: &str) -> SecondsTable {
    let of = |name| scenes.iter().map(|scene| seconds(times, name, scene, symbol)).collect();
    STRUCTURES.map(|(name, _)| (name, of(name))).into()
}

/// The same table of measured scenes, whose rows are those of [`STRUCTURES`] and [`MODERN`]. Where
/// a part of the rays was timed, the time is multiplied to all of them.
pub fn measured_seconds(scenes: &[SceneRecord], symbol: &str) -> SecondsTable {
    let seconds = |scene: &SceneRecord, i: usize| {
        let row = scene.rows.get(i).filter(|row| row.verdict == Verdict::Ok)?;
        if symbol == SYMBOLS[0] {
            return row.build_s.map(|time| time.median);
        }
        let all: u64 = scene.rays.values().sum();
        row.trace_s.map(|time| time.median * all as f64 / row.rays.max(1) as f64)
    };
    let names = STRUCTURES.iter().map(|(name, _)| *name).chain([MODERN]).enumerate();
    let of = |i| scenes.iter().map(|scene| seconds(scene, i)).collect();
    names.map(|(i, name)| (name, of(i))).collect()
}

#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// As the lecture names it; none for the modern structure.
    pub lecture: Option<&'static str>,
    pub ours: String,
    pub verdict: Verdict,
    pub build: Ratios,
    /// Ratios of tracing all rays.
    pub run: Ratios,
}

/// A scene's part of both tables.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    pub scene: String,
    /// Lines in the lecture's order, the modern structure last.
    pub lines: Vec<Line>,
}

impl Comparison {
    /// Puts the lecture's times beside a measured scene. Rows of the record stand in the order of
    /// [`STRUCTURES`], then [`MODERN`].
    pub fn new(scene: &SceneRecord, published: &[Figure]) -> Self {
        let names = STRUCTURES.iter().map(|(name, _)| Some(*name)).chain([None]);
        let lines = names.zip(&scene.rows).map(|(lecture, row)| {
            let then = |symbol| {
                let ratio = Self::then(published, &scene.name, lecture?, symbol);
                ratio.filter(|r| r.is_finite())
            };
            let now = |ratio: Option<Estimate>| ratio.filter(|_| row.verdict == Verdict::Ok);
            Line {
                lecture,
                ours: RowRecord::label(row),
                verdict: row.verdict,
                build: Ratios { then: then(SYMBOLS[0]), now: now(row.build_ratio) },
                run: Ratios { then: then(SYMBOLS[1]), now: now(row.ratio) },
            }
        });
        Self { scene: scene.name.clone(), lines: lines.collect() }
    }

    fn then(published: &[Figure], scene: &str, name: &str, symbol: &str) -> Option<f64> {
        let seconds = |name| seconds(published, name, scene, symbol);
        Some(seconds(name)? / seconds(STRUCTURES[0].0)?)
    }

    /// Spearman's rank correlation of the lecture's ratios with ours; none with fewer than three
    /// pairs.
    pub fn correlation(&self, of: impl Fn(&Line) -> Ratios) -> Option<f64> {
        let pairs: Vec<(f64, f64)> = self
            .lines
            .iter()
            .map(of)
            .filter_map(|ratios| Some((ratios.then?, ratios.now?.median)))
            .collect();
        rank_correlation(&pairs)
    }

    /// One sentence: the winner then, the winner now, and the lead of the modern structure.
    pub fn sentence(&self) -> String {
        let of_lecture = || self.lines.iter().filter(|l| l.lecture.is_some());
        let then = of_lecture()
            .filter_map(|l| Some((l.lecture?, l.run.then?)))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let now = of_lecture()
            .filter_map(|l| Some((l.lecture?, l.run.now?)))
            .min_by(|a, b| a.1.median.total_cmp(&b.1.median));
        let (Some((then, by)), Some((now, ratio))) = (then, now) else {
            return format!("{}: no verdict: no correct, timed rows.", self.scene);
        };
        let ties: Vec<&str> = of_lecture()
            .filter(|l| l.lecture != Some(now))
            .filter(|l| l.run.now.is_some_and(|r| r.low <= ratio.high))
            .filter_map(|l| l.lecture)
            .collect();
        let mut text = format!(
            "{}: then {then} won, {} times as fast as uniform D=1; now {now} {}, {} times",
            self.scene,
            short(1.0 / by),
            if now == then { "still wins" } else { "wins" },
            short(1.0 / ratio.median),
        );
        if !ties.is_empty() {
            text += &format!(" (not significantly different from {})", ties.join(", "));
        }
        let modern = self.lines.iter().find(|l| l.lecture.is_none());
        if let Some((line, modern)) = modern.and_then(|l| Some((l, l.run.now?))) {
            let factor = ratio.median / modern.median;
            text += &if factor >= 1.0 {
                format!("; {} is {} times faster still", line.ours, short(factor))
            } else {
                format!("; {} is {} times slower", line.ours, short(1.0 / factor))
            };
        }
        text + "."
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(lecture: Option<&'static str>, then: Option<f64>, now: f64) -> Line {
        let now = Some(Estimate { median: now, low: now * 0.9, high: now * 1.1 });
        let run = Ratios { then, now };
        let (ours, verdict) = ("ours".to_owned(), Verdict::Ok);
        Line { lecture, ours, verdict, build: Ratios::default(), run }
    }

    #[test]
    fn the_lecture_s_tables_are_whole() {
        let all = published().unwrap();
        for scene in SCENES {
            for (name, _) in &STRUCTURES[..4] {
                for symbol in SYMBOLS {
                    assert!(Comparison::then(&all, scene, name, symbol).is_some());
                }
            }
        }
        let ratio = Comparison::then(&all, "tree", "adaptive", SYMBOLS[1]).unwrap();
        assert!((ratio - 18.38 / 1517.0).abs() < 1e-12);
        assert_eq!(Comparison::then(&all, "balls", "adaptive", SYMBOLS[1]), None);
        // as the slides have them: adaptive has no build times, and run times of four scenes
        let [build, run] = SYMBOLS.map(|symbol| published_seconds(&all, &SCENES, symbol));
        assert_eq!(build[0].1, [0.19, 0.38, 0.26, 0.35, 0.3, 0.13, 0.22].map(Some));
        assert_eq!(build[4], ("adaptive", vec![None; 7]));
        assert_eq!(run[4].1[2..], [None, Some(167.7), Some(43.04), Some(8.71), Some(18.38)]);
    }

    #[test]
    fn the_sentence_names_winners_and_ties() {
        let mut lines = vec![
            line(Some("uniform D=1.0"), Some(1.0), 1.0),
            line(Some("recursive"), Some(0.02), 0.03),
            line(Some("hug"), Some(0.03), 0.025),
            line(None, None, 0.0125),
        ];
        let comparison = Comparison { scene: "tree".into(), lines: lines.clone() };
        assert_eq!(
            comparison.sentence(),
            "tree: then recursive won, 50.0 times as fast as uniform D=1; now hug wins, 40.0 times \
             (not significantly different from recursive); ours is 2.00 times faster still."
        );
        assert_eq!(comparison.correlation(|l| l.run), Some(0.5));
        lines[2].run.now = None;
        let comparison = Comparison { scene: "tree".into(), lines: lines.clone() };
        assert!(comparison.sentence().contains("now recursive still wins, 33.3 times;"));
        assert_eq!(comparison.correlation(|l| l.run), None);
        lines.clear();
        assert!(Comparison { scene: "x".into(), lines }.sentence().contains("no verdict"));
    }
}
