//! Markup that is always well-formed: elements close in the order in which they were opened, and
//! all text is escaped. What comes out is HTML that an XML parser reads, too.

use crate::outside::is_hidden;

pub type Attribute<'a> = (&'a str, &'a str);

#[derive(Debug, Default)]
pub struct Html {
    out: String,
    open: Vec<&'static str>,
}

impl Html {
    pub fn open(&mut self, name: &'static str, attributes: &[Attribute<'_>]) {
        self.tag(name, attributes);
        self.out.push('>');
        self.open.push(name);
    }

    /// Ends the element begun last.
    pub fn close(&mut self) {
        if let Some(name) = self.open.pop() {
            self.out.push_str("</");
            self.out.push_str(name);
            self.out.push_str(">\n");
        }
    }

    /// Ends elements until so many are open.
    pub fn close_until(&mut self, open: usize) {
        while self.open.len() > open {
            self.close();
        }
    }

    /// An element that holds nothing, such as an image.
    pub fn void(&mut self, name: &'static str, attributes: &[Attribute<'_>]) {
        self.tag(name, attributes);
        self.out.push_str("/>\n");
    }

    pub fn text(&mut self, text: &str) {
        self.out.push_str(&escaped(text));
    }

    pub fn element(&mut self, name: &'static str, attributes: &[Attribute<'_>], text: &str) {
        self.tag(name, attributes);
        self.out.push('>');
        self.text(text);
        self.out.push_str("</");
        self.out.push_str(name);
        self.out.push('>');
    }

    /// A box that scrolls by itself where what it holds is wider than the page.
    pub fn open_scroll(&mut self, label: &str) {
        let attributes =
            [("class", "scroll"), ("tabindex", "0"), ("role", "region"), ("aria-label", label)];
        self.open("div", &attributes);
    }

    /// A section with its heading, opened.
    pub fn open_section(&mut self, id: &str, title: &str) {
        let heading = format!("{id}-title");
        self.open("section", &[("id", id), ("aria-labelledby", &heading)]);
        self.element("h2", &[("id", &heading)], title);
    }

    /// A part that is folded until its summary is clicked, opened.
    pub fn open_details(&mut self, attributes: &[Attribute<'_>], summary: &str) {
        self.open("details", attributes);
        self.element("summary", &[], summary);
    }

    pub fn paragraph(&mut self, text: &str) {
        self.element("p", &[], text);
        self.out.push('\n');
    }

    /// A list of texts; nothing where there are none.
    pub fn list(&mut self, items: impl IntoIterator<Item = String>) {
        let mut items = items.into_iter().peekable();
        if items.peek().is_none() {
            return;
        }
        self.open("ul", &[]);
        for item in items {
            self.element("li", &[], &item);
        }
        self.close();
    }

    /// Terms and their descriptions.
    pub fn definitions<'t>(&mut self, of: impl IntoIterator<Item = (&'t str, impl AsRef<str>)>) {
        self.open("dl", &[]);
        for (term, description) in of {
            self.element("dt", &[], term);
            self.element("dd", &[], description.as_ref());
        }
        self.close();
    }

    /// A list with an item of mixed content for each.
    pub fn items<T>(
        &mut self,
        attributes: &[Attribute<'_>],
        items: impl IntoIterator<Item = T>,
        write: impl Fn(&mut Self, T),
    ) {
        self.open("ul", attributes);
        for item in items {
            self.open("li", &[]);
            write(self, item);
            self.close();
        }
        self.close();
    }

    /// Markup of our own making, such as a plot: must be well-formed.
    pub fn markup(&mut self, markup: &str) {
        self.out.push_str(markup);
    }

    /// Everything, all elements closed.
    pub fn finish(mut self) -> String {
        self.close_until(0);
        self.out
    }

    fn tag(&mut self, name: &str, attributes: &[Attribute<'_>]) {
        self.out.push('<');
        self.out.push_str(name);
        for (name, value) in attributes {
            self.out.push(' ');
            self.out.push_str(name);
            self.out.push_str("=\"");
            self.out.push_str(&escaped(value));
            self.out.push('"');
        }
    }
}

/// Text that may stand in an element or an attribute; what XML 1.0 cannot hold is replaced.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&apos;"),
            '\t' | '\n' | '\r' => out.push(' '),
            '\u{fffe}' | '\u{ffff}' => out.push(char::REPLACEMENT_CHARACTER),
            c if is_hidden(c) => out.push(char::REPLACEMENT_CHARACTER),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_and_elements_close() {
        let mut html = Html::default();
        html.open("div", &[("title", "\"<&>'")]);
        html.open("p", &[]);
        html.text("</div><script>alert(1)</script>\u{0}");
        let text = html.finish();
        let tree = roxmltree::Document::parse(&text).expect("well-formed");
        let div = tree.root_element();
        assert_eq!(div.attribute("title"), Some("\"<&>'"));
        assert_eq!(div.descendants().filter(|n| n.is_element()).count(), 2);
        assert_eq!(
            div.first_child().unwrap().text(),
            Some("</div><script>alert(1)</script>\u{fffd}")
        );
    }

    #[test]
    fn empty_lists_produce_no_html() {
        let mut html = Html::default();
        html.list(Vec::new());
        assert_eq!(html.finish(), "");
    }

    #[test]
    fn markup_and_control_characters() {
        assert_eq!(escaped("a<b>&\"'"), "a&lt;b&gt;&amp;&quot;&apos;");
        assert_eq!(escaped("é\n\u{7}"), "é \u{fffd}");
    }
}
