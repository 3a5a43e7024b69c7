//! The flight core behind one face: whichever estimator, precision and number of wheels.
//!
//! Everything here is `f64` until a sample crosses into the core, where it is rounded once to the
//! precision that flies.

use std::fmt;
use std::marker::PhantomData;

use clap::ValueEnum;
use fsw_core::estimator::ekf_sgf::{self, EkfSgf};
use fsw_core::estimator::joint_ekf::{self, InitialRate, JointEkfPublished, JointEkfUd};
use fsw_core::estimator::momentum::{self, Momentum};
use fsw_core::estimator::window::{self, Window};
use fsw_core::gate;
use fsw_core::outcome::OutcomeCounts;
use fsw_core::{
    ConfigError, Estimate, Estimator, Inertia, Outcome, Quaternion, Real, Sample, Vec3, WheelArray,
};
use fsw_core::{Innovation, Prior};
use nalgebra::Vector3;
use thiserror::Error;

use crate::input::Craft;
use crate::input::craft::SolveFor;
use crate::input::log::LogRow;

/// The estimators by the names that others rely on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EstimatorName {
    /// Our own: each manoeuvre fitted as a whole, at the Cramér-Rao bound.
    Window,
    /// Nine-state filter in UD form: in the flight image too.
    JointEkf,
    /// The same filter as Bellar and Si Mohammed (2019) print it.
    JointEkfPublished,
    /// The UD form started as the printed one is, at once on its prior: only the numerics differ.
    JointEkfUnaligned,
    /// Rate filter, causal Savitzky-Golay, recursive least squares for three moments: Kim et al. 2013.
    EkfSgfRls,
    /// Rate filter, even-window Savitzky-Golay, batch least squares for six elements: Kim et al. 2016.
    EkfSgfLls,
    /// Conservation of momentum, least squares for all elements at once: Kim et al. 2010.
    MomentumBatch,
    /// The same by one axis at a time, as before Kim et al. 2010.
    MomentumConventional,
    /// The same with products that take earlier products into account: Kim et al. 2010, as a comparison.
    MomentumPreEstimate,
    /// The same with products that take the moments into account: what Kim et al. 2010 suggest.
    MomentumSuggested,
}

impl EstimatorName {
    /// Whether it can be left to find the gyro's noise while it estimates.
    pub fn measures_gyro_noise(self) -> bool {
        self == Self::Window
    }

    /// Whether it can solve for a disturbance torque and the gyro's bias.
    pub fn solves_for_disturbances(self) -> bool {
        self == Self::Window
    }

    /// Whether it can't work without the attitude.
    pub fn needs_attitude(self) -> bool {
        match self {
            Self::Window
            | Self::JointEkf
            | Self::JointEkfPublished
            | Self::JointEkfUnaligned
            | Self::EkfSgfRls
            | Self::EkfSgfLls => false,
            Self::MomentumBatch
            | Self::MomentumConventional
            | Self::MomentumPreEstimate
            | Self::MomentumSuggested => true,
        }
    }
}

/// The arithmetic of the flight core.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Precision {
    /// Single: what flies.
    F32,
    /// Double.
    F64,
}

impl fmt::Display for EstimatorName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Window => "window",
            Self::JointEkf => "joint-ekf",
            Self::JointEkfPublished => "joint-ekf-published",
            Self::JointEkfUnaligned => "joint-ekf-unaligned",
            Self::EkfSgfRls => "ekf-sgf-rls",
            Self::EkfSgfLls => "ekf-sgf-lls",
            Self::MomentumBatch => "momentum-batch",
            Self::MomentumConventional => "momentum-conventional",
            Self::MomentumPreEstimate => "momentum-pre-estimate",
            Self::MomentumSuggested => "momentum-suggested",
        })
    }
}

impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
        })
    }
}

