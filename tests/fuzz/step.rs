//! `step` of the estimators that fly, with any configuration that is accepted and any samples.

use fsw_core::estimator::ekf_sgf::EkfSgf;
use fsw_core::estimator::joint_ekf::{self, JointEkfUd};
use fsw_core::estimator::window::{self, Window};
use fsw_core::estimator::{Estimator, ekf_sgf};
use fsw_core::hardware::{Disturbance, Hardware};
use fsw_core::{Mat, Prior, Sample, Status, Vec3, WheelArray, gate};
use fsw_target::flight::craft::WHEELS;
use rand::RngExt;
use rand_pcg::Pcg64;

use super::numbers::Numbers;
use super::{Executed, once_in, one_of};

/// Samples of a case, and of one case in fifty.
const SAMPLES: usize = 200;
const MANY_SAMPLES: usize = 10_000;
/// Samples between two judgements of the estimate.
const JUDGED: usize = 20;

/// A window of the smallest storage, which fills within a case: all groups of unknowns.
pub type SmallWindow = Window<f32, WHEELS, 64, 27, 7>;
/// The filter as it flies.
pub type Filter = JointEkfUd<f32, WHEELS, 24>;
/// The regression as it flies.
pub type Regression = EkfSgf<f32, WHEELS>;

/// Inertia, motion and noise of a case: their magnitudes.
pub struct Case {
    numbers: Numbers,
    inertia_kg_m2: f32,
    rate_rad_s: f32,
    noise_rad_s: f32,
    period_us: u64,
}

impl Case {
    /// Draws the magnitudes.
    pub fn new(random: &mut Pcg64) -> Self {
        let numbers = Numbers::new(random);
        let usual = Numbers::of_usual();
        Self {
            numbers,
            inertia_kg_m2: usual.between(random, 1e-6, 1e6),
            rate_rad_s: usual.between(random, 1e-4, 30.0),
            noise_rad_s: usual.between(random, 1e-7, 1e-1),
            period_us: one_of(random, &[1_000, 10_000, 100_000, 100_000, 1_000_000]),
        }
    }

    /// True where no number is extreme.
    fn is_plausible(&self) -> bool {
        self.numbers.are_usual()
    }

    /// Wheels; none in one case of four.
    pub fn wheels(&self, random: &mut Pcg64) -> Option<WheelArray<f32, WHEELS>> {
        let axes = std::array::from_fn(|_| Vec3::from_fn(|_, _| self.numbers.of(random, 1.0)));
        let is_absent = once_in(random, 4);
        let spin_kg_m2 = std::array::from_fn(|_| {
            if is_absent {
                0.0
            } else {
                self.numbers.between(random, 1e-5, 1e-2) * self.inertia_kg_m2
            }
        });
        WheelArray::new(axes, spin_kg_m2).ok()
    }

    fn prior(&self, random: &mut Pcg64) -> Prior<f32> {
        let j = self.inertia_kg_m2;
        let moment = |random: &mut Pcg64| self.numbers.between(random, 0.7, 1.3) * j;
        let product = |random: &mut Pcg64| self.numbers.of(random, 0.1 * j);
        Prior {
            inertia_kg_m2: [
                moment(random),
                moment(random),
                moment(random),
                product(random),
                product(random),
                product(random),
            ],
            sigma_kg_m2: std::array::from_fn(|_| self.numbers.between(random, 1e-3, 10.0) * j),
        }
    }

    fn some_prior(&self, random: &mut Pcg64) -> Option<Prior<f32>> {
        random.random::<bool>().then(|| self.prior(random))
    }

    /// Stated errors of the hardware.
    pub fn hardware(&self, random: &mut Pcg64) -> Hardware<f32, WHEELS> {
        let mut share = |most: f32| {
            if once_in(random, 2) { 0.0 } else { self.numbers.between(random, 1e-4 * most, most) }
        };
        Hardware {
            gyro_scale: share(0.1),
            gyro_axes_rad: share(0.1),
            delay_s: share(0.05),
            delay_sigma_s: share(0.01),
            wheel_inertia: [share(0.1); WHEELS],
            wheel_axis_rad: [share(0.1); WHEELS],
            common_wheel_inertia: share(0.1),
            torque_scale: share(0.2),
            clock: share(0.01),
            mount_rad: [share(0.1); 3],
        }
    }

