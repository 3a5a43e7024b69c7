//! Roster of the estimators that fly, one row each: number, name, variant, type and start.
//!
//! The number identifies an estimator in telemetry, telecommand and checkpoint. The name is that of
//! `host-sim --estimator`, and of the cargo feature that builds the estimator in. Numbers and names are
//! stable. [`EstimatorId`], the storage [`EstimatorSlot`], its dispatch and its layout in a checkpoint are
//! generated from the rows.
//!
//! A further estimator takes a row at the foot of this file, its type and its step in `fsw-steps`, and its
//! feature in `Cargo.toml` of `fsw-roster` and of `fsw-target`.

use crate::work::Work;
use fsw_core::checkpoint::{self, Archive, Persist};
use fsw_core::estimator;
use fsw_core::estimator::window::Remaining;
use fsw_core::hardware::{Finding, Hardware};
use fsw_core::{ConfigError, Estimate, Innovation, Outcome, Prior, Sample, Vec3, WheelArray};
use fsw_steps::{EkfSgfRls, JointEkfOfHardware, Step, WHEELS, WindowOfHardware};

/// `window` of the flight image. The only place that decides which form flies; `docs/budgets.md` has the figures of the
/// others.
pub type FlightWindow = WindowOfHardware;
/// `joint-ekf` of the flight image: considers the same errors.
pub type FlightJointEkf = JointEkfOfHardware;

/// Reason why a telecommand to the estimators is not executed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// A value outside the range that the estimators accept.
    Config(ConfigError),
    /// `ekf-sgf-rls` needs a nominal inertia, and no prior is set.
    NoNominalInertia,
    /// The selected estimator has no windows.
    NoWindows,
    /// The estimator is not built into this image.
    NotBuiltIn,
    /// The inertia of the prior is below that of the wheels, which it includes.
    BelowWheels,
    /// A bit of craft or prior has flipped in memory. A restart of the computer reads both again.
    Corrupt,
}

impl From<ConfigError> for Refused {
    fn from(error: ConfigError) -> Self {
        Self::Config(error)
    }
}

/// Data that an estimator starts from.
#[derive(Debug, Clone, Copy)]
pub struct InitialData {
    /// Gyro noise, one sigma per sample, rad/s.
    pub gyro_noise_rad_s: f32,
    /// Reaction wheels.
    pub wheels: WheelArray<f32, WHEELS>,
    /// Errors of gyro, wheels and torque, one sigma each. Unused by `ekf-sgf-rls`.
    pub hardware: Hardware<f32, WHEELS>,
    /// Inertia before the first sample, with its uncertainty.
    pub prior: Option<Prior<f32>>,
}

/// Start of an estimator, and the functions that not every estimator has.
trait Entry: Step + Work + Persist {
    /// Starts the estimator in its storage, without a copy of its state on the stack. The storage is
    /// unchanged after an error.
    fn start(slot: &mut EstimatorSlot, from: &InitialData) -> Result<(), Refused>;

    /// As [`fsw_core::Estimator::estimate`]. Not inlined: each estimate has a stack frame of its own.
    #[inline(never)]
    fn report(&self) -> Estimate<f32> {
        fsw_core::Estimator::estimate(self)
    }
}

/// The estimator in a slot, independent of its type. Its step is [`Step::step_fast`]: a reference to
/// `dyn Estimator` would link each step a second time.
pub trait Selected {
    /// As [`fsw_core::Estimator::step`].
    fn step(&mut self, sample: &Sample<f32, WHEELS>) -> Outcome;
    /// As [`Work::work_in_slices`].
    fn work(&mut self, slices: u32) -> Remaining;
    /// As [`fsw_core::Estimator::rate_rad_s`].
    fn rate_rad_s(&self) -> Vec3<f32>;
    /// As [`fsw_core::Estimator::innovation`].
    fn innovation(&self) -> Option<Innovation<f32>>;
    /// As [`fsw_core::Estimator::each_of_hardware`].
    fn each_of_hardware(&self, visit: &mut dyn FnMut(Finding<f32>));
}

