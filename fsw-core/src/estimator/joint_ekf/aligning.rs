//! Operation before tracking: the alignment behind an outlier gate, and its link to the present.
//!
//! ```text
//!  sample ─► outlier gate ─► alignment ─► solution at the last judged sample
//!             two samples late                 │ rate predicted across the pending ones
//!                                              ▼
//!                                          tracking
//! ```
//!
//! One bad reading in the integrals of the alignment would remain in its solution. A refused sample
//! enters the integrals with its bridged rate, and adds no equation.
//!
//! A solution is more expensive than a sample. It is spread over the samples after the one at which it is due, in place
//! of their verdicts:
//!
//! | sample | part of the solution | pending samples |
//! |---|---|---|
//! | first | inertia, acceptance | 3 |
//! | second | rate and covariance at the last judged sample | 4 |
//! | third | rate predicted across the pending samples | 5 |
//!
//! After a solution that is not accepted the gate catches up.

use super::alignment::Alignment;
use super::start::{self, NoStart, Start};
use super::{Config, Form, State};
use crate::dynamics::gyrostat::Gyrostat;
use crate::dynamics::interval::{Drive, Interval};
use crate::dynamics::step::runge_kutta_4;
use crate::math::{Vec3, scalar::Real};
use crate::monitor::outliers::{Judged, OutlierGate};
use crate::persist::{Archive, Persist};
use crate::prior::Prior;
use crate::tensor::Inertia;

/// Delay of the gate, samples.
const DELAY: usize = 2;

/// Accumulation of motion for the first state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aligning<T: Real> {
    /// Gate on the raw samples, with the drive of each.
    outliers: OutlierGate<T, Drive<T>>,
    /// Least squares since the first accepted sample; empty before it.
    alignment: Alignment<T>,
    /// Solution that is due at the last judged sample.
    due: Option<Due<T>>,
    /// The last solution contradicted the model; the alignment has started anew since.
    contradicts_model: bool,
}

crate::persist!([T: Real] Aligning<T> { outliers, alignment, due, contradicts_model });

/// Solution that is due.
#[derive(Clone, Copy, Debug)]
pub(super) struct Due<T: Real> {
    /// Drive at the last judged sample.
    pub(super) drive: Drive<T>,
    /// Inertia, once it is solved for.
    pub(super) inertia: Option<Inertia<T>>,
}

crate::persist!([T: Real] Due<T> { drive, inertia });

/// Alignment of a filter, absent only between the construction of the filter in its place and that of the
/// alignment: together they would take a copy of more than a kilobyte on the stack.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed<T: Real>(Option<Aligning<T>>);

impl<T: Real> Placed<T> {
    /// No alignment.
    pub(super) fn absent() -> Self {
        Self(None)
    }

    /// Constructs the alignment.
    #[inline(never)]
    pub(super) fn construct(&mut self) {
        self.0 = Some(Aligning::new());
    }

    /// The alignment.
    pub(super) fn get(&self) -> Option<&Aligning<T>> {
        self.0.as_ref()
    }

    /// As [`get`](Self::get), mutable.
    pub(super) fn get_mut(&mut self) -> Option<&mut Aligning<T>> {
        self.0.as_mut()
    }
}

/// As the alignment itself.
impl<T: Real> Persist for Placed<T> {
    fn layout() -> u32 {
        Aligning::<T>::layout()
    }

    fn persist(&mut self, archive: &mut Archive<'_>) {
        if let Some(aligning) = &mut self.0 {
            aligning.persist(archive);
        }
    }
}

/// Result of one sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    /// More motion is needed.
    Continues,
    /// The same, and a sample of two samples ago was refused.
    Refused,
}

impl<T: Real> Aligning<T> {
    /// Before the first sample.
    #[inline(always)] // built in its place
    pub(super) fn new() -> Self {
        Self {
            outliers: OutlierGate::new(),
            alignment: Alignment::empty(),
            due: None,
            contradicts_model: false,
        }
    }

    /// Starts with a first sample.
    pub(super) fn begin(&mut self, rate_rad_s: &Vec3<T>, drive: &Drive<T>, noise_rad_s: T) {
        self.outliers.reset();
        self.outliers.add(T::zero(), *rate_rad_s, *drive, noise_rad_s);
        self.alignment.clear();
        self.due = None;
        self.contradicts_model = false;
    }

    /// True where the last solution contradicted the model: a tensor that no rigid body has, or
    /// residuals above the noise.
    pub(super) fn contradicts_model(&self) -> bool {
        self.contradicts_model
    }

    /// Takes in a sample, `elapsed_s` after the one before. A part of the solution follows where one is due, otherwise
    /// [`step`](Self::step).
    pub(super) fn take_in(
        &mut self,
        (rate_rad_s, drive): (&Vec3<T>, &Drive<T>),
        elapsed_s: T,
        noise_rad_s: T,
    ) {
        self.outliers.add(elapsed_s, *rate_rad_s, *drive, noise_rad_s);
    }

