//! Histograms, and the normal distribution beside them.

/// Bars of a histogram.
const BARS: usize = 48;

/// Histogram from `−reach` to `reach`, filled one value at a time.
#[derive(Clone, Debug)]
pub struct Histogram {
    reach: f64,
    counts: [u64; BARS],
    values: u64,
}

impl Histogram {
    /// An empty histogram.
    pub fn new(reach: f64) -> Self {
        Self { reach, counts: [0; BARS], values: 0 }
    }

    /// Lower edge of a bar; the upper edge is that of the next one.
    fn edge(&self, bar: usize) -> f64 {
        -self.reach + bar as f64 * bar_width(self.reach)
    }

    /// Counts a value. Values outside are in [`Self::values`] alone.
    pub fn add(&mut self, value: f64) {
        self.values += 1;
        // The quotient is rounded: the bar is that whose edges contain the value.
        let near = ((value + self.reach) / bar_width(self.reach)) as usize;
        let is_in = |bar: &usize| (self.edge(*bar)..self.edge(bar + 1)).contains(&value);
        let found = (near.saturating_sub(1)..BARS.min(near.saturating_add(2))).find(is_in);
        if let Some(count) = found.and_then(|bar| self.counts.get_mut(bar)) {
            *count += 1;
        }
    }

    /// Number of values added, those outside included.
    pub fn values(&self) -> u64 {
        self.values
    }

    /// Lower edge, upper edge and count of each bar.
    pub fn bars(&self) -> Vec<(f64, f64, f64)> {
        let bar = |bar: usize| (self.edge(bar), self.edge(bar + 1), self.counts[bar] as f64);
        (0..BARS).map(bar).collect()
    }
}

/// Bars of the histogram of these values.
pub fn histogram(values: &[f64], reach: f64) -> Vec<(f64, f64, f64)> {
    let mut histogram = Histogram::new(reach);
    values.iter().for_each(|value| histogram.add(*value));
    histogram.bars()
}

/// Width of a bar of a [`Histogram`].
pub fn bar_width(reach: f64) -> f64 {
    2.0 * reach / BARS as f64
}

/// Normal distribution of zero mean, `area / (σ √(2π)) exp(−x² / 2σ²)`, from `−reach` to `reach`.
pub fn normal_curve(sigma: f64, area: f64, reach: f64) -> Vec<(f64, f64)> {
    const POINTS: i32 = 100;
    let peak = area / (sigma * (2.0 * std::f64::consts::PI).sqrt());
    let x = |k: i32| reach * f64::from(k) / f64::from(POINTS);
    (-POINTS..=POINTS).map(|k| (x(k), peak * (-0.5 * (x(k) / sigma).powi(2)).exp())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn histogram_counts_the_values_within_reach() {
        let mut histogram = Histogram::new(8.0);
        for value in [0.0, 0.01, -7.99, 8.0, f64::NAN, 100.0, -1e30] {
            histogram.add(value);
        }
        assert_eq!(histogram.values(), 7);
        let bars = histogram.bars();
        assert_eq!(bars.iter().map(|bar| bar.2).sum::<f64>(), 3.0);
        assert_eq!((bars[0].0, bars[0].2), (-8.0, 1.0));
        assert_eq!(bars[BARS / 2].2, 2.0);
    }

    #[test]
    fn normal_curve_has_the_given_area() {
        /// Trapezoidal rule with 200 intervals, runs.
        const TOLERANCE: f64 = 0.5;
        let curve = normal_curve(0.5, 200.0, 8.0);
        let area: f64 = curve.windows(2).map(|p| (p[1].0 - p[0].0) * (p[0].1 + p[1].1) / 2.0).sum();
        assert!((area - 200.0).abs() < TOLERANCE, "{area}");
    }
}
