//! What is plotted, and its places on the axes: where ticks are.

/// Width of a figure, in pixels.
pub const WIDTH: f64 = 900.0;

/// A panel of a figure.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Plot {
    pub title: String,
    /// Below the title, small.
    pub subtitle: String,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
    pub marks: Vec<Mark>,
    /// Legend of marks that belong to no series.
    pub marks_name: String,
    /// Horizontal lines to compare with.
    pub levels: Vec<Level>,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct Axis {
    /// Quantity with its unit.
    pub label: String,
    /// Form in which it is shown.
    pub scale: Scale,
}

/// How an axis maps numbers to places. Its ends follow from what is plotted.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Scale {
    /// Equal differences, equal lengths.
    #[default]
    Linear,
    /// The same, from zero.
    FromZero,
    /// Equal ratios, equal lengths; what is not above zero has no place.
    Log,
    /// Words at 0, 1, 2...
    Words(Vec<String>),
}

#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    pub name: String,
    /// Its points, in the order in which they are joined.
    pub points: Vec<Point>,
    /// Lines between the points.
    pub is_joined: bool,
}

/// A point with an error bar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    pub x: f64,
    pub y: f64,
    pub low: f64,
    pub high: f64,
}

/// A point that is pointed out.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    pub point: Point,
    /// The label; may be empty.
    pub label: String,
    /// Shown while a pointer is over the point; may be empty.
    pub hover: String,
    pub ring: Ring,
    /// The point is one of a series and drawn with it.
    pub is_in_series: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ring {
    None,
    Best,
    /// Dashed: as good as the best.
    AsGood,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    pub y: f64,
    pub label: String,
}

/// Ticks wanted on a linear axis, about.
const TICKS: f64 = 6.0;
/// Room between the outermost numbers and the ends, as a share of the axis.
const PADDING: f64 = 0.05;

/// An axis with its ends.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedAxis {
    /// Ends; of logarithms where the axis is logarithmic.
    low: f64,
    high: f64,
    is_log: bool,
    /// Places of the ends.
    ends: [f64; 2],
    /// Ticks, those without a label being small.
    pub ticks: Vec<Tick>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    pub at: f64,
    /// Its label; none for small ticks.
    pub label: Option<String>,
}

impl FittedAxis {
    /// The axis that shows, between these places, all the numbers that have a place on it.
    pub fn new(scale: &Scale, ends: [f64; 2], numbers: impl Iterator<Item = f64>) -> Self {
        if let Scale::Words(words) = scale {
            let tick =
                |(i, word): (usize, &String)| Tick { at: i as f64, label: Some(word.clone()) };
            let ticks = words.iter().enumerate().map(tick).collect();
            let high = words.len().max(1) as f64 - 0.5;
            return Self { low: -0.5, high, is_log: false, ends, ticks };
        }
        let is_log = *scale == Scale::Log;
        let has_place = |x: &f64| x.abs() < 1e300 && (*x > 0.0 || !is_log);
        let places = numbers.filter(has_place).map(|x| if is_log { x.log10() } else { x });
        let (low, high) = range(places).unwrap_or((0.0, 1.0));
        let around = if is_log { 0.3 } else { 0.5 };
        let (low, high) = if low < high { (low, high) } else { (low - around, high + around) };
        let room = PADDING * (high - low);
        let starts_at_zero = *scale == Scale::FromZero && low >= 0.0;
        let (low, high) = (if starts_at_zero { 0.0 } else { low - room }, high + room);
        let ticks = if is_log { log_ticks(low, high) } else { linear_ticks(low, high) };
        Self { low, high, is_log, ends, ticks }
    }

    /// The place of a number between the ends, if it has one there.
    pub fn place(&self, x: f64) -> Option<f64> {
        let x = if self.is_log { x.log10() } else { x };
        let share = (x - self.low) / (self.high - self.low);
        (-1e-9..=1.0 + 1e-9).contains(&share).then(|| self.at(share))
    }

    /// The same; what lies beyond an end is moved there.
    pub fn nearest_place(&self, x: f64) -> f64 {
        let x = if !self.is_log {
            x
        } else if x <= 0.0 {
            f64::NEG_INFINITY
        } else {
            x.log10()
        };
        let share = (x - self.low) / (self.high - self.low);
        self.at(if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) })
    }

    fn at(&self, share: f64) -> f64 {
        let [from, to] = self.ends;
        from + share * (to - from)
    }
}

fn range(numbers: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    numbers.filter(|x| x.is_finite()).fold(None, |ends, x| {
        let (low, high) = ends.unwrap_or((x, x));
        Some((f64::min(low, x), f64::max(high, x)))
    })
}

