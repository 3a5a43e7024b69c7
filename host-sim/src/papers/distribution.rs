//! Sample statistics of one quantity over the trials, and the percentile of a published value.

/// Finite values of a quantity, ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    sorted: Vec<f64>,
}

impl Distribution {
    /// Sorts the values. Values that are not finite are dropped.
    pub fn new(values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.into_iter().filter(|x| x.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        Self { sorted }
    }

    /// One value per trial.
    pub fn over<T>(trials: &[T], value: impl Fn(&T) -> f64) -> Self {
        Self::new(trials.iter().map(value))
    }

    /// Number of values.
    pub fn count(&self) -> usize {
        self.sorted.len()
    }

    /// Mean, `Σ x / n`. None without values.
    pub fn mean(&self) -> Option<f64> {
        let count = self.count();
        (count > 0).then(|| self.sorted.iter().sum::<f64>() / count as f64)
    }

    /// Median: the middle value, or the mean of the two middle values. None without values.
    pub fn median(&self) -> Option<f64> {
        let upper = self.sorted.get(self.count() / 2)?;
        let lower = self.sorted.get(self.count().checked_sub(1)? / 2)?;
        Some((lower + upper) / 2.0)
    }

    /// Sample standard deviation, `√(Σ (x − mean)² / (n − 1))`. None with fewer than two values.
    pub fn standard_deviation(&self) -> Option<f64> {
        let mean = self.mean()?;
        let square: f64 = self.sorted.iter().map(|x| (x - mean).powi(2)).sum();
        let count = self.count();
        (count > 1).then(|| (square / (count - 1) as f64).sqrt())
    }

    /// Share of the values below `of`, per cent. A value equal to `of` counts half.
    pub fn percentile(&self, of: f64) -> Option<f64> {
        let below = self.sorted.partition_point(|x| *x < of);
        let up_to = self.sorted.partition_point(|x| *x <= of);
        let count = self.count();
        (count > 0).then(|| 50.0 * (below + up_to) as f64 / count as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_standard_deviation_match_a_hand_calculation() {
        // Mean 5, squares 9 + 1 + 1 + 1 + 0 + 0 + 4 + 16 = 32 over 7.
        let values = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0];
        let distribution = Distribution::new(values);
        assert_eq!(distribution.mean(), Some(5.0));
        let expected = (32.0f64 / 7.0).sqrt();
        assert!((distribution.standard_deviation().unwrap() - expected).abs() < 1e-15);
    }

    #[test]
    fn median_is_the_middle_value_or_the_mean_of_two() {
        assert_eq!(Distribution::new([3.0, 1.0, 9.0]).median(), Some(3.0));
        assert_eq!(Distribution::new([4.0, 1.0, 9.0, 2.0]).median(), Some(3.0));
        assert_eq!(Distribution::new([]).median(), None);
    }

    #[test]
    fn percentile_counts_ties_half() {
        let distribution = Distribution::new([3.0, 1.0, 2.0, 2.0]);
        for (value, percentile) in
            [(0.5, 0.0), (1.0, 12.5), (1.5, 25.0), (2.0, 50.0), (2.5, 75.0), (9.0, 100.0)]
        {
            assert_eq!(distribution.percentile(value), Some(percentile), "{value}");
        }
    }

    #[test]
    fn statistics_are_none_without_enough_finite_values() {
        let nothing = Distribution::new([f64::NAN, f64::INFINITY]);
        assert_eq!((nothing.mean(), nothing.percentile(1.0)), (None, None));
        let one = Distribution::new([3.0]);
        assert_eq!((one.mean(), one.standard_deviation()), (Some(3.0), None));
    }

    #[test]
    fn statistics_do_not_depend_on_the_order_of_the_values() {
        let values = [0.1, 0.7, 1e-9, 0.3, 1e5];
        let mut reversed = values;
        reversed.reverse();
        assert_eq!(Distribution::new(values).mean(), Distribution::new(reversed).mean());
    }
}
