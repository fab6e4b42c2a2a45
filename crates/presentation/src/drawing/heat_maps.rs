//! Heat maps side by side: a number for each pixel as a colour, on one scale for all, with its
//! legend; beside them the image that they are of.
//!
//! The scale is logarithmic. It ends at the 99.5th percentile of all maps together, since a single
//! pixel that the system interrupted must not darken all others, and begins at the smallest number
//! above 0, at most [`DECADES`] decades below.

use crate::drawing::item::{Color, Drawing, Item, Paint, color, wrapped};
use crate::svg_plot::pen::{Font, GREY, PLAIN};

/// Room around and between.
const MARGIN: f64 = 16.0;
const LINE: f64 = 16.0;
/// Height of the legend's bar.
const BAR: f64 = 12.0;
/// The legend is no narrower.
const LEAST: f64 = 160.0;
/// Images of more pixels are drawn half as large.
const LARGE: u32 = 512;
const DECADES: i32 = 4;

#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    /// Title above the map.
    pub name: String,
    /// Numbers, row by row from above.
    pub values: Vec<f64>,
    /// Numbers in a row.
    pub width: u32,
}

/// What stands side by side: a rendered image, or a map in colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Title above it.
    pub name: String,
    /// Pixels, row by row from above.
    pub pixels: Vec<Color>,
    /// Pixels in a row.
    pub width: u32,
}

/// The image, if there is one, and the maps, from left to right, under a title.
pub fn heat_maps(title: &str, unit: &str, image: Option<&Panel>, maps: &[HeatMap]) -> Drawing {
    let scale = Scale::of(maps.iter().flat_map(|map| map.values.iter().copied()));
    let colored = |map: &HeatMap| Panel {
        name: named(map),
        pixels: map.values.iter().map(|value| ramp(scale.share(*value))).collect(),
        width: map.width,
    };
    let panels: Vec<Panel> = image.into_iter().cloned().chain(maps.iter().map(colored)).collect();
    let mut drawing = Drawing { alternative: title.to_owned(), ..Drawing::default() };
    let size = |panel: &Panel| {
        let width = panel.width.max(1);
        let zoom = if width >= LARGE { 0.5 } else { (LEAST / f64::from(width)).ceil().max(1.0) };
        [f64::from(width) * zoom, (panel.pixels.len() as u32 / width) as f64 * zoom]
    };
    let names: Vec<Vec<String>> =
        panels.iter().map(|panel| wrapped(&panel.name, size(panel)[0], 12.0)).collect();
    let lines = names.iter().map(Vec::len).max().unwrap_or(0);
    let wide: f64 = panels.iter().map(|panel| size(panel)[0] + MARGIN).sum::<f64>() - MARGIN;
    let titles = wrapped(title, wide.max(LEAST), 14.0);
    let mut y = MARGIN;
    for line in &titles {
        y += LINE;
        drawing.text([MARGIN, y - 3.0], Font { size: 14.0, is_bold: true, ..PLAIN }, line.as_str());
    }
    let tops = y + 4.0;
    y = tops + LINE * lines as f64 + 4.0;
    let (mut x, mut lowest) = (MARGIN, y);
    for (panel, names) in panels.into_iter().zip(names) {
        for (i, name) in names.into_iter().enumerate() {
            drawing.text([x, tops + LINE * (i + 1) as f64 - 3.0], PLAIN, name);
        }
        let [width, height] = size(&panel);
        let at = [x, y, width, height];
        drawing.items.push(Item::Image(at, panel.width.max(1), panel.pixels));
        x += width + MARGIN;
        lowest = f64::max(lowest, y + height);
    }
    let right = (x - MARGIN).max(MARGIN + LEAST);
    y = lowest + 10.0;
    legend(&mut drawing, [MARGIN, y, right], unit, scale);
    drawing.size = [right + MARGIN, y + BAR + LINE + MARGIN];
    drawing
}

/// Its name and the mean of its numbers.
fn named(map: &HeatMap) -> String {
    let mean = map.values.iter().sum::<f64>() / map.values.len().max(1) as f64;
    format!("{}: mean {}", map.name, number(mean))
}

