//! Durations as people write them: `60s`, `2m`, `500ms`, `1.5m`, `2h30m`.

use std::time::Duration;

/// What is valid.
const EXPECTED: &str = "expected a number with a unit: 500ms, 60s, 1.5m, 2h30m";

/// The units, largest first, in seconds.
const UNITS: [(&str, f64); 6] =
    [("h", 3600.0), ("m", 60.0), ("min", 60.0), ("s", 1.0), ("ms", 1e-3), ("us", 1e-6)];

/// Parses a duration for clap: numbers with units, larger units first; a number alone is seconds.
///
/// # Errors
/// A message that says what is valid.
pub fn parse(text: &str) -> Result<Duration, String> {
    let mut rest = text.trim();
    let mut seconds = 0.0;
    let mut scale_before = f64::INFINITY;
    while !rest.is_empty() {
        let is_number = |c: char| c.is_ascii_digit() || c == '.';
        let (number, behind) = split(rest, is_number);
        let (unit, behind) = split(behind, |c| !is_number(c) && c != ' ');
        rest = behind.trim_start();
        let scale = match unit {
            "" if rest.is_empty() && scale_before.is_infinite() => 1.0,
            "" => return Err(EXPECTED.to_owned()),
            _ => {
                let known = UNITS.iter().find(|(name, _)| *name == unit);
                known.ok_or_else(|| format!("unknown unit '{unit}'; {EXPECTED}"))?.1
            }
        };
        if scale >= scale_before {
            return Err(format!("larger units come first, each once; {EXPECTED}"));
        }
        seconds += number.parse::<f64>().map_err(|_| EXPECTED.to_owned())? * scale;
        scale_before = scale;
    }
    match Duration::try_from_secs_f64(seconds) {
        Ok(duration) if duration > Duration::ZERO && seconds <= 1e7 => Ok(duration),
        _ => Err(format!("out of range; {EXPECTED}")),
    }
}

/// The characters of a kind at the front, and the rest.
fn split(text: &str, is_kind: impl Fn(char) -> bool) -> (&str, &str) {
    let end = text.find(|c| !is_kind(c)).unwrap_or(text.len());
    text.split_at(end)
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert_eq!(parse(text), Ok(Duration::from_millis(expected)), "{text}");
        }
        for bad in [
            "",
            "s",
            "-1s",
            "0s",
            "inf",
            "nans",
            "1e99s",
            "5 parsecs",
            "1d",
            "30m2h",
            "1m1m",
            "2h30",
            "1..5s",
            "99999999s",
        ] {
            assert!(parse(bad).is_err(), "{bad}");
        }
        assert!(parse("30m2h").unwrap_err().contains("larger units come first"));
    }
}
