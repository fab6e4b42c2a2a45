//! Differences that make two runs incomparable.
//!
//! A figure of one run can be compared with one of another if nothing but the program differs
//! between them. Other scenes, rays, arithmetic or instructions make everything another question.
//! Another machine makes seconds one, but not counters, and not ratios to the reference of the same
//! run, which is why they are taken. Another reference makes those another question; in a single
//! scene too, where another row took its place.

use crate::comparison::entry::{ComparisonSettings, NamedRun};
use crate::comparison::pairing::Pairing;
use measurement::record::metrics::DifferenceScope::{self, Everything, Nothing, Ratios, Seconds};
use measurement::record::{Machine, RunRecord, SceneRecord, reference};

/// Something that two runs do not have in common.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// The property with its old and new value.
    pub what: String,
    pub concerns: DifferenceScope,
}

/// All differences between two runs, over the scenes that both have.
pub fn differences(old: &RunRecord, new: &RunRecord) -> Vec<Difference> {
    let mut found = DifferenceList(Vec::new());
    let (a, b) = (&old.settings, &new.settings);
    found.unless_equal(Everything, "threads", &a.threads, &b.threads);
    found.unless_equal(Everything, "precision", &a.precision, &b.precision);
    let size = |[width, height]: [u32; 2]| format!("{width}x{height}");
    let sizes = [a.resolution, b.resolution].map(size);
    found.unless_equal(Everything, "resolution", &sizes[0], &sizes[1]);
    found.unless_equal(Everything, "depth", &a.max_depth, &b.max_depth);
    found.unless_equal(Everything, "rays", &a.rays.join(","), &b.rays.join(","));
    found.unless_equal(Everything, "order of rays", &a.order, &b.order);
    found.unless_equal(Everything, "lights", &a.lights, &b.lights);
    let views = [&a.view, &b.view]
        .map(|view| if view.is_empty() { "the scenes' own".to_owned() } else { view.to_string() });
    found.unless_equal(Everything, "view", &views[0], &views[1]);
    found.unless_equal(Everything, "seed", &a.seed, &b.seed);
    let (x, y) = (&old.compiler, &new.compiler);
    found.unless_known_equal(Everything, "target", &x.target, &y.target);
    found.features(&x.target_features, &y.target_features);
    found.unless_known_equal(Everything, "profile", &x.profile, &y.profile);
    found.unless_known_equal(Everything, "opt-level", &x.opt_level, &y.opt_level);
    for [before, after] in Pairing::of(old, new).scenes.into_iter().map(|pair| pair.scenes) {
        let name = &before.name;
        let what = format!("scene {name}: sha256");
        found.unless_equal(Everything, &what, &before.sha256, &after.sha256);
        if a.rays != b.rays {
            // said above
            continue;
        }
        let rays = [&before.rays, &after.rays].map(|rays| {
            rays.iter().map(|(kind, n)| format!("{n} {kind}")).collect::<Vec<_>>().join(" + ")
        });
        let what = format!("scene {name}: rays");
        found.unless_equal(Everything, &what, &rays[0], &rays[1]);
    }
    let (m, n) = (&old.machine, &new.machine);
    found.processor(m, n);
    found.unless_known_equal(Seconds, "governor", &m.governor, &n.governor);
    found.unless_known_equal(Seconds, "boost", &m.boost, &n.boost);
    found.unless_equal(Ratios, "reference", &a.reference, &b.reference);
    found.unless_equal(Seconds, "timed by", &a.timed_by, &b.timed_by);
    found.unless_equal(Nothing, "system", &m.os, &n.os);
    found.unless_known_equal(Nothing, "compiler", &x.rustc, &y.rustc);
    found.0
}

/// Differences of two machines' processors that affect ratios of times: model, number of threads,
/// instruction sets. Memory and kernel do not count.
pub fn other_processor(old: &Machine, new: &Machine) -> Option<String> {
    let mut found = DifferenceList(Vec::new());
    found.processor(old, new);
    let differing: Vec<String> = found.0.into_iter().map(|difference| difference.what).collect();
    (!differing.is_empty()).then(|| differing.join("; "))
}

/// References of a scene in both runs, if they differ.
pub fn other_reference(scenes: [&SceneRecord; 2]) -> Option<[String; 2]> {
    let [old, new] = scenes.map(reference::of_scene);
    let both = [old?, new?];
    (both[0] != both[1]).then_some(both)
}

/// Differences as they are found.
struct DifferenceList(Vec<Difference>);