fn legend(drawing: &mut Drawing, [left, y, right]: [f64; 3], unit: &str, scale: Scale) {
    const PARTS: usize = 64;
    let width = (right - left) / PARTS as f64;
    for part in 0..PARTS {
        let fill = Some((ramp(part as f64 / (PARTS - 1) as f64), 1.0));
        let at = [left + width * part as f64, y, width + 0.2, BAR];
        drawing.items.push(Item::Boxes(vec![at], Paint { fill, stroke: None }));
    }
    let frame = Paint { fill: None, stroke: Some((color(GREY), 0.5)) };
    drawing.items.push(Item::Boxes(vec![[left, y, right - left, BAR]], frame));
    let base = y + BAR + LINE - 3.0;
    drawing.text([left, base], PLAIN, format!("<= {}", number(scale.low)));
    let font = Font { anchor: "middle", ..PLAIN };
    drawing.text([0.5 * (left + right), base], font, format!("{unit}, logarithmic"));
    let end = format!(">= {}", number(scale.high));
    drawing.text([right, base], Font { anchor: "end", ..PLAIN }, end);
}

/// Ends of the logarithmic scale, 0 < low < high.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Scale {
    low: f64,
    high: f64,
}

impl Scale {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.filter(|x| x.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let above_zero = |x: &f64| *x > 0.0;
        let percentile = sorted.get(sorted.len().saturating_sub(1) * 199 / 200).copied();
        let largest = || sorted.last().copied().filter(above_zero).unwrap_or(1.0);
        let high = percentile.filter(above_zero).unwrap_or_else(largest);
        let smallest = sorted.iter().copied().find(above_zero).unwrap_or(high);
        Self { low: smallest.clamp(high / 10f64.powi(DECADES), high / 2.0), high }
    }

    /// Position on the scale: 0 at its low end, 1 at its high end.
    fn share(self, value: f64) -> f64 {
        (value / self.low).ln() / (self.high / self.low).ln()
    }
}

fn number(x: f64) -> String {
    match x {
        x if x >= 1e6 => format!("{:.1}M", x / 1e6),
        x if x >= 1e4 => format!("{:.0}k", x / 1e3),
        x if x >= 10.0 => format!("{x:.0}"),
        x => format!("{x:.1}"),
    }
}

/// Colours in sRGB at equal distances.
const ANCHORS: [Color; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// The colour of a share of the scale, from 0 (dark) to 1 (bright).
pub fn ramp(share: f64) -> Color {
    let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
    let at = share * (ANCHORS.len() - 1) as f64;
    let i = (at as usize).min(ANCHORS.len() - 2);
    let f = at - i as f64;
    let [low, high] = [i, i + 1].map(|i| ANCHORS.get(i).copied().unwrap_or_default());
    let mixed = |(a, b): (u8, u8)| (f64::from(a) * (1.0 - f) + f64::from(b) * f).round() as u8;
    let mut all = low.into_iter().zip(high).map(mixed);
    std::array::from_fn(|_| all.next().unwrap_or(0))
}

/// Classes of positive integers that end at powers of two: 1, 2, 3-4, 5-8, ...; small numbers are
/// bright, large ones dark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Classes {
    count: u32,
}

impl Classes {
    /// As many as numbers up to `most` need.
    pub fn up_to(most: u64) -> Self {
        Self { count: Self::class(most) + 1 }
    }

    fn class(n: u64) -> u32 {
        n.max(1).next_power_of_two().trailing_zeros()
    }

    /// The class of a number, from 0.
    pub fn of(self, n: u64) -> u32 {
        Self::class(n).min(self.count - 1)
    }

    pub fn count(self) -> u32 {
        self.count
    }

    pub fn color(self, class: u32) -> Color {
        let last = self.count.saturating_sub(1).max(1);
        // the brightest would be lost on white, the darkest hides lines
        ramp(0.97 - 0.92 * f64::from(class) / f64::from(last))
    }

