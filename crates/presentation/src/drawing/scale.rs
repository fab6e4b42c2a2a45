//! Colours of numbers. They run from dark blue over green to yellow and grow evenly brighter, so
//! that they can be told apart in grey print and by colour-blind readers; the anchors are those of
//! viridis (S. van der Walt, N. Smith, 2015, CC0).

use super::item::Color;

/// Colours in sRGB at equal distances.
const ANCHORS: [Color; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// The colour of a share of the scale, from 0 (dark) to 1 (bright).
pub fn ramp(share: f64) -> Color {
    let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
    let at = share * (ANCHORS.len() - 1) as f64;
    let i = (at as usize).min(ANCHORS.len() - 2);
    let f = at - i as f64;
    let [low, high] = [i, i + 1].map(|i| ANCHORS.get(i).copied().unwrap_or_default());
    let mixed = |(a, b): (u8, u8)| (f64::from(a) * (1.0 - f) + f64::from(b) * f).round() as u8;
    let mut all = low.into_iter().zip(high).map(mixed);
    std::array::from_fn(|_| all.next().unwrap_or(0))
}

/// Whole numbers from 1 on in classes whose ends are powers of two: 1, 2, 3-4, 5-8, ...; few are
/// bright, many are dark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Classes {
    count: u32,
}

impl Classes {
    /// As many as numbers up to `most` need.
    pub fn up_to(most: u64) -> Self {
        Self { count: Self::class(most) + 1 }
    }

    fn class(n: u64) -> u32 {
        n.max(1).next_power_of_two().trailing_zeros()
    }

    /// The class of a number, from 0.
    pub fn of(self, n: u64) -> u32 {
        Self::class(n).min(self.count - 1)
    }

    /// How many there are.
    pub fn count(self) -> u32 {
        self.count
    }

    /// The colour of a class.
    pub fn color(self, class: u32) -> Color {
        let last = self.count.saturating_sub(1).max(1);
        // the brightest would be lost on white, the darkest hides lines
        ramp(0.97 - 0.92 * f64::from(class) / f64::from(last))
    }

    pub fn label(class: u32) -> String {
        match class {
            0 | 1 => (class + 1).to_string(),
            _ => format!("{}-{}", (1u64 << (class - 1)) + 1, 1u64 << class),
        }
    }
}
