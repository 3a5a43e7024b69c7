//! Values that are valid, and probably mistakes of a unit.

use std::f64::consts::TAU;

use flight_input::words::short;

use super::log::LogRow;
use super::scenario::SimulatedWheel;
use super::{Craft, Scenario};
use crate::truth::Instant;

/// Largest speed of an ordinary wheel, rad/s: 10,000 rpm.
const MAX_WHEEL_RAD_S: f64 = 1_047.2;
/// Noise of ordinary gyros, one sample, rad/s: 0.02 arcsec/s of a laser gyro to 1 deg/s of a telephone.
const NOISE_RAD_S: std::ops::RangeInclusive<f64> = 1e-7..=0.0175;
/// Share above a limit that is rounding of a difference of momenta.
const LIMIT_ROUNDING: f64 = 1e-6;
/// Largest full scale of ordinary gyros, rad/s: 4,000 deg/s.
const MAX_RANGE_RAD_S: f64 = 70.0;

/// Shortest median step of a log that is noted, s.
const MAX_STEP_S: f64 = 30.0;
/// Stretches of a log whose typical rates are compared.
const STRETCHES: usize = 100;
/// Largest ratio of two rates at one momentum: that of the moments, 10 for a slender body.
const MAX_RATIO: f64 = 10.0;

/// Notes on the gyro and the wheels of a craft.
pub fn craft(craft: &Craft) -> Vec<String> {
    let gyro = &craft.gyro;
    let range = gyro.range_rad_s.filter(|range| *range > MAX_RANGE_RAD_S);
    let range = range.map(|range| {
        format!(
            "gyro.range_rad_s is {range} rad/s, {:.0} deg/s: above ordinary gyros; check the unit",
            range.to_degrees()
        )
    });
    gyro.noise_rad_s.and_then(noise).into_iter().chain(range).chain(heavy_wheels(craft)).collect()
}

/// Notes on the speeds of wheels in a log, and on a motion that nothing in it drives.
pub fn log(rows: &[LogRow]) -> Vec<String> {
    let wheels = rows.first().map_or(0, |row| row.wheel_speed_rad_s.len());
    let largest = |wheel: usize| {
        let mut speeds: Vec<f64> = rows
            .iter()
            .filter_map(|row| row.wheel_speed_rad_s.get(wheel))
            .map(|s| s.abs())
            .collect();
        speeds.sort_by(f64::total_cmp);
        speeds.get(speeds.len() * 9 / 10).copied().unwrap_or(0.0)
    };
    let note = |wheel: usize| wheel_speed(&format!("wheel {}", wheel + 1), largest(wheel));
    let of_wheels =
        (0..wheels).filter_map(note).chain((0..wheels).filter_map(|w| standing(rows, w)));
    of_wheels.chain(slow(rows)).chain(undriven(rows)).collect()
}

/// A wheel of one speed beside others that change.
fn standing(rows: &[LogRow], wheel: usize) -> Option<String> {
    let is_constant = |wheel: usize| {
        let speed = |row: &LogRow| row.wheel_speed_rad_s.get(wheel).copied();
        rows.windows(2).all(|pair| speed(&pair[0]) == speed(&pair[1]))
    };
    let first = rows.first().filter(|_| rows.len() > 2 * STRETCHES)?;
    let has_others = (0..first.wheel_speed_rad_s.len()).any(|other| !is_constant(other));
    (has_others && is_constant(wheel)).then(|| {
        format!(
            "wheel {} has the speed {} rad/s in all rows: right for a wheel that stands or is held; else its column or its \
             tachometer is at fault",
            wheel + 1,
            short(first.wheel_speed_rad_s[wheel])
        )
    })
}

/// Rows further apart than those of house-keeping.
fn slow(rows: &[LogRow]) -> Option<String> {
    let mut steps: Vec<u64> =
        rows.windows(2).map(|pair| pair[1].time_us.saturating_sub(pair[0].time_us)).collect();
    steps.sort_unstable();
    let step_s = *steps.get(steps.len() / 2)? as f64 * 1e-6;
    (step_s >= MAX_STEP_S).then(|| {
        format!(
            "the median step is {} s; if the stamps are in ms, state time_unit = \"ms\" in [log] of the craft file",
            short(step_s)
        )
    })
}

