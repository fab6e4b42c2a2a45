//! Conclusions in words: one line per question, the same on the terminal, in Markdown and in a
//! report.

use std::fmt::Write;

use measurement::record::query::Query;
use measurement::record::{
    Conclusion, Defective, LeastTime, NextRow, Question, RunRecord, SceneRecord,
};
use presentation::numbers::short;
use statistics::estimate::Estimate;

const NAMES: usize = 3;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Line {
    /// The question in a few words.
    pub head: String,
    /// The row, its figure, and how it stands against the others.
    pub text: String,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lines {
    pub title: String,
    pub lines: Vec<Line>,
}

pub const NOTE: &str = "first image: build, one million primary rays and their shadow rays. next: \
                        the closest row that is significantly slower (or larger), and by what \
                        factor. A row with a known defect, or whose answers were not all \
                        compared and right, never leads; the fastest with a known defect is named \
                        with its wrong rays where it is closer than the next row.";

/// Lines over all scenes, or of the only scene; `None` for a run without finished scenes.
pub fn of_run(run: &RunRecord) -> Option<Lines> {
    match &run.scenes[..] {
        [] => None,
        [scene] => Some(of_scene(scene)),
        scenes => Some(Lines {
            title: format!("Answers over {} scenes (geometric means)", scenes.len()),
            lines: lines(&run.conclusions, &[]),
        }),
    }
}

pub fn of_scene(scene: &SceneRecord) -> Lines {
    Lines {
        title: format!("Answers for {} ({} primitives)", scene.name, scene.primitives),
        lines: lines(&scene.conclusions, &scene.least_time),
    }
}

fn lines(conclusions: &[Conclusion], least_time: &[LeastTime]) -> Vec<Line> {
    let mut lines: Vec<Line> = conclusions.iter().map(line).collect();
    lines.extend(build_pays(least_time));
    if lines.is_empty() {
        lines.push(Line {
            head: "none".into(),
            text: "each row has a known defect, or answers that are wrong or were not compared"
                .into(),
        });
    }
    lines
}

fn line(conclusion: &Conclusion) -> Line {
    let Conclusion { question, query, row, figure, not_different, next, defective } = conclusion;
    let head = match question {
        Question::FirstImage => "first image".to_owned(),
        Question::Memory => "least memory".to_owned(),
        Question::Trace(kind) => match kind.split_once('-') {
            Some((kind, order)) => format!("{kind} rays, {order}"),
            None => format!("{kind} rays"),
        },
    };
    let is_batch = *query == Query::Batch && *question != Question::Memory;
    let figure = match question {
        Question::FirstImage => duration(figure),
        Question::Trace(_) => {
            let rate = figure.inverse();
            with_interval(&rate, 1e-6, "Mrays/s")
        }
        Question::Memory => bytes(figure.median),
    };
    let mut text = format!("{row} {figure}");
    if !not_different.is_empty() {
        let _ = write!(text, "; {}", names("not significantly different:", not_different));
    }
    match next {
        Some(NextRow { row, times }) if times.low == times.high => {
            let _ = write!(text, "; next: {row} {} x", short(times.median));
        }
        Some(NextRow { row, times }) => {
            let _ =
                write!(text, "; next: {row} {} x {}", short(times.median), interval(times, 1.0));
        }
        None if not_different.is_empty() => text += "; no other row to compare with",
        None => {}
    }
    // the fastest of them; the record has all
    if let Some(Defective { row, times, wrong, rays }) = defective.first() {
        let what = match (times.low, times.high) {
            (_, high) if high < 1.0 => "faster",
            (low, _) if low <= 1.0 => "as fast",
            _ => "closer",
        };
        let defect = match wrong {
            0 => format!("a known defect that none of {} rays met", thousands(*rays)),
            _ => wrong_rays(*wrong, *rays),
        };
        let _ = write!(text, "; {what}, with {defect}: {row} {} x", short(times.median));
    }
    Line { head: if is_batch { format!("{head}, batch") } else { head }, text }
}

/// `1 wrong ray of 203,423`
pub fn wrong_rays(wrong: u64, rays: u64) -> String {
    let word = if wrong == 1 { "ray" } else { "rays" };
    format!("{} wrong {word} of {}", thousands(wrong), thousands(rays))
}

fn thousands(n: u64) -> String {
    match n / 1000 {
        0 => n.to_string(),
        more => format!("{},{:03}", thousands(more), n % 1000),
    }
}

/// From how many rays on a build that takes longer is worth it.
fn build_pays(least_time: &[LeastTime]) -> Option<Line> {
    let mut rows = least_time.iter();
    let mut text = rows.next()?.row.clone();
    if least_time.len() == 1 {
        text += " takes the least time, build included, for any number of rays";
    }
    for LeastTime { row, from_rays, low, high } in rows {
        let high = high.map_or("never".to_owned(), count);
        let (from, low) = (count(*from_rays), count(*low));
        let _ = write!(text, "; from {from} rays [{low}, {high}] {row}");
    }
    Some(Line { head: "break-even".into(), text })
}

/// A few names, and how many more there are.
pub fn names(before: &str, all: &[String]) -> String {
    let mut text = before.to_owned();
    for (i, name) in all.iter().take(NAMES).enumerate() {
        let _ = write!(text, "{} {name}", if i == 0 { "" } else { "," });
    }
    if all.len() > NAMES {
        let _ = write!(text, " and {} more", all.len() - NAMES);
    }
    text
}

/// A number of rays, three digits and a letter.
pub fn count(rays: f64) -> String {
    match rays {
        n if n.is_infinite() => "never".to_owned(),
        n if n >= 999.5e9 => format!("{n:.1e}"),
        n if n >= 999.5e6 => format!("{} G", short(n / 1e9)),
        n if n >= 999.5e3 => format!("{} M", short(n / 1e6)),
        n if n >= 999.5 => format!("{} k", short(n / 1e3)),
        n => n.ceil().to_string(),
    }
}

/// Seconds with the unit that suits them.
pub fn seconds(seconds: f64) -> String {
    let (scale, unit) = unit_of(seconds);
    format!("{} {unit}", short(seconds * scale))
}

fn duration(estimate: &Estimate) -> String {
    let (scale, unit) = unit_of(estimate.median);
    with_interval(estimate, scale, unit)
}

fn unit_of(seconds: f64) -> (f64, &'static str) {
    match seconds {
        s if s < 1e-3 => (1e6, "us"),
        s if s < 1.0 => (1e3, "ms"),
        _ => (1.0, "s"),
    }
}

fn with_interval(estimate: &Estimate, scale: f64, unit: &str) -> String {
    format!("{} {unit} {}", short(estimate.median * scale), interval(estimate, scale))
}

fn interval(estimate: &Estimate, scale: f64) -> String {
    format!("[{}, {}]", short(estimate.low * scale), short(estimate.high * scale))
}

fn bytes(bytes: f64) -> String {
    match bytes {
        n if n < 1024.0 => format!("{} bytes", short(n)),
        n if n < 1024.0 * 1024.0 => format!("{} KiB", short(n / 1024.0)),
        n => format!("{} MiB", short(n / 1024.0 / 1024.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn conclusion(question: Question) -> Conclusion {
        Conclusion {
            question,
            query: Query::OneRay,
            row: "bvh".into(),
            figure: Estimate { median: 0.04, low: 0.039, high: 0.05 },
            not_different: Vec::new(),
            next: None,
            defective: Vec::new(),
        }
    }

    #[test]
    fn a_rival_with_a_known_defect_is_named_with_it() {
        let with = |wrong, low, high| {
            let times = Estimate { median: f64::midpoint(low, high), low, high };
            let rival = Defective { row: "honest".into(), times, wrong, rays: 203_423 };
            let image = conclusion(Question::FirstImage);
            line(&Conclusion { defective: vec![rival], ..image }).text
        };
        let of = |low, high| with(1, low, high);
        let unmet = "; faster, with a known defect that none of 203,423 rays met: honest 0.90 x";
        assert!(with(0, 0.85, 0.95).ends_with(unmet));
        assert!(of(0.99, 1.01).ends_with("; as fast, with 1 wrong ray of 203,423: honest 1.00 x"));
        assert!(of(0.85, 0.95).ends_with("; faster, with 1 wrong ray of 203,423: honest 0.90 x"));
        assert!(of(1.05, 1.15).ends_with("; closer, with 1 wrong ray of 203,423: honest 1.10 x"));
        assert_eq!(wrong_rays(1_000_007, 12), "1,000,007 wrong rays of 12");
    }

    #[test]
    fn every_line_has_its_figure_and_the_next_row() {
        let times = Estimate { median: 1.25, low: 1.2, high: 1.31 };
        let next = Some(NextRow { row: "grid".into(), times });
        let of = |c: Conclusion| {
            let Line { head, text } = line(&c);
            format!("{head}: {text}")
        };
        let image = conclusion(Question::FirstImage);
        assert_eq!(
            of(Conclusion { next: next.clone(), ..image.clone() }),
            "first image: bvh 40.0 ms [39.0, 50.0]; next: grid 1.25 x [1.20, 1.31]"
        );
        let not_different: Vec<String> = ["a", "b", "c", "d"].map(str::to_owned).into();
        assert_eq!(
            of(Conclusion { not_different, ..image.clone() }),
            "first image: bvh 40.0 ms [39.0, 50.0]; not significantly different: a, b, c and 1 more"
        );
        assert_eq!(
            of(Conclusion {
                query: Query::Batch,
                ..conclusion(Question::Trace("shadow-shuffled".into()))
            }),
            "shadow rays, shuffled, batch: bvh 2.5e-5 Mrays/s [2.0e-5, 2.6e-5]; no other row to \
             compare with"
        );
        let memory = Conclusion {
            figure: Estimate::exactly(3.0 * 1024.0 * 1024.0),
            next: Some(NextRow { row: "grid".into(), times: Estimate::exactly(2.0) }),
            ..conclusion(Question::Memory)
        };
        assert_eq!(of(memory), "least memory: bvh 3.00 MiB; next: grid 2.00 x");
    }

    #[test]
    fn break_even_counts_are_numbers_or_never() {
        let at =
            |row: &str, from_rays, low, high| LeastTime { row: row.into(), from_rays, low, high };
        let alone = [at("grid", 0.0, 0.0, None)];
        assert!(build_pays(&alone).unwrap().text.contains("for any number of rays"));
        let three =
            [alone[0].clone(), at("kd", 1234.0, 1100.0, Some(1500.0)), at("bvh", 5e6, 4e6, None)];
        assert_eq!(
            build_pays(&three).unwrap().text,
            "grid; from 1.23 k rays [1.10 k, 1.50 k] kd; from 5.00 M rays [4.00 M, never] bvh"
        );
        assert_eq!(build_pays(&[]), None);
        assert_eq!(lines(&[], &[])[0].head, "none");
    }

    #[test]
    fn counts_and_durations_are_short() {
        for (n, text) in [
            (0.0, "0"),
            (0.2, "1"),
            (999.0, "999"),
            (12_345.0, "12.3 k"),
            (2e6, "2.00 M"),
            (3e9, "3.00 G"),
        ] {
            assert_eq!(count(n), text);
        }
        assert_eq!(count(f64::INFINITY), "never");
        assert_eq!(seconds(0.0123), "12.3 ms");
        assert_eq!(seconds(2e-6), "2.00 us");
        assert_eq!((bytes(100.0).as_str(), bytes(2048.0).as_str()), ("100 bytes", "2.00 KiB"));
    }
}
