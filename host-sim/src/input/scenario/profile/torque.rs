//! Torque over time: constant, a sum of sines or chirps, or linear between points; in the whole flight
//! or in intervals.

use nalgebra::Vector3;

use super::super::thruster::SimulatedThruster;

/// Torque about one axis over time, N m.
#[derive(Clone, Debug, PartialEq)]
pub enum TorqueProfile {
    /// A constant.
    Constant {
        /// The torque, N m.
        value_n_m: f64,
    },
    /// A sum of sines.
    Multisine {
        /// The terms of the sum.
        terms: Vec<Sine>,
    },
    /// Linear between points; constant before the first and after the last.
    Table {
        /// Times of the points, strictly increasing, s since the start.
        time_s: Vec<f64>,
        /// Torque at each, N m.
        value_n_m: Vec<f64>,
    },
    /// Another profile in intervals, zero between them.
    During {
        /// Start and end of each interval, ascending and disjoint, s since the start of the flight.
        intervals_s: Vec<[f64; 2]>,
        /// The profile, its time counted from the start of each interval.
        profile: Box<TorqueProfile>,
    },
}

/// One term of a sum of sines: `a sin(2π (f + s t) t + φ)`, a chirp unless `s` is zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sine {
    /// Amplitude `a`, N m.
    pub amplitude_n_m: f64,
    /// Frequency `f` at the start, Hz.
    pub frequency_hz: f64,
    /// Sweep `s`, half the rate at which the frequency grows, Hz/s.
    pub sweep_hz_s: f64,
    /// Phase `φ` at the start, rad.
    pub phase_rad: f64,
}

/// Torque about the three body axes over time: profiles, and pulses of thrusters.
#[derive(Clone, Debug, PartialEq)]
pub struct ExternalTorque {
    /// The profile about x, y and z.
    pub axes: [TorqueProfile; 3],
    /// Thrusters.
    pub thrusters: Vec<SimulatedThruster>,
}

impl TorqueProfile {
    /// No torque at any time.
    pub const ZERO: Self = Self::Constant { value_n_m: 0.0 };

    /// True if the torque is smooth between its samples; otherwise it is linear.
    pub fn is_smooth(&self) -> bool {
        match self {
            Self::Constant { .. } | Self::Table { .. } => false,
            Self::Multisine { .. } => true,
            Self::During { profile, .. } => profile.is_smooth(),
        }
    }

    /// The torque `t_s` seconds after the start, N m.
    pub fn at(&self, t_s: f64) -> f64 {
        match self {
            Self::Constant { value_n_m } => *value_n_m,
            Self::Multisine { terms } => terms.iter().map(|term| term.at(t_s)).sum(),
            Self::Table { time_s, value_n_m } => interpolate(time_s, value_n_m, t_s),
            Self::During { intervals_s, profile } => {
                let begun = intervals_s.partition_point(|[start_s, _]| *start_s <= t_s);
                match intervals_s[..begun].last() {
                    Some([start_s, end_s]) if t_s < *end_s => profile.at(t_s - start_s),
                    _ => 0.0,
                }
            }
        }
    }

    /// The profile commanded at `rate_hz`, linear between these points, from the start to
    /// `duration_s`. The instants are rounded to 1 µs as those of gyro samples.
    pub fn in_points(&self, rate_hz: f64, duration_s: f64) -> Self {
        let last = (duration_s * rate_hz).ceil() as u64;
        let time_s: Vec<f64> =
            (0..=last).map(|index| (index as f64 / rate_hz * 1e6).round() * 1e-6).collect();
        let value_n_m = time_s.iter().map(|t_s| self.at(*t_s)).collect();
        Self::Table { time_s, value_n_m }
    }

    /// Times at which torque or its slope may jump, ascending, s: steps of an integrator should end
    /// there. The torque at such a time is its right limit.
    pub fn breakpoints_s(&self) -> Vec<f64> {
        match self {
            Self::Constant { .. } | Self::Multisine { .. } => Vec::new(),
            Self::Table { time_s, .. } => time_s.clone(),
            Self::During { intervals_s, profile } => {
                let inside = profile.breakpoints_s();
                let of = |&[start_s, end_s]: &[f64; 2]| {
                    let shifted = inside.iter().map(move |t_s| start_s + t_s);
                    let within: Vec<f64> =
                        shifted.filter(|t_s| start_s < *t_s && *t_s < end_s).collect();
                    [vec![start_s], within, vec![end_s]].concat()
                };
                intervals_s.iter().flat_map(of).collect()
            }
        }
    }
}

impl Sine {
    fn at(&self, t_s: f64) -> f64 {
        let Self { amplitude_n_m, frequency_hz, sweep_hz_s, phase_rad } = *self;
        let turns = (frequency_hz + sweep_hz_s * t_s) * t_s;
        amplitude_n_m * (std::f64::consts::TAU * turns + phase_rad).sin()
    }
}

impl ExternalTorque {
    /// True if the torque about any axis is smooth between its samples.
    pub fn is_smooth(&self) -> bool {
        self.axes.iter().any(TorqueProfile::is_smooth)
    }

    /// No torque at any time.
    pub const ZERO: Self = Self {
        axes: [TorqueProfile::ZERO, TorqueProfile::ZERO, TorqueProfile::ZERO],
        thrusters: Vec::new(),
    };

