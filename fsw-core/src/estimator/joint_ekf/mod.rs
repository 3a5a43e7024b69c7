//! `joint-ekf`: extended Kalman filter of rate and inertia, nine states, \[Bellar2019\].
//!
//! State `x = (ω, j)` in rad/s and kg m², measurement `y = ω + v` with v the gyro's white noise of
//! variance R on each axis. Process model:
//!
//! `ω̇ = J⁻¹ (τ − ḣ_w − ω × (J ω + h_w)) + w`, `j̇ = w_j`
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `ω`, `y` | body rate, its measurement | rad/s |
//! | `j`, `J` | six elements `Jxx Jyy Jzz Jxy Jxz Jyz`, 3×3 tensor | kg m² |
//! | `τ` | external torque, body axes | N m |
//! | `h_w` | momentum of the wheels relative to the body | N m s |
//! | `w`, `w_j` | random walks of rate and inertia | (rad/s)/√s, kg m²/√s |
//! | `P⁻`, `P⁺` | covariance of x before and after the correction | products of the states' |
//! | `R`, `S` | variance of the gyro noise, of the innovation | rad²/s² |
//! | `ν` | innovation, `y − ω⁻` | rad/s |
//!
//! One step:
//!
//! ```text
//!  sample ─► gate ─► predict ─► innovation ─► spike gate ─► shift test ─► update ─► Outcome
//!                    x⁻, P⁻     ν = y − ω⁻    ν² ≤ 6² S?    mean of ν?    x⁺, P⁺
//! ```
//!
//! Before that, without a prior or from a vague one, [`alignment`] estimates the first state from
//! the motion itself. Its samples pass an outlier gate ([`monitor::outliers`](crate::monitor::outliers))
//! and are two samples late; a refused one is the outcome [`Coasting::Spike`] of that step. Tracking
//! starts five samples after the last one that the solution contains.
//!
//! Two forms of the same filter are chosen by type:
//!
//! * [`JointEkfPublished`], as printed ([`as_published`]);
//! * [`JointEkfUd`], in UD factors, the one that flies ([`structured_ud`]).
//!
//! # Restarts
//!
//! | event | state afterwards | outcome |
//! |---|---|---|
//! | first sample | the prior's, or alignment | [`Reset::FirstSample`] |
//! | alignment complete | the alignment's | [`Reset::Aligned`] |
//! | gap longer than `gate.max_gap_us`, or hole in the rate beyond the limits of [`gate`](crate::gate) | rate of the sample; inertia unchanged | [`Reset::Gap`], [`Reset::Clock`] |
//! | lock-out: spikes in a row, a persistent shift | alignment without a prior; the estimate from before is doubted | [`Reset::Lockout`] |
//! | later data contradict what is doubted | that of the later data | [`Reset::Changed`] |
//! | a number not finite, `J` singular | the prior's, or alignment | [`Reset::Diverged`] |
//!
//! A sample whose rate alone is rejected is predicted to while the filter tracks: wheels and torque are known.
//!
//! # Doubt
//!
//! A transient fault costs the data of its duration and of up to 128 updates before its detection. The estimate from
//! before a lock-out is kept. Once the later data are so certain that a change of 2 % would contradict it, chi-square
//! decides: it is fused with theirs, in six updates, or discarded. Until then the residuals are not called white. The
//! equations are those of module `doubt`. The published form keeps no earlier estimate.
//!
//! # Errors of the hardware
//!
//! [`JointEkf::considering`] takes stated errors of gyro, wheels and torque, and constant disturbances. They are
//! not estimated: each has a column of sensitivities, which widens the covariance and sets the gain
//! ([`considered`]). `sigma_random_kg_m2` is then the share of the noise, and
//! [`Estimator::each_of_hardware`] returns the effect of each parameter. [`JointEkf::new`] takes the hardware as
//! ideal, and has none of this compiled in.
//!
//! # Whiteness
//!
//! `residuals_white` is false in doubt and in a transient of spikes. Otherwise it is the result of
//! [`whiteness`](crate::monitor::whiteness) on the innovations since the last start, but those of such transients
//! ([`transients`](crate::monitor::transients)): size and correlation, of single ones and of groups of 4 and 16.
//! `Some(false)` with a status of `Converged` is then an error of the model below the alarm of the mean NIS.
//!
//! # Departures and assumptions
//!
//! Departures from \[Bellar2019\], for both forms: wheels (the paper has none), the gate, the spike
//! gate, the alignment, and the observability that the estimate reports. Those of each form are
//! listed in its module.
//!
//! Assumptions: gyro noise is white and of the stated sigma, torque and wheel speeds are exact but for the
//! considered errors, the body is rigid. Other errors enter the estimate, up to the tests of the
//! innovations ([`InnovationMonitor::is_consistent`] and the whiteness). An error that the inertia itself can
//! imitate, such as a common scale of gyro or wheels, leaves the innovations white: it must be stated.
//!
//! # Accuracy
//!
//! STSAT-3 spin-up of the paper, 600 s at 10 Hz, gyro noise 0.0104 deg/s. RMS error in units of the
//! Cramér-Rao bound over 100 runs, least and largest of the six elements; NEES per degree of
//! freedom, 1 for a covariance that fits. Held within bounds by `tests/consistency.rs`.
//!
//! | start | form | RMS error / bound | NEES | failed |
//! |---|---|---|---|---|
//! | alignment | UD, f32 | 1.03 to 1.35 | 1.08 | 0 |
//! | prior of 25 and 2 kg m² | UD, f64 | 1.08 to 1.99 | 10.4 | 0 |
//! | prior of 25 and 2 kg m² | published, f64 | 1.01 to 3.54 | 28 | 0 |
//! | prior of 25 and 2 kg m² | published, f32 | 1.56 to 4.45 | 51 | 24 |
//!
//! Linearisation about a wrong inertia makes the covariance too small; the alignment removes most
//! of the initial error first.
//!
//! # Example
//!
//! ```
//! use fsw_core::estimator::joint_ekf::{Config, JointEkfUd};
//! use fsw_core::{Estimator, Outcome, Prior, Sample, Vec3, WheelArray};
//!
//! // One wheel about z, spin inertia 1.7e-6 kg m²; gyro noise 1.8e-4 rad/s.
//! let wheels = WheelArray::new([Vec3::z()], [1.7e-6f32])?;
//! let prior = Prior { inertia_kg_m2: [25.0, 25.0, 25.0, 0.0, 0.0, 0.0], sigma_kg_m2: [2.0; 6] };
//! let config = Config { prior: Some(prior), ..Config::new(1.8e-4) };
//! let mut filter = JointEkfUd::new(config, wheels)?;
//! let mut outcome = None;
//! for k in 0..100 {
//!     outcome = Some(filter.step(&Sample {
//!         time_us: 100_000 * k,
//!         rate_rad_s: Vec3::new(0.01, 0.0, 1e-4 * (k % 3) as f32),
//!         wheel_speed_rad_s: [50.0],
//!         torque_n_m: Vec3::zeros(),
//!         attitude: None,
//!     }));
//! }
//! assert_eq!(outcome, Some(Outcome::Updated));
//! let [jxx, ..] = filter.estimate().inertia.elements_kg_m2();
//! assert!((jxx - 25.0).abs() < 2.0);
//! # Ok::<(), fsw_core::ConfigError>(())
//! ```

