//! Estimate from before a lock-out: kept, in doubt, and fused again once later data agree with it.
//!
//! A transient fault and a change of the inertia look alike at first. Both end in a lock-out, after which the filter
//! aligns on the later data alone. The estimate from before, `(j₀, P₀)`, is doubted: kept, but not used. Once the
//! later data are decisive, chi-square decides, as in [`window`](crate::estimator::window):
//!
//! `χ² = Δᵀ C⁻¹ Δ`, `Δ = j − j₀` (kg m²), `C = P + P₀ + Σ_p (Γ − Γ₀) (Γ − Γ₀)ᵀ` (kg² m⁴)
//!
//! with j and P the later estimate and its covariance, and Γ the columns of the considered parameters, which have the
//! same value before and after.
//!
//! | case | verdict | consequence |
//! |---|---|---|
//! | a sigma of Δ above 0.35 % of the mean moment | none yet | the residuals are not called white |
//! | χ² above 33 | the inertia has changed | the earlier estimate is discarded |
//! | otherwise | the motion was interrupted | fusion |
//!
//! # Snapshots
//!
//! The first readings of a fault are used before it is detected. The estimate that is doubted is therefore the older of
//! two snapshots, which are taken every [`PERIOD`] updates, and only while no shift is being counted: it is 64 to 128
//! updates old. A shift of one sigma is detected after 40 samples.
//!
//! # Fusion
//!
//! With `P₀ = U₀ D₀ U₀ᵀ` the six numbers `U₀⁻¹ j₀` are uncorrelated measurements of `hᵢ j`, hᵢ row i of `U₀⁻¹`, with
//! the variances `D₀`. One of them is taken in at each sample, in place of its reading. Rate and inertia are corrected together, by the
//! correlation that the filter has of them.

use super::considered::Considered;
use crate::math::{Entries, Mat, quadratic_over, scalar::Real, ud::Ud};
use crate::tensor::Inertia;

/// Updates between two snapshots, and between two judgements.
pub(super) const PERIOD: u8 = 64;
/// Sigma of the difference of an element, over the mean moment, from which it is decisive: a change of 2 % then has
/// the chi-square `(0.02 / 0.0035)²` = 33.
const DECISIVE: f64 = 0.02 / 5.75;
/// Chi-square of six degrees of freedom that chance exceeds once in 10⁵.
const CONTRADICTED: f64 = 33.0;

/// Estimate of the inertia at one time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Snapshot<T: Real, const P: usize> {
    /// `j₀`.
    pub inertia: Inertia<T>,
    /// `P₀`, kg² m⁴.
    pub factors: Ud<T, 6>,
    /// `Γ₀` times one sigma of each parameter, kg m².
    pub columns: [[T; 6]; P],
}

crate::persist!([T: Real, const P: usize] Snapshot<T, P> { inertia, factors, columns });

/// Snapshots, and the estimate that is doubted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Doubt<T: Real, const P: usize> {
    /// The last two snapshots, and which of them is the older one.
    recent: [Option<Snapshot<T, P>>; 2],
    is_second_older: bool,
    doubted: Option<Snapshot<T, P>>,
    /// Updates since the last snapshot or judgement.
    updates: u8,
    /// Next row of the fusion; `None` before the verdict.
    row: Option<u8>,
}

crate::persist!([T: Real, const P: usize] Doubt<T, P> { recent, is_second_older, doubted, updates, row });

/// Task of an update.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Task {
    /// None.
    Nothing,
    /// Snapshot of the estimate.
    Snapshot,
    /// Random walk of what is doubted.
    Ageing,
    /// Judgement of what is doubted.
    Judgement,
    /// Fusion of the next row.
    Fusion,
}

/// Verdict on what is doubted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// The later data are not decisive yet.
    Undecided,
    /// The inertia has changed.
    Changed,
    /// The motion was interrupted.
    Interrupted,
}

/// Measurement `y = h j` of the inertia, with the variance of its noise.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<T: Real, const P: usize> {
    /// h over the nine states: zero for the rate.
    pub h: [T; 9],
    /// y, kg m².
    pub value_kg_m2: T,
    /// Variance of its noise, kg² m⁴.
    pub variance: T,
    /// `h Γ₀`, kg m².
    pub columns: [T; P],
}

impl<T: Real, const P: usize> Doubt<T, P> {
    /// No snapshot.
    #[inline(always)] // built in its place
    pub(super) fn none() -> Self {
        Self { recent: [None; 2], is_second_older: false, doubted: None, updates: 0, row: None }
    }

