//! The scene files, sets and small assets of the folder `scenes/`, compiled in so that the
//! program works from any folder.

macro_rules! embed {
    ($($path:literal),* $(,)?) => {
        &[$((concat!("scenes/", $path), include_str!(concat!("../../../scenes/", $path)))),*]
    };
}

/// Scene files: path in the repository and text.
pub(crate) static SCENES: &[(&str, &str)] = embed![
    "balls-tess.json",
    "gears-tess.json",
    "kitchen.json",
    "pavilion.json",
    "sponza.json",
    "tree-tess.json",
];

/// Set files: path in the repository and text.
pub(crate) static SETS: &[(&str, &str)] =
    embed!["sets/real.json", "sets/small.json", "sets/spd.json"];

/// Files that scene files refer to: path in the repository and bytes.
pub(crate) static ASSETS: &[(&str, &[u8])] =
    &[("scenes/pavilion.glb", include_bytes!("../../../scenes/pavilion.glb"))];