mod aligning;
pub mod alignment;
pub mod as_published;
pub mod config;
pub mod considered;
mod delay;
mod doubt;
mod start;
mod state;
pub mod structured_ud;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_of_hardware;

pub use as_published::AsPublished;
pub use config::{Config, InitialRate};
pub use considered::{Considered, Gain, Prediction};
pub use state::{Combination, Form, State};
pub use structured_ud::StructuredUd;

use crate::dynamics::interval::{Drive, DriveHistory, Interval};
use crate::dynamics::wheels::WheelArray;
use crate::error::ConfigError;
use crate::estimate::{Estimate, Status};
use crate::estimator::Estimator;
use crate::gate::{Gate, Verdict};
use crate::hardware::{Disturbance, Finding, Hardware};
use crate::math::{Entries, Mat, Vec3, norm, scalar::Real, ud::Ud};
use crate::monitor::innovation::{Innovation, InnovationMonitor};
use crate::monitor::shift::{self, ShiftTest};
use crate::monitor::spikes::{Decision, SpikeGate};
use crate::monitor::transients::Undisturbed;
use crate::outcome::{Coasting, Outcome, Reset};
use crate::persist::Persist;
use crate::prior::Prior;
use crate::sample::Sample;
use aligning::{Aligning, Due, Pending, Placed, Progress};
use delay::Delay;
use doubt::{Doubt, Row, Snapshot, Task, Verdict as OnDoubt};
use start::{AlignmentError, NoStart, Start};

/// The filter as printed: AB2 propagation, first-order transition, `(1 − K H) P`.
pub type JointEkfPublished<T, const W: usize> = JointEkf<T, AsPublished<T>, W>;
/// The filter that flies: Runge-Kutta propagation, UD factors, P considered parameters.
pub type JointEkfUd<T, const W: usize, const P: usize = 0> = JointEkf<T, StructuredUd<T>, W, P>;

