//! From positions and times of edges to a speed at an instant.
//!
//! From one reading to the next the wheel has moved by whole edges, `N`, in the time `T` between the
//! last edge of each. That is the period method while edges are few and the count method while they are
//! many, and either way exact to a tick. `N / T` is the speed in the middle of that time, so it is late
//! by `T / 2` and more. The estimator needs momentum at the gyro's instant: 1 N m on a wheel is 0.05
//! N m s in 0.05 s, and an error like that in each of its samples. So the way that the mean speeds change
//! goes on: the cubic through the last edges of four readings (of three, a parabola, at first), and its
//! slope at that instant.
//!
//! * Constant acceleration has no error, nor has one that changes evenly. A wheel that swings with `ω`
//!   has one of `(ω T)³ / 4` of its swing, a quarter of a period late or early: at 10 Hz and 0.23 Hz that
//!   is 0.08 %. A parabola would leave `(ω T)² / 3`, 0.7 %, in phase, which is as if the wheel's inertia
//!   were that much less; it made inertias of a CubeSat wrong by six of their sigmas.
//! * Noise grows: each edge's own error counts 11/6, 3, 3/2 and 1/3 rather than 1 and 1, so that the
//!   speed's is 2.7 times that of the mean.
//! * Without an edge the cubic holds as long as it hasn't passed where the next one is. Once it has,
//!   the wheel has moved by less than that since the last edge, and this bounds the speed.
//! * No edge for `zero_after_s`: the wheel stands still. Coming out of that it is taken as having begun
//!   at the last reading, half an edge before the first edge.

use super::Captured;

/// So many times the angle between edges the next one may be away: they may be uneven by a quarter.
const UNEVEN: f32 = 1.25;

/// The speed of one wheel, reading by reading.
#[derive(Debug, Clone, Copy)]
pub struct SpeedTracker {
    /// Angle of an edge, rad; negative if they count backward.
    step_rad: f32,
    tick_s: f32,
    zero_after_s: f32,
    last: Option<Captured>,
    motion: Motion,
}

/// What is known of the motion at the last edge.
#[derive(Debug, Clone, Copy)]
enum Motion {
    /// No edge since the first reading.
    Nothing {
        /// When that was, ticks.
        since_ticks: u32,
    },
    /// An edge, and no mean speed yet.
    OneEdge,
    /// A mean speed, and not yet how it changes.
    Mean(Mean),
    /// No edge for so long that the wheel stands still.
    Standing,
    /// The wheel moves along this curve.
    Turning(Curve),
}

/// Position around the last edge by divided differences: with `x` the time since then, and `T`, `S` the
/// times from the edges of one and two readings before to it,
/// `x (mean + bend (x + T) + twist (x + T) (x + S))`.
#[derive(Debug, Clone, Copy)]
struct Curve {
    mean: Mean,
    bend_rad_s2: f32,
    twist_rad_s3: f32,
    /// S; none where the edges of two readings before aren't of the same motion.
    span_s: Option<f32>,
}

/// Mean speed from one edge to another.
#[derive(Debug, Clone, Copy)]
struct Mean {
    rad_s: f32,
    /// From the one to the other.
    duration_s: f32,
}

impl SpeedTracker {
    /// A wheel that turns by `step_rad` from edge to edge. No edge for `zero_after_s`: it stands still.
    pub fn new(step_rad: f32, ticks_per_s: u32, zero_after_s: f32) -> Self {
        Self {
            step_rad,
            tick_s: 1.0 / ticks_per_s as f32,
            zero_after_s,
            last: None,
            motion: Motion::OneEdge,
        }
    }

    /// Begins anew: what comes next has nothing to do with what was.
    pub fn forget(&mut self) {
        self.last = None;
        self.motion = Motion::OneEdge;
    }

