//! `joint-ekf`: rate and inertia in one nine-state filter, \[Bellar2019\].
//!
//! State `(ωx ωy ωz Jxx Jyy Jzz Jxy Jxz Jyz)`, measurement the body rate; extended here by
//! wheels, through the gyrostat equation. Two forms of the same filter, chosen by type:
//!
//! * [`JointEkfPublished`], as printed ([`as_published`]);
//! * [`JointEkfUd`], the one that flies ([`structured_ud`]).
//!
//! Around both: the sample gate, a first estimate from the motion itself where no prior is given,
//! spike and lockout handling, and the monitor.

pub mod as_published;
pub mod config;
pub mod momentum_integral;
mod start;
pub mod structured_ud;

pub use as_published::AsPublished;
pub use config::{Config, InitialRate};
pub use structured_ud::StructuredUd;

use start::{NoStart, Start};

use crate::dynamics::interval::{DriveHistory, Interval};
use crate::dynamics::wheels::WheelArray;
use crate::error::ConfigError;
use crate::estimate::{Estimate, Status};
use crate::estimator::Estimator;
use crate::gate::{Gate, Verdict};
use crate::math::{Mat, Vec3, scalar::Real, ud::Ud};
use crate::monitor::innovation::Innovation;
use crate::monitor::innovation::InnovationMonitor;
use crate::outcome::{Coasting, Outcome, Reset};
use crate::persist::Persist;
use crate::prior::Prior;
use crate::sample::Sample;
use crate::tensor::Inertia;
use momentum_integral::MomentumIntegral;

/// The filter as printed: AB2 propagation, first-order transition, `(1 − K H) P`.
pub type JointEkfPublished<T, const W: usize> = JointEkf<T, AsPublished<T>, W>;
/// The filter that flies: Runge-Kutta propagation, UD factors.
pub type JointEkfUd<T, const W: usize> = JointEkf<T, StructuredUd<T>, W>;

/// While aligning, a first estimate is tried every so many samples: a solution costs twice as much
/// as taking in a sample, and one more sample changes little.
const ALIGNMENT_PERIOD: u32 = 16;

/// Rate and inertia, the nine states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<T: Real> {
    /// Body rate, rad/s.
    pub rate_rad_s: Vec3<T>,
    /// Inertia tensor.
    pub inertia: Inertia<T>,
}

crate::persist!([T: Real] State<T> { rate_rad_s, inertia });

/// How the filter keeps its covariance, and with it propagates and corrects.
pub trait Form<T: Real>: Sized {
    /// Starts with this covariance of the nine states.
    fn new(covariance: &Ud<T, 9>) -> Self;
    /// Propagates state and covariance over an interval; `None` where the inertia has no inverse.
    fn predict(
        &mut self,
        state: &mut State<T>,
        interval: &Interval<T>,
        config: &Config<T>,
    ) -> Option<()>;
    /// Variance of the rate, axis by axis, rad²/s².
    fn rate_variance(&self) -> Vec3<T>;
    /// Corrects state and covariance with a measured rate of the given noise variance.
    fn update(&mut self, state: &mut State<T>, measured_rad_s: &Vec3<T>, noise_variance: T);
    /// Starts the rate anew, uncorrelated; the inertia keeps its covariance.
    fn restart_rate(&mut self, variance: T);
    /// Covariance of the nine states.
    fn covariance(&self) -> Mat<T, 9, 9>;
    /// Whether every number is finite and no variance negative.
    fn is_valid(&self) -> bool;
}

/// What the filter is doing.
#[derive(Clone, Copy, Debug)]
enum Phase<T: Real> {
    /// No usable sample yet.
    Waiting,
    /// With no prior, or a vague one: gathering motion for a first estimate.
    Aligning(MomentumIntegral<T>),
    /// Filtering.
    Tracking,
}

crate::persist!([T: Real] enum Phase<T> {
    0 => Waiting, 1 => Aligning(motion: MomentumIntegral<T>), 2 => Tracking
});

/// The nine-state filter, W wheels, its covariance in form F.
#[derive(Clone, Debug)]
pub struct JointEkf<T: Real, F: Form<T>, const W: usize> {
    config: Config<T>,
    wheels: WheelArray<T, W>,
    gate: Gate<T>,
    drive: DriveHistory<T>,
    phase: Phase<T>,
    /// The motion so far determines an inertia that no body has: it contradicts the model.
    contradicted: bool,
    /// What is believed beforehand: the configuration's prior, until a lockout disproves it.
    prior: Option<Prior<T>>,
    range_kg_m2: [T; 6],
    state: State<T>,
    form: F,
    monitor: InnovationMonitor<T>,
    innovation: Option<Innovation<T>>,
    spikes_in_a_row: u16,
}

