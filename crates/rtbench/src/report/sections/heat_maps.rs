//! Where in the image the work is: the pictures of `rtbench cost --heat-maps`, within the page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::report::material::Material;
use crate::report::page::{Page, SectionOutcome};

/// Captions of the pictures.
static CAPTIONS: &[(&str, &str)] = &[
    ("tests", "intersection tests of each pixel"),
    ("steps", "traversal steps of each pixel"),
    ("time", "microseconds of each pixel"),
];

pub fn write(material: &Material, page: &mut Page) -> SectionOutcome {
    if material.heat_maps.is_empty() {
        return SectionOutcome::Missing;
    }
    let html = &mut page.html;
    for (i, map) in material.heat_maps.iter().enumerate() {
        let is_first =
            i == 0 || material.heat_maps.get(i - 1).is_some_and(|before| before.scene != map.scene);
        if is_first {
            html.element("h3", &[], &map.scene);
        }
        let known = CAPTIONS.iter().find(|(name, _)| *name == map.name);
        let caption = known.map_or(map.name.as_str(), |(_, caption)| caption);
        let text = format!("{}: {caption}", map.scene);
        let [width, height] = map.size.map(|n| n.to_string());
        let source = format!("data:image/png;base64,{}", STANDARD.encode(&map.png));
        html.open("figure", &[("class", "picture")]);
        html.void(
            "img",
            &[("src", &source), ("alt", &text), ("width", &width), ("height", &height)],
        );
        html.element("figcaption", &[], &text);
        html.close();
    }
    SectionOutcome::Yes
}