/// An estimator could not be set up.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SetUpError {
    /// The core refused its configuration.
    #[error("the estimator refuses its configuration: {0}")]
    Config(#[from] ConfigError),
    /// An estimator that filters the rate with a nominal inertia, and none is given.
    #[error(
        "{estimator} needs a nominal inertia: add a [prior] with inertia_kg_m2 = [jxx, jyy, jzz, \
         jxy, jxz, jyz] and sigma_kg_m2 of each"
    )]
    NoNominalInertia {
        /// Which.
        estimator: EstimatorName,
    },
    /// An estimator that must be told the gyro's noise, and isn't.
    #[error("{estimator} must be told the gyro's noise: give noise_rad_s under [gyro]")]
    NoGyroNoise {
        /// Which.
        estimator: EstimatorName,
    },
    /// An estimator that conserves momentum in inertial space, and a log that doesn't tell where
    /// that is.
    #[error(
        "{estimator} needs the attitude: add the columns attitude_q1, attitude_q2, attitude_q3, \
         attitude_q4 to the log (inertial to body axes, scalar last)"
    )]
    NoAttitude {
        /// Which.
        estimator: EstimatorName,
    },
    /// A craft with more wheels than the core is compiled for here.
    #[error("{found} wheels: the estimators are compiled for at most 8")]
    TooManyWheels {
        /// How many the craft has.
        found: usize,
    },
}

/// An estimator of the flight core in double-precision clothes.
pub trait AnyEstimator {
    /// Takes in one sample.
    fn step(&mut self, row: &LogRow) -> Outcome;
    /// What is known by now.
    fn estimate(&self) -> Estimate<f64>;
    /// Filtered body rate, rad/s.
    fn rate_rad_s(&self) -> Vector3<f64>;
    /// Innovation of the last sample, if it had one.
    fn innovation(&self) -> Option<Innovation<f64>>;
    /// One sigma of the filtered rate by the filter's own covariance, rad/s, if the last sample
    /// had an innovation. With the identity as measurement matrix, and axis by axis, the variance
    /// after the sample is `(S − R) R / S`, S the innovation's variance and R the gyro's.
    fn rate_sigma_rad_s(&self) -> Option<Vector3<f64>>;
    /// Angular acceleration that the last sample completed, if the estimator makes one.
    fn acceleration(&self) -> Option<Acceleration>;
}

/// Angular acceleration at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acceleration {
    /// Derivative of the filtered rate, body axes, rad/s².
    pub rad_s2: Vector3<f64>,
    /// How long before the last sample that instant was, s.
    pub delay_s: f64,
}

/// What an estimator needs to be told of the craft.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup<'a> {
    /// Which estimator.
    pub estimator: EstimatorName,
    /// In which arithmetic.
    pub precision: Precision,
    /// The craft.
    pub craft: &'a Craft,
    /// Gyro noise, one sigma per sample, rad/s: the craft's, or measured from the log. None: the
    /// estimator measures it itself, if it can.
    pub gyro_noise_rad_s: Option<f64>,
    /// The typical time between samples, s.
    pub sample_period_s: f64,
    /// Whether samples far from their prediction are passed over. Not while the noise itself is
    /// being looked for.
    pub refuse_spikes: bool,
}

/// After so many sample periods without a usable sample (and at least the core's default), a gap
/// is no longer bridged by prediction.
const BRIDGED_PERIODS: f64 = 10.0;

/// Blocks that the window estimator stores.
const WINDOW_BLOCKS: usize = 512;
/// A gyro that is sampled faster than four times in this, s, is averaged over it: a body turns little
/// in so short a time, and vibration is faster.
const SHORTEST_BLOCK_S: f64 = 2e-3;
/// Its unknowns: momentum, inertia and torque, which is tested for where it isn't asked for; and gyro
/// bias and drag as well.
const WITH_TORQUE: usize = 12;
const WITH_DRAG: usize = 18;
/// Ranges, one sigma, that hold a disturbance torque and a gyro bias where the motion doesn't show
/// them: more than any disturbance of a small spacecraft, and than the bias of a consumer gyro
/// (3 deg/s).
const TORQUE_RANGE_N_M: f64 = 0.1;
const BIAS_RANGE_RAD_S: f64 = 0.05;

/// The estimator that was asked for.
pub fn set_up(setup: &Setup<'_>) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    match setup.precision {
        Precision::F32 => with_wheels::<f32>(setup),
        Precision::F64 => with_wheels::<f64>(setup),
    }
}

/// Compiled for no wheels, four and eight, which keeps the build short. What a craft has fewer is
/// filled up with wheels that stand still: they add exactly zero to the momentum, so that every bit
/// is as with the exact number.
fn with_wheels<T: Real>(setup: &Setup<'_>) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    match setup.craft.wheels.len() {
        0 => by_name::<T, 0>(setup),
        1..=4 => by_name::<T, 4>(setup),
        5..=8 => by_name::<T, 8>(setup),
        found => Err(SetUpError::TooManyWheels { found }),
    }
}