    /// Discards everything.
    pub(super) fn clear(&mut self) {
        self.recent = [None; 2];
        self.is_second_older = false;
        self.restart();
        self.doubted = None;
    }

    /// True while an earlier estimate is in doubt.
    pub(super) fn is_present(&self) -> bool {
        self.doubted.is_some()
    }

    /// Lock-out: the older snapshot is doubted. What is doubted already stays so, and the data since then are discarded.
    pub(super) fn interrupt(&mut self) {
        if self.doubted.is_none() {
            let [first, second] = &self.recent;
            self.doubted = if self.is_second_older { *second } else { *first };
        }
        self.recent = [None; 2];
        self.is_second_older = false;
        self.restart();
    }

    fn restart(&mut self) {
        (self.updates, self.row) = (0, None);
    }

    /// Counts an update, and returns its task. `is_calm`: no shift is being counted.
    #[inline]
    pub(super) fn advance(&mut self, is_calm: bool) -> Task {
        if self.row.is_some() {
            return Task::Fusion;
        }
        let is_first = self.doubted.is_none() && self.recent[0].is_none();
        self.updates = self.updates.saturating_add(1);
        if self.updates < PERIOD && !is_first || !is_calm {
            return Task::Nothing;
        }
        if self.doubted.is_some() && self.updates == PERIOD {
            return Task::Ageing;
        }
        self.updates = 0;
        if self.doubted.is_some() { Task::Judgement } else { Task::Snapshot }
    }

    /// Takes a snapshot in place of the older one. The first one is that of the start, and counts as both.
    pub(super) fn keep(&mut self, snapshot: Snapshot<T, P>) {
        let [first, second] = &mut self.recent;
        if first.is_none() {
            *second = Some(snapshot);
        }
        let older = if self.is_second_older { second } else { first };
        *older = Some(snapshot);
        self.is_second_older = !self.is_second_older;
    }

    /// Random walk of what is doubted, one sigma of each element in the square, kg² m⁴.
    pub(super) fn walk(&mut self, variances: [T; 6]) {
        if let Some(doubted) = &mut self.doubted {
            for (element, variance) in variances.into_iter().enumerate() {
                doubted.factors.inflate(element, variance);
            }
        }
    }

    /// Judges what is doubted by the later estimate, its covariance (kg² m⁴) and its columns.
    #[inline(never)]
    pub(super) fn judge(
        &mut self,
        inertia: &Inertia<T>,
        covariance: Mat<T, 6, 6>,
        considered: &Considered<T, P>,
    ) -> Verdict {
        let Some(doubted) = &self.doubted else { return Verdict::Undecided };
        let mut sum = covariance + doubted.factors.covariance();
        let later = considered.of_inertia();
        for (later, earlier) in later.iter().zip(&doubted.columns) {
            let change = Mat::<T, 6, 1>::from_fn(|k, _| later[k] - earlier[k]);
            sum += change * change.transpose();
        }
        let most = inertia.trace_kg_m2() * T::lit(DECISIVE / 3.0);
        if !(0..6).all(|i| sum.at(i, i) <= most * most) {
            return Verdict::Undecided;
        }
        let (now, before) = (inertia.elements_kg_m2(), doubted.inertia.elements_kg_m2());
        let difference = core::array::from_fn(|k| now[k] - before[k]);
        // A sum that is not positive definite says nothing.
        match quadratic_over(&mut sum, difference) {
            None => Verdict::Undecided,
            Some(chi_square) if chi_square > T::lit(CONTRADICTED) => {
                self.doubted = None;
                Verdict::Changed
            }
            Some(_) => {
                self.row = Some(0);
                Verdict::Interrupted
            }
        }
    }

    /// The next row of the fusion; after the last one nothing is in doubt.
    #[inline(never)]
    pub(super) fn next_row(&mut self) -> Option<Row<T, P>> {
        let (index, doubted) = (usize::from(self.row?), self.doubted.as_ref()?);
        let row = (index < 6).then(|| doubted.row(index));
        if index < 5 {
            self.row = Some(index as u8 + 1);
        } else {
            self.restart();
            self.doubted = None;
        }
        row
    }
}

