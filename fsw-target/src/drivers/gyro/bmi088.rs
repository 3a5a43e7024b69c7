//! Gyro of a BMI088: the driver [`bmi088_gyro`] as a gyro of the flight loop.

pub use bmi088_gyro::*;

use super::{Gyro, RateGyro, StartFault};
use bus::RegisterBus;
use embedded_hal::delay::DelayNs;
use fsw_core::Vec3;

impl<B: RegisterBus> Gyro for Bmi088<B> {
    type Error = ReadError<B::Error>;

    fn rate_rad_s(&mut self) -> Result<Vec3<f32>, Self::Error> {
        Self::rate_rad_s(self).map(Vec3::from)
    }

    fn delay_us(&self) -> u32 {
        Self::delay_us(self)
    }
}

impl<B: RegisterBus> RateGyro for Bmi088<B> {
    const IDENTITY: u8 = CHIP_ID;

    type StartError = StartError<B::Error>;
    type SelfTestError = SelfTestError<B::Error>;

    fn restart(&mut self, delay: &mut impl DelayNs) -> Result<(), Self::StartError> {
        Self::restart(self, delay)
    }

    fn self_test(&mut self, delay: &mut impl DelayNs) -> Result<(), Self::SelfTestError> {
        Self::self_test(self, delay)
    }

    fn range_rad_s(&self) -> f32 {
        Self::range_rad_s(self)
    }

    fn quantum_rad_s(&self) -> f32 {
        Self::quantum_rad_s(self)
    }
}

impl<E> From<StartError<E>> for StartFault {
    fn from(error: StartError<E>) -> Self {
        match error {
            StartError::Bus(_) => Self::Bus,
            StartError::WrongIdentity { found } => Self::WrongIdentity { found },
            StartError::NotAccepted(_) => Self::NotAsSet,
            StartError::NotARotation => Self::WrongSettings,
        }
    }
}