impl DifferenceList {
    fn unless_equal<T: PartialEq + ToString>(
        &mut self,
        concerns: DifferenceScope,
        what: &str,
        old: &T,
        new: &T,
    ) {
        if old != new {
            let what = format!("{what}: {}, then {}", old.to_string(), new.to_string());
            self.0.push(Difference { what, concerns });
        }
    }

    /// Difference of two values; `None` if either is unknown.
    fn unless_known_equal<T: PartialEq + ToString>(
        &mut self,
        concerns: DifferenceScope,
        what: &str,
        old: &Option<T>,
        new: &Option<T>,
    ) {
        if let (Some(old), Some(new)) = (old, new) {
            self.unless_equal(concerns, what, old, new);
        }
    }

    fn processor(&mut self, old: &Machine, new: &Machine) {
        self.unless_known_equal(Seconds, "processor", &old.cpu, &new.cpu);
        self.unless_equal(Seconds, "threads of the machine", &old.threads, &new.threads);
        let avx512 = [old, new].map(|machine| machine.batches_by_avx512);
        self.unless_known_equal(Seconds, "wide nodes, batches by AVX-512", &avx512[0], &avx512[1]);
        self.unless_known_equal(Seconds, "huge pages", &old.huge_pages, &new.huge_pages);
    }

    /// Target features, by those that only one run has.
    fn features(&mut self, old: &[String], new: &[String]) {
        let only = |all: &[String], others: &[String]| -> String {
            let only: Vec<&str> =
                all.iter().filter(|f| !others.contains(f)).map(String::as_str).collect();
            if only.is_empty() { "none".to_owned() } else { only.join(" ") }
        };
        let (gone, come) = (only(old, new), only(new, old));
        self.unless_equal(Everything, "target features of one run only", &gone, &come);
    }
}

/// Reasons why `now` cannot be compared with `base`: all differences that make runs incomparable,
/// except for seconds, which no stage uses, and references, which are compared by scene.
pub fn refusals(base: &RunRecord, now: &RunRecord) -> Vec<String> {
    let refuses = |d: &Difference| d.concerns == Everything;
    differences(base, now).into_iter().filter(refuses).map(|d| d.what).collect()
}

/// Remarks that do not prevent a comparison.
pub fn remarks(base: &RunRecord, now: &RunRecord) -> Vec<String> {
    let mut remarks = Vec::new();
    if let Some(processors) = other_processor(&base.machine, &now.machine) {
        remarks.push(format!(
            "Another processor than the baseline's ({processors}): counters and instruction \
             counts are judged as on the same; times only with --across-processors."
        ));
    }
    let (was, is) = (&base.settings.timed_by, &now.settings.timed_by);
    if was != is {
        remarks.push(format!(
            "Times of the baseline are {was}, now {is}: only one of them includes time taken by other programs."
        ));
    }
    if base.compiler.rustc != now.compiler.rustc {
        let of = |r: &RunRecord| r.compiler.rustc.clone().unwrap_or_else(|| "unknown".into());
        remarks.push(format!(
            "Another compiler than the baseline's ({}; was {}): it may change instruction counts.",
            of(now),
            of(base)
        ));
    }
    remarks
}

