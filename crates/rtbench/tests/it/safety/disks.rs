//! Folders that go while a run is on, and what killed runs leave.

use std::path::{Path, PathBuf};

use accel_core::structures::REGISTRY;
use measurement::record::file;
use measurement::scenes::{
    InstalledScenes, KnownScene, LoadError, LoadedScene, SceneRef, SceneSource,
};
use measurement::system::clock::SystemClock;
use measurement::system::world::World;
use rtbench::context::{Context, Environment};

use crate::common::{Ended, Folder, run};
use crate::resuming::{journal, record, run as run_here, show};

/// Scenes of which the last does something to a folder when it is loaded.
struct Sabotage {
    folder: PathBuf,
    act: fn(&Path),
}

#[derive(Debug)]
struct Last {
    scene: Box<dyn KnownScene>,
    folder: PathBuf,
    act: fn(&Path),
}

impl KnownScene for Last {
    fn known(&self) -> &SceneRef {
        self.scene.known()
    }
    fn known_mut(&mut self) -> &mut SceneRef {
        self.scene.known_mut()
    }
    fn load(&self) -> Result<LoadedScene, LoadError> {
        (self.act)(&self.folder);
        self.scene.load()
    }
}

impl SceneSource for Sabotage {
    fn resolve(&self, names: &[String]) -> Result<Vec<Box<dyn KnownScene>>, LoadError> {
        let mut scenes = InstalledScenes.resolve(names)?;
        if let Some(scene) = scenes.pop() {
            let (folder, act) = (self.folder.clone(), self.act);
            scenes.push(Box::new(Last { scene, folder, act }));
        }
        Ok(scenes)
    }
}

const RUN: &str = "run tetra:1 tetra:2 --size 4 --rounds 1 -s obvhs-cwbvh,uniform-grid";

/// Runs two scenes into `folder/parent/out`; the second does `act` to `folder/parent`.
fn sabotaged(folder: &Path, temporary: &str, act: fn(&Path)) -> Ended {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let parent = folder.join("parent");
    let scenes = Sabotage { folder: parent.clone(), act };
    let (clock, world) = (SystemClock::default(), World::fixed());
    let mut context = Context {
        environment: Environment {
            temporary: Some(folder.join(temporary)),
            ..Environment::default()
        },
        ..Context::new(REGISTRY, &scenes, &clock, &world, &mut out, &mut err)
    };
    let arguments = format!("rtbench {RUN} -o {}", show(&parent.join("out")));
    let code = rtbench::run(&mut context, arguments.split_whitespace());
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Ended { code, out: text(out), err: text(err) }
}

#[test]
fn a_folder_that_is_removed_in_mid_run_is_made_again() {
    let folder = tempfile::tempdir().unwrap();
    let ended = sabotaged(folder.path(), "", |parent| std::fs::remove_dir_all(parent).unwrap());
    assert_eq!(ended.code, 1, "{}", ended.err);
    assert!(ended.err.contains("were removed during the run"), "{}", ended.err);
    let out = folder.path().join("parent/out");
    assert!(record(&out).complete && record(&out).scenes.len() == 2);
    let found = journal(&out);
    assert!(found.is_complete && found.finished.len() == 2);
    for name in ["results.csv", "results.md"] {
        let text = std::fs::read_to_string(out.join(name)).unwrap();
        assert!(text.contains("tetra:1") && text.contains("tetra:2"), "{name}");
    }
}

#[test]
fn records_are_kept_elsewhere_or_printed_if_the_folder_is_lost() {
    /// A file in the folder's place.
    fn replaced(parent: &Path) {
        std::fs::remove_dir_all(parent).unwrap();
        std::fs::write(parent, "mine").unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let ended = sabotaged(folder.path(), "", replaced);
    assert_eq!(ended.code, 1, "{}", ended.err);
    let (_, kept) = ended.err.split_once("2 scene(s)) are saved in ").expect("it says where");
    let kept = file::read(Path::new(kept.lines().next().unwrap())).unwrap();
    assert_eq!(kept.scenes.len(), 2);
    assert!(kept.scenes.iter().all(|scene| scene.rows.iter().all(|row| row.trace_s.is_some())));
    assert!(ended.err.contains("cannot write"), "{}", ended.err);
    // nor there
    let folder = tempfile::tempdir().unwrap();
    let ended = sabotaged(folder.path(), "none", replaced);
    assert_eq!(ended.code, 1, "{}", ended.err);
    assert!(ended.err.contains("are only printed"), "{}", ended.err);
    assert!(ended.out.contains("tetra:1: ") && ended.out.contains("tetra:2: "), "{}", ended.out);
}

/// A kill in the middle of a write left `results.json.PID.tmp` for ever.
#[test]
fn temporary_files_of_killed_runs_are_removed() {
    let folder = Folder::new();
    // no process has that number
    let left = format!("{}/results.json.4200001.tmp", folder.path());
    let other = format!("{}/mine.json.4200001.tmp", folder.path());
    for path in [&left, &other] {
        std::fs::write(path, "{\"half").unwrap();
    }
    let ended = run(&format!("run tetra:1 --size 4 -s obvhs-cwbvh -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(!Path::new(&left).exists() && Path::new(&other).exists());
}

/// Names of 240 characters: the plots were named too long, and one of them was left empty.
#[test]
fn plots_of_long_names_have_names_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let names = ["a", "b"].map(|end| format!("{}{end}", "x".repeat(239)));
    let paths = names.map(|name| show(&folder.path().join(name + ".obj")));
    paths.iter().for_each(|path| crate::safety::write_triangle(Path::new(path)));
    let (out, plots) = (folder.path().join("out"), folder.path().join("plots"));
    let run = format!(
        "run {} --size 4 --rounds 1 -s obvhs-cwbvh,uniform-grid -o {}",
        paths.join(" "),
        show(&out)
    );
    assert_eq!(run_here(&run).0, 0);
    let (code, _, err) = run_here(&format!("report {} --plots {}", show(&out), show(&plots)));
    assert_eq!(code, 0, "{err}");
    let files: Vec<_> = std::fs::read_dir(&plots).unwrap().map(|f| f.unwrap()).collect();
    let long = files.iter().filter(|f| f.file_name().to_string_lossy().contains("xxxx")).count();
    assert_eq!(long, 4, "two plots per scene");
    assert!(files.iter().all(|file| file.metadata().unwrap().len() > 100));
}
