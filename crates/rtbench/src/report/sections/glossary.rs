//! What the symbols mean, and the papers.

use crate::report::glossary::MEANINGS;
use crate::report::material::Material;
use crate::report::page::{Page, SectionOutcome};
use presentation::html::Html;

/// The list, and the papers.
pub fn write(_: &Material, page: &mut Page) -> SectionOutcome {
    let html = &mut page.html;
    html.open("dl", &[]);
    for (symbol, meaning) in MEANINGS {
        html.element("dt", &[], symbol);
        html.element("dd", &[], meaning);
    }
    html.close();
    html.paragraph(
        "Times are medians over rounds; each round visits every row once, in seeded random order, \
         so that what disturbs a round disturbs all rows alike. Intervals are 95% bootstrap \
         percentile intervals (expanded, Hesterberg 2015); of fewer than six rounds they reach from \
         the least to the largest value. Each interval holds by itself: of many comparisons some \
         differ by chance. All answers are compared, and a wrong row shows no time.",
    );
    papers(html);
    SectionOutcome::Yes
}

fn papers(html: &mut Html) {
    html.list(
        [
            "V. Havran, F. Sixta, Comparison of Hierarchical Grids, Ray Tracing News 12(1), 1999: \
             counters and tables.",
            "G. Zachmann, lecture on ray tracing acceleration, 2007: the two tables of times.",
            "T. Hesterberg, What Teachers Should Know About the Bootstrap, The American Statistician \
             69(4), 2015: intervals.",
            "J. W. Tukey, Exploratory Data Analysis, 1977: outliers.",
        ]
        .map(str::to_owned),
    );
}
