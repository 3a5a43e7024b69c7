//! Units of a log that are probably not SI: rates in deg/s, time in milliseconds or microseconds.
//!
//! Momentum of body and wheels, between two rows `a` and `b` of a log, all in body axes:
//!
//! ```text
//! J (ω_b − ω_a) + h_b − h_a + f ∫ ω × (J ω + h) dt = g ∫ τ dt
//! ```
//!
//! with `h` the momentum of the wheels and `τ` the external torque. In SI units `f = g = 1`. Rates in
//! deg/s make the product too large by 180/π: with `J` in the inverse unit the balance holds for
//! `f = π/180`. Time in milliseconds makes both integrals too large: `f = g = 10⁻³`. The balance is
//! fitted for each unit by least squares over `J`.
//!
//! A unit is named only where its fit is ten times better than that of SI in the sum of squares,
//! explains the data by itself, and has a positive definite `J`. Motion without net momentum, or so slow
//! that `ω × (J ω + h)` is below the noise, says nothing of the unit. Wrong wheels or an unknown torque
//! spoil both fits. A log with attitude shows the unit directly, by the angle from row to row.

mod balance;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::Craft;
use super::log::LogRow;
use balance::{Fit, changes};

/// Least ratio of the sums of squares of SI and of another unit.
const MIN_GAIN: f64 = 10.0;
/// Ratio of sums of squares up to which two units fit equally well.
const EQUAL_FITS: f64 = 2.0;
/// Largest residual of a unit that explains the data, as a share of the sum of squares without `J`.
const MAX_UNEXPLAINED: f64 = 0.1;
/// Largest numbers of intervals in the fits: short intervals resolve fast motion, long ones have less
/// noise.
const INTERVALS: [usize; 2] = [300, 30];
/// Largest relative difference of the turns by the rates in a unit from those by the attitude.
const ANGLE_TOLERANCE: f64 = 0.2;
/// Largest turn from row to row by the attitude, rad: well below half a turn, which is ambiguous.
const MAX_TURN_RAD: f64 = 2.0;
/// Smallest sum of turns by the attitude for a decision, rad.
const MIN_TURNS_RAD: f64 = 0.1;
/// Fewest intervals for a decision: three times the elements of `J` in equations.
const MIN_INTERVALS: usize = 6;
/// Largest ordinary range of a gyro, rad/s: 2,000 deg/s.
const ORDINARY_RANGE_RAD_S: f64 = 35.0;
/// Shortest and longest time between rows of an ordinary log, s.
const ORDINARY_STEP_S: std::ops::Range<f64> = 1e-4..5.0;

/// A unit that a column may have in place of the SI unit.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Unit {
    DegPerSecond,
    Millisecond,
    Microsecond,
}

impl Unit {
    /// In the order of preference among equal fits.
    const ALL: [Self; 3] = [Self::Millisecond, Self::Microsecond, Self::DegPerSecond];

    /// Factors `f` of the product and `g` of the torque.
    fn factors(self) -> [f64; 2] {
        match self {
            Self::DegPerSecond => [1f64.to_radians(), 1.0],
            Self::Millisecond => [1e-3; 2],
            Self::Microsecond => [1e-6; 2],
        }
    }

    /// True if a log with this median step may have this unit: the step is ordinary in a unit of time,
    /// and not ordinary as seconds.
    fn is_possible(self, step_s: f64) -> bool {
        let [_, time] = self.factors();
        let is_ordinary = |step_s: f64| ORDINARY_STEP_S.contains(&step_s);
        self == Self::DegPerSecond || (is_ordinary(step_s * time) && !is_ordinary(step_s))
    }

    /// The note; `reason` is the finding, up to the name of the unit.
    fn note(self, reason: &str, step_s: f64) -> String {
        match self {
            Self::DegPerSecond => format!(
                "rates look like deg/s: {reason} with the rates times π/180; if so, state unit = \"deg/s\" in \
                 [log.gyro] of the craft file"
            ),
            Self::Millisecond => format!(
                "median step {step_s} s: time looks like milliseconds: {reason} with t_s / 1000; if \
                 so, state time_unit = \"ms\" in [log] of the craft file"
            ),
            Self::Microsecond => format!(
                "median step {step_s} s: time looks like microseconds: {reason} with t_s / 1e6; if so, \
                 state time_unit = \"us\" in [log] of the craft file"
            ),
        }
    }
}

/// A note on a unit that is probably not SI; none for a plausible log.
pub fn note(craft: &Craft, rows: &[LogRow]) -> Option<String> {
    let step_s = median(rows.windows(2).map(|pair| step_s(&pair[0], &pair[1])).collect())?;
    by_attitude(rows, step_s)
        .or_else(|| INTERVALS.iter().find_map(|most| by_momentum(craft, rows, step_s, *most)))
        .or_else(|| beyond_range(craft, rows))
        .or_else(|| too_far_apart(rows, step_s))
}

