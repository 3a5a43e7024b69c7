//! `ekf-sgf-rls` \[Kim2013\] and `ekf-sgf-lls` \[Kim2016\]: filter, differentiate, regress.
//!
//! ```text
//!  sample ─► gate ─► rate_ekf ─► spike gate ─► savgol ─────────────► regression ─► estimate
//!                    ω̂, ν                     ω, h_w, τ and          [G(ω̇) + ω^× G(ω)] j
//!                                             ω̇, ḣ_w at one          = τ − ḣ_w − ω × h_w
//!                                             earlier instant
//! ```
//!
//! Two constructors of [`Config`] make the two published systems of the one [`EkfSgf`]:
//! [`Config::kim_2013`] and [`Config::kim_2016`].
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `ω̂`, `ω` | filtered rate; its value at the evaluation point | rad/s |
//! | `ω̇` | derivative of the polynomial there | rad/s² |
//! | `ν` | innovation of the rate filter | rad/s |
//! | `τ` | external torque, body axes | N m |
//! | `h_w`, `ḣ_w` | momentum of the wheels, its derivative | N m s, N m |
//! | `j` | six elements `Jxx Jyy Jzz Jxy Jxz Jyz` | kg m² |
//! | `G(v)` | regressor, `J v = G(v) j` | that of v |
//!
//! # Restarts
//!
//! | event | state afterwards | outcome |
//! |---|---|---|
//! | first sample | nominal inertia, empty sums | [`Reset::FirstSample`] |
//! | gap longer than `gate.max_gap_us` | rate of the sample; sums unchanged | [`Reset::Gap`], [`Reset::Clock`] |
//! | lock-out: spikes in a row | nominal inertia, empty sums | [`Reset::Lockout`] |
//! | a number not finite | nominal inertia, empty sums | [`Reset::Diverged`] |
//! | uneven sample interval | empty window; sums unchanged | [`Coasting::Refilling`] |
//!
//! # Departures from the papers
//!
//! * Rate, torque and wheel momentum go through the same window as the derivative, and the same
//!   polynomial gives the value of each at its evaluation point, by default the middle of the
//!   window. All terms of the equation then belong to one instant, between two samples too, and a
//!   step of the torque is smoothed as the acceleration is. The papers leave the pairing open.
//! * Wheels: the papers have none.
//! * The gate, the spike gate, the monitor, and a covariance of the six elements.
//!
//! # Accuracy
//!
//! Reported for the STSAT-3 spin-up: \[Kim2013\] errors of the moments of 2.4 to 2.6 % at the end,
//! \[Kim2016\] errors of all six elements within 1 % after about 440 s. Both depend on the process
//! noise of the rate filter, which the papers leave open.
//!
//! The rate filter's remaining noise enters the accelerations, and with them the regressor. The
//! solution is therefore biased towards zero wherever the acceleration does not stand out of that
//! noise. The covariance contains this bias; as in the papers, nothing removes it.
//! [`alignment`](super::joint_ekf::alignment) avoids differentiation altogether.
//!
//! A filter with a nominal inertia lags by the steady part of its innovations. Spike gate, monitor
//! and reported residual all take the innovations with their running mean removed.
//!
//! # Example
//!
//! ```
//! use fsw_core::estimator::ekf_sgf::{Config, EkfSgf};
//! use fsw_core::{Estimator, Outcome, Sample, Vec3, WheelArray};
//!
//! // Nominal inertia half of the true moments, gyro noise 1e-4 rad/s, no wheels.
//! let config = Config::kim_2013(1e-4f32, Config::half_of([14.2, 17.3, 20.3]));
//! let mut estimator = EkfSgf::<f32, 0>::new(config, WheelArray::new([], [])?)?;
//! let mut outcome = None;
//! for k in 0..20 {
//!     outcome = Some(estimator.step(&Sample {
//!         time_us: 100_000 * k,
//!         rate_rad_s: Vec3::new(0.0, 0.0, 1e-5 * k as f32),
//!         wheel_speed_rad_s: [],
//!         torque_n_m: Vec3::new(0.0, 0.0, 2e-3),
//!         attitude: None,
//!     }));
//! }
//! assert_eq!(outcome, Some(Outcome::Updated));
//! assert!(estimator.last_instant().is_some());
//! # Ok::<(), fsw_core::ConfigError>(())
//! ```

mod batches;
pub mod config;
mod instant;
mod lag;
pub mod rate_ekf;
pub mod regression;
#[cfg(test)]
mod tests;

pub use config::{Batch, Config, Readout};

use batches::Batches;
use lag::Lag;
use rate_ekf::RateEkf;
use regression::Instant;

