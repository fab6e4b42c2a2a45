//! Mailboxes: answers, work, threads, and what excludes them.

use accel_core::Hit;
use accel_core::primitives::{PrimsRef, TriangleSet, Watertight};
use accel_core::structures::{find, uniform_grid};

use crate::grids::work;
use crate::test_scenes::{built, hard_scenes, mixed_scene, rays};

#[test]
fn mailboxes_change_no_answer_and_account_for_every_test() {
    let entry = find(uniform_grid::INFO.name).unwrap();
    for (scene, set) in hard_scenes::<f32>() {
        let rays = rays(&set, if scene == "duplicates" { 60 } else { 1500 }, 23);
        let (hits, blocked, closest, _) = work(built(entry, &set, "density=8").as_ref(), &rays);
        assert_eq!(closest.tests_saved, 0);
        for mailbox in ["primitive", "array", "hash", "hash mailbox-slots=1"] {
            let settings = format!("density=8 mailbox={mailbox}");
            let got = work(built(entry, &set, &settings).as_ref(), &rays);
            assert!(got.0 == hits && got.1 == blocked, "{settings} {scene}");
            let tests = got.2.intersection_tests + got.2.tests_saved;
            assert_eq!(tests, closest.intersection_tests, "{settings} {scene}");
            assert_eq!(got.2.traversal_steps, closest.traversal_steps);
            if scene == "cube" && !mailbox.contains('=') {
                assert!(got.2.tests_saved > 0, "{settings}");
            }
        }
    }
}

#[test]
fn threads_share_a_mailbox_without_harm() {
    let set = mixed_scene::<f32>(200, 24, [1.0; 3]);
    let rays = rays(&set, 600, 25);
    let entry = find(uniform_grid::INFO.name).unwrap();
    let mut expected = vec![Hit::NONE; rays.len()];
    built(entry, &set, "density=8").closest_hits(&rays, &mut expected);
    for mailbox in ["primitive", "array", "hash"] {
        let tracer = built(entry, &set, &format!("density=8 mailbox={mailbox}"));
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
    let entry = find("kd-tree").unwrap();
    let bytes = |settings: &[(&str, &str)]| {
        let params = entry.params(settings.iter().copied()).unwrap();
        entry.build(PrimsRef::Watertight(&set), &params).map(|tracer| tracer.stats().bytes)
    };
    let [scalar, block] = ["scalar", "block"].map(|k| bytes(&[("kernel", k)]).unwrap());
    assert!(block >= scalar + 2 * 320, "{scalar} {block}");
    let both = bytes(&[("kernel", "block"), ("mailbox", "hash")]).unwrap_err().to_string();
    assert!(both.contains("kd-tree.kernel = 'block': expected scalar where"), "{both}");
}