    /// Judges samples and adds them. At most two leave the gate, and one where it makes two verdicts: a
    /// backlog costs one of both more a step.
    pub(super) fn step(&mut self, noise_rad_s: T, prior: Option<&Prior<T>>) -> Progress {
        let is_behind = self.outliers.is_behind();
        let Some(judged) = self.outliers.advance() else {
            return Progress::Continues;
        };
        self.add(&judged, noise_rad_s, prior);
        let second = if is_behind { None } else { self.outliers.ready() };
        if let Some(second) = &second {
            self.add(second, noise_rad_s, prior);
        }
        if second.is_none() && judged.is_accepted {
            let is_due = start::is_due(&self.alignment) && self.outliers.pending().count() == DELAY;
            self.due = is_due.then_some(Due { drive: judged.payload, inertia: None });
            return Progress::Continues;
        }
        let is_refused = !judged.is_accepted || second.is_some_and(|second| !second.is_accepted);
        if is_refused { Progress::Refused } else { Progress::Continues }
    }

    /// Adds a judged sample; the first accepted one starts the integrals.
    fn add(&mut self, judged: &Judged<T, Drive<T>>, noise_rad_s: T, prior: Option<&Prior<T>>) {
        let Judged { elapsed_s, rate_rad_s, payload: drive, is_accepted, .. } = judged;
        if self.alignment.samples() > 0 {
            self.alignment.add(rate_rad_s, drive, *elapsed_s, *is_accepted);
        } else if *is_accepted {
            self.alignment.begin(rate_rad_s, drive, noise_rad_s, prior);
        }
    }

    /// The solution that is due.
    pub(super) fn due(&self) -> Option<Due<T>> {
        self.due
    }

    /// Solves for the inertia of the solution that is due. `allowed_rad_s`: noise that the residuals may have by errors of
    /// the hardware, rad/s, for a mean moment (kg m²) and the number of samples.
    ///
    /// # Errors
    /// As [`start::inertia_of`]: none is due then.
    pub(super) fn solve_inertia(
        &mut self,
        noise_rad_s: T,
        allowed_rad_s: impl FnOnce(T, u32) -> T,
    ) -> Result<(), NoStart> {
        let samples = self.alignment.samples();
        let measured_rad_s = self.outliers.noise_rad_s();
        let solved = start::inertia_of(&self.alignment, noise_rad_s, |mean_moment_kg_m2| {
            measured_rad_s.max(allowed_rad_s(mean_moment_kg_m2, samples))
        });
        let inertia = solved.ok();
        self.due = self.due.filter(|_| inertia.is_some()).map(|due| Due { inertia, ..due });
        solved.map(|_| ())
    }

    /// First state at the last judged sample for the solved inertia, once. `None` where that has no inverse.
    #[inline(always)] // without a copy of the result
    pub(super) fn start(
        &mut self,
        inertia: &Inertia<T>,
        noise_rad_s: T,
        prior: Option<&Prior<T>>,
    ) -> Option<Start<T>> {
        self.due = None;
        Start::from_motion(&self.alignment, inertia, prior, noise_rad_s)
    }

    /// Starts anew after data that contradict the model: they cannot lead to a start, the next ones may.
    pub(super) fn discard(&mut self) {
        self.contradicts_model = true;
        self.alignment.clear();
    }

    /// Predicts the rate of `state` across the pending samples to the present one, and adds their
    /// intervals to `way`. `None` where the inertia has no inverse.
    pub(super) fn predict(&self, state: &mut State<T>, way: &mut Pending<T>) -> Option<()> {
        let body = Gyrostat::new(&state.inertia)?;
        let mut start = way.drive;
        for (step_s, end) in self.outliers.pending() {
            let interval = linear(step_s, start, end);
            state.rate_rad_s = runge_kutta_4(&body, &state.rate_rad_s, &interval);
            way.duration_s += step_s;
            start = end;
        }
        Some(())
    }
}

/// Way from the last judged sample to the present one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending<T: Real> {
    /// Rate at the last judged sample, rad/s.
    pub(super) rate_rad_s: Vec3<T>,
    /// Drive there.
    drive: Drive<T>,
    /// Time since then, s.
    duration_s: T,
}

crate::persist!([T: Real] Pending<T> { rate_rad_s, drive, duration_s });

impl<T: Real> Pending<T> {
    /// From a rate, rad/s, and drive at the last judged sample.
    pub(super) fn new(rate_rad_s: Vec3<T>, drive: Drive<T>) -> Self {
        Self { rate_rad_s, drive, duration_s: T::zero() }
    }

    /// Prediction to the end of the interval `last`, which follows the pending ones: the rate over that
    /// interval, the covariance over all of them at once.
    ///
    /// `None` where the inertia has no inverse.
    pub(super) fn predict<F: Form<T>>(
        &self,
        state: &mut State<T>,
        form: &mut F,
        last: &Interval<T>,
        config: &Config<T>,
    ) -> Option<()> {
        let body = Gyrostat::new(&state.inertia)?;
        state.rate_rad_s = runge_kutta_4(&body, &state.rate_rad_s, last);
        let rates_rad_s = (&self.rate_rad_s, &state.rate_rad_s);
        let all = linear(self.duration_s + last.duration_s, self.drive, last.end);
        form.predict_covariance(&body, rates_rad_s, &all, config);
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
