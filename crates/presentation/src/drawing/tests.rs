use super::*;
use crate::svg_plot::palette::{INK, PAPER};

/// Lines, a box, a disc, an image, text that must be escaped.
fn all_kinds() -> Drawing {
    let red = [200, 0, 0];
    let fill = Paint { fill: Some((red, 1.0)), stroke: None };
    let line = Paint { fill: None, stroke: Some((red, 2.0)) };
    let items = vec![
        Item::Boxes(vec![[2.0, 2.0, 10.0, 6.0]], fill),
        Item::Lines { lines: vec![vec![[20.0, 5.0], [30.0, 5.0]]], are_closed: false, paint: line },
        Item::Lines {
            lines: vec![vec![[2.0, 20.0], [12.0, 20.0], [2.0, 30.0]]],
            are_closed: true,
            paint: fill,
        },
        Item::Disc { at: [25.0, 25.0], radius: 4.0, paint: fill },
        Item::Image([40.0, 2.0, 8.0, 4.0], 2, vec![[0, 0, 255], [0, 255, 0]]),
        Item::Text([40.0, 20.0], PLAIN, "a < b".into()),
    ];
    Drawing { size: [80.0, 40.0], alternative: "all & more".into(), items }
}

#[test]
fn colors_are_read() {
    assert_eq!((color(PAPER), color(INK)), ([255; 3], [0x22; 3]));
    assert_eq!(color("red"), [0; 3]);
}

#[test]
fn the_ramp_grows_brighter_and_classes_end_at_powers_of_two() {
    let gray =
        |c: Color| 0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2]);
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

#[test]
fn svg_is_well_formed_and_says_all() {
    let svg = all_kinds().svg().unwrap();
    let tree = roxmltree::Document::parse(&svg).unwrap();
    let count = |name: &str| tree.descendants().filter(|n| n.has_tag_name(name)).count();
    assert_eq!((count("path"), count("circle"), count("image"), count("text")), (3, 1, 1, 1));
    assert_eq!(tree.root_element().attribute("aria-label"), Some("all & more"));
    assert!(svg.contains("prefers-color-scheme: dark") && svg.contains("a &lt; b"));
    assert!(svg.contains("M2 2h10v6h-10z"), "{svg}");
}

#[test]
fn png_has_what_svg_has_at_the_same_places() {
    let drawing = all_kinds();
    let (width, pixels) = svg::drawn(&drawing.svg().unwrap(), 2.0).unwrap();
    assert_eq!((width, pixels.len()), (160, 160 * 80));
    let at = |x: f64, y: f64| pixels[(2.0 * y) as usize * 160 + (2.0 * x) as usize];
    let red = [200, 0, 0];
    for (x, y) in [(2.0, 2.0), (11.5, 7.5), (25.0, 5.0), (4.0, 22.0), (25.0, 25.0)] {
        assert_eq!(at(x, y), red, "{x} {y}");
    }
    for (x, y) in [(1.0, 1.0), (12.5, 5.0), (25.0, 8.0), (11.0, 28.0), (30.0, 30.0)] {
        assert_eq!(at(x, y), [255; 3], "{x} {y}");
    }
    assert_eq!((at(41.0, 3.0), at(46.0, 3.0)), ([0, 0, 255], [0, 255, 0]));
    let dark = |pixels: &[Color]| {
        pixels.iter().filter(|p| p[0] < 0x80 && p[0] == p[1] && p[1] == p[2]).count()
    };
    assert!(dark(&pixels) > 60, "{}", dark(&pixels));
    // planted fault: without its text
    let mut silent = drawing.clone();
    silent.items.pop();
    assert_eq!(dark(&svg::drawn(&silent.svg().unwrap(), 2.0).unwrap().1), 0);
    let png = drawing.png().unwrap();
    assert_eq!(&png[1..4], b"PNG");
}

#[test]
fn drawings_are_moved_as_a_whole() {
    let mut page = Drawing { size: [200.0, 100.0], ..Drawing::default() };
    page.add(all_kinds(), [100.0, 50.0]);
    let (width, pixels) = svg::drawn(&page.svg().unwrap(), 1.0).unwrap();
    let at = |x: usize, y: usize| pixels[y * width as usize + x];
    assert_eq!((at(105, 55), at(125, 75), at(5, 5)), ([200, 0, 0], [200, 0, 0], [255; 3]));
}

#[test]
fn odd_numbers_can_be_drawn() {
    let mut drawing = all_kinds();
    let paint = Paint { fill: Some(([1; 3], 1.0)), stroke: Some(([2; 3], f64::NAN)) };
    let odd = [f64::NAN, f64::INFINITY, -1e300];
    drawing.items.push(Item::Boxes(vec![[odd[0], odd[1], odd[2], 1.0]], paint));
    let lines = vec![odd.map(|x| [x, -x]).to_vec(), Vec::new()];
    drawing.items.push(Item::Lines { lines, are_closed: true, paint });
    drawing.items.push(Item::Disc { at: [odd[0], odd[1]], radius: odd[2], paint });
    drawing.items.push(Item::Image([0.0; 4], 0, Vec::new()));
    drawing.png().unwrap();
    assert_eq!(wrapped("ab cde f", 1.0, 12.0), ["ab", "cde", "f"]);
    assert_eq!(wrapped("ab cde f", 1e3, 12.0), ["ab cde f"]);
}