/// Multiples of 1, 2 or 5 times a power of ten.
fn linear_ticks(low: f64, high: f64) -> Vec<Tick> {
    let rough = (high - low) / TICKS;
    let power = 10.0_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power);
    let step = step.into_iter().find(|s| *s >= 0.8 * rough).unwrap_or(rough);
    let decimals = (-step.log10().floor()).clamp(0.0, 17.0) as usize;
    let (first, last) = ((low / step).ceil(), (high / step).floor());
    if !(step > 0.0 && (last - first).abs() < 100.0) {
        return Vec::new();
    }
    (0..=(last - first).max(0.0) as u32)
        .map(|i| {
            let at = (first + f64::from(i)) * step;
            let is_plain = step >= 1e-5 && high.abs().max(low.abs()) < 1e6;
            let text = if is_plain { format!("{at:.decimals$}") } else { scientific(at) };
            Tick { at, label: Some(text) }
        })
        .collect()
}

/// Two digits and an exponent.
fn scientific(x: f64) -> String {
    format!("{x:.1e}").replace(".0e", "e")
}

/// Powers of ten, and 2 and 5 times them where there is room; between `low` and `high`, which are
/// decimal logarithms.
fn log_ticks(low: f64, high: f64) -> Vec<Tick> {
    let span = high - low;
    if span < 0.7 {
        return linear_ticks(10.0_f64.powf(low), 10.0_f64.powf(high));
    }
    let labelled: &[u32] = if span <= 2.5 { &[1, 2, 5] } else { &[1] };
    let every = (span / 10.0).ceil().max(1.0) as i32;
    let mut ticks = Vec::new();
    for exponent in low.floor() as i32..=high.ceil() as i32 {
        for mantissa in 1..=9_u32 {
            // Parsed, so that 3 tenths are 0.3 and not a bit more.
            let Ok(at) = format!("{mantissa}e{exponent}").parse::<f64>() else { continue };
            let has_label = labelled.contains(&mantissa) && exponent.rem_euclid(every) == 0;
            let is_within = (low..=high).contains(&at.log10());
            if is_within && (has_label || (span <= 6.0 && every == 1)) {
                let is_short = (1e-4..1e6).contains(&at);
                let text = if is_short { at.to_string() } else { format!("{at:e}") };
                ticks.push(Tick { at, label: has_label.then_some(text) });
            }
        }
    }
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: &Scale, numbers: &[f64]) -> Vec<String> {
        let axis = FittedAxis::new(scale, [0.0, 1.0], numbers.iter().copied());
        axis.ticks.into_iter().filter_map(|t| t.label).collect()
    }

    #[test]
    fn linear_ticks_are_round() {
        assert_eq!(labels(&Scale::FromZero, &[1.0, 8.0]), ["0", "2", "4", "6", "8"]);
        assert_eq!(
            labels(&Scale::FromZero, &[2.5]),
            ["0.0", "0.5", "1.0", "1.5", "2.0", "2.5", "3.0"]
        );
        assert_eq!(labels(&Scale::Linear, &[-1.0, 1.0]), ["-1.0", "-0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(labels(&Scale::Linear, &[1e7, 3e7]), ["1e7", "1.5e7", "2e7", "2.5e7", "3e7"]);
    }

    #[test]
    fn log_ticks_are_powers_of_ten() {
        assert_eq!(labels(&Scale::Log, &[0.1, 1000.0]), ["0.1", "1", "10", "100", "1000"]);
        assert_eq!(labels(&Scale::Log, &[1.0, 30.0]), ["1", "2", "5", "10", "20"]);
        assert_eq!(labels(&Scale::Log, &[1e-9, 1e-6, 1e6]).len(), 8, "every second power");
        assert!(labels(&Scale::Log, &[1.1, 1.9]).len() >= 4, "as on a linear axis");
        let all = FittedAxis::new(&Scale::Log, [0.0, 1.0], [1.0, 1000.0].into_iter()).ticks;
        assert!(all.iter().any(|t| t.at == 300.0 && t.label.is_none()), "small ticks between");
    }

    #[test]
    fn places() {
        let axis = FittedAxis::new(&Scale::Log, [0.0, 1.0], [1.0, 100.0].into_iter());
        assert!((axis.place(10.0).unwrap() - 0.5).abs() < 1e-12);
        assert_eq!((axis.place(0.0), axis.place(-1.0), axis.place(1e9)), (None, None, None));
        assert_eq!((axis.nearest_place(-1.0), axis.nearest_place(1e9)), (0.0, 1.0));
        let words = FittedAxis::new(
            &Scale::Words(vec!["a".into(), "b".into()]),
            [0.0, 1.0],
            [].into_iter(),
        );
        assert_eq!((words.place(0.0), words.place(1.0)), (Some(0.25), Some(0.75)));
    }

    #[test]
    fn axes_without_numbers_or_with_one_have_ends() {
        for scale in [Scale::Linear, Scale::FromZero, Scale::Log] {
            for numbers in [&[][..], &[5.0], &[f64::NAN, f64::INFINITY], &[0.0], &[-3.0]] {
                let axis = FittedAxis::new(&scale, [0.0, 1.0], numbers.iter().copied());
                assert!(axis.low < axis.high && axis.high.is_finite(), "{scale:?} {numbers:?}");
            }
        }
    }
}
