//! Durations as people write them: `60s`, `2m`, `500ms`, `1.5m`, `2h30m`.

use std::time::Duration;

const EXPECTED: &str = "expected a number with a unit: 500ms, 60s, 1.5m, 2h30m";

/// The longest duration, seconds.
pub const LONGEST: u32 = 10_000_000;

/// Parses a duration for clap: numbers with units; a number alone is seconds.
pub fn parse(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().and_then(|s| Duration::try_from_secs_f64(s).ok());
    let duration = match seconds {
        Some(duration) => duration,
        None => humantime::parse_duration(text).map_err(|e| format!("{e}; {EXPECTED}"))?,
    };
    if !is_valid(duration) {
        return Err(format!("out of range; {EXPECTED}"));
    }
    Ok(duration)
}

/// Returns whether a setting may be that long.
pub fn is_valid(duration: Duration) -> bool {
    !duration.is_zero() && duration <= Duration::from_secs(LONGEST.into())
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
        assert_eq!(parse("0.123456789s"), Ok(Duration::from_nanos(123_456_789)));
        for bad in [
            "",
            "s",
            "-1s",
            "0s",
            "inf",
            "nans",
            "1e99s",
            "5 parsecs",
            "17w",
            "2h30",
            "1..5s",
            "99999999s",
        ] {
            assert!(parse(bad).is_err(), "{bad}");
        }
        assert!(parse("5 parsecs").unwrap_err().contains("parsecs"));
    }
}
