//! Configuration of the window estimator.

use crate::error::{ConfigError, Invalid};
use crate::gate;
use crate::hardware::{Hardware, Mode, Parameter};
use crate::math::range::{not_negative, positive};
use crate::math::scalar::Real;
use crate::prior::Prior;
use crate::trajectory::unknowns::{
    Belief, GROUPS, GROUPS_OF_FIELD, GROUPS_OF_MODE, Group, Groups, MOST_MODES, groups_of,
    may_hold_fields,
};

/// Prior sigma of each element of a modal inertia over the trace: a tenth of a mean moment of inertia. Appendages and
/// liquids of small spacecraft carry 1 to 20 % of it; one of half of the body would raise its frequency by 40 %, and a
/// linear fit would not find it.
const MODAL_SIGMA: f64 = 0.1 / 3.0;
/// Sigma of the constant torque over that of the torque of fields, at least, where both are solved for.
const LEAST_CONSTANT: f64 = 0.01;

/// Configuration, fixed for the estimator's life.
///
/// ```
/// use fsw_core::estimator::window::Config;
///
/// let config = Config { gyro_bias_rad_s: Some(0.01), ..Config::<f32, 0>::new(1e-4) };
/// assert!(config.validate::<12, 0, 0>().is_ok()); // one further group of unknowns
/// assert_eq!(config.validate::<9, 0, 0>().unwrap_err().field, "gyro_bias_rad_s");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config<T: Real, const W: usize> {
    /// Inertia before any data. Default none, and none is needed. A prior that the data contradict is
    /// discarded.
    pub prior: Option<Prior<T>>,
    /// Gyro noise, one sigma, white, per sample, rad/s. None: measured from differences of the
    /// readings.
    pub gyro_noise_rad_s: Option<T>,
    /// One sigma of a constant disturbance torque, N m, each axis. Default none: zero, and where U
    /// leaves a place the residuals are tested for one.
    pub disturbance_torque_n_m: Option<T>,
    /// One sigma of a torque of fields, which varies as the body turns against them, N m, each axis: of a magnetic
    /// dipole, of the gravity gradient, of drag. Default zero. It needs `disturbance_torque_n_m`, the sigma of both
    /// together.
    pub varying_torque_n_m: T,
    /// One sigma of a constant gyro bias, rad/s, each axis. Default none: zero.
    pub gyro_bias_rad_s: Option<T>,
    /// Random walk of the gyro bias, one sigma after a second, (rad/s)/√s, each axis. Default zero: a constant
    /// bias. A walk needs `gyro_bias_rad_s`, the sigma of the bias at the start of a window.
    pub bias_walk_rad_s_sqrt_s: T,
    /// Instability of the gyro bias, floor of its Allan deviation, rad/s, each axis. Default zero. It needs
    /// `gyro_bias_rad_s` too.
    pub bias_instability_rad_s: T,
    /// One sigma of the drag rates of a body in air, 1/s, each axis. Default none: zero. Otherwise the
    /// drag is estimated once the residuals show it.
    pub drag_per_s: Option<T>,
    /// Random walk of each element of the inertia, one sigma after a second, kg m²/√s. Default zero.
    pub inertia_walk_kg_m2_sqrt_s: T,
    /// Samples of a block at first; doubled whenever storage is full of blocks that turn little.
    /// Default 4.
    pub block_samples: u32,
    /// Largest turn of a block, rad. Default 0.6: its mean keeps 97 % of the information on a
    /// motion that turns with the body, and storage for 512 blocks holds 48 turns.
    pub block_turn_rad: T,
    /// True for external torque that is smooth between its samples, such as a sine; false for straight
    /// lines, such as a table. Default false.
    pub is_torque_smooth: bool,
    /// Slices of work that a step does after taking in its sample. Default 1. Zero for a caller that
    /// calls [`work`](super::Window::work) itself.
    pub slices_per_step: u32,
    /// Time without motion that ends a manoeuvre, s. Default 30.
    pub quiet_s: T,
    /// Errors of gyro, wheels and known torque, one sigma each. Default ideal. Those that are not zero are
    /// among the unknowns, with a place in U for each group of three ([`unknowns`](super::unknowns)), or considered
    /// where U has no place for all: then the last place is kept for them, and C groups at most are considered.
    pub hardware: Hardware<T, W>,
    /// Stated modes, in the first places. Default none. Each needs three places in U, and as many as there are need M.
    /// The body and its modes are at rest relative to one another at the start of a window. A block should be shorter
    /// than an eighth of the period.
    pub modes: [Option<Mode<T>>; MOST_MODES],
    /// Checks of each sample.
    pub gate: gate::Config<T>,
}

