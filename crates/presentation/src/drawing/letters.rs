//! Letters as lines, for pictures that have no fonts.

/// Height of a capital in steps of the letters' grid.
const CAPITAL: f64 = 6.0;
/// The same as a part of a font's size, as in Helvetica.
const CAPITAL_OF_SIZE: f64 = 0.72;
/// Width of a step as a part of the size.
const STEP: f64 = 0.112;
/// Steps between two letters.
const GAP: f64 = 1.9;

/// The lines of a text that begins at (0, 0), in pixels to the right and down, and its width.
pub fn lines(text: &str, size: f64) -> (Vec<Vec<[f64; 2]>>, f64) {
    let up = size * CAPITAL_OF_SIZE / CAPITAL;
    let (mut out, mut x) = (Vec::new(), 0.0);
    for character in text.chars() {
        let strokes = strokes(character);
        let mut width = if strokes.is_empty() { 1.2 } else { 0.0 };
        for stroke in strokes.split(' ').filter(|stroke| !stroke.is_empty()) {
            let digits: Vec<f64> =
                stroke.chars().filter_map(|c| c.to_digit(10)).map(f64::from).collect();
            let mut line = Vec::new();
            for pair in digits.chunks_exact(2) {
                if let [across, height] = *pair {
                    width = across.max(width);
                    // the baseline is at height 2
                    line.push([(x + across) * size * STEP, (2.0 - height) * up]);
                }
            }
            out.push(line);
        }
        x += width + GAP;
    }
    (out, (x - GAP).max(0.0) * size * STEP)
}

/// Pairs of digits, to the right and up, joined; several lines with blanks between.
fn strokes(character: char) -> &'static str {
    match character {
        '!' => "0804 0202",
        '"' => "0806 2826",
        '#' => "1218 3238 0646 0444",
        '$' => "473818070615354443321203 2921",
        '%' => "0248 0818170708 3343423233",
        '&' => "4216172837360403123244",
        '\'' => "0806",
        '(' => "18070312",
        ')' => "08171302",
        '*' => "2723 0644 0446",
        '+' => "2723 0545",
        ',' => "1301",
        '-' | '\u{2013}' => "0535",
        '.' => "0202",
        '/' => "0248",
        '0' | 'O' => "183847433212030718",
        '1' => "071812 0222",
        '2' => "07183847460242",
        '3' => "0718384746354443321203 1535",
        '4' => "32380444",
        '5' => "480805354443321203",
        '6' => "4738180703123243443505",
        '7' => "084812",
        '8' => "15060718384746351504031232434435",
        '9' => "4515060718384743321203",
        ':' => "0606 0303",
        ';' => "1616 1301",
        '<' => "370533",
        '=' => "0636 0434",
        '>' => "073503",
        '?' => "07183847462524 2222",
        '@' => "433212030718384744242646",
        'A' => "022842 1434",
        'B' => "02083847463505 3544433202",
        'C' => "4738180703123243",
        'D' => "02083847433202",
        'E' => "48080242 0535",
        'F' => "480802 0535",
        'G' => "47381807031232434525",
        'H' => "0208 4248 0545",
        'I' => "0802",
        'J' => "3833221203",
        'K' => "0802 4805 1642",
        'L' => "080242",
        'M' => "0208254842",
        'N' => "02084248",
        'P' => "02083847463505",
        'Q' => "183847433212030718 2442",
        'R' => "02083847463505 2542",
        'S' => "473818070615354443321203",
        'T' => "0848 2822",
        'U' => "080312324348",
        'V' => "082248",
        'W' => "0812263248",
        'X' | '\u{d7}' => "0842 0248",
        'Y' => "082548 2522",
        'Z' => "08480242",
        '[' => "18080212",
        '\\' => "0842",
        ']' => "08181202",
        '^' => "062846",
        '_' => "0141",
        '`' => "0817",
        'a' => "0516263532 341403122233",
        'b' => "0802 0516263533221203",
        'c' => "3526160503122233",
        'd' => "3832 3526160503122233",
        'e' => "04343526160503122233",
        'f' => "281712 0626",
        'g' => "3631201001 3526160503122233",
        'h' => "0802 0516263532",
        'i' => "0602 0808",
        'j' => "161100 1818",
        'k' => "0802 3604 1532",
        'l' => "0802",
        'm' => "0602 05162522 25364542",
        'n' => "0602 0516263532",
        'o' => "162635332212030516",
        'p' => "0600 0516263533221203",
        'q' => "3630 3526160503122233",
        'r' => "0602 051626",
        's' => "35261605142433221203",
        't' => "181322 0626",
        'u' | '\u{b5}' | '\u{3bc}' => "0603122233 3632",
        'v' => "062246",
        'w' => "0612253246",
        'x' => "0632 0236",
        'y' => "0622 4610",
        'z' => "06360232",
        '{' => "28171605141322",
        '|' => "0802",
        '}' => "08171625141302",
        '~' => "05163445",
        ' ' => "",
        // what has none
        _ => "0848420208",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_has_its_own_strokes() {
        let printed: Vec<char> = ('!'..='~').collect();
        let drawn: Vec<_> = printed.iter().map(|&c| lines(&c.to_string(), 12.0)).collect();
        for (i, (lines, width)) in drawn.iter().enumerate() {
            assert!(!lines.is_empty() && lines.iter().all(|l| !l.is_empty()), "{}", printed[i]);
            assert!(*width <= 12.0 && strokes(printed[i]) != strokes('\u{1}'), "{}", printed[i]);
            let same = (0..i).filter(|&j| drawn[j].0 == *lines).map(|j| printed[j]);
            // as in many fonts
            let same: Vec<char> = same.filter(|c| !"0Il".contains(*c)).collect();
            assert!(same.is_empty(), "{} as {same:?}", printed[i]);
        }
        let (_, width) = lines("references in a cell", 12.0);
        assert!((90.0..130.0).contains(&width), "{width}");
    }
}
