//! Pages that need nothing but themselves: one file each, no network, no font of others. The only
//! script is ours, sorts and filters tables, and is let through by its hash; without it all is
//! there.

pub mod tables;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

use crate::html::Html;
use crate::svg_plot::palette::dark_rules;
use crate::svg_plot::{Drawing, Format};

/// Style sheet of pages, except the colours of plots in dark mode.
static STYLE: &str = include_str!("page.css");
/// Sorts and filters tables.
static SCRIPT: &str = include_str!("page.js");

/// Beginning of every page.
pub const BEGINNING: &str = "<!DOCTYPE html>\n";

/// A page of that title, opened as far as its body: what comes next is its header.
pub fn start_page(title: &str) -> Html {
    let mut html = Html::default();
    html.open("html", &[("lang", "en")]);
    html.open("head", &[]);
    html.void("meta", &[("charset", "utf-8")]);
    let viewport = "width=device-width, initial-scale=1";
    html.void("meta", &[("name", "viewport"), ("content", viewport)]);
    html.void("meta", &[("name", "color-scheme"), ("content", "light dark")]);
    // nothing may be loaded, and nothing but our script run, whatever a name or a message says
    let hash = STANDARD.encode(Sha256::digest(SCRIPT.as_bytes()));
    let policy = format!(
        "default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src 'sha256-{hash}'"
    );
    html.void("meta", &[("http-equiv", "Content-Security-Policy"), ("content", &policy)]);
    html.element("title", &[], title);
    html.markup(&format!(
        "<style>\n{STYLE}@media screen and (prefers-color-scheme: dark) {{\n{}}}\n</style>\n",
        dark_rules("figure svg")
    ));
    html.close();
    html.open("body", &[]);
    html.element("a", &[("class", "skip"), ("href", "#main")], "To the results");
    html
}

/// The whole text, all elements closed.
pub fn finished(mut html: Html) -> String {
    // the body, and all around it, stay open for the script
    html.close_until(2);
    html.markup(&format!("<script>{SCRIPT}</script>\n"));
    format!("{BEGINNING}{}", html.finish())
}

/// A drawing as wide windows show it, and as narrow ones do; returns the former.
pub fn figure(html: &mut Html, label: &str, drawing: &Drawing) -> String {
    html.open("figure", &[("aria-label", label)]);
    let wide = drawing.svg(Format::Wide);
    for (class, svg) in [("wide", &wide), ("narrow", &drawing.svg(Format::Narrow))] {
        html.open("div", &[("class", class)]);
        html.markup(svg);
        html.close();
    }
    html.close();
    wide
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_only_script_is_the_one_whose_hash_the_policy_has() {
        let mut html = start_page("a < b");
        html.open("main", &[("id", "main")]);
        html.open("p", &[]);
        let page = finished(html);
        let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
        let tree = roxmltree::Document::parse_with_options(&page, options).expect("well-formed");
        let scripts: Vec<_> = tree.descendants().filter(|n| n.has_tag_name("script")).collect();
        assert_eq!(scripts.len(), 1);
        assert!(scripts[0].parent().unwrap().has_tag_name("body"), "behind all that was open");
        let hash = STANDARD.encode(Sha256::digest(scripts[0].text().unwrap().as_bytes()));
        let policy =
            tree.descendants().find_map(|n| n.attribute("content")?.contains("-src").then_some(n));
        let policy = policy.unwrap().attribute("content").unwrap();
        assert!(policy.ends_with(&format!("script-src 'sha256-{hash}'")), "{policy}");
        // read the same as HTML, which knows no escapes within scripts
        assert!(!SCRIPT.contains(['<', '&']) && !SCRIPT.contains("]]>"));
    }
}
