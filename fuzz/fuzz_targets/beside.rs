//! What `report` reads beside a record: the CSV of `reproduce`, the JSON of `accuracy` and of
//! `compare-tracers`. The first byte says which, and the length whether what was read is put on a page, too: that
//! takes a hundred times as long.
#![no_main]

use std::path::PathBuf;
use std::sync::OnceLock;

use measurement::system::progress::Progress;
use rtbench::report::material::Material;
use rtbench::report::page;

/// What may lie there.
const FILES: [&str; 4] =
    ["havran1999.csv", "zachmann2007.csv", "accuracy/accuracy.json", "tracers/scene/tracers.json"];

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((&first, text)) = bytes.split_first() else { return };
    let folder = folder();
    let file = folder.join(FILES[usize::from(first) % FILES.len()]);
    std::fs::write(&file, text).expect("a file of our own");
    let read = Material::read(&folder.join("results.json"));
    if let Ok(material) = read
        && bytes.len() % 32 == 0
    {
        let _ = page(&[material], true, Progress::new(false, 1, None));
    }
    std::fs::remove_file(&file).expect("it was written");
});

/// A folder of this process with a record.
fn folder() -> &'static PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = std::env::temp_dir().join(format!("rtbench-fuzz-{}", std::process::id()));
        for file in FILES {
            let parent = folder.join(file);
            std::fs::create_dir_all(parent.parent().expect("a folder")).expect("a folder");
        }
        let record = include_bytes!("../seeds/records/one-row.json");
        std::fs::write(folder.join("results.json"), record).expect("a file");
        folder
    })
}