impl<E: Entry> Selected for E {
    fn step(&mut self, sample: &Sample<f32, WHEELS>) -> Outcome {
        self.step_fast(sample)
    }

    fn work(&mut self, slices: u32) -> Remaining {
        self.work_in_slices(slices)
    }

    fn rate_rad_s(&self) -> Vec3<f32> {
        fsw_core::Estimator::rate_rad_s(self)
    }

    fn innovation(&self) -> Option<Innovation<f32>> {
        fsw_core::Estimator::innovation(self)
    }

    #[inline(never)]
    fn each_of_hardware(&self, visit: &mut dyn FnMut(Finding<f32>)) {
        fsw_core::Estimator::each_of_hardware(self, visit);
    }
}

/// Generates the roster from rows `number "name" => Variant(type) { implementation of Entry }`.
macro_rules! roster {
    ($(
        $(#[doc = $doc:literal])+
        $number:literal $name:tt => $variant:ident($estimator:ty) { $($entry:tt)+ }
    )+) => {
        /// Estimator, by its number in telemetry, telecommand and checkpoint.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[cfg_attr(target_os = "none", derive(defmt::Format))]
        #[repr(u8)]
        pub enum EstimatorId {
            $($(#[doc = $doc])+ $variant = $number,)+
        }

        impl EstimatorId {
            /// All estimators of the roster, built in or not.
            pub const ALL: [Self; [$($number),+].len()] = [$(Self::$variant),+];

            /// The estimators that this image has, in the order of the roster.
            pub const BUILT_IN: &[Self] = &[$(#[cfg(feature = $name)] Self::$variant),+];

            /// Number and name of each estimator.
            pub const CODES: &[(u8, &str)] = &[$(($number, $name)),+];

            /// Name, as in `host-sim --estimator`.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }

        fsw_core::persist!([] enum EstimatorId { $($number => $variant),+ });

        /// Storage of the selected estimator: one place for all, so that a selection allocates
        /// nothing.
        #[derive(Debug, Clone, Default)]
        #[allow(clippy::large_enum_variant, reason = "one place for all")]
        #[repr(u8)] // a static of `Uninitialised` is all zeros and takes no flash
        pub enum EstimatorSlot {
            /// No estimator has been started.
            #[default]
            Uninitialised,
            $(
                $(#[doc = $doc])+
                #[cfg(feature = $name)]
                $variant($estimator),
            )+
        }

        impl EstimatorSlot {
            /// Size of the largest estimator of the roster, bytes.
            pub const LARGEST_BYTES: usize = largest(&[$(size_of::<$estimator>()),+]);

            /// Layout of all estimators in a checkpoint, mixed into `layout` in the order of the
            /// roster. It is the same in all images: estimators that are not built in are included.
            pub fn mix_layout(layout: u32) -> u32 {
                [$(<$estimator>::layout()),+].into_iter().fold(layout, checkpoint::mix)
            }

            /// The estimator in this slot; `None` before the first start.
            pub fn id(&self) -> Option<EstimatorId> {
                match self {
                    Self::Uninitialised => None,
                    $(#[cfg(feature = $name)] Self::$variant(_) => Some(EstimatorId::$variant),)+
                }
            }

            /// Starts an estimator in this slot.
            ///
            /// # Errors
            /// [`Refused::NotBuiltIn`], [`Refused::NoNominalInertia`], or [`Refused::Config`] for a
            /// value that the estimator does not accept. The slot is unchanged then.
            pub fn start(&mut self, id: EstimatorId, from: &InitialData) -> Result<(), Refused> {
                match id {
                    $(
                        #[cfg(feature = $name)]
                        EstimatorId::$variant => <$estimator as Entry>::start(self, from),
                    )+
                    #[allow(unreachable_patterns, reason = "with all estimators built in")]
                    _ => Err(Refused::NotBuiltIn),
                }
            }

            /// The estimate; that of the unknown prior before the first start. Inlined, and so
            /// compiled for size by the firmware.
            #[inline]
            pub fn estimate(&self) -> Estimate<f32> {
                match self {
                    Self::Uninitialised => Estimate::nothing(),
                    $(#[cfg(feature = $name)] Self::$variant(estimator) => estimator.report(),)+
                }
            }

            /// State of the estimator as words of a checkpoint; rejected before the first start.
            /// Inlined, and so compiled for size by the firmware.
            #[inline]
            pub fn persist(&mut self, archive: &mut Archive<'_>) {
                match self {
                    Self::Uninitialised => archive.refuse("EstimatorSlot"),
                    $(#[cfg(feature = $name)] Self::$variant(estimator) => estimator.persist(archive),)+
                }
            }

            /// The estimator; `None` before the first start.
            ///
            /// Never inlined into another crate: the functions of the estimator would be compiled
            /// there, at the level of that crate.
            #[inline(never)]
            pub fn selected(&self) -> Option<&dyn Selected> {
                match self {
                    Self::Uninitialised => None,
                    $(#[cfg(feature = $name)] Self::$variant(estimator) => Some(estimator),)+
                }
            }

            /// As [`selected`](Self::selected), mutable.
            #[inline(never)]
            pub fn selected_mut(&mut self) -> Option<&mut dyn Selected> {
                match self {
                    Self::Uninitialised => None,
                    $(#[cfg(feature = $name)] Self::$variant(estimator) => Some(estimator),)+
                }
            }
        }

        $(
            #[cfg(feature = $name)]
            impl Entry for $estimator {
                $($entry)+
            }
        )+
    };
}

roster! {
    /// `window`: each manoeuvre fitted as a whole. Unknowns: angular momentum, inertia, time offset and common scales;
    /// the other errors of the hardware are considered.
    0 "window" => Window(FlightWindow) {
        fn start(slot: &mut EstimatorSlot, from: &InitialData) -> Result<(), Refused> {
            check_window(from)?;
            if !matches!(slot, EstimatorSlot::Window(_)) {
                place_window(slot, from);
            }
            reset_window(slot, from)
        }
    }

    /// `joint-ekf`: rate and inertia in one filter, which considers the stated errors of the hardware.
    1 "joint-ekf" => JointEkf(FlightJointEkf) {
        #[inline(never)]
        fn start(slot: &mut EstimatorSlot, from: &InitialData) -> Result<(), Refused> {
            check_joint_ekf(from)?;
            place_joint_ekf(slot, from);
            if let EstimatorSlot::JointEkf(filter) = slot {
                filter.consider(&from.hardware, &fsw_core::hardware::Disturbance::none())?;
                filter.complete();
            }
            Ok(())
        }
    }

    /// `ekf-sgf-rls`: rate filter, differentiator, recursive least squares. Needs a prior: its
    /// inertia is the nominal one of the rate filter.
    2 "ekf-sgf-rls" => EkfSgfRls(EkfSgfRls) {
        #[inline(never)]
        fn start(slot: &mut EstimatorSlot, from: &InitialData) -> Result<(), Refused> {
            let config = ekf_sgf_config(from)?;
            let rate = EkfSgfRls::check(&config)?;
            place_ekf_sgf(slot, config, &rate, from);
            Ok(())
        }
    }
}

/// Configuration of `window`.
#[cfg(feature = "window")]
fn window_config(from: &InitialData) -> estimator::window::Config<f32, WHEELS> {
    let config = estimator::window::Config::new(from.gyro_noise_rad_s);
    // The flight computer calls `work` itself.
    estimator::window::Config {
        prior: from.prior,
        hardware: from.hardware,
        slices_per_step: 0,
        ..config
    }
}

/// Checks the configuration of `window`. Not inlined, as each of the functions of a start: their copies on the stack
/// must not add up.
#[cfg(feature = "window")]
#[inline(never)]
fn check_window(from: &InitialData) -> Result<(), ConfigError> {
    window_config(from).validate::<{ FlightWindow::UNKNOWNS }, { FlightWindow::CONSIDERED }, 0>()
}

/// Resets `window` in its storage.
#[cfg(feature = "window")]
#[inline(never)]
fn reset_window(slot: &mut EstimatorSlot, from: &InitialData) -> Result<(), Refused> {
    match slot {
        EstimatorSlot::Window(window) => Ok(window.reset(window_config(from))?),
        #[allow(unreachable_patterns, reason = "with `window` alone built in")]
        _ => Ok(()),
    }
}

/// Constructs `window` in its storage, to be reset.
#[cfg(feature = "window")]
#[inline(never)]
fn place_window(slot: &mut EstimatorSlot, from: &InitialData) {
    *slot = EstimatorSlot::Window(FlightWindow::in_place(from.wheels));
}

/// Configuration of `joint-ekf`.
#[cfg(feature = "joint-ekf")]
fn joint_ekf_config(from: &InitialData) -> estimator::joint_ekf::Config<f32> {
    let config = estimator::joint_ekf::Config::new(from.gyro_noise_rad_s);
    estimator::joint_ekf::Config { prior: from.prior, ..config }
}

/// Checks the configuration of `joint-ekf`.
#[cfg(feature = "joint-ekf")]
#[inline(never)]
fn check_joint_ekf(from: &InitialData) -> Result<(), ConfigError> {
    from.hardware.validate()?;
    joint_ekf_config(from).validate()
}

/// Constructs `joint-ekf` in its storage, to be completed.
#[cfg(feature = "joint-ekf")]
#[inline(never)]
fn place_joint_ekf(slot: &mut EstimatorSlot, from: &InitialData) {
    *slot = EstimatorSlot::JointEkf(FlightJointEkf::in_place(joint_ekf_config(from), from.wheels));
}

/// Configuration of `ekf-sgf-rls`.
#[cfg(feature = "ekf-sgf-rls")]
fn ekf_sgf_config(from: &InitialData) -> Result<estimator::ekf_sgf::Config<f32>, Refused> {
    let nominal = from.prior.ok_or(Refused::NoNominalInertia)?;
    Ok(estimator::ekf_sgf::Config::kim_2013(from.gyro_noise_rad_s, nominal))
}

/// Constructs `ekf-sgf-rls` in its storage.
#[cfg(feature = "ekf-sgf-rls")]
#[inline(never)]
fn place_ekf_sgf(
    slot: &mut EstimatorSlot,
    config: estimator::ekf_sgf::Config<f32>,
    rate: &estimator::ekf_sgf::rate_ekf::RateEkf<f32>,
    from: &InitialData,
) {
    *slot = EstimatorSlot::EkfSgfRls(EkfSgfRls::of_valid(config, rate, from.wheels));
}

impl EstimatorSlot {
    /// The window estimator, for the functions that it alone has. No function of each estimator in the
    /// slot: an image without `window` would contain their code.
    #[inline]
    pub fn window(&self) -> Option<&FlightWindow> {
        match self {
            #[cfg(feature = "window")]
            Self::Window(window) => Some(window),
            _ => None,
        }
    }

    /// As [`window`](Self::window), mutable.
    #[inline]
    pub fn window_mut(&mut self) -> Option<&mut FlightWindow> {
        match self {
            #[cfg(feature = "window")]
            Self::Window(window) => Some(window),
            _ => None,
        }
    }
}

/// The largest of these sizes.
const fn largest(sizes: &[usize]) -> usize {
    let (mut most, mut index) = (0, 0);
    while index < sizes.len() {
        if sizes[index] > most {
            most = sizes[index];
        }
        index += 1;
    }
    most
}

impl EstimatorId {
    /// The estimator that an image starts with: the first of the roster that is built in.
    pub const FIRST: Self = {
        assert!(
            !Self::BUILT_IN.is_empty(),
            "no estimator is built in: enable at least one of the cargo features `window`, \
             `joint-ekf`, `ekf-sgf-rls`"
        );
        Self::BUILT_IN[0]
    };

    /// The estimator of a number; `None` for a number outside the roster.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|id| *id as u8 == number)
    }

    /// The estimator of a name; `None` for a name outside the roster.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|id| id.name() == name)
    }
}