crate::persist!([T: Real, F: Form<T> + Persist, const W: usize] JointEkf<T, F, W> {
    config, gate, drive, phase, contradicted, prior, range_kg_m2, state, form, monitor, innovation,
    spikes_in_a_row; unchanged wheels
});

impl<T: Real, F: Form<T>, const W: usize> JointEkf<T, F, W> {
    /// A filter that waits for its first sample.
    ///
    /// # Errors
    /// Names the configuration's first field that is out of its range.
    pub fn new(config: Config<T>, wheels: WheelArray<T, W>) -> Result<Self, ConfigError> {
        config.validate()?;
        let start = Start::from_prior(config.prior, &config, &Vec3::zeros());
        Ok(Self {
            gate: Gate::new(config.gate),
            drive: DriveHistory::default(),
            phase: Phase::Waiting,
            contradicted: false,
            prior: config.prior,
            range_kg_m2: start.range_kg_m2,
            state: start.state,
            form: F::new(&start.covariance),
            monitor: InnovationMonitor::default(),
            innovation: None,
            spikes_in_a_row: 0,
            config,
            wheels,
        })
    }

    /// The nine states: ω (rad/s), then `jxx jyy jzz jxy jxz jyz` (kg m²).
    pub fn state(&self) -> [T; 9] {
        let [x, y, z]: [T; 3] = self.state.rate_rad_s.into();
        let [a, b, c, d, e, f] = self.state.inertia.elements_kg_m2();
        [x, y, z, a, b, c, d, e, f]
    }

    /// Covariance of the nine states, in the same order and units.
    pub fn covariance(&self) -> Mat<T, 9, 9> {
        self.form.covariance()
    }

    /// Running mean of the normalised innovation squared per degree of freedom: 1 is honest.
    pub fn mean_nis(&self) -> T {
        self.monitor.mean_nis()
    }

    /// Begins, or begins again, from nothing but the prior and this sample.
    fn begin(&mut self, sample: &Sample<T, W>) {
        let drive = sample.drive(&self.wheels);
        self.drive.restart(drive);
        self.track_from(Start::from_prior(self.prior, &self.config, &sample.rate_rad_s));
        if self.prior.is_none_or(|prior| prior.is_vague(self.config.align_above)) {
            let (noise, prior) = (self.config.gyro_noise_rad_s, self.prior.as_ref());
            let fit = MomentumIntegral::new(&sample.rate_rad_s, &drive, noise, prior);
            self.phase = Phase::Aligning(fit);
        }
    }

    fn track_from(&mut self, start: Start<T>) {
        self.state = start.state;
        self.form = F::new(&start.covariance);
        self.range_kg_m2 = start.range_kg_m2;
        self.spikes_in_a_row = 0;
        self.contradicted = false;
        self.phase = Phase::Tracking;
    }

    fn align(&mut self, sample: &Sample<T, W>, interval: &Interval<T>) -> Outcome {
        self.state.rate_rad_s = sample.rate_rad_s;
        let Phase::Aligning(fit) = &mut self.phase else {
            return Outcome::Coasting(Coasting::Aligning);
        };
        fit.add(&sample.rate_rad_s, interval);
        if !fit.samples().is_multiple_of(ALIGNMENT_PERIOD) {
            return Outcome::Coasting(Coasting::Aligning);
        }
        let start = Start::from_motion(fit, self.prior.as_ref(), self.config.gyro_noise_rad_s);
        self.contradicted = matches!(start, Err(NoStart::NotPhysical));
        match start {
            Err(_) => Outcome::Coasting(Coasting::Aligning),
            Ok(start) => {
                self.track_from(start);
                Outcome::Reset(Reset::Aligned)
            }
        }
    }

    fn track(&mut self, sample: &Sample<T, W>, interval: &Interval<T>) -> Outcome {
        if self.form.predict(&mut self.state, interval, &self.config).is_none() {
            return self.start_over(sample);
        }
        let noise_variance = self.config.noise_variance();
        let innovation = Innovation {
            rate_rad_s: sample.rate_rad_s - self.state.rate_rad_s,
            variance_rad2_s2: self.form.rate_variance() + Vec3::repeat(noise_variance),
        };
        self.innovation = Some(innovation);
        let ratio = innovation.squared_test_ratio();
        if !ratio.is_finite() {
            return self.start_over(sample);
        }
        if ratio > self.config.spike_sigma * self.config.spike_sigma {
            return self.pass_over_spike(sample, &innovation);
        }
        self.spikes_in_a_row = 0;
        self.monitor.accept(&innovation);
        self.form.update(&mut self.state, &sample.rate_rad_s, noise_variance);
        if self.is_valid() { Outcome::Updated } else { self.start_over(sample) }
    }