/// Variance that monitors allow the hardware, over its stated one: three sigma.
///
/// With it no hardware within three sigma raises an alarm of the shift test, whatever its share c² of the
/// variance: an error of 3 c, in noise of σ, has the mean `z = 3 c σ / (σ² + 9 c²) ≤ ½`, the reference value of the
/// test. Nor does it of the mean NIS: `(σ² + 9 c²) / (σ² + 9 c²) = 1`.
const ALLOWED: f64 = 9.0;

/// Phase of operation.
#[derive(Clone, Copy, Debug)]
enum Phase<T: Real> {
    /// No usable sample yet.
    Waiting,
    /// No prior, or a vague one: motion is accumulated for the first state.
    Aligning,
    /// Aligned, the inertia alone: the rate is to be predicted across the pending samples.
    Solved(Pending<T>),
    /// Aligned: the state is that of the present sample, the covariance that of the last judged one.
    Joining(Pending<T>),
    /// Filtering.
    Tracking,
}

crate::persist!([T: Real] enum Phase<T> {
    0 => Waiting,
    1 => Aligning,
    2 => Joining(pending: Pending<T>),
    3 => Tracking,
    4 => Solved(pending: Pending<T>)
});

/// The nine-state filter, W wheels, its covariance in form F, up to P considered parameters.
#[derive(Clone, Debug)]
pub struct JointEkf<T: Real, F: Form<T>, const W: usize, const P: usize = 0> {
    config: Config<T>,
    wheels: WheelArray<T, W>,
    gate: Gate<T>,
    /// Torque and wheel momentum at the last samples.
    drive: DriveHistory<T>,
    phase: Phase<T>,
    /// Data of the phase of alignment: beside the phase, since a new phase is a copy on the stack.
    aligning: Placed<T>,
    /// The configuration's prior; none after a lock-out, since the estimate that contains it is in doubt.
    prior: Option<Prior<T>>,
    /// Sigma of each element before the data, kg m²: the yardstick of observability.
    range_kg_m2: [T; 6],
    state: State<T>,
    /// Covariance of the state.
    form: F,
    spikes: SpikeGate,
    shift: ShiftTest<T>,
    monitor: InnovationMonitor<T>,
    whiteness: Undisturbed<T>,
    /// Innovation of the last sample, if that was predicted.
    innovation: Option<Innovation<T>>,
    /// Columns of the considered parameters.
    considered: Considered<T, P>,
    /// Last samples, for a known time offset.
    delay: Delay<T, W>,
    /// Estimate from before a lock-out.
    doubt: Doubt<T, P>,
    /// Time since the last snapshot or judgement, s: of the inertia's random walk.
    walked_for_s: T,
}

crate::persist!([T: Real, F: Form<T> + Persist, const W: usize, const P: usize] JointEkf<T, F, W, P> {
    config, gate, drive, phase, aligning, prior, range_kg_m2, state, form, spikes, shift, monitor, whiteness, innovation,
    considered, delay, doubt, walked_for_s;
    unchanged wheels
});

impl<T: Real, F: Form<T>, const W: usize> JointEkf<T, F, W> {
    /// A filter that waits for its first sample. Gyro, wheels and torque are taken as ideal.
    ///
    /// # Errors
    /// Names the configuration's first field that is out of its range.
    pub fn new(config: Config<T>, wheels: WheelArray<T, W>) -> Result<Self, ConfigError> {
        config.validate()?;
        let mut this = Self::in_place(config, wheels);
        this.complete();
        Ok(this)
    }
}

impl<T: Real, const W: usize, const P: usize> JointEkfUd<T, W, P> {
    /// A filter that considers the stated errors of the hardware and constant disturbances ([`considered`]), and
    /// corrects for the known time offset.
    ///
    /// ```
    /// use fsw_core::estimator::joint_ekf::{Config, JointEkfUd};
    /// use fsw_core::hardware::{Disturbance, Hardware};
    /// use fsw_core::{Vec3, WheelArray};
    ///
    /// // Scale factors of the gyro to 0.5 %, spin inertia of the wheel to 1 %: four parameters.
    /// let wheels = WheelArray::new([Vec3::z()], [1.7e-6f32])?;
    /// let hardware =
    ///     Hardware { gyro_scale: 0.005, wheel_inertia: [0.01], ..Hardware::ideal() };
    /// let config = Config::new(1.8e-4);
    /// let none = Disturbance::none();
    /// assert!(JointEkfUd::<f32, 1, 4>::considering(config, wheels, &hardware, &none).is_ok());
    /// let refused = JointEkfUd::<f32, 1, 3>::considering(config, wheels, &hardware, &none);
    /// assert_eq!(refused.unwrap_err().field, "hardware");
    /// # Ok::<(), fsw_core::ConfigError>(())
    /// ```
    ///
    /// # Errors
    /// Names the first field of configuration or hardware that is out of its range; `hardware` where it has more
    /// than P parameters with a sigma above zero.
    pub fn considering(
        config: Config<T>,
        wheels: WheelArray<T, W>,
        hardware: &Hardware<T, W>,
        disturbance: &Disturbance<T>,
    ) -> Result<Self, ConfigError> {
        config.validate()?;
        let mut this = Self::in_place(config, wheels);
        this.consider(hardware, disturbance)?;
        this.complete();
        Ok(this)
    }

