//! `ekf-sgf-rls` \[Kim2013\] and `ekf-sgf-lls` \[Kim2016\]: filter, differentiate, regress.
//!
//! ```text
//!  sample ─► rate_ekf ─► savgol ─────────────────────► regression ─► estimate
//!            quieter     rate, torque, wheels and       [G(ω̇) + ω^× G(ω)] j = τ − ḣ_w − ω × h_w
//!            rate        ω̇, ḣ_w of one and the same
//!                        earlier instant
//! ```
//!
//! Two constructors of [`Config`] make the two published systems of the one [`EkfSgf`]. Rate,
//! torque and wheel momentum go through the same window as the derivative, and the same
//! polynomial gives the value of each at its evaluation point (its middle, unless configured
//! otherwise), so that all terms of the equation belong to one instant, between two samples too,
//! and a step of the torque is blurred as the acceleration is. Ours: the papers don't say.
//!
//! What to expect: the rate filter's noise stays in the accelerations, these are the regressor,
//! and so the result is pulled towards zero wherever the acceleration doesn't stand out of that
//! noise. The covariance says how much; nothing here takes it out, as the papers don't. Compare
//! [`momentum_integral`](super::joint_ekf::momentum_integral), which differentiates nothing.
//!
//! Around the chain, as for the other estimators: the sample gate, spikes, lockout, monitor. The
//! last three look at the innovations with their running mean taken off, and so does the residual
//! that is reported: a filter with a nominal inertia lags.

pub mod config;
pub mod rate_ekf;
pub mod regression;

pub use config::{Batch, Config, Readout};

use rate_ekf::RateEkf;
use regression::{Instant, Regression};

use crate::dynamics::interval::{Drive, DriveHistory, Interval};
use crate::dynamics::wheels::WheelArray;
use crate::error::ConfigError;
use crate::estimate::{Estimate, Status};
use crate::estimator::Estimator;
use crate::gate::{Gate, Verdict};
use crate::math::savgol::{Differentiator, Fitted, Pushed};
use crate::math::{Vec3, scalar::Real};
use crate::monitor::innovation::Innovation;
use crate::monitor::innovation::InnovationMonitor;
use crate::outcome::{Coasting, Outcome, Reset};
use crate::sample::Sample;
use crate::tensor::Inertia;

/// Channels of the differentiator: rate, wheel momentum, torque, three axes each.
const CHANNELS: usize = 9;

/// Innovations that the running mean remembers: long beside the filter, short beside the
/// manoeuvre.
const LAG_MEMORY: f64 = 64.0;

/// W wheels; windows of up to C samples.
#[derive(Clone, Debug)]
pub struct EkfSgf<T: Real, const W: usize, const C: usize = 8> {
    config: Config<T>,
    wheels: WheelArray<T, W>,
    gate: Gate<T>,
    drive: DriveHistory<T>,
    rate: RateEkf<T>,
    differentiator: Differentiator<T, CHANNELS, C>,
    sums: Regression<T>,
    /// The sums as they were at the end of the last interval, and when the present one began.
    last_interval: Regression<T>,
    interval_start_us: u64,
    monitor: InnovationMonitor<T>,
    innovation: Option<Innovation<T>>,
    last_instant: Option<Instant<T>>,
    last_delay_s: T,
    /// Running mean of the innovations, rad/s: not zero where the nominal inertia makes the
    /// filter lag.
    mean_innovation_rad_s: Vec3<T>,
    spikes_in_a_row: u16,
}

crate::persist!([T: Real, const W: usize, const C: usize] EkfSgf<T, W, C> {
    config, gate, drive, rate, differentiator, sums, last_interval, interval_start_us, monitor,
    innovation, last_instant, last_delay_s, mean_innovation_rad_s, spikes_in_a_row;
    unchanged wheels
});

impl<T: Real, const W: usize, const C: usize> EkfSgf<T, W, C> {
    /// A chain that waits for its first sample.
    ///
    /// # Errors
    /// Names the configuration's first field that is out of its range.
    pub fn new(config: Config<T>, wheels: WheelArray<T, W>) -> Result<Self, ConfigError> {
        config.validate(C)?;
        let nominal = Inertia::new(config.nominal.inertia_kg_m2);
        let nothing = Regression::new(&config.nominal);
        Ok(Self {
            gate: Gate::new(config.gate),
            drive: DriveHistory::default(),
            rate: RateEkf::new(config.rate_ekf, &nominal)?,
            differentiator: Differentiator::new(
                config.fit,
                config.growth,
                config.period_tolerance,
            )?,
            sums: nothing,
            last_interval: nothing,
            interval_start_us: 0,
            monitor: InnovationMonitor::default(),
            innovation: None,
            last_instant: None,
            last_delay_s: T::zero(),
            mean_innovation_rad_s: Vec3::zeros(),
            spikes_in_a_row: 0,
            config,
            wheels,
        })
    }

