//! Operation before tracking: the alignment behind an outlier gate, and its link to the present.
//!
//! ```text
//!  sample ─► outlier gate ─► alignment ─► solution at the last judged sample
//!             two samples late                 │ prediction across the two pending ones
//!                                              ▼
//!                                          tracking
//! ```
//!
//! One bad reading in the integrals of the alignment would remain in its solution. A refused sample
//! enters the integrals with its bridged rate, and adds no equation.

use super::alignment::Alignment;
use super::start::{self, NoStart, Start};
use super::{Config, State};
use crate::dynamics::gyrostat::Gyrostat;
use crate::dynamics::interval::{Drive, Interval};
use crate::dynamics::step::runge_kutta_4;
use crate::math::{Vec3, scalar::Real};
use crate::monitor::outliers::{Judged, OutlierGate};
use crate::prior::Prior;

/// Samples between the last judged one and the present one, the latter included.
const PENDING: usize = 2;

/// Accumulation of motion for the first state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aligning<T: Real> {
    /// Gate on the raw samples, with the drive of each.
    outliers: OutlierGate<T, Drive<T>>,
    /// Least squares since the first accepted sample; empty before it.
    alignment: Alignment<T>,
    /// The last solution contradicted the model; the alignment has started anew since.
    contradicts_model: bool,
}

crate::persist!([T: Real] Aligning<T> { outliers, alignment, contradicts_model });

/// Result of one sample.
pub(super) enum Progress<T: Real> {
    /// More motion is needed.
    Continues,
    /// The same, and a sample of two samples ago was refused.
    Refused,
    /// A solution is due: way from the last judged sample to the present one. The rate is that of the
    /// judged sample.
    Due(Pending<T>),
}

impl<T: Real> Aligning<T> {
    /// Before the first sample.
    #[inline(always)] // built in its place
    pub(super) fn new() -> Self {
        Self {
            outliers: OutlierGate::new(),
            alignment: Alignment::empty(),
            contradicts_model: false,
        }
    }

    /// Starts with a first sample.
    pub(super) fn begin(&mut self, rate_rad_s: &Vec3<T>, drive: &Drive<T>, noise_rad_s: T) {
        self.outliers.reset();
        self.outliers.push(T::zero(), *rate_rad_s, *drive, noise_rad_s);
        self.alignment.clear();
        self.contradicts_model = false;
    }

    /// True where the last solution contradicted the model: a tensor that no rigid body has, or
    /// residuals above the noise.
    pub(super) fn contradicts_model(&self) -> bool {
        self.contradicts_model
    }

    /// Takes in a sample, `elapsed_s` after the one before. At most two samples leave the gate, and one
    /// where it makes two verdicts: a backlog costs one of both more a step.
    pub(super) fn step(
        &mut self,
        (rate_rad_s, drive): (&Vec3<T>, &Drive<T>),
        elapsed_s: T,
        noise_rad_s: T,
        prior: Option<&Prior<T>>,
    ) -> Progress<T> {
        let is_behind = self.outliers.is_behind();
        let Some(judged) = self.outliers.push(elapsed_s, *rate_rad_s, *drive, noise_rad_s) else {
            return Progress::Continues;
        };
        self.add(&judged, noise_rad_s, prior);
        let second = if is_behind { None } else { self.outliers.ready() };
        if let Some(second) = &second {
            self.add(second, noise_rad_s, prior);
        }
        if second.is_none() && judged.is_accepted {
            return self.progress(&judged);
        }
        let is_refused = !judged.is_accepted || second.is_some_and(|second| !second.is_accepted);
        if is_refused { Progress::Refused } else { Progress::Continues }
    }

    /// Adds a judged sample; the first accepted one starts the integrals.
    fn add(&mut self, judged: &Judged<T, Drive<T>>, noise_rad_s: T, prior: Option<&Prior<T>>) {
        let Judged { elapsed_s, rate_rad_s, payload: drive, is_accepted } = judged;
        if self.alignment.samples() > 0 {
            self.alignment.add(rate_rad_s, drive, *elapsed_s, *is_accepted);
        } else if *is_accepted {
            self.alignment.begin(rate_rad_s, drive, noise_rad_s, prior);
        }
    }

    /// Progress after an accepted sample, which is the last judged one: a solution needs that only the
    /// delay of the gate is pending.
    fn progress(&self, judged: &Judged<T, Drive<T>>) -> Progress<T> {
        if !start::is_due(&self.alignment) {
            return Progress::Continues;
        }
        let mut pending = self.outliers.pending();
        match [pending.next(), pending.next(), pending.next()] {
            [Some(first), Some(second), None] => Progress::Due(Pending {
                rate_rad_s: judged.rate_rad_s,
                drive: judged.payload,
                steps: [first, second],
            }),
            _ => Progress::Continues,
        }
    }

    /// First state at the last judged sample, where the solution is good enough.
    pub(super) fn start(&mut self, noise_rad_s: T, prior: Option<&Prior<T>>) -> Option<Start<T>> {
        let measured_rad_s = || self.outliers.noise_rad_s();
        match Start::from_motion(&self.alignment, prior, noise_rad_s, measured_rad_s) {
            Ok(start) => Some(start),
            Err(NoStart::TooLittleMotion) => None,
            // These data cannot lead to a start: the next ones may.
            Err(NoStart::Contradiction) => {
                self.contradicts_model = true;
                self.alignment.clear();
                None
            }
        }
    }
}

/// Way from the last judged sample to the present one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending<T: Real> {
    /// Rate at the last judged sample, rad/s.
    pub(super) rate_rad_s: Vec3<T>,
    /// Drive there.
    drive: Drive<T>,
    /// Duration (s) and drive at the end of each interval since.
    steps: [(T, Drive<T>); PENDING],
}

crate::persist!([T: Real] Pending<T> { rate_rad_s, drive, steps });

impl<T: Real> Pending<T> {
    /// Prediction from the last judged sample to the end of the interval `last`, which follows the
    /// pending ones: the rate interval by interval, the covariance over all of them at once.
    ///
    /// `predict` is the prediction of the filter. `None` where the inertia has no inverse.
    pub(super) fn predict(
        &self,
        state: &mut State<T>,
        last: &Interval<T>,
        predict: impl FnOnce(&mut State<T>, &Interval<T>, &Config<T>) -> Option<()>,
        config: &Config<T>,
    ) -> Option<()> {
        let body = Gyrostat::new(&state.inertia)?;
        let (mut rate_rad_s, mut start) = (self.rate_rad_s, self.drive);
        let mut duration_s = last.duration_s;
        for (step_s, end) in self.steps {
            let interval = linear(step_s, start, end);
            rate_rad_s = runge_kutta_4(&body, &rate_rad_s, &interval);
            duration_s += step_s;
            start = end;
        }
        rate_rad_s = runge_kutta_4(&body, &rate_rad_s, last);
        state.rate_rad_s = self.rate_rad_s;
        predict(state, &linear(duration_s, self.drive, last.end), config)?;
        state.rate_rad_s = rate_rad_s;
        Some(())
    }
}

/// Interval with a drive that is linear in time.
fn linear<T: Real>(duration_s: T, start: Drive<T>, end: Drive<T>) -> Interval<T> {
    let half = T::lit(0.5);
    let middle = Drive {
        torque_n_m: (start.torque_n_m + end.torque_n_m) * half,
        wheel_momentum_n_m_s: (start.wheel_momentum_n_m_s + end.wheel_momentum_n_m_s) * half,
    };
    Interval { duration_s, start, middle, end }
}
