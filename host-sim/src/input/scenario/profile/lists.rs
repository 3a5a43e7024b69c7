//! Profiles from lists in the scenario: sums of sines, points, and intervals.

use flight_input::InputError;
use flight_input::key::{FINITE, Key};
use flight_input::section::{List, Section};
use flight_input::words::numbers;
use toml::Spanned;

use super::super::problem::ScenarioProblem;
use super::keys::{AMPLITUDE, FREQUENCY, PHASE, POINT, SWEEP, TIME};
use super::torque::{Sine, TorqueProfile};

/// A profile's lists for one axis. `suffix` is empty for a wheel, else the axis as `[1]`.
pub(super) struct Axis<'a> {
    pub section: &'a Section<'a>,
    pub suffix: &'a str,
}

/// The lists of one sum of sines.
pub(super) struct SineLists<'a> {
    pub amplitude: &'a List,
    pub frequency: &'a List,
    pub phase: &'a List,
    pub sweep: Option<&'a List>,
}

impl Axis<'_> {
    /// A sum of sines.
    pub(super) fn multisine(&self, lists: &SineLists<'_>) -> Result<TorqueProfile, InputError> {
        let SineLists { amplitude, frequency, phase, sweep } = *lists;
        let amplitude_name = self.name(&AMPLITUDE);
        let count = amplitude.get_ref().len();
        self.section.all_in(&amplitude_name, &FINITE, amplitude)?;
        for (key, list) in [(FREQUENCY, Some(frequency)), (PHASE, Some(phase)), (SWEEP, sweep)] {
            if let Some(list) = list {
                self.finite_of_length(&key, list, &amplitude_name, count)?;
            }
        }
        let term = |i: usize| Sine {
            amplitude_n_m: amplitude.get_ref()[i],
            frequency_hz: frequency.get_ref()[i],
            sweep_hz_s: sweep.map_or(0.0, |sweep| sweep.get_ref()[i]),
            phase_rad: phase.get_ref()[i],
        };
        Ok(TorqueProfile::Multisine { terms: (0..count).map(term).collect() })
    }

    /// Linear interpolation between points.
    pub(super) fn points(&self, time: &List, value: &List) -> Result<TorqueProfile, InputError> {
        let time_s = time.get_ref();
        let ascends = time_s.windows(2).all(|pair| pair[0] < pair[1]);
        if time_s.is_empty() || !ascends || time_s.iter().any(|t| !t.is_finite()) {
            return Err(self.section.list_out_of_range(&TIME, time));
        }
        self.finite_of_length(&POINT, value, &self.section.full(&TIME), time_s.len())?;
        Ok(TorqueProfile::Table { time_s: time_s.clone(), value_n_m: value.get_ref().clone() })
    }

    fn name(&self, key: &Key) -> String {
        format!("{}{}", self.section.full(key), self.suffix)
    }

    fn finite_of_length(
        &self,
        key: &Key,
        list: &List,
        other: &str,
        required: usize,
    ) -> Result<(), InputError> {
        let (key, found) = (self.name(key), list.get_ref().len());
        self.section.all_in(&key, &FINITE, list)?;
        if found == required {
            return Ok(());
        }
        let other = other.to_owned();
        Err(self
            .section
            .error(list, ScenarioProblem::UnequalLengths { key, found, other, required }))
    }
}

/// Intervals in which a profile acts, ascending and disjoint; at least one.
pub(in super::super) fn intervals_s(
    section: &Section<'_>,
    key: &Key,
    during_s: &Spanned<Vec<Vec<f64>>>,
) -> Result<Vec<[f64; 2]>, InputError> {
    let lists = during_s.get_ref();
    let pairs: Option<Vec<[f64; 2]>> =
        lists.iter().map(|list| <[f64; 2]>::try_from(list.as_slice()).ok()).collect();
    let times: Vec<f64> = lists.concat();
    let are_in_order = times.iter().all(|time_s| time_s.is_finite())
        && lists.iter().all(|list| list.is_sorted_by(|a, b| a < b))
        && times.is_sorted();
    match pairs {
        Some(pairs) if are_in_order && !pairs.is_empty() => Ok(pairs),
        _ => {
            let found: Vec<String> = lists.iter().map(|list| numbers(list)).collect();
            Err(section.out_of_range(key, during_s, format!("[{}]", found.join(", "))))
        }
    }
}