    /// Considers the stated errors of the hardware and constant disturbances, in place: before the first sample.
    ///
    /// # Errors
    /// As [`considering`](Self::considering); the filter is unchanged then.
    pub fn consider(
        &mut self,
        hardware: &Hardware<T, W>,
        disturbance: &Disturbance<T>,
    ) -> Result<(), ConfigError> {
        self.considered.set((hardware, disturbance), &self.wheels)
    }
}

impl<T: Real, F: Form<T>, const W: usize, const P: usize> JointEkf<T, F, W, P> {
    /// A filter for a configuration that has passed [`Config::validate`], to be completed by
    /// [`complete`](Self::complete). Inlined, so that the filter is built in its place and not on the stack.
    #[inline(always)]
    pub fn in_place(config: Config<T>, wheels: WheelArray<T, W>) -> Self {
        Self {
            gate: Gate::new(config.gate),
            drive: DriveHistory::default(),
            phase: Phase::Waiting,
            aligning: Placed::absent(),
            prior: config.prior,
            range_kg_m2: [T::zero(); 6],
            state: State::zero(),
            form: F::new(&Ud::diagonal([T::zero(); 9])),
            spikes: SpikeGate::default(),
            shift: ShiftTest::default(),
            monitor: InnovationMonitor::default(),
            whiteness: Undisturbed::default(),
            innovation: None,
            considered: Considered::NOTHING,
            delay: Delay::new(),
            doubt: Doubt::none(),
            walked_for_s: T::zero(),
            config,
            wheels,
        }
    }

    /// Constructs the alignment and the state of the prior in their place: once, after [`in_place`](Self::in_place).
    pub fn complete(&mut self) {
        self.aligning.construct();
        self.take_prior();
    }

    /// State and covariance of the prior.
    #[inline(never)]
    fn take_prior(&mut self) {
        let start = Start::from_prior(self.prior, &self.config, &Vec3::zeros());
        self.state = start.state;
        self.form = F::new(&start.covariance);
        self.range_kg_m2 = start.range_kg_m2;
    }

    /// The nine states: ω (rad/s), then `jxx jyy jzz jxy jxz jyz` (kg m²).
    pub fn state(&self) -> [T; 9] {
        self.state.elements()
    }

    /// Covariance of the nine states, in the same order and units: of the noise, for hardware that is known
    /// exactly.
    pub fn covariance(&self) -> Mat<T, 9, 9> {
        self.form.covariance()
    }

    /// Running mean of the normalised innovation squared per degree of freedom,
    /// `mean(Σ νᵢ² / Sᵢᵢ) / 3`: 1 where the covariance fits the innovations.
    pub fn mean_nis(&self) -> T {
        self.monitor.mean_nis()
    }

    /// One step of the filter: predict, innovation, spike gate, update.
    ///
    /// \[Bellar2019\] Eqs. (18) to (22), with the gate between. A rejected sample leaves the
    /// prediction as the state.
    fn track(&mut self, sample: &Sample<T, W>, interval: &Interval<T>) -> Outcome {
        if self.predict(sample, interval).is_none() {
            return self.restart_diverged(sample);
        }
        let innovation = self.innovation_of(&sample.rate_rad_s);
        let by_hardware =
            if P == 0 { Vec3::zeros() } else { self.considered.innovation_variance() };
        self.innovation = Some(Self::widened(innovation, &by_hardware));
        let allowed = Self::widened(innovation, &(by_hardware * T::lit(ALLOWED)));
        let ratio = allowed.squared_test_ratio();
        if !ratio.is_finite() {
            return self.restart_diverged(sample);
        }
        match self.spikes.judge(ratio, &self.config.spikes) {
            Decision::Accept => match self.judge_shift(&allowed) {
                shift::Decision::Consistent => self.advance(sample, &innovation, &allowed),
                shift::Decision::Shifted => {
                    self.monitor.refuse(&allowed);
                    Outcome::Coasting(Coasting::Spike)
                }
                shift::Decision::LockOut => self.restart_locked_out(sample),
            },
            Decision::Reject => {
                self.monitor.refuse(&allowed);
                self.whiteness.refuse();
                Outcome::Coasting(Coasting::Spike)
            }
            Decision::LockOut => {
                self.monitor.refuse(&allowed);
                self.restart_locked_out(sample)
            }
        }
    }

