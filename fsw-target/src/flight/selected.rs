//! The estimators that fly, side by side, of which one is stepped.
//!
//! Input: a craft, then samples and the ground's wishes: another estimator, another prior, a window
//! opened or closed. Output: what the selected estimator says. A wish that can't be granted is
//! refused with the reason, and nothing changes.
//!
//! What is kept in a checkpoint is the selected one, and the prior: [`Persist`].
//!
//! All share one place in memory, so that selecting one allocates nothing. Selecting one starts it
//! afresh: what another one has seen is no business of its. Which are aboard is a choice of features,
//! `window`, `joint-ekf` and `ekf-sgf-rls`: all, unless told otherwise.

use crate::flight::craft::{Craft, WHEELS};
use fsw_core::checkpoint::{self, Archive, Persist};
#[cfg(feature = "ekf-sgf-rls")]
use fsw_core::estimator::ekf_sgf;
#[cfg(feature = "joint-ekf")]
use fsw_core::estimator::joint_ekf;
#[cfg(feature = "window")]
use fsw_core::estimator::window;
use fsw_core::{ConfigError, Estimate, Estimator, Outcome, Sample, Vec3};
use fsw_core::{Innovation, Prior};
use fsw_steps::Flown;

/// `window` as it flies: momentum and inertia are its unknowns. A torque or a bias would take 1.2 KiB
/// each.
pub type FlownWindow = fsw_steps::Window9;
/// `joint-ekf` as it flies.
pub type FlownJointEkf = fsw_steps::JointEkf;
/// `ekf-sgf-rls` as it flies.
pub type FlownChain = fsw_steps::EkfSgfRls;

/// Which estimator is stepped. The numbers are those of telemetry and telecommand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
#[repr(u8)]
pub enum EstimatorId {
    /// `window`: each manoeuvre fitted as a whole.
    #[default]
    Window = 0,
    /// `joint-ekf`: rate and inertia in one filter.
    JointEkf = 1,
    /// `ekf-sgf-rls`: rate filter, differentiator, least squares. Needs a nominal inertia, which is
    /// the prior's.
    EkfSgfRls = 2,
}

impl EstimatorId {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Window, Self::JointEkf, Self::EkfSgfRls];

    /// The first that is aboard: stepped from the start.
    pub const FIRST: Self = if cfg!(feature = "window") {
        Self::Window
    } else if cfg!(feature = "joint-ekf") {
        Self::JointEkf
    } else {
        Self::EkfSgfRls
    };

    /// The one of this number.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|id| *id as u8 == number)
    }

    /// Its name, as `host-sim --estimator` has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Window => "window",
            Self::JointEkf => "joint-ekf",
            Self::EkfSgfRls => "ekf-sgf-rls",
        }
    }
}

/// Why a wish wasn't granted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// A value that no estimator accepts.
    Config(ConfigError),
    /// `ekf-sgf-rls` filters the rate with a nominal inertia: set a prior first.
    NoNominalInertia,
    /// Only `window` has windows.
    NoWindows,
    /// This image was built without it.
    NotAboard,
}

impl From<ConfigError> for Refused {
    fn from(error: ConfigError) -> Self {
        Self::Config(error)
    }
}

/// The estimators.
#[derive(Debug, Clone)]
pub struct SelectedEstimator {
    /// As built.
    craft: Craft<WHEELS>,
    /// The craft's, or what the ground has set instead.
    prior: Option<Prior<f32>>,
    flown: Flown,
}

impl SelectedEstimator {
    /// The estimators of a spacecraft, the first of them selected, all waiting for their first sample.
    ///
    /// # Errors
    /// Names the value of the craft that an estimator refuses.
    pub fn new(craft: Craft<WHEELS>) -> Result<Self, ConfigError> {
        let mut onboard = Self::nowhere();
        onboard.board(craft)?;
        Ok(onboard)
    }