    /// What the last sample put into the regression: rate, acceleration and torque of the
    /// evaluation point, if the window was full.
    pub fn last_instant(&self) -> Option<&Instant<T>> {
        self.last_instant.as_ref()
    }

    /// How long before the last sample that instant was, s.
    pub fn last_delay_s(&self) -> T {
        self.last_delay_s
    }

    /// Begins, or begins again, with the nominal inertia and this sample.
    fn begin(&mut self, sample: &Sample<T, W>) {
        let nothing = Regression::new(&self.config.nominal);
        self.sums = nothing;
        self.last_interval = nothing;
        self.interval_start_us = sample.time_us;
        self.spikes_in_a_row = 0;
        self.restart_rate(sample);
    }

    fn restart_rate(&mut self, sample: &Sample<T, W>) {
        let drive = sample.drive(&self.wheels);
        self.drive.restart(drive);
        self.rate.restart(&sample.rate_rad_s);
        self.mean_innovation_rad_s = Vec3::zeros();
        self.differentiator.restart();
        self.differentiate(sample.time_us, &drive);
    }

    fn filter(&mut self, sample: &Sample<T, W>, interval: &Interval<T>) -> Outcome {
        self.rate.predict(interval);
        let innovation = self.rate.innovation(&sample.rate_rad_s);
        self.innovation = Some(innovation);
        // A lag that the nominal inertia causes is no spike, nor does it speak against the
        // estimate, whose covariance has it: both are judged without it.
        let rate_rad_s = innovation.rate_rad_s - self.mean_innovation_rad_s;
        let sudden = Innovation { rate_rad_s, ..innovation };
        let limit = self.config.spike_sigma * self.config.spike_sigma;
        let is_spike = sudden.squared_test_ratio() > limit;
        if is_spike {
            self.monitor.refuse(&sudden);
            self.spikes_in_a_row = self.spikes_in_a_row.saturating_add(1);
            if self.spikes_in_a_row >= self.config.lockout_after {
                self.begin(sample);
                self.monitor.restart();
                return Outcome::Reset(Reset::Lockout);
            }
        } else {
            self.spikes_in_a_row = 0;
            self.monitor.accept(&sudden);
            self.mean_innovation_rad_s += rate_rad_s * T::lit(1.0 / LAG_MEMORY);
            self.rate.update(&sample.rate_rad_s);
        }
        if !self.rate.is_valid() {
            self.begin(sample);
            return Outcome::Reset(Reset::Diverged);
        }
        let is_full = self.differentiate(sample.time_us, &interval.end);
        self.close_interval(sample.time_us);
        match (is_spike, is_full) {
            (true, _) => Outcome::Coasting(Coasting::Spike),
            (false, true) => Outcome::Updated,
            (false, false) => Outcome::Coasting(Coasting::Refilling),
        }
    }

    /// Puts the filtered rate and the drive of this instant into the window, and what comes out
    /// of it into the sums; `false` while nothing does.
    fn differentiate(&mut self, time_us: u64, drive: &Drive<T>) -> bool {
        let (w, h, t) = (self.rate.rate_rad_s(), drive.wheel_momentum_n_m_s, drive.torque_n_m);
        let channels = [w.x, w.y, w.z, h.x, h.y, h.z, t.x, t.y, t.z];
        self.last_instant = match self.differentiator.push(time_us, channels) {
            Pushed::Fitted(fitted) => {
                self.last_delay_s = fitted.delay_s;
                Some(self.instant(&fitted))
            }
            Pushed::Filling | Pushed::Restarted => None,
        };
        let Some(instant) = &self.last_instant else { return false };
        if let Readout::EverySample { forgetting } = self.config.readout {
            self.sums.forget(forgetting);
        }
        self.sums.add(instant)
    }

