//! Faults of gyro, clock, tachometers and torque report, applied to the samples of a flight.

use nalgebra::Vector3;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

use super::{Drawn, micros};
use crate::input::log::LogRow;
use crate::input::scenario::Fault;
use crate::input::scenario::fault::FaultKind;

/// A sample as it reaches the estimator.
#[derive(Clone, Debug, PartialEq)]
pub struct Timed {
    /// True time since the first sample, µs.
    pub elapsed_us: u64,
    /// Content, with the stamp that the estimator reads.
    pub row: LogRow,
}

/// The samples of a flight after its faults, in the order of arrival. `noise_rad_s` is the stated gyro
/// noise.
///
/// The clock reads the sum of all jumps back at the first sample, since stamps are not negative.
pub fn inject(rows: Vec<LogRow>, faults: &[Fault], noise_rad_s: f64, seed: u64) -> Vec<Timed> {
    let back_us: u64 = faults.iter().map(|fault| micros(backwards_s(fault))).sum();
    let mut samples: Vec<Timed> = rows
        .into_iter()
        .map(|row| Timed {
            elapsed_us: row.time_us,
            row: LogRow { time_us: row.time_us + back_us, ..row },
        })
        .collect();
    for (index, fault) in faults.iter().enumerate() {
        let drawn = Drawn::new(fault, index, seed);
        apply(&mut samples, fault, drawn, noise_rad_s);
    }
    samples
}

/// Size of a jump back of the stamps, s.
fn backwards_s(fault: &Fault) -> f64 {
    match fault.kind {
        FaultKind::StampJump | FaultKind::ClockSet => (-fault.magnitude).max(0.0),
        _ => 0.0,
    }
}

/// Applies one fault.
fn apply(samples: &mut Vec<Timed>, fault: &Fault, mut drawn: Drawn, noise_rad_s: f64) {
    use FaultKind as Kind;
    match fault.kind {
        Kind::GyroDropout => {
            let mut hits = 0;
            samples.retain(|s| !drawn.is_hit(s.elapsed_us, fault.share, &mut hits));
        }
        Kind::Reset | Kind::ColdReset | Kind::PowerCut => {
            // Zero duration: a restart between two samples.
            let off = drawn.start_us..drawn.end_us;
            samples.retain(|s| !off.contains(&s.elapsed_us));
        }
        Kind::BitFlip => {}
        Kind::Duplicate => duplicate(samples, fault, &mut drawn),
        Kind::Reordered => reorder(samples, fault, &mut drawn),
        Kind::ClockSet => {
            let set = samples.iter_mut().filter(|s| s.elapsed_us >= drawn.start_us);
            set.for_each(|s| shift(&mut s.row, fault.magnitude));
        }
        Kind::TachometerLate => late(samples, fault, &mut drawn),
        _ => {
            let mut damage = Damage { fault, noise_rad_s, held: None };
            let mut hits = 0;
            for sample in samples {
                if drawn.is_hit(sample.elapsed_us, fault.share, &mut hits) {
                    damage.of(&mut sample.row, &mut drawn.random);
                }
            }
        }
    }
}

fn duplicate(samples: &mut Vec<Timed>, fault: &Fault, drawn: &mut Drawn) {
    let mut hits = 0;
    *samples = std::mem::take(samples)
        .into_iter()
        .flat_map(|sample| {
            let twice = drawn.is_hit(sample.elapsed_us, fault.share, &mut hits);
            let copy = twice.then(|| sample.clone());
            [Some(sample), copy].into_iter().flatten()
        })
        .collect();
}

fn reorder(samples: &mut [Timed], fault: &Fault, drawn: &mut Drawn) {
    let (mut hits, mut at) = (0, 0);
    while at + 1 < samples.len() {
        if drawn.is_hit(samples[at].elapsed_us, fault.share, &mut hits) {
            samples.swap(at, at + 1);
            at += 1; // a sample is late by one place at most
        }
        at += 1;
    }
}