/// A rate that rises or falls many times, in a log without wheels and torque.
fn undriven(rows: &[LogRow]) -> Option<String> {
    let is_driven = |row: &LogRow| {
        row.torque_n_m.norm() > 0.0 || row.wheel_speed_rad_s.iter().any(|speed| *speed != 0.0)
    };
    if rows.len() < 2 * STRETCHES || rows.iter().any(is_driven) {
        return None;
    }
    let of_stretch = |rows: &[LogRow]| {
        let mut rates: Vec<f64> = rows.iter().map(|row| row.rate_rad_s.norm()).collect();
        rates.sort_by(f64::total_cmp);
        rates.get(rates.len() / 2).copied().unwrap_or(0.0)
    };
    let rates = rows.chunks(rows.len().div_ceil(STRETCHES)).map(of_stretch);
    let (least, largest) =
        rates.fold((f64::INFINITY, 0.0), |(least, largest), r| (r.min(least), r.max(largest)));
    (largest > MAX_RATIO * least).then(|| {
        format!(
            "the rate changes between {} and {} rad/s, and the log has no wheels and no torque: without them the momentum \
             is constant; name their columns in [log.wheels] or [log.torque]",
            short(least),
            short(largest)
        )
    })
}

/// Notes on a scenario.
pub fn scenario(scenario: &Scenario) -> Vec<String> {
    let wheels = scenario.wheels.iter().enumerate();
    let speeds = wheels.filter_map(|(index, wheel)| {
        wheel_speed(&format!("wheel[{}].speed_rad_s", index + 1), wheel.speed_rad_s.abs())
    });
    craft(&scenario.craft()).into_iter().chain(speeds).collect()
}

/// Notes on wheels that exceed their `max_torque_n_m` or `max_speed_rad_s` in a flight.
///
/// The torque of a motor, controller included, is the change of the axial momentum `Iₛ (Ω + a · ω)` from sample to
/// sample.
pub fn flight(scenario: &Scenario, instants: &[Instant]) -> Vec<String> {
    let wheels = scenario.true_wheels();
    let note = |(index, wheel): (usize, &SimulatedWheel)| {
        let wheel = &wheel.wheel;
        let speed = |instant: &Instant| instant.wheel_speed_rad_s[index];
        let momentum = |instant: &Instant| {
            wheel.spin_inertia_kg_m2 * (speed(instant) + wheel.axis.dot(&instant.rate_rad_s))
        };
        let torque = |pair: &[Instant]| {
            let time_s = (pair[1].time_us - pair[0].time_us) as f64 * 1e-6;
            ((momentum(&pair[1]) - momentum(&pair[0])) / time_s).abs()
        };
        let fastest = instants.iter().map(|instant| speed(instant).abs()).fold(0.0, f64::max);
        let strongest = instants.windows(2).map(torque).fold(0.0, f64::max);
        let exceeded = [
            ("max_torque_n_m", strongest, wheel.limits.max_torque_n_m, "N m"),
            ("max_speed_rad_s", fastest, wheel.limits.max_speed_rad_s, "rad/s"),
        ];
        let line = move |(key, found, limit, unit): (&str, f64, Option<f64>, &str)| {
            let limit = limit.filter(|limit| found > limit * (1.0 + LIMIT_ROUNDING))?;
            Some(format!(
                "wheel[{}] reaches {found:.4e} {unit}, beyond its {key} of {limit:e} {unit}: no wheel flies \
                 this; reduce the torque or the duration",
                index + 1
            ))
        };
        exceeded.into_iter().filter_map(line)
    };
    wheels.iter().enumerate().flat_map(note).collect()
}

fn noise(noise_rad_s: f64) -> Option<String> {
    (!NOISE_RAD_S.contains(&noise_rad_s)).then(|| {
        format!(
            "the gyro noise is {noise_rad_s:.3e} rad/s, {:.3} deg/s a sample: outside ordinary gyros, \
             {:e} to {:e} rad/s; check the unit",
            noise_rad_s.to_degrees(),
            NOISE_RAD_S.start(),
            NOISE_RAD_S.end()
        )
    })
}

fn wheel_speed(name: &str, speed_rad_s: f64) -> Option<String> {
    (speed_rad_s > MAX_WHEEL_RAD_S).then(|| {
        format!(
            "{name}: {speed_rad_s:.0} rad/s are {:.0} rpm, above ordinary wheels; if the speeds are in rpm, \
             state unit = \"rpm\" in [log.wheels]",
            speed_rad_s * 60.0 / TAU
        )
    })
}

