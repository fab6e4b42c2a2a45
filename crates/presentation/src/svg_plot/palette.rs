//! The colours of plots. A page that is read in the dark replaces them by these names' others.

pub const INK: &str = "#222222";
/// Text of less weight.
pub const GREY: &str = "#707070";
pub const GRID: &str = "#e4e4e4";
pub const PAPER: &str = "#ffffff";
pub const BEST: &str = "#137a3a";
/// Marks that belong to no series.
pub const MARK: &str = "#b4560a";
/// Colours of series, used in turn; distinguishable for colour-blind readers too.
pub const SERIES: [&str; 5] = ["#1f5fa8", "#8c3f97", "#4d8f8b", "#a3842c", "#555555"];

/// Patterns of the lines of series, as attributes: where the colours begin anew, the next one.
pub const DASHES: [&str; 4] = [
    "",
    " stroke-dasharray=\"7 3\"",
    " stroke-dasharray=\"2 3\"",
    " stroke-dasharray=\"10 3 2 3\"",
];

/// Colour and pattern of the series at a place.
pub fn style_of(place: usize) -> (&'static str, &'static str) {
    let of = |list: &[&'static str], i: usize| list.iter().copied().cycle().nth(i % list.len());
    let dashes = of(&DASHES, place / SERIES.len());
    (of(&SERIES, place).unwrap_or(INK), dashes.unwrap_or_default())
}

/// Each colour and what stands for it on a dark ground.
pub const IN_THE_DARK: [(&str, &str); 11] = [
    (INK, "#e8e8e8"),
    (GREY, "#b0b0b0"),
    (GRID, "#3a3f47"),
    (PAPER, "#16191d"),
    (BEST, "#5fd38d"),
    (MARK, "#f0a35e"),
    (SERIES[0], "#7ab8ff"),
    (SERIES[1], "#d69be0"),
    (SERIES[2], "#7fc9c4"),
    (SERIES[3], "#dcc06a"),
    (SERIES[4], "#c0c0c0"),
];

/// Style rules that draw the plots within `selector` in those colours.
pub fn dark_rules(selector: &str) -> String {
    let rule = |(light, dark): &(&str, &str)| {
        format!(
            "{selector} [fill=\"{light}\"]{{fill:{dark}}}{selector} [stroke=\"{light}\"]\
             {{stroke:{dark}}}"
        )
    };
    IN_THE_DARK.iter().map(rule).collect()
}
