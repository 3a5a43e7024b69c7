//! Selected estimator: dispatch of samples and telecommands to one estimator of the roster.
//!
//! Input: a craft, then samples, and the telecommands that concern the estimators: select, reset, set
//! a prior, open or close a window. Output: the estimate of the selected estimator. A telecommand that
//! cannot be executed is rejected with the reason; the state is unchanged.
//!
//! All estimators share one place in memory ([`EstimatorSlot`]), so that a selection allocates
//! nothing. A selected estimator starts from the craft and the prior, without the state of the one
//! before it. Cargo features decide which estimators are built in, see [`EstimatorId::BUILT_IN`].
//!
//! A checkpoint holds the prior, the number of the selected estimator and its state ([`Persist`]).

use crate::flight::craft::{Craft, WHEELS};
use fsw_core::checkpoint::{self, Archive, Persist};
use fsw_core::estimator::window::Remaining;
use fsw_core::hardware::{Finding, Hardware};
use fsw_core::{Coasting, ConfigError, Estimate, Estimator, Innovation, Outcome, Prior};
use fsw_core::{Sample, Vec3};
use fsw_roster::{EstimatorSlot, FlightWindow, InitialData};

pub use fsw_roster::{EstimatorId, Refused};

/// Errors of the hardware before a spacecraft is set: zeros.
const NO_HARDWARE: Hardware<f32, WHEELS> = Hardware {
    gyro_scale: 0.0,
    gyro_axes_rad: 0.0,
    delay_s: 0.0,
    delay_sigma_s: 0.0,
    wheel_inertia: [0.0; WHEELS],
    wheel_axis_rad: [0.0; WHEELS],
    common_wheel_inertia: 0.0,
    torque_scale: 0.0,
    clock: 0.0,
    mount_rad: [0.0; 3],
};

/// The selected estimator, with the data that it and any other starts from.
#[derive(Debug, Clone)]
pub struct SelectedEstimator {
    /// Spacecraft as configured.
    craft: Craft<WHEELS>,
    /// Prior of the craft, or of the last telecommand that set one.
    prior: Option<Prior<f32>>,
    /// Sum of craft and prior, to detect a flipped bit.
    sum: u32,
    slot: EstimatorSlot,
}

impl SelectedEstimator {
    /// The first built-in estimator on this spacecraft, before its first sample.
    ///
    /// # Errors
    /// Names the value of the craft that the estimator does not accept.
    pub fn new(craft: Craft<WHEELS>) -> Result<Self, ConfigError> {
        let mut estimator = Self::uninitialised();
        estimator.configure(craft)?;
        Ok(estimator)
    }

    /// No spacecraft and no estimator, until [`configure`](Self::configure). For a static: the value
    /// takes 38 KiB, more than a stack, and is all zeros, so that it takes no flash.
    pub const fn uninitialised() -> Self {
        let craft = Craft {
            wheel_axes: [[0.0; 3]; WHEELS],
            spin_inertia_kg_m2: [0.0; WHEELS],
            gyro_noise_rad_s: 0.0,
            hardware: NO_HARDWARE,
            prior: None,
        };
        Self { craft, prior: None, sum: 0, slot: EstimatorSlot::Uninitialised }
    }

