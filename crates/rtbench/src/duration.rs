//! Durations as typed: `60s`, `2m`, `500ms`, `1.5m`.

use std::time::Duration;

/// What is valid.
const EXPECTED: &str = "expected a number with a unit: 500ms, 60s, 2m";

/// Parses a duration for clap.
///
/// # Errors
/// A message that says what is valid.
pub fn parse(text: &str) -> Result<Duration, String> {
    let (number, unit) = match text.find(|c: char| c.is_ascii_alphabetic()) {
        Some(at) => text.split_at(at),
        None => (text, "s"),
    };
    let scale = match unit {
        "ms" => 1e-3,
        "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(format!("unknown unit '{unit}'; {EXPECTED}")),
    };
    let seconds = number.parse::<f64>().map_err(|_| EXPECTED.to_owned())? * scale;
    match Duration::try_from_secs_f64(seconds) {
        Ok(duration) if duration > Duration::ZERO && seconds <= 1e7 => Ok(duration),
        _ => Err(format!("out of range; {EXPECTED}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations() {
        assert_eq!(parse("60s"), Ok(Duration::from_secs(60)));
        assert_eq!(parse("60"), Ok(Duration::from_secs(60)));
        assert_eq!(parse("1.5m"), Ok(Duration::from_secs(90)));
        assert_eq!(parse("500ms"), Ok(Duration::from_millis(500)));
        for bad in ["", "s", "-1s", "0s", "inf", "nans", "1e99s", "5 parsecs", "1d"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }
}