// A command may set the prior.
crate::persist!([T: Real, const W: usize] Config<T, W> {
    prior;
    unchanged gyro_noise_rad_s, disturbance_torque_n_m, varying_torque_n_m, gyro_bias_rad_s, bias_walk_rad_s_sqrt_s, bias_instability_rad_s,
    drag_per_s, inertia_walk_kg_m2_sqrt_s, block_samples, block_turn_rad, is_torque_smooth, slices_per_step, quiet_s,
    hardware, modes, gate
});

impl<T: Real, const W: usize> Config<T, W> {
    /// Defaults for a gyro of this noise (one sigma, white, per sample, rad/s).
    pub fn new(gyro_noise_rad_s: T) -> Self {
        Self { gyro_noise_rad_s: Some(gyro_noise_rad_s), ..Self::of_unknown_noise() }
    }

    /// Defaults for a gyro of unknown noise.
    pub fn of_unknown_noise() -> Self {
        Self {
            prior: None,
            gyro_noise_rad_s: None,
            disturbance_torque_n_m: None,
            varying_torque_n_m: T::zero(),
            gyro_bias_rad_s: None,
            bias_walk_rad_s_sqrt_s: T::zero(),
            bias_instability_rad_s: T::zero(),
            drag_per_s: None,
            inertia_walk_kg_m2_sqrt_s: T::zero(),
            block_samples: 4,
            block_turn_rad: T::lit(0.6),
            is_torque_smooth: false,
            slices_per_step: 1,
            quiet_s: T::lit(30.0),
            hardware: Hardware::ideal(),
            modes: [None; MOST_MODES],
            gate: gate::Config::default(),
        }
    }

    /// Checks the ranges, and that U unknowns and C considered groups hold what is asked for.
    ///
    /// # Errors
    /// Names the first field that is out of its range, or for whose group U has no place.
    pub fn validate<const U: usize, const C: usize, const M: usize>(
        &self,
    ) -> Result<(), ConfigError> {
        let mut places = self.places_beside_asked::<U>()?;
        self.validate_walks()?;
        for mode in self.modes.iter().flatten() {
            mode.validate()?;
            places = places
                .checked_sub(GROUPS_OF_MODE)
                .ok_or(ConfigError { field: "modes", reason: Invalid::NoRoom })?;
        }
        if self.modes.iter().flatten().count() > M {
            return Err(ConfigError { field: "modes", reason: Invalid::NoRoom });
        }
        self.hardware.validate()?;
        let not_solved = self.hardware_groups().count() - self.solved_groups(places);
        if not_solved > C || not_solved > 0 && places == 0 {
            return Err(ConfigError { field: "hardware", reason: Invalid::NoRoom });
        }
        positive("block_turn_rad", self.block_turn_rad)?;
        positive("quiet_s", self.quiet_s)?;
        not_negative("inertia_walk_kg_m2_sqrt_s", self.inertia_walk_kg_m2_sqrt_s)?;
        if self.block_samples == 0 {
            return Err(ConfigError { field: "block_samples", reason: Invalid::NotPositive });
        }
        if let Some(prior) = &self.prior {
            prior.validate()?;
        }
        self.gate.validate()
    }

