//! Model of a flight with errors of the hardware: what drives the motion, and its derivatives.
//!
//! ```text
//! Ḣ = τ − ω × H,   ω = J⁻¹ (H − h_w),   z = (1 + M) ω + b
//! ```
//!
//! H total momentum, h_w that of the wheels, τ external torque, body axes. A gyro that is late by δ is equivalent to
//! wheels and torque shifted by δ: `h_w(t − δ)`, `τ(t − δ)`.

use fsw_core::hardware::tilt_directions;
use nalgebra::{Matrix3, Vector3};

use super::record::{Record, Wheel};

/// An unknown besides momentum and inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Unknown {
    /// Scale factor error of a gyro axis.
    GyroScale(usize),
    /// Reading of the first axis of a rate about the second, rad.
    GyroAxes(usize, usize),
    /// Bias of a gyro axis, rad/s.
    Bias(usize),
    /// Spin inertia error of a wheel, share.
    WheelInertia(usize),
    /// Tilt of a wheel's axis, first or second direction, rad.
    WheelAxis(usize, usize),
    /// Delay of the gyro, s.
    Delay,
    /// Scale error of the external torque.
    TorqueScale,
    /// Constant torque about an axis, N m.
    Torque(usize),
    /// Modal inertia of an oscillator, by element, share of the scale.
    Modal(usize),
}

/// Signal at the rows and midway between them.
#[derive(Clone, Debug, Default)]
pub(super) struct Signal {
    pub at: Vec<Vector3<f64>>,
    /// Between row k and k + 1.
    pub middle: Vec<Vector3<f64>>,
}

/// Derivative of the model by one unknown.
#[derive(Clone, Debug)]
pub(super) enum Column {
    /// Of the momentum of the wheels, and of the torque.
    Driven(Signal, Option<Vec<Vector3<f64>>>),
    /// Of the torque alone.
    Torque(Vec<Vector3<f64>>),
    /// Of the reading of the first axis by the rate about the second.
    Reading(usize, usize),
    /// Of the reading of an axis.
    Bias(usize),
}

/// Motion's drive at given values of the unknowns, over the scale.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    pub momentum: Signal,
    pub torque: Vec<Vector3<f64>>,
    pub columns: Vec<Column>,
    pub reading: Matrix3<f64>,
    pub bias: Vector3<f64>,
}

/// Weights of four rows for the value at a time: cubic of Lagrange.
pub(super) fn lagrange(times_s: &[f64], time_s: f64) -> (usize, [f64; 4]) {
    let after = times_s.partition_point(|t| *t <= time_s);
    let first = after.saturating_sub(2).min(times_s.len().saturating_sub(4));
    let nodes = &times_s[first..(first + 4).min(times_s.len())];
    let mut weights = [0.0; 4];
    for (i, weight) in weights.iter_mut().enumerate().take(nodes.len()) {
        *weight = 1.0;
        for (k, node) in nodes.iter().enumerate() {
            if k != i {
                *weight *= (time_s - node) / (nodes[i] - node);
            }
        }
    }
    (first, weights)
}

/// Values at rows and midway, each taken `delay_s` earlier.
fn signal(record: &Record, values: &[Vector3<f64>], delay_s: f64) -> Signal {
    let t = &record.time_s;
    let value = |time_s: f64| {
        let (first, weights) = lagrange(t, time_s);
        weights.iter().zip(&values[first..]).map(|(weight, value)| value * *weight).sum()
    };
    let at = match delay_s {
        0.0 => values.to_vec(),
        delay_s => t.iter().map(|t| value(t - delay_s)).collect(),
    };
    let middle = t.windows(2).map(|pair| value(0.5 * (pair[0] + pair[1]) - delay_s)).collect();
    Signal { at, middle }
}