    /// The equation's terms at the window's evaluation point.
    ///
    /// What noise is left in the filtered rate is a first-order lag of the gyro's: with gain K,
    /// variance `K/(2−K) σ²` and correlation `1 − K` from sample to sample.
    fn instant(&self, fitted: &Fitted<T, CHANNELS>) -> Instant<T> {
        let [wx, wy, wz, hx, hy, hz, tx, ty, tz] = fitted.value;
        let [ax, ay, az, gx, gy, gz, ..] = fitted.derivative_per_s;
        let rate_rad_s = Vec3::new(wx, wy, wz);
        let wheel_momentum = Vec3::new(hx, hy, hz);
        let wheels = Vec3::new(gx, gy, gz) + rate_rad_s.cross(&wheel_momentum);
        let gain = self.rate.mean_gain();
        let share = gain / (T::lit(2.0) - gain);
        let differentiated = self.differentiator.derivative_noise_gain(T::one() - gain);
        let noise = (share * differentiated.max(T::EPSILON)).sqrt() / fitted.period_s;
        Instant {
            rate_rad_s,
            acceleration_rad_s2: Vec3::new(ax, ay, az),
            torque_n_m: Vec3::new(tx, ty, tz) - wheels,
            acceleration_sigma_rad_s2: noise * self.config.rate_ekf.gyro_noise_rad_s,
            imbalance_n_m: self.imbalance_n_m(&rate_rad_s, &wheel_momentum),
        }
    }

    /// What the filter's lag does to the equation. The rate that is left behind is
    /// `e = (1 − K) ν̄`, ν̄ the mean innovation; the left-hand side then misses
    /// `e × (J ω + h_w) + ω × J e`, with the nominal `J`. The lag's own derivative, smaller by
    /// the ratio of its change to the body's turning, is left out.
    fn imbalance_n_m(&self, rate_rad_s: &Vec3<T>, wheel_momentum_n_m_s: &Vec3<T>) -> Vec3<T> {
        let j = Inertia::new(self.config.nominal.inertia_kg_m2).matrix_kg_m2();
        let lag = self.mean_innovation_rad_s * (T::one() - self.rate.mean_gain());
        lag.cross(&(j * rate_rad_s + wheel_momentum_n_m_s)) + rate_rad_s.cross(&(j * lag))
    }

