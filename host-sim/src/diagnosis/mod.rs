//! Diagnosis of a log: which single cause explains that residuals differ from the noise.
//!
//! ```text
//! Craft, rows ─► record ─► mistakes: changed records ─┐
//!                   └────► hardware: further unknowns ┴─► fit (start, pass, model) ─► ranking ─► Explanation
//! ```
//!
//! Every candidate is fitted to the whole log, in `f64`, with initial momentum and inertia free: a mistake of people
//! as a change of log or craft file that undoes it, an error of the hardware as further unknowns with a wide prior.
//! Its score is the decrease of chi-square against the fit of the log as it is, less `k ln n` for k unknowns and n
//! readings (Bayesian information criterion). The noise is measured from differences of the readings, and outliers are
//! refused before any fit, which distinguishes both from an error of the model.
//!
//! Chi-square includes the prior of the inertia, if the craft states one, the distance of the fit to a physical tensor,
//! and the ratio of measured to stated noise. A cause that scales or turns everything alike moves none of them without a
//! prior, and is not found: see `docs/diagnose.md`.

mod fit;
mod hardware;
mod innovations;
mod mistakes;
mod mode;
mod model;
mod pass;
mod record;
mod start;

use rayon::prelude::*;

pub use innovations::innovations;

use crate::input::Craft;
use crate::input::log::LogRow;
use fit::{Fit, Problem, Unknowns};
use hardware::Group;
use mistakes::Mistake;
use model::Unknown;
use record::{MARGIN, MOST_COARSE_ROWS, MOST_ROWS, Record};

/// Fewest rows of a diagnosis.
const FEWEST_ROWS: usize = 4 * MARGIN;
/// Decrease of chi-square from which on an explanation of positive score is reported: chance reaches it once in 200,000 logs
/// with four unknowns (chi-square), and the score asks for more of those with five or more.
const LEAST_DECREASE: f64 = 30.0;
/// Share of the excess that an explanation must account for.
const LEAST_SHARE: f64 = 0.02;
/// Difference of scores below which two explanations are not distinguished.
const SAME_SCORE: f64 = 10.0;
/// Cost of each elementary step of a mistake, as a flip or an exchange: orders causes that are equivalent.
const STEP_COST: f64 = 1.0;
/// Error of a stated gyro noise that is none, one sigma, share: noise density is a typical value.
const NOISE_TOLERANCE: f64 = 0.2;
/// Most mistakes that are fitted beyond the first stage.
const MOST_FITTED: usize = 10;
/// Most shifts of the same columns among them.
const MOST_NEIGHBOURS: usize = 2;
/// Most explanations.
const MOST: usize = 12;

/// One explanation of the residuals.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// Name, as `time offset` or `sign of wheel 2`.
    pub name: String,
    /// Component of largest significance, as `x` or `wheel 2`; empty where there is but one.
    pub component: String,
    /// Its value and one sigma, in `unit`; none for a mistake that has no number.
    pub value: Option<(f64, f64)>,
    /// Unit of the value; empty for a share or a count.
    pub unit: &'static str,
    /// Decrease of chi-square.
    pub chi_square: f64,
    /// Decrease over the excess of chi-square over the number of readings, 0 to 1.
    pub share: f64,
    /// Line for the craft file, or the correction of the log.
    pub remedy: String,
    /// Names of explanations whose score does not differ.
    pub same_as: Vec<String>,
    score: f64,
}

/// Result of a diagnosis.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnosis {
    /// Chi-square of the log as it is, with the noise as stated; not finite where no model follows the motion.
    pub chi_square: f64,
    /// Number of scalar readings.
    pub readings: f64,
    /// Measured gyro noise, one sigma, rad/s.
    pub noise_rad_s: f64,
    /// Explanations, best first.
    pub explanations: Vec<Explanation>,
}

/// The log as it is, with which all candidates are compared.
struct Reference<'a> {
    craft: &'a Craft,
    record: Record,
    base: Unknowns,
    coarse: Option<Fit>,
    null: Option<Fit>,
    /// Chi-square of the log as it is.
    chi_square: f64,
    readings: f64,
}

