//! How far an image is from the one it should be.

use renderer::Image;

/// From this difference to a direct neighbour on, in any channel, a pixel is one of an edge.
const EDGE: f64 = 0.05;

/// Root of the mean square difference over all channels of the pixels that `counts`; none where it
/// counts no pixel, or where the images differ in size.
fn rmse_over(a: &Image, b: &Image, mut counts: impl FnMut(usize) -> bool) -> Option<f64> {
    if [a.width, a.height] != [b.width, b.height] {
        return None;
    }
    let (mut sum, mut channels) = (0.0, 0usize);
    for (i, (p, q)) in a.pixels.iter().zip(&b.pixels).enumerate() {
        if counts(i) {
            sum += p.iter().zip(q).map(|(x, y)| (x - y) * (x - y)).sum::<f64>();
            channels += 3;
        }
    }
    (channels > 0).then(|| (sum / channels as f64).sqrt())
}

/// Root mean square error over all pixels and channels, linear; none for images of unlike size.
pub fn rmse(a: &Image, b: &Image) -> Option<f64> {
    rmse_over(a, b, |_| true)
}

/// The same over the pixels of `edges` alone.
pub fn edge_rmse(a: &Image, b: &Image, edges: &[bool]) -> Option<f64> {
    rmse_over(a, b, |i| edges.get(i).copied().unwrap_or(false))
}

/// Which pixels differ from one of their four neighbours by more than 0.05 in a channel.
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
        assert_eq!(rmse(&image, &other), Some(0.0));
        other.pixels[1] = [0.0, 0.6, 0.0];
        let expected = (0.36f64 / 24.0).sqrt();
        assert!((rmse(&image, &other).unwrap() - expected).abs() < 1e-15);
        // the middle columns are the edge
        let edges = edges(&image);
        assert_eq!(edges, [false, true, true, false, false, true, true, false]);
        let expected = (0.36f64 / 12.0).sqrt();
        assert!((edge_rmse(&image, &other, &edges).unwrap() - expected).abs() < 1e-15);
        assert_eq!(edge_rmse(&image, &other, &[false; 8]), None);
        let small = Image { width: 1, height: 1, pixels: vec![[0.0; 3]] };
        assert_eq!(rmse(&image, &small), None);
    }
}