    /// Places of U unknowns beside torque, bias and drag, where these are asked for.
    ///
    /// # Errors
    /// Names a sigma that is out of its range, or one whose group has no place.
    fn places_beside_asked<const U: usize>(&self) -> Result<usize, ConfigError> {
        if let Some(noise) = self.gyro_noise_rad_s {
            positive("gyro_noise_rad_s", noise)?;
        }
        let mut places = groups_of(U);
        for (field, value) in [
            ("disturbance_torque_n_m", self.disturbance_torque_n_m),
            ("gyro_bias_rad_s", self.gyro_bias_rad_s),
            ("drag_per_s", self.drag_per_s),
        ] {
            let Some(value) = value else { continue };
            positive(field, value)?;
            places = places.checked_sub(1).ok_or(ConfigError { field, reason: Invalid::NoRoom })?;
        }
        Ok(places)
    }

    /// # Errors
    /// True where the inertia walks.
    pub(super) fn is_walking(&self) -> bool {
        self.inertia_walk_kg_m2_sqrt_s > T::zero()
    }

    /// Names a walk that is out of its range, or whose unknown is not asked for: it begins at a value of that sigma.
    fn validate_walks(&self) -> Result<(), ConfigError> {
        not_negative("varying_torque_n_m", self.varying_torque_n_m)?;
        if self.varying_torque_n_m > T::zero() && self.disturbance_torque_n_m.is_none() {
            let (field, reason) = ("disturbance_torque_n_m", Invalid::NotPositive);
            return Err(ConfigError { field, reason });
        }
        not_negative("bias_walk_rad_s_sqrt_s", self.bias_walk_rad_s_sqrt_s)?;
        not_negative("bias_instability_rad_s", self.bias_instability_rad_s)?;
        let is_walking =
            self.bias_walk_rad_s_sqrt_s > T::zero() || self.bias_instability_rad_s > T::zero();
        if is_walking && self.gyro_bias_rad_s.is_none() {
            return Err(ConfigError { field: "gyro_bias_rad_s", reason: Invalid::NotPositive });
        }
        Ok(())
    }

    /// One sigma of an error that scales all that drives the body, share: it scales the tensor, and no motion shows
    /// it. Without wheels that of the known torque. As an unknown its column would be proportional to that of the
    /// scale, and single precision would find false information in their rounding.
    pub(super) fn considered_scale(&self) -> T {
        if W == 0 { self.hardware.torque_scale } else { T::zero() }
    }

