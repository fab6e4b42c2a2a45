//! Text inside XML.

use crate::outside::is_hidden;
use crate::svg_plot::palette::PAPER;

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

/// A picture of that size, and what it is for those who cannot see it.
pub fn document_of(body: &str, [width, height]: [f64; 2], alternative: &str) -> String {
    let height = f64::max(height, 1.0);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
         viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"Helvetica, Arial, sans-serif\" \
         role=\"img\" aria-label=\"{}\">\n<rect width=\"100%\" height=\"100%\" \
         fill=\"{PAPER}\"/>\n{body}</svg>\n",
        escaped(alternative)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_and_control_characters() {
        assert_eq!(escaped("a<b>&\"'"), "a&lt;b&gt;&amp;&quot;&apos;");
        assert_eq!(escaped("é\n\u{7}"), "é \u{fffd}");
    }
}
