//! Wheel speed at an instant, from the positions and times of edges.
//!
//! Input: [`Captured`], once per gyro sample. Output: speed, rad/s, at `now_ticks`.
//!
//! Between two readings the wheel moves by `N` whole edges in the time `T` between the last edge of
//! each. `N / T` is the period method at few edges and the count method at many, exact to a tick. It
//! is the speed in the middle of `T`, hence late by at least `T / 2`. The estimator needs the
//! momentum at the gyro's instant: a motor torque of 1 N m changes it by 0.05 N m s within 0.05 s, an
//! error of every sample. The speed is therefore the slope, at the requested instant, of the cubic
//! through the last edges of four readings (at first the parabola through three).
//!
//! * Truncation: constant and linearly changing acceleration have no error. An oscillation at `ω`
//!   has an error of `(ω T)³ / 4` of its amplitude, in quadrature: 0.08 % at 10 Hz and 0.23 Hz. The
//!   parabola would leave `(ω T)² / 3`, 0.7 %, in phase, equivalent to a spin inertia 0.7 % too small;
//!   it shifted the inertia of a CubeSat by six sigma.
//! * Noise: the errors of the four edges have weights 11/6, 3, 3/2 and 1/3 instead of 1 and 1. The
//!   speed's noise is 2.7 times that of the mean speed.
//! * No edge since the last reading: the cubic holds until it passes the position of the next edge.
//!   From then on, the angle between edges over the time since the last edge bounds the speed.
//! * No edge although the wheel must have passed two, however hard it was braked: the signal is lost, and
//!   there is no speed until edges return. A dead line of a wheel faster than `√(4 a δ)` is found so, with
//!   the largest acceleration `a` and the angle `δ` between edges: 18 rad/s at 300 rad/s² and 24 edges.
//! * No edge for `zero_after_s` otherwise: the wheel stands. The next motion is assumed to start at the last
//!   reading, half an edge before its first edge.

use super::Captured;

/// Largest angle to the next edge, in angles between edges: edges may be misplaced by a quarter.
const UNEVEN: f32 = 1.25;

/// Angle without an edge after which the signal is lost, in angles between edges.
const LOST: f32 = 2.0;

/// Speed of one wheel, reading by reading.
#[derive(Debug, Clone, Copy)]
pub struct SpeedTracker {
    /// Angle between edges, rad; negative if they count backward.
    step_rad: f32,
    tick_s: f32,
    zero_after_s: f32,
    /// Largest acceleration of the wheel, rad/s².
    largest_rad_s2: f32,
    last: Option<Captured>,
    motion: Motion,
}

/// Knowledge of the motion at the last edge.
#[derive(Debug, Clone, Copy)]
enum Motion {
    /// No edge since the first reading.
    Nothing {
        /// Time of the first reading, ticks.
        since_ticks: u32,
    },
    /// One edge, no mean speed.
    OneEdge,
    /// One mean speed, no acceleration.
    Mean(Mean),
    /// Standing: no edge for `zero_after_s`.
    Standing,
    /// No edge where the wheel must have passed some.
    Lost,
    /// Motion along a curve.
    Turning(Curve),
}

/// Angle since the last edge by divided differences (Newton form), `x` the time since then:
/// `x (mean + bend (x + T) + twist (x + T) (x + S))`. `T` and `S` are the times from the edges of one
/// and two readings before to the last edge, s.
#[derive(Debug, Clone, Copy)]
struct Curve {
    mean: Mean,
    bend_rad_s2: f32,
    twist_rad_s3: f32,
    /// `S`; `None` if the edges of two readings before belong to another motion.
    span_s: Option<f32>,
}

/// Mean speed between two edges.
#[derive(Debug, Clone, Copy)]
struct Mean {
    rad_s: f32,
    /// Time between the edges, s.
    duration_s: f32,
}

impl SpeedTracker {
    /// A tracker before its first reading. `step_rad` is the angle between edges, signed.
    /// `largest_rad_s2` is the largest acceleration of the wheel, above zero; infinity for no check of
    /// the signal.
    pub fn new(step_rad: f32, ticks_per_s: u32, zero_after_s: f32, largest_rad_s2: f32) -> Self {
        Self {
            step_rad,
            tick_s: 1.0 / ticks_per_s as f32,
            zero_after_s,
            largest_rad_s2,
            last: None,
            motion: Motion::OneEdge,
        }
    }

    /// Discards the motion: the next reading is the first.
    pub fn reset(&mut self) {
        self.last = None;
        self.motion = Motion::OneEdge;
    }

    /// True if edges are missing that the wheel must have passed.
    pub fn is_lost(&self) -> bool {
        matches!(self.motion, Motion::Lost)
    }

    /// Speed at `captured.now_ticks`, rad/s; `None` until enough edges have arrived or the wheel
    /// counts as standing.
    pub fn speed_rad_s(&mut self, captured: &Captured) -> Option<f32> {
        let now_ticks = captured.now_ticks;
        let since_edge_s = self.seconds(now_ticks, captured.last_edge_ticks);
        self.motion = match self.last.replace(*captured) {
            None => Motion::Nothing { since_ticks: now_ticks },
            Some(last) if last.is_at_same_edge(captured) => self.without_an_edge(captured),
            Some(last) => self.after_edges(&last, captured),
        };
        match self.motion {
            Motion::Nothing { .. } | Motion::OneEdge | Motion::Mean(_) | Motion::Lost => None,
            Motion::Standing => Some(0.0),
            Motion::Turning(curve) => Some(self.bounded(&curve, since_edge_s)),
        }
    }

