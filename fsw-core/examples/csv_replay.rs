//! A recorded flight, replayed through the `window` estimator.
//!
//! ```text
//! cargo run -p fsw-core --example csv_replay [LOG.csv]
//! ```
//!
//! Columns are found by name: `t_s`, `gyro_x_rad_s`, `gyro_y_rad_s`, `gyro_z_rad_s`; optional are
//! `wheel_1_rad_s` to `wheel_4_rad_s` (relative to the body) and `torque_x_n_m`, `torque_y_n_m`,
//! `torque_z_n_m` (external). A missing optional column counts as zero. The craft is that of
//! `fsw-target/flights/cubesat_pyramid.csv`, the default log. For another craft, change [`AXES`],
//! [`SPIN_INERTIA_KG_M2`] and [`GYRO_NOISE_RAD_S`].

use fsw_core::estimator::window::{Config, Window};
use fsw_core::outcome::OutcomeCounts;
use fsw_core::{Estimator, Sample, Vec3, WheelArray};
use std::error::Error;

/// Number of wheels.
const WHEELS: usize = 4;
/// Spin axes in body axes; [`WheelArray::new`] normalises them.
const AXES: [[f32; 3]; WHEELS] =
    [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [1.0, -1.0, 1.0]];
/// Spin inertia of each wheel, kg m².
const SPIN_INERTIA_KG_M2: f32 = 2.1e-5;
/// One sigma of the gyro noise, white, per sample, rad/s.
const GYRO_NOISE_RAD_S: f32 = 1e-4;

/// Log to replay where no argument names one.
const DEFAULT_LOG: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../fsw-target/flights/cubesat_pyramid.csv");

/// Indices of the columns in a log.
struct Columns {
    /// Time stamp.
    time: usize,
    /// Rate about x, y and z.
    gyro: [usize; 3],
    /// Speed of each wheel, if recorded.
    wheel: [Option<usize>; WHEELS],
    /// External torque about x, y and z, if recorded.
    torque: [Option<usize>; 3],
}

impl Columns {
    /// Columns of a log by the names in its header.
    ///
    /// # Errors
    /// Names a required column that the header lacks.
    fn new(header: &csv::StringRecord) -> Result<Self, String> {
        let optional = |name: String| header.iter().position(|column| column.trim() == name);
        let required = |name: &str| {
            optional(name.to_owned()).ok_or_else(|| format!("the log has no column {name}"))
        };
        let axes = ["x", "y", "z"];
        Ok(Self {
            time: required("t_s")?,
            gyro: [required("gyro_x_rad_s")?, required("gyro_y_rad_s")?, required("gyro_z_rad_s")?],
            wheel: core::array::from_fn(|i| optional(format!("wheel_{}_rad_s", i + 1))),
            torque: axes.map(|axis| optional(format!("torque_{axis}_n_m"))),
        })
    }

    /// Sample of one row.
    ///
    /// # Errors
    /// A field that is not a number.
    fn sample(&self, row: &csv::StringRecord) -> Result<Sample<f32, WHEELS>, Box<dyn Error>> {
        let number = |column: usize| row.get(column).unwrap_or_default().trim().parse::<f64>();
        let optional = |column: Option<usize>| column.map_or(Ok(0.0), number);
        let three = |columns: [Option<usize>; 3]| -> Result<Vec3<f32>, Box<dyn Error>> {
            let [x, y, z] = columns.map(optional);
            Ok(Vec3::new(x? as f32, y? as f32, z? as f32))
        };
        let mut wheel_speed_rad_s = [0.0; WHEELS];
        for (speed, column) in wheel_speed_rad_s.iter_mut().zip(self.wheel) {
            *speed = optional(column)? as f32;
        }
        Ok(Sample {
            // Whole microseconds: single precision would lose them within a minute.
            time_us: (number(self.time)? * 1e6).round() as u64,
            rate_rad_s: three(self.gyro.map(Some))?,
            wheel_speed_rad_s,
            torque_n_m: three(self.torque)?,
            attitude: None,
        })
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| DEFAULT_LOG.to_owned());
    let wheels = WheelArray::new(AXES.map(Vec3::from), [SPIN_INERTIA_KG_M2; WHEELS])?;
    let mut window = Window::<f32, WHEELS, 512, 9>::new(Config::new(GYRO_NOISE_RAD_S), wheels)?;
    let mut counts = OutcomeCounts::default();

    let mut log = csv::Reader::from_path(&path)?;
    let columns = Columns::new(log.headers()?)?;
    for row in log.records() {
        let outcome = window.step(&columns.sample(&row?)?);
        counts.add(&outcome);
    }
    window.finish();

    let estimate = window.estimate();
    println!("log        {path}");
    println!("samples    {} accepted", counts.accepted);
    for (reason, number) in counts.rejected().into_iter().filter(|(_, number)| *number > 0) {
        println!("           {number} rejected: {reason}");
    }
    println!("status     {:?}, {} of 6 directions", estimate.status, estimate.observed.directions);
    println!("elements   jxx jyy jzz jxy jxz jyz");
    println!("estimate   {:.6?} kg m²", estimate.inertia.elements_kg_m2());
    println!("one sigma  {:.6?} kg m²", estimate.sigma_kg_m2());
    println!("residual   {:.2e} rad/s RMS", estimate.residual_rms_rad_s);
    Ok(())
}