fn late(samples: &mut [Timed], fault: &Fault, drawn: &mut Drawn) {
    let actual: Vec<(u64, Vec<f64>)> =
        samples.iter().map(|s| (s.elapsed_us, s.row.wheel_speed_rad_s.clone())).collect();
    let delay_us = micros(fault.magnitude);
    let mut hits = 0;
    for sample in samples {
        let shown_us = sample.elapsed_us.saturating_sub(delay_us);
        if drawn.is_hit(sample.elapsed_us, fault.share, &mut hits) {
            let earlier = actual.iter().rev().find(|(us, _)| *us <= shown_us);
            let Some((_, speeds)) = earlier.or(actual.first()) else { return };
            for (wheel, speed) in sample.row.wheel_speed_rad_s.iter_mut().enumerate() {
                if fault.wheel.is_none_or(|only| only == wheel) {
                    *speed = speeds[wheel];
                }
            }
        }
    }
}

/// Moves a stamp by this offset, s.
fn shift(row: &mut LogRow, by_s: f64) {
    row.time_us = row.time_us.saturating_add_signed((by_s * 1e6).round() as i64);
}

/// Fault of the content of single samples.
struct Damage<'a> {
    fault: &'a Fault,
    noise_rad_s: f64,
    /// Content at the start, for readings that are repeated.
    held: Option<LogRow>,
}

impl Damage<'_> {
    fn of(&mut self, row: &mut LogRow, random: &mut impl Rng) {
        let magnitude = self.fault.magnitude;
        let held = self.held.get_or_insert_with(|| row.clone());
        let held = (held.rate_rad_s, held.wheel_speed_rad_s.clone());
        match self.fault.kind {
            FaultKind::StampJump => shift(row, magnitude),
            FaultKind::TorqueNotExecuted => self.on_axes(&mut row.torque_n_m, |t, _| t + magnitude),
            FaultKind::TorqueNotReported => {
                self.on_axes(&mut row.torque_n_m, |t, _| t * (1.0 - magnitude));
            }
            _ => {
                self.on_axes(&mut row.rate_rad_s, |rate, axis| {
                    self.reading(rate, held.0[axis], random)
                });
                for (wheel, speed) in row.wheel_speed_rad_s.iter_mut().enumerate() {
                    if self.fault.wheel.is_none_or(|only| only == wheel) {
                        *speed = self.speed(*speed, held.1[wheel]);
                    }
                }
            }
        }
    }

    fn on_axes(&self, vector: &mut Vector3<f64>, mut damage: impl FnMut(f64, usize) -> f64) {
        for axis in (0..3).filter(|axis| self.fault.axis.is_none_or(|only| only == *axis)) {
            vector[axis] = damage(vector[axis], axis);
        }
    }

    /// Reading of the gyro on one axis, rad/s.
    fn reading(&self, rate: f64, held: f64, random: &mut impl Rng) -> f64 {
        let magnitude = self.fault.magnitude;
        match self.fault.kind {
            FaultKind::GyroSpike => rate + signed(magnitude, random),
            FaultKind::GyroStuck => held,
            FaultKind::GyroZero => 0.0,
            FaultKind::GyroSaturation => rate.clamp(-magnitude, magnitude),
            FaultKind::GyroBias => rate + magnitude,
            FaultKind::GyroNoise => {
                // Independent of the noise that the reading has: the variances add up to k² σ².
                let normal: f64 = StandardNormal.sample(random);
                rate + self.noise_rad_s * (magnitude * magnitude - 1.0).sqrt() * normal
            }
            FaultKind::GyroNan => f64::NAN,
            FaultKind::GyroInfinite => signed(f64::INFINITY, random),
            _ => rate,
        }
    }

    /// Reading of a tachometer, rad/s.
    fn speed(&self, speed: f64, held: f64) -> f64 {
        let magnitude = self.fault.magnitude;
        match self.fault.kind {
            FaultKind::TachometerDropout => 0.0,
            FaultKind::TachometerFreeze => held,
            FaultKind::TachometerSign => -speed,
            FaultKind::TachometerEdges => speed * (1.0 - magnitude),
            FaultKind::TachometerFactor => speed * magnitude,
            _ => speed,
        }
    }
}