fn by_name<T: Real, const W: usize>(
    setup: &Setup<'_>,
) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    let wheel = |i: usize| setup.craft.wheels.get(i);
    let wheels = WheelArray::<T, W>::new(
        std::array::from_fn(|i| wheel(i).map_or_else(Vec3::x, |w| narrow(&w.axis))),
        std::array::from_fn(|i| wheel(i).map_or(T::one(), |w| T::lit(w.spin_inertia_kg_m2))),
    )?;
    Ok(match setup.estimator {
        EstimatorName::Window if setup.craft.solve_for == SolveFor::default() => {
            window::<T, W, WITH_TORQUE>(setup, wheels)?
        }
        EstimatorName::Window => window::<T, W, WITH_DRAG>(setup, wheels)?,
        EstimatorName::JointEkf => {
            let config = configure(joint_ekf::Config::new(gyro_noise_rad_s(setup)?), setup);
            Box::new(Adapter::<T, _, W>::new(JointEkfUd::new(config, wheels)?, setup))
        }
        EstimatorName::JointEkfPublished => {
            let filter = JointEkfPublished::new(bellar_2019(setup)?, wheels)?;
            Box::new(Adapter::<T, _, W>::new(filter, setup))
        }
        EstimatorName::JointEkfUnaligned => {
            Box::new(Adapter::<T, _, W>::new(JointEkfUd::new(bellar_2019(setup)?, wheels)?, setup))
        }
        EstimatorName::EkfSgfRls => ekf_sgf::<T, W>(ekf_sgf::Config::kim_2013, setup, wheels)?,
        EstimatorName::EkfSgfLls => ekf_sgf::<T, W>(ekf_sgf::Config::kim_2016, setup, wheels)?,
        EstimatorName::MomentumBatch => momentum(momentum::Method::Batch, setup, wheels)?,
        EstimatorName::MomentumConventional => {
            momentum(momentum::Method::Conventional, setup, wheels)?
        }
        EstimatorName::MomentumPreEstimate => {
            momentum(momentum::Method::PreEstimate, setup, wheels)?
        }
        EstimatorName::MomentumSuggested => momentum(momentum::Method::Suggested, setup, wheels)?,
    })
}

/// The window estimator with U unknowns.
fn window<T: Real, const W: usize, const U: usize>(
    setup: &Setup<'_>,
    wheels: WheelArray<T, W>,
) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    let asked = &setup.craft.solve_for;
    let mut config = window::Config::of_unknown_noise();
    config.gyro_noise_rad_s = setup.gyro_noise_rad_s.map(T::lit);
    config.prior = prior(setup);
    if let Some(walk) = inertia_walk_kg_m2_sqrt_s(setup) {
        config.inertia_walk_kg_m2_sqrt_s = walk;
    }
    config.disturbance_torque_n_m = asked.torque.then_some(T::lit(TORQUE_RANGE_N_M));
    config.gyro_bias_rad_s = asked.gyro_bias.then_some(T::lit(BIAS_RANGE_RAD_S));
    config.is_torque_smooth = setup.craft.is_torque_smooth;
    let in_a_block = (SHORTEST_BLOCK_S / setup.sample_period_s).round();
    config.block_samples = config.block_samples.max(in_a_block as u32);
    configure_gate(&mut config.gate, setup);
    let window = Window::<T, W, WINDOW_BLOCKS, U>::new(config, wheels)?;
    Ok(Box::new(Adapter::<T, _, W>::new(window, setup)))
}

/// The nine-state filter as its paper starts it, from whatever initial estimate is drawn.
fn bellar_2019<T: Real>(setup: &Setup<'_>) -> Result<joint_ekf::Config<T>, SetUpError> {
    let published = joint_ekf::Config::bellar_2019(gyro_noise_rad_s(setup)?);
    let mut config = configure(published, setup);
    if let (Some(start), Some(prior)) = (&setup.craft.initial_estimate, published.prior) {
        config.initial_rate = Some(InitialRate {
            rate_rad_s: narrow(&start.rate_rad_s),
            sigma_rad_s: T::lit(start.rate_sigma_rad_s),
        });
        config.initial_inertia_kg_m2 = Some(start.inertia_kg_m2.map(T::lit));
        let sigma_kg_m2 = start.sigma_kg_m2.map(T::lit);
        config.prior = Some(Prior { sigma_kg_m2, ..prior });
    }
    Ok(config)
}

