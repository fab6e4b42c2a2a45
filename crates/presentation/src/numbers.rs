//! Numbers and moments as people read them.

use statistics::estimate::Estimate;

/// Three significant digits without an exponent where that stays short.
pub fn short(x: f64) -> String {
    let magnitude = x.abs();
    match magnitude {
        _ if !x.is_finite() => "-".into(),
        0.0 => "0".into(),
        m if m >= 99.95 => format!("{x:.0}"),
        m if m >= 9.995 => format!("{x:.1}"),
        m if m >= 0.0995 => format!("{x:.2}"),
        m if m >= 0.000_995 => format!("{x:.4}"),
        _ => format!("{x:.1e}"),
    }
}

pub fn milliseconds(seconds: f64) -> String {
    short(seconds * 1e3)
}

pub fn mebibytes(bytes: u64) -> String {
    short(bytes as f64 / f64::from(1 << 20))
}

/// A figure with its interval.
pub fn interval(estimate: &Estimate) -> String {
    let Estimate { median, low, high } = *estimate;
    format!("{} [{}, {}]", short(median), short(low), short(high))
}

/// A ratio with its interval; `=` where the interval contains 1: no difference was measured.
pub fn ratio(estimate: &Estimate) -> String {
    let mark = if estimate.holds(1.0) { " =" } else { "  " };
    let Estimate { median, low, high } = *estimate;
    if median < 0.0995 {
        return interval(estimate) + mark;
    }
    format!("{median:.2} [{low:.2}, {high:.2}]{mark}")
}

/// Formats voxels per axis: `4x4x8`.
pub fn resolution(voxels: [u32; 3]) -> String {
    voxels.map(|n| n.to_string()).join("x")
}

/// `2026-11-22 01:30 UTC` of seconds since 1970.
pub fn utc(unix_s: u64) -> String {
    let (days, seconds) = ((unix_s / 86_400) as i64, unix_s % 86_400);
    // Julian day number of 1970-01-01: 2440588
    let julian = days.saturating_add(2_440_588);
    let f = julian + 1401 + (((4 * julian + 274_277) / 146_097) * 3) / 4 - 38;
    let e = 4 * f + 3;
    let h = 5 * ((e % 1461) / 4) + 2;
    let (day, month) = ((h % 153) / 5 + 1, (h / 153 + 2) % 12 + 1);
    let year = e / 1461 - 4716 + (14 - month) / 12;
    let (hour, minute) = (seconds / 3600, seconds / 60 % 60);
    format!("{year}-{month:02}-{day:02} {hour:02}:{minute:02} UTC")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_numbers() {
        for (x, text) in [
            (0.0, "0"),
            (1234.6, "1235"),
            (99.96, "100"),
            (12.34, "12.3"),
            (1.234, "1.23"),
            (0.1234, "0.12"),
            (0.01234, "0.0123"),
            (1.2e-5, "1.2e-5"),
            (f64::NAN, "-"),
        ] {
            assert_eq!(short(x), text);
        }
        assert_eq!(milliseconds(0.0123), "12.3");
        assert_eq!(mebibytes(3 << 19), "1.50");
    }

    #[test]
    fn ratios_say_when_there_is_no_difference() {
        let e = Estimate { median: 1.02, low: 0.98, high: 1.05 };
        assert_eq!(ratio(&e), "1.02 [0.98, 1.05] =");
        assert_eq!(ratio(&Estimate { low: 1.01, ..e }), "1.02 [1.01, 1.05]  ");
        let small = Estimate { median: 0.02, low: 0.019, high: 0.12 };
        assert_eq!(ratio(&small), "0.0200 [0.0190, 0.12]  ");
    }

    #[test]
    fn known_moments() {
        assert_eq!(utc(0), "1970-01-01 00:00 UTC");
        assert_eq!(utc(951_827_696), "2000-02-29 12:34 UTC");
        assert_eq!(utc(1_795_280_839), "2026-11-21 17:07 UTC");
        assert_eq!(utc(4_107_542_399), "2100-02-28 23:59 UTC");
        assert_eq!(utc(4_107_542_400), "2100-03-01 00:00 UTC");
    }
}
