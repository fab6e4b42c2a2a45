//! Cost of reaching an error by sampling: between two numbers of samples, time and error follow a
//! power law.

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledImage {
    /// Samples per pixel.
    pub samples: f64,
    /// Root mean square error.
    pub error: f64,
    pub seconds: f64,
}

/// Samples per pixel and seconds at which the samples reach an error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AtError {
    /// By interpolation between two that were measured.
    Reached {
        /// Samples per pixel.
        samples: f64,
        seconds: f64,
    },
    /// One sample per pixel is as good already.
    AtOnce {
        /// Seconds of the image with the fewest samples.
        seconds: f64,
    },
    /// None that was measured has an error so small.
    Never {
        /// The most samples measured.
        samples: f64,
        /// Their seconds: it takes longer than this.
        seconds: f64,
    },
}

/// Point at which a series by samples, ascending, first has an error of at most `error`.
pub fn at_error(series: &[SampledImage], error: f64) -> Option<AtError> {
    let (first, last) = (series.first()?, series.last()?);
    if first.error <= error {
        return Some(AtError::AtOnce { seconds: first.seconds });
    }
    let reached = series.windows(2).find(|pair| pair[1].error <= error);
    let Some([before, after]) = reached else {
        return Some(AtError::Never { samples: last.samples, seconds: last.seconds });
    };
    // an error of 0 is reached where it was measured
    let share = if after.error > 0.0 {
        (before.error / error).ln() / (before.error / after.error).ln()
    } else {
        1.0
    };
    let between = |a: f64, b: f64| a * (b / a).powf(share);
    Some(AtError::Reached {
        samples: between(before.samples, after.samples),
        seconds: between(before.seconds, after.seconds),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_laws_are_interpolated_exactly() {
        let series: Vec<SampledImage> = [1.0f64, 4.0, 16.0, 64.0]
            .map(|n| SampledImage { samples: n, error: 0.1 / n.sqrt(), seconds: 0.01 * n })
            .to_vec();
        let Some(AtError::Reached { samples, seconds }) = at_error(&series, 0.1 / 9f64.sqrt())
        else {
            panic!("it lies between 4 and 16 samples")
        };
        assert!((samples - 9.0).abs() < 1e-9 && (seconds - 0.09).abs() < 1e-12);
        assert_eq!(at_error(&series, 0.2), Some(AtError::AtOnce { seconds: 0.01 }));
        let never = AtError::Never { samples: 64.0, seconds: 0.64 };
        assert_eq!(at_error(&series, 0.001), Some(never));
        assert_eq!(at_error(&[], 0.1), None);
    }
}
