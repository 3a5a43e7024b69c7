//! The edges of a wheel's encoder, from its speed over time.
//!
//! In: wheel speeds at the gyro's samples. Out: the flanks in between, each with the timer's tick and
//! the levels of both channels, for the [`EdgeFilter`] that a board's interrupt calls; and what a
//! capture timer would say at each sample.
//!
//! Between two samples the speed is a cubic with the slopes that the samples around have, and the angle
//! its integral.

use fsw_target::drivers::wheel_tach::{CaptureTimer, Captured, EdgeFilter};

use crate::truth::Instant;

/// Parts of the time between two samples in which the angle is looked at for edges: a wheel that turns
/// back within one of them may do so unseen.
const SLICES_PER_EDGE: f64 = 4.0;
const LEAST_SLICES: f64 = 16.0;

/// The sensor and the timer that watches it: the same for each wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncoderData {
    /// Edges in a turn, both flanks of the first channel counted.
    pub edges_per_turn: u16,
    /// The timer's ticks in a second.
    pub ticks_per_s: u32,
    /// A pulse shorter than this is none, ticks.
    pub shortest_ticks: u32,
}

impl Default for EncoderData {
    /// Twelve pulses a turn, as three Hall sensors of a motor with four pairs of poles give; a timer of
    /// 1 MHz; nothing faster than 0.1 ms between edges (2600 rad/s).
    fn default() -> Self {
        Self { edges_per_turn: 24, ticks_per_s: 1_000_000, shortest_ticks: 100 }
    }
}

/// Speed of a wheel from one sample to the next, rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// When it begins, s.
    pub from_s: f64,
    /// How long it is, s.
    pub duration_s: f64,
    /// Speed at either end, rad/s.
    pub speed_rad_s: [f64; 2],
    /// Its slope at either end, rad/s².
    pub slope_rad_s2: [f64; 2],
}

impl Stretch {
    /// Angle turned after a share of the stretch, rad: the integral of a cubic Hermite polynomial.
    fn angle_rad(&self, share: f64) -> f64 {
        let [v0, v1] = self.speed_rad_s;
        let [a0, a1] = self.slope_rad_s2.map(|slope| slope * self.duration_s);
        let x = share;
        let cubic = x * x * x * (v1 - v0 - (2.0 * a0 + a1) / 3.0);
        let quartic = x * x * x * x * (2.0 * (v0 - v1) + a0 + a1) / 4.0;
        self.duration_s * (v0 * x + a0 * x * x / 2.0 + cubic + quartic)
    }
}

/// A flank of the first channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flank {
    /// When, s.
    pub time_s: f64,
    /// Level of the first channel just after.
    pub a: bool,
    /// Level of the second.
    pub b: bool,
}

/// One wheel's encoder.
#[derive(Clone, Debug)]
pub struct Encoder {
    edges_per_rad: f64,
    /// Where the wheel is, in edges.
    position: f64,
}

impl Encoder {
    /// An encoder whose wheel stands in the middle between two edges.
    pub fn new(edges_per_turn: u16) -> Self {
        Self { edges_per_rad: f64::from(edges_per_turn) / std::f64::consts::TAU, position: 0.5 }
    }

    /// The wheel turns; each flank is shown in order.
    pub fn turn(&mut self, stretch: &Stretch, mut on_flank: impl FnMut(Flank)) {
        let start = self.position;
        let position = |share: f64| start + self.edges_per_rad * stretch.angle_rad(share);
        let [v0, v1] = stretch.speed_rad_s.map(f64::abs);
        let edges = v0.max(v1) * stretch.duration_s * self.edges_per_rad;
        let slices = (edges * SLICES_PER_EDGE).max(LEAST_SLICES).ceil();
        let mut before = 0.0;
        for slice in 1..=slices as u64 {
            let after = slice as f64 / slices;
            let (from, to) = (position(before).floor(), position(after).floor());
            if from != to {
                let share = crossing(&position, before, after, from);
                let time_s = stretch.from_s + share * stretch.duration_s;
                let a = to.rem_euclid(2.0) == 1.0;
                on_flank(Flank { time_s, a, b: a != (to > from) });
            }
            before = after;
        }
        self.position = position(1.0);
    }
}

/// Where `position` leaves the step `from` between two shares of a stretch, by bisection to the last bit
/// that matters: 2⁻⁴⁰ of a tenth of a second is far below a tick.
fn crossing(position: &impl Fn(f64) -> f64, mut before: f64, mut after: f64, from: f64) -> f64 {
    for _ in 0..40 {
        let middle = 0.5 * (before + after);
        if position(middle).floor() == from {
            before = middle;
        } else {
            after = middle;
        }
    }
    after
}

/// The encoders of a flight, W places for wheels, and the timer that captures their edges.
#[derive(Clone, Debug)]
pub struct Captures<'a, const W: usize> {
    data: EncoderData,
    instants: &'a [Instant],
    encoders: [Encoder; W],
    filters: [EdgeFilter; W],
    /// The sample that time stands at.
    index: usize,
}

impl<'a, const W: usize> Captures<'a, W> {
    /// Stands at the first sample, with no edge seen.
    pub fn new(data: EncoderData, instants: &'a [Instant]) -> Self {
        Self {
            data,
            instants,
            encoders: std::array::from_fn(|_| Encoder::new(data.edges_per_turn)),
            filters: [EdgeFilter::new(data.shortest_ticks); W],
            index: 0,
        }
    }