/// Diagnoses a log. None for a log of too few rows.
pub fn diagnose(craft: &Craft, rows: &[LogRow]) -> Option<Diagnosis> {
    if rows.len() < FEWEST_ROWS {
        return None;
    }
    let mut record = Record::new(craft, rows);
    let outliers = record.outliers();
    outliers.iter().for_each(|row| record.weight[*row] = 0.0);
    let reference = Reference::new(craft, record);
    let mistakes = mistakes::all(&reference.record);
    let groups = hardware::groups(&reference.record, &reference.base);
    let candidates = reference.promising(&mistakes);
    let mut all: Vec<Explanation> = candidates
        .par_iter()
        .filter_map(|(mistake, coarse)| reference.of_mistake(mistake, coarse))
        .collect();
    all.par_extend(groups.par_iter().filter_map(|group| reference.of_group(group)));
    all.extend(reference.of_mode());
    all.extend(reference.of_noise());
    all.extend(reference.of_outliers(&outliers, rows));
    Some(Diagnosis {
        chi_square: reference.chi_square,
        readings: reference.readings,
        noise_rad_s: reference.record.noise_rad_s,
        explanations: ranked(all),
    })
}

/// Sorted by score, with those named that do not differ.
fn ranked(mut all: Vec<Explanation>) -> Vec<Explanation> {
    all.retain(|e| e.score > 0.0 && e.chi_square > LEAST_DECREASE && e.share > LEAST_SHARE);
    all.sort_by(|a, b| b.score.total_cmp(&a.score));
    all.truncate(MOST);
    let scores: Vec<(String, f64)> = all.iter().map(|e| (e.name.clone(), e.score)).collect();
    for explanation in &mut all {
        let is_same = |(name, score): &&(String, f64)| {
            *name != explanation.name && (score - explanation.score).abs() < SAME_SCORE
        };
        explanation.same_as = scores.iter().filter(is_same).map(|(name, _)| name.clone()).collect();
    }
    all
}

impl<'a> Reference<'a> {
    fn new(craft: &'a Craft, raw: Record) -> Self {
        let mut base = Vec::new();
        if craft.solve_for.torque {
            base.extend((0..3).map(Unknown::Torque));
        }
        if craft.solve_for.gyro_bias {
            base.extend((0..3).map(Unknown::Bias));
        }
        let base = Unknowns::of(base);
        let record = raw.averaged(MOST_ROWS);
        let coarse = coarse(craft, &raw, &base);
        let problem = Problem::new(&record, &base, craft.prior.as_ref());
        let null = coarse.as_ref().and_then(|coarse| problem.whole(coarse));
        let readings = record.readings();
        let about_mean = chi_square_about_mean(&record);
        let found = null.as_ref().map_or(about_mean, |fit| fit.chi_square.min(about_mean));
        let unused = null.as_ref().map_or(0.0, |fit| fit.unused_squares);
        let mut reference =
            Self { craft, record: raw, base, coarse, null, chi_square: 0.0, readings };
        reference.chi_square =
            (found + unused) * reference.unit(1.0) + reference.noise_contradiction(1.0);
        reference
    }

    /// Squared ratio of measured to stated noise for readings times a factor, one within the tolerance and below: the
    /// chi-square of the stated noise is that of the measured one times this.
    fn unit(&self, factor: f64) -> f64 {
        let stated = self.craft.gyro.reading_sigma_rad_s();
        let ratio = stated.map_or(1.0, |stated| self.record.noise_rad_s * factor / stated);
        if ratio.ln() > NOISE_TOLERANCE { ratio * ratio } else { 1.0 }
    }

    /// Squared deviation of the noise from the stated one, over the tolerance, for readings times a factor.
    fn noise_contradiction(&self, factor: f64) -> f64 {
        let Some(stated) = self.craft.gyro.reading_sigma_rad_s() else { return 0.0 };
        let ratio = (self.record.noise_rad_s * factor / stated).ln() / NOISE_TOLERANCE;
        ratio * ratio
    }

    /// Chi-square of the fit of the log as it is, without outliers, in units of the stated noise.
    fn chi_square_used(&self) -> f64 {
        let unused = self.null.as_ref().map_or(0.0, |fit| fit.unused_squares);
        self.chi_square - unused * self.unit(1.0)
    }

    /// An explanation that leaves this chi-square with `unknowns` more.
    fn explanation(
        &self,
        name: String,
        remedy: String,
        decrease: f64,
        unknowns: f64,
    ) -> Explanation {
        let excess = (self.chi_square - self.readings).max(1.0);
        Explanation {
            name,
            component: String::new(),
            value: None,
            unit: "",
            chi_square: decrease,
            share: (decrease / excess).clamp(0.0, 1.0),
            remedy,
            same_as: Vec::new(),
            score: decrease - unknowns * self.readings.max(3.0).ln(),
        }
    }

