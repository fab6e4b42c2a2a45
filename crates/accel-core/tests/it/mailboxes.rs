//! Mailboxes: answers, work, threads, and what excludes them.

use accel_core::Hit;
use accel_core::primitives::{MixedSet, PrimsRef, TriangleSet, Watertight};
use accel_core::query::tracer::Tracer;

use crate::agreement::work;
use crate::common::build;
use crate::test_scenes::{hard_scenes, mixed_scene, rays};

const MAILBOXES: [&str; 3] = ["mailbox=primitive", "mailbox=array", "mailbox=hash"];

fn grid<'a>(set: &'a MixedSet<f32>, mailbox: &str) -> Box<dyn Tracer<f32> + 'a> {
    build(PrimsRef::Mixed(set), "uniform-grid", &format!("density=8 {mailbox}")).unwrap()
}

#[test]
fn mailboxes_change_no_answer_and_account_for_every_test() {
    for (scene, set) in hard_scenes::<f32>() {
        let rays = rays(&set, if scene == "duplicates" { 60 } else { 1500 }, 23);
        let (answers, [closest, _]) = work(&*grid(&set, ""), &rays);
        assert_eq!(closest.tests_saved, 0);
        for mailbox in MAILBOXES.into_iter().chain(["mailbox=hash mailbox-slots=1"]) {
            let (same, [got, _]) = work(&*grid(&set, mailbox), &rays);
            assert!(same == answers, "{mailbox} {scene}");
            let tests = got.intersection_tests + got.tests_saved;
            assert_eq!(tests, closest.intersection_tests, "{mailbox} {scene}");
            assert_eq!(got.traversal_steps, closest.traversal_steps);
            if scene == "cube" && !mailbox.ends_with("=1") {
                assert!(got.tests_saved > 0, "{mailbox}");
            }
        }
    }
}

#[test]
fn threads_share_a_mailbox_without_harm() {
    let set = mixed_scene::<f32>(200, 24, [1.0; 3]);
    let rays = rays(&set, 600, 25);
    let mut expected = vec![Hit::NONE; rays.len()];
    grid(&set, "").closest_hits(&rays, &mut expected);
    for mailbox in MAILBOXES {
        let tracer = grid(&set, mailbox);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for part in [7, 100, 600] {
                        for (r, e) in rays.chunks(part).zip(expected.chunks(part)) {
                            let mut hits = vec![Hit::NONE; r.len()];
                            tracer.closest_hits(r, &mut hits);
                            assert_eq!(hits, e, "{mailbox}");
                        }
                    }
                });
            }
        });
    }
}

#[test]
fn blocks_and_mailboxes_exclude_each_other() {
    let triangle = [[0.0f32; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let set = TriangleSet::<f32, Watertight>::new(vec![triangle; 9], |_| false).unwrap();
    let bytes = |settings| {
        build(PrimsRef::Watertight(&set), "kd-tree", settings).map(|tracer| tracer.stats().bytes)
    };
    let [scalar, block] = ["kernel=scalar", "kernel=block"].map(|kernel| bytes(kernel).unwrap());
    assert!(block >= scalar + 2 * 320, "{scalar} {block}");
    let both = bytes("kernel=block mailbox=hash").unwrap_err().to_string();
    assert!(both.contains("kd-tree.kernel = 'block': expected scalar where"), "{both}");
}
