//! A craft file, from TOML to Rust source.
//!
//! Decimal text is parsed as f64 and rounded to f32 once, here, and emitted as exact bits: the
//! constant holds what `host-sim replay --precision f32` reads from the same file.

use fsw_core::estimator::window;
use fsw_core::{Vec3, WheelArray};
use serde::Deserialize;
use std::{error::Error, fmt::Write as _, fs, path::Path};

/// What the craft file says: what `host-sim replay --craft` knows of wheels, gyro noise and prior.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Craft {
    /// One for each wheel.
    #[serde(default)]
    pub wheel: Vec<Wheel>,
    gyro: Gyro,
    prior: Option<Prior>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wheel {
    axis: [f64; 3],
    spin_inertia_kg_m2: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Gyro {
    noise_rad_s: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Prior {
    inertia_kg_m2: [f64; 6],
    sigma_kg_m2: [f64; 6],
}

impl Craft {
    /// Reads a craft file.
    pub fn load(path: &Path) -> Result<Self, Box<dyn Error>> {
        let text = fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(toml::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?)
    }

    /// Refuses, in the arithmetic that flies, what the estimators would: an image that is built flies.
    fn check(&self, room: usize) -> Result<(), Box<dyn Error>> {
        if self.wheel.len() > room {
            let wheels = self.wheel.len();
            return Err(format!("{wheels} [[wheel]], and the image has room for {room}").into());
        }
        for (i, wheel) in self.wheel.iter().enumerate() {
            let axis = Vec3::from(wheel.axis.map(|x| x as f32));
            WheelArray::new([axis], [wheel.spin_inertia_kg_m2 as f32])
                .map_err(|why| format!("[[wheel]] {} of {}: {why}", i + 1, self.wheel.len()))?;
        }
        window::Config::new(self.gyro.noise_rad_s as f32)
            .validate::<9>()
            .map_err(|why| format!("[gyro]: {why}"))?;
        let narrow = |values: [f64; 6]| values.map(|x| x as f32);
        let prior = self.prior.as_ref().map(|prior| fsw_core::Prior {
            inertia_kg_m2: narrow(prior.inertia_kg_m2),
            sigma_kg_m2: narrow(prior.sigma_kg_m2),
        });
        prior.map_or(Ok(()), |prior| prior.validate()).map_err(|why| format!("[prior]: {why}"))?;
        Ok(())
    }

    /// The Rust source of `CRAFT`, a constant with room for so many wheels. What the file doesn't
    /// have is a wheel about z without spin inertia; what estimators don't take is refused.
    pub fn to_source(&self, room: usize) -> Result<String, Box<dyn Error>> {
        self.check(room)?;
        let missing = room - self.wheel.len();
        let axes: Vec<_> = self.wheel.iter().map(|wheel| floats(&wheel.axis)).collect();
        let axes = [axes, vec![floats(&[0.0, 0.0, 1.0]); missing]].concat();
        let spin_inertias: Vec<_> =
            self.wheel.iter().map(|wheel| wheel.spin_inertia_kg_m2).collect();
        let spin_inertias = [spin_inertias, vec![0.0; missing]].concat();

        let mut source = String::new();
        writeln!(source, "/// The spacecraft.\npub const CRAFT: Craft<{room}> = Craft {{")?;
        writeln!(source, "    wheel_axes: [{}],", axes.join(", "))?;
        writeln!(source, "    spin_inertia_kg_m2: {},", floats(&spin_inertias))?;
        writeln!(source, "    gyro_noise_rad_s: {},", float(self.gyro.noise_rad_s))?;
        match &self.prior {
            None => writeln!(source, "    prior: None,")?,
            Some(prior) => {
                let inertia = floats(&prior.inertia_kg_m2);
                let sigma = floats(&prior.sigma_kg_m2);
                writeln!(source, "    prior: Some(Prior {{")?;
                writeln!(source, "        inertia_kg_m2: {inertia},")?;
                writeln!(source, "        sigma_kg_m2: {sigma},")?;
                writeln!(source, "    }}),")?;
            }
        }
        writeln!(source, "}};")?;
        Ok(source)
    }
}

/// Numbers as an array of exact bits.
pub fn floats(values: &[f64]) -> String {
    let elements: Vec<_> = values.iter().map(|&value| float(value)).collect();
    format!("[{}]", elements.join(", "))
}

fn float(value: f64) -> String {
    format!("f32::from_bits({:#010x})", (value as f32).to_bits())
}