/// Wheels that have more inertia about their axis than a tenth of the expected body.
fn heavy_wheels(craft: &Craft) -> Option<String> {
    const LARGEST_SHARE: f64 = 0.1;
    let prior = craft.prior.as_ref()?;
    let [x, y, z, ..] = prior.inertia_kg_m2;
    let least = x.min(y).min(z);
    let heavy = |inertia: f64| inertia > LARGEST_SHARE * least;
    let index = craft.wheels.iter().position(|wheel| heavy(wheel.spin_inertia_kg_m2))?;
    let inertia = craft.wheels[index].spin_inertia_kg_m2;
    Some(format!(
        "wheel[{}].spin_inertia_kg_m2 is {inertia:e} kg m², beside {least} kg m² of the body; check the \
         unit",
        index + 1
    ))
}

#[cfg(test)]
mod tests {
    use flight_input::craft::WheelLimits;

    use crate::truth::Flight;

    use super::super::scenario::built_in_names;
    use super::*;

    #[test]
    fn built_in_scenarios_are_plausible() {
        for name in built_in_names() {
            let built_in = Scenario::load(name).unwrap();
            assert_eq!(scenario(&built_in), Vec::<String>::new(), "{name}");
        }
    }

    #[test]
    fn mistakes_of_a_unit_are_named_in_both_units() {
        let craft_of = |text: &str| craft(&Craft::from_toml("craft.toml", text).unwrap());
        let notes = craft_of("[gyro]\nnoise_rad_s = 0.07\nrange_rad_s = 2000\n");
        assert!(notes[0].starts_with("the gyro noise is 7.000e-2 rad/s, 4.011 deg/s a sample"));
        assert!(notes[1].starts_with("gyro.range_rad_s is 2000 rad/s, 114592 deg/s: above"));
        assert!(craft_of("[gyro]\nnoise_rad_s = 1e-3\nrange_rad_s = 35\n").is_empty());
        let prior =
            "[prior]\ninertia_kg_m2 = [1, 1, 1, 0, 0, 0]\nsigma_kg_m2 = [1, 1, 1, 1, 1, 1]\n";
        let heavy = format!("{prior}[[wheel]]\naxis = [1, 0, 0]\nspin_inertia_kg_m2 = 0.2\n");
        assert!(craft_of(&heavy)[0].starts_with("wheel[1].spin_inertia_kg_m2 is 2e-1 kg m²"));

        let row = LogRow {
            line: 2,
            time_us: 0,
            rate_rad_s: Default::default(),
            wheel_speed_rad_s: vec![100.0, -3000.0],
            torque_n_m: Default::default(),
            attitude: None,
        };
        assert_eq!(
            log(&[row]),
            [
                "wheel 2: 3000 rad/s are 28648 rpm, above ordinary wheels; if the speeds are in rpm, state \
              unit = \"rpm\" in [log.wheels]"
            ]
        );
    }

    #[test]
    fn wheels_without_motion_and_motion_without_wheels_are_noted() {
        let scenario = Scenario::load("cubesat-pyramid").unwrap();
        let flight = Flight::simulate(&scenario).unwrap();
        let mut rows = crate::simulation::log_of(&scenario, &flight, 1);
        assert!(log(&rows).is_empty());
        rows.iter_mut().for_each(|row| row.wheel_speed_rad_s[1] = 0.0);
        assert!(log(&rows)[0].starts_with("wheel 2 has the speed 0 rad/s in all rows"));
        rows.iter_mut().for_each(|row| row.time_us *= 1000);
        assert!(log(&rows)[1].starts_with("the median step is 100 s"));
        rows.iter_mut().for_each(|row| row.time_us /= 1000);
        rows.iter_mut().for_each(|row| row.wheel_speed_rad_s.clear());
        assert!(log(&rows)[0].contains("the log has no wheels and no torque"));
        rows.iter_mut().for_each(|row| row.rate_rad_s.x += 1.0);
        assert!(log(&rows).is_empty());
    }

    #[test]
    fn flight_beyond_the_limits_of_a_wheel_is_noted() {
        let mut scenario = Scenario::load("microsat-slew").unwrap();
        let notes =
            |scenario: &Scenario| flight(scenario, &Flight::simulate(scenario).unwrap().instants);
        assert!(notes(&scenario).is_empty());
        scenario.wheels[0].wheel.limits =
            WheelLimits { max_torque_n_m: Some(1e-3), max_speed_rad_s: Some(140.0) };
        scenario.wheels[2].wheel.limits =
            WheelLimits { max_torque_n_m: Some(0.1), max_speed_rad_s: Some(1000.0) };
        let found = notes(&scenario);
        assert!(found.iter().all(|note| note.starts_with("wheel[1] reaches")), "{found:?}");
        assert_eq!(found.len(), 2, "{found:?}");
    }
}
