//! Types of [`math`](crate::math) as words.
//!
//! Implemented here, so that the algebra does not depend on checkpoints. Fields of these types are
//! visible within the crate for this purpose alone.
//!
//! | type | condition on reading |
//! |---|---|
//! | [`SquareRootInformation`] | weights not negative |
//! | [`Ud`] | variances not negative and below 1e18, factors below 1e9 |
//! | [`Kernel`] | window within the capacity |
//! | [`Differentiator`] | ring index and number of samples within their limits |

use crate::math::savgol::{Differentiator, Fit, Growth, Kernel};
use crate::math::scalar::Real;
use crate::math::square_root_information::{RecursiveResidual, SquareRootInformation};
use crate::math::ud::Ud;

crate::persist!(
    [T: Real, const N: usize] SquareRootInformation<T, N> { factor, right_hand_side }
    if |this| (0..N).all(|i| this.factor[i][i] >= T::zero())
);

crate::persist!([T: Real] RecursiveResidual<T> { value, weight });

/// Bound on a stored variance D, and on the magnitude of a factor U: the nine terms `u² d` of a variance are below 1e37 and
/// finite in single precision. A prior of 1e6 kg m² with a sigma ten times as large has variances of 1e14 kg² m⁴.
const LARGEST_VARIANCE: f64 = 1.0e18;
const LARGEST_FACTOR: f64 = 1.0e9;

crate::persist!(
    [T: Real, const N: usize] Ud<T, N> { packed }
    if |ud| ud.is_valid() && ud.is_below(T::lit(LARGEST_VARIANCE), T::lit(LARGEST_FACTOR))
);

crate::persist!([T: Real] Fit<T> { window, order, derivative, at });

crate::persist!(
    [T: Real, const C: usize] Kernel<T, C> { weights, window } if |kernel| kernel.window <= C
);

crate::persist!([] enum Growth { 0 => WaitUntilFull, 1 => Odd });

crate::persist!([T: Real, const N: usize, const C: usize] Differentiator<T, N, C> {
    ring, next, filled, smoothing, differentiation; unchanged fit, growth, period_tolerance
} if |this| this.next < C && this.filled <= this.fit.window);
