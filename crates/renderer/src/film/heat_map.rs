//! A heat map: a number for each pixel as an image, with a legend.
//!
//! The colours run from dark blue over green to yellow and grow evenly brighter, so that they can
//! be told apart in grey too; the anchors are those of viridis (S. van der Walt, N. Smith, 2015,
//! CC0). The scale is linear and ends at the 99.5th percentile: a single pixel that the system
//! interrupted must not darken all others.

use super::rgb_image::Image;

/// Rows of the legend below the image: bar and text.
const BAR: u32 = 12;
const GLYPH: [u32; 2] = [3, 5];
const MARGIN: u32 = 4;
/// The least width that the legend needs.
const LEAST_WIDTH: u32 = 128;

/// Colours in sRGB at equal distances.
const ANCHORS: [[u8; 3]; 9] = [
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

/// The image of `values` (row by row, `width` per row), with a legend that names their unit.
pub fn heat_map(values: &[f64], width: u32, unit: &str) -> Image {
    let width = width.max(1);
    let height = values.len() as u32 / width;
    let top = scale_end(values);
    // small images are enlarged by a whole factor, for the legend's sake
    let zoom = LEAST_WIDTH.div_ceil(width);
    let text = zoom.min(2).max(if width >= 256 { 2 } else { 1 });
    let (w, h) = (width * zoom, height * zoom);
    let legend = BAR + GLYPH[1] * text + 3 * MARGIN;
    let mut image =
        Image { width: w, height: h + legend, pixels: vec![[0.0; 3]; (w * (h + legend)) as usize] };
    for y in 0..h {
        for x in 0..w {
            let value = values[((y / zoom) * width + x / zoom) as usize];
            image.pixels[(y * w + x) as usize] = color(value / top);
        }
    }
    for y in h + MARGIN..h + MARGIN + BAR {
        for x in MARGIN..w - MARGIN {
            let share = f64::from(x - MARGIN) / f64::from(w - 2 * MARGIN - 1);
            image.pixels[(y * w + x) as usize] = color(share);
        }
    }
    let y = h + BAR + 2 * MARGIN;
    let right = format!(">={}", number(top));
    write(&mut image, [MARGIN, y], text, "0");
    write(&mut image, [centred(w, unit, text), y], text, unit);
    let end = w.saturating_sub(MARGIN + text_width(&right, text));
    write(&mut image, [end, y], text, &right);
    image
}

/// The 99.5th percentile, above 0.
fn scale_end(values: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|x| x.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let end = sorted.get(sorted.len().saturating_sub(1) * 199 / 200).copied().unwrap_or(0.0);
    if end > 0.0 { end } else { sorted.last().copied().filter(|x| *x > 0.0).unwrap_or(1.0) }
}

/// Linear colour of a share of the scale.
fn color(share: f64) -> [f64; 3] {
    let at = share.clamp(0.0, 1.0) * (ANCHORS.len() - 1) as f64;
    let i = (at as usize).min(ANCHORS.len() - 2);
    let f = at - i as f64;
    std::array::from_fn(|k| {
        let mixed = f64::from(ANCHORS[i][k]) * (1.0 - f) + f64::from(ANCHORS[i + 1][k]) * f;
        let x = mixed / 255.0;
        if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    })
}

fn number(x: f64) -> String {
    match x {
        x if x >= 1e6 => format!("{:.1}m", x / 1e6),
        x if x >= 1e4 => format!("{:.0}k", x / 1e3),
        x if x >= 10.0 => format!("{x:.0}"),
        x => format!("{x:.1}"),
    }
}

fn text_width(text: &str, zoom: u32) -> u32 {
    (text.chars().count() as u32 * (GLYPH[0] + 1) * zoom).saturating_sub(zoom)
}

fn centred(width: u32, text: &str, zoom: u32) -> u32 {
    width.saturating_sub(text_width(text, zoom)) / 2
}

/// Writes text in white; characters without a glyph leave a gap.
fn write(image: &mut Image, [x, y]: [u32; 2], zoom: u32, text: &str) {
    for (i, character) in text.chars().enumerate() {
        let bits = glyph(character);
        for row in 0..GLYPH[1] * zoom {
            for column in 0..GLYPH[0] * zoom {
                let bit = 14 - (row / zoom) * GLYPH[0] - column / zoom;
                let px = x + i as u32 * (GLYPH[0] + 1) * zoom + column;
                let place = (y + row) * image.width + px;
                if bits >> bit & 1 == 1
                    && px < image.width
                    && let Some(pixel) = image.pixels.get_mut(place as usize)
                {
                    *pixel = [1.0; 3];
                }
            }
        }
    }
}

/// Three columns by five rows, from the upper left, one bit each.
fn glyph(character: char) -> u16 {
    match character {
        '0' | 'o' => 0b111_101_101_101_111,
        '1' => 0b010_110_010_010_111,
        '2' => 0b111_001_111_100_111,
        '3' => 0b111_001_111_001_111,
        '4' => 0b101_101_111_001_001,
        '5' | 's' => 0b111_100_111_001_111,
        '6' => 0b111_100_111_101_111,
        '7' => 0b111_001_001_001_001,
        '8' => 0b111_101_111_101_111,
        '9' => 0b111_101_111_001_111,
        '.' => 0b000_000_000_000_010,
        '>' => 0b100_010_001_010_100,
        '=' => 0b000_111_000_111_000,
        '/' => 0b001_001_010_100_100,
        'a' => 0b010_101_111_101_101,
        'c' => 0b111_100_100_100_111,
        'd' => 0b110_101_101_101_110,
        'e' => 0b111_100_110_100_111,
        'i' => 0b111_010_010_010_111,
        'k' => 0b101_110_100_110_101,
        'l' => 0b100_100_100_100_111,
        'm' => 0b101_111_111_101_101,
        'n' => 0b111_101_101_101_101,
        'p' => 0b111_101_111_100_100,
        't' => 0b111_010_010_010_010,
        'u' => 0b101_101_101_101_111,
        'x' => 0b101_101_010_101_101,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_grow_brighter_and_the_legend_says_where_they_end() {
        let gray = |c: [f64; 3]| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
        let ramp: Vec<f64> = (0..=64).map(|i| gray(color(f64::from(i) / 64.0))).collect();
        assert!(ramp.windows(2).all(|w| w[0] < w[1]));
        assert_eq!(
            (number(3.25), number(999.6), number(12_345.0)),
            ("3.2".into(), "1000".into(), "12k".into())
        );
        assert_eq!(scale_end(&[0.0; 10]), 1.0);
        let mut values = vec![2.0; 1000];
        values[0] = 1e9;
        assert_eq!(scale_end(&values), 2.0);
    }

    #[test]
    fn the_image_shows_the_values_and_a_legend() {
        let values: Vec<f64> = (0..160 * 20).map(|i| f64::from(i % 160)).collect();
        let image = heat_map(&values, 160, "tests/pixel");
        assert_eq!((image.width, image.pixels.len()), (160, 160 * image.height as usize));
        assert!(image.height > 20);
        assert_eq!(image.pixels[0], color(0.0));
        let white = |image: &Image| image.pixels.iter().filter(|p| **p == [1.0; 3]).count();
        assert!(white(&image) > 50, "{}", white(&image));
        // planted fault: a legend without its unit has less text
        assert!(white(&heat_map(&values, 160, "")) < white(&image));
        // every letter of the units in use has a glyph
        for letter in "tests/pixel steps/pixel us/pixel k m".chars().filter(|c| *c != ' ') {
            assert_ne!(glyph(letter), 0, "{letter}");
        }
        assert_eq!(heat_map(&[1.0], 1, "").width, LEAST_WIDTH);
    }
}