impl<T: Real, const P: usize> Snapshot<T, P> {
    /// Row `index` of `U₀⁻¹`, with its measurement: `r U₀ = eᵢᵀ`, from the diagonal to the right.
    fn row(&self, index: usize) -> Row<T, P> {
        let mut h = [T::zero(); 9];
        let elements = self.inertia.elements_kg_m2();
        let mut value_kg_m2 = T::zero();
        let mut columns = [T::zero(); P];
        for k in index..6 {
            let mut r = if k == index { T::one() } else { T::zero() };
            for m in index..k {
                r -= h[3 + m] * self.factors.u(m, k);
            }
            h[3 + k] = r;
            value_kg_m2 += r * elements[k];
            for (sum, column) in columns.iter_mut().zip(&self.columns) {
                *sum += r * column[k];
            }
        }
        Row { h, value_kg_m2, variance: self.factors.d(index), columns }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INERTIA: [f64; 6] = [2.0, 3.0, 4.0, 0.1, -0.2, 0.3];

    fn snapshot(variances: [f64; 6]) -> Snapshot<f64, 0> {
        let mut factors = Ud::diagonal(variances);
        for k in 1..6 {
            for i in 0..k {
                factors.set_u(i, k, 0.1 * (i as f64 - 0.7 * k as f64));
            }
        }
        Snapshot { inertia: Inertia::new(INERTIA), factors, columns: [] }
    }

    fn doubted(variances: [f64; 6]) -> Doubt<f64, 0> {
        let mut doubt = Doubt::none();
        doubt.keep(snapshot(variances));
        doubt.interrupt();
        doubt
    }

    #[test]
    fn the_older_snapshot_is_doubted() {
        let mut doubt = Doubt::<f64, 0>::none();
        assert_eq!(doubt.advance(true), Task::Snapshot);
        for x in [1.0, 2.0, 3.0] {
            doubt.keep(Snapshot { inertia: Inertia::new([x; 6]), ..snapshot([1.0; 6]) });
        }
        doubt.interrupt();
        assert_eq!(doubt.doubted.map(|d| d.inertia.elements_kg_m2()[0]), Some(2.0));
        // A second lock-out keeps it.
        doubt.interrupt();
        assert_eq!(doubt.doubted.map(|d| d.inertia.elements_kg_m2()[0]), Some(2.0));
    }

    #[test]
    fn no_snapshot_is_taken_during_a_shift() {
        let mut doubt = Doubt::<f64, 0>::none();
        doubt.keep(snapshot([1.0; 6]));
        assert!((0..200).all(|_| doubt.advance(false) == Task::Nothing));
        assert_eq!(doubt.advance(true), Task::Snapshot);
    }

    #[test]
    fn chi_square_decides_once_the_later_data_are_decisive() {
        let judge = |variance: f64, change: f64| {
            let mut doubt = doubted([1e-6; 6]);
            let mut later = INERTIA;
            later[1] += change;
            let covariance = Mat::from_diagonal_element(variance);
            doubt.judge(&Inertia::new(later), covariance, &Considered::NOTHING)
        };
        // 0.35 % of 3 kg m² is 0.0104 kg m².
        assert_eq!(judge(1.2e-4, 0.0), Verdict::Undecided);
        assert_eq!(judge(0.9e-4, 0.0), Verdict::Interrupted);
        assert_eq!(judge(0.9e-4, 0.03), Verdict::Interrupted);
        assert_eq!(judge(0.9e-4, 0.06), Verdict::Changed);
    }

    /// Six rows taken in one after the other, against the weighted mean of two estimates.
    #[test]
    fn fusion_is_the_weighted_mean() {
        let mut doubt = doubted([0.2, 0.3, 0.1, 0.4, 0.2, 0.5]);
        let earlier = snapshot([0.2, 0.3, 0.1, 0.4, 0.2, 0.5]).factors.covariance();
        let mut later = Ud::diagonal([0.5, 0.6, 0.7, 0.2, 0.3, 0.4, 0.3, 0.2, 0.1]);
        later.set_u(0, 5, 0.3);
        later.set_u(4, 7, -0.5);
        let before: Mat<f64, 6, 6> = later.covariance_of_last();
        let mut state = Mat::<f64, 9, 1>::from_fn(|i, _| 0.1 * i as f64);
        let j = state.fixed_rows::<6>(3).into_owned();
        doubt.row = Some(0);
        while let Some(row) = doubt.next_row() {
            let h = Mat::<f64, 9, 1>::from(row.h);
            let (gain, _) = later.observe_along(&row.h, row.variance);
            state += Mat::<f64, 9, 1>::from(gain) * (row.value_kg_m2 - h.dot(&state));
        }
        let (a, b) = (before.try_inverse().unwrap(), earlier.try_inverse().unwrap());
        let covariance = (a + b).try_inverse().unwrap();
        let mean = covariance * (a * j + b * Mat::<f64, 6, 1>::from(INERTIA));
        assert!((later.covariance_of_last::<6>() - covariance).abs().max() < 1e-12);
        assert!((state.fixed_rows::<6>(3) - mean).abs().max() < 1e-12);
        assert!(!doubt.is_present());
    }
}
