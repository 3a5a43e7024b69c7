//! Decimation of curves and bands that keeps their extremes.

/// Largest number of points of a curve, and of either side of a band: one for each pixel of a wide plot.
pub(super) const MOST_POINTS: usize = 1200;

/// A point of a curve: position and value.
pub(super) type Point = (f64, f64);

/// Interval that is a gap, median intervals.
const GAP: f64 = 10.0;
/// Fewest points in which gaps are looked for.
const FEWEST_POINTS: usize = 10;
/// Most pieces; points of more have no regular interval.
const MOST_PIECES: usize = 100;

/// The points cut at gaps; `position` is that of a point.
pub(super) fn pieces<P>(points: &[P], position: impl Fn(&P) -> f64) -> Vec<&[P]> {
    let interval = |pair: &[P]| position(&pair[1]) - position(&pair[0]);
    let mut intervals: Vec<f64> = points.windows(2).map(interval).collect();
    intervals.sort_by(f64::total_cmp);
    let median = intervals.get(intervals.len() / 2).copied().unwrap_or(0.0);
    let is_near = |a: &P, b: &P| position(b) - position(a) <= GAP * median;
    let pieces: Vec<&[P]> = points.chunk_by(is_near).collect();
    let is_cut = points.len() >= FEWEST_POINTS && pieces.len() <= MOST_PIECES;
    if is_cut { pieces } else { vec![points] }
}

/// At most [`MOST_POINTS`] of the points: the lowest and the highest of each interval, so that a
/// single spike is kept, and the ends of a constant stretch.
pub(super) fn curve(points: &[Point]) -> Vec<Point> {
    let is_within = |i: usize| {
        i > 0 && i + 1 < points.len() && (i - 1..=i + 1).all(|k| points[k].1 == points[i].1)
    };
    let kept = points.iter().enumerate().filter(|(i, _)| !is_within(*i));
    thinned(&kept.map(|(_, point)| *point).collect::<Vec<_>>())
}

fn thinned(points: &[Point]) -> Vec<Point> {
    if points.len() <= MOST_POINTS {
        return points.to_vec();
    }
    let intervals = points.chunks(points.len().div_ceil(MOST_POINTS / 2));
    let mut kept = Vec::with_capacity(MOST_POINTS);
    for interval in intervals {
        let by_value = |left: &&Point, right: &&Point| left.1.total_cmp(&right.1);
        if let (Some(low), Some(high)) =
            (interval.iter().min_by(by_value), interval.iter().max_by(by_value))
        {
            let (first, second) = if low.0 <= high.0 { (low, high) } else { (high, low) };
            kept.push(*first);
            kept.push(*second);
        }
    }
    kept
}

/// At most [`MOST_POINTS`] points (position, lower, upper) of a band: the envelope of each interval.
pub(super) fn band(points: &[(f64, f64, f64)]) -> Vec<(f64, f64, f64)> {
    points
        .chunks(points.len().div_ceil(MOST_POINTS).max(1))
        .filter_map(|interval| {
            let &(time, ..) = interval.first()?;
            let lower = interval.iter().map(|point| point.1).fold(f64::INFINITY, f64::min);
            let upper = interval.iter().map(|point| point.2).fold(f64::NEG_INFINITY, f64::max);
            Some((time, lower, upper))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_points_are_unchanged() {
        let points = [(0.0, 1.0), (1.0, 3.0)];
        assert_eq!(curve(&points), points);
        assert!(band(&[]).is_empty());
    }

    #[test]
    fn spike_is_kept_and_the_points_stay_in_order() {
        let mut points: Vec<Point> = (0..100_001).map(|k| (f64::from(k), 0.0)).collect();
        points.iter_mut().for_each(|point| point.1 = (point.0 * 0.7).sin());
        points[54_321].1 = 9.0;
        let kept = curve(&points);
        assert!(kept.len() <= MOST_POINTS);
        assert!(kept.contains(&(54_321.0, 9.0)));
        assert!(kept.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    }

    #[test]
    fn points_are_cut_at_gaps() {
        let mut points: Vec<f64> = (0..20).map(f64::from).collect();
        points[12..].iter_mut().for_each(|x| *x += 50.0);
        let lengths: Vec<usize> = pieces(&points, |x| *x).iter().map(|piece| piece.len()).collect();
        assert_eq!(lengths, [12, 8]);
        assert_eq!(pieces(&[0.0, 1.0, 100.0], |x| *x).len(), 1);
        assert_eq!(pieces(&[] as &[f64], |x| *x).len(), 1);
    }

    #[test]
    fn constant_stretch_keeps_its_ends() {
        let points = [(0.0, 1.0), (1.0, 1.0), (2.0, 1.0), (3.0, 1.0), (4.0, 5.0)];
        assert_eq!(curve(&points), [points[0], points[3], points[4]]);
    }

    #[test]
    fn band_keeps_its_envelope() {
        let mut points: Vec<_> = (0..10_000).map(|k| (f64::from(k), -1.0, 1.0)).collect();
        points[777].2 = 5.0;
        let kept = band(&points);
        assert!(kept.len() <= MOST_POINTS);
        assert!(kept.iter().any(|point| point.2 == 5.0));
    }
}
