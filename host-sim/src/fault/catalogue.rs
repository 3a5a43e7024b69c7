//! Faults of the matrix, sized for a scenario.

use crate::input::Scenario;
use crate::input::scenario::Fault;
use crate::input::scenario::fault::FaultKind as Kind;
use crate::truth::Flight;

use super::computer::CHECKPOINT_S;
use super::matrix::MAX_OVER_CLEAN;

/// Earliest and latest start of a fault, share of the flight: after the first estimate, and with most of
/// the flight still to come.
const START: [f64; 2] = [0.3, 0.4];
/// Duration of a short transient, s.
const SHORT_S: f64 = 10.0;
/// Duration of a long transient, s.
const LONG_S: f64 = 30.0;
/// Set of a clock forwards, and offset of a stamp, s: an hour.
const HOUR_S: f64 = 3600.0;
/// One row of the matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Name in reports.
    pub name: String,
    /// The fault.
    pub fault: Fault,
    /// The fault ends before the flight does.
    pub is_transient: bool,
}

impl Entry {
    /// Largest final error over that of the clean flight, for a flight of this duration, s; none for a fault that lasts.
    ///
    /// 1.2 for the data that are left: over a motion that goes on, the information grows with the time,
    /// and the error of a flight without a part of it is larger by the root of the ratio.
    pub fn most_over_clean(&self, duration_s: f64) -> Option<f64> {
        let left_s = duration_s - discarded_s(&self.fault);
        let limit = MAX_OVER_CLEAN * (duration_s / left_s).sqrt();
        (self.is_transient && left_s > 0.0).then_some(limit)
    }

    /// The faults of a scenario, each as one row.
    pub fn of_scenario(scenario: &Scenario) -> Vec<Self> {
        let entry = |(index, fault): (usize, &Fault)| Self {
            name: format!("{}[{}]", fault.kind.properties().name, index + 1),
            fault: *fault,
            is_transient: fault.latest_start_s + fault.duration_s < scenario.duration_s,
        };
        scenario.faults.iter().enumerate().map(entry).collect()
    }
}

/// Longest time whose data a fault discards with the state of the estimator, s: a restart from a checkpoint continues
/// with the data before it, from the last but one up to two periods old.
fn discarded_s(fault: &Fault) -> f64 {
    match fault.kind {
        Kind::Reset => fault.magnitude + fault.duration_s,
        Kind::BitFlip => CHECKPOINT_S,
        Kind::PowerCut => 2.0 * fault.magnitude + fault.duration_s,
        Kind::ColdReset => fault.latest_start_s + fault.duration_s,
        _ => 0.0,
    }
}

/// Scales of a flight that size the faults.
struct Scales {
    /// Gyro noise, rad/s.
    noise_rad_s: f64,
    /// Largest rate about any axis, rad/s.
    rate_rad_s: f64,
    /// Largest external torque about any axis, N m; of a wheel's motor if there is none.
    torque_n_m: f64,
    has_wheels: bool,
    has_torque: bool,
}

impl Scales {
    fn of(scenario: &Scenario, flight: &Flight) -> Self {
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let external = largest(&mut flight.instants.iter().map(|i| i.torque_n_m.amax()));
        let motors = flight.instants.windows(2).flat_map(|pair| {
            let wheels = scenario.wheels.iter().enumerate();
            let period_s = (pair[1].time_us - pair[0].time_us) as f64 * 1e-6;
            wheels.map(move |(i, simulated)| {
                let step = pair[1].wheel_speed_rad_s[i] - pair[0].wheel_speed_rad_s[i];
                simulated.wheel.spin_inertia_kg_m2 * step.abs() / period_s
            })
        });
        Self {
            noise_rad_s: scenario.gyro.noise_rad_s,
            rate_rad_s: largest(&mut flight.instants.iter().map(|i| i.rate_rad_s.amax())),
            torque_n_m: if external > 0.0 { external } else { motors.fold(0.0, f64::max) },
            has_wheels: !scenario.wheels.is_empty(),
            has_torque: external > 0.0,
        }
    }
}

