//! The glue: right answers come through, and planted mistakes are seen.

use peer::trial::{Trial, glass, rays, triangles};
use peer::{Description, Hit, Kind, Peer, Ray, Scene, Setting, Shadows, Stats, Triangle};

/// Every triangle, with a mistake that a setting plants.
struct Brute<const SHADOWS: u8> {
    triangles: Vec<Triangle>,
    transmissive: Vec<bool>,
    fault: String,
}

type Describe = extern "C" fn() -> *const peer::abi::Plugin;

const NONE: u8 = 0;
const FILTERED: u8 = 1;
const ALL: u8 = 2;

impl<const SHADOWS: u8> Peer for Brute<SHADOWS> {
    const DESCRIPTION: Description = Description {
        name: "brute",
        library: "peer",
        summary: "every triangle",
        settings: &[
            Setting {
                name: "fault",
                summary: "a planted mistake",
                initial: "none",
                kind: Kind::Choice(
                    "none drops-hits wrong-id ignores-t-min glass-blocks panics refuses panics-later",
                ),
            },
            Setting { name: "size", summary: "any", initial: "3", kind: Kind::Integer(1, 9) },
        ],
    };
    const SHADOWS: Shadows = match SHADOWS {
        NONE => Shadows::None,
        FILTERED => Shadows::Filtered,
        _ => Shadows::All,
    };
    const USES_RAYON: bool = SHADOWS == FILTERED;

    fn build(scene: &Scene<'_>) -> Result<Self, String> {
        assert_eq!(scene.settings.integer("size"), 3);
        let fault = scene.settings.text("fault").to_owned();
        match fault.as_str() {
            "panics" => panic!("the {} of a planted mistake: {}", "text", "ä".repeat(40)),
            "refuses" => Err("it does not want to".to_owned()),
            _ => Ok(Self {
                triangles: scene.triangles.to_vec(),
                transmissive: (0..scene.triangles.len())
                    .map(|id| scene.is_transmissive(id))
                    .collect(),
                fault,
            }),
        }
    }

    fn closest(&self, ray: &Ray) -> Option<Hit> {
        assert_ne!(self.fault, "panics-later");
        let ignores = self.fault == "ignores-t-min";
        let asked = Ray { t_min: if ignores { 0.0 } else { ray.t_min }, ..*ray };
        let mut best: Option<Hit> = None;
        for (id, triangle) in self.triangles.iter().enumerate() {
            let t_max = best.map_or(ray.t_max, |hit| hit.t);
            if let Some(t) = peer::triangle::intersect(triangle, &asked, t_max) {
                let id = id as u32 + u32::from(self.fault == "wrong-id");
                best = Some(Hit::new(t, id));
            }
        }
        best.filter(|hit| self.fault != "drops-hits" || hit.id % 8 != 0)
    }

    fn occluded(&self, ray: &Ray) -> bool {
        let blocks =
            |id: usize| SHADOWS == ALL || self.fault == "glass-blocks" || !self.transmissive[id];
        let mut all = self.triangles.iter().enumerate();
        all.any(|(id, t)| blocks(id) && peer::triangle::intersect(t, ray, ray.t_max).is_some())
    }

    fn stats(&self, stats: &mut Stats) {
        stats.leaves += 1;
        stats.references += self.triangles.len() as u64;
    }
}

extern "C" fn plugin<const SHADOWS: u8>() -> *const peer::abi::Plugin {
    peer::describe::<Brute<SHADOWS>>().as_ptr()
}

#[test]
fn right_answers_come_through() {
    let (triangles, rays) = (triangles(200), rays(600));
    let glass = glass(200);
    for plugin in [plugin::<NONE> as Describe, plugin::<FILTERED>, plugin::<ALL>] {
        for (transmissive, threads) in [(&[][..], 1), (&glass, 2)] {
            let trial = Trial::build(plugin, &triangles, transmissive, "", threads).unwrap();
            let faults = trial.faults(&rays);
            assert_eq!(faults.sum(), 0, "{faults:?}");
            assert!(faults.certain > 400, "{faults:?}");
            let hits = trial.closest(&rays).iter().filter(|hit| hit.id < 200).count();
            assert!(hits > 200 && hits < 590, "{hits}");
        }
    }
    // without rays there are no answers
    assert!(Trial::build(plugin::<NONE>, &triangles, &[], "", 1).unwrap().closest(&[]).is_empty());
}