    fn pass_over_spike(&mut self, sample: &Sample<T, W>, innovation: &Innovation<T>) -> Outcome {
        self.monitor.refuse(innovation);
        self.spikes_in_a_row = self.spikes_in_a_row.saturating_add(1);
        if self.spikes_in_a_row < self.config.lockout_after {
            return Outcome::Coasting(Coasting::Spike);
        }
        let last = self.state.inertia;
        self.prior = None;
        self.begin(sample);
        self.state.inertia = last;
        Outcome::Reset(Reset::Lockout)
    }

    fn bridge_gap(&mut self, sample: &Sample<T, W>) -> Outcome {
        self.drive.restart(sample.drive(&self.wheels));
        match self.phase {
            Phase::Waiting | Phase::Aligning(_) => self.begin(sample),
            Phase::Tracking => {
                self.state.rate_rad_s = sample.rate_rad_s;
                self.form.restart_rate(self.config.noise_variance());
            }
        }
        Outcome::Reset(Reset::Gap)
    }

    fn start_over(&mut self, sample: &Sample<T, W>) -> Outcome {
        self.prior = self.config.prior;
        self.begin(sample);
        Outcome::Reset(Reset::Diverged)
    }

    fn is_valid(&self) -> bool {
        self.form.is_valid() && self.state().iter().all(|x| x.is_finite())
    }

    /// The status, where it isn't for the directions seen to say.
    fn status(&self) -> Option<Status> {
        match self.phase {
            _ if self.contradicted || !self.monitor.is_consistent() => Some(Status::Diverged),
            Phase::Waiting | Phase::Aligning(_) => Some(Status::Unobservable),
            Phase::Tracking => None,
        }
    }
}

impl<T: Real, F: Form<T>, const W: usize> Estimator<T, W> for JointEkf<T, F, W> {
    fn step(&mut self, sample: &Sample<T, W>) -> Outcome {
        self.innovation = None;
        match self.gate.check(sample) {
            Verdict::Rejected(why) => Outcome::Coasting(Coasting::Rejected(why)),
            Verdict::First => {
                self.begin(sample);
                Outcome::Reset(Reset::FirstSample)
            }
            Verdict::Gap => self.bridge_gap(sample),
            Verdict::After { elapsed_us } => {
                let duration_s = T::seconds(elapsed_us);
                let interval = self.drive.advance(sample.drive(&self.wheels), duration_s);
                match self.phase {
                    Phase::Aligning(_) => self.align(sample, &interval),
                    Phase::Waiting | Phase::Tracking => self.track(sample, &interval),
                }
            }
        }
    }

    fn estimate(&self) -> Estimate<T> {
        let p = self.form.covariance();
        let covariance = Mat::from_fn(|i, k| p[(3 + i, 3 + k)]);
        let residual = self.monitor.residual_rms_rad_s();
        let estimate =
            Estimate::of_inertia(self.state.inertia, covariance, &self.range_kg_m2, residual);
        Estimate { status: self.status().unwrap_or(estimate.status), ..estimate }
    }

    fn rate_rad_s(&self) -> Vec3<T> {
        self.state.rate_rad_s
    }