    /// Time goes on to the next sample.
    pub fn advance(&mut self) {
        for wheel in 0..W {
            if let Some(stretch) = stretch(self.instants, self.index, wheel) {
                let filter = &mut self.filters[wheel];
                let ticks_per_s = f64::from(self.data.ticks_per_s);
                self.encoders[wheel].turn(&stretch, |flank| {
                    filter.edge(ticks(flank.time_s, ticks_per_s), flank.a, flank.b);
                });
            }
        }
        self.index += 1;
    }

    /// What the timer holds at this sample.
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

/// The timer counts whole ticks and wraps.
fn ticks(time_s: f64, ticks_per_s: f64) -> u32 {
    (time_s * ticks_per_s) as u64 as u32
}

fn seconds(time_us: u64) -> f64 {
    time_us as f64 * 1e-6
}

/// A wheel's speed from a sample to the next; none where there is no wheel, or no next sample.
fn stretch(instants: &[Instant], index: usize, wheel: usize) -> Option<Stretch> {
    let at = |index: usize| {
        let instant = instants.get(index)?;
        Some((seconds(instant.time_us), *instant.wheel_speed_rad_s.get(wheel)?))
    };
    let ((from_s, v0), (to_s, v1)) = (at(index)?, at(index + 1)?);
    let slope = |(t0, v0): (f64, f64), (t1, v1): (f64, f64)| (v1 - v0) / (t1 - t0);
    let before = index.checked_sub(1).and_then(at).unwrap_or((from_s, v0));
    let after = at(index + 2).unwrap_or((to_s, v1));
    Some(Stretch {
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
    use crate::truth::Flight;
    use fsw_target::drivers::wheel_tach::{Config, WheelTach};
    use fsw_target::flight::sensors::WheelTachometers;

    const CUBIC: Stretch = Stretch {
        from_s: 3.0,
        duration_s: 0.5,
        speed_rad_s: [100.0, 80.0],
        slope_rad_s2: [30.0, -60.0],
    };

    #[test]
    fn the_angle_is_the_integral_of_a_speed_with_these_ends() {
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
    fn each_edge_is_shown_once_in_order_and_where_it_is() {
        let mut encoder = Encoder::new(24);
        let start = encoder.position;
        let mut flanks = Vec::new();
        encoder.turn(&CUBIC, |flank| flanks.push(flank));
        assert_eq!(flanks.len(), encoder.position.floor() as usize);
        for (k, flank) in flanks.iter().enumerate() {
            let share = (flank.time_s - CUBIC.from_s) / CUBIC.duration_s;
            let position = start + encoder.edges_per_rad * CUBIC.angle_rad(share);
            assert!((position - (k + 1) as f64).abs() < 1e-9, "edge {k} at {position}");
            assert_eq!((flank.a, flank.b), (k % 2 == 0, k % 2 == 1));
        }
    }

    #[test]
    fn a_wheel_that_turns_back_shows_the_same_edges_again() {
        let back = Stretch {
            from_s: 0.0,
            duration_s: 1.0,
            speed_rad_s: [5.0, -5.0],
            slope_rad_s2: [-10.0, -10.0],
        };
        let mut filter = EdgeFilter::new(100);
        let mut encoder = Encoder::new(24);
        let mut edges = Vec::new();
        encoder.turn(&back, |flank| {
            filter.edge((flank.time_s * 1e6) as u32, flank.a, flank.b);
            edges.push(filter.captured(0).edges);
        });
        // 1.25 rad forward are 4.77 edges from the middle of a step: five passed, and passed again.
        assert_eq!(edges, [1, 2, 3, 4, 5, 5, 4, 3, 2, 1]);
        assert!((encoder.position - 0.5).abs() < 1e-9);
    }

    /// Where the driver errs on a flight, in momentum, N m s RMS and at most.
    fn momentum_errors(scenario: &str) -> (f64, f64) {
        let scenario = Scenario::load(scenario).unwrap();
        let flight = Flight::simulate(&scenario).unwrap();
        let data = EncoderData::default();
        let config = Config {
            edges_per_turn: [data.edges_per_turn; 4],
            reversed: [false; 4],
            zero_after_s: 0.5,
        };
        let captures = Captures::<4>::new(data, &flight.instants);
        let mut tach = WheelTach::new(captures, &config).unwrap();
        let (mut squares, mut largest, mut count) = (0.0, 0.0f64, 0);
        for instant in &flight.instants {
            let speeds = tach.speed_rad_s();
            tach.timer().advance();
            let Ok(speeds) = speeds else { continue };
            for (i, wheel) in scenario.wheels.iter().enumerate() {
                let error = f64::from(speeds[i]) - instant.wheel_speed_rad_s[i];
                let error = error * wheel.wheel.spin_inertia_kg_m2;
                largest = largest.max(error.abs());
                squares += error * error;
                count += 1;
            }
        }
        let missed = flight.instants.len() - count / scenario.wheels.len();
        assert!(missed <= 6, "{missed} samples without speeds");
        ((squares / count as f64).sqrt(), largest)
    }

    #[test]
    fn the_driver_finds_the_momentum_better_than_the_gyro_does() {
        // The gyro's noise times the mean moment is 2e-4 and 9e-6 N m s a sample. What swings with the
        // motion must be far below that: it doesn't average out.
        let (rms, largest) = momentum_errors("microsat-slew");
        assert!(rms < 4e-6 && largest < 2e-4, "{rms} {largest}");
        let (rms, largest) = momentum_errors("cubesat-pyramid");
        assert!(rms < 6e-7 && largest < 9e-6, "{rms} {largest}");
    }
}