    /// The innovation with this variance in addition, rad²/s².
    fn widened(innovation: Innovation<T>, variance_rad2_s2: &Vec3<T>) -> Innovation<T> {
        if P == 0 {
            return innovation;
        }
        let variance_rad2_s2 = innovation.variance_rad2_s2 + variance_rad2_s2;
        Innovation { variance_rad2_s2, ..innovation }
    }

    /// Prediction over the interval to the present sample; the first one after an alignment starts
    /// at its last judged sample.
    fn predict(&mut self, sample: &Sample<T, W>, interval: &Interval<T>) -> Option<()> {
        let Phase::Joining(pending) = self.phase else {
            return self.form.predict(&mut self.state, interval, &self.config, |prediction| {
                if P > 0 {
                    let momenta = self.wheels.momenta_n_m_s(&sample.wheel_speed_rad_s);
                    self.considered.predict(prediction, &momenta);
                }
            });
        };
        self.phase = Phase::Tracking;
        pending.predict(&mut self.state, &mut self.form, interval, &self.config)?;
        let rate_rad_s = self.state.rate_rad_s;
        self.restart_rate_of_columns(Some(&rate_rad_s), sample);
        Some(())
    }

    /// Columns at the start of a rate, rad/s, that is, or agrees with, a reading; none for another rate.
    fn restart_rate_of_columns(&mut self, rate_rad_s: Option<&Vec3<T>>, sample: &Sample<T, W>) {
        if P > 0 {
            let momenta = self.wheels.momenta_n_m_s(&sample.wheel_speed_rad_s);
            self.considered.restart_rate(rate_rad_s, &momenta);
        }
    }

    /// Shift test of an innovation; none where the spike gate is disabled.
    fn judge_shift(&mut self, innovation: &Innovation<T>) -> shift::Decision {
        if self.config.spikes.limit_sigma < T::MAX {
            self.shift.judge(innovation, self.config.gyro_noise_rad_s)
        } else {
            shift::Decision::Consistent
        }
    }

    /// `ν = y − ω⁻`, rad/s, with its variance `S = P⁻ + R` on each axis: \[Bellar2019\] Eq. (21).
    fn innovation_of(&self, measured_rad_s: &Vec3<T>) -> Innovation<T> {
        let noise_variance = self.config.noise_variance();
        Innovation {
            rate_rad_s: measured_rad_s - self.state.rate_rad_s,
            variance_rad2_s2: self.form.rate_variance() + Vec3::repeat(noise_variance),
        }
    }

    /// Correction of state and covariance; a restart where the result is not finite or no
    /// covariance. `allowed`: the innovation with the variance that monitors allow the hardware.
    fn update(
        &mut self,
        sample: &Sample<T, W>,
        innovation: &Innovation<T>,
        allowed: &Innovation<T>,
    ) -> Outcome {
        self.monitor.accept(allowed);
        let noise_rad_s = self.config.gyro_noise_rad_s;
        self.whiteness.add(innovation, noise_rad_s, Self::explained(innovation, allowed));
        let noise_variance = self.config.noise_variance();
        let rate_rad_s = &sample.rate_rad_s;
        self.form.update(&mut self.state, rate_rad_s, noise_variance, |gain| {
            if P == 0 { None } else { self.considered.correct(gain) }
        });
        if self.is_valid() { Outcome::Updated } else { self.restart_diverged(sample) }
    }

    /// Correction by a consistent innovation, or the task that is due in place of it: a doubted estimate takes two samples
    /// in 64, and six for its fusion, which are predicted across. No step has the cost of both.
    #[inline]
    fn advance(
        &mut self,
        sample: &Sample<T, W>,
        innovation: &Innovation<T>,
        allowed: &Innovation<T>,
    ) -> Outcome {
        match self.doubt.advance(self.shift.is_calm()) {
            Task::Nothing => self.update(sample, innovation, allowed),
            Task::Snapshot => {
                self.take_snapshot();
                self.update(sample, innovation, allowed)
            }
            Task::Ageing => self.age_doubted(),
            Task::Judgement => self.judge_doubted(),
            Task::Fusion => self.fuse_doubted(),
        }
    }