    /// Sets the spacecraft and starts the first built-in estimator.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn configure(&mut self, craft: Craft<WHEELS>) -> Result<(), ConfigError> {
        self.craft = craft;
        self.restart()
    }

    /// Returns to the state after [`configure`](Self::configure). No estimator is stepped where
    /// `ekf-sgf-rls` alone is built in and the craft has no prior: it starts with the first
    /// [`set_prior`](Self::set_prior).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn restart(&mut self) -> Result<(), ConfigError> {
        self.prior = self.craft.prior;
        self.sum = self.sum_now();
        match self.select(EstimatorId::FIRST) {
            Err(Refused::Config(error)) => Err(error),
            _ => Ok(()),
        }
    }

    /// Discards the estimator, whose memory is not valid, and starts again as after [`configure`](Self::configure).
    ///
    /// # Errors
    /// [`Refused::Corrupt`] where craft or prior has changed as well: no estimator is stepped then, until the computer
    /// restarts.
    pub fn rebuild(&mut self) -> Result<(), Refused> {
        self.slot = EstimatorSlot::Uninitialised; // a store: nothing of the former content is read
        if !self.is_intact() {
            return Err(Refused::Corrupt);
        }
        Ok(self.restart()?)
    }

    /// True if craft and prior are as they were set. They outlive every reset of an estimator: a flipped bit
    /// in them stays until the computer restarts. No estimator starts from it, and no checkpoint holds it.
    pub fn is_intact(&self) -> bool {
        self.sum == self.sum_now()
    }

    /// Sum of craft and prior: depends on every bit and on the order of the words.
    #[inline(never)]
    fn sum_now(&self) -> u32 {
        let Craft { wheel_axes, spin_inertia_kg_m2, gyro_noise_rad_s, hardware, prior } =
            &self.craft;
        let Hardware {
            gyro_scale,
            gyro_axes_rad,
            delay_s,
            delay_sigma_s,
            wheel_inertia,
            wheel_axis_rad,
            common_wheel_inertia,
            torque_scale,
            clock,
            mount_rad,
        } = hardware;
        let of_hardware = [
            gyro_scale,
            gyro_axes_rad,
            delay_s,
            delay_sigma_s,
            common_wheel_inertia,
            torque_scale,
            clock,
        ];
        let mut sum = checkpoint::mix(u32::from(prior.is_some()), u32::from(self.prior.is_some()));
        let priors = [prior, &self.prior].into_iter().flatten();
        let of_priors = priors.flat_map(|prior| [&prior.inertia_kg_m2, &prior.sigma_kg_m2]);
        let numbers = wheel_axes
            .as_flattened()
            .iter()
            .chain(spin_inertia_kg_m2)
            .chain(core::iter::once(gyro_noise_rad_s))
            .chain(of_hardware)
            .chain(wheel_inertia)
            .chain(wheel_axis_rad)
            .chain(mount_rad)
            .chain(of_priors.flatten());
        for number in numbers {
            sum = checkpoint::mix(sum, number.to_bits());
        }
        sum
    }

    /// The spacecraft as configured.
    pub fn craft(&self) -> &Craft<WHEELS> {
        &self.craft
    }

    /// The estimator that is stepped.
    pub fn selected(&self) -> EstimatorId {
        self.slot.id().unwrap_or(EstimatorId::FIRST)
    }

    /// The prior that estimators start from: of the craft, or of the last
    /// [`set_prior`](Self::set_prior).
    pub fn prior(&self) -> Option<Prior<f32>> {
        self.prior
    }

    /// Starts the selected estimator again: its estimate is discarded, the prior stays.
    ///
    /// # Errors
    /// As [`select`](Self::select); none for a selected estimator that has been started before.
    pub fn reset(&mut self) -> Result<(), Refused> {
        self.select(self.selected())
    }

    /// Starts this estimator and steps it from the next sample on.
    ///
    /// # Errors
    /// [`Refused::NoNominalInertia`], [`Refused::NotBuiltIn`], [`Refused::Corrupt`].
    pub fn select(&mut self, id: EstimatorId) -> Result<(), Refused> {
        if !self.is_intact() {
            return Err(Refused::Corrupt);
        }
        let from = InitialData {
            gyro_noise_rad_s: self.craft.gyro_noise_rad_s,
            wheels: self.craft.wheels()?,
            hardware: self.craft.hardware,
            prior: self.prior,
        };
        self.slot.start(id, &from)
    }

    /// Sets the prior and starts the selected estimator again with it.
    ///
    /// # Errors
    /// [`Refused::Config`] for a tensor that no rigid body has, or a sigma that is not positive;
    /// [`Refused::BelowWheels`]; [`Refused::Corrupt`].
    pub fn set_prior(&mut self, prior: Prior<f32>) -> Result<(), Refused> {
        prior.validate()?;
        if !self.is_intact() {
            return Err(Refused::Corrupt);
        }
        if !self.contains_wheels(&prior.inertia_kg_m2) {
            return Err(Refused::BelowWheels);
        }
        self.prior = Some(prior);
        self.sum = self.sum_now();
        self.reset()
    }

    /// True if `J − Σ Iₛ a aᵀ` is positive definite: the inertia of the body includes the spin inertia `Iₛ` of
    /// each wheel about its axis `a`. A smaller body would turn faster than its wheels: the squares of its
    /// rates overflowed to a NaN in telemetry.
    #[inline(never)]
    fn contains_wheels(&self, inertia_kg_m2: &[f32; 6]) -> bool {
        let [mut xx, mut yy, mut zz, mut xy, mut xz, mut yz] = *inertia_kg_m2;
        for ([x, y, z], spin_kg_m2) in
            self.craft.wheel_axes.iter().zip(&self.craft.spin_inertia_kg_m2)
        {
            let square = x * x + y * y + z * z;
            let weight = if square > 0.0 { spin_kg_m2 / square } else { 0.0 };
            (xx, yy, zz) = (xx - weight * x * x, yy - weight * y * y, zz - weight * z * z);
            (xy, xz, yz) = (xy - weight * x * y, xz - weight * x * z, yz - weight * y * z);
        }
        // Leading minors, in multiples of half the trace: no square leaves the range of `f32`.
        let half = 0.5 * (xx + yy + zz);
        let [xx, yy, zz, xy, xz, yz] = [xx, yy, zz, xy, xz, yz].map(|element| element / half);
        let plane = xx * yy - xy * xy;
        let whole = plane * zz - xx * yz * yz - yy * xz * xz + 2.0 * xy * xz * yz;
        half > 0.0 && xx > 0.0 && plane > 0.0 && whole > 0.0
    }

    /// Opens a window with the next sample.
    ///
    /// # Errors
    /// [`Refused::NoWindows`].
    pub fn open_window(&mut self) -> Result<(), Refused> {
        self.window_mut().map(FlightWindow::open_window)
    }

    /// Closes the open window.
    ///
    /// # Errors
    /// [`Refused::NoWindows`].
    pub fn close_window(&mut self) -> Result<(), Refused> {
        self.window_mut().map(FlightWindow::close_window)
    }

    /// Does up to this number of slices of the work beside a step, each of bounded cost. Only `window`
    /// has any.
    pub fn work(&mut self, slices: u32) -> Remaining {
        self.slot.selected_mut().map_or(Remaining::Nothing, |estimator| estimator.work(slices))
    }

    /// True at rest, when a lost sample costs no information. Always false for estimators other than
    /// `window`, which do not detect rest.
    pub fn is_at_rest(&self) -> bool {
        self.slot.window().is_some_and(FlightWindow::is_at_rest)
    }

    fn window_mut(&mut self) -> Result<&mut FlightWindow, Refused> {
        self.slot.window_mut().ok_or(Refused::NoWindows)
    }
}