/// Name, kind, duration in s, magnitude, share.
type Line = (&'static str, Kind, f64, f64, f64);

/// The faults that a scenario can have, sized by its noise, rates and torques. Faults of tachometers need
/// wheels; an unreported torque needs an external torque.
pub fn catalogue(scenario: &Scenario, flight: &Flight) -> Vec<Entry> {
    let scales = Scales::of(scenario, flight);
    let mut entries: Vec<Entry> = [of_gyro(&scales), of_time(), of_computer()]
        .concat()
        .into_iter()
        .map(|line| entry(line, scenario))
        .collect();
    entries.insert(3, with_axis(("gyro stuck, y", Kind::GyroStuck, SHORT_S, 0.0, 1.0), scenario));
    if scales.torque_n_m > 0.0 {
        let torque = 0.5 * scales.torque_n_m;
        let line = ("torque not executed", Kind::TorqueNotExecuted, SHORT_S, torque, 1.0);
        entries.push(entry(line, scenario));
    }
    if scales.has_torque {
        let line = ("torque not reported", Kind::TorqueNotReported, SHORT_S, 1.0, 1.0);
        entries.push(entry(line, scenario));
    }
    if scales.has_wheels {
        entries.extend(of_wheels(scenario));
    }
    entries
}

fn of_gyro(scales: &Scales) -> Vec<Line> {
    let sigmas = |count: f64| count * scales.noise_rad_s;
    vec![
        ("gyro spike, one", Kind::GyroSpike, 0.0, sigmas(20.0), 1.0),
        ("gyro spikes, 5 %", Kind::GyroSpike, LONG_S, sigmas(100.0), 0.05),
        ("gyro stuck", Kind::GyroStuck, SHORT_S, 0.0, 1.0),
        ("gyro zeros, 10 %", Kind::GyroZero, LONG_S, 0.0, 0.1),
        ("gyro dropout", Kind::GyroDropout, SHORT_S, 0.0, 1.0),
        ("gyro dropout, 30 %", Kind::GyroDropout, LONG_S, 0.0, 0.3),
        ("gyro saturation", Kind::GyroSaturation, LONG_S, 0.5 * scales.rate_rad_s, 1.0),
        ("gyro bias, 10 sigma", Kind::GyroBias, SHORT_S, sigmas(10.0), 1.0),
        ("gyro noise, 5 times", Kind::GyroNoise, SHORT_S, 5.0, 1.0),
        ("gyro NaN", Kind::GyroNan, SHORT_S, 0.0, 0.5),
        ("gyro infinite", Kind::GyroInfinite, SHORT_S, 0.0, 0.5),
    ]
}

fn of_time() -> Vec<Line> {
    vec![
        ("stamp ahead, one", Kind::StampJump, 0.0, HOUR_S, 1.0),
        ("stamp back, one", Kind::StampJump, 0.0, -SHORT_S, 1.0),
        ("clock set ahead", Kind::ClockSet, 0.0, HOUR_S, 1.0),
        ("clock set back", Kind::ClockSet, 0.0, -SHORT_S, 1.0),
        ("duplicates, 20 %", Kind::Duplicate, LONG_S, 0.0, 0.2),
        ("reordered, 20 %", Kind::Reordered, LONG_S, 0.0, 0.2),
    ]
}

fn of_computer() -> Vec<Line> {
    vec![
        ("reset", Kind::Reset, 2.0, CHECKPOINT_S, 1.0),
        ("cold reset", Kind::ColdReset, 2.0, 0.0, 1.0),
        ("power cut", Kind::PowerCut, SHORT_S, CHECKPOINT_S, 1.0),
        ("bit flip", Kind::BitFlip, 0.0, 1.0, 1.0),
    ]
}

fn of_wheels(scenario: &Scenario) -> Vec<Entry> {
    let one = [
        ("tachometer dropout", Kind::TachometerDropout, SHORT_S, 0.0, 1.0),
        ("tachometer freeze", Kind::TachometerFreeze, SHORT_S, 0.0, 1.0),
        ("tachometer sign", Kind::TachometerSign, SHORT_S, 0.0, 1.0),
        ("tachometer edges, 10 %", Kind::TachometerEdges, SHORT_S, 0.1, 1.0),
        ("tachometer factor 1.5", Kind::TachometerFactor, SHORT_S, 1.5, 1.0),
    ];
    let all = [
        ("tachometers late, 0.3 s", Kind::TachometerLate, LONG_S, 0.3, 1.0),
        ("tachometers frozen", Kind::TachometerFreeze, SHORT_S, 0.0, 1.0),
    ];
    let mut entries: Vec<Entry> = one
        .into_iter()
        .map(|line| {
            let mut entry = entry(line, scenario);
            entry.fault.wheel = Some(0);
            entry
        })
        .chain(all.into_iter().map(|line| entry(line, scenario)))
        .collect();
    let line = ("tachometer edges, for good", Kind::TachometerEdges, 0.0, 0.1, 1.0);
    let mut for_good = entry(line, scenario);
    (for_good.fault.start_s, for_good.fault.latest_start_s) = (0.0, 0.0);
    for_good.fault.duration_s = 2.0 * scenario.duration_s;
    for_good.is_transient = false;
    entries.push(for_good);
    entries
}

fn entry((name, kind, duration_s, magnitude, share): Line, scenario: &Scenario) -> Entry {
    let [start_s, latest_start_s] = START.map(|share| share * scenario.duration_s);
    let fault = Fault {
        kind,
        start_s,
        latest_start_s,
        duration_s,
        magnitude,
        share,
        axis: None,
        wheel: None,
    };
    let is_transient = latest_start_s + duration_s < scenario.duration_s;
    Entry { name: name.to_owned(), fault, is_transient }
}

fn with_axis(line: Line, scenario: &Scenario) -> Entry {
    let mut entry = entry(line, scenario);
    entry.fault.axis = Some(1);
    entry
}