/// Slope of a signal by central differences of its rows and midpoints.
fn slope(record: &Record, signal: &Signal) -> Signal {
    let (t, rows) = (&record.time_s, record.len());
    let middle = (0..rows - 1).map(|k| (signal.at[k + 1] - signal.at[k]) / (t[k + 1] - t[k]));
    let at = (0..rows).map(|k| {
        let (from, to) = (k.saturating_sub(1), k.min(rows - 2));
        if from == to {
            return (signal.at[from + 1] - signal.at[from]) / (t[from + 1] - t[from]);
        }
        (signal.middle[to] - signal.middle[from]) / (0.5 * (t[to + 1] - t[from]))
    });
    Signal { at: at.collect(), middle: middle.collect() }
}

impl Signal {
    fn scaled(mut self, factor: f64) -> Self {
        self.at.iter_mut().chain(&mut self.middle).for_each(|value| *value *= factor);
        self
    }
}

impl Drive {
    /// The drive of a record with these unknowns at `values`, divided by `scale_kg_m2`.
    pub(super) fn new(
        record: &Record,
        unknowns: &[Unknown],
        values: &[f64],
        modal: &[Signal],
        scale_kg_m2: f64,
    ) -> Self {
        let value_of = |unknown: Unknown| {
            unknowns.iter().position(|u| *u == unknown).map_or(0.0, |place| values[place])
        };
        let delay_s = value_of(Unknown::Delay);
        let per_scale = 1.0 / scale_kg_m2;
        let momentum = momentum(record, &value_of, per_scale);
        let mut driven = signal(record, &momentum, delay_s);
        for (element, column) in modal.iter().enumerate() {
            let value = value_of(Unknown::Modal(element));
            for (sum, add) in driven.at.iter_mut().zip(&column.at) {
                *sum += add * value;
            }
            for (sum, add) in driven.middle.iter_mut().zip(&column.middle) {
                *sum += add * value;
            }
        }
        let torque = torque(record, &value_of, delay_s, per_scale);
        let mut reading = Matrix3::identity();
        for i in 0..3 {
            reading[(i, i)] += value_of(Unknown::GyroScale(i));
            for k in 0..3 {
                reading[(i, k)] += value_of(Unknown::GyroAxes(i, k));
            }
        }
        let bias = Vector3::from_fn(|i, _| value_of(Unknown::Bias(i)));
        let column = |unknown: &Unknown| {
            let of_wheels = (&driven, delay_s);
            column(record, *unknown, &value_of, of_wheels, &torque, modal, per_scale)
        };
        let columns = unknowns.iter().map(column).collect();
        Self { momentum: driven, torque, columns, reading, bias }
    }
}

/// Momentum of the wheels at each row, over the scale.
fn momentum(
    record: &Record,
    value_of: &impl Fn(Unknown) -> f64,
    per_scale: f64,
) -> Vec<Vector3<f64>> {
    let mut sum = vec![Vector3::zeros(); record.len()];
    for (w, wheel) in record.wheels.iter().enumerate() {
        let axis = tilted(wheel, w, value_of).normalize();
        let axis = axis * (1.0 + value_of(Unknown::WheelInertia(w)));
        let of_speed = axis * (wheel.inertia_kg_m2 * per_scale);
        for (sum, speed) in sum.iter_mut().zip(&record.wheel_rad_s[w]) {
            *sum += of_speed * *speed;
        }
    }
    sum
}

/// Axis of a wheel with its tilts, before normalisation.
fn tilted(wheel: &Wheel, w: usize, value_of: &impl Fn(Unknown) -> f64) -> Vector3<f64> {
    let [first, second] = tilt_directions(&wheel.axis);
    wheel.axis
        + first * value_of(Unknown::WheelAxis(w, 0))
        + second * value_of(Unknown::WheelAxis(w, 1))
}

/// Torque at each row, over the scale.
fn torque(
    record: &Record,
    value_of: &impl Fn(Unknown) -> f64,
    delay_s: f64,
    per_scale: f64,
) -> Vec<Vector3<f64>> {
    let factor = (1.0 + value_of(Unknown::TorqueScale)) * per_scale;
    let constant = Vector3::from_fn(|i, _| value_of(Unknown::Torque(i))) * per_scale;
    delayed_torque(record, delay_s).into_iter().map(|torque| torque * factor + constant).collect()
}

