//! Clipping of a curve to its panel. The SVG backend draws points outside over the other panels.

use std::ops::Range;

use super::decimate::Point;

/// Pieces of a curve within a range of values, cut at the crossings of the ends.
pub(super) fn clip(points: &[Point], range: &Range<f64>) -> Vec<Vec<Point>> {
    let is_inside = |point: &Point| (range.start..=range.end).contains(&point.1);
    let mut pieces: Vec<Vec<Point>> = Vec::new();
    let mut was_inside = false;
    for (index, point) in points.iter().enumerate() {
        let before = index.checked_sub(1).and_then(|index| points.get(index));
        match (was_inside, is_inside(point)) {
            (false, true) => {
                let entry = before.map(|before| crossing(before, point, range));
                pieces.push(entry.into_iter().chain([*point]).collect());
            }
            (true, is_inside) => {
                if let (Some(piece), Some(before)) = (pieces.last_mut(), before) {
                    piece.push(if is_inside { *point } else { crossing(point, before, range) });
                }
            }
            (false, false) => {}
        }
        was_inside = is_inside(point);
    }
    pieces
}

/// Crossing of the line from a point outside the range to one inside with the end of the range.
fn crossing(outside: &Point, inside: &Point, range: &Range<f64>) -> Point {
    let end = if outside.1 > range.end { range.end } else { range.start };
    let part = (end - inside.1) / (outside.1 - inside.1);
    (inside.0 + part * (outside.0 - inside.0), end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curve_is_cut_at_the_crossings_of_the_range() {
        let points = [(0.0, 0.0), (1.0, 2.0), (2.0, 2.0), (3.0, -2.0), (4.0, 0.0)];
        let pieces = clip(&points, &(-1.0..1.0));
        assert_eq!(pieces, [vec![(0.0, 0.0), (0.5, 1.0)], vec![(3.5, -1.0), (4.0, 0.0)]]);
    }
}
