//! Covariance propagation alone, nine states and three measurements: `P ← Φ P Φᵀ + Q`, then the Kalman
//! update with a measured rate. The form of `joint-ekf` and the peers on the same numbers.
//!
//! Gate, dynamics, Jacobians and monitor of a step are left out, since the peers have none. All filters
//! must end at the same variances, which shows that they do the same work.

mod ours;

use crate::counter::Counter;
use crate::noise::Noise;
use crate::tally::Tally;
use fsw_core::Mat;
use fsw_core::dynamics::interval::{Drive, Interval};
use fsw_core::dynamics::step::{Transition, runge_kutta_4};
use fsw_core::{Inertia, Vec3, dynamics::gyrostat::Gyrostat};

/// Steps per filter; all have about the same cost.
const STEPS: usize = 100;

/// Tolerance of the standard deviations after all steps, relative: `f32` rounding of a plain
/// covariance against the UD form.
const AGREE: f32 = 0.01;

/// Problem: the CubeSat at a few degrees per second, sampled at 10 Hz.
const INERTIA_KG_M2: [f32; 6] = [0.058, 0.104, 0.118, -0.0021, 0.0016, 0.0028];
const RATE_RAD_S: [f32; 3] = [0.05, -0.08, 0.1];
const TORQUE_N_M: [f32; 3] = [2e-4, -1e-4, 3e-4];
const WHEELS_N_M_S: [f32; 3] = [2e-3, 1e-3, -3e-3];
const DURATION_S: f32 = 0.1;
const GYRO_NOISE_RAD_S: f32 = 1e-4;
const RATE_WALK_RAD_S_SQRT_S: f32 = 1e-5;
const INERTIA_WALK_KG_M2_SQRT_S: f32 = 1e-5;
const SIGMA: [f32; 9] = [1e-4, 1e-4, 1e-4, 0.01, 0.01, 0.01, 0.004, 0.004, 0.004];

/// Problem of all filters.
struct Problem {
    transition: Transition<f32>,
    /// Random walk of each inertia element, kg m²/√s.
    inertia_walk_kg_m2_sqrt_s: f32,
}

/// A filter about zero: its state is the deviation from the prediction.
trait Filter {
    /// Predicts, then updates with the measured deviation of the rate, rad/s.
    fn step(&mut self, measured_rad_s: &Vec3<f32>);
    /// Variances of the nine states.
    fn variances(&self) -> [f32; 9];
}

impl Problem {
    /// A problem with this random walk of the inertia; `None` if the inertia has no inverse.
    fn new(inertia_walk_kg_m2_sqrt_s: f32) -> Option<Self> {
        let body = Gyrostat::new(&Inertia::new(INERTIA_KG_M2))?;
        let drive = Drive {
            torque_n_m: Vec3::from(TORQUE_N_M),
            wheel_momentum_n_m_s: Vec3::from(WHEELS_N_M_S),
        };
        let interval = Interval { duration_s: DURATION_S, start: drive, middle: drive, end: drive };
        let start = Vec3::from(RATE_RAD_S);
        let end = runge_kutta_4(&body, &start, &interval);
        let transition = Transition::between(&body, &start, &end, &interval);
        Some(Self { transition, inertia_walk_kg_m2_sqrt_s })
    }

    /// The problem as full matrices.
    fn of_peers(&self) -> fsw_peers::Problem {
        let mut transition = Mat::<f32, 9, 9>::identity();
        transition.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.transition.rate);
        transition.fixed_view_mut::<3, 6>(0, 3).copy_from(&self.transition.inertia);
        let walk =
            |i: usize| if i < 3 { RATE_WALK_RAD_S_SQRT_S } else { self.inertia_walk_kg_m2_sqrt_s };
        let q = |i: usize, k: usize| if i == k { walk(i) * walk(i) * DURATION_S } else { 0.0 };
        fsw_peers::Problem {
            transition,
            process_noise: Mat::from_fn(q),
            sigma: SIGMA,
            measurement_noise: GYRO_NOISE_RAD_S,
        }
    }
}

/// Counts every filter.
///
/// # Errors
/// The reason, for the log.
// Not inlined: the peers need more stack than the estimators, in this function only.
#[inline(never)]
pub fn count_all(counter: &mut Counter, tally: &mut Tally) -> Result<(), &'static str> {
    let still = Problem::new(0.0).ok_or("the inertia has no inverse")?;
    let walking = Problem::new(INERTIA_WALK_KG_M2_SQRT_S).ok_or("the inertia has no inverse")?;
    let mut bench = Bench { counter, tally, expected: None };
    bench.count("covariance-ud", &mut ours::StructuredUd::new(&still))?;
    bench.expected = None;
    bench.count("covariance-ud-walk", &mut ours::StructuredUd::new(&walking))?;
    let mut counted = Ok(());
    if !cfg!(feature = "one-flight") {
        fsw_peers::each(&walking.of_peers(), &mut |name, filter| {
            counted = counted.and_then(|()| bench.count(name, &mut Peer(filter)));
        });
    }
    counted
}

/// A peer as [`Filter`].
struct Peer<'a>(&'a mut dyn fsw_peers::Filter);

impl Filter for Peer<'_> {
    fn step(&mut self, measured_rad_s: &Vec3<f32>) {
        self.0.step(measured_rad_s);
    }

    fn variances(&self) -> [f32; 9] {
        self.0.variances()
    }
}

struct Bench<'a> {
    counter: &'a mut Counter,
    tally: &'a mut Tally,
    /// Variances at the end of the first filter of a problem.
    expected: Option<[f32; 9]>,
}

impl Bench<'_> {
    /// Counts a filter, logs it, and compares its variances with the first one's.
    fn count(&mut self, name: &'static str, filter: &mut impl Filter) -> Result<(), &'static str> {
        self.tally.clear();
        let mut noise = Noise::new();
        for _ in 0..STEPS {
            let measured = Vec3::from_fn(|_, _| noise.standard() * GYRO_NOISE_RAD_S);
            let instructions = self.counter.count(|| {
                core::hint::black_box(&mut *filter).step(core::hint::black_box(&measured));
            });
            self.tally.add(instructions);
        }
        self.tally.report(name, "covariance", "-");
        let found = filter.variances();
        let expected = *self.expected.get_or_insert(found);
        let agrees = |(a, b): (&f32, &f32)| (a - b).abs() <= 2.0 * AGREE * b.abs();
        if found.iter().zip(&expected).all(agrees) {
            Ok(())
        } else {
            fsw_target::log_line!(
                "{} has the variances {:?}, expected {:?}",
                name,
                found,
                expected
            );
            Err("a filter ends at other variances than the first one")
        }
    }
}