#[test]
fn planted_mistakes_are_seen() {
    let (triangles, rays) = (triangles(200), rays(600));
    let glass = glass(200);
    for plugin in [plugin::<NONE> as Describe, plugin::<FILTERED>] {
        let faults = |fault: &str| {
            let settings = format!("fault={fault}");
            Trial::build(plugin, &triangles, &glass, &settings, 1).unwrap().faults(&rays)
        };
        assert!(faults("drops-hits").lost > 20);
        assert!(faults("wrong-id").elsewhere > 200);
        let early = faults("ignores-t-min");
        assert!(early.elsewhere + early.invented > 20, "{early:?}");
    }
    let shadows = |fault| {
        let trial = Trial::build(plugin::<FILTERED>, &triangles, &glass, fault, 1).unwrap();
        trial.faults(&rays).occlusion
    };
    assert_eq!(shadows("fault=none"), 0);
    assert!(shadows("fault=glass-blocks") > 20);
}

#[test]
fn a_panic_in_a_build_is_a_reason() {
    let triangles = triangles(3);
    for plugin in [plugin::<NONE> as Describe, plugin::<FILTERED>, plugin::<ALL>] {
        let refused = |fault| Trial::build(plugin, &triangles, &[], fault, 1).err().unwrap();
        assert_eq!(refused("fault=refuses"), "it does not want to");
        // cut where a letter ends: the message has room for 63 bytes
        let said = refused("fault=panics");
        let begins = "its build panics: the text of a planted mistake: ää";
        assert!(said.starts_with(begins), "{said}");
        assert!(said.len() >= 62 && said.ends_with('ä'), "{said}");
    }
}

#[test]
#[cfg(unix)]
fn a_panic_in_a_query_ends_the_process() {
    use std::os::unix::process::ExitStatusExt;

    const CHILD: &str = "PEER_TRIAL_IS_CHILD";
    if std::env::var_os(CHILD).is_some() {
        let triangles = triangles(3);
        let trial = Trial::build(plugin::<NONE>, &triangles, &[], "fault=panics-later", 1).unwrap();
        // whoever gets beyond this ends well, and is found out
        let _caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            trial.closest(&rays(1));
        }));
        return;
    }
    let mut child = std::process::Command::new(std::env::current_exe().unwrap());
    child.args(["--exact", "a_panic_in_a_query_ends_the_process"]).env(CHILD, "1");
    const SIGABRT: i32 = 6;
    assert_eq!(child.output().unwrap().status.signal(), Some(SIGABRT));
}

#[test]
fn a_second_structure_stands_for_what_is_opaque() {
    let triangles = triangles(90);
    let stats = |plugin: Describe, transmissive: &[u8]| {
        Trial::build(plugin, &triangles, transmissive, "", 1).unwrap().stats()
    };
    let glass = glass(90);
    assert_eq!(stats(plugin::<ALL>, &glass).references, 90 + 60);
    assert_eq!(stats(plugin::<ALL>, &[]).references, 90);
    assert_eq!(stats(plugin::<ALL>, &[0; 90]).references, 90);
    assert_eq!(stats(plugin::<FILTERED>, &glass).references, 90);
    // of glass alone nothing is opaque: a point stands for it, and blocks nothing
    let all_glass = [1; 90];
    let trial = Trial::build(plugin::<ALL>, &triangles, &all_glass, "", 1).unwrap();
    assert_eq!(trial.stats().references, 91);
    assert_eq!(trial.faults(&rays(300)).sum(), 0);
}

#[test]
fn a_plugin_is_described() {
    // SAFETY: it lives as long as the process
    let of = |plugin: Describe| unsafe { &*plugin() };
    let (none, filtered) = (of(plugin::<NONE>), of(plugin::<FILTERED>));
    assert!(none.in_f32.occluded.is_none() && filtered.in_f32.occluded.is_some());
    assert_eq!([none.answers, filtered.answers], [1, 3]);
    assert_eq!((none.query, none.test, none.settings_count), (0, 0, 2));
    // SAFETY: likewise
    let version = unsafe { std::ffi::CStr::from_ptr(none.version) };
    assert_eq!(version.to_str(), Ok(env!("CARGO_PKG_VERSION")));
}

/// What rtbench is compiled for: a peer for less would be measured too slow.
#[test]
#[cfg(target_arch = "x86_64")]
fn target_features_are_those_of_rtbench() {
    let enabled = [cfg!(target_feature = "avx2"), cfg!(target_feature = "fma")];
    assert_eq!(enabled, [true; 2]);
}