    /// On no spacecraft, and stepping nothing. It takes 16 KiB, and a stack has less than that: so it
    /// stands in a static, as zeros, until it goes on [`board`](Self::board).
    pub const fn nowhere() -> Self {
        let none = Craft {
            wheel_axes: [[0.0; 3]; WHEELS],
            spin_inertia_kg_m2: [0.0; WHEELS],
            gyro_noise_rad_s: 0.0,
            prior: None,
        };
        Self { craft: none, prior: None, flown: Flown::Nothing }
    }

    /// Goes on board of this spacecraft.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn board(&mut self, craft: Craft<WHEELS>) -> Result<(), ConfigError> {
        self.craft = craft;
        self.configure()
    }

    /// Configures all for the craft: as at the start. Where `ekf-sgf-rls` is all that is aboard, and the
    /// craft has no prior, nothing is stepped until it is told one.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn configure(&mut self) -> Result<(), ConfigError> {
        self.prior = self.craft.prior;
        match self.select(EstimatorId::FIRST) {
            Err(Refused::Config(error)) => Err(error),
            _ => Ok(()),
        }
    }

    /// Which estimator is stepped.
    pub fn selected(&self) -> EstimatorId {
        match self.flown {
            Flown::Nothing => EstimatorId::FIRST,
            #[cfg(feature = "window")]
            Flown::Window(_) => EstimatorId::Window,
            #[cfg(feature = "joint-ekf")]
            Flown::JointEkf(_) => EstimatorId::JointEkf,
            #[cfg(feature = "ekf-sgf-rls")]
            Flown::EkfSgfRls(_) => EstimatorId::EkfSgfRls,
        }
    }

    /// What is believed of the inertia beforehand: the craft's prior, or the one that was set last.
    pub fn prior(&self) -> Option<Prior<f32>> {
        self.prior
    }

    /// Starts the selected estimator afresh: all that it has found is forgotten, the prior stays.
    ///
    /// # Errors
    /// None that a craft which was accepted once can cause; see [`select`](Self::select).
    pub fn reset(&mut self) -> Result<(), Refused> {
        self.select(self.selected())
    }

    /// Steps this estimator from now on, from a fresh start.
    ///
    /// # Errors
    /// [`Refused::NoNominalInertia`], [`Refused::NotAboard`].
    pub fn select(&mut self, id: EstimatorId) -> Result<(), Refused> {
        let (craft, prior) = (&self.craft, self.prior);
        let (noise, wheels) = (craft.gyro_noise_rad_s, craft.wheels()?);
        match id {
            #[cfg(feature = "window")]
            EstimatorId::Window => {
                let config = window::Config { prior, ..window::Config::new(noise) };
                self.flown.start_window(&config, &wheels)?;
            }
            #[cfg(feature = "joint-ekf")]
            EstimatorId::JointEkf => {
                let config = joint_ekf::Config { prior, ..joint_ekf::Config::new(noise) };
                self.flown.start_joint_ekf(&config, &wheels)?;
            }
            #[cfg(feature = "ekf-sgf-rls")]
            EstimatorId::EkfSgfRls => {
                let nominal = prior.ok_or(Refused::NoNominalInertia)?;
                let config = ekf_sgf::Config::kim_2013(noise, nominal);
                self.flown.start_ekf_sgf_rls(&config, &wheels)?;
            }
            #[allow(unreachable_patterns, reason = "where all are aboard")]
            _ => return Err(Refused::NotAboard),
        }
        Ok(())
    }

    /// Believes this of the inertia beforehand, and starts the selected estimator afresh with it.
    ///
    /// # Errors
    /// [`Refused::Config`] for a tensor that no body has, or a sigma that isn't positive.
    pub fn set_prior(&mut self, prior: Prior<f32>) -> Result<(), Refused> {
        prior.validate()?;
        self.prior = Some(prior);
        self.reset()
    }

    /// Begins a window with the next sample.
    ///
    /// # Errors
    /// [`Refused::NoWindows`].
    pub fn open_window(&mut self) -> Result<(), Refused> {
        self.of_windows().map(FlownWindow::open_window)
    }

    /// Ends the window that is open.
    ///
    /// # Errors
    /// [`Refused::NoWindows`].
    pub fn close_window(&mut self) -> Result<(), Refused> {
        self.of_windows().map(FlownWindow::close_window)
    }

    /// Whether samples that fail to come now cost nothing. Only `window` knows when nothing moves.
    pub fn is_at_rest(&self) -> bool {
        match &self.flown {
            #[cfg(feature = "window")]
            Flown::Window(window) => window.is_at_rest(),
            _ => false,
        }
    }

    fn of_windows(&mut self) -> Result<&mut FlownWindow, Refused> {
        match &mut self.flown {
            #[cfg(feature = "window")]
            Flown::Window(window) => Ok(window),
            _ => Err(Refused::NoWindows),
        }
    }
}

