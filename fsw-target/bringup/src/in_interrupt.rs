//! Flight loop in the exception PendSV, raised by each gyro sample: for images with another main loop.

use core::cell::Cell;
use core::convert::Infallible;
use core::sync::atomic::{AtomicU32, Ordering};
use critical_section::Mutex;
use fsw_core::estimator::joint_ekf::{Config, JointEkfUd};
use fsw_core::{Vec3, WheelArray};
use fsw_target::board::GyroDataReady;
use fsw_target::flight::flight_loop::{FlightLoop, Sensors, Tick};
use fsw_target::flight::sensors::{CommandedTorque, Gyro, WheelTachometers};

/// Samples stepped.
static SAMPLES: AtomicU32 = AtomicU32::new(0);
/// Data-ready line, passed to the exception.
static LINE: Mutex<Cell<Option<GyroDataReady>>> = Mutex::new(Cell::new(None));

/// True if the flight loop steps every sample that the main loop triggers.
pub fn loop_steps_every_sample(data_ready: GyroDataReady) -> bool {
    const SAMPLE_COUNT: u32 = 20;
    data_ready.also_pend_sv();
    critical_section::with(|section| LINE.borrow(section).set(Some(data_ready)));
    for _ in 0..SAMPLE_COUNT {
        GyroDataReady::trigger();
    }
    SAMPLES.load(Ordering::Relaxed) == SAMPLE_COUNT
}

/// Gyro and tachometer of a body at rest.
struct AtRest;

impl Gyro for AtRest {
    type Error = Infallible;
    fn rate_rad_s(&mut self) -> Result<Vec3<f32>, Infallible> {
        Ok(Vec3::zeros())
    }
}

impl WheelTachometers<1> for AtRest {
    type Error = Infallible;
    fn speed_rad_s(&mut self) -> Result<[f32; 1], Infallible> {
        Ok([0.0])
    }
}

type Flight = FlightLoop<JointEkfUd<f32, 1>, GyroDataReady, AtRest, AtRest, CommandedTorque, 1>;

/// One tick of the flight loop per sample, independent of the main loop.
#[cortex_m_rt::exception]
fn PendSV() {
    static mut FLIGHT: Option<Flight> = None;

    if FLIGHT.is_none() {
        *FLIGHT = critical_section::with(|section| LINE.borrow(section).take()).and_then(start);
    }
    if let Some(Tick::Stepped { .. }) = FLIGHT.as_mut().map(Flight::tick) {
        SAMPLES.fetch_add(1, Ordering::Relaxed);
    }
}

/// Flight loop of a body with one wheel.
fn start(data_ready: GyroDataReady) -> Option<Flight> {
    let wheels = WheelArray::new([Vec3::new(0.0, 0.0, 1.0)], [1e-5]).ok()?;
    let estimator = JointEkfUd::new(Config::new(1e-4), wheels).ok()?;
    let sensors =
        Sensors { data_ready, gyro: AtRest, wheels: AtRest, torque: CommandedTorque::default() };
    Some(FlightLoop::new(estimator, sensors))
}