    /// Groups of the hardware that are not known exactly, with their sigmas.
    fn hardware_groups(&self) -> impl Iterator<Item = (Group, Belief<T>)> + '_ {
        (0..4 + W).filter_map(|index| self.hardware_group(index))
    }

    /// Number of groups of the hardware among the unknowns, for these places: all, or as many as leave the last place
    /// to those that are considered.
    fn solved_groups(&self, places: usize) -> usize {
        let all = self.hardware_groups().count();
        if all <= places { all } else { places.saturating_sub(1) }
    }

    /// Places of U unknowns beside the groups of one window that are asked for.
    fn places_of_hardware<const U: usize>(&self) -> usize {
        let asked = [self.disturbance_torque_n_m, self.gyro_bias_rad_s, self.drag_per_s];
        let modes = self.modes.iter().flatten().count();
        let field = if self.has_field::<U>() { GROUPS_OF_FIELD } else { 0 };
        groups_of(U).saturating_sub(asked.iter().flatten().count() + GROUPS_OF_MODE * modes + field)
    }

    /// True where the torque of fields is solved for: stated, without modes, and U has places for all that is stated.
    /// It is a walk otherwise (module `drift`).
    pub(super) fn has_field<const U: usize>(&self) -> bool {
        if !may_hold_fields(U) || self.varying_torque_n_m <= T::zero() {
            return false;
        }
        let asked = [self.disturbance_torque_n_m, self.gyro_bias_rad_s, self.drag_per_s];
        let groups = asked.iter().flatten().count() + GROUPS_OF_FIELD;
        let is_rigid = self.modes.iter().all(Option::is_none);
        is_rigid && groups_of(U) >= groups + self.hardware_groups().count()
    }

    /// Group of the hardware that is considered with this index; none beyond the last one.
    pub(super) fn considered_group<const U: usize>(
        &self,
        index: usize,
    ) -> Option<(Group, Belief<T>)> {
        let solved = self.solved_groups(self.places_of_hardware::<U>());
        self.hardware_groups().nth(solved + index)
    }

    /// Group of the hardware with this index, of 4 + W; none where it is known exactly. The time offset comes first: it
    /// is the one that motion shows best.
    fn hardware_group(&self, index: usize) -> Option<(Group, Belief<T>)> {
        let h = &self.hardware;
        let (group, sigma) = match index {
            0 => {
                // Without wheels the scale of the torque is that of the inertia: see `considered_scale`.
                let of_drive = |parameter, own| {
                    if W > 0 { h.with_clock(parameter, own) } else { T::zero() }
                };
                let torque_scale = of_drive(Parameter::TorqueScale, h.torque_scale);
                let wheels = of_drive(Parameter::CommonWheelInertia, h.common_wheel_inertia);
                (Group::Common, [h.delay_sigma_s, torque_scale, wheels])
            }
            1 => (Group::GyroScale, [h.with_clock(Parameter::GyroScale(0), h.gyro_scale); 3]),
            2 => (Group::GyroUpper, [h.gyro_axes_rad; 3]),
            3 => (Group::GyroLower, [h.gyro_axes_rad; 3]),
            _ => {
                let wheel = index - 4;
                let (inertia, tilt) = (h.wheel_inertia.get(wheel)?, h.wheel_axis_rad.get(wheel)?);
                (Group::Wheel(wheel as u8), [*inertia, *tilt, *tilt])
            }
        };
        sigma.iter().any(|s| *s > T::zero()).then_some((group, Belief::Within(sigma)))
    }

    /// Groups of one window, in the order of their places: those that are asked for, and torque where it is tested.
    fn window_groups<const U: usize>(&self) -> impl Iterator<Item = (Group, Belief<T>)> {
        let within = |group, sigma: Option<T>| sigma.map(|s| (group, Belief::Within([s; 3])));
        let field = self.has_field::<U>().then(|| self.field_groups()).into_iter().flatten();
        let constant = |sigma: T| {
            if self.has_field::<U>() { self.constant_torque_n_m(sigma) } else { sigma }
        };
        let torque = within(Group::Torque, self.disturbance_torque_n_m.map(constant));
        let untested_torque = torque.is_none().then_some((Group::Torque, Belief::Zero));
        let drag = self.drag_per_s.map(|_| (Group::Drag, Belief::Zero));
        let bias = within(Group::Bias, self.gyro_bias_rad_s);
        let modes =
            (0u8..).zip(&self.modes).flat_map(|(index, mode)| of_mode(index, mode.as_ref()));
        let asked = [torque, bias, drag].into_iter().flatten();
        asked.chain(field).chain(modes).chain(untested_torque)
    }

    /// Sigma of the constant torque, of that of all torque: never so small that it has no unknown.
    fn constant_torque_n_m(&self, all: T) -> T {
        let of_field = self.varying_torque_n_m;
        let variance = all * all - of_field * of_field;
        variance.max(of_field * of_field * T::lit(LEAST_CONSTANT * LEAST_CONSTANT)).sqrt()
    }

    /// Groups of the torque of a field. Two products of the moment and the field add up to the torque about an axis.
    fn field_groups(&self) -> [(Group, Belief<T>); GROUPS_OF_FIELD] {
        let sigma = self.varying_torque_n_m * T::lit(core::f64::consts::FRAC_1_SQRT_2);
        let product = |k| (Group::Field(k), Belief::Within([sigma; 3]));
        [product(0), product(1), product(2), (Group::Axes, Belief::Within([T::zero(); 3]))]
    }

    /// Sets groups of unknowns by place: those of one window that are asked for and those that are tested, as far as
    /// U holds them, then those of the hardware. In place: they are large.
    #[inline(never)]
    pub(super) fn set_groups<const U: usize>(&self, groups: &mut Groups<T>) {
        groups.place = [None; GROUPS];
        groups.delay_s = self.hardware.delay_s;
        groups.clock = self.hardware.clock;
        let tau = T::lit(core::f64::consts::TAU);
        groups.modes = self.modes.map(|mode| {
            mode.map_or([T::zero(); 2], |mode| [tau * mode.frequency_hz, mode.damping])
        });
        let places = self.places_of_hardware::<U>();
        let solved = self.solved_groups(places);
        let is_considered = solved < self.hardware_groups().count();
        groups.hardware = groups_of(U).saturating_sub(solved + usize::from(is_considered));
        let (of_window, of_hardware) = groups.place.split_at_mut(groups.hardware.min(groups_of(U)));
        for (place, group) in of_window.iter_mut().zip(self.window_groups::<U>()) {
            *place = Some(group);
        }
        for (place, group) in of_hardware.iter_mut().zip(self.hardware_groups().take(solved)) {
            *place = Some(group);
        }
    }
}

