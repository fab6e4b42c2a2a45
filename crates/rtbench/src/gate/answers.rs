//! Stage: are the answers right, and still the same?
//!
//! Wrong hits are judged by the run itself, against its oracle. Beyond that the hashes of all
//! answers must be those of the baseline: ids and every bit of t.

use crate::comparison::pairing::RowPair;
use crate::gate::evidence::{Evidence, Finding, GateOutcome, Stage};
use measurement::record::Verdict;

pub const STAGE: Stage =
    Stage { name: "answers", summary: "no wrong hits; all answers as in the baseline", judge };

fn judge(evidence: &Evidence<'_>) -> Vec<Finding> {
    let of_row = |row: &RowPair<'_>| {
        let (outcome, note) = outcome(row);
        Finding::of(STAGE.name, row, "answers", outcome, note)
    };
    evidence.rows().iter().map(of_row).collect()
}

fn outcome(row: &RowPair<'_>) -> (GateOutcome, String) {
    let [base, now] = row.rows;
    let was_and_is = |was: &str, is: &str| format!("was {was}, is {is}");
    let verdicts = || was_and_is(base.verdict.name(), now.verdict.name());
    match now.verdict {
        Verdict::Wrong => {
            let (wrong, rays) = (now.mismatches, now.checked_rays);
            let example = now.example.as_deref().unwrap_or("no example");
            return (GateOutcome::WrongHits, format!("{wrong} of {rays} rays: {example}"));
        }
        v if !v.is_judged() => {
            let why = now.error.as_deref().unwrap_or(now.verdict.name());
            return if base.verdict == now.verdict {
                (GateOutcome::NotJudged, format!("{}: {why}", now.verdict.name()))
            } else {
                (GateOutcome::Regression, format!("{}: {why}", verdicts()))
            };
        }
        _ => {}
    }
    if now.mismatches > base.mismatches && now.checked_rays == base.checked_rays {
        let (was, is) = (base.mismatches.to_string(), now.mismatches.to_string());
        let note = format!("wrong hits by design: {}", was_and_is(&was, &is));
        return (GateOutcome::Regression, note);
    }
    if now.verdict != base.verdict {
        return (GateOutcome::Improved, verdicts());
    }
    if base.checked_rays != now.checked_rays {
        let (was, is) = (base.checked_rays.to_string(), now.checked_rays.to_string());
        let note = format!("other rays were checked: {}", was_and_is(&was, &is));
        return (GateOutcome::NotJudged, note);
    }
    match (&base.answers_sha256, &now.answers_sha256) {
        (Some(was), Some(is)) if was == is => (GateOutcome::Unchanged, String::new()),
        (Some(_), Some(_)) => (
            GateOutcome::Regression,
            "answers differ from the baseline's, though none is wrong".to_owned(),
        ),
        _ => (GateOutcome::NotJudged, "the baseline has no hash of answers".to_owned()),
    }
}
