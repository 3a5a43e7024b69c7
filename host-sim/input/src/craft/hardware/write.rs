//! Stated hardware as lines of a craft file: all values except those assumed, so that the file reads
//! back as the same hardware.

use super::StatedHardware;
use super::keys::{
    AVERAGED, AXES_SIGMA, AXIS_SIGMA, BIAS_INSTABILITY, BIAS_SIGMA, BIAS_WALK, CLOCK_SIGMA,
    COMMON_SPIN_INERTIA_SIGMA, DATA_SHEET, DELAY, DELAY_SIGMA, KNOWN_AXES, KNOWN_SCALE,
    MODE_DAMPING, MODE_DAMPING_SIGMA, MODE_FREQUENCY, MODE_FREQUENCY_SIGMA, MOUNT_SIGMA,
    NOISE_TOLERANCE, SCALE_SIGMA, SPIN_INERTIA_SIGMA, TORQUE_SCALE_SIGMA, TORQUE_SIGMA,
    VARYING_TORQUE_SIGMA,
};
use crate::key::Key;

/// Angle in degrees whose conversion to radians gives this angle: the nearest, or one of its
/// neighbours.
fn degrees(angle_rad: f64) -> f64 {
    let nearest = angle_rad.to_degrees();
    let candidates = [nearest, nearest.next_up(), nearest.next_down()];
    candidates.into_iter().find(|deg| deg.to_radians() == angle_rad).unwrap_or(nearest)
}

impl StatedHardware {
    /// Lines of `[gyro]`, below its header.
    pub(in crate::craft) fn write_gyro(&self, text: &mut String) {
        if self.gyro_scale != [0.0; 3] {
            *text += &format!("{} = {:?}\n", KNOWN_SCALE.name, self.gyro_scale);
        }
        if self.gyro_axes_rad != [0.0; 6] {
            *text += &format!("{} = {:?}\n", KNOWN_AXES.name, self.gyro_axes_rad.map(degrees));
        }
        self.write_assumable(text, "gyro.scale_sigma", &SCALE_SIGMA, self.gyro_scale_sigma);
        let axes_deg = degrees(self.gyro_axes_sigma_rad);
        self.write_assumable(text, "gyro.axes_sigma_deg", &AXES_SIGMA, axes_deg);
        if self.gyro_delay_s != 0.0 {
            *text += &format!("{} = {:?}\n", DELAY.name, self.gyro_delay_s);
        }
        self.write_assumable(text, "gyro.delay_sigma_s", &DELAY_SIGMA, self.gyro_delay_sigma_s);
        if self.gyro_averaged {
            *text += &format!("{} = true\n", AVERAGED.name);
        }
        if let Some(sigma) = self.bias_sigma_rad_s {
            *text += &format!("{} = {sigma:?}\n", BIAS_SIGMA.name);
        }
        if self.bias_walk_rad_s_sqrt_s != 0.0 {
            *text += &format!("{} = {:?}\n", BIAS_WALK.name, self.bias_walk_rad_s_sqrt_s);
        }
        if self.bias_instability_rad_s != 0.0 {
            *text += &format!("{} = {:?}\n", BIAS_INSTABILITY.name, self.bias_instability_rad_s);
        }
        if self.clock_sigma != 0.0 {
            *text += &format!("{} = {:?}\n", CLOCK_SIGMA.name, self.clock_sigma);
        }
        let tolerance = self.gyro_noise_tolerance;
        self.write_assumable(text, "gyro.noise_tolerance", &NOISE_TOLERANCE, tolerance);
    }

    /// Lines of one `[[wheel]]`, below its header.
    pub(in crate::craft) fn write_wheel(&self, text: &mut String, index: usize) {
        let of = |sigmas: &[f64]| sigmas.get(index).copied().unwrap_or(0.0);
        let sigma = of(&self.wheel_spin_inertia_sigma);
        self.write_assumable(text, "wheel.spin_inertia_sigma", &SPIN_INERTIA_SIGMA, sigma);
        let tilt_deg = degrees(of(&self.wheel_axis_sigma_rad));
        self.write_assumable(text, "wheel.axis_sigma_deg", &AXIS_SIGMA, tilt_deg);
        if let Some(tachometer) = self.tachometers.get(index) {
            tachometer.write(text);
        }
    }

    /// The tables `[wheels]`, `[torque]`, `[mount]` and `[[mode]]`.
    pub(in crate::craft) fn write_tables(&self, text: &mut String) {
        if self.common_spin_inertia_sigma != 0.0 {
            let key = COMMON_SPIN_INERTIA_SIGMA.name;
            *text += &format!("[wheels]\n{key} = {:?}\n", self.common_spin_inertia_sigma);
        }
        *text += "[torque]\n";
        let sigma = self.torque_scale_sigma;
        self.write_assumable(text, "torque.scale_sigma", &TORQUE_SCALE_SIGMA, sigma);
        if self.mount_sigma_rad != [0.0; 3] {
            let sigma_deg = self.mount_sigma_rad.map(degrees);
            *text += &format!("[mount]\n{} = {sigma_deg:?}\n", MOUNT_SIGMA.name);
        }
        for mode in &self.modes {
            *text += &format!("[[mode]]\n{} = {:?}\n", MODE_FREQUENCY.name, mode.frequency_hz);
            *text += &format!("{} = {:?}\n", MODE_DAMPING.name, mode.damping);
            let (frequency, damping) = (mode.frequency_sigma, mode.damping_sigma);
            self.write_assumable(text, "mode.frequency_sigma", &MODE_FREQUENCY_SIGMA, frequency);
            self.write_assumable(text, "mode.damping_sigma", &MODE_DAMPING_SIGMA, damping);
        }
    }

    /// The lines of `[disturbance]` on sigmas, below its header.
    pub(in crate::craft) fn write_disturbance(&self, text: &mut String) {
        if let Some(sigma) = self.torque_sigma_n_m {
            *text += &format!("{} = {sigma:?}\n", TORQUE_SIGMA.name);
        }
        if self.varying_torque_sigma_n_m != 0.0 {
            let key = VARYING_TORQUE_SIGMA.name;
            *text += &format!("{key} = {:?}\n", self.varying_torque_sigma_n_m);
        }
    }

    /// A key with a data-sheet value, unless that value was assumed.
    fn write_assumable(&self, text: &mut String, path: &str, key: &Key, value: f64) {
        let is_assumed = self.assumed.contains(&path)
            && DATA_SHEET.iter().any(|row| row.path == path && row.value == value);
        if !is_assumed {
            *text += &format!("{} = {value:?}\n", key.name);
        }
    }
}
