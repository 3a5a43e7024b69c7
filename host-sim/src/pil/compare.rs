//! Comparison of the telemetry of firmware and host, element by element, bit by bit.

use fsw_target::link::telemetry::Received;
use fsw_target::link::wire::{About, Shape, Value, Visitor};
use thiserror::Error;

/// The first difference between firmware and host.
#[derive(Clone, Debug, Error, PartialEq)]
#[error(
    "{when}: {element} is {firmware} on the target and {host} on the host; all earlier telemetry is \
     identical"
)]
pub struct Difference {
    /// Sample before the difference.
    pub when: After,
    /// Name of the element, as `estimate inertia_kg_m2[3]`.
    pub element: String,
    /// Value of the firmware.
    pub firmware: String,
    /// Value of the host.
    pub host: String,
}

impl Difference {
    /// A packet that only the firmware has sent.
    pub fn unexpected(when: After, received: &Received) -> Self {
        let firmware = format!("an additional packet of {}", received.telemetry.kind());
        Self { when, element: "the packet".to_owned(), firmware, host: "missing".to_owned() }
    }
}

/// Last event before a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum After {
    /// Start of the flight computers.
    Start,
    /// The sample of this index.
    Sample(usize),
}

impl std::fmt::Display for After {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Start => f.write_str("before the first sample"),
            Self::Sample(sample) => write!(f, "sample {sample}"),
        }
    }
}

/// Elements that only the target has, and are not compared.
const TARGET_ONLY: [&str; 1] = ["stack_high_water_bytes"];

/// Compares two packets bit by bit.
///
/// # Errors
/// The first element that differs.
pub fn packets(when: After, host: &Received, firmware: &Received) -> Result<(), Box<Difference>> {
    let differs = |element, firmware, host| Box::new(Difference { when, element, firmware, host });
    let (kind, other) = (firmware.telemetry.kind(), host.telemetry.kind());
    if kind != other {
        let packet = |kind: &str| format!("of {kind}");
        return Err(differs("the packet".to_owned(), packet(kind), packet(other)));
    }
    let host = elements(host);
    for (index, (element, firmware)) in elements(firmware).into_iter().enumerate() {
        let host = host.get(index).and_then(|(_, value)| *value);
        let is_compared = !TARGET_ONLY.contains(&element.as_str());
        if is_compared && firmware.map(bits) != host.map(bits) {
            return Err(differs(format!("{kind} {element}"), text(firmware), text(host)));
        }
    }
    Ok(())
}

type Element = (String, Option<Value>);

/// Every element of a packet with its name. An element of a field without a value has none.
fn elements(received: &Received) -> Vec<Element> {
    struct Collect(Vec<Element>);
    impl Visitor for Collect {
        fn open(&mut self, _: &About) {}
        fn close(&mut self) {}
        fn field(&mut self, about: &About, shape: Shape, values: Option<&[Value]>) {
            for index in 0..shape.count {
                let name = match shape.count {
                    1 => about.name.to_owned(),
                    _ => format!("{}[{index}]", about.name),
                };
                self.0.push((name, values.and_then(|values| values.get(index).copied())));
            }
        }
    }
    let count = u64::from(received.sequence_count.value());
    let mut all = Collect(vec![
        ("time_us".to_owned(), Some(Value::Whole(received.time_us))),
        ("sequence_count".to_owned(), Some(Value::Whole(count))),
        ("tag_slot".to_owned(), received.slot.map(|slot| Value::Whole(slot.into()))),
    ]);
    received.telemetry.visit(&mut all);
    all.0
}

/// Bits of a value. With them a NaN equals itself, and −0 differs from 0.
fn bits(value: Value) -> (u64, &'static str) {
    match value {
        Value::Whole(number) => (number, ""),
        Value::Number(number) => (u64::from(number.to_bits()), ""),
        Value::Flag(flag) => (u64::from(flag), ""),
        Value::Word(word) => (0, word),
    }
}

/// Text of a value.
fn text(value: Option<Value>) -> String {
    match value {
        None => "missing".to_owned(),
        Some(Value::Whole(number)) => number.to_string(),
        Some(Value::Number(number)) => format!("{number:e} ({:#010x})", number.to_bits()),
        Some(Value::Flag(flag)) => flag.to_string(),
        Some(Value::Word(word)) => word.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fsw_core::estimator::window::{Config, Window};
    use fsw_core::monitor::health::HealthMonitor;
    use fsw_core::{Outcome, WheelArray};
    use fsw_target::flight::selected::EstimatorId;
    use fsw_target::link::packet::SequenceCount;
    use fsw_target::link::telemetry::{EstimateReport, Telemetry};

    const WHEN: After = After::Sample(3);

    fn estimate() -> EstimateReport {
        let wheels = WheelArray::new([], []).unwrap();
        let window = Window::<f32, 0, 64, 9>::new(Config::new(1e-4), wheels).unwrap();
        let (id, outcome) = (EstimatorId::Window, Some(Outcome::Updated));
        EstimateReport::of(id, &window, 0, outcome, &mut HealthMonitor::default(), [true; 4])
    }

    fn packet(estimate: EstimateReport) -> Received {
        let telemetry = Telemetry::Estimate(estimate);
        Received { time_us: 5, sequence_count: SequenceCount::new(7), slot: None, telemetry }
    }

    #[test]
    fn equal_packets_have_no_difference() {
        assert_eq!(packets(WHEN, &packet(estimate()), &packet(estimate())), Ok(()));
    }

    #[test]
    fn single_bit_is_detected_and_named() {
        let mut other = estimate();
        let sigma = &mut other.sigma_kg_m2[4];
        *sigma = f32::from_bits(sigma.to_bits() ^ 1);
        let difference = packets(WHEN, &packet(estimate()), &packet(other)).unwrap_err();
        assert_eq!(difference.element, "estimate sigma_kg_m2[4]");
        assert!(difference.to_string().starts_with("sample 3: estimate sigma_kg_m2[4] is "));
    }

    #[test]
    fn missing_value_is_a_difference() {
        let mut other = estimate();
        other.gyro_bias_rad_s = Some([0.0; 3]);
        let difference = packets(WHEN, &packet(estimate()), &packet(other)).unwrap_err();
        assert_eq!(difference.element, "estimate gyro_bias_rad_s[0]");
        assert_eq!(difference.host, "missing");
    }

    #[test]
    fn missing_packet_is_a_difference() {
        let later = Received { sequence_count: SequenceCount::new(8), ..packet(estimate()) };
        let difference = packets(WHEN, &packet(estimate()), &later).unwrap_err();
        assert_eq!(difference.element, "estimate sequence_count");
    }

    #[test]
    fn zero_and_minus_zero_differ_and_nan_equals_itself() {
        let mut host = estimate();
        host.rate_rad_s = [f32::NAN, 0.0, 0.0];
        assert_eq!(packets(WHEN, &packet(host), &packet(host)), Ok(()));
        let mut other = host;
        other.rate_rad_s[2] = -0.0;
        let difference = packets(WHEN, &packet(host), &packet(other)).unwrap_err();
        assert_eq!(difference.element, "estimate rate_rad_s[2]");
    }
}
