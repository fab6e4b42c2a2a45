//! The files of the site, and how pages link to one another.

use std::collections::{BTreeMap, BTreeSet};

use crate::history::lines::{History, Key, Quantity};
use crate::report::file_name;

/// The page that all others are found from.
pub const INDEX: &str = "index.html";

/// Key of a page: scene, structure, quantity.
pub type PageKey = (String, String, Quantity);

/// The paths of all pages, from the site's folder on.
pub struct Names {
    scenes: BTreeMap<String, String>,
    pages: BTreeMap<PageKey, String>,
}

pub fn page_of(key: &Key) -> PageKey {
    (key.scene.clone(), key.structure.clone(), key.quantity)
}

/// The part of its page that a row has.
pub fn anchor(settings: &str) -> String {
    match settings {
        "" => "defaults".to_owned(),
        settings => file_name(settings),
    }
}

impl Names {
    /// Names that are safe as files' and distinct, in upper and lower case alike.
    pub fn new(history: &History) -> Self {
        let mut taken = BTreeSet::from([INDEX.to_owned()]);
        let mut distinct = |stem: String| {
            let tries = std::iter::once(stem.clone()).chain((2..).map(|n| format!("{stem}-{n}")));
            let mut free = tries.filter(|path| taken.insert(path.to_lowercase()));
            free.next().unwrap_or(stem)
        };
        let (mut scenes, mut pages) = (BTreeMap::new(), BTreeMap::new());
        for key in history.lines.keys() {
            let folder = scenes.entry(key.scene.clone());
            let folder = folder.or_insert_with(|| distinct(file_name(&key.scene)));
            pages.entry(page_of(key)).or_insert_with(|| {
                let [kind, row] = [key.quantity.head(), &key.structure].map(file_name);
                distinct(format!("{folder}/{row}-{kind}")) + ".html"
            });
        }
        let scenes = scenes.into_iter().map(|(scene, folder)| (scene, format!("{folder}/{INDEX}")));
        Self { scenes: scenes.collect(), pages }
    }

    pub fn scenes(&self) -> impl Iterator<Item = (&String, &String)> {
        self.scenes.iter()
    }

    /// Structures within scenes, and their pages.
    pub fn pages(&self) -> impl Iterator<Item = (&PageKey, &String)> {
        self.pages.iter()
    }

    /// The page of a scene, from the site's folder on.
    pub fn scene(&self, scene: &str) -> &str {
        self.scenes.get(scene).map_or(INDEX, String::as_str)
    }

    /// The part of a page that a row has, from the site's folder on.
    pub fn row(&self, key: &Key) -> String {
        let page = self.pages.get(&page_of(key)).map_or(INDEX, String::as_str);
        format!("{page}#{}", anchor(&key.settings))
    }
}
