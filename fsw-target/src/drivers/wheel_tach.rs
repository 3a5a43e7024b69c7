//! Reaction-wheel tachometers: the driver [`wheel_tach`] as the sensors of the flight loop.

pub use wheel_tach::*;

use crate::flight::sensors::{MotorTorque, WheelTachometers};

impl<C, const W: usize> WheelTachometers<W> for WheelTach<C, W>
where
    C: CaptureTimer<W> + MotorTorque<W>,
{
    type Error = Error<C::Error>;

    fn speed_rad_s(&mut self) -> Result<[f32; W], Self::Error> {
        Self::speed_rad_s(self)
    }

    /// Of the board. A wheel with an assumed speed is not judged.
    fn motor_torque_n_m(&mut self) -> [Option<f32>; W] {
        let mut torque_n_m = self.timer().motor_torque_n_m();
        for (torque_n_m, is_assumed) in torque_n_m.iter_mut().zip(self.are_assumed()) {
            *torque_n_m = torque_n_m.filter(|_| !is_assumed);
        }
        torque_n_m
    }

    fn are_valid(&self) -> [bool; W] {
        Self::are_valid(self)
    }

    fn assume(&mut self, wheel: usize, speed_rad_s: Option<f32>) -> bool {
        Self::assume(self, wheel, speed_rad_s)
    }
}
