//! The frame of a figure.

use crate::svg_plot::palette::PAPER;
use crate::svg_plot::xml;

/// A picture of that size, and what it is for those who cannot see it.
pub fn document_of(body: &str, [width, height]: [f64; 2], alternative: &str) -> String {
    let height = f64::max(height, 1.0);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
         viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"Helvetica, Arial, sans-serif\" \
         role=\"img\" aria-label=\"{}\">\n<rect width=\"100%\" height=\"100%\" \
         fill=\"{PAPER}\"/>\n{body}</svg>\n",
        xml::escaped(alternative)
    )
}
