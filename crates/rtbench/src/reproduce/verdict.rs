//! How close is ours to what was published? One rule a counter, for all scenes alike.

use std::fmt;

/// The judgement of one figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Equal as printed.
    Exact,
    /// Within the counter's tolerance.
    Within,
    /// Outside, and why is known.
    KnownReason(&'static str),
    /// Outside, and nobody knows why.
    Unexplained,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exact => f.write_str("exact"),
            Self::Within => f.write_str("within tolerance"),
            Self::KnownReason(why) => write!(f, "differs: {why}"),
            Self::Unexplained => f.write_str("differs: unexplained"),
        }
    }
}

/// Largest relative deviation that counts as reproduced; 0 asks for equality.
pub fn tolerance(structure: &str, counter: &str) -> f64 {
    match (structure, counter) {
        ("invariants", _) => 0.003,
        ("uniform", "N_EV" | "N_OIV") => 0.025,
        ("uniform", "N_TS" | "N_ETS") => 0.005,
        ("uniform", "N_EETS") => 0.012,
        ("uniform" | "recursive", "N_IT") => 0.03,
        ("recursive", "N_IN" | "N_V" | "N_EV" | "N_OIV") => 0.0002,
        ("recursive", "N_TS" | "N_ETS" | "N_EETS") => 0.01,
        _ => 0.0,
    }
}

const CONE_BOX: &str = "the original's box of cones and cylinders is not known";

/// Deviations whose cause is known: structure, setting (empty: all), scene, counters, why. Only where the figure is outside its tolerance do they speak.
static KNOWN: &[(&str, &str, &str, &[&str], &str)] = &[
    (
        "uniform",
        "woo D=10.0",
        "gears",
        &["N_OIV"],
        "quads that end exactly on a cell plane; the original's rounding there is not known",
    ),
    (
        "uniform",
        "customary",
        "lattice",
        &["N_OIV", "N_EETS", "N_IT"],
        "cylinder ends on cell planes; the original's cone box is not known",
    ),
    ("recursive", "", "rings", &["N_IN", "N_V", "N_EV", "N_OIV"], CONE_BOX),
    ("recursive", "", "tree", &["N_IN", "N_V", "N_EV", "N_OIV"], CONE_BOX),
    (
        "recursive",
        "",
        "gears",
        &["N_IT", "N_TS", "N_ETS", "N_EETS"],
        "the original's rule for shadow rays that meet glass is not fully known",
    ),
];

/// Judges one figure. `published` is the text as printed, which tells its number of decimals.
pub fn judge(
    structure: &str,
    params: &str,
    scene: &str,
    counter: &str,
    published: &str,
    ours: f64,
) -> Verdict {
    let Ok(value) = published.parse::<f64>() else { return Verdict::Unexplained };
    let decimals = published.split_once('.').map_or(0, |(_, d)| d.len());
    let half_digit = if decimals == 0 { 0.0 } else { 0.5 * 0.1f64.powi(decimals as i32) };
    let difference = (ours - value).abs();
    // a printed digit may have been rounded either way
    if difference <= half_digit * (1.0 + 1e-9) {
        return Verdict::Exact;
    }
    if difference - half_digit <= tolerance(structure, counter) * value.abs() {
        return Verdict::Within;
    }
    KNOWN
        .iter()
        .find(|(s, p, sc, counters, _)| {
            *s == structure
                && (p.is_empty() || *p == params)
                && *sc == scene
                && counters.contains(&counter)
        })
        .map_or(Verdict::Unexplained, |(.., why)| Verdict::KnownReason(why))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_within_known_unexplained() {
        let j = |params, scene, counter, published, ours| {
            judge("uniform", params, scene, counter, published, ours)
        };
        assert_eq!(j("woo D=1.0", "balls", "N_V", "6348", 6348.0), Verdict::Exact);
        assert_eq!(j("woo D=1.0", "balls", "N_V", "6348", 6349.0), Verdict::Unexplained);
        assert_eq!(j("woo D=1.0", "balls", "N_IT", "39.76", 39.764), Verdict::Exact);
        assert_eq!(j("woo D=1.0", "balls", "N_IT", "39.76", 40.9), Verdict::Within);
        assert_eq!(j("woo D=1.0", "balls", "N_IT", "39.76", 41.0), Verdict::Unexplained);
        assert!(matches!(j("woo D=10.0", "gears", "N_OIV", "100", 106.8), Verdict::KnownReason(_)));
        assert_eq!(j("woo D=10.0", "balls", "N_OIV", "100", 106.8), Verdict::Unexplained);
        let j = |scene, ours| judge("recursive", "RMD=3 RHT=+", scene, "N_V", "10000", ours);
        assert_eq!(j("mount", 10002.0), Verdict::Within);
        assert_eq!(j("mount", 10003.0), Verdict::Unexplained);
        assert!(matches!(j("tree", 10003.0), Verdict::KnownReason(_)));
        assert_eq!(judge("", "", "", "N_V", "?", 1.0), Verdict::Unexplained);
    }
}