/// Stated torque at the instants of the gyro.
fn delayed_torque(record: &Record, delay_s: f64) -> Vec<Vector3<f64>> {
    match delay_s {
        0.0 => record.torque_n_m.clone(),
        delay_s => signal(record, &record.torque_n_m, delay_s).at,
    }
}

/// Derivative of the drive by one unknown.
fn column(
    record: &Record,
    unknown: Unknown,
    value_of: &impl Fn(Unknown) -> f64,
    (driven, delay_s): (&Signal, f64),
    torque: &[Vector3<f64>],
    modal: &[Signal],
    per_scale: f64,
) -> Column {
    let of_wheel = |w: usize, direction: Vector3<f64>| {
        let of_speed = direction * (record.wheels[w].inertia_kg_m2 * per_scale);
        let speeds = record.wheel_rad_s[w].iter();
        let values: Vec<_> = speeds.map(|speed| of_speed * *speed).collect();
        Column::Driven(signal(record, &values, delay_s), None)
    };
    match unknown {
        Unknown::GyroScale(i) => Column::Reading(i, i),
        Unknown::GyroAxes(i, k) => Column::Reading(i, k),
        Unknown::Bias(i) => Column::Bias(i),
        Unknown::WheelInertia(w) => of_wheel(w, tilted(&record.wheels[w], w, value_of).normalize()),
        Unknown::WheelAxis(w, tilt) => {
            // u = (a + θ e)/|a + θ e|: ∂u/∂θ = (e − u (u·e))/|a + θ e|.
            let axis = tilted(&record.wheels[w], w, value_of);
            let direction = tilt_directions(&record.wheels[w].axis)[tilt];
            let unit = axis.normalize();
            let share = 1.0 + value_of(Unknown::WheelInertia(w));
            of_wheel(w, (direction - unit * unit.dot(&direction)) * (share / axis.norm()))
        }
        Unknown::Delay => {
            let torque = Signal { at: torque.to_vec(), middle: middles(torque) };
            let of_torque = slope(record, &torque).scaled(-1.0).at;
            Column::Driven(slope(record, driven).scaled(-1.0), Some(of_torque))
        }
        Unknown::TorqueScale => {
            let torque = delayed_torque(record, delay_s);
            Column::Torque(torque.into_iter().map(|torque| torque * per_scale).collect())
        }
        Unknown::Torque(i) => {
            let mut constant = Vector3::zeros();
            constant[i] = per_scale;
            Column::Torque(vec![constant; record.len()])
        }
        Unknown::Modal(element) => Column::Driven(modal[element].clone(), None),
    }
}

/// Means of neighbours.
fn middles(values: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    values.windows(2).map(|pair| (pair[0] + pair[1]) * 0.5).collect()
}

impl Unknown {
    /// Prior sigma of a diagnosis: wider than any error that a craft file states.
    pub(super) fn widest(self) -> f64 {
        match self {
            Self::GyroScale(_) | Self::WheelInertia(_) | Self::TorqueScale => 0.5,
            Self::GyroAxes(..) | Self::WheelAxis(..) => 0.5,
            Self::Delay => 1.0,
            Self::Bias(_) | Self::Modal(_) => 1.0,
            Self::Torque(_) => 1.0,
        }
    }

    /// Unit of its value; empty for a share.
    pub(super) fn unit(self) -> &'static str {
        match self {
            Self::GyroScale(_) | Self::WheelInertia(_) | Self::TorqueScale => "",
            Self::GyroAxes(..) | Self::WheelAxis(..) => "rad",
            Self::Bias(_) => "rad/s",
            Self::Delay => "s",
            Self::Torque(_) => "N m",
            Self::Modal(_) => "kg m²",
        }
    }
}
