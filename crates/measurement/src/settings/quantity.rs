//! Counts as people write them: `5000`, `10k`, `2M`, `1e6`, `1_000`; and bytes: `8GiB`, `500MB`.

use std::ops::RangeInclusive;

use parse_size::{ByteSuffix, Config};

/// The suffixes, powers of 1000.
const SUFFIXES: [(&str, f64); 3] = [("k", 1e3), ("M", 1e6), ("G", 1e9)];

/// f64 cannot distinguish all counts above this.
const LARGEST: f64 = 9_007_199_254_740_992.0;

/// A parser for clap of counts within a range.
pub fn count(
    valid: RangeInclusive<u32>,
) -> impl Fn(&str) -> Result<u32, String> + Clone + Send + Sync + 'static {
    move |text| {
        let expected = || {
            format!(
                "expected a whole number from {} to {}: 500, 10k, 1e6",
                valid.start(),
                valid.end()
            )
        };
        let count = parse(text).ok_or_else(expected)?;
        u32::try_from(count).ok().filter(|n| valid.contains(n)).ok_or_else(expected)
    }
}

/// A whole number, exact; none where the text is none. Crate `parse-size` would round: 1.5 to 2,
/// and 1e-3 to 0.
pub fn parse(text: &str) -> Option<u64> {
    let with_suffix = SUFFIXES.iter().find_map(|(s, scale)| Some((text.strip_suffix(s)?, *scale)));
    let (number, scale) = with_suffix.unwrap_or((text, 1.0));
    let digit_first = number.starts_with(|c: char| c.is_ascii_digit());
    if !digit_first || number.ends_with('_') {
        return None;
    }
    let plain = number.replace('_', "");
    if scale == 1.0
        && let Ok(count) = plain.parse()
    {
        return Some(count);
    }
    let value = plain.parse::<f64>().ok()? * scale;
    (value.fract() == 0.0 && (0.0..=LARGEST).contains(&value)).then_some(value as u64)
}

/// Parses a size of memory for clap: a number with a unit, `8GiB`, `1.5GB`, `512 MiB`.
pub fn bytes(text: &str) -> Result<u64, String> {
    let expected = "expected a number with a unit: 8GiB, 1.5GB; units: TiB, GiB, MiB, KiB, TB, GB, \
                    MB, kB, B";
    let parsed = Config::new().with_byte_suffix(ByteSuffix::Require).parse_size(text);
    parsed.ok().filter(|bytes| *bytes > 0).ok_or_else(|| expected.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts() {
        for (text, expected) in [
            ("0", 0),
            ("5000", 5000),
            ("10k", 10_000),
            ("1.5k", 1500),
            ("2M", 2_000_000),
            ("1e6", 1_000_000),
            ("1_000", 1000),
            ("18446744073709551615", u64::MAX),
        ] {
            assert_eq!(parse(text), Some(expected), "{text}");
        }
        for bad in ["", "k", "-1", "1.5", "1e-3", "inf", "1e99", "10kk", "10 k", "+5", "1_", "0x10"]
        {
            assert_eq!(parse(bad), None, "{bad}");
        }
    }

    #[test]
    fn sizes_of_memory() {
        for (text, expected) in [
            ("8GiB", 8 << 30),
            ("1.5MiB", 3 << 19),
            ("512 MiB", 512 << 20),
            ("2GB", 2_000_000_000),
            ("10kB", 10_000),
            ("7B", 7),
            ("8gib", 8 << 30),
        ] {
            assert_eq!(bytes(text), Ok(expected), "{text}");
        }
        for bad in ["", "8", "GiB", "-1GiB", "0B", "infGiB", "nanB", "1e99TiB", "8 Gi B"] {
            assert!(bytes(bad).unwrap_err().contains("8GiB"), "{bad}");
        }
    }

    #[test]
    fn errors_name_the_valid_range() {
        let parse = count(1..=10_000);
        assert_eq!(parse("10k"), Ok(10_000));
        assert!(parse("11k").unwrap_err().contains("from 1 to 10000"));
        assert!(parse("0").is_err());
    }
}