/// Groups of a mode and the beliefs in them.
fn of_mode<T: Real>(
    index: u8,
    mode: Option<&Mode<T>>,
) -> impl Iterator<Item = (Group, Belief<T>)> + use<T> {
    let groups = mode.map(|mode| {
        let inertia = Belief::Within([T::lit(MODAL_SIGMA); 3]);
        let tuning = [mode.frequency_sigma, mode.damping_sigma, T::zero()];
        [
            (Group::ModalMoments(index), inertia),
            (Group::ModalProducts(index), inertia),
            (Group::ModeTuning(index), Belief::Within(tuning)),
        ]
    });
    groups.into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_the_field_that_is_out_of_range() {
        let refused = |change: fn(&mut Config<f32, 1>)| {
            let mut config = Config::new(1e-4);
            assert_eq!(config.validate::<12, 0, 0>(), Ok(()));
            change(&mut config);
            config.validate::<12, 0, 0>().unwrap_err().field
        };
        assert_eq!(refused(|c| c.gyro_noise_rad_s = Some(0.0)), "gyro_noise_rad_s");
        assert_eq!(refused(|c| c.disturbance_torque_n_m = Some(-1.0)), "disturbance_torque_n_m");
        assert_eq!(refused(|c| c.block_turn_rad = f32::NAN), "block_turn_rad");
        assert_eq!(refused(|c| c.quiet_s = 0.0), "quiet_s");
        assert_eq!(refused(|c| c.inertia_walk_kg_m2_sqrt_s = -1.0), "inertia_walk_kg_m2_sqrt_s");
        assert_eq!(refused(|c| c.block_samples = 0), "block_samples");
        assert_eq!(refused(|c| c.gate.range_rad_s = 0.0), "gate.range_rad_s");
        let two = |c: &mut Config<f32, 1>| {
            c.gyro_bias_rad_s = Some(1.0);
            c.disturbance_torque_n_m = Some(1.0);
        };
        assert_eq!(refused(two), "gyro_bias_rad_s", "no room for two");
    }

    /// Bias alone, and torque tested in the place that is left.
    #[test]
    fn any_subset_can_be_asked_for() {
        let config = Config { gyro_bias_rad_s: Some(0.1), ..Config::<f64, 0>::new(1e-4) };
        let mut groups = Groups::none();
        config.set_groups::<15>(&mut groups);
        assert_eq!(groups.place[0], Some((Group::Bias, Belief::Within([0.1; 3]))));
        assert_eq!(groups.place[1], Some((Group::Torque, Belief::Zero)));
        config.set_groups::<12>(&mut groups);
        assert_eq!(groups.place[1], None);
    }
}