fn signed(size: f64, random: &mut impl Rng) -> f64 {
    if random.random::<bool>() { size } else { -size }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::scenario::fault::KINDS;

    fn rows() -> Vec<LogRow> {
        let row = |k: u64| LogRow {
            line: k + 2,
            time_us: k * 100_000,
            rate_rad_s: Vector3::new(0.1, 0.2, 0.3) * (1.0 + k as f64 * 0.01),
            wheel_speed_rad_s: vec![100.0 + k as f64, -50.0 - k as f64],
            torque_n_m: Vector3::new(1e-3, 0.0, 0.0),
            attitude: None,
        };
        (0..100).map(row).collect()
    }

    fn fault(kind: FaultKind, magnitude: f64) -> Fault {
        Fault {
            kind,
            start_s: 2.0,
            latest_start_s: 2.0,
            duration_s: 3.0,
            magnitude,
            share: 1.0,
            axis: None,
            wheel: None,
        }
    }

    fn damaged(fault: Fault) -> Vec<Timed> {
        inject(rows(), &[fault], 1e-4, 7)
    }

    #[test]
    fn a_fault_alters_its_interval_alone() {
        for row in &KINDS {
            if row.kind == FaultKind::ClockSet || row.kind.is_of_the_computer() {
                continue;
            }
            let samples = damaged(fault(row.kind, 0.3));
            let outside = |us: u64| !(2_000_000..=5_000_000).contains(&us);
            let kept: Vec<&LogRow> =
                samples.iter().filter(|s| outside(s.elapsed_us)).map(|s| &s.row).collect();
            let all = rows();
            let clean: Vec<&LogRow> = all.iter().filter(|r| outside(r.time_us)).collect();
            assert_eq!(kept, clean, "{}", row.name);
            let within = |us: u64| (2_000_000..5_000_000).contains(&us);
            let altered = samples.len() != 100
                || samples.iter().zip(&all).any(|(s, r)| within(s.elapsed_us) && s.row != *r);
            assert!(altered, "{}", row.name);
        }
    }

    #[test]
    fn each_reading_is_that_of_its_kind() {
        let at = |fault: Fault| damaged(fault)[30].row.clone();
        let clean = rows()[30].clone();
        assert_eq!(
            at(fault(FaultKind::GyroBias, 0.5)).rate_rad_s,
            clean.rate_rad_s.add_scalar(0.5)
        );
        assert_eq!(at(fault(FaultKind::GyroStuck, 0.0)).rate_rad_s, rows()[20].rate_rad_s);
        assert!(at(fault(FaultKind::GyroSaturation, 0.05)).rate_rad_s.amax() <= 0.05);
        assert!(at(fault(FaultKind::GyroNan, 0.0)).rate_rad_s.x.is_nan());
        assert_eq!(at(fault(FaultKind::TachometerSign, 0.0)).wheel_speed_rad_s, [-130.0, 80.0]);
        assert_eq!(at(fault(FaultKind::TachometerLate, 1.0)).wheel_speed_rad_s, [120.0, -70.0]);
        let one = Fault { wheel: Some(1), ..fault(FaultKind::TachometerEdges, 0.5) };
        assert_eq!(at(one).wheel_speed_rad_s, [130.0, -40.0]);
        assert_eq!(at(fault(FaultKind::TorqueNotReported, 1.0)).torque_n_m, Vector3::zeros());
    }

    #[test]
    fn stamps_jump_and_clocks_are_set_both_ways() {
        let stamps = |fault: Fault| -> Vec<i64> {
            damaged(fault).iter().map(|s| s.row.time_us as i64 - s.elapsed_us as i64).collect()
        };
        let single = Fault { duration_s: 0.0, ..fault(FaultKind::StampJump, -1.0) };
        let offsets = stamps(single);
        assert_eq!((offsets[19], offsets[20], offsets[21]), (1_000_000, 0, 1_000_000));
        let offsets = stamps(fault(FaultKind::ClockSet, 3600.0));
        assert_eq!((offsets[19], offsets[20], offsets[99]), (0, 3_600_000_000, 3_600_000_000));
    }

    #[test]
    fn a_share_of_the_samples_is_drawn_by_the_seed() {
        let some = Fault { share: 0.5, ..fault(FaultKind::GyroDropout, 0.0) };
        let samples = damaged(some);
        assert!((75..95).contains(&samples.len()), "{}", samples.len());
        assert_eq!(samples, damaged(some));
        assert_ne!(samples, inject(rows(), &[some], 1e-4, 8));
        assert_eq!(damaged(fault(FaultKind::Duplicate, 0.0)).len(), 130);
    }
}
