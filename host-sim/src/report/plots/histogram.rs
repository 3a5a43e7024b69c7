//! Histograms, and the normal distribution beside them.

/// Bars of a histogram.
const BARS: usize = 48;

/// Histogram from `−reach` to `reach`: lower edge, upper edge and count of each bar. Values outside
/// are not counted.
pub fn histogram(values: &[f64], reach: f64) -> Vec<(f64, f64, f64)> {
    let width = bar_width(reach);
    let edge = |bar: usize| -reach + bar as f64 * width;
    let is_in = |value: f64, bar: usize| (edge(bar)..edge(bar + 1)).contains(&value);
    let height = |bar: usize| values.iter().filter(|value| is_in(**value, bar)).count() as f64;
    (0..BARS).map(|bar| (edge(bar), edge(bar + 1), height(bar))).collect()
}

/// Width of a bar of [`histogram`].
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
        let bars = histogram(&[0.0, 0.01, -7.99, 8.0, f64::NAN, 100.0], 8.0);
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