    /// Speed at `captured.now_ticks`, rad/s; `None` if since start-up too few edges have come, and yet
    /// it isn't known to stand still.
    pub fn speed_rad_s(&mut self, captured: &Captured) -> Option<f32> {
        let now_ticks = captured.now_ticks;
        let since_edge_s = self.seconds(now_ticks, captured.last_edge_ticks);
        self.motion = match self.last.replace(*captured) {
            None => Motion::Nothing { since_ticks: now_ticks },
            Some(last) if last.is_at_same_edge(captured) => self.without_an_edge(captured),
            Some(last) => self.after_edges(&last, captured),
        };
        match self.motion {
            Motion::Nothing { .. } | Motion::OneEdge | Motion::Mean(_) => None,
            Motion::Standing => Some(0.0),
            Motion::Turning(curve) => Some(self.bounded(&curve, since_edge_s)),
        }
    }

    /// What it means that no edge has come since the last reading.
    fn without_an_edge(&self, captured: &Captured) -> Motion {
        let since_ticks = match self.motion {
            // Time doesn't count any more: it would wrap.
            Motion::Standing => return Motion::Standing,
            Motion::Nothing { since_ticks } => since_ticks,
            Motion::OneEdge | Motion::Mean(_) | Motion::Turning(_) => captured.last_edge_ticks,
        };
        let is_over = self.seconds(captured.now_ticks, since_ticks) >= self.zero_after_s;
        if is_over { Motion::Standing } else { self.motion }
    }

    /// What edges since the last reading tell.
    fn after_edges(&self, last: &Captured, captured: &Captured) -> Motion {
        let moved = captured.edges.wrapping_sub(last.edges) as f32;
        let mean = match self.motion {
            Motion::Nothing { .. } => return Motion::OneEdge,
            Motion::Standing => {
                let within = 0.5f32.min(moved.abs()) * sign(moved);
                self.mean(moved - within, last.now_ticks, captured.last_edge_ticks)
            }
            Motion::OneEdge | Motion::Mean(_) | Motion::Turning(_) => {
                self.mean(moved, last.last_edge_ticks, captured.last_edge_ticks)
            }
        };
        if mean.duration_s <= 0.0 {
            return Motion::OneEdge; // A glitch was taken back, or the timer wrapped unread.
        }
        let bend =
            |before: &Mean| (mean.rad_s - before.rad_s) / (mean.duration_s + before.duration_s);
        let curve = match self.motion {
            Motion::Nothing { .. } | Motion::OneEdge => return Motion::Mean(mean),
            // From rest at constant acceleration: at the end, twice the mean.
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

    /// Mean speed over so many edges.
    fn mean(&self, edges: f32, from_ticks: u32, to_ticks: u32) -> Mean {
        let duration_s = self.seconds(to_ticks, from_ticks);
        Mean { rad_s: edges * self.step_rad / duration_s, duration_s }
    }

    /// Speed so long after the last edge, rad/s, as far as it agrees with there being no edge since.
    fn bounded(&self, curve: &Curve, since_edge_s: f32) -> f32 {
        let angle_rad = curve.angle_rad(since_edge_s);
        let farthest_rad = UNEVEN * self.step_rad.abs();
        if since_edge_s > 0.0 && angle_rad.abs() > farthest_rad {
            return sign(angle_rad) * farthest_rad / since_edge_s;
        }
        curve.speed_rad_s(since_edge_s)
    }

    /// From one time to a later one, at most half the timer's range; negative if it is earlier.
    fn seconds(&self, later_ticks: u32, earlier_ticks: u32) -> f32 {
        later_ticks.wrapping_sub(earlier_ticks).cast_signed() as f32 * self.tick_s
    }
}

impl Curve {
    /// Angle turned since the last edge, rad.
    fn angle_rad(&self, x: f32) -> f32 {
        let (from_one, from_two) = self.since_edges_s(x);
        let bend = self.bend_rad_s2 + self.twist_rad_s3 * from_two;
        x * (self.mean.rad_s + from_one * bend)
    }

    /// Its derivative, rad/s.
    fn speed_rad_s(&self, x: f32) -> f32 {
        let (from_one, from_two) = self.since_edges_s(x);
        let twist = from_one * from_two + x * (from_one + from_two);
        self.mean.rad_s + self.bend_rad_s2 * (x + from_one) + self.twist_rad_s3 * twist
    }

    /// Times since the edges of one and two readings before.
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