    fn innovation(&self) -> Option<Innovation<T>> {
        self.innovation
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::test_flight::{TestFlight, tumbling_torque_n_m};
    use crate::gate::Rejection;
    use crate::monitor::observability::Observed;
    use proptest::prelude::*;
    use std::vec::Vec;

    const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
    const NOISE_RAD_S: f64 = 1e-4;
    const PERIOD_US: u64 = 100_000;

    /// A minute of motion under known torques, without noise: 10 Hz, no wheels.
    fn flight(inertia: [f64; 6]) -> Vec<Sample<f32, 0>> {
        let flight = TestFlight {
            inertia_kg_m2: inertia,
            initial_rate_rad_s: Vec3::new(0.01, -0.02, 0.03),
            wheels: WheelArray::<f64, 0>::new([], []).unwrap(),
            period_us: PERIOD_US,
            samples: 600,
        };
        flight.fly(|_| [], tumbling_torque_n_m)
    }

    fn filter() -> JointEkfUd<f32, 0> {
        let wheels = WheelArray::new([], []).unwrap();
        JointEkfUd::new(Config::new(NOISE_RAD_S as f32), wheels).unwrap()
    }

    fn relative_error(filter: &JointEkfUd<f32, 0>, truth: [f64; 6]) -> f64 {
        let found = filter.estimate().inertia.elements_kg_m2();
        (0..6).map(|i| (f64::from(found[i]) - truth[i]).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn starts_from_nothing_aligns_and_converges() {
        let mut filter = filter();
        let outcomes: Vec<Outcome> =
            flight(INERTIA).iter().map(|sample| filter.step(sample)).collect();
        assert_eq!(outcomes[0], Outcome::Reset(Reset::FirstSample));
        assert_eq!(outcomes[1], Outcome::Coasting(Coasting::Aligning));
        assert_eq!(outcomes.iter().filter(|o| **o == Outcome::Reset(Reset::Aligned)).count(), 1);
        assert_eq!(outcomes[599], Outcome::Updated);
        let estimate = filter.estimate();
        assert_eq!((estimate.status, estimate.observed.directions), (Status::Converged, 6));
        assert!(relative_error(&filter, INERTIA) < 1e-3);
    }

    #[test]
    fn says_unobservable_before_it_has_seen_anything() {
        let estimate = filter().estimate();
        assert_eq!(
            (estimate.status, estimate.observed),
            (Status::Unobservable, Observed::default())
        );
        assert!(estimate.sigma_kg_m2().iter().all(|s| *s >= 1e3));
    }

    #[test]
    fn broken_samples_are_passed_over_for_their_reason() {
        let mut filter = filter();
        let mut samples = flight(INERTIA);
        samples[400].rate_rad_s.x = f32::NAN;
        samples[420].rate_rad_s.y += 0.5;
        samples[440].time_us = samples[439].time_us;
        let outcomes: Vec<Outcome> = samples.iter().map(|sample| filter.step(sample)).collect();
        let rejected = |why| Outcome::Coasting(Coasting::Rejected(why));
        assert_eq!(outcomes[400], rejected(Rejection::NotFinite));
        assert_eq!(outcomes[420], Outcome::Coasting(Coasting::Spike));
        assert_eq!(outcomes[440], rejected(Rejection::OutOfOrder));
        for next in [401, 421, 441] {
            assert_eq!(outcomes[next], Outcome::Updated, "sample {next}");
        }
        assert!(relative_error(&filter, INERTIA) < 1e-3);
    }

    #[test]
    fn a_gap_keeps_the_inertia_and_starts_the_rate_anew() {
        let mut filter = filter();
        let samples = flight(INERTIA);
        samples[..400].iter().for_each(|sample| {
            filter.step(sample);
        });
        let before = filter.estimate();
        assert_eq!(filter.step(&samples[450]), Outcome::Reset(Reset::Gap));
        assert_eq!(filter.rate_rad_s(), samples[450].rate_rad_s);
        assert_eq!(filter.estimate().inertia, before.inertia);
        assert_eq!(filter.step(&samples[451]), Outcome::Updated);
    }

    #[test]
    fn a_deployment_locks_out_and_is_followed() {
        let deployed = [3.0, 1.6, 2.6, 0.2, -0.1, 0.05];
        let mut filter = filter();
        flight(INERTIA).iter().for_each(|sample| {
            filter.step(sample);
        });
        let later = flight(deployed).into_iter().map(|mut sample| {
            sample.time_us += 600 * PERIOD_US;
            sample
        });
        let outcomes: Vec<Outcome> = later.map(|sample| filter.step(&sample)).collect();
        assert!(outcomes.contains(&Outcome::Reset(Reset::Lockout)));
        assert_eq!(outcomes[599], Outcome::Updated);
        assert_eq!(filter.estimate().status, Status::Converged);
        assert!(relative_error(&filter, deployed) < 1e-2);
    }

    proptest! {
        #[test]
        fn any_sequence_of_samples_leaves_a_finite_estimate(
            bits in prop::collection::vec((any::<u64>(), prop::array::uniform6(any::<u32>())), 50),
            spoil in 0..600usize,
        ) {
            let mut filter = filter();
            let mut samples = flight(INERTIA);
            for (k, (time, values)) in bits.into_iter().enumerate() {
                let [a, b, c, d, e, f] = values.map(f32::from_bits);
                let sample = &mut samples[(spoil + 7 * k) % 600];
                if time % 3 == 0 {
                    sample.time_us = time;
                }
                sample.rate_rad_s = Vec3::new(a, b, c);
                sample.torque_n_m = Vec3::new(d, e, f);
            }
            for sample in &samples {
                filter.step(sample);
            }
            let estimate = filter.estimate();
            prop_assert!(estimate.inertia.elements_kg_m2().iter().all(|x| x.is_finite()));
            prop_assert!(estimate.sigma_kg_m2().iter().all(|x| x.is_finite()));
            prop_assert!(filter.state().iter().all(|x| x.is_finite()));
        }
    }
}