    fn gate(&self, random: &mut Pcg64) -> gate::Config<f32> {
        if !once_in(random, 4) {
            return gate::Config::default();
        }
        gate::Config {
            range_rad_s: self.numbers.between(random, 0.1, 1e4),
            max_gap_us: one_of(random, &[0, 1, 1_000_000, u64::MAX]),
            stuck_after: random.random(),
        }
    }

    /// Configuration of a window.
    pub fn window(&self, random: &mut Pcg64) -> window::Config<f32, WHEELS> {
        let numbers = &self.numbers;
        let mut some = |least: f32, most: f32| {
            random.random::<bool>().then(|| numbers.between(random, least, most))
        };
        let noise = self.noise_rad_s;
        let (disturbance_torque_n_m, gyro_bias_rad_s, drag_per_s) =
            (some(1e-8, 1.0), some(1e-6, 0.1), some(1e-9, 1e-2));
        let gyro_noise_rad_s = some(noise, 2.0 * noise);
        window::Config {
            prior: self.some_prior(random),
            gyro_noise_rad_s,
            disturbance_torque_n_m,
            varying_torque_n_m: numbers.between(random, 1e-9, 1e-3),
            gyro_bias_rad_s,
            bias_walk_rad_s_sqrt_s: numbers.between(random, 1e-9, 1e-3),
            bias_instability_rad_s: numbers.between(random, 1e-9, 1e-3),
            drag_per_s,
            inertia_walk_kg_m2_sqrt_s: self.inertia_kg_m2 * numbers.between(random, 1e-9, 1e-2),
            block_samples: one_of(random, &[0, 1, 1, 2, 4, 10, u32::MAX]),
            block_turn_rad: numbers.between(random, 1e-3, 2.0),
            is_torque_smooth: random.random(),
            slices_per_step: one_of(random, &[0, 1, 2, 4]),
            quiet_s: numbers.between(random, 1e-2, 100.0),
            hardware: self.hardware(random),
            modes: [None; window::unknowns::MOST_MODES],
            gate: self.gate(random),
        }
    }

    /// Configuration of the filter.
    pub fn filter(&self, random: &mut Pcg64) -> joint_ekf::Config<f32> {
        let numbers = &self.numbers;
        let walk = numbers.between(random, 1e-9, 1e-2) * self.inertia_kg_m2;
        joint_ekf::Config {
            prior: self.some_prior(random),
            rate_walk_rad_s_sqrt_s: numbers.between(random, 1e-9, 1e-2),
            inertia_walk_kg_m2_sqrt_s: if once_in(random, 2) { [0.0; 6] } else { [walk; 6] },
            gate: self.gate(random),
            ..joint_ekf::Config::new(numbers.between(random, 0.1, 10.0) * self.noise_rad_s)
        }
    }

    /// Configuration of the regression.
    pub fn regression(&self, random: &mut Pcg64) -> ekf_sgf::Config<f32> {
        let noise = self.numbers.between(random, 0.1, 10.0) * self.noise_rad_s;
        let config = ekf_sgf::Config::kim_2013(noise, self.prior(random));
        ekf_sgf::Config {
            gate: self.gate(random),
            period_tolerance: self.numbers.between(random, 0.01, 1.0),
            ..config
        }
    }

    /// The next sample: a motion with noise, and any content now and then.
    fn sample(&self, random: &mut Pcg64, k: usize, time_us: &mut u64) -> Sample<f32, WHEELS> {
        let numbers = &self.numbers;
        *time_us = match numbers.is_extreme(random) {
            true => one_of(random, &[0, 1, *time_us, u64::MAX, time_us.wrapping_mul(3)]),
            false => time_us.saturating_add(self.period_us),
        };
        let phase = k as f32 * 0.1;
        let motion = |axis: usize| self.rate_rad_s * (phase * (1.0 + axis as f32 * 0.37)).sin();
        Sample {
            time_us: *time_us,
            rate_rad_s: Vec3::from_fn(|axis, _| {
                motion(axis) + numbers.of(random, self.noise_rad_s)
            }),
            wheel_speed_rad_s: std::array::from_fn(|wheel| {
                300.0 * (phase * (0.5 + wheel as f32 * 0.21)).sin() + numbers.of(random, 0.1)
            }),
            torque_n_m: Vec3::from_fn(|_, _| {
                numbers.of(random, 0.1 * self.inertia_kg_m2 * self.rate_rad_s)
            }),
            attitude: None,
        }
    }

