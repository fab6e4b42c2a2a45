//! Samples far from the others: counted and shown, never dropped.
//!
//! Source: J. W. Tukey, "Exploratory Data Analysis", 1977: beyond 1.5 interquartile ranges from
//! the quartiles.

/// Distance of the fences from the quartiles, in interquartile ranges.
const FENCE: f64 = 1.5;
/// Fewer samples have no quartiles worth the name.
const FEWEST: usize = 4;

/// Samples beyond the fences: below, above.
pub fn outliers(samples: &[f64]) -> [usize; 2] {
    if samples.len() < FEWEST {
        return [0; 2];
    }
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (first, third) = (quantile(&sorted, 0.25), quantile(&sorted, 0.75));
    let range = third - first;
    let low = sorted.iter().filter(|&&x| x < first - FENCE * range).count();
    let high = sorted.iter().filter(|&&x| x > third + FENCE * range).count();
    [low, high]
}

/// A quantile of sorted samples, of which there is one at least, linear between them.
pub fn quantile(sorted: &[f64], part: f64) -> f64 {
    let place = part * (sorted.len() - 1) as f64;
    let (i, share) = (place.floor() as usize, place.fract());
    let next = sorted[(i + 1).min(sorted.len() - 1)];
    sorted[i] + (next - sorted[i]) * share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_beyond_the_fences_are_counted() {
        let mut samples = vec![10.0, 11.0, 12.0, 13.0, 14.0];
        assert_eq!(outliers(&samples), [0, 0]);
        samples.push(40.0);
        assert_eq!(outliers(&samples), [0, 1]);
        samples.push(-20.0);
        assert_eq!(outliers(&samples), [1, 1]);
        assert_eq!(outliers(&[1.0, 1.0, 1.0, 1.0, 1.0, 1.5]), [0, 1]);
        assert_eq!(outliers(&[1.0, 99.0, 1.0]), [0, 0]);
    }
}
