//! Savitzky-Golay filter: a polynomial fitted to the newest samples, smoothed or differentiated.
//! \[Savitzky1964\]
//!
//! Input: N channels at an even sample period. Output: value and derivative of the fitted
//! polynomial at a fixed place in the window. \[Kim2013\] and \[Kim2016\] turn filtered rates into
//! angular accelerations by it.
//!
//! * [`kernel`]: weights for any window, order, derivative and evaluation point;
//! * [`differentiator`]: the weights applied to a stream of samples.

pub mod differentiator;
pub mod kernel;

pub use differentiator::{Differentiator, Fitted, Growth, Pushed};
pub use kernel::{Fit, Kernel, LARGEST_WINDOW};