fsw_core::persist!([] enum EstimatorId { 0 => Window, 1 => JointEkf, 2 => EkfSgfRls });

/// The prior, which estimator is selected, and its state. The others are started afresh when they
/// are selected.
impl Persist for SelectedEstimator {
    fn layout() -> u32 {
        [
            Option::<Prior<f32>>::layout(),
            EstimatorId::layout(),
            FlownWindow::layout(),
            FlownJointEkf::layout(),
            FlownChain::layout(),
        ]
        .into_iter()
        .fold(0, checkpoint::mix)
    }

    fn persist(&mut self, archive: &mut Archive<'_>) {
        self.prior.persist(archive);
        let mut selected = self.selected();
        selected.persist(archive);
        // All of its state comes back, its prior too: it only has to be there.
        if selected != self.selected() && self.select(selected).is_err() {
            return archive.refuse("SelectedEstimator");
        }
        match &mut self.flown {
            Flown::Nothing => archive.refuse("SelectedEstimator"),
            #[cfg(feature = "window")]
            Flown::Window(window) => window.persist(archive),
            #[cfg(feature = "joint-ekf")]
            Flown::JointEkf(filter) => filter.persist(archive),
            #[cfg(feature = "ekf-sgf-rls")]
            Flown::EkfSgfRls(chain) => chain.persist(archive),
        }
    }
}

/// What the estimator that is stepped says. (Not by a reference to any estimator: its table would
/// have all steps once more, compiled for size.)
macro_rules! ask {
    ($flown:expr, $estimator:ident => $answer:expr, $nothing:expr) => {
        match $flown {
            Flown::Nothing => $nothing,
            #[cfg(feature = "window")]
            Flown::Window($estimator) => $answer,
            #[cfg(feature = "joint-ekf")]
            Flown::JointEkf($estimator) => $answer,
            #[cfg(feature = "ekf-sgf-rls")]
            Flown::EkfSgfRls($estimator) => $answer,
        }
    };
}

impl Estimator<f32, WHEELS> for SelectedEstimator {
    fn step(&mut self, sample: &Sample<f32, WHEELS>) -> Outcome {
        self.flown.step(sample)
    }

    #[inline(never)]
    fn estimate(&self) -> Estimate<f32> {
        match &self.flown {
            Flown::Nothing => Estimate::nothing(),
            #[cfg(feature = "window")]
            Flown::Window(window) => fsw_steps::estimate_of_window(window),
            #[cfg(feature = "joint-ekf")]
            Flown::JointEkf(filter) => estimate_of(filter),
            #[cfg(feature = "ekf-sgf-rls")]
            Flown::EkfSgfRls(chain) => estimate_of(chain),
        }
    }

    fn rate_rad_s(&self) -> Vec3<f32> {
        ask!(&self.flown, estimator => estimator.rate_rad_s(), Vec3::zeros())
    }

    fn innovation(&self) -> Option<Innovation<f32>> {
        ask!(&self.flown, estimator => estimator.innovation(), None)
    }
}