    /// Snapshot of the estimate, where the form of the covariance keeps earlier ones.
    #[inline(never)]
    fn take_snapshot(&mut self) {
        if let Some(factors) = self.form.inertia_factors() {
            let (inertia, columns) = (self.state.inertia, self.considered.of_inertia());
            self.walked_for_s = T::zero();
            self.doubt.keep(Snapshot { inertia, factors, columns });
        }
    }

    /// Random walk of the estimate from before the last lock-out.
    #[inline(never)]
    fn age_doubted(&mut self) -> Outcome {
        let duration_s = core::mem::replace(&mut self.walked_for_s, T::zero());
        self.doubt.walk(self.config.inertia_walk_kg_m2_sqrt_s.map(|s| s * s * duration_s));
        Outcome::Updated
    }

    /// Judges the estimate from before the last lock-out.
    #[inline(never)]
    fn judge_doubted(&mut self) -> Outcome {
        let covariance = self.form.inertia_covariance();
        match self.doubt.judge(&self.state.inertia, covariance, &self.considered) {
            OnDoubt::Undecided | OnDoubt::Interrupted => Outcome::Updated,
            OnDoubt::Changed => Outcome::Reset(Reset::Changed),
        }
    }

    /// Takes in the next row of the estimate from before the last lock-out.
    #[inline(never)]
    fn fuse_doubted(&mut self) -> Outcome {
        let Some(Row { h, value_kg_m2, variance, columns }) = self.doubt.next_row() else {
            return Outcome::Updated;
        };
        let measured = Combination { h: &h, value_kg_m2, variance };
        let considered = &mut self.considered;
        self.form.observe_inertia(&mut self.state, &measured, |gain, variance| {
            if P == 0 { None } else { considered.correct_along(&h, &columns, (gain, variance)) }
        });
        Outcome::Updated
    }

    /// Mean square of an innovation, over its variance by noise, that the hardware may have in addition.
    fn explained(innovation: &Innovation<T>, allowed: &Innovation<T>) -> T {
        if P == 0 {
            return T::zero();
        }
        let ratio = allowed.variance_rad2_s2.component_div(&innovation.variance_rad2_s2);
        ratio.sum() * T::lit(1.0 / 3.0) - T::one()
    }

    /// True if all states are finite and the covariance is valid.
    fn is_valid(&self) -> bool {
        self.form.is_valid()
            && self.state().iter().all(|x| x.is_finite())
            && self.considered.is_finite()
    }

    /// Adds the sample to the alignment, and starts tracking once that determines the inertia.
    fn align(&mut self, sample: &Sample<T, W>, elapsed_s: T) -> Outcome {
        self.state.rate_rad_s = sample.rate_rad_s;
        let drive = sample.drive(&self.wheels);
        let (noise, prior) = (self.config.gyro_noise_rad_s, self.prior);
        let Some(aligning) = self.aligning.get_mut() else {
            return Outcome::Coasting(Coasting::Aligning);
        };
        aligning.take_in((&sample.rate_rad_s, &drive), elapsed_s, noise);
        let (considered, wheels) = (&self.considered, &self.wheels);
        let error = |mean_moment_kg_m2: T, samples: u32| {
            let of_body = (mean_moment_kg_m2, elapsed_s * T::count(samples));
            considered.rate_error_rad_s(sample, wheels, of_body)
        };
        let allowed = |mean_moment_kg_m2: T, samples: u32| {
            let error = error(mean_moment_kg_m2, samples);
            (noise * noise + error * error * T::lit(ALLOWED)).sqrt()
        };
        match aligning.due() {
            None => {}
            Some(Due { inertia: None, .. }) => match aligning.solve_inertia(noise, allowed) {
                Err(NoStart::NoSolution) => {}
                Ok(()) | Err(NoStart::TooLittleMotion) => {
                    return Outcome::Coasting(Coasting::Aligning);
                }
                Err(NoStart::Contradiction) => {
                    aligning.discard();
                    return Outcome::Coasting(Coasting::Aligning);
                }
            },
            Some(Due { inertia: Some(inertia), drive }) => {
                if let Some(start) = aligning.start(&inertia, noise, prior.as_ref()) {
                    return self.end_alignment(start, drive, sample);
                }
            }
        }
        match aligning.step(noise, prior.as_ref()) {
            Progress::Continues => Outcome::Coasting(Coasting::Aligning),
            Progress::Refused => Outcome::Coasting(Coasting::Spike),
        }
    }

