//! Savitzky-Golay: a polynomial fitted to the last few samples, smoothed or differentiated.
//!
//! Used by \[Kim2013\] and \[Kim2016\] to turn filtered rates into angular accelerations.
//!
//! * [`kernel`]: the weights, for any window, order, derivative and evaluation point;
//! * [`differentiator`]: the same over a stream of samples, which must be evenly spaced.

pub mod differentiator;
pub mod kernel;

pub use differentiator::{Differentiator, Fitted, Growth, Pushed};
pub use kernel::{Fit, Kernel, LARGEST_WINDOW};