/// A function of its own for each, so that one doesn't take the stack of all.
#[inline(never)]
fn estimate_of(estimator: &impl Estimator<f32, WHEELS>) -> Estimate<f32> {
    estimator.estimate()
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::stand_in::recording::cubesat_pyramid::{CRAFT, ROWS};
    use fsw_core::Status;
    use fsw_core::checkpoint::{FromWords, ToWords};

    const PRIOR: Prior<f32> = Prior {
        inertia_kg_m2: [0.05, 0.05, 0.03, 0.0, 0.0, 0.0],
        sigma_kg_m2: [0.02, 0.02, 0.02, 0.005, 0.005, 0.005],
    };

    fn fly(onboard: &mut SelectedEstimator) -> Estimate<f32> {
        for row in &ROWS {
            onboard.step(&Sample {
                time_us: row.time_us,
                rate_rad_s: Vec3::from(row.rate_rad_s),
                wheel_speed_rad_s: row.wheel_speed_rad_s,
                torque_n_m: Vec3::from(row.torque_n_m),
                attitude: None,
            });
        }
        onboard.estimate()
    }

    #[test]
    fn each_estimator_flies_when_selected() {
        let mut onboard = SelectedEstimator::new(CRAFT).unwrap();
        onboard.set_prior(PRIOR).unwrap();
        let mut estimates = std::vec::Vec::new();
        for id in EstimatorId::ALL {
            onboard.select(id).unwrap();
            assert_eq!(onboard.selected(), id);
            estimates.push(fly(&mut onboard));
        }
        assert_eq!(estimates[0].status, Status::Converged);
        assert_eq!(estimates[1].status, Status::Converged);
        assert!(estimates[0] != estimates[1] && estimates[1] != estimates[2]);
    }

    #[test]
    fn a_reset_forgets_what_was_found() {
        let mut onboard = SelectedEstimator::new(CRAFT).unwrap();
        let fresh = onboard.estimate();
        let once = fly(&mut onboard);
        assert_ne!(once.inertia, fresh.inertia);
        onboard.reset().unwrap();
        assert_eq!(onboard.estimate(), fresh);
        assert_eq!(fly(&mut onboard), once);
    }

    #[test]
    fn a_wish_that_can_t_be_granted_changes_nothing() {
        let mut onboard = SelectedEstimator::new(CRAFT).unwrap();
        assert_eq!(onboard.select(EstimatorId::EkfSgfRls), Err(Refused::NoNominalInertia));
        assert_eq!(onboard.selected(), EstimatorId::Window);
        let impossible = Prior { inertia_kg_m2: [1.0, 1.0, 3.0, 0.0, 0.0, 0.0], ..PRIOR };
        assert!(matches!(onboard.set_prior(impossible), Err(Refused::Config(_))));
        assert_eq!(onboard.prior(), None);
        onboard.select(EstimatorId::JointEkf).unwrap();
        assert_eq!(onboard.open_window(), Err(Refused::NoWindows));
    }

    /// Whatever was selected, and whichever prior was set.
    #[test]
    fn what_was_kept_comes_back_into_a_fresh_one() {
        for id in EstimatorId::ALL {
            let mut flown = SelectedEstimator::new(CRAFT).unwrap();
            flown.set_prior(PRIOR).unwrap();
            flown.select(id).unwrap();
            fly(&mut flown);
            let mut words = [0; 8192];
            checkpoint::transfer(&mut flown, &mut ToWords::new(&mut words)).unwrap();
            let mut restored = SelectedEstimator::new(Craft { prior: None, ..CRAFT }).unwrap();
            checkpoint::transfer(&mut restored, &mut FromWords::new(&words)).unwrap();
            assert_eq!((restored.selected(), restored.prior()), (id, Some(PRIOR)));
            assert_eq!(restored.estimate(), flown.estimate());
        }
    }

    #[test]
    fn numbers_of_estimators_go_there_and_back() {
        for id in EstimatorId::ALL {
            assert_eq!(EstimatorId::from_number(id as u8), Some(id));
        }
        assert_eq!(EstimatorId::from_number(3), None);
    }
}