/// Filter, differentiator and regression, with the prior's inertia as the nominal one.
fn ekf_sgf<T: Real, const W: usize>(
    published: fn(T, Prior<T>) -> ekf_sgf::Config<T>,
    setup: &Setup<'_>,
    wheels: WheelArray<T, W>,
) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    let missing = SetUpError::NoNominalInertia { estimator: setup.estimator };
    let nominal = prior(setup).ok_or(missing)?;
    let mut config = published(gyro_noise_rad_s(setup)?, nominal);
    if let Some(walk) = setup.craft.rate_walk_rad_s_sqrt_s {
        // Told the whole process noise, as the papers' filters are.
        config.rate_ekf.rate_walk_rad_s_sqrt_s = T::lit(walk);
        config.rate_ekf.acceleration_doubt = T::zero();
    }
    if !setup.refuse_spikes {
        config.spikes.limit_sigma = T::MAX;
    }
    configure_gate(&mut config.gate, setup);
    let adapter = Adapter::<T, _, W>::new(EkfSgf::<T, W>::new(config, wheels)?, setup);
    Ok(Box::new(Adapter { acceleration: acceleration_of_ekf_sgf, ..adapter }))
}

fn acceleration_of_ekf_sgf<T: Real, const W: usize>(chain: &EkfSgf<T, W>) -> Option<Acceleration> {
    chain.last_instant().map(|instant| Acceleration {
        rad_s2: widen(&instant.acceleration_rad_s2),
        delay_s: chain.last_delay_s().to_f64(),
    })
}

/// Conservation of momentum, solved by one of the paper's formulas.
fn momentum<T: Real, const W: usize>(
    method: momentum::Method,
    setup: &Setup<'_>,
    wheels: WheelArray<T, W>,
) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    let mut config = momentum::Config::kim_2010(method, gyro_noise_rad_s(setup)?);
    config.prior = prior(setup);
    configure_gate(&mut config.gate, setup);
    Ok(Box::new(Adapter::<T, _, W>::new(Momentum::new(config, wheels)?, setup)))
}

/// The gyro's noise, for an estimator that must be told.
fn gyro_noise_rad_s<T: Real>(setup: &Setup<'_>) -> Result<T, SetUpError> {
    let missing = SetUpError::NoGyroNoise { estimator: setup.estimator };
    setup.gyro_noise_rad_s.map(T::lit).ok_or(missing)
}

/// What the craft's file says of the inertia.
fn prior<T: Real>(setup: &Setup<'_>) -> Option<Prior<T>> {
    setup.craft.prior.as_ref().map(|prior| Prior {
        inertia_kg_m2: prior.inertia_kg_m2.map(T::lit),
        sigma_kg_m2: prior.sigma_kg_m2.map(T::lit),
    })
}

/// Puts what is known of the craft into an estimator's defaults.
fn configure<T: Real>(mut config: joint_ekf::Config<T>, setup: &Setup<'_>) -> joint_ekf::Config<T> {
    config.prior = prior(setup).or(config.prior);
    if let Some(walk) = setup.craft.rate_walk_rad_s_sqrt_s {
        config.rate_walk_rad_s_sqrt_s = T::lit(walk);
    }
    if let Some(walk) = inertia_walk_kg_m2_sqrt_s(setup) {
        config.inertia_walk_kg_m2_sqrt_s = [walk; 6];
    }
    if !setup.refuse_spikes {
        config.spikes.limit_sigma = T::MAX;
    }
    configure_gate(&mut config.gate, setup);
    config
}

/// How fast each element of the inertia may wander, if anything is known of that.
fn inertia_walk_kg_m2_sqrt_s<T: Real>(setup: &Setup<'_>) -> Option<T> {
    const SQRT_SECONDS_PER_HOUR: f64 = 60.0;
    setup.craft.inertia_walk_kg_m2_sqrt_hour.map(|walk| T::lit(walk / SQRT_SECONDS_PER_HOUR))
}

fn configure_gate<T: Real>(gate: &mut gate::Config<T>, setup: &Setup<'_>) {
    if let Some(range) = setup.craft.gyro.range_rad_s {
        gate.range_rad_s = T::lit(range);
    }
    let bridged_us = (BRIDGED_PERIODS * setup.sample_period_s * 1e6) as u64;
    gate.max_gap_us = gate.max_gap_us.max(bridged_us);
}

/// An estimator that has been set up elsewhere. `gyro_noise_rad_s` is what it was told, if anything.
pub fn on_board<T: Real, E: Estimator<T, W> + 'static, const W: usize>(
    estimator: E,
    gyro_noise_rad_s: Option<f64>,
) -> Box<dyn AnyEstimator> {
    Box::new(Adapter::<T, E, W>::of(estimator, gyro_noise_rad_s))
}

