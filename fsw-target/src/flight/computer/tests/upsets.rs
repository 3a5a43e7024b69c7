//! Flipped bits in the memory of the estimator between rounds.

extern crate std;
use super::super::*;
use super::world::*;
use crate::flight::selected::EstimatorId;
use crate::stand_in::recording::cubesat_pyramid::ROWS;
use fsw_core::{Estimator, Reset, Status};

/// Bits of the estimator in memory.
const BITS: usize = size_of::<SelectedEstimator>() * 8;

/// Bits drawn over all of the memory: a multiplicative sequence, whose factor has no divisor in common with the size.
fn bit(k: usize) -> usize {
    k.wrapping_mul(1_000_003) % BITS
}

/// A computer that has flown 300 samples with this estimator, and saved a checkpoint.
fn in_flight(id: EstimatorId) -> Ground {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    ground.command(Command::SetPrior(PRIOR));
    ground.command(Command::Select(id));
    ground.poll(300);
    ground.command(Command::SaveCheckpoint);
    ground
}

impl Ground {
    fn flip(&mut self, bit: usize) {
        self.computer.flight.estimator_mut().flip(bit);
    }
}

#[test]
fn estimator_returns_to_its_checkpoint_after_a_flipped_bit() {
    for id in EstimatorId::ALL {
        for k in 0..200 {
            let mut ground = in_flight(id);
            let saved = ground.computer.estimator().estimate().inertia.elements_kg_m2();
            ground.poll(5);
            ground.flip(bit(k));
            let reports = estimates(&ground.poll(1));
            assert_eq!(reports[0].outcome, Some(Outcome::Reset(Reset::Diverged)), "bit {}", bit(k));
            let status = ground.command(Command::Ping);
            assert_eq!(status.upsets, 1);
            if status.configuration_intact {
                assert_eq!(ground.computer.estimator().selected(), id);
                let found = ground.computer.estimator().estimate().inertia.elements_kg_m2();
                for (found, saved) in found.iter().zip(saved) {
                    assert!((found - saved).abs() < 2e-3, "{id:?}, bit {}", bit(k));
                }
                assert_eq!(ground.world.0.reboots.get(), 0);
            } else {
                assert_eq!(
                    ground.world.0.reboots.get(),
                    1,
                    "only the image in flash has the craft"
                );
            }
        }
    }
}

#[test]
fn estimator_starts_again_without_a_checkpoint() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    ground.poll(100);
    ground.flip(BITS / 2);
    let status = ground.command(Command::Ping);
    assert_eq!((status.upsets, status.configuration_intact), (1, true));
    ground.poll(400);
    assert_eq!(ground.computer.estimator().estimate().status, Status::Converged);
}

#[test]
fn telecommand_after_a_flipped_bit_is_executed_on_the_restored_estimator() {
    let mut ground = in_flight(EstimatorId::JointEkf);
    ground.flip(BITS / 2);
    let status = ground.command(Command::Select(EstimatorId::Window));
    assert_eq!((status.upsets, status.last_command_done), (1, Some(true)));
    assert_eq!(ground.computer.estimator().selected(), EstimatorId::Window);
}

#[test]
fn no_step_is_taken_after_a_flipped_bit_of_the_craft() {
    let mut ground = in_flight(EstimatorId::JointEkf);
    // The craft is somewhere in the estimator: the first bit whose flip is found there.
    let first = (0..BITS).step_by(32).find(|bit| {
        ground.flip(bit + 3);
        let is_craft = !ground.computer.estimator().is_intact();
        if !is_craft {
            ground.flip(bit + 3);
        }
        is_craft
    });
    assert!(first.is_some());
    ground.poll(10);
    let status = ground.command(Command::Ping);
    assert_eq!((status.configuration_intact, status.upsets), (false, 1));
    assert!(ground.world.0.reboots.get() >= 1);
    let rate = ground.computer.estimator().rate_rad_s();
    assert_eq!(rate, Vec3::zeros(), "no estimator is stepped");
}
