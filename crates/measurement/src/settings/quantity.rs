//! Counts as people write them: `5000`, `10k`, `2M`, `1e6`, `1_000`; bytes: `8GiB`, `500MB`; and
//! durations: `90s`, `2m`.

use parse_size::{ByteSuffix, Config};
use std::ops::RangeInclusive;
use std::time::Duration;

/// The suffixes, powers of 1000.
const SUFFIXES: [(&str, f64); 3] = [("k", 1e3), ("M", 1e6), ("G", 1e9)];

/// f64 cannot distinguish all counts above this.
const LARGEST: f64 = 9_007_199_254_740_992.0;

/// A parser for clap of counts within a range.
pub fn count(
    valid: RangeInclusive<u32>,
) -> impl Fn(&str) -> Result<u32, String> + Clone + Send + Sync + 'static {
    move |text| {
        let (least, most) = (valid.start(), valid.end());
        let expected = || format!("expected a whole number from {least} to {most}: 500, 10k, 1e6");
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

const EXPECTED: &str = "expected a number with a unit: 500ms, 60s, 1.5m, 2h30m";

/// The longest duration, seconds.
pub const LONGEST_DURATION: u32 = 10_000_000;

/// Parses a duration for clap: numbers with units; a number alone is seconds.
pub fn duration(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().and_then(|s| Duration::try_from_secs_f64(s).ok());
    let duration = match seconds {
        Some(duration) => duration,
        None => humantime::parse_duration(text).map_err(|e| format!("{e}; {EXPECTED}"))?,
    };
    if !is_duration(duration) {
        return Err(format!("out of range; {EXPECTED}"));
    }
    Ok(duration)
}

/// Returns whether a setting may be that long.
pub fn is_duration(duration: Duration) -> bool {
    !duration.is_zero() && duration <= Duration::from_secs(LONGEST_DURATION.into())
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
        for bad in ",k,-1,1.5,1e-3,inf,1e99,10kk,10 k,+5,1_,0x10".split(',') {
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

    #[test]
    fn durations() {
        for (text, expected) in [
            ("60s", 60_000),
            ("60", 60_000),
            ("1.5m", 90_000),
            ("500ms", 500),
            ("2h30m", 9_000_000),
            ("1m 30s", 90_000),
            ("1min", 60_000),
            ("1h0.5s", 3_600_500),
        ] {
            assert_eq!(duration(text), Ok(Duration::from_millis(expected)), "{text}");
        }
        assert_eq!(duration("0.123456789s"), Ok(Duration::from_nanos(123_456_789)));
        for bad in ",s,-1s,0s,inf,nans,1e99s,5 parsecs,17w,2h30,1..5s,99999999s".split(',') {
            assert!(duration(bad).is_err(), "{bad}");
        }
        assert!(duration("5 parsecs").unwrap_err().contains("parsecs"));
    }
}