    pub fn label(class: u32) -> String {
        match class {
            0 | 1 => (class + 1).to_string(),
            _ => format!("{}-{}", (1u64 << (class - 1)) + 1, 1u64 << class),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_ends_where_all_maps_together_do() {
        let numbers = |x: f64| number(x);
        assert_eq!([3.25, 999.6, 12_345.0].map(numbers), ["3.2", "1000", "12k"]);
        assert_eq!(Scale::of([0.0; 10].into_iter()).high, 1.0);
        let mut values = vec![2.0; 1000];
        values[0] = 1e9;
        assert_eq!(Scale::of(values.into_iter()).high, 2.0);
    }

    #[test]
    fn equal_factors_are_equal_steps_of_the_scale() {
        let scale = Scale::of([0.0, 1.0, 10.0, 100.0, 100.0].into_iter());
        assert_eq!(scale, Scale { low: 1.0, high: 100.0 });
        assert_eq!([1.0, 10.0, 100.0].map(|x| scale.share(x)), [0.0, 0.5, 1.0]);
        assert_eq!([0.0, 1e9].map(|x| ramp(scale.share(x))), [ramp(0.0), ramp(1.0)]);
        // tiny numbers do not take the scale
        assert_eq!(Scale::of([1e-30, 1.0, 1.0].into_iter()).low, 1e-4);
    }

    #[test]
    fn equal_numbers_have_one_colour_in_all_maps() {
        let map = |name: &str, values: Vec<f64>| HeatMap { name: name.into(), values, width: 8 };
        let maps = [map("a", vec![4.0; 64]), map("b", (0..64).map(f64::from).collect())];
        let photo = Panel { name: "image".into(), pixels: vec![[9; 3]; 64], width: 8 };
        let drawn = heat_maps("tests per pixel", "tests", Some(&photo), &maps);
        let images: Vec<_> = drawn
            .items
            .iter()
            .filter_map(|item| match item {
                Item::Image(_, width, pixels) => Some((*width, pixels.clone())),
                _ => None,
            })
            .collect();
        assert_eq!(images.len(), 3);
        assert_eq!(images[0].1, photo.pixels);
        assert_eq!(images[1], (8, vec![images[2].1[4]; 64]));
        // planted fault: each on a scale of its own
        let alone = heat_maps("tests per pixel", "tests", None, &maps[..1]);
        let image = alone.items.iter().find_map(|item| match item {
            Item::Image(_, _, pixels) => Some(pixels.clone()),
            _ => None,
        });
        assert_ne!(image.unwrap(), images[1].1);
        let texts: Vec<_> = drawn
            .items
            .iter()
            .filter_map(|item| match item {
                Item::Text(_, _, text) => Some(text.as_str()),
                _ => None,
            })
            .collect();
        let scale = ["<= 1.0", "tests, logarithmic", ">= 62"];
        assert_eq!(texts[..4], ["tests per pixel", "image", "a: mean 4.0", "b: mean 32"]);
        assert_eq!(texts[4..], scale);
    }

    #[test]
    fn the_ramp_grows_brighter_and_classes_end_at_powers_of_two() {
        let gray = |c: Color| {
            0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2])
        };
        let all: Vec<f64> = (0..=64).map(|i| gray(ramp(f64::from(i) / 64.0))).collect();
        assert!(all.windows(2).all(|w| w[0] < w[1]), "{all:?}");
        let classes = Classes::up_to(100);
        assert_eq!(classes.count(), 8);
        assert_eq!(
            [1, 2, 3, 4, 5, 8, 9, 100, 5000].map(|n| classes.of(n)),
            [0, 1, 2, 2, 3, 3, 4, 7, 7]
        );
        let labels: Vec<_> = (0..5).map(Classes::label).collect();
        assert_eq!(labels, ["1", "2", "3-4", "5-8", "9-16"]);
        for n in 1..30 {
            let classes = Classes::up_to(1 << n);
            let greys: Vec<f64> = (0..=n).map(|class| gray(classes.color(class))).collect();
            assert!(greys.windows(2).all(|w| w[0] > w[1]), "{n}: {greys:?}");
        }
    }
}