/// A unit in which the turns by the rates are those by the attitude.
///
/// `k = Σ (ω Δt) · θ / Σ θ · θ`, with `θ` the turn by the attitude from row to row, is 1 in SI units and
/// `1/f` in another unit. The noise of the gyro averages out of it; that of the attitude lowers it.
fn by_attitude(rows: &[LogRow], step_s: f64) -> Option<String> {
    let (mut product, mut square, mut angle) = (0.0, 0.0, 0.0);
    for pair in rows.windows(2) {
        let Some(turn) = turn(&pair[0], &pair[1]).filter(|turn| turn.norm() < MAX_TURN_RAD) else {
            continue;
        };
        let rate = 0.5 * (pair[0].rate_rad_s + pair[1].rate_rad_s);
        product += (rate * self::step_s(&pair[0], &pair[1])).dot(&turn);
        square += turn.norm_squared();
        angle += turn.norm();
    }
    let is_near = |unit: &Unit| {
        let [factor, _] = unit.factors();
        (product / square * factor - 1.0).abs() < ANGLE_TOLERANCE
    };
    let unit = Unit::ALL.into_iter().find(is_near).filter(|_| angle > MIN_TURNS_RAD)?;
    Some(unit.note("the turn from row to row is that of the attitude", step_s))
}

/// Turn of the body from one row to the next by the attitude, body axes, rad.
fn turn(from: &LogRow, to: &LogRow) -> Option<Vector3<f64>> {
    // The components from inertial to body axes are those of the rotation from body to inertial axes.
    let rotation = |row: &LogRow| {
        let [x, y, z, w] = row.attitude?;
        UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.0)
    };
    Some((rotation(from)?.inverse() * rotation(to)?).scaled_axis())
}

/// A unit in which the momentum is balanced much better than in SI units.
fn by_momentum(craft: &Craft, rows: &[LogRow], step_s: f64, intervals: usize) -> Option<String> {
    let changes = changes(craft, rows, step_s, intervals);
    if changes.len() < MIN_INTERVALS {
        return None;
    }
    let si = Fit::of(&changes, [1.0; 2]);
    let possible = Unit::ALL.into_iter().filter(|unit| unit.is_possible(step_s));
    let fits: Vec<(Unit, Fit)> =
        possible.map(|unit| (unit, Fit::of(&changes, unit.factors()))).collect();
    let best = fits.iter().map(|(_, fit)| fit.unexplained).fold(f64::INFINITY, f64::min);
    let (unit, fit) = fits.into_iter().find(|(_, fit)| fit.unexplained <= EQUAL_FITS * best)?;
    // A factor below 1 makes the torque small, and its residual with it: both ratios must be large.
    let gain = (si.unexplained / fit.unexplained).min(si.share() / fit.share());
    (gain > MIN_GAIN && fit.share() < MAX_UNEXPLAINED && fit.is_positive).then(|| {
        let reason = format!("the momentum of body and wheels is balanced {gain:.0} times better");
        unit.note(&reason, step_s)
    })
}

/// Rates in deg/s: most are beyond the gyro's range, or beyond the range of ordinary gyros.
fn beyond_range(craft: &Craft, rows: &[LogRow]) -> Option<String> {
    let range = craft.gyro.range_rad_s.unwrap_or(ORDINARY_RANGE_RAD_S);
    let largest = median(rows.iter().map(|row| row.rate_rad_s.amax()).collect())?;
    (largest > range && largest.to_radians() < range).then(|| {
        format!(
            "rates look like deg/s: the median of the largest axis, {largest:.1} rad/s, is beyond the \
             range of the gyro, {range} rad/s; if so, state unit = \"deg/s\" in [log.gyro] of the craft file"
        )
    })
}

/// Rows between which the body turns too far for a prediction.
fn too_far_apart(rows: &[LogRow], step_s: f64) -> Option<String> {
    let rate = median(rows.iter().map(|row| row.rate_rad_s.norm()).collect())?;
    let turn = rate * step_s;
    (turn > std::f64::consts::PI).then(|| {
        format!(
            "median step {step_s} s: the body turns by {turn:.1} rad from row to row, too far for a \
             prediction; check the units of t_s, s, and of the rates, rad/s"
        )
    })
}

