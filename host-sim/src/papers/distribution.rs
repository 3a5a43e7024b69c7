//! What many runs say of one number, and where another number falls among theirs.

/// The finite values of a quantity over the runs, ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    sorted: Vec<f64>,
}

impl Distribution {
    /// Values that aren't finite are left out.
    pub fn new(values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.into_iter().filter(|x| x.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        Self { sorted }
    }

    /// How many values there are.
    pub fn count(&self) -> usize {
        self.sorted.len()
    }

    /// Mean; none of nothing.
    pub fn mean(&self) -> Option<f64> {
        let count = self.count();
        (count > 0).then(|| self.sorted.iter().sum::<f64>() / count as f64)
    }

    /// The middle value, or the mean of the two in the middle; none of nothing.
    pub fn median(&self) -> Option<f64> {
        let upper = self.sorted.get(self.count() / 2)?;
        let lower = self.sorted.get(self.count().checked_sub(1)? / 2)?;
        Some((lower + upper) / 2.0)
    }

    /// Standard deviation, `√(Σ (x − mean)² / (n − 1))`; none of fewer than two.
    pub fn standard_deviation(&self) -> Option<f64> {
        let mean = self.mean()?;
        let square: f64 = self.sorted.iter().map(|x| (x - mean).powi(2)).sum();
        let count = self.count();
        (count > 1).then(|| (square / (count - 1) as f64).sqrt())
    }

    /// Per cent of the values that are below this one; those equal to it count half.
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
    fn mean_and_standard_deviation_are_those_by_hand() {
        // Mean 5, squares 9 + 1 + 1 + 1 + 0 + 0 + 4 + 16 = 32 over 7.
        let values = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0];
        let distribution = Distribution::new(values);
        assert_eq!(distribution.mean(), Some(5.0));
        let expected = (32.0f64 / 7.0).sqrt();
        assert!((distribution.standard_deviation().unwrap() - expected).abs() < 1e-15);
    }

    #[test]
    fn the_median_is_in_the_middle() {
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
    fn few_or_no_values_say_no_more_than_they_can() {
        let nothing = Distribution::new([f64::NAN, f64::INFINITY]);
        assert_eq!((nothing.mean(), nothing.percentile(1.0)), (None, None));
        let one = Distribution::new([3.0]);
        assert_eq!((one.mean(), one.standard_deviation()), (Some(3.0), None));
    }

    #[test]
    fn the_order_of_the_runs_changes_no_bit() {
        let values = [0.1, 0.7, 1e-9, 0.3, 1e5];
        let mut reversed = values;
        reversed.reverse();
        assert_eq!(Distribution::new(values).mean(), Distribution::new(reversed).mean());
    }
}
