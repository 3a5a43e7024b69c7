//! Quadrature encoders of the wheels: edges from wheel speeds, and the timer that captures them.
//!
//! In: wheel speeds at the gyro samples. Out: the edges in between, each with the timer's tick and
//! the levels of both channels, for the [`EdgeFilter`] that a board's interrupt calls; and the content
//! of the capture timer at each sample.
//!
//! Between two samples the speed is a cubic Hermite polynomial with the slopes of the neighbouring
//! samples (see [`SpeedSegment`]), and the angle is its integral.

use std::borrow::Cow;

use fsw_target::drivers::wheel_tach::{CaptureTimer, Captured, EdgeFilter};

use crate::truth::Instant;

/// Slices per edge into which a segment is divided for the search of edges. A reversal within one
/// slice may go undetected.
const SLICES_PER_EDGE: f64 = 4.0;
/// Smallest number of slices of a segment.
const MIN_SLICES: f64 = 16.0;
/// Bisections of a slice: 2⁻⁴⁰ of a tenth of a second is far below a tick.
const BISECTIONS: usize = 40;

/// Properties of encoder and timer, the same for each wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncoderData {
    /// Edges per turn: rising and falling edges of the first channel.
    pub edges_per_turn: u16,
    /// Timer frequency, ticks/s.
    pub ticks_per_s: u32,
    /// Shortest valid pulse, ticks.
    pub shortest_ticks: u32,
}

impl Default for EncoderData {
    /// Twelve pulses per turn, as of three Hall sensors on a motor with four pole pairs; a timer at
    /// 1 MHz; at least 0.1 ms between edges (2600 rad/s).
    fn default() -> Self {
        Self { edges_per_turn: 24, ticks_per_s: 1_000_000, shortest_ticks: 100 }
    }
}

/// Wheel speed from one sample to the next, a cubic Hermite polynomial of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedSegment {
    /// Start, s.
    pub from_s: f64,
    /// Duration, s.
    pub duration_s: f64,
    /// Speed at start and end, rad/s.
    pub speed_rad_s: [f64; 2],
    /// Slope of the speed at start and end, rad/s².
    pub slope_rad_s2: [f64; 2],
}

impl SpeedSegment {
    /// Angle turned after the share `x` of the segment, rad: the integral of the speed,
    /// `T (v₀ x + a₀ x²/2 + (v₁ − v₀ − (2 a₀ + a₁)/3) x³ + (2 (v₀ − v₁) + a₀ + a₁) x⁴/4)`, with
    /// duration `T`, speeds `v`, and slopes times duration `a`.
    fn angle_rad(&self, share: f64) -> f64 {
        let [v0, v1] = self.speed_rad_s;
        let [a0, a1] = self.slope_rad_s2.map(|slope| slope * self.duration_s);
        let x = share;
        let cubic = x * x * x * (v1 - v0 - (2.0 * a0 + a1) / 3.0);
        let quartic = x * x * x * x * (2.0 * (v0 - v1) + a0 + a1) / 4.0;
        self.duration_s * (v0 * x + a0 * x * x / 2.0 + cubic + quartic)
    }
}

/// Edge of the first channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Time, s.
    pub time_s: f64,
    /// Level of the first channel after the edge.
    pub a: bool,
    /// Level of the second channel.
    pub b: bool,
}

/// Encoder of one wheel.
#[derive(Clone, Debug)]
pub struct Encoder {
    edges_per_rad: f64,
    /// Angle of the wheel, edges; not wrapped.
    position: f64,
}

impl Encoder {
    /// Encoder of a wheel that stands halfway between two edges.
    pub fn new(edges_per_turn: u16) -> Self {
        Self { edges_per_rad: f64::from(edges_per_turn) / std::f64::consts::TAU, position: 0.5 }
    }

    /// Turns the wheel through a segment. `on_edge` is called for each edge in order of time.
    pub fn turn(&mut self, segment: &SpeedSegment, mut on_edge: impl FnMut(Edge)) {
        let start = self.position;
        let position = |share: f64| start + self.edges_per_rad * segment.angle_rad(share);
        let [v0, v1] = segment.speed_rad_s.map(f64::abs);
        let edges = v0.max(v1) * segment.duration_s * self.edges_per_rad;
        let slices = (edges * SLICES_PER_EDGE).max(MIN_SLICES).ceil();
        let mut before = 0.0;
        for slice in 1..=slices as u64 {
            let after = slice as f64 / slices;
            let (from, to) = (position(before).floor(), position(after).floor());
            if from != to {
                let share = crossing(&position, before, after, from);
                let time_s = segment.from_s + share * segment.duration_s;
                let a = to.rem_euclid(2.0) == 1.0;
                on_edge(Edge { time_s, a, b: a != (to > from) });
            }
            before = after;
        }
        self.position = position(1.0);
    }
}