    /// The mistakes whose first stage is better than that of the log as it is, the best ones.
    fn promising<'m>(&self, mistakes: &'m [Mistake]) -> Vec<(&'m Mistake, Fit)> {
        let of_reading = |fit: &Fit| fit.chi_square / fit.readings;
        let noise = |factor: f64| self.noise_contradiction(factor) / self.readings;
        let limit = self
            .coarse
            .as_ref()
            .map_or(f64::INFINITY, |fit| of_reading(fit) + noise(1.0) - SAME_SCORE / fit.readings);
        let candidate = |mistake: &'m Mistake| {
            let record = mistake.undone(&self.record);
            let fit = coarse(self.craft, &record, &self.base)?;
            let score = of_reading(&fit) + noise(mistake.gyro_factor());
            (score < limit).then_some((mistake, fit, score))
        };
        let mut all: Vec<_> = mistakes.par_iter().filter_map(candidate).collect();
        all.sort_by(|a, b| a.2.total_cmp(&b.2));
        let mut shifted = Vec::new();
        all.retain(|(mistake, ..)| {
            let neighbours = shifted.iter().filter(|of| **of == mistake.shifted()).count();
            shifted.extend(mistake.shifted().map(Some));
            mistake.shifted().is_none() || neighbours < MOST_NEIGHBOURS
        });
        all.truncate(MOST_FITTED);
        all.into_iter().map(|(mistake, fit, _)| (mistake, fit)).collect()
    }

    fn of_mistake(&self, mistake: &Mistake, coarse: &Fit) -> Option<Explanation> {
        let record = mistake.undone(&self.record).averaged(MOST_ROWS);
        let fit = Problem::new(&record, &self.base, self.craft.prior.as_ref()).whole(coarse)?;
        // A change that drops readings is compared on the mean of a reading.
        let of_readings = self.readings / fit.readings;
        let factor = mistake.gyro_factor();
        let left = fit.chi_square * of_readings * self.unit(factor);
        let left = left + self.noise_contradiction(factor);
        let decrease = self.chi_square_used() - left;
        let mut explanation =
            self.explanation(mistake.name.clone(), mistake.remedy.clone(), decrease, 0.0);
        explanation.score -= STEP_COST * mistake.steps as f64;
        Some(explanation)
    }

    fn of_group(&self, group: &Group) -> Option<Explanation> {
        let record = self.record.averaged(MOST_ROWS);
        let mut names = self.base.names.clone();
        names.extend(&group.unknowns);
        let unknowns = Unknowns::of(names);
        let coarse = coarse(self.craft, &self.record, &unknowns)?;
        let fit = Problem::new(&record, &unknowns, self.craft.prior.as_ref()).whole(&coarse)?;
        let left = fit.chi_square * self.unit(1.0) + self.noise_contradiction(1.0);
        let remedy = hardware::remedy(group.name, &fit, &unknowns.names, &record);
        let decrease = self.chi_square_used() - left;
        let count = group.unknowns.len() as f64;
        let mut explanation = self.explanation(group.name.to_owned(), remedy, decrease, count);
        let significance = |i: &usize| (fit.values[*i] / fit.sigmas[*i]).abs();
        let places = self.base.names.len()..unknowns.names.len();
        let largest = places.max_by(|a, b| significance(a).total_cmp(&significance(b)))?;
        explanation.value = Some((fit.values[largest], fit.sigmas[largest]));
        explanation.component = hardware::component(unknowns.names[largest]);
        explanation.unit = unknowns.names[largest].unit();
        Some(explanation)
    }

    /// A flexible appendage or slosh: six elements, frequency and damping.
    fn of_mode(&self) -> Option<Explanation> {
        const UNKNOWNS: f64 = 8.0;
        let null = self.null.as_ref()?;
        // No cause can explain that much, to two standard errors of chi-square.
        let scatter = 2.0 * (2.0 * self.readings).sqrt();
        if self.chi_square_used() - self.readings < LEAST_DECREASE - scatter {
            return None;
        }
        let record = self.record.averaged(MOST_ROWS);
        let problem = Problem::new(&record, &self.base, self.craft.prior.as_ref());
        let fit_of = |drive: &Fit| {
            let mode = mode::search(&problem, null, drive)?;
            let start = null.with_unknowns(mode.unknowns.names.len());
            let prior = self.craft.prior.as_ref();
            let fit = Problem::new(&record, &mode.unknowns, prior).whole(&start)?;
            Some((mode, fit))
        };
        let (mut mode, mut fit) = fit_of(null)?;
        if let Some(second) = fit_of(&fit)
            && second.1.chi_square < fit.chi_square
        {
            (mode, fit) = second;
        }
        let left = fit.chi_square * self.unit(1.0) + self.noise_contradiction(1.0);
        let remedy =
            format!("[[mode]] frequency_hz = {:.4}, damping = {}", mode.frequency_hz, mode.damping);
        let name = "flexible mode or slosh".to_owned();
        let mut explanation =
            self.explanation(name, remedy, self.chi_square_used() - left, UNKNOWNS);
        // Half the spacing of independent frequencies.
        let span_s = record.time_s.last()? - record.time_s.first()?;
        explanation.value = Some((mode.frequency_hz, 0.25 / span_s));
        explanation.unit = "Hz";
        Some(explanation)
    }

    /// Noise other than stated, as the differences of the readings have it. It explains no more than white residuals.
    fn of_noise(&self) -> Option<Explanation> {
        let noise = self.record.noise_rad_s;
        let stated = self.craft.gyro.reading_sigma_rad_s()?;
        if (noise / stated).ln().abs() < NOISE_TOLERANCE {
            return None;
        }
        let white = self.null.as_ref().map_or(0.0, |fit| fit.chi_square.min(self.readings));
        let decrease = white * (self.unit(1.0) - 1.0) + self.noise_contradiction(1.0);
        let remedy = format!("[gyro] noise_rad_s = {noise:.3e}");
        let mut explanation =
            self.explanation("gyro noise other than stated".to_owned(), remedy, decrease, 1.0);
        explanation.value = Some((noise, noise / (2.0 * self.readings).sqrt()));
        explanation.unit = "rad/s";
        Some(explanation)
    }

    fn of_outliers(&self, outliers: &[usize], rows: &[LogRow]) -> Option<Explanation> {
        let first = outliers.first()?;
        let decrease = self.null.as_ref()?.unused_squares * self.unit(1.0);
        let remedy = format!(
            "none: outliers are refused; the first is in line {} of the log",
            rows.get(*first)?.line
        );
        let count = outliers.len() as f64;
        let mut explanation = self.explanation("outliers".to_owned(), remedy, decrease, count);
        explanation.value = Some((count, 0.0));
        Some(explanation)
    }
}