fn step_s(from: &LogRow, to: &LogRow) -> f64 {
    to.time_us.saturating_sub(from.time_us) as f64 / 1e6
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::super::Scenario;
    use super::super::scenario::built_in_names;
    use super::*;
    use crate::simulation::log_of;
    use crate::truth::Flight;

    fn log(scenario: &Scenario) -> Vec<LogRow> {
        log_of(scenario, &Flight::simulate(scenario).unwrap(), 1)
    }

    /// Note on the log of a scenario after `spoil` of each row.
    fn note_on(name: &str, spoil: impl Fn(&mut LogRow)) -> Option<String> {
        let scenario = Scenario::load(name).unwrap().of_seed(1);
        let mut rows = log(&scenario);
        rows.iter_mut().for_each(spoil);
        note(&scenario.craft(), &rows)
    }

    fn in_deg_s(row: &mut LogRow) {
        row.rate_rad_s *= 1f64.to_degrees();
    }

    #[test]
    fn built_in_scenarios_have_plausible_units() {
        for name in built_in_names() {
            assert_eq!(note_on(name, |_| ()), None, "{name}");
            assert_eq!(note_on(name, without_attitude), None, "{name}");
        }
    }

    fn without_attitude(row: &mut LogRow) {
        row.attitude = None;
    }

    #[test]
    fn random_spacecraft_have_plausible_units() {
        let random = Scenario::load("random-spacecraft").unwrap();
        for seed in 0..40 {
            let scenario = random.of_seed(seed);
            let mut rows = log(&scenario);
            rows.iter_mut().for_each(without_attitude);
            assert_eq!(note(&scenario.craft(), &rows), None, "{seed}");
        }
    }

    #[test]
    fn rates_in_deg_s_are_named() {
        for name in ["cubesat-pyramid", "stsat3-spin-up", "kim-2010-slew"] {
            let note = note_on(name, in_deg_s).unwrap();
            assert!(note.starts_with("rates look like deg/s: the turn from row to row"), "{note}");
        }
        for name in ["microsat-slew", "cubesat-pyramid-disturbed"] {
            let note = note_on(name, |row| {
                without_attitude(row);
                in_deg_s(row);
            });
            let note = note.unwrap();
            assert!(note.starts_with("rates look like deg/s: the momentum of body and"), "{note}");
        }
    }

    #[test]
    fn time_in_smaller_units_is_named() {
        for (factor, unit) in [(1_000, "milliseconds"), (1_000_000, "microseconds")] {
            for name in ["cubesat-pyramid-disturbed", "cubesat-pyramid"] {
                let note = note_on(name, |row| row.time_us *= factor).unwrap();
                let step = format!("median step {} s: time looks like {unit}", factor / 10);
                assert!(note.starts_with(&step), "{note}");
            }
            let note = note_on("cubesat-pyramid-disturbed", |row| {
                without_attitude(row);
                row.time_us *= factor;
            });
            assert!(note.unwrap().contains("time looks like"), "{unit}");
        }
    }

    const TUMBLE: &str = "name = 'tumble'\nduration_s = 60\n[spacecraft]\n\
        inertia_kg_m2 = [0.4, 0.5, 0.7, 0.01, 0.02, -0.03]\nrate_rad_s = [0.2, 0.4, -0.1]\n\
        [gyro]\nrate_hz = 10\nnoise_rad_s = 1e-4\n";

    #[test]
    fn torque_free_tumble_shows_its_unit_without_wheels() {
        let scenario = Scenario::from_toml("s.toml", TUMBLE, std::path::Path::new("")).unwrap();
        let mut rows = log(&scenario);
        rows.iter_mut().for_each(without_attitude);
        assert_eq!(note(&scenario.craft(), &rows), None);
        rows.iter_mut().for_each(in_deg_s);
        let note = note(&scenario.craft(), &rows).unwrap();
        assert!(note.starts_with("rates look like deg/s"), "{note}");
    }

    #[test]
    fn rest_shows_no_unit_and_the_range_does() {
        let still = TUMBLE.replace("[0.2, 0.4, -0.1]", "[0, 0, 0]");
        let scenario = Scenario::from_toml("s.toml", &still, std::path::Path::new("")).unwrap();
        let mut rows = log(&scenario);
        rows.iter_mut().for_each(without_attitude);
        rows.iter_mut().for_each(in_deg_s);
        assert_eq!(note(&scenario.craft(), &rows), None);
        rows.iter_mut().for_each(|row| row.rate_rad_s.z += 50.0);
        let mut craft = scenario.craft();
        let note = note(&craft, &rows).unwrap();
        assert!(note.contains("50.0 rad/s, is beyond the range of the gyro, 35 rad/s"), "{note}");
        craft.gyro.range_rad_s = Some(60.0);
        assert!(super::note(&craft, &rows).is_none_or(|note| !note.contains("beyond the range")));
        assert_eq!(super::note(&craft, &rows[..1]), None);
        assert_eq!(super::note(&craft, &[]), None);
    }
}