/// Prior, selected estimator and its state. Every other estimator starts again when it is selected.
impl Persist for SelectedEstimator {
    fn layout() -> u32 {
        let layout = [Option::<Prior<f32>>::layout(), EstimatorId::layout()];
        EstimatorSlot::mix_layout(layout.into_iter().fold(0, checkpoint::mix))
    }

    fn persist(&mut self, archive: &mut Archive<'_>) {
        // Neither is a flipped bit saved, nor is the sum made to match it.
        if !self.is_intact() {
            return archive.refuse("SelectedEstimator");
        }
        self.prior.persist(archive);
        self.sum = self.sum_now();
        let mut selected = self.selected();
        selected.persist(archive);
        // The start selects the type only: the archive then replaces the whole state, the prior
        // included.
        if selected != self.selected() && self.select(selected).is_err() {
            return archive.refuse("SelectedEstimator");
        }
        self.slot.persist(archive);
    }
}

impl Estimator<f32, WHEELS> for SelectedEstimator {
    fn step(&mut self, sample: &Sample<f32, WHEELS>) -> Outcome {
        match self.slot.selected_mut() {
            Some(estimator) => estimator.step(sample),
            None => Outcome::Coasting(Coasting::Aligning),
        }
    }

    #[inline(never)] // an inlined copy of the estimate adds 184 bytes to the deepest stack
    fn estimate(&self) -> Estimate<f32> {
        self.slot.estimate()
    }

    fn rate_rad_s(&self) -> Vec3<f32> {
        self.slot.selected().map_or(Vec3::zeros(), |estimator| estimator.rate_rad_s())
    }

    fn innovation(&self) -> Option<Innovation<f32>> {
        self.slot.selected().and_then(|estimator| estimator.innovation())
    }

    fn each_of_hardware(&self, visit: &mut dyn FnMut(Finding<f32>)) {
        if let Some(estimator) = self.slot.selected() {
            estimator.each_of_hardware(visit);
        }
    }

