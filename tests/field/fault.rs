//! Damage to the samples of a log, before the estimator.
//!
//! | fault | samples | source |
//! |---|---|---|
//! | `Frame` | one reading | a corrupted transfer |
//! | `Outliers` | independent, each with a probability | a noisy bus |
//! | `ZeroBursts` | runs of zeros | lost packets, logged as zeros |
//! | `StampAhead`, `ClockBack` | time stamps | a corrupted stamp, a clock that is set |
//! | `GyroGarbage`, `WheelGarbage`, `AxisHeld`, `BiasPulse` | an interval | a transient fault |
//! | `AxesTurned` | all | a gyro that is mounted inaccurately |
//!
//! Every draw follows from the seed of the run.

use host_sim::input::log::LogRow;
use nalgebra::{Unit, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Offset of a seed's fault generator from its noise generator.
const STREAM: u64 = 0x9e37_79b9_7f4a_7c15;
/// Full scale of the gyro where the scenario states none, rad/s: 2,000 deg/s.
const FULL_SCALE_RAD_S: f64 = 34.9;
/// Counts of the full scale: 16 bits, signed.
const COUNTS: f64 = 32_768.0;
/// Longest burst of zeros, samples.
const LONGEST_BURST: usize = 20;
/// Difference from the undamaged reading above which a fault is visible, sigmas.
const VISIBLE_SIGMAS: f64 = 20.0;
/// Largest rate of garbage, rad/s.
const GARBAGE_RAD_S: f64 = 1.0;
/// Largest wheel speed of garbage, rad/s.
const GARBAGE_WHEEL_RAD_S: f64 = 600.0;
/// Jump of a corrupted stamp, and time from the origin to the first sample where a clock is set back,
/// µs: one day.
const DAY_US: u64 = 86_400_000_000;

/// Reading of a bad frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// Zero on each axis.
    Zero,
    /// Minus one count on each axis: a bus that reads all ones.
    MinusOneCount,
    /// Full scale on each axis.
    FullScale,
    /// A step of 20 to 1,000 sigma on one axis.
    Step,
}

/// Damage to a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// None.
    None,
    /// One bad frame at a random instant.
    Frame(Reading),
    /// Steps of 20 to 1,000 sigma on one axis of this share of the samples.
    Outliers(f64),
    /// Zeros in bursts of up to 20 samples, this share of the samples in all.
    ZeroBursts(f64),
    /// One time stamp at a random instant of the first half is a day ahead.
    StampAhead,
    /// The clock is set back by this time at a random instant of the first half, s.
    ClockBack(f64),
    /// Uniform random rates within ±1 rad/s, from the first to the second time, s.
    GyroGarbage([f64; 2]),
    /// Uniform random wheel speeds within ±600 rad/s, from the first to the second time, s.
    WheelGarbage([f64; 2]),
    /// The y axis of the gyro repeats its reading, from the first to the second time, s.
    AxisHeld([f64; 2]),
    /// Axes of the gyro turned about the body diagonal by this angle, deg, in the whole log.
    AxesTurned(f64),
    /// A bias of this many sigmas on each axis, from the first to the second time, s.
    BiasPulse(f64, [f64; 2]),
}

/// Gyro of the damaged log.
#[derive(Clone, Copy, Debug)]
pub struct Gyro {
    /// White noise of one sample, rad/s.
    pub noise_rad_s: f64,
    /// Full scale, rad/s; none if the scenario states none.
    pub range_rad_s: Option<f64>,
}

