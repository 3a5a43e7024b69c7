//! The nine states, and the two operations on them that a form of the filter provides.

use super::Config;
use super::considered::{Gain, Prediction};
use crate::dynamics::gyrostat::Gyrostat;
use crate::dynamics::interval::Interval;
use crate::math::{Mat, Vec3, scalar::Real, ud::Ud};
use crate::tensor::Inertia;

/// Rate and inertia, `(ωx ωy ωz Jxx Jyy Jzz Jxy Jxz Jyz)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<T: Real> {
    /// Body rate, rad/s, body axes.
    pub rate_rad_s: Vec3<T>,
    /// Inertia tensor, kg m². Not necessarily physical: the filter knows no constraint.
    pub inertia: Inertia<T>,
}

crate::persist!([T: Real] State<T> { rate_rad_s, inertia });

impl<T: Real> State<T> {
    /// All zeros, to be filled in.
    #[inline(always)] // built in its place
    pub(super) fn zero() -> Self {
        Self { rate_rad_s: Vec3::zeros(), inertia: Inertia::new([T::zero(); 6]) }
    }

    /// The nine states as numbers: rad/s, then kg m².
    pub(super) fn elements(&self) -> [T; 9] {
        let [x, y, z]: [T; 3] = self.rate_rad_s.into();
        let [a, b, c, d, e, f] = self.inertia.elements_kg_m2();
        [x, y, z, a, b, c, d, e, f]
    }
}

/// Measurement of a combination of the inertia.
#[derive(Clone, Copy, Debug)]
pub struct Combination<'a, T: Real> {
    /// h over the nine states: zero for the rate.
    pub h: &'a [T; 9],
    /// Measured value, kg m².
    pub value_kg_m2: T,
    /// Variance of its noise, kg² m⁴.
    pub variance: T,
}

/// Representation of the covariance, with the prediction and the correction that go with it.
///
/// Covariances have the units of the products of the states: rad²/s², kg m² rad/s, kg² m⁴.
pub trait Form<T: Real>: Sized {
    /// Starts with this covariance of the nine states.
    fn new(covariance: &Ud<T, 9>) -> Self;

    /// Prediction: state and covariance over one interval between samples. `visit` receives what columns of
    /// considered parameters need of it.
    ///
    /// `None` where the inertia has no inverse; state and covariance are then unchanged.
    fn predict(
        &mut self,
        state: &mut State<T>,
        interval: &Interval<T>,
        config: &Config<T>,
        visit: impl FnOnce(&Prediction<'_, T>),
    ) -> Option<()>;

    /// Covariance alone, over an interval across which the rate has been integrated. `rates_rad_s`: at its
    /// start and at its end.
    fn predict_covariance(
        &mut self,
        body: &Gyrostat<T>,
        rates_rad_s: (&Vec3<T>, &Vec3<T>),
        interval: &Interval<T>,
        config: &Config<T>,
    );

    /// Variance of the rate on each axis, rad²/s².
    fn rate_variance(&self) -> Vec3<T>;

    /// Correction of state and covariance by a measured rate, rad/s, of noise variance
    /// `noise_variance` on each axis, rad²/s². Axis by axis, `choose` receives the [`Gain`] of the form, and may
    /// return another one.
    fn update(
        &mut self,
        state: &mut State<T>,
        measured_rad_s: &Vec3<T>,
        noise_variance: T,
        choose: impl FnMut(&Gain<T>) -> Option<[T; 9]>,
    );

    /// Sets the rate's covariance to `variance` on each axis (rad²/s²), uncorrelated with the
    /// inertia, whose covariance is unchanged.
    fn restart_rate(&mut self, variance: T);

    /// Covariance of the nine states, 9×9.
    fn covariance(&self) -> Mat<T, 9, 9>;

    /// Covariance of the six elements of the inertia, kg² m⁴.
    fn inertia_covariance(&self) -> Mat<T, 6, 6> {
        self.covariance().fixed_view::<6, 6>(3, 3).into_owned()
    }

    /// Factors of the covariance of the inertia; `None` for a form that keeps no earlier estimate.
    fn inertia_factors(&self) -> Option<Ud<T, 6>> {
        None
    }

    /// Correction of state and covariance by the measurement of a combination of the inertia, `y = h j`. `choose`
    /// receives the combination's gain, and may return another one. A form without earlier estimates has none.
    fn observe_inertia(
        &mut self,
        _state: &mut State<T>,
        _measured: &Combination<'_, T>,
        _choose: impl FnOnce(&[T; 9], T) -> Option<[T; 9]>,
    ) {
    }

    /// True if every number is finite and no variance negative.
    fn is_valid(&self) -> bool;
}