/// Caveats of comparing two runs.
pub fn notes(
    old: NamedRun<'_>,
    new: NamedRun<'_>,
    pairing: &Pairing<'_>,
    choice: &ComparisonSettings,
    differing: &[Difference],
) -> Vec<String> {
    let mut said = Vec::new();
    for Difference { what, concerns } in differing {
        let consequence = match (concerns, choice.is_forced) {
            (Nothing, _) => "",
            (_, true) => "; compared by --force",
            (Seconds, _) => {
                "; times in seconds are not compared (except with --force), ratios and counters are"
            }
            (Ratios, _) => "; ratios to the reference are not compared (except with --force)",
            (Everything, false) => "",
        };
        said.push(format!("{what}{consequence}"));
    }
    for scenes in pairing.scenes.iter().map(|pair| pair.scenes) {
        let Some([a, b]) = other_reference(scenes) else { continue };
        let what = if choice.is_forced { "compared by --force" } else { "not compared" };
        let (in_a, in_b, scene) = (old.letter, new.letter, &scenes[0].name);
        said.push(format!("scene {scene}: ratios to {a} in {in_a}, to {b} in {in_b}, {what}"));
    }
    for NamedRun { letter, run, .. } in [old, new] {
        if !run.complete || run.scenes.len() < run.planned.len() {
            let (finished, all) = (run.scenes.len(), run.planned.len());
            said.push(format!("{letter} is incomplete: {finished} of {all} scenes"));
        }
        if run.settings.quick {
            said.push(format!("{letter} is a quick run: few rounds, a first look"));
        }
        said.extend(run.warnings.iter().map(|warning| format!("{letter}: {warning}")));
    }
    for (named, scenes) in [old, new].into_iter().zip(&pairing.only) {
        if !scenes.is_empty() {
            let names: Vec<&str> = scenes.iter().map(|s| s.name.as_str()).collect();
            said.push(format!("only in {}: {}", named.letter, names.join(", ")));
        }
    }
    said
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::record::made_up::run;

    #[test]
    fn every_planted_difference_is_found_with_its_scope() {
        let old = run(&[("tetra", &[("obvhs-cwbvh", &[1.0])])]);
        assert_eq!(differences(&old, &old.clone()), []);
        type Plant = (fn(&mut RunRecord), &'static str, DifferenceScope);
        let plants: [Plant; 23] = [
            (|r| r.settings.threads = 2, "threads: 1, then 2", Everything),
            (|r| r.settings.precision = "f64".into(), "precision: f32, then f64", Everything),
            (|r| r.settings.resolution = [8, 9], "resolution: 16x16, then 8x9", Everything),
            (|r| r.settings.max_depth = 9, "depth: 4, then 9", Everything),
            (|r| r.settings.rays = vec!["shadow".into()], "rays: primary, then shadow", Everything),
            (
                |r| r.settings.order = "both".into(),
                "order of rays: scanline, then both",
                Everything,
            ),
            (|r| r.settings.lights = "first".into(), "lights: each, then first", Everything),
            (
                |r| r.settings.view.up = "0,0,1".parse().ok(),
                "view: the scenes' own, then --up=0,0,1",
                Everything,
            ),
            (|r| r.settings.seed = 7, "seed: 1, then 7", Everything),
            (
                |r| r.compiler.target = Some("arm".into()),
                "target: x86_64-unknown-linux-gnu, then arm",
                Everything,
            ),
            (
                |r| r.compiler.target_features = vec!["avx2".into()],
                "target features of one run only: fma, then none",
                Everything,
            ),
            (|r| r.compiler.profile = Some("dev".into()), "profile: release, then dev", Everything),
            (|r| r.compiler.opt_level = Some("1".into()), "opt-level: 3, then 1", Everything),
            (|r| r.scenes[0].sha256 = "ef".into(), "scene tetra: sha256: cd, then ef", Everything),
            (
                |r| r.scenes[0].rays = [("shadow".into(), 9)].into(),
                "scene tetra: rays: 256 primary, then 9 shadow",
                Everything,
            ),
            (|r| r.machine.cpu = Some("Other".into()), "processor: Test CPU, then Other", Seconds),
            (|r| r.machine.threads = 3, "threads of the machine: 2, then 3", Seconds),
            (
                |r| r.machine.governor = Some("powersave".into()),
                "governor: performance, then powersave",
                Seconds,
            ),
            (|r| r.machine.boost = Some(false), "boost: true, then false", Seconds),
            (|r| r.settings.reference = "hug".into(), "reference: obvhs-cwbvh, then hug", Ratios),
            (
                |r| r.settings.timed_by = "processor time".into(),
                "timed by: time of day, then processor time",
                Seconds,
            ),
            (|r| r.machine.os = "plan9".into(), "system: linux, then plan9", Nothing),
            (
                |r| r.compiler.rustc = Some("rustc 2".into()),
                "compiler: rustc 1.90.0, then rustc 2",
                Nothing,
            ),
        ];
        let mut old = old;
        (old.machine.governor, old.machine.boost) = (Some("performance".into()), Some(true));
        for (plant, what, concerns) in plants {
            let mut new = old.clone();
            plant(&mut new);
            assert_eq!(differences(&old, &new), [Difference { what: what.into(), concerns }]);
        }
        let mut grid = old.scenes[0].clone();
        assert_eq!(other_reference([&old.scenes[0], &grid]), None);
        grid.rows[0].structure = "uniform-grid".into();
        let both = ["obvhs-cwbvh", "uniform-grid"].map(str::to_owned);
        assert_eq!(other_reference([&old.scenes[0], &grid]), Some(both));
        // without ratios there is nothing to compare
        grid.rows[0].verdict = measurement::record::Verdict::NotBuilt;
        assert_eq!(other_reference([&old.scenes[0], &grid]), None);
        let mut unknown = old.clone();
        (unknown.machine.governor, unknown.compiler.target) = (None, None);
        assert_eq!(differences(&old, &unknown), []);
    }
}