/// First stage of the fit of a record.
fn coarse(craft: &Craft, record: &Record, unknowns: &Unknowns) -> Option<Fit> {
    if record.len() < FEWEST_ROWS {
        return None;
    }
    let record = record.averaged(MOST_COARSE_ROWS);
    Problem::new(&record, unknowns, craft.prior.as_ref()).coarse()
}

/// Chi-square of the readings about their mean: without any model.
fn chi_square_about_mean(record: &Record) -> f64 {
    let rows = MARGIN..record.len() - MARGIN;
    let weight: f64 = record.weight[rows.clone()].iter().sum();
    let mean = rows
        .clone()
        .map(|row| record.rate_rad_s[row] * record.weight[row])
        .sum::<nalgebra::Vector3<f64>>()
        / weight;
    let squares =
        rows.map(|row| (record.rate_rad_s[row] - mean).norm_squared() * record.weight[row]);
    squares.sum::<f64>() / (record.noise_rad_s * record.noise_rad_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::Scenario;
    use crate::simulation::log_of;
    use crate::truth::Flight;

    #[test]
    fn explanation_has_value_unit_share_and_remedy() {
        let scenario = Scenario::load("microsat-slew").unwrap();
        let mut log = log_of(&scenario, &Flight::simulate(&scenario).unwrap(), 5);
        log.iter_mut().for_each(|row| row.rate_rad_s.x *= 1.02);
        let found = diagnose(&scenario.craft(), &log).unwrap();
        let first = &found.explanations[0];
        assert_eq!((first.name.as_str(), first.component.as_str()), ("gyro scale factor", "x"));
        let (value, sigma) = first.value.unwrap();
        assert!((value - 0.02).abs() < 5.0 * sigma && sigma < 0.005, "{value} {sigma}");
        assert!(first.share > 0.8 && first.unit.is_empty(), "{first:?}");
        assert!(first.remedy.starts_with("[gyro] scale = ["), "{}", first.remedy);
    }

    #[test]
    fn short_log_has_no_diagnosis() {
        let scenario = Scenario::load("microsat-slew").unwrap();
        let log = log_of(&scenario, &Flight::simulate(&scenario).unwrap(), 5);
        assert_eq!(diagnose(&scenario.craft(), &log[..20]), None);
        assert!(diagnose(&scenario.craft(), &log[..24]).is_some());
    }
}