impl Fault {
    /// Damages a log. True if a sample differs visibly from the undamaged log.
    pub fn apply(&self, rows: &mut [LogRow], gyro: Gyro, seed: u64) -> bool {
        let mut random = Pcg64::seed_from_u64(seed ^ STREAM);
        if rows.is_empty() {
            return false;
        }
        match *self {
            Self::None => false,
            Self::Frame(reading) => {
                let at = random.random_range(0..rows.len());
                let truth = rows[at].rate_rad_s;
                rows[at].rate_rad_s = reading.of(truth, gyro, &mut random);
                is_visible(&(rows[at].rate_rad_s - truth), gyro)
            }
            Self::Outliers(share) => outliers(rows, share, gyro, &mut random),
            Self::ZeroBursts(share) => zero_bursts(rows, share, gyro, &mut random),
            Self::StampAhead => {
                let at = in_first_half(rows, &mut random);
                rows[at].time_us += DAY_US;
                true
            }
            Self::ClockBack(by_s) => {
                let at = in_first_half(rows, &mut random);
                let back_us = (by_s * 1e6) as u64;
                rows.iter_mut().for_each(|row| row.time_us += DAY_US);
                rows.iter_mut().skip(at).for_each(|row| row.time_us -= back_us);
                true
            }
            Self::GyroGarbage(during) => during_s(rows, during, |row| {
                row.rate_rad_s = Vector3::from_fn(|_, _| symmetric(GARBAGE_RAD_S, &mut random));
            }),
            Self::WheelGarbage(during) => during_s(rows, during, |row| {
                for speed in &mut row.wheel_speed_rad_s {
                    *speed = symmetric(GARBAGE_WHEEL_RAD_S, &mut random);
                }
            }),
            Self::AxisHeld(during) => {
                let mut held = None;
                during_s(rows, during, |row| {
                    row.rate_rad_s.y = *held.get_or_insert(row.rate_rad_s.y);
                })
            }
            Self::AxesTurned(angle_deg) => {
                let axis = Unit::new_normalize(Vector3::repeat(1.0));
                let turn = UnitQuaternion::from_axis_angle(&axis, angle_deg.to_radians());
                rows.iter_mut().for_each(|row| row.rate_rad_s = turn * row.rate_rad_s);
                true
            }
            Self::BiasPulse(sigmas, during) => during_s(rows, during, |row| {
                row.rate_rad_s += Vector3::repeat(sigmas * gyro.noise_rad_s);
            }),
        }
    }
}

impl Reading {
    fn of(self, truth: Vector3<f64>, gyro: Gyro, random: &mut Pcg64) -> Vector3<f64> {
        let range = gyro.range_rad_s.unwrap_or(FULL_SCALE_RAD_S);
        match self {
            Self::Zero => Vector3::zeros(),
            Self::MinusOneCount => Vector3::repeat(-range / COUNTS),
            Self::FullScale => Vector3::repeat(range),
            Self::Step => truth + step(gyro, random),
        }
    }
}

/// A step of 20 to 1,000 sigma, log-uniform, on a random axis and of random sign, rad/s.
fn step(gyro: Gyro, random: &mut Pcg64) -> Vector3<f64> {
    let sigmas = random.random_range(20.0f64.ln()..1000.0f64.ln()).exp();
    let sign = if random.random::<bool>() { 1.0 } else { -1.0 };
    let mut step = Vector3::zeros();
    step[random.random_range(0..3)] = sign * sigmas * gyro.noise_rad_s;
    step
}

/// A random sample of the first half, not the first one.
fn in_first_half(rows: &[LogRow], random: &mut Pcg64) -> usize {
    random.random_range(1..(rows.len() / 2).max(2)).min(rows.len() - 1)
}

fn outliers(rows: &mut [LogRow], share: f64, gyro: Gyro, random: &mut Pcg64) -> bool {
    let mut any = false;
    for row in rows {
        if random.random::<f64>() < share {
            row.rate_rad_s += step(gyro, random);
            any = true;
        }
    }
    any
}

fn zero_bursts(rows: &mut [LogRow], share: f64, gyro: Gyro, random: &mut Pcg64) -> bool {
    let mut left = (share * rows.len() as f64).round() as usize;
    let mut any = false;
    while left > 0 {
        let length = random.random_range(1..=LONGEST_BURST).min(left);
        let at = random.random_range(0..rows.len());
        for row in rows.iter_mut().skip(at).take(length) {
            any |= is_visible(&row.rate_rad_s, gyro);
            row.rate_rad_s = Vector3::zeros();
        }
        left -= length;
    }
    any
}

/// Damages the rows of an interval; true if there are any.
fn during_s(
    rows: &mut [LogRow],
    [from_s, to_s]: [f64; 2],
    mut damage: impl FnMut(&mut LogRow),
) -> bool {
    let is_within = |row: &&mut LogRow| (from_s..to_s).contains(&(row.time_us as f64 * 1e-6));
    rows.iter_mut().filter(is_within).map(&mut damage).count() > 0
}

fn is_visible(difference_rad_s: &Vector3<f64>, gyro: Gyro) -> bool {
    difference_rad_s.amax() > VISIBLE_SIGMAS * gyro.noise_rad_s
}

/// Uniform within ± `most`.
fn symmetric(most: f64, random: &mut Pcg64) -> f64 {
    random.random_range(-most..most)
}