/// Share of a segment at which `position` leaves the step `from`, by bisection between two shares.
fn crossing(position: &impl Fn(f64) -> f64, mut before: f64, mut after: f64, from: f64) -> f64 {
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (before + after);
        if position(middle).floor() == from {
            before = middle;
        } else {
            after = middle;
        }
    }
    after
}

/// Encoders of a flight, for up to W wheels, and the timer that captures their edges.
#[derive(Clone, Debug)]
pub struct Captures<'a, const W: usize> {
    data: EncoderData,
    instants: Cow<'a, [Instant]>,
    encoders: [Encoder; W],
    filters: [EdgeFilter; W],
    /// Index of the current sample.
    index: usize,
}

impl<'a, const W: usize> Captures<'a, W> {
    /// Encoders at the first sample, without edges.
    pub fn new(data: EncoderData, instants: impl Into<Cow<'a, [Instant]>>) -> Self {
        Self {
            data,
            instants: instants.into(),
            encoders: std::array::from_fn(|_| Encoder::new(data.edges_per_turn)),
            filters: [EdgeFilter::new(data.shortest_ticks); W],
            index: 0,
        }
    }

    /// Adds a sample after the last one.
    pub fn add(&mut self, instant: Instant) {
        self.instants.to_mut().push(instant);
    }

    /// Advances to the next sample.
    pub fn advance(&mut self) {
        for wheel in 0..W {
            if let Some(segment) = segment(&self.instants, self.index, wheel) {
                let filter = &mut self.filters[wheel];
                let ticks_per_s = f64::from(self.data.ticks_per_s);
                self.encoders[wheel].turn(&segment, |edge| {
                    filter.edge(ticks(edge.time_s, ticks_per_s), edge.a, edge.b);
                });
            }
        }
        self.index += 1;
    }

    /// Content of the timer at the current sample.
    pub fn now(&self) -> [Captured; W] {
        let time_s = self.instants.get(self.index).map_or(0.0, |instant| seconds(instant.time_us));
        let now_ticks = ticks(time_s, f64::from(self.data.ticks_per_s));
        std::array::from_fn(|wheel| self.filters[wheel].captured(now_ticks))
    }
}

impl<const W: usize> CaptureTimer<W> for Captures<'_, W> {
    type Error = std::convert::Infallible;

    fn ticks_per_s(&self) -> u32 {
        self.data.ticks_per_s
    }

    fn captured(&mut self) -> Result<[Captured; W], Self::Error> {
        Ok(self.now())
    }
}

/// Timer content at a time: whole ticks, modulo 2³².
fn ticks(time_s: f64, ticks_per_s: f64) -> u32 {
    (time_s * ticks_per_s) as u64 as u32
}

fn seconds(time_us: u64) -> f64 {
    time_us as f64 * 1e-6
}

