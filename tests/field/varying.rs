//! Scenarios whose inertia varies in small steps, on a course that is drawn for each seed.

use std::f64::consts::TAU;

use anyhow::Result;
use host_sim::campaign::{Truth, Truths};
use host_sim::input::Scenario;
use host_sim::input::scenario::change::SuddenChange;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

/// Offset of a seed's draw from its noise.
const STREAM: u64 = 0x2545_f491_4f6c_dd1d;
/// Time between two steps, s.
const STEP_S: f64 = 0.2;

/// Course of the elements over time.
#[derive(Clone, Copy, Debug)]
pub enum Course {
    /// Independent random walks of all elements, sigma after a second, kg m²/√s.
    Walk(f64),
    /// All elements swing by this share about their initial values with this period, s, from a phase of any value.
    Swing(f64, f64),
}

/// A scenario with a course of its inertia.
#[derive(Clone, Debug)]
pub struct Varying {
    /// Scenario with the initial inertia.
    pub base: Scenario,
    /// Course of the inertia.
    pub course: Course,
}

impl Varying {
    /// Scenario and truth of a seed.
    ///
    /// # Errors
    /// The motion cannot be integrated.
    pub fn draw(&self, seed: u64) -> Result<(Scenario, Truth)> {
        let mut random = Pcg64::seed_from_u64(seed ^ STREAM);
        let mut scenario = self.base.clone();
        let initial = scenario.spacecraft.inertia_kg_m2;
        let steps = (scenario.duration_s / STEP_S).ceil() as u32;
        let times_s = (1..steps).map(|step| f64::from(step) * STEP_S);
        scenario.changes.sudden = match self.course {
            Course::Walk(walk) => {
                let step = walk * STEP_S.sqrt();
                let mut present = initial;
                times_s
                    .map(|time_s| {
                        for element in &mut present {
                            let normal: f64 = StandardNormal.sample(&mut random);
                            *element += step * normal;
                        }
                        SuddenChange { time_s, inertia_kg_m2: present }
                    })
                    .collect()
            }
            Course::Swing(share, period_s) => {
                let phase = random.random_range(0.0..TAU);
                let swing = |t: f64| share * ((TAU * t / period_s + phase).sin() - phase.sin());
                times_s
                    .map(|time_s| {
                        let inertia_kg_m2 = initial.map(|j| j * (1.0 + swing(time_s)));
                        SuddenChange { time_s, inertia_kg_m2 }
                    })
                    .collect()
            }
        };
        let truths = Truths::simulate(&scenario)?;
        let truth = truths.of_run(&scenario, seed)?.into_owned();
        Ok((scenario, truth))
    }
}
