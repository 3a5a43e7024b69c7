//! Check of each tachometer against the commanded torque of its motor.
//!
//! Input: speed and motor torque of each wheel, body rate, once per sample. Output: the wheels whose speed does not
//! follow their command, by number. A wheel whose command is unknown is not judged.
//!
//! The axial momentum of a wheel changes by its motor and its drag alone:
//!
//! ```text
//! Iₛ (ΔΩ + a · Δω) = ∫u dt − ∫d dt
//! ```
//!
//! `Iₛ` spin inertia, kg m²; `Ω` speed relative to the body, rad/s; `a` spin axis; `ω` body rate, rad/s; `u` commanded
//! motor torque, N m; `d` drag, N m. Over a stretch of commands of one sign, of T seconds, the speed follows its command
//! within
//!
//! ```text
//! |ΔΩ + a · Δω − ∫u dt / Iₛ| ≤ s |∫u dt| / Iₛ + d T / Iₛ + r
//! ```
//!
//! with the tolerance s of motor and spin inertia, the largest drag d, and the error r of two speeds ([`Config`]). A
//! tachometer that misses the share k of the motion (1: stuck or dead, 0.1: a tenth of the edges) is outside after
//! `r Iₛ / ((k − s) |u| − d)` seconds and three samples; not at all where its torque is below `d / (k − s)`. A motor off by m changes k by m.
//!
//! One wrong speed at the begin of a stretch is an error of all of it. The first stretch outside the limits is therefore no
//! fault yet, and the next begins at the present reading; the second one in a row is a fault, after twice that time. Either
//! ends with a stretch within the limits of at least the impulse at which the last one left them.

use fsw_core::Vec3;

/// Limits of the check.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    /// Tolerance of motor torque and spin inertia, share. Default 0.05: torque constant of a brushless motor over
    /// temperature 3 %, spin inertia 1 %, current loop 1 %.
    pub tolerance: f32,
    /// Largest drag of a wheel, N m. Default 2e-5: bearings of a wheel of 10 to 50 mN m s at full speed have 5e-6 to
    /// 2e-5.
    pub drag_n_m: f32,
    /// Error of two speeds, rad/s. Default 1.5: the slowest measurable speed, 0.52 rad/s with 24 edges
    /// ([`crate::drivers::wheel_tach`]), at both ends, and a margin of a half.
    pub resolution_rad_s: f32,
}

impl Default for Config {
    fn default() -> Self {
        Self { tolerance: 0.05, drag_n_m: 2e-5, resolution_rad_s: 1.5 }
    }
}

/// Readings in a row outside the limits that show a fault: an isolated wrong speed shows none.
const CONFIRMED: u8 = 3;

/// Longest stretch, s: the share of the drag in the limit grows with it.
const LONGEST_S: f32 = 10.0;

/// Longest time between two readings within a stretch, µs: the longest interval that a gate bridges.
const LONGEST_PAUSE_US: u64 = 1_000_000;

/// Check of `W` wheels.
#[derive(Debug, Clone, Copy)]
pub struct WheelCheck<const W: usize> {
    config: Config,
    last_us: Option<u64>,
    wheels: [Wheel; W],
}

/// One wheel. Without spin inertia it is not fitted.
#[derive(Debug, Clone, Copy)]
struct Wheel {
    /// Unit vector of the spin axis.
    axis: Vec3<f32>,
    spin_inertia_kg_m2: f32,
    /// `Ω + a · ω` at the last reading, rad/s.
    last_rad_s: f32,
    /// The present stretch; none before its first reading.
    stretch: Option<Stretch>,
    /// Readings in a row outside the limits.
    outside: u8,
    /// None for a wheel that follows its command.
    doubt: Option<Doubt>,
}

/// Doubt in a wheel after a stretch outside the limits.
#[derive(Debug, Clone, Copy)]
struct Doubt {
    /// Magnitude of the impulse at which the last stretch left the limits, N m s.
    impulse_n_m_s: f32,
    /// True after the second stretch in a row.
    is_found: bool,
}

/// A stretch of commands of one sign.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    /// `Ω + a · ω` at its begin, rad/s.
    begin_rad_s: f32,
    /// `∫u dt`, N m s.
    impulse_n_m_s: f32,
    duration_s: f32,
}