    // `window` alone has work to complete. Not a function of every estimator in the slot: an image
    // that never calls it would hold its code.
    fn finish(&mut self) {
        if let Ok(window) = self.window_mut() {
            window.finish();
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::flight::computer::SLICES_PER_SAMPLE;
    use crate::link::Command;
    use crate::stand_in::recording::cubesat_pyramid::{CRAFT, ROWS};
    use fsw_core::Status;
    use fsw_core::checkpoint::{FromWords, ToWords};

    const PRIOR: Prior<f32> = Prior {
        inertia_kg_m2: [0.05, 0.05, 0.03, 0.0, 0.0, 0.0],
        sigma_kg_m2: [0.02, 0.02, 0.02, 0.005, 0.005, 0.005],
    };

    /// Steps the estimator through the recorded flight and returns its estimate.
    fn run(estimator: &mut SelectedEstimator) -> Estimate<f32> {
        for row in &ROWS {
            estimator.step(&Sample {
                time_us: row.time_us,
                rate_rad_s: Vec3::from(row.rate_rad_s),
                wheel_speed_rad_s: row.wheel_speed_rad_s,
                torque_n_m: Vec3::from(row.torque_n_m),
                attitude: None,
            });
            estimator.work(SLICES_PER_SAMPLE);
        }
        estimator.estimate()
    }

    #[test]
    fn the_craft_of_the_flight_image_is_accepted() {
        use crate::flight::craft::CRAFT as FLIGHT_CRAFT;
        let prior = SelectedEstimator::new(FLIGHT_CRAFT).map(|estimator| estimator.prior());
        assert_eq!(prior, Ok(FLIGHT_CRAFT.prior));
    }

    #[test]
    fn each_estimator_of_the_roster_can_be_selected() {
        let mut estimator = SelectedEstimator::new(CRAFT).unwrap();
        estimator.set_prior(PRIOR).unwrap();
        let mut estimates = std::vec::Vec::new();
        for id in EstimatorId::ALL {
            estimator.select(id).unwrap();
            assert_eq!(estimator.selected(), id);
            estimates.push(run(&mut estimator));
        }
        assert_eq!(estimates[0].status, Status::Converged);
        assert_eq!(estimates[1].status, Status::Converged);
        assert!(estimates[0] != estimates[1] && estimates[1] != estimates[2]);
    }

    #[test]
    fn a_reset_discards_the_estimate() {
        let mut estimator = SelectedEstimator::new(CRAFT).unwrap();
        let initial = estimator.estimate();
        let first = run(&mut estimator);
        assert_ne!(first.inertia, initial.inertia);
        estimator.reset().unwrap();
        assert_eq!(estimator.estimate(), initial);
        assert_eq!(run(&mut estimator), first);
    }

    /// Every number of a report.
    fn numbers(estimator: &SelectedEstimator) -> std::vec::Vec<f32> {
        let estimate = estimator.estimate();
        let mut all = estimate.inertia.elements_kg_m2().to_vec();
        all.extend(estimate.sigma_kg_m2());
        all.push(estimate.residual_rms_rad_s);
        all.extend(estimator.rate_rad_s().iter());
        all.extend(estimator.innovation().map(|innovation| innovation.nis()));
        all
    }

    #[test]
    fn prior_below_the_wheels_is_refused() {
        // Four wheels of 2.1e-5 kg m² in a pyramid: 2.8e-5 kg m² about each axis.
        let mut estimator = SelectedEstimator::new(CRAFT).unwrap();
        let before = estimator.estimate();
        let of = |inertia_kg_m2| Prior { inertia_kg_m2, ..PRIOR };
        for small in [
            of([2.7e-5, 2.7e-5, 2.7e-5, 0.0, 0.0, 0.0]),
            of([1e-9, 1e-2, 1e-2, 0.0, 0.0, 0.0]),
            of([0.5, 0.500_01, 1.0, -0.5, 0.0, 0.0]), // principal moment 5e-6 between x and y
        ] {
            assert_eq!(estimator.set_prior(small), Err(Refused::BelowWheels), "{small:?}");
            assert_eq!((estimator.prior(), estimator.estimate()), (None, before));
        }
        assert_eq!(estimator.set_prior(of([3e-5, 3e-5, 3e-5, 0.0, 0.0, 0.0])), Ok(()));
    }

    /// Priors over the whole range of the telecommand, extremes above all.
    #[test]
    fn no_accepted_prior_gives_a_report_that_is_not_finite() {
        let mut state = 1_u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f32 / (1_u64 << 24) as f32
        };
        let mut estimator = SelectedEstimator::new(CRAFT).unwrap();
        let mut size = |least: f32, most: f32| match random() {
            share if share < 0.2 => least,
            share if share > 0.8 => most,
            _ => least * (most / least).powf(random()),
        };
        let (mut accepted, mut refused) = (0, 0);
        for turn in 0..3_000 {
            let id = EstimatorId::ALL[turn % 3];
            let x = size(1e-9, 1e4);
            let y = size(x, 1e4);
            let z = size((y - x).max(1e-9), (x + y).min(1e4));
            let products = [size(1e-12, x), -size(1e-12, x), size(1e-12, x)].map(|p| 0.3 * p);
            let prior = Prior {
                inertia_kg_m2: [x, y, z, products[0], products[1], products[2]],
                sigma_kg_m2: core::array::from_fn(|_| size(1e-9, 1e4)),
            };
            if Command::SetPrior(prior).check().is_err() {
                continue;
            }
            if estimator.set_prior(prior).is_err() || estimator.select(id).is_err() {
                refused += 1;
                continue;
            }
            accepted += 1;
            for row in &ROWS[..40] {
                let all = numbers(&estimator);
                assert!(all.iter().all(|number| number.is_finite()), "{id:?} {prior:?}: {all:?}");
                estimator.step(&Sample {
                    time_us: row.time_us,
                    rate_rad_s: Vec3::from(row.rate_rad_s),
                    wheel_speed_rad_s: row.wheel_speed_rad_s,
                    torque_n_m: Vec3::from(row.torque_n_m),
                    attitude: None,
                });
                estimator.work(SLICES_PER_SAMPLE);
            }
        }
        assert!(accepted > 1_000, "{accepted} accepted, {refused} refused");
    }

    #[test]
    fn flipped_bit_of_craft_or_prior_is_detected_and_neither_used_nor_saved() {
        let mut intact = SelectedEstimator::new(CRAFT).unwrap();
        intact.set_prior(PRIOR).unwrap();
        assert!(intact.is_intact());
        let flips: [fn(&mut SelectedEstimator, u32); 4] = [
            |e, bit| flip(&mut e.craft.wheel_axes[2][1], bit),
            |e, bit| flip(&mut e.craft.spin_inertia_kg_m2[3], bit),
            |e, bit| flip(&mut e.craft.gyro_noise_rad_s, bit),
            |e, bit| flip(&mut e.prior.as_mut().unwrap().sigma_kg_m2[5], bit),
        ];
        for (flip, bit) in flips.iter().flat_map(|flip| (0..32).map(move |bit| (flip, bit))) {
            let mut flipped = intact.clone();
            flip(&mut flipped, bit);
            assert!(!flipped.is_intact(), "bit {bit}");
            assert_eq!(flipped.reset(), Err(Refused::Corrupt));
            assert_eq!(flipped.set_prior(PRIOR), Err(Refused::Corrupt));
            let mut words = std::vec![0; 12_288];
            let saved = checkpoint::transfer(&mut flipped, &mut ToWords::new(&mut words));
            assert!(saved.is_err() && !flipped.is_intact(), "bit {bit}");
        }
    }

    fn flip(number: &mut f32, bit: u32) {
        *number = f32::from_bits(number.to_bits() ^ 1 << bit);
    }

    #[test]
    fn a_rejected_telecommand_changes_nothing() {
        let mut estimator = SelectedEstimator::new(CRAFT).unwrap();
        assert_eq!(estimator.select(EstimatorId::EkfSgfRls), Err(Refused::NoNominalInertia));
        assert_eq!(estimator.selected(), EstimatorId::Window);
        let impossible = Prior { inertia_kg_m2: [1.0, 1.0, 3.0, 0.0, 0.0, 0.0], ..PRIOR };
        assert!(matches!(estimator.set_prior(impossible), Err(Refused::Config(_))));
        assert_eq!(estimator.prior(), None);
        estimator.select(EstimatorId::JointEkf).unwrap();
        assert_eq!(estimator.open_window(), Err(Refused::NoWindows));
    }

    #[test]
    fn a_checkpoint_restores_selection_prior_and_estimate() {
        for id in EstimatorId::ALL {
            let mut saved = SelectedEstimator::new(CRAFT).unwrap();
            saved.set_prior(PRIOR).unwrap();
            saved.select(id).unwrap();
            run(&mut saved);
            let mut words = std::vec![0; 16_384];
            checkpoint::transfer(&mut saved, &mut ToWords::new(&mut words)).unwrap();
            let mut restored = SelectedEstimator::new(Craft { prior: None, ..CRAFT }).unwrap();
            checkpoint::transfer(&mut restored, &mut FromWords::new(&words)).unwrap();
            assert_eq!((restored.selected(), restored.prior()), (id, Some(PRIOR)));
            assert_eq!(restored.estimate(), saved.estimate());
        }
    }

    #[test]
    fn numbers_and_names_identify_estimators() {
        for id in EstimatorId::ALL {
            assert_eq!(EstimatorId::from_number(id as u8), Some(id));
            assert_eq!(EstimatorId::from_name(id.name()), Some(id));
        }
        assert_eq!(EstimatorId::from_number(3), None);
    }
}
