//! Fewer points for the same picture.

/// Most points of a curve, and of either side of a band.
pub(super) const MOST_POINTS: usize = 2000;

/// A point of a curve: time and value.
pub(super) type Point = (f64, f64);

/// At most [`MOST_POINTS`] of `points`, among them the lowest and the highest of each stretch, so
/// that a single spike is still seen.
pub(super) fn curve(points: &[Point]) -> Vec<Point> {
    if points.len() <= MOST_POINTS {
        return points.to_vec();
    }
    let stretches = points.chunks(points.len().div_ceil(MOST_POINTS / 2));
    let mut kept = Vec::with_capacity(MOST_POINTS);
    for stretch in stretches {
        let by_value = |left: &&Point, right: &&Point| left.1.total_cmp(&right.1);
        if let (Some(low), Some(high)) =
            (stretch.iter().min_by(by_value), stretch.iter().max_by(by_value))
        {
            let (first, second) = if low.0 <= high.0 { (low, high) } else { (high, low) };
            kept.push(*first);
            kept.push(*second);
        }
    }
    kept
}

/// At most [`MOST_POINTS`] points (time, lower, upper) of a band, each as wide as the band is
/// anywhere in its stretch.
pub(super) fn band(points: &[(f64, f64, f64)]) -> Vec<(f64, f64, f64)> {
    points
        .chunks(points.len().div_ceil(MOST_POINTS).max(1))
        .filter_map(|stretch| {
            let &(time, ..) = stretch.first()?;
            let lower = stretch.iter().map(|point| point.1).fold(f64::INFINITY, f64::min);
            let upper = stretch.iter().map(|point| point.2).fold(f64::NEG_INFINITY, f64::max);
            Some((time, lower, upper))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_points_stay_as_they_are() {
        let points = [(0.0, 1.0), (1.0, 3.0)];
        assert_eq!(curve(&points), points);
        assert!(band(&[]).is_empty());
    }

    #[test]
    fn spike_survives_in_order_of_time() {
        let mut points: Vec<Point> = (0..100_001).map(|k| (f64::from(k), 0.0)).collect();
        points[54_321].1 = 9.0;
        let kept = curve(&points);
        assert!(kept.len() <= MOST_POINTS);
        assert!(kept.contains(&(54_321.0, 9.0)));
        assert!(kept.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    }

    #[test]
    fn band_keeps_its_widest() {
        let mut points: Vec<_> = (0..10_000).map(|k| (f64::from(k), -1.0, 1.0)).collect();
        points[777].2 = 5.0;
        let kept = band(&points);
        assert!(kept.len() <= MOST_POINTS);
        assert!(kept.iter().any(|point| point.2 == 5.0));
    }
}