    /// Steps an estimator through the samples of a case.
    ///
    /// # Errors
    /// The finding: an estimate that is not finite, or converged and not physical.
    pub fn fly(&self, random: &mut Pcg64, estimator: &mut dyn Estimator<f32, WHEELS>) -> Executed {
        let mut time_us = random.random_range(0..2_000_000);
        let samples = if once_in(random, 50) { MANY_SAMPLES } else { SAMPLES };
        for k in 0..samples {
            let sample = self.sample(random, k, &mut time_us);
            let outcome = estimator.step(&sample);
            if k % JUDGED == 0 || !estimator.rate_rad_s().iter().all(|x| x.is_finite()) {
                judge(estimator)
                    .map_err(|why| format!("{why}, {outcome:?} at {k} of {sample:?}"))?;
            }
        }
        estimator.finish();
        judge(estimator)?;
        Ok(samples as u64)
    }
}

/// Steps an estimator that accepts the configuration.
pub fn execute(random: &mut Pcg64) -> Executed {
    let case = Case::new(random);
    let Some(wheels) = case.wheels(random) else { return Ok(0) };
    let (name, executed) = match random.random_range(0..4) {
        0 => {
            let window = SmallWindow::new(case.window(random), wheels);
            ("window", window.map(|mut window| case.fly(random, &mut window)))
        }
        1 => {
            let regression = Regression::new(case.regression(random), wheels);
            ("ekf-sgf-rls", regression.map(|mut regression| case.fly(random, &mut regression)))
        }
        _ => {
            let (config, hardware) = (case.filter(random), case.hardware(random));
            let filter = Filter::considering(config, wheels, &hardware, &Disturbance::none());
            ("joint-ekf", filter.map(|mut filter| case.fly(random, &mut filter)))
        }
    };
    // A configuration that is rejected is no execution.
    executed.unwrap_or(Ok(0)).map_err(|why| {
        let numbers = if case.is_plausible() { "usual" } else { "extreme" };
        format!("{name}, {numbers} numbers, {:.1e} kg m²: {why}", case.inertia_kg_m2)
    })
}

/// Asymmetry by rounding, and least eigenvalue of the correlations: some roundings of products of six elements.
const ROUNDINGS: f64 = 1e3 * f32::EPSILON as f64;

/// Symmetric and not negative, in units of the sigmas.
fn judge_covariance(covariance: &Mat<f32, 6, 6>) -> Result<(), String> {
    let covariance = covariance.map(f64::from);
    let sigmas = covariance.diagonal().map(|variance| variance.max(0.0).sqrt());
    let of_unit = |i: usize, k: usize| match sigmas[i] * sigmas[k] {
        product if product > 0.0 => covariance[(i, k)] / product,
        _ => 0.0,
    };
    let correlations = Mat::<f64, 6, 6>::from_fn(of_unit);
    let asymmetry = (correlations - correlations.transpose()).amax();
    let least = correlations.symmetric_eigenvalues().min();
    if covariance.diagonal().min() < 0.0 || asymmetry > ROUNDINGS || least < -ROUNDINGS {
        return Err(format!("covariance: asymmetry {asymmetry:e}, least {least:e}, {sigmas:?}"));
    }
    Ok(())
}

/// Checks of an estimate.
///
/// # Errors
/// The first that does not hold.
pub fn judge(estimator: &dyn Estimator<f32, WHEELS>) -> Result<(), String> {
    let estimate = estimator.estimate();
    let elements = estimate.inertia.elements_kg_m2();
    let covariance = estimate.covariance_kg2_m4;
    if !elements.iter().all(|x| x.is_finite()) {
        return Err(format!("an element is not finite: {elements:?}"));
    }
    if !estimator.rate_rad_s().iter().all(|x| x.is_finite()) {
        return Err(format!("the rate is not finite: {:?}", estimator.rate_rad_s()));
    }
    if !covariance.iter().all(|x| x.is_finite()) {
        return Err(format!("the covariance is not finite: {covariance:?}"));
    }
    judge_covariance(&covariance)?;
    if estimate.status == Status::Converged && estimate.inertia.check().is_err() {
        return Err(format!("converged and not physical: {elements:?}"));
    }
    Ok(())
}