    /// The torque `t_s` seconds after the start, body axes, N m.
    pub fn at(&self, t_s: f64) -> Vector3<f64> {
        let [x, y, z] = &self.axes;
        let profiles = Vector3::new(x.at(t_s), y.at(t_s), z.at(t_s));
        self.thrusters.iter().fold(profiles, |sum, of| sum + of.torque_at_n_m(t_s))
    }

    /// Times at which torque or its slope may jump, ascending, s: steps of an integrator should end
    /// there.
    pub fn breakpoints_s(&self) -> Vec<f64> {
        // The axes share the times of a table and the intervals.
        let [x, _, _] = &self.axes;
        let pulses = self.thrusters.iter().flat_map(|thruster| thruster.on_s.concat());
        let mut all: Vec<f64> = x.breakpoints_s().into_iter().chain(pulses).collect();
        all.sort_by(f64::total_cmp);
        all
    }
}

/// Linear interpolation between points, constant beyond them.
fn interpolate(time_s: &[f64], value: &[f64], t_s: f64) -> f64 {
    // The first point after t_s.
    let end = time_s.partition_point(|time| *time <= t_s);
    let start = end.saturating_sub(1);
    let point = |index: usize| Some((*time_s.get(index)?, *value.get(index)?));
    match (point(start), point(end)) {
        (Some((t0, v0)), Some((t1, v1))) if t1 > t0 => v0 + (v1 - v0) * (t_s - t0) / (t1 - t0),
        (Some((_, only)), _) => only,
        (None, _) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multisine_is_the_sum_of_its_sines() {
        let quarter_turn = std::f64::consts::FRAC_PI_2;
        let terms = vec![
            Sine { amplitude_n_m: 2.0, frequency_hz: 0.25, sweep_hz_s: 0.0, phase_rad: 0.0 },
            Sine {
                amplitude_n_m: 3.0,
                frequency_hz: 1.0,
                sweep_hz_s: 0.0,
                phase_rad: quarter_turn,
            },
        ];
        let profile = TorqueProfile::Multisine { terms };
        assert!((profile.at(0.0) - 3.0).abs() < 1e-12);
        assert!((profile.at(1.0) - 5.0).abs() < 1e-12);
        assert!(profile.breakpoints_s().is_empty());
    }

    #[test]
    fn frequency_of_a_chirp_increases() {
        // (1/4 + t/2) t turns: 3/4 after 1 s, 3/2 after 1.5 s.
        let term = Sine { amplitude_n_m: 2.0, frequency_hz: 0.25, sweep_hz_s: 0.5, phase_rad: 0.0 };
        let profile = TorqueProfile::Multisine { terms: vec![term] };
        assert!((profile.at(1.0) + 2.0).abs() < 1e-12);
        assert!((profile.at(1.5) - 2.0 * (3.0 * std::f64::consts::PI).sin()).abs() < 1e-12);
    }

    #[test]
    fn points_lie_on_the_profile_with_lines_between() {
        let term = Sine { amplitude_n_m: 1.0, frequency_hz: 0.1, sweep_hz_s: 0.0, phase_rad: 0.5 };
        let sine = TorqueProfile::Multisine { terms: vec![term] };
        let points = sine.in_points(2.0, 1.8);
        assert_eq!(points.breakpoints_s(), [0.0, 0.5, 1.0, 1.5, 2.0]);
        assert_eq!(points.at(1.5), sine.at(1.5));
        let middle = (sine.at(1.0) + sine.at(1.5)) / 2.0;
        assert!((points.at(1.25) - middle).abs() < 1e-15);
    }

    #[test]
    fn table_is_linear_between_rows_and_constant_beyond() {
        let profile =
            TorqueProfile::Table { time_s: vec![1.0, 2.0, 4.0], value_n_m: vec![10.0, 20.0, 0.0] };
        for (t_s, expected) in [
            (-1.0, 10.0),
            (1.0, 10.0),
            (1.25, 12.5),
            (2.0, 20.0),
            (3.0, 10.0),
            (4.0, 0.0),
            (9.0, 0.0),
        ] {
            assert_eq!(profile.at(t_s), expected, "{t_s}");
        }
        assert_eq!(profile.breakpoints_s(), [1.0, 2.0, 4.0]);
    }

    #[test]
    fn profile_restarts_in_each_interval_and_is_zero_between() {
        let table = TorqueProfile::Table { time_s: vec![0.0, 2.0], value_n_m: vec![4.0, 8.0] };
        let profile = TorqueProfile::During {
            intervals_s: vec![[10.0, 13.0], [20.0, 21.0]],
            profile: Box::new(table),
        };
        for (t_s, expected) in [
            (0.0, 0.0),
            (10.0, 4.0),
            (11.0, 6.0),
            (12.5, 8.0),
            (13.0, 0.0),
            (19.9, 0.0),
            (20.5, 5.0),
            (21.0, 0.0),
        ] {
            assert_eq!(profile.at(t_s), expected, "{t_s}");
        }
        // The second interval ends before the table does.
        assert_eq!(profile.breakpoints_s(), [10.0, 12.0, 13.0, 20.0, 21.0]);
    }

    #[test]
    fn table_of_one_row_is_constant() {
        let profile = TorqueProfile::Table { time_s: vec![0.0], value_n_m: vec![7.0] };
        assert_eq!([profile.at(-1.0), profile.at(0.0), profile.at(1.0)], [7.0; 3]);
    }
}