    /// Motion after a reading without an edge.
    fn without_an_edge(&self, captured: &Captured) -> Motion {
        let since_ticks = match self.motion {
            // The time is not updated any more: it would wrap.
            Motion::Standing | Motion::Lost => return self.motion,
            Motion::Nothing { since_ticks } => since_ticks,
            Motion::OneEdge | Motion::Mean(_) | Motion::Turning(_) => captured.last_edge_ticks,
        };
        if let Motion::Turning(curve) = &self.motion
            && self.misses_edges(curve, self.seconds(captured.now_ticks, since_ticks))
        {
            return Motion::Lost;
        }
        let is_over = self.seconds(captured.now_ticks, since_ticks) >= self.zero_after_s;
        if is_over { Motion::Standing } else { self.motion }
    }

    /// True if the wheel has turned by more than [`LOST`] angles between edges, braked as hard as it can be
    /// since its last edge: `v t − a t² / 2`, until it stands at `t = v / a`.
    fn misses_edges(&self, curve: &Curve, since_edge_s: f32) -> bool {
        let edge_rad_s = curve.speed_rad_s(0.0).abs();
        let moving_s = since_edge_s.min(edge_rad_s / self.largest_rad_s2);
        let least_rad = moving_s * (edge_rad_s - 0.5 * self.largest_rad_s2 * moving_s);
        least_rad > LOST * self.step_rad.abs()
    }

    /// Motion after a reading with edges.
    fn after_edges(&self, last: &Captured, captured: &Captured) -> Motion {
        let moved = captured.edges.wrapping_sub(last.edges) as f32;
        let mean = match self.motion {
            Motion::Nothing { .. } | Motion::Lost => return Motion::OneEdge,
            Motion::Standing => {
                let within = 0.5f32.min(moved.abs()) * sign(moved);
                self.mean(moved - within, last.now_ticks, captured.last_edge_ticks)
            }
            Motion::OneEdge | Motion::Mean(_) | Motion::Turning(_) => {
                self.mean(moved, last.last_edge_ticks, captured.last_edge_ticks)
            }
        };
        if mean.duration_s <= 0.0 {
            return Motion::OneEdge; // a removed glitch, or a timer that wrapped between readings
        }
        let bend =
            |before: &Mean| (mean.rad_s - before.rad_s) / (mean.duration_s + before.duration_s);
        let curve = match self.motion {
            Motion::Nothing { .. } | Motion::Lost | Motion::OneEdge => return Motion::Mean(mean),
            // From rest at constant acceleration the final speed is twice the mean.
            Motion::Standing => {
                let bend_rad_s2 = mean.rad_s / mean.duration_s;
                Curve { mean, bend_rad_s2, twist_rad_s3: 0.0, span_s: None }
            }
            Motion::Mean(before) => Curve {
                mean,
                bend_rad_s2: bend(&before),
                twist_rad_s3: 0.0,
                span_s: Some(mean.duration_s + before.duration_s),
            },
            Motion::Turning(before) => {
                let bend_rad_s2 = bend(&before.mean);
                let change_rad_s2 = bend_rad_s2 - before.bend_rad_s2;
                let twist = |span_s: f32| change_rad_s2 / (mean.duration_s + span_s);
                Curve {
                    mean,
                    bend_rad_s2,
                    twist_rad_s3: before.span_s.map_or(0.0, twist),
                    span_s: Some(mean.duration_s + before.mean.duration_s),
                }
            }
        };
        Motion::Turning(curve)
    }

    /// Mean speed over a number of edges.
    fn mean(&self, edges: f32, from_ticks: u32, to_ticks: u32) -> Mean {
        let duration_s = self.seconds(to_ticks, from_ticks);
        Mean { rad_s: edges * self.step_rad / duration_s, duration_s }
    }

    /// Speed at `since_edge_s` after the last edge, rad/s, bounded by the absence of an edge since.
    fn bounded(&self, curve: &Curve, since_edge_s: f32) -> f32 {
        let angle_rad = curve.angle_rad(since_edge_s);
        let farthest_rad = UNEVEN * self.step_rad.abs();
        if since_edge_s > 0.0 && angle_rad.abs() > farthest_rad {
            return sign(angle_rad) * farthest_rad / since_edge_s;
        }
        curve.speed_rad_s(since_edge_s)
    }

    /// Time difference, s, within ± half the timer's range; negative for a later second argument.
    fn seconds(&self, later_ticks: u32, earlier_ticks: u32) -> f32 {
        later_ticks.wrapping_sub(earlier_ticks).cast_signed() as f32 * self.tick_s
    }
}

impl Curve {
    /// Angle since the last edge, rad.
    fn angle_rad(&self, x: f32) -> f32 {
        let (from_one, from_two) = self.since_edges_s(x);
        let bend = self.bend_rad_s2 + self.twist_rad_s3 * from_two;
        x * (self.mean.rad_s + from_one * bend)
    }

    /// Derivative of the angle, rad/s.
    fn speed_rad_s(&self, x: f32) -> f32 {
        let (from_one, from_two) = self.since_edges_s(x);
        let twist = from_one * from_two + x * (from_one + from_two);
        self.mean.rad_s + self.bend_rad_s2 * (x + from_one) + self.twist_rad_s3 * twist
    }

    /// Times since the edges of one and two readings before, s.
    fn since_edges_s(&self, x: f32) -> (f32, f32) {
        (x + self.mean.duration_s, x + self.span_s.unwrap_or(0.0))
    }
}

impl Captured {
    fn is_at_same_edge(&self, later: &Self) -> bool {
        self.edges == later.edges && self.last_edge_ticks == later.last_edge_ticks
    }
}

fn sign(value: f32) -> f32 {
    if value < 0.0 { -1.0 } else { 1.0 }
}
