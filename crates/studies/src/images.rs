//! Images of the studies: planned within the memory limit; how far one is from the one it should be;
//! and the converged images to compare with.

use measurement::plan::error::PlanError;
use renderer::effects::plan::MOST_SAMPLES_PER_PIXEL;
use renderer::{EffectPlan, Image, RenderSettings};
use scene_loading::Scene;

/// An error must be this many times that of a reference to be significantly different.
pub const TIMES_REFERENCE: f64 = 10.0;

/// From this difference to a direct neighbour on, in any channel, a pixel is one of an edge.
const EDGE: f64 = 0.05;

/// Root of the mean square difference over all channels of the pixels that `counts`, of two images
/// of one size; 0 where it counts none.
fn rmse_over(a: &Image, b: &Image, mut counts: impl FnMut(usize) -> bool) -> f64 {
    let (mut sum, mut channels) = (0.0, 0usize);
    for (i, (p, q)) in a.pixels.iter().zip(&b.pixels).enumerate() {
        if counts(i) {
            sum += p.iter().zip(q).map(|(x, y)| (x - y) * (x - y)).sum::<f64>();
            channels += 3;
        }
    }
    (sum / channels.max(1) as f64).sqrt()
}

/// Root mean square error over all pixels and channels, linear.
pub fn rmse(a: &Image, b: &Image) -> f64 {
    rmse_over(a, b, |_| true)
}

/// The same over the pixels of `edges` alone; none where there is no edge.
pub fn edge_rmse(a: &Image, b: &Image, edges: &[bool]) -> Option<f64> {
    let is_edge = |i: usize| edges.get(i).copied().unwrap_or(false);
    edges.contains(&true).then(|| rmse_over(a, b, is_edge))
}

/// A converged image: many samples per pixel, of two seeds, so that its own error is known.
#[derive(Debug, Clone, PartialEq)]
pub struct ConvergedImage {
    /// The mean of both.
    pub image: Image,
    /// Its own error: half the root mean square difference of the two.
    pub own_error: f64,
}

impl ConvergedImage {
    /// From two images of one size, with samples of unlike seeds.
    pub fn of(first: &Image, second: &Image) -> Self {
        let own_error = rmse(first, second) / 2.0;
        let mean = |(a, b): (&[f64; 3], &[f64; 3])| std::array::from_fn(|k| (a[k] + b[k]) / 2.0);
        let pixels = first.pixels.iter().zip(&second.pixels).map(mean).collect();
        Self { image: Image { pixels, ..*first }, own_error }
    }

    /// Returns whether an error is so small that much of it may be that of the reference itself.
    pub fn hides(&self, error: f64) -> bool {
        error < TIMES_REFERENCE * self.own_error
    }
}

/// Marks pixels that differ from one of their four neighbours by more than 0.05 in a channel.
pub fn edges(image: &Image) -> Vec<bool> {
    let (w, h) = (image.width as usize, image.height as usize);
    let differs = |i: usize, j: usize| {
        image.pixels[i].iter().zip(&image.pixels[j]).any(|(x, y)| (x - y).abs() > EDGE)
    };
    let is_edge = |i: usize| {
        let (x, y) = (i % w, i / w);
        (x > 0 && differs(i, i - 1))
            || (x + 1 < w && differs(i, i + 1))
            || (y > 0 && differs(i, i - w))
            || (y + 1 < h && differs(i, i + w))
    };
    (0..w * h).map(is_edge).collect()
}

/// The effect plan, unless its samples would fill the memory.
pub fn plan_of(scene: &Scene, settings: &RenderSettings) -> Result<EffectPlan, PlanError> {
    let plan = EffectPlan::of(scene, settings);
    if plan.samples_per_pixel() > MOST_SAMPLES_PER_PIXEL {
        return Err(PlanError::Malformed {
            text: format!("{} eye x glossy x shadow samples per pixel", plan.samples_per_pixel()),
            expected: "at most 4194304 of them",
        });
    }
    Ok(plan)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 4 x 2 pixels, the right half white.
    fn halves() -> Image {
        let pixels = (0..8).map(|i| if i % 4 < 2 { [0.0; 3] } else { [1.0; 3] }).collect();
        Image { width: 4, height: 2, pixels }
    }

    #[test]
    fn errors_of_known_images() {
        let image = halves();
        let mut other = image.clone();
        assert_eq!(rmse(&image, &other), 0.0);
        other.pixels[1] = [0.0, 0.6, 0.0];
        let expected = (0.36f64 / 24.0).sqrt();
        assert!((rmse(&image, &other) - expected).abs() < 1e-15);
        // the middle columns are the edge
        let edges = edges(&image);
        assert_eq!(edges, [false, true, true, false, false, true, true, false]);
        let expected = (0.36f64 / 12.0).sqrt();
        assert!((edge_rmse(&image, &other, &edges).unwrap() - expected).abs() < 1e-15);
        assert_eq!(edge_rmse(&image, &other, &[false; 8]), None);
    }

    #[test]
    fn a_reference_knows_its_own_error() {
        let image = |x: f64| Image { width: 1, height: 2, pixels: vec![[x; 3]; 2] };
        let converged = ConvergedImage::of(&image(1.0), &image(1.5));
        assert_eq!((converged.image.clone(), converged.own_error), (image(1.25), 0.25));
        assert!(converged.hides(2.4) && !converged.hides(2.5));
        assert!(!ConvergedImage::of(&image(1.0), &image(1.0)).hides(0.0));
    }
}