    fn close_interval(&mut self, time_us: u64) {
        let Readout::EveryInterval { interval_us, batch } = self.config.readout else { return };
        if time_us.saturating_sub(self.interval_start_us) < interval_us {
            return;
        }
        self.interval_start_us = time_us;
        self.last_interval = self.sums;
        if batch == Batch::LastInterval {
            self.sums = Regression::new(&self.config.nominal);
        }
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
                Outcome::Reset(Reset::Gap)
            }
            Verdict::After { elapsed_us } => {
                let duration_s = T::seconds(elapsed_us);
                let interval = self.drive.advance(sample.drive(&self.wheels), duration_s);
                self.filter(sample, &interval)
            }
        }
    }

    fn estimate(&self) -> Estimate<T> {
        let sums = match self.config.readout {
            Readout::EverySample { .. } => &self.sums,
            Readout::EveryInterval { .. } => &self.last_interval,
        };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::ekf_sgf::regression::Elements;
    use crate::estimator::test_flight::{TestFlight, tumbling_torque_n_m};
    use crate::gate::Rejection;
    use crate::math::savgol::Fit;
    use crate::prior::Prior;
    use proptest::prelude::*;
    use std::vec::Vec;

    const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
    const NOISE_RAD_S: f64 = 1e-5;
    const PERIOD_US: u64 = 50_000;
    const PERIOD_S: f64 = 0.05;

    fn prior() -> Prior<f32> {
        Prior {
            inertia_kg_m2: [1.2, 1.2, 1.2, 0.0, 0.0, 0.0],
            sigma_kg_m2: [1.0, 1.0, 1.0, 0.5, 0.5, 0.5],
        }
    }

    fn wheel_speed(t: f64) -> f64 {
        100.0 + 50.0 * (0.5 * t).sin()
    }

    fn wheel<T: Real>() -> WheelArray<T, 1> {
        let axis = Vec3::new(T::one(), T::one(), T::zero());
        WheelArray::new([axis], [T::lit(1e-3)]).unwrap()
    }

    /// 100 s of known torques and one wheel that speeds up and down, without noise: 20 Hz.
    fn tumble() -> Vec<Sample<f32, 1>> {
        let flight = TestFlight {
            inertia_kg_m2: INERTIA,
            initial_rate_rad_s: Vec3::new(0.01, -0.02, 0.03),
            wheels: wheel(),
            period_us: PERIOD_US,
            samples: 2000,
        };
        flight.fly(|t| [wheel_speed(t)], tumbling_torque_n_m)
    }

    fn lls() -> EkfSgf<f32, 1> {
        EkfSgf::new(Config::kim_2016(NOISE_RAD_S as f32, prior()), wheel()).unwrap()
    }

    fn rls(elements: Elements) -> EkfSgf<f32, 1> {
        let config = Config { elements, ..Config::kim_2013(NOISE_RAD_S as f32, prior()) };
        EkfSgf::new(config, wheel()).unwrap()
    }

    fn fly(chain: &mut EkfSgf<f32, 1>, samples: &[Sample<f32, 1>]) -> Vec<Outcome> {
        samples.iter().map(|sample| chain.step(sample)).collect()
    }

    fn worst_error(chain: &EkfSgf<f32, 1>) -> f64 {
        let found = chain.estimate().inertia.elements_kg_m2();
        (0..6).map(|i| (f64::from(found[i]) - INERTIA[i]).abs()).fold(0.0, f64::max)
    }

    /// The parabola over six samples of 0.05 s blurs motions of up to 0.9 rad/s by about
    /// (0.9 · 0.3 / 2)² / 6, and the nominal inertia's lag adds as much: kg m² of moments near 1.
    const BLUR: f64 = 1e-2;

    #[test]
    fn lls_converges_on_a_quiet_flight_with_a_wheel() {
        let mut chain = lls();
        let outcomes = fly(&mut chain, &tumble());
        assert_eq!(outcomes[0], Outcome::Reset(Reset::FirstSample));
        assert_eq!(outcomes[1], Outcome::Coasting(Coasting::Refilling));
        assert!(outcomes[6..].iter().all(|o| *o == Outcome::Updated));
        let estimate = chain.estimate();
        assert_eq!((estimate.status, estimate.observed.directions), (Status::Converged, 6));
        assert!(worst_error(&chain) < BLUR, "{:?}", estimate.inertia);
    }

    #[test]
    fn rls_converges_with_six_elements() {
        let mut chain = rls(Elements::All);
        fly(&mut chain, &tumble());
        assert_eq!(chain.estimate().observed.directions, 6);
        assert!(worst_error(&chain) < BLUR, "{:?}", chain.estimate().inertia);
    }

    #[test]
    fn rls_with_three_moments_says_that_products_are_not_seen() {
        let mut chain = rls(Elements::Moments);
        fly(&mut chain, &tumble());
        let estimate = chain.estimate();
        assert_eq!(estimate.observed.element[3..], [false; 3]);
        for k in 0..3 {
            let error = f64::from(estimate.inertia.elements_kg_m2()[k]) - INERTIA[k];
            assert!(error.abs() < 3.0 * f64::from(estimate.sigma_kg_m2()[k]));
        }
    }

    #[test]
    fn lls_says_nothing_before_the_first_interval_ends() {
        let (mut chain, samples) = (lls(), tumble());
        fly(&mut chain, &samples[..800]);
        assert_eq!(chain.estimate().status, Status::Unobservable);
        assert_eq!(chain.estimate().inertia.elements_kg_m2()[0], prior().inertia_kg_m2[0]);
        fly(&mut chain, &samples[800..801]);
        assert_ne!(chain.estimate().status, Status::Unobservable);
    }

    #[test]
    fn each_instant_balances_whatever_the_window() {
        // Also at the newest sample and between two: the terms belong together.
        let j = Inertia::new(INERTIA).matrix_kg_m2();
        for fit in [Fit::centred(6, 2, 1), Fit::centred(7, 2, 1), Fit::newest(5, 3, 1)] {
            let config = Config { fit, ..Config::kim_2016(NOISE_RAD_S as f32, prior()) };
            let mut chain = EkfSgf::<f32, 1>::new(config, wheel()).unwrap();
            let mut worst = 0.0f64;
            for (k, sample) in tumble().iter().enumerate() {
                chain.step(sample);
                let Some(i) = chain.last_instant().filter(|_| k > 200) else { continue };
                let (w, a) = (i.rate_rad_s.map(f64::from), i.acceleration_rad_s2.map(f64::from));
                let balance = j * a + w.cross(&(j * w)) - i.torque_n_m.map(f64::from);
                worst = worst.max(balance.norm());
            }
            // Torques of 0.03 N m; a delay of one sample would cost 1e-3.
            assert!(worst < 3e-4, "{fit:?}: {worst}");
        }
    }

    #[test]
    fn a_spin_about_one_axis_shows_three_elements() {
        // Made up: a body on a bearing about z, the bearing's torque known.
        let j = Inertia::new(INERTIA).matrix_kg_m2();
        let spin = |k: u64| {
            let t = k as f64 * PERIOD_S * 0.2;
            let (w, a) = (Vec3::z() * (0.1 * t.sin()), Vec3::z() * (0.02 * t.cos()));
            let torque = j * a + w.cross(&(j * w));
            Sample {
                time_us: k * PERIOD_US,
                rate_rad_s: w.map(|x: f64| x as f32),
                wheel_speed_rad_s: [0.0],
                torque_n_m: torque.map(|x| x as f32),
                attitude: None,
            }
        };
        let mut chain = lls();
        fly(&mut chain, &(0..2000).map(spin).collect::<Vec<_>>());
        let estimate = chain.estimate();
        assert_eq!(estimate.observed.element, [false, false, true, false, true, true]);
        assert_ne!(estimate.status, Status::Converged);
        for k in [0, 1, 3] {
            let shift = estimate.inertia.elements_kg_m2()[k] - prior().inertia_kg_m2[k];
            assert!(shift.abs() < prior().sigma_kg_m2[k]);
            assert!(estimate.sigma_kg_m2()[k] > 0.5 * prior().sigma_kg_m2[k]);
        }
    }

    #[test]
    fn broken_samples_are_passed_over_for_their_reason() {
        let (mut chain, mut samples) = (lls(), tumble());
        samples[400].rate_rad_s.x = f32::NAN;
        samples[820].rate_rad_s.y += 0.5;
        let outcomes = fly(&mut chain, &samples);
        assert_eq!(outcomes[400], Outcome::Coasting(Coasting::Rejected(Rejection::NotFinite)));
        // A missing sample makes the next interval uneven, and the window fills again.
        assert_eq!(outcomes[401], Outcome::Coasting(Coasting::Refilling));
        assert_eq!(outcomes[406], Outcome::Updated);
        assert_eq!(outcomes[820], Outcome::Coasting(Coasting::Spike));
        assert_eq!(outcomes[821], Outcome::Updated);
        assert!(worst_error(&chain) < BLUR);
    }

    #[test]
    fn a_gap_keeps_the_sums() {
        let (mut chain, samples) = (rls(Elements::All), tumble());
        fly(&mut chain, &samples[..1000]);
        let before = chain.estimate().inertia;
        assert_eq!(chain.step(&samples[1100]), Outcome::Reset(Reset::Gap));
        assert_eq!(chain.estimate().inertia, before);
        assert_eq!(chain.rate_rad_s(), samples[1100].rate_rad_s);
    }

    proptest! {
        #[test]
        fn any_sequence_of_samples_leaves_a_finite_estimate(
            bits in prop::collection::vec((any::<u64>(), prop::array::uniform7(any::<u32>())), 50),
            spoil in 0..900usize,
        ) {
            let mut samples = tumble()[..900].to_vec();
            for (k, (time, values)) in bits.into_iter().enumerate() {
                let [a, b, c, d, e, f, g] = values.map(f32::from_bits);
                let sample = &mut samples[(spoil + 7 * k) % 900];
                if time % 3 == 0 {
                    sample.time_us = time;
                }
                sample.rate_rad_s = Vec3::new(a, b, c);
                sample.torque_n_m = Vec3::new(d, e, f);
                sample.wheel_speed_rad_s = [g];
            }
            for mut chain in [lls(), rls(Elements::Moments)] {
                fly(&mut chain, &samples);
                let estimate = chain.estimate();
                prop_assert!(estimate.inertia.elements_kg_m2().iter().all(|x| x.is_finite()));
                prop_assert!(estimate.covariance_kg2_m4.iter().all(|x| x.is_finite()));
                prop_assert!(chain.rate_rad_s().iter().all(|x| x.is_finite()));
            }
        }
    }
}