use crate::dynamics::interval::{Drive, DriveHistory, Interval};
use crate::dynamics::wheels::WheelArray;
use crate::error::ConfigError;
use crate::estimate::{Estimate, Status};
use crate::estimator::Estimator;
use crate::gate::{Gate, Verdict};
use crate::math::savgol::{Differentiator, Pushed};
use crate::math::{Vec3, scalar::Real};
use crate::monitor::innovation::{Innovation, InnovationMonitor};
use crate::monitor::spikes::{Decision, SpikeGate};
use crate::outcome::{Coasting, Outcome, Reset};
use crate::sample::Sample;
use crate::tensor::Inertia;

/// Channels of the differentiator: rate, wheel momentum, torque, three axes each.
const CHANNELS: usize = 9;

/// W wheels; windows of up to C samples.
#[derive(Clone, Debug)]
pub struct EkfSgf<T: Real, const W: usize, const C: usize = 8> {
    config: Config<T>,
    wheels: WheelArray<T, W>,
    gate: Gate<T>,
    /// Torque and wheel momentum at the last samples.
    drive: DriveHistory<T>,
    /// Rate filter.
    rate: RateEkf<T>,
    /// Steady part of its innovations.
    lag: Lag<T>,
    differentiator: Differentiator<T, CHANNELS, C>,
    batches: Batches<T>,
    spikes: SpikeGate,
    monitor: InnovationMonitor<T>,
    /// Innovation of the last sample, if that was predicted; the lag included.
    innovation: Option<Innovation<T>>,
    /// Terms that the last sample added, if its window was full enough.
    last_instant: Option<Instant<T>>,
    /// Age of that instant at the last sample.
    last_delay_s: T,
}

crate::persist!([T: Real, const W: usize, const C: usize] EkfSgf<T, W, C> {
    config, gate, drive, rate, lag, differentiator, batches, spikes, monitor, innovation,
    last_instant, last_delay_s;
    unchanged wheels
});

impl<T: Real, const W: usize, const C: usize> EkfSgf<T, W, C> {
    /// An estimator that waits for its first sample.
    ///
    /// # Errors
    /// Names the configuration's first field that is out of its range.
    pub fn new(config: Config<T>, wheels: WheelArray<T, W>) -> Result<Self, ConfigError> {
        let rate = Self::check(&config)?;
        Ok(Self::of_valid(config, &rate, wheels))
    }

    /// Checks a configuration. Returns its rate filter before the first sample.
    ///
    /// # Errors
    /// Names the configuration's first field that is out of its range.
    pub fn check(config: &Config<T>) -> Result<RateEkf<T>, ConfigError> {
        config.validate(C)?;
        RateEkf::new(config.rate_ekf, &Inertia::new(config.nominal.inertia_kg_m2))
    }

    /// As [`new`](Self::new), for a configuration that has passed [`check`](Self::check), and the rate
    /// filter that this returned. Inlined, so that the estimator is built in its place and not on the
    /// stack.
    #[inline(always)]
    pub fn of_valid(config: Config<T>, rate: &RateEkf<T>, wheels: WheelArray<T, W>) -> Self {
        Self {
            gate: Gate::new(config.gate),
            drive: DriveHistory::default(),
            rate: *rate,
            lag: Lag::default(),
            differentiator: Differentiator::of_valid(
                config.fit,
                config.growth,
                config.period_tolerance,
            ),
            batches: Batches::new(&config.nominal, 0),
            spikes: SpikeGate::default(),
            monitor: InnovationMonitor::default(),
            innovation: None,
            last_instant: None,
            last_delay_s: T::zero(),
            config,
            wheels,
        }
    }

    /// The equation's terms that the last sample added to the regression: rate, acceleration and
    /// torque at the evaluation point. `None` while the window fills.
    pub fn last_instant(&self) -> Option<&Instant<T>> {
        self.last_instant.as_ref()
    }

    /// Age of that instant at the last sample, s.
    pub fn last_delay_s(&self) -> T {
        self.last_delay_s
    }

    /// One step: predict, innovation, spike gate, update, differentiate, regress.
    ///
    /// Spike gate and monitor use the innovation minus its running mean, the lag that the nominal
    /// inertia causes. The covariance contains the lag.
    fn filter(&mut self, sample: &Sample<T, W>, interval: &Interval<T>) -> Outcome {
        self.rate.predict(interval);
        let innovation = self.rate.innovation(&sample.rate_rad_s);
        self.innovation = Some(innovation);
        let without_lag = self.lag.removed_from(&innovation);
        let decision = self.spikes.judge(without_lag.squared_test_ratio(), &self.config.spikes);
        match decision {
            Decision::Accept => self.update(sample, &without_lag),
            Decision::Reject => self.monitor.refuse(&without_lag),
            Decision::LockOut => {
                self.monitor.refuse(&without_lag);
                return self.restart_locked_out(sample);
            }
        }
        if !self.rate.is_valid() {
            self.begin(sample);
            return Outcome::Reset(Reset::Diverged);
        }
        let is_regressed = self.regress(sample.time_us, &interval.end);
        match (decision, is_regressed) {
            (Decision::Accept, true) => Outcome::Updated,
            (Decision::Accept, false) => Outcome::Coasting(Coasting::Refilling),
            (Decision::Reject | Decision::LockOut, _) => Outcome::Coasting(Coasting::Spike),
        }
    }