impl<const W: usize> WheelCheck<W> {
    /// Check of wheels with these spin axes and spin inertias, kg m²; zero for a place without a wheel.
    pub fn new(config: Config, axes: &[[f32; 3]; W], spin_inertia_kg_m2: &[f32; W]) -> Self {
        let mut inertias = spin_inertia_kg_m2.iter();
        let wheels = axes.map(|axis| {
            let (axis, spin) = (Vec3::from(axis), inertias.next().copied().unwrap_or(0.0));
            let norm = axis.norm();
            Wheel {
                axis: if norm > 0.0 { axis / norm } else { axis },
                spin_inertia_kg_m2: spin,
                last_rad_s: 0.0,
                stretch: None,
                outside: 0,
                doubt: None,
            }
        });
        Self { config, last_us: None, wheels }
    }

    /// Adds the speeds and body rate at `time_us`, rad/s, and the mean motor torque of each wheel since the last reading,
    /// N m; `None` where it is unknown.
    pub fn add(
        &mut self,
        time_us: u64,
        rate_rad_s: &Vec3<f32>,
        speed_rad_s: &[f32; W],
        torque_n_m: &[Option<f32>; W],
    ) {
        let elapsed_us = self.last_us.and_then(|last_us| time_us.checked_sub(last_us));
        let elapsed_us = elapsed_us.filter(|us| (1..=LONGEST_PAUSE_US).contains(us));
        let elapsed_s = elapsed_us.map(|us| us as f32 * 1e-6);
        self.last_us = Some(time_us);
        let readings = speed_rad_s.iter().zip(torque_n_m);
        for (wheel, (speed_rad_s, torque_n_m)) in self.wheels.iter_mut().zip(readings) {
            let at_rad_s = speed_rad_s + wheel.axis.dot(rate_rad_s);
            match elapsed_s.zip(torque_n_m.filter(|torque| torque.is_finite())) {
                Some((elapsed_s, torque)) if wheel.spin_inertia_kg_m2 > 0.0 => {
                    wheel.add(&self.config, at_rad_s, elapsed_s, torque);
                }
                _ => wheel.stretch = None,
            }
            wheel.last_rad_s = at_rad_s;
        }
    }

    /// Discards the present stretches, after a reading without speeds.
    pub fn interrupt(&mut self) {
        self.last_us = None;
    }

    /// True for each wheel that follows its command, or is not judged.
    pub fn follow(&self) -> [bool; W] {
        self.wheels.map(|wheel| !wheel.doubt.is_some_and(|doubt| doubt.is_found))
    }
}