/// Speed of a wheel from a sample to the next; none without that wheel or without a next sample.
fn segment(instants: &[Instant], index: usize, wheel: usize) -> Option<SpeedSegment> {
    let at = |index: usize| {
        let instant = instants.get(index)?;
        Some((seconds(instant.time_us), *instant.wheel_speed_rad_s.get(wheel)?))
    };
    let ((from_s, v0), (to_s, v1)) = (at(index)?, at(index + 1)?);
    let slope = |(t0, v0): (f64, f64), (t1, v1): (f64, f64)| (v1 - v0) / (t1 - t0);
    let before = index.checked_sub(1).and_then(at).unwrap_or((from_s, v0));
    let after = at(index + 2).unwrap_or((to_s, v1));
    Some(SpeedSegment {
        from_s,
        duration_s: to_s - from_s,
        speed_rad_s: [v0, v1],
        slope_rad_s2: [slope(before, (to_s, v1)), slope((from_s, v0), after)],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::Scenario;
    use crate::input::craft::StatedHardware;
    use crate::input::log::{LogRow, correct_wheels};
    use crate::truth::Flight;
    use fsw_target::drivers::wheel_tach::{Config, WheelTach};
    use nalgebra::Vector3;

    const CUBIC: SpeedSegment = SpeedSegment {
        from_s: 3.0,
        duration_s: 0.5,
        speed_rad_s: [100.0, 80.0],
        slope_rad_s2: [30.0, -60.0],
    };

    #[test]
    fn angle_is_the_integral_of_the_speed() {
        let step = 1e-5;
        let speed = |share: f64| {
            (CUBIC.angle_rad(share + step) - CUBIC.angle_rad(share - step)) / (2.0 * step * 0.5)
        };
        let slope = |share: f64| (speed(share + 1e-3) - speed(share - 1e-3)) / (2.0 * 1e-3 * 0.5);
        assert_eq!(CUBIC.angle_rad(0.0), 0.0);
        for (share, v, a) in [(0.0, 100.0, 30.0), (1.0, 80.0, -60.0)] {
            assert!((speed(share) - v).abs() < 1e-5, "{}", speed(share));
            assert!((slope(share) - a).abs() < 0.01, "{}", slope(share));
        }
    }

    #[test]
    fn each_edge_occurs_once_in_order_at_its_position() {
        let mut encoder = Encoder::new(24);
        let start = encoder.position;
        let mut edges = Vec::new();
        encoder.turn(&CUBIC, |edge| edges.push(edge));
        assert_eq!(edges.len(), encoder.position.floor() as usize);
        for (k, edge) in edges.iter().enumerate() {
            let share = (edge.time_s - CUBIC.from_s) / CUBIC.duration_s;
            let position = start + encoder.edges_per_rad * CUBIC.angle_rad(share);
            assert!((position - (k + 1) as f64).abs() < 1e-9, "edge {k} at {position}");
            assert_eq!((edge.a, edge.b), (k % 2 == 0, k % 2 == 1));
        }
    }

    #[test]
    fn reversal_repeats_the_same_edges() {
        let reversal = SpeedSegment {
            from_s: 0.0,
            duration_s: 1.0,
            speed_rad_s: [5.0, -5.0],
            slope_rad_s2: [-10.0, -10.0],
        };
        let mut filter = EdgeFilter::new(100);
        let mut encoder = Encoder::new(24);
        let mut edges = Vec::new();
        encoder.turn(&reversal, |edge| {
            filter.edge((edge.time_s * 1e6) as u32, edge.a, edge.b);
            edges.push(filter.captured(0).edges);
        });
        // 1.25 rad forward are 4.77 edges from the middle of a step: five edges, each passed twice.
        assert_eq!(edges, [1, 2, 3, 4, 5, 5, 4, 3, 2, 1]);
        assert!((encoder.position - 0.5).abs() < 1e-9);
    }

    /// Calls `visit` with the driver's wheel speeds of a flight, rad/s, and the true instant. The number of instants without
    /// speeds.
    fn each_speed(scenario: &Scenario, mut visit: impl FnMut(&[f32], &Instant)) -> usize {
        let flight = Flight::simulate(scenario).unwrap();
        let data = EncoderData::default();
        let config = Config {
            edges_per_turn: [data.edges_per_turn; 4],
            reversed: [false; 4],
            largest_acceleration_rad_s2: f32::INFINITY,
            delay_us: 0,
            zero_after_s: 0.5,
        };
        let captures = Captures::<4>::new(data, &flight.instants);
        let mut tach = WheelTach::new(captures, &config).unwrap();
        let mut missed = 0;
        for instant in &flight.instants {
            let speeds = tach.speed_rad_s();
            tach.timer().advance();
            match speeds {
                Ok(speeds) => visit(&speeds[..scenario.wheels.len()], instant),
                Err(_) => missed += 1,
            }
        }
        missed
    }

    /// Error of the driver's wheel speeds on a flight, as momentum, N m s: RMS and largest.
    fn momentum_errors(scenario: &str) -> (f64, f64) {
        let scenario = Scenario::load(scenario).unwrap();
        let (mut squares, mut largest, mut count) = (0.0, 0.0f64, 0);
        let missed = each_speed(&scenario, |speeds, instant| {
            for (i, wheel) in scenario.wheels.iter().enumerate() {
                let error = f64::from(speeds[i]) - instant.wheel_speed_rad_s[i];
                let error = error * wheel.wheel.spin_inertia_kg_m2;
                largest = largest.max(error.abs());
                squares += error * error;
                count += 1;
            }
        });
        assert!(missed <= 6, "{missed} samples without speeds");
        ((squares / f64::from(count)).sqrt(), largest)
    }

    /// A log of the flight computer is not corrected a second time.
    #[test]
    fn readings_of_the_driver_show_no_tachometer() {
        for name in ["microsat-slew", "cubesat-pyramid"] {
            let scenario = Scenario::load(name).unwrap();
            let mut rows = Vec::new();
            each_speed(&scenario, |speeds, instant| {
                rows.push(LogRow {
                    line: rows.len() as u64 + 2,
                    time_us: instant.time_us,
                    rate_rad_s: Vector3::zeros(),
                    wheel_speed_rad_s: speeds.iter().copied().map(f64::from).collect(),
                    torque_n_m: Vector3::zeros(),
                    attitude: None,
                });
            });
            let hardware = StatedHardware::ideal(scenario.wheels.len());
            assert_eq!(correct_wheels(&mut rows, &hardware), None, "{name}");
        }
    }

    #[test]
    fn momentum_error_of_the_driver_is_below_the_gyro_noise() {
        // The gyro noise times the mean moment is 2e-4 and 9e-6 N m s per sample. Errors that correlate
        // with the motion do not average out, and must be far below.
        let (rms, largest) = momentum_errors("microsat-slew");
        assert!(rms < 4e-6 && largest < 2e-4, "{rms} {largest}");
        let (rms, largest) = momentum_errors("cubesat-pyramid");
        assert!(rms < 6e-7 && largest < 9e-6, "{rms} {largest}");
    }
}