    /// Correction of the rate filter by an accepted sample.
    fn update(&mut self, sample: &Sample<T, W>, without_lag: &Innovation<T>) {
        self.monitor.accept(without_lag);
        self.lag.update(without_lag);
        self.rate.update(&sample.rate_rad_s);
    }

    /// Differentiates, and adds the result to the regression; `false` where there is none.
    fn regress(&mut self, time_us: u64, drive: &Drive<T>) -> bool {
        self.differentiate(time_us, drive);
        let (readout, nominal) = (&self.config.readout, &self.config.nominal);
        let is_added = match &self.last_instant {
            Some(instant) => self.batches.add(instant, readout),
            None => false,
        };
        self.batches.close_interval(time_us, readout, nominal);
        is_added
    }

    /// Pushes the filtered rate and the drive into the window: nine channels, whose values and
    /// derivatives all belong to the same instant.
    fn differentiate(&mut self, time_us: u64, drive: &Drive<T>) {
        let (w, h, t) = (self.rate.rate_rad_s(), drive.wheel_momentum_n_m_s, drive.torque_n_m);
        let channels = [w.x, w.y, w.z, h.x, h.y, h.z, t.x, t.y, t.z];
        self.last_instant = match self.differentiator.push(time_us, channels) {
            Pushed::Fitted(fitted) => {
                self.last_delay_s = fitted.delay_s;
                Some(self.instant(&fitted))
            }
            Pushed::Filling | Pushed::Restarted => None,
        };
    }

    /// Starts, or starts again, from the nominal inertia and this sample.
    fn begin(&mut self, sample: &Sample<T, W>) {
        self.batches = Batches::new(&self.config.nominal, sample.time_us);
        self.spikes.restart();
        self.restart_rate(sample);
    }

    /// Starts the rate from this sample; the regression keeps its sums.
    fn restart_rate(&mut self, sample: &Sample<T, W>) {
        let drive = sample.drive(&self.wheels);
        self.drive.restart(drive);
        self.rate.restart(&sample.rate_rad_s);
        self.lag = Lag::default();
        self.differentiator.restart();
        self.differentiate(sample.time_us, &drive);
    }

    /// After a lock-out everything restarts, the record of the innovations included.
    fn restart_locked_out(&mut self, sample: &Sample<T, W>) -> Outcome {
        self.begin(sample);
        self.monitor.restart();
        Outcome::Reset(Reset::Lockout)
    }
}

impl<T: Real, const W: usize, const C: usize> Estimator<T, W> for EkfSgf<T, W, C> {
    fn step(&mut self, sample: &Sample<T, W>) -> Outcome {
        self.innovation = None;
        match self.gate.check(sample) {
            Verdict::Rejected(why) => Outcome::Coasting(Coasting::Rejected(why)),
            Verdict::First => {
                self.begin(sample);
                Outcome::Reset(Reset::FirstSample)
            }
            Verdict::Gap => {
                self.restart_rate(sample);
                Outcome::Reset(self.gate.cause_of_gap().into())
            }
            Verdict::After { elapsed_us } => {
                let duration_s = T::seconds(elapsed_us);
                let interval = self.drive.advance(sample.drive(&self.wheels), duration_s);
                self.filter(sample, &interval)
            }
        }
    }

    fn estimate(&self) -> Estimate<T> {
        let sums = self.batches.read_out(&self.config.readout);
        let solution = sums.solve(self.config.elements, &self.config.nominal);
        let estimate = Estimate::of_inertia(
            solution.inertia,
            solution.covariance_kg2_m4,
            &self.config.nominal.sigma_kg_m2,
            self.monitor.residual_rms_rad_s(),
        );
        if self.monitor.is_consistent() {
            estimate
        } else {
            Estimate { status: Status::Diverged, ..estimate }
        }
    }

    fn rate_rad_s(&self) -> Vec3<T> {
        self.rate.rate_rad_s()
    }

    fn innovation(&self) -> Option<Innovation<T>> {
        self.innovation
    }
}