impl Wheel {
    #[inline(never)] // one copy for all wheels
    fn add(&mut self, config: &Config, at_rad_s: f32, elapsed_s: f32, torque_n_m: f32) {
        let continues = |stretch: &Stretch| {
            stretch.impulse_n_m_s * torque_n_m >= 0.0 && stretch.duration_s < LONGEST_S
        };
        let mut stretch = self.stretch.filter(continues).unwrap_or(Stretch {
            begin_rad_s: self.last_rad_s,
            impulse_n_m_s: 0.0,
            duration_s: 0.0,
        });
        stretch.impulse_n_m_s += torque_n_m * elapsed_s;
        stretch.duration_s += elapsed_s;
        self.stretch = Some(stretch);

        let commanded_rad_s = stretch.impulse_n_m_s / self.spin_inertia_kg_m2;
        let drag_rad_s = config.drag_n_m * stretch.duration_s / self.spin_inertia_kg_m2;
        let allowed_rad_s =
            config.tolerance * commanded_rad_s.abs() + drag_rad_s + config.resolution_rad_s;
        let error_rad_s = (at_rad_s - stretch.begin_rad_s - commanded_rad_s).abs();
        let impulse_n_m_s = stretch.impulse_n_m_s.abs();
        // Not a number is inside.
        if error_rad_s > allowed_rad_s {
            self.outside = self.outside.saturating_add(1);
            if self.outside >= CONFIRMED {
                self.doubt = Some(Doubt { impulse_n_m_s, is_found: self.doubt.is_some() });
                (self.outside, self.stretch) = (0, None);
            }
        } else {
            self.outside = 0;
            self.doubt = self.doubt.filter(|doubt| impulse_n_m_s < doubt.impulse_n_m_s);
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::println;

    const SPIN_KG_M2: f32 = 2.1e-5;
    const TORQUE_N_M: f32 = 1e-3;
    const PERIOD_S: f32 = 0.1;
    const AXES: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];

    /// Two wheels: a square wave of the torque, drag, motor constant and body rate within their limits. `read` is the
    /// tachometer of the first one.
    struct Bench {
        check: WheelCheck<2>,
        k: u64,
        speed_rad_s: f32,
        /// Motor torque over the commanded one.
        motor: f32,
    }

    impl Bench {
        fn new() -> Self {
            let check = WheelCheck::new(Config::default(), &AXES, &[SPIN_KG_M2; 2]);
            Self { check, k: 0, speed_rad_s: 300.0, motor: 1.03 }
        }

        /// Flies this number of samples. Returns the sample at which the first wheel is found.
        fn fly(&mut self, samples: u64, read: impl Fn(f32) -> f32) -> Option<u64> {
            let mut found = None;
            for flown in 0..samples {
                self.k += 1;
                // Five seconds a half-wave.
                let torque = if (self.k / 50).is_multiple_of(2) { TORQUE_N_M } else { -TORQUE_N_M };
                let drag = 1e-5 * self.speed_rad_s.signum();
                let body = Vec3::new(0.02 * (self.k as f32 * 0.3).sin(), 0.0, 0.0);
                self.speed_rad_s += (self.motor * torque - drag) / SPIN_KG_M2 * PERIOD_S;
                let speeds = [read(self.speed_rad_s - body.x), 0.0];
                let time_us = self.k * 100_000;
                self.check.add(time_us, &body, &speeds, &[Some(torque), None]);
                let is_found = !self.check.follow()[0];
                found = found.or(is_found.then_some(flown + 1));
                assert!(self.check.follow()[1], "without a command");
            }
            found
        }
    }

    /// 3 % of motor constant and half the drag: no wheel is found.
    #[test]
    fn healthy_wheel_follows_its_command() {
        assert_eq!(Bench::new().fly(20_000, |speed| speed), None);
        // Quantised to the slowest measurable speed.
        assert_eq!(Bench::new().fly(20_000, |speed| (speed / 0.52).round() * 0.52), None);
    }

    /// A stuck reading, a dead line and a reversed one within 1 s, a tenth of the edges within 3 s at 10 Hz and 48 rad/s²; each
    /// follows again within 1.5 periods of the torque after the end of the fault. A motor that is 3 % strong makes a tenth
    /// look like 7 %, which the tolerance of 5 % and the drag hide: that one has its nominal torque.
    #[test]
    fn faults_are_found_by_wheel_in_the_stated_time() {
        type Read = fn(f32) -> f32;
        let faults: [(&str, f32, Read, u64); 5] = [
            ("stuck", 1.03, |_| 300.0, 10),
            ("dead line", 1.03, |_| 0.0, 10),
            ("reversed", 1.03, |speed| -speed, 10),
            ("half of the edges", 1.03, |speed| 0.5 * speed, 10),
            ("a tenth of the edges", 1.0, |speed| 0.9 * speed, 30),
        ];
        for (name, motor, read, most) in faults {
            let mut bench = Bench::new();
            bench.motor = motor;
            assert_eq!(bench.fly(330, |speed| speed), None);
            let found = bench.fly(300, read);
            println!("{name}: {found:?} samples");
            assert!(found.is_some_and(|found| found <= most), "{name}: {found:?}");
            bench.fly(150, |speed| speed);
            assert!(bench.check.follow()[0], "{name} is over");
        }
    }

    #[test]
    fn one_wrong_speed_is_no_fault() {
        let mut bench = Bench::new();
        for _ in 0..200 {
            assert_eq!(bench.fly(40, |speed| speed), None);
            assert_eq!(bench.fly(1, |speed| speed + 1_000.0), None);
        }
    }

    /// The motion between two readings a second and more apart, or without speeds, is unknown.
    #[test]
    fn pause_begins_a_stretch() {
        let mut bench = Bench::new();
        assert_eq!(bench.fly(20, |speed| speed), None);
        for pause in [15, 500] {
            bench.k += pause;
            bench.speed_rad_s += 400.0;
            assert_eq!(bench.fly(5, |speed| speed), None);
        }
        bench.check.interrupt();
        bench.speed_rad_s -= 800.0;
        assert_eq!(bench.fly(20, |speed| speed), None);
    }

    #[test]
    fn numbers_that_are_not_finite_are_no_fault_and_no_panic() {
        let mut check = WheelCheck::new(Config::default(), &[[0.0; 3]; 1], &[SPIN_KG_M2]);
        for (k, bad) in (0..).zip([f32::NAN, f32::INFINITY, f32::MAX, f32::NAN, 0.0, f32::NAN]) {
            check.add(k * 1000, &Vec3::repeat(bad), &[bad], &[Some(bad)]);
            check.add(u64::MAX, &Vec3::repeat(bad), &[bad], &[Some(1e-3)]);
        }
        assert_eq!(check.follow(), [true]);
    }
}