    /// Takes over the solution at the last judged sample, with the drive there. The rate remains that of the reading
    /// until the next sample.
    fn end_alignment(
        &mut self,
        mut start: Start<T>,
        drive: Drive<T>,
        sample: &Sample<T, W>,
    ) -> Outcome {
        self.widen_by_hardware(&mut start, sample);
        self.track_from(&start);
        self.phase = Phase::Solved(Pending::new(self.state.rate_rad_s, drive));
        self.state.rate_rad_s = sample.rate_rad_s;
        Outcome::Coasting(Coasting::Aligning)
    }

    /// Predicts the rate of the solution across the pending samples to this one. Tracking follows.
    fn join(&mut self, sample: &Sample<T, W>, elapsed_s: T, mut way: Pending<T>) -> Outcome {
        let drive = sample.drive(&self.wheels);
        let noise = self.config.gyro_noise_rad_s;
        self.state.rate_rad_s = way.rate_rad_s;
        let state = &mut self.state;
        let predicted = self.aligning.get_mut().and_then(|aligning| {
            aligning.take_in((&sample.rate_rad_s, &drive), elapsed_s, noise);
            aligning.predict(state, &mut way)
        });
        if predicted.is_none() || !self.is_valid() {
            return self.restart_diverged(sample);
        }
        self.phase = Phase::Joining(way);
        Outcome::Reset(Reset::Aligned)
    }

    /// Adds the errors of the hardware to the covariance of a start by alignment up to this sample.
    fn widen_by_hardware(&self, start: &mut Start<T>, sample: &Sample<T, W>) {
        if P == 0 {
            return;
        }
        let of_body = (start.state.inertia.trace_kg_m2() * T::lit(1.0 / 3.0), T::zero());
        start.widen(&AlignmentError {
            rate_rad_s: self.considered.rate_error_rad_s(sample, &self.wheels, of_body),
            of_rate_rad_s: norm(&sample.rate_rad_s),
            scale: self.considered.scale_error(),
        });
    }

    /// Starts from the prior and this sample: tracking, or aligning where the prior is vague.
    #[inline(never)]
    fn begin(&mut self, sample: &Sample<T, W>) {
        let drive = sample.drive(&self.wheels);
        self.drive.restart(drive);
        self.track_from(&Start::from_prior(self.prior, &self.config, &sample.rate_rad_s));
        let is_reading = self.config.initial_rate.is_none();
        self.restart_rate_of_columns(is_reading.then_some(&sample.rate_rad_s), sample);
        if self.prior.is_none_or(|prior| prior.is_vague(self.config.align_above)) {
            self.phase = Phase::Aligning;
            if let Some(aligning) = self.aligning.get_mut() {
                aligning.begin(&sample.rate_rad_s, &drive, self.config.gyro_noise_rad_s);
            }
        }
    }

    /// Takes over a first state and its covariance.
    fn track_from(&mut self, start: &Start<T>) {
        self.state = start.state;
        self.form = F::new(&start.covariance);
        self.range_kg_m2 = start.range_kg_m2;
        self.spikes.restart();
        self.shift.restart();
        self.whiteness.restart();
        self.considered.restart();
        self.phase = Phase::Tracking;
    }

    /// After a gap the rate starts from the sample; the inertia keeps value and covariance.
    fn restart_rate(&mut self, sample: &Sample<T, W>) -> Outcome {
        self.drive.restart(sample.drive(&self.wheels));
        match self.phase {
            Phase::Waiting | Phase::Aligning | Phase::Solved(_) => self.begin(sample),
            Phase::Joining(_) | Phase::Tracking => {
                self.phase = Phase::Tracking;
                self.shift.restart();
                self.state.rate_rad_s = sample.rate_rad_s;
                self.form.restart_rate(self.config.noise_variance());
                self.restart_rate_of_columns(Some(&sample.rate_rad_s), sample);
            }
        }
        Outcome::Reset(self.gate.cause_of_gap().into())
    }

    /// After a lock-out the prior is dropped, and the estimate from before is doubted; the last inertia is reported
    /// until the alignment ends.
    fn restart_locked_out(&mut self, sample: &Sample<T, W>) -> Outcome {
        let last = self.state.inertia;
        self.prior = None;
        self.doubt.interrupt();
        self.begin(sample);
        self.state.inertia = last;
        Outcome::Reset(Reset::Lockout)
    }

    /// After a divergence the configuration's prior counts again, also where a lock-out dropped it.
    fn restart_diverged(&mut self, sample: &Sample<T, W>) -> Outcome {
        self.prior = self.config.prior;
        self.doubt.clear();
        self.begin(sample);
        Outcome::Reset(Reset::Diverged)
    }

