//! Arguments of the telecommands: names, types, units, valid ranges. [`Command`](crate::link::Command) has the rest.

extern crate std;
use crate::flight::craft::WHEELS;
use crate::flight::manoeuvre::{SEGMENT, SEGMENTS};
use crate::link::authentication::SLOTS;
use crate::link::command::{
    Function, MAX_PERIOD_MS, MAX_PRIOR_KG_M2, MAX_TORQUE_N_M, MAX_WHEEL_RAD_S, MIN_PERIOD_MS,
    MIN_PRIOR_KG_M2,
};
use crate::link::wire::Field;
use fsw_roster::EstimatorId;
use std::string::{String, ToString};
use std::vec::Vec;
use std::{format, vec};

/// An argument of a telecommand.
#[derive(Clone, Debug, PartialEq)]
pub struct Argument {
    /// Name, unique in its telecommand.
    pub name: String,
    /// Type on the line.
    pub element: &'static str,
    /// Length on the line, bytes.
    pub bytes: usize,
    /// Unit; a dash for none.
    pub unit: &'static str,
    /// Meaning.
    pub meaning: String,
    /// Smallest and largest valid value.
    pub range: Option<(f64, f64)>,
}

fn of<F: Field>(name: &str, unit: &'static str, meaning: &str) -> Argument {
    let (element, bytes) = (F::SHAPE.element, F::SHAPE.bytes);
    let (name, meaning) = (name.to_string(), meaning.to_string());
    Argument { name, element, bytes, unit, meaning, range: None }
}

impl Argument {
    fn within(self, least: impl Into<f64>, most: impl Into<f64>) -> Self {
        Self { range: Some((least.into(), most.into())), ..self }
    }
}

fn prior() -> Vec<Argument> {
    let number = |kind: &str, element: &str, meaning: &str| {
        of::<f32>(&format!("{kind}_{element}_kg_m2"), "kg m²", &format!("{meaning} {element}."))
    };
    let (least, most) = (MIN_PRIOR_KG_M2, MAX_PRIOR_KG_M2);
    let moments = ["jxx", "jyy", "jzz"].map(|element| {
        number("inertia", element, "Inertia tensor, body axes, wheels included:")
            .within(least, most)
    });
    let products = ["jxy", "jxz", "jyz"].map(|element| {
        number("inertia", element, "Inertia tensor, body axes, wheels included:")
            .within(-most, most)
    });
    let sigmas = ["jxx", "jyy", "jzz", "jxy", "jxz", "jyz"]
        .map(|element| number("sigma", element, "Standard deviation of").within(least, most));
    [&moments[..], &products, &sigmas].concat()
}

fn segment() -> Vec<Argument> {
    let index = of::<u8>("segment", "–", "Segment of the table, from 0.");
    let words = (1..=SEGMENT).map(|i| of::<u32>(&format!("word_{i}"), "–", "Word of the segment."));
    [index.within(0, SEGMENTS as u32 - 1)].into_iter().chain(words).collect()
}

/// Arguments of a telecommand, in the order of the line.
pub fn arguments(function: Function) -> Vec<Argument> {
    match function {
        Function::Ping
        | Function::StartSequence
        | Function::Reset
        | Function::OpenWindow
        | Function::CloseWindow
        | Function::SaveCheckpoint
        | Function::DumpCheckpoint
        | Function::Reboot
        | Function::AbortManoeuvre => vec![],
        Function::SetPrior => prior(),
        Function::Select => vec![of::<EstimatorId>("estimator", "–", "Estimator to start.")],
        Function::SetTelemetryPeriod => {
            let period = of::<u32>("period_ms", "ms", "Time between two reports of a kind.");
            vec![period.within(MIN_PERIOD_MS, MAX_PERIOD_MS)]
        }
        Function::SetTorque => ["x", "y", "z"]
            .map(|axis| {
                let meaning = format!("External torque about body axis {axis}.");
                of::<f32>(&format!("torque_{axis}_n_m"), "N m", &meaning)
                    .within(-MAX_TORQUE_N_M, MAX_TORQUE_N_M)
            })
            .to_vec(),
        Function::ChangeKey => {
            let slot = of::<u8>("slot", "–", "Key slot that receives its next key.");
            vec![slot.within(1, SLOTS as u32 - 1)]
        }
        Function::LoadManoeuvre => segment(),
        Function::CommitManoeuvre => {
            vec![of::<u32>(
                "checksum",
                "–",
                "CRC-32 over the words of the table, as of IEEE 802.3.",
            )]
        }
        Function::StartManoeuvre => {
            vec![of::<u64>("at_us", "µs", "On-board time; a past one: at the next sample.")]
        }
        Function::TagTelemetry => vec![of::<bool>("on", "–", "True: telemetry has a tag.")],
        Function::AssumeWheelSpeed => vec![
            of::<u8>("wheel", "–", "Wheel, by its number.").within(1, WHEELS as u32),
            of::<bool>("speed_present", "–", "False: the speed of the wheel's sensor is used."),
            of::<f32>("speed_rad_s", "rad/s", "Assumed speed; zero if it is not present.")
                .within(-MAX_WHEEL_RAD_S, MAX_WHEEL_RAD_S),
        ],
    }
}
