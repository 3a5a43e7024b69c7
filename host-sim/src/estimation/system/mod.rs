//! The four systems of the core, each configured for a craft: one file per folder of
//! `fsw_core::estimator`.

mod ekf_sgf;
mod joint_ekf;
mod momentum;
mod window;

use fsw_core::estimator::momentum::Method;
use fsw_core::{Real, Vec3, WheelArray};

use super::adapter::{AnyEstimator, narrow};
use super::error::SetUpError;
use super::name::{EstimatorName, Precision};
use super::setup::Setup;

/// The estimator that `setup` names, configured for its craft.
///
/// # Errors
/// See [`SetUpError`].
pub fn set_up(setup: &Setup<'_>) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    match setup.precision {
        Precision::F32 => with_wheels::<f32>(setup),
        Precision::F64 => with_wheels::<f64>(setup),
    }
}

/// Estimators are compiled for 0, 4 and 8 wheels, which keeps the build short. A craft with fewer
/// wheels is filled up with wheels at rest: these add exactly zero to the momentum, so that every
/// bit is the same as with the exact number.
fn with_wheels<T: Real>(setup: &Setup<'_>) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    match setup.craft.wheels.len() {
        0 => by_name::<T, 0, 30, 42, 48, 17>(setup, wheels(setup)?),
        1..=4 => by_name::<T, 4, 42, 54, 60, 30>(setup, wheels(setup)?),
        5..=8 => by_name::<T, 8, 54, 66, 72, 42>(setup, wheels(setup)?),
        found => Err(SetUpError::TooManyWheels { found }),
    }
}

/// The craft's wheels; axis x and spin inertia 1 kg m² for those that fill up the array.
fn wheels<T: Real, const W: usize>(setup: &Setup<'_>) -> Result<WheelArray<T, W>, SetUpError> {
    let wheel = |i: usize| setup.craft.wheels.get(i);
    Ok(WheelArray::new(
        std::array::from_fn(|i| wheel(i).map_or_else(Vec3::x, |w| narrow(&w.axis))),
        std::array::from_fn(|i| wheel(i).map_or(T::one(), |w| T::lit(w.spin_inertia_kg_m2))),
    )?)
}

/// H unknowns of `window` where errors of the hardware are stated: 9, three groups of one window, four of gyro and
/// clock, and one for each wheel; G where a torque of fields is stated too: four groups more; F where modes are: three groups
/// more for each of two. P columns of `joint-ekf`: gyro 9, wheels 3 each and 1 in common, time offset, torque scale, bias
/// and disturbance torque 3 each.
fn by_name<
    T: Real,
    const W: usize,
    const H: usize,
    const G: usize,
    const F: usize,
    const P: usize,
>(
    setup: &Setup<'_>,
    wheels: WheelArray<T, W>,
) -> Result<Box<dyn AnyEstimator>, SetUpError> {
    match setup.estimator {
        EstimatorName::Window => window::set_up::<T, W, H, G, F>(setup, wheels),
        EstimatorName::JointEkf => joint_ekf::aligned::<T, W, P>(setup, wheels),
        EstimatorName::JointEkfPublished => joint_ekf::published(setup, wheels),
        EstimatorName::JointEkfUnaligned => joint_ekf::unaligned(setup, wheels),
        EstimatorName::EkfSgfRls => ekf_sgf::rls(setup, wheels),
        EstimatorName::EkfSgfLls => ekf_sgf::lls(setup, wheels),
        EstimatorName::MomentumBatch => momentum::set_up(Method::Batch, setup, wheels),
        EstimatorName::MomentumConventional => {
            momentum::set_up(Method::Conventional, setup, wheels)
        }
        EstimatorName::MomentumPreEstimate => momentum::set_up(Method::PreEstimate, setup, wheels),
        EstimatorName::MomentumSuggested => momentum::set_up(Method::Suggested, setup, wheels),
    }
}