    /// One step with a sample that the gate has judged.
    fn step_judged(&mut self, sample: &Sample<T, W>, verdict: Verdict) -> Outcome {
        match verdict {
            Verdict::Rejected(why) => {
                self.coast(sample).unwrap_or(Outcome::Coasting(Coasting::Rejected(why)))
            }
            Verdict::First => {
                self.begin(sample);
                Outcome::Reset(Reset::FirstSample)
            }
            Verdict::Gap => self.restart_rate(sample),
            Verdict::After { elapsed_us } => {
                let duration_s = T::seconds(elapsed_us);
                let interval = self.drive.advance(sample.drive(&self.wheels), duration_s);
                self.walked_for_s += duration_s;
                match self.phase {
                    Phase::Aligning => self.align(sample, duration_s),
                    Phase::Solved(way) => self.join(sample, duration_s, way),
                    Phase::Waiting | Phase::Joining(_) | Phase::Tracking => {
                        self.track(sample, &interval)
                    }
                }
            }
        }
    }

    /// Prediction to a sample whose rate was rejected and whose drive is known. A restart, from the rate before it, where
    /// the result is not finite or no covariance.
    #[inline(never)]
    fn coast(&mut self, sample: &Sample<T, W>) -> Option<Outcome> {
        if !matches!(self.phase, Phase::Tracking) {
            return None;
        }
        let elapsed_us = self.gate.bridge(sample)?;
        let before = Sample { rate_rad_s: self.state.rate_rad_s, ..*sample };
        let duration_s = T::seconds(elapsed_us);
        let sample = match self.considered.delay_s() {
            Some(delay_s) => self.delay.shifted(sample, duration_s, delay_s),
            None => *sample,
        };
        let interval = self.drive.advance(sample.drive(&self.wheels), duration_s);
        self.walked_for_s += duration_s;
        let is_predicted = self.predict(&sample, &interval).is_some() && self.is_valid();
        (!is_predicted).then(|| self.restart_diverged(&before))
    }

    /// The status, where the phase or the innovations decide it rather than the observed
    /// directions.
    fn status(&self) -> Option<Status> {
        if !self.monitor.is_consistent() || self.shift.is_shifted() {
            return Some(Status::Diverged);
        }
        match &self.phase {
            Phase::Aligning if self.aligning.get().is_some_and(Aligning::contradicts_model) => {
                Some(Status::Diverged)
            }
            Phase::Waiting | Phase::Aligning | Phase::Solved(_) => Some(Status::Unobservable),
            Phase::Joining(_) | Phase::Tracking => None,
        }
    }
}

impl<T: Real, F: Form<T>, const W: usize, const P: usize> Estimator<T, W> for JointEkf<T, F, W, P> {
    fn step(&mut self, sample: &Sample<T, W>) -> Outcome {
        self.innovation = None;
        let verdict = self.gate.check(sample);
        let Some(delay_s) = self.considered.delay_s() else {
            return self.step_judged(sample, verdict);
        };
        match verdict {
            Verdict::Rejected(_) => self.step_judged(sample, verdict),
            Verdict::First | Verdict::Gap => {
                self.delay.restart(sample);
                self.step_judged(sample, verdict)
            }
            Verdict::After { elapsed_us } => {
                let shifted = self.delay.shifted(sample, T::seconds(elapsed_us), delay_s);
                self.step_judged(&shifted, verdict)
            }
        }
    }

    fn estimate(&self) -> Estimate<T> {
        let mut covariance = self.form.inertia_covariance();
        let random = core::array::from_fn(|i| covariance.at(i, i).max(T::zero()).sqrt());
        self.considered.add_to(&mut covariance, &self.state.inertia);
        let residual = self.monitor.residual_rms_rad_s();
        let estimate =
            Estimate::of_inertia(self.state.inertia, covariance, &self.range_kg_m2, residual);
        Estimate {
            status: self.status().unwrap_or(estimate.status),
            residuals_white: if self.doubt.is_present() {
                Some(false)
            } else {
                self.whiteness.is_white()
            },
            sigma_random_kg_m2: (!self.considered.is_ideal()).then_some(random),
            ..estimate
        }
    }

    fn rate_rad_s(&self) -> Vec3<T> {
        self.state.rate_rad_s
    }

    fn innovation(&self) -> Option<Innovation<T>> {
        self.innovation
    }

    fn each_of_hardware(&self, visit: &mut dyn FnMut(Finding<T>)) {
        self.considered.each(&self.state.inertia, visit);
    }
}