/// An estimator of the core, its precision and its number of wheels hidden.
struct Adapter<T, E, const W: usize> {
    estimator: E,
    gyro_variance_rad2_s2: Option<f64>,
    acceleration: fn(&E) -> Option<Acceleration>,
    precision: PhantomData<T>,
}

impl<T: Real, E: Estimator<T, W>, const W: usize> Adapter<T, E, W> {
    fn new(estimator: E, setup: &Setup<'_>) -> Self {
        Self::of(estimator, setup.gyro_noise_rad_s)
    }

    fn of(estimator: E, gyro_noise_rad_s: Option<f64>) -> Self {
        let gyro_variance_rad2_s2 = gyro_noise_rad_s.map(|sigma| sigma * sigma);
        Self { estimator, gyro_variance_rad2_s2, acceleration: |_| None, precision: PhantomData }
    }
}

impl<T: Real, E: Estimator<T, W>, const W: usize> AnyEstimator for Adapter<T, E, W> {
    fn step(&mut self, row: &LogRow) -> Outcome {
        // A log has as many speeds as its craft has wheels; the rest stand still.
        let speed = |i: usize| row.wheel_speed_rad_s.get(i).copied().unwrap_or(0.0);
        self.estimator.step(&Sample {
            time_us: row.time_us,
            rate_rad_s: narrow(&row.rate_rad_s),
            wheel_speed_rad_s: std::array::from_fn(|i| T::lit(speed(i))),
            torque_n_m: narrow(&row.torque_n_m),
            attitude: row.attitude.map(|q| Quaternion::new(q.map(T::lit))),
        })
    }

    fn estimate(&self) -> Estimate<f64> {
        let e = self.estimator.estimate();
        Estimate {
            inertia: Inertia::new(e.inertia.elements_kg_m2().map(T::to_f64)),
            covariance_kg2_m4: e.covariance_kg2_m4.map(T::to_f64),
            observed: e.observed,
            status: e.status,
            disturbance_torque_n_m: e.disturbance_torque_n_m.as_ref().map(widen),
            gyro_bias_rad_s: e.gyro_bias_rad_s.as_ref().map(widen),
            residual_rms_rad_s: e.residual_rms_rad_s.to_f64(),
            residuals_white: e.residuals_white,
            projected: e.projected,
        }
    }

    fn rate_rad_s(&self) -> Vector3<f64> {
        widen(&self.estimator.rate_rad_s())
    }

    fn innovation(&self) -> Option<Innovation<f64>> {
        self.estimator.innovation().map(|i| Innovation {
            rate_rad_s: widen(&i.rate_rad_s),
            variance_rad2_s2: widen(&i.variance_rad2_s2),
        })
    }

    fn rate_sigma_rad_s(&self) -> Option<Vector3<f64>> {
        let gyro = self.gyro_variance_rad2_s2?;
        self.innovation().map(|innovation| {
            innovation.variance_rad2_s2.map(|s| ((s - gyro).max(0.0) * gyro / s).sqrt())
        })
    }

    fn acceleration(&self) -> Option<Acceleration> {
        (self.acceleration)(&self.estimator)
    }
}

fn narrow<T: Real>(v: &Vector3<f64>) -> Vec3<T> {
    Vec3::from_fn(|i, _| T::lit(v[i]))
}

fn widen<T: Real>(v: &Vec3<T>) -> Vector3<f64> {
    Vector3::from_fn(|i, _| v[i].to_f64())
}

/// An estimator flown over a log.
pub struct Flown {
    /// What became of the samples.
    pub counts: OutcomeCounts,
    /// The estimate after the last one.
    pub estimate: Estimate<f64>,
}

impl Flown {
    /// How often what was known before was dropped, since new data contradicted it.
    pub fn changes(&self) -> u32 {
        self.counts.change_resets.saturating_add(self.counts.lockout_resets)
    }
}

/// Streams a log through an estimator, and shows each step to `watch`.
pub fn fly(
    rows: &[LogRow],
    mut on_board: Box<dyn AnyEstimator>,
    mut watch: impl FnMut(&LogRow, &Outcome, &dyn AnyEstimator),
) -> Flown {
    let mut counts = OutcomeCounts::default();
    for row in rows {
        let outcome = on_board.step(row);
        counts.add(&outcome);
        watch(row, &outcome, on_board.as_ref());
    }
    Flown { counts, estimate: on_board.estimate() }
}
