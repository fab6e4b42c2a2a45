//! Many tests at once: the probability of even one false alarm among them.
//!
//! Paper: S. Holm, "A Simple Sequentially Rejective Multiple Test Procedure", Scandinavian Journal
//! of Statistics 6(2), 1979, as adjusted probabilities. Deviations: none.

/// The probabilities of tests, adjusted: those below a level may be called significant, all of
/// them together with no more than that probability of a false alarm. In the order given.
pub fn adjusted(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]));
    let mut adjusted = vec![1.0; p.len()];
    let mut largest = 0.0_f64;
    for (rank, &i) in order.iter().enumerate() {
        largest = largest.max(p[i] * (p.len() - rank) as f64).min(1.0);
        adjusted[i] = largest;
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn adjusted_probabilities_are_known() {
        assert_eq!(adjusted(&[]), Vec::<f64>::new());
        assert_eq!(adjusted(&[0.04]), [0.04]);
        // 0.01 * 3; 0.02 * 2 = 0.04; 0.03 * 1 = 0.03, but no less than the one before
        assert_eq!(adjusted(&[0.03, 0.01, 0.02]), [0.04, 0.03, 0.04]);
        assert_eq!(adjusted(&[0.9, 0.8]), [1.0, 1.0]);
    }
}
