//! Parameters over their values: the plots of `rtbench sweep`, as images within the page (an image
//! can neither run nor load anything, whatever its file says).

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::report::material::Material;
use crate::report::page::{Page, SectionOutcome};

pub fn write(material: &Material, page: &mut Page) -> SectionOutcome {
    if material.sweeps.is_empty() {
        return SectionOutcome::Missing;
    }
    let html = &mut page.html;
    for sweep in &material.sweeps {
        html.element("h3", &[], &sweep.name);
        let source = format!("data:image/svg+xml;base64,{}", STANDARD.encode(&sweep.svg));
        let text = format!("plot of times over the values of a parameter, {}", sweep.name);
        html.open("figure", &[]);
        html.open_scroll(&text);
        html.void("img", &[("src", &source), ("alt", &text), ("class", "plot")]);
        html.close();
        html.close();
    }
    SectionOutcome::Yes
}
