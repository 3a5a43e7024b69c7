//! `window`: Gauss-Newton fit of each manoeuvre as a whole.

use fsw_core::estimator::window::unknowns::MOST_MODES;
use fsw_core::estimator::window::{Config, Window};
use fsw_core::hardware::{Hardware, Mode};
use fsw_core::{Real, WheelArray};

use crate::estimation::adapter::{AnyEstimator, of_setup};
use crate::estimation::error::SetUpError;
use crate::estimation::setup::Setup;
use crate::input::craft::SolveFor;

/// Blocks that the estimator stores.
const BLOCKS: usize = 512;
/// Shortest block, s: at a high sample rate a block has more samples than the core's default, so that its
/// mean covers this time. Short against the rotation of the body,
/// long against the period of vibration.
const SHORTEST_BLOCK_S: f64 = 2e-3;
/// Longest block of several samples, s: a parabola represents wheels that swing with a period of some
/// seconds.
const LONGEST_BLOCK_S: f64 = 0.8;
/// Unknowns without disturbances to solve for: momentum, inertia, and the torque that is tested for.
const WITH_TORQUE: usize = 12;
/// Unknowns with disturbances to solve for: gyro bias and drag as well.
const WITH_DRAG: usize = 18;
/// Prior sigma of a disturbance torque where none is stated, N m: above any disturbance of a small spacecraft. It bounds
/// the torque where the motion leaves it unobserved.
const TORQUE_SIGMA_N_M: f64 = 0.1;
/// Prior sigma of a gyro bias where none is stated, rad/s: above the bias of a consumer gyro, 3 deg/s.
const BIAS_SIGMA_RAD_S: f64 = 0.05;

/// Prior sigma of drag rates, 1/s: of objects of a tenth of a metre and a hundred grams in air, 0.1 to
/// 0.2. In orbit there is none, and it is estimated only where the residuals show it.
const DRAG_SIGMA_PER_S: f64 = 0.2;
/// Slices of work after each sample. A pass over 512 blocks then takes 8 samples.
const SLICES_PER_STEP: u32 = 64;

/// Blocks in a period of the fastest stated mode, at least: the mean over a block then keeps 97 % of its amplitude.
const BLOCKS_PER_PERIOD: f64 = 8.0;

/// The estimator with the unknowns that the craft asks for; H of them where errors of the hardware are stated, F where
/// modes are, G where both errors of the hardware and a torque of fields are.
pub fn set_up<T: Real, const W: usize, const H: usize, const G: usize, const F: usize>(
    setup: &Setup<'_>,
    wheels: WheelArray<T, W>,
) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    let has_field = setup.craft.hardware.varying_torque_sigma_n_m > 0.0;
    if !setup.craft.hardware.modes.is_empty() {
        with_unknowns::<T, W, F, MOST_MODES>(setup, wheels)
    } else if setup.hardware::<T, W>() != Hardware::ideal() {
        if has_field {
            with_unknowns::<T, W, G, 0>(setup, wheels)
        } else {
            with_unknowns::<T, W, H, 0>(setup, wheels)
        }
    } else if has_field {
        with_unknowns::<T, W, H, 0>(setup, wheels)
    } else if setup.craft.solve_for == SolveFor::default() {
        with_unknowns::<T, W, WITH_TORQUE, 0>(setup, wheels)
    } else {
        with_unknowns::<T, W, WITH_DRAG, 0>(setup, wheels)
    }
}

/// Samples of a block at first: the core's default, fewer where samples are far apart and the wheels move
/// on within a block or a stated mode swings, more where they are close together. With thrusters one: a parabola does
/// not represent their pulses.
fn block_samples(setup: &Setup<'_>, default: u32) -> u32 {
    if !setup.craft.thrusters.is_empty() {
        return 1;
    }
    let sample_period_s = setup.sample_period_s;
    let modes = setup.craft.hardware.modes.iter();
    let of_modes = modes.map(|mode| 1.0 / (BLOCKS_PER_PERIOD * mode.frequency_hz));
    let longest_s = of_modes.fold(LONGEST_BLOCK_S, f64::min);
    let (most, least) = (longest_s / sample_period_s, SHORTEST_BLOCK_S / sample_period_s);
    default.min(most as u32).max(least.round() as u32).max(1)
}

/// The estimator with U unknowns, for up to M modes.
fn with_unknowns<T: Real, const W: usize, const U: usize, const M: usize>(
    setup: &Setup<'_>,
    wheels: WheelArray<T, W>,
) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    let solve_for = &setup.craft.solve_for;
    let mut config = Config::of_unknown_noise();
    config.gyro_noise_rad_s = setup.gyro_noise_rad_s.map(T::lit);
    config.prior = setup.prior();
    if let Some(walk) = setup.inertia_walk_kg_m2_sqrt_s() {
        config.inertia_walk_kg_m2_sqrt_s = walk;
    }
    let hardware = &setup.craft.hardware;
    let of_fields = hardware.varying_torque_sigma_n_m;
    let torque_sigma_n_m = match hardware.torque_sigma_n_m {
        Some(sigma) => sigma.hypot(of_fields),
        None if of_fields > 0.0 => of_fields,
        None => TORQUE_SIGMA_N_M,
    };
    let bias_sigma_rad_s = hardware.bias_sigma_rad_s.unwrap_or(BIAS_SIGMA_RAD_S);
    config.disturbance_torque_n_m = solve_for.torque.then_some(T::lit(torque_sigma_n_m));
    config.varying_torque_n_m = T::lit(of_fields);
    config.gyro_bias_rad_s = solve_for.gyro_bias.then_some(T::lit(bias_sigma_rad_s));
    config.bias_walk_rad_s_sqrt_s = T::lit(hardware.bias_walk_rad_s_sqrt_s);
    config.bias_instability_rad_s = T::lit(hardware.bias_instability_rad_s);
    config.drag_per_s = solve_for.torque.then_some(T::lit(DRAG_SIGMA_PER_S));
    config.hardware = setup.hardware();
    let modes = &hardware.modes;
    if modes.len() > M {
        return Err(SetUpError::TooManyModes { found: modes.len(), most: M });
    }
    for (slot, mode) in config.modes.iter_mut().zip(modes) {
        *slot = Some(Mode {
            frequency_hz: T::lit(mode.frequency_hz),
            damping: T::lit(mode.damping),
            frequency_sigma: T::lit(mode.frequency_sigma),
            damping_sigma: T::lit(mode.damping_sigma),
        });
    }
    config.slices_per_step = SLICES_PER_STEP;
    config.is_torque_smooth = setup.craft.filter.is_torque_smooth;
    config.block_samples = block_samples(setup, config.block_samples);
    setup.configure_gate(&mut config.gate);
    let window = Window::<T, W, BLOCKS, U, 0, M>::new(config, wheels)?;
    Ok(of_setup::<T, _, W>(window, setup))
}
