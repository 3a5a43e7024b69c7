//! Fault injection: the faults of a scenario between its sensors and the estimator, and the matrix of
//! faults and estimators.
//!
//! ```text
//! simulation ──► samples: gyro, clock, tachometers, torque report ──► computer: restarts, flipped bits
//!                                                                      └─ around any estimator
//! catalogue: faults of a scenario ─► flight: one judged flight ─► matrix: cells, statistics
//! ```
//!
//! Every draw follows from the seed of the run. The kinds are those of
//! [`scenario::fault`](crate::input::scenario::fault).

mod catalogue;
mod computer;
mod flight;
mod matrix;
mod samples;

pub use catalogue::{Entry, catalogue};
pub use computer::Computer;
pub use flight::{Judged, Record};
pub use matrix::{Cell, Matrix, Row};
pub use samples::{Timed, inject};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::input::scenario::Fault;

/// Offset of a seed's fault generator from its noise generator.
const STREAM: u64 = 0x9e37_79b9_7f4a_7c15;

/// Start of a fault in one run, and the generator of its further draws.
struct Drawn {
    start_us: u64,
    /// End of the interval; that of the start for a duration of zero.
    end_us: u64,
    random: Pcg64,
}

impl Drawn {
    /// Draw of fault number `index` of a scenario in the run of this seed.
    fn new(fault: &Fault, index: usize, seed: u64) -> Self {
        let of_fault = seed.wrapping_mul(0x2545_f491_4f6c_dd1d).wrapping_add(index as u64);
        let mut random = Pcg64::seed_from_u64(of_fault ^ STREAM);
        let within = random.random::<f64>() * (fault.latest_start_s - fault.start_s);
        let start_us = micros(fault.start_s + within);
        Self { start_us, end_us: start_us + micros(fault.duration_s), random }
    }

    /// True for a sample of the interval; of the first one alone where the duration is zero.
    fn is_hit(&mut self, elapsed_us: u64, share: f64, hits: &mut u32) -> bool {
        let single = self.end_us == self.start_us;
        let within = elapsed_us >= self.start_us && (elapsed_us < self.end_us || single);
        if !within || (single && *hits > 0) || (share < 1.0 && self.random.random::<f64>() >= share)
        {
            return false;
        }
        *hits += 1;
        true
    }
}

/// Start and end of a fault in the run of this seed, µs since the first sample.
pub fn interval_us(fault: &Fault, index: usize, seed: u64) -> [u64; 2] {
    let Drawn { start_us, end_us, .. } = Drawn::new(fault, index, seed);
    [start_us, end_us]
}

fn micros(time_s: f64) -> u64 {
    (time_s * 1e6).round() as u64
}
