//! Rays as text: a ray a line, eight numbers each, in hexadecimal where every bit counts.

use std::path::{Path, PathBuf};

use accel_core::Ray;
use glam::DVec3;

#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}:{line}: {what}", file.display())]
pub struct RayTextError {
    pub file: PathBuf,
    pub line: usize,
    pub what: String,
}

/// A number as C's `%a` writes it, and C and [`number`] read it: all bits, nothing rounded.
pub fn hexadecimal(x: f64) -> String {
    let sign = if x.is_sign_negative() { "-" } else { "" };
    if x.is_nan() {
        return "nan".into();
    }
    if x.is_infinite() {
        return format!("{sign}inf");
    }
    let bits = x.abs().to_bits();
    let (fraction, exponent) = (bits & ((1 << 52) - 1), (bits >> 52) as i64);
    let (first, exponent) = match exponent {
        0 if fraction == 0 => (0, 0),
        0 => (0, -1022),
        _ => (1, exponent - 1023),
    };
    let digits = format!("{fraction:013x}");
    let digits = digits.trim_end_matches('0');
    let point = if digits.is_empty() { "" } else { "." };
    format!("{sign}0x{first}{point}{digits}p{exponent:+}")
}

/// Reads a decimal number, or a hexadecimal one that f64 holds exactly.
pub fn number(text: &str) -> Option<f64> {
    let (sign, rest) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    let Some(digits) = rest.strip_prefix("0x").or_else(|| rest.strip_prefix("0X")) else {
        return text.parse().ok();
    };
    let (mantissa, exponent) = digits.split_once(['p', 'P']).unwrap_or((digits, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let all = format!("{whole}{fraction}");
    let value = u64::from_str_radix(&all, 16).ok().filter(|m| *m <= 1 << 53)? as f64;
    let power = exponent.parse::<i32>().ok()?.checked_sub(4 * fraction.len() as i32)?;
    // in two steps: the power alone may be none of f64
    let half = power.clamp(-4000, 4000) / 2;
    let scaled = value * 2f64.powi(half.clamp(-1000, 1000));
    let rest = power.clamp(-4000, 4000) - half.clamp(-1000, 1000);
    let scaled = sign * scaled * 2f64.powi(rest);
    scaled.is_finite().then_some(scaled)
}

/// A ray as a line without its end.
pub fn line(ray: &Ray<f64>) -> String {
    let ([x, y, z], [a, b, c]) = (ray.origin.to_array(), ray.direction.to_array());
    [x, y, z, ray.t_min, a, b, c, ray.t_max].map(hexadecimal).join(" ")
}

/// Reads rays, one a line: origin, t_min, direction, t_max. Empty lines and what follows a `#` are
/// left out.
///
/// # Errors
/// [`RayTextError`] for the first line that is no ray.
pub fn read(file: &Path, text: &str) -> Result<Vec<Ray<f64>>, RayTextError> {
    let mut rays = Vec::new();
    for (line, i) in text.lines().zip(1..) {
        let wrong = |what| RayTextError { file: file.into(), line: i, what };
        let words: Vec<&str> =
            line.split('#').next().unwrap_or_default().split_whitespace().collect();
        if words.is_empty() {
            continue;
        }
        let &[x, y, z, t_min, a, b, c, t_max] = words.as_slice() else {
            let expected = "expected eight: origin, t_min, direction, t_max";
            return Err(wrong(format!("{} numbers, {expected}", words.len())));
        };
        let read = |word: &str| number(word).ok_or_else(|| wrong(format!("'{word}' is no number")));
        let origin = DVec3::new(read(x)?, read(y)?, read(z)?);
        let direction = DVec3::new(read(a)?, read(b)?, read(c)?);
        let (t_min, t_max) = (read(t_min)?, read(t_max)?);
        rays.push(Ray { t_min, t_max, ..Ray::new(origin, direction) });
    }
    Ok(rays)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_comes_back() {
        let numbers = [
            (1.0, "0x1p+0"),
            (-0.0, "-0x0p+0"),
            (0.1, "0x1.999999999999ap-4"),
            (f64::from(f32::MIN_POSITIVE / 2.0), "0x1p-127"),
            (f64::from_bits(1), "0x0.0000000000001p-1022"),
            (-f64::MAX, "-0x1.fffffffffffffp+1023"),
            (f64::INFINITY, "inf"),
        ];
        for (x, text) in numbers {
            assert_eq!(hexadecimal(x), text);
            assert_eq!(number(text).map(f64::to_bits), Some(x.to_bits()), "{text}");
        }
        assert_eq!(number("0x10.8p1"), Some(33.0));
        for bad in ["", "0x", "0x1p", "0x1.ffffffffffffffp+0", "0x1p+1024", "0x1p99999999999", "1x"]
        {
            assert_eq!(number(bad), None, "{bad}");
        }
    }

    #[test]
    fn rays_are_read_as_written_and_bad_lines_are_named() {
        let mut ray = Ray::new(DVec3::new(0.1, -0.0, 1e-40), DVec3::new(0.0, 0.0, -3.0));
        (ray.t_min, ray.t_max) = (-1.0, 1e30);
        let text = format!("# two\n{}\n\n0 0 0 0 1 0 0 inf # along x\n", line(&ray));
        let read = |text: &str| super::read(Path::new("a.rays"), text);
        let rays = read(&text).unwrap();
        assert_eq!(rays, [ray, Ray::new(DVec3::ZERO, DVec3::X)]);
        assert!(rays[0].origin.y.is_sign_negative());
        let error = read("1 2 3 4 5 6 7 8\n1 2 3\n").unwrap_err().to_string();
        assert!(error.starts_with("a.rays:2: 3 numbers, expected eight"), "{error}");
        let error = read("1 2 3 4 5 6 7 8,\n").unwrap_err().to_string();
        assert_eq!(error, "a.rays:1: '8,' is no number");
    }
}
