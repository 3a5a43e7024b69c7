//! Telemetry: reports as packets.
//!
//! Input: reports of the flight computer, plain structs in SI units. Output: packets; on the ground, the same
//! structs from packets, bit for bit. The tables of `link.md` are generated from these types.

/// [`Report`] for a record.
macro_rules! report {
    ($name:ident, $apid:expr) => {
        impl $crate::link::telemetry::Report for $name {
            const APID: $crate::link::packet::Apid = $apid;

            fn put(&self, out: &mut $crate::link::wire::Writer<'_>) {
                $crate::link::wire::Wire::put(self, out);
            }

            fn decode(data: &[u8]) -> Result<Self, $crate::link::wire::Unreadable> {
                let mut from = $crate::link::wire::Reader::new(data);
                let report = $crate::link::wire::Wire::take(&mut from)?;
                from.end()?;
                Ok(report)
            }
        }
    };
}
mod checkpoint;
mod estimate;
#[cfg(test)]
pub mod fixtures;
mod manoeuvre;
mod status;

pub use checkpoint::{CheckpointPart, PART_BYTES};
pub use estimate::{EstimateReport, HardwareError};
pub use manoeuvre::{ManoeuvreReport, TableFault};
pub use status::{
    BrownOutLevel, CheckpointState, ClockSource, GyroState, LINK_VERSION, ResetCause, StatusReport,
};

use super::authentication::{Key, TAG_BYTES};
use super::frame::MAX_PACKET;
use super::packet::{self, Apid, Header, Packet, PacketError, Secondary, SequenceCount};
use super::wire::{About, Unreadable, Visitor, Wire, Writer};
use core::fmt;

/// A report with a packet of its own.
pub trait Report: Sized {
    /// APID of its packets.
    const APID: Apid;
    /// Writes the user data.
    fn put(&self, out: &mut Writer<'_>);
    /// Reads the whole user data.
    ///
    /// # Errors
    /// See [`Unreadable`].
    fn decode(data: &[u8]) -> Result<Self, Unreadable>;

    /// Packet made at `time_us`, with a tag if `key` is a slot with its key. Always `Some`: every report
    /// is shorter than a packet.
    fn packet(
        &self,
        time_us: u64,
        sequence_count: SequenceCount,
        key: Option<&(u8, Key)>,
    ) -> Option<Packet> {
        let secondary = Secondary::Telemetry { time_us, slot: key.map(|(slot, _)| *slot) };
        let header = Header { apid: Self::APID, sequence_count, secondary };
        Packet::new(&header, key.map(|(_, key)| key), &|out| self.put(out))
    }
}

/// A telemetry packet.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "no heap, and few values at a time")]
pub enum Telemetry {
    /// Estimate of the selected estimator.
    Estimate(EstimateReport),
    /// State of the flight computer.
    Status(StatusReport),
    /// Part of a checkpoint.
    Checkpoint(CheckpointPart),
    /// State of upload and manoeuvre.
    Manoeuvre(ManoeuvreReport),
}

/// A received telemetry packet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Received {
    /// On-board time of the packet, µs.
    pub time_us: u64,
    /// Sequence count of its APID, modulo 2¹⁴, packets dropped by the flight computer included.
    pub sequence_count: SequenceCount,
    /// Key slot of its tag; `None` for a packet without a tag. Verified by a
    /// [`Receiver`](super::Receiver) with a key only.
    pub slot: Option<u8>,
    /// Content.
    pub telemetry: Telemetry,
}

/// Reason for bytes that are not a telemetry packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TelemetryError {
    /// Not an intact packet.
    Packet(PacketError),
    /// A telecommand, or telemetry of another APID.
    UnknownKind {
        /// True if it is a telecommand.
        command: bool,
        /// APID.
        apid: u16,
    },
    /// User data that differs from the layout of its kind.
    Unreadable {
        /// Kind of the packet.
        kind: &'static str,
        /// Difference from the layout.
        why: Unreadable,
    },
}

impl fmt::Display for TelemetryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Packet(why) => why.fmt(f),
            Self::UnknownKind { command: true, apid } => {
                write!(f, "telecommand (APID {apid:#05x}) instead of telemetry")
            }
            Self::UnknownKind { command: false, apid } => {
                write!(f, "telemetry of unknown APID {apid:#05x}")
            }
            Self::Unreadable { kind, why } => write!(f, "{kind} packet {why}"),
        }
    }
}

impl core::error::Error for TelemetryError {}

impl From<PacketError> for TelemetryError {
    fn from(error: PacketError) -> Self {
        Self::Packet(error)
    }
}

impl Telemetry {
    /// Telemetry from a whole packet. A tag is not verified: [`packet::Parsed::is_authentic`].
    ///
    /// # Errors
    /// See [`TelemetryError`].
    pub fn decode(packet: &[u8]) -> Result<Received, TelemetryError> {
        let parsed = packet::parse(packet)?;
        let (header, data) = (parsed.header, parsed.data);
        let command = !matches!(header.secondary, Secondary::Telemetry { .. });
        let unknown = TelemetryError::UnknownKind { command, apid: header.apid.value() };
        let Secondary::Telemetry { time_us, slot } = header.secondary else { return Err(unknown) };
        let (kind, telemetry) = match header.apid {
            packet::ESTIMATE => ("estimate", EstimateReport::decode(data).map(Self::Estimate)),
            packet::STATUS => ("status", StatusReport::decode(data).map(Self::Status)),
            packet::CHECKPOINT => {
                ("checkpoint", CheckpointPart::decode(data).map(Self::Checkpoint))
            }
            packet::MANOEUVRE => ("manoeuvre", ManoeuvreReport::decode(data).map(Self::Manoeuvre)),
            _ => return Err(unknown),
        };
        let telemetry = telemetry.map_err(|why| TelemetryError::Unreadable { kind, why })?;
        Ok(Received { time_us, sequence_count: header.sequence_count, slot, telemetry })
    }

    /// Kind of the packet, one word.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Estimate(_) => "estimate",
            Self::Status(_) => "status",
            Self::Checkpoint(_) => "checkpoint",
            Self::Manoeuvre(_) => "manoeuvre",
        }
    }

    /// Passes each field to the visitor, in the order of the line. Omits the bytes of a checkpoint.
    pub fn visit(&self, visitor: &mut dyn Visitor) {
        let about = About { name: self.kind(), unit: "–", meaning: "" };
        match self {
            Self::Estimate(report) => report.visit(&about, visitor),
            Self::Status(report) => report.visit(&about, visitor),
            Self::Manoeuvre(report) => report.visit(&about, visitor),
            Self::Checkpoint(part) => {
                visitor.open(&about);
                let of = |name, meaning| About { name, unit: "–", meaning };
                part.index.visit(&of("index", "Index of the part, from 0."), visitor);
                part.parts.visit(&of("parts", "Number of parts."), visitor);
                visitor.close();
            }
        }
    }
}

// Header, time, key slot, tag and checksum of a packet.
const AROUND: usize = 6 + 8 + 1 + TAG_BYTES + 2;
const _: () = assert!(AROUND + <EstimateReport as Wire>::BYTES <= MAX_PACKET);
const _: () = assert!(AROUND + <StatusReport as Wire>::BYTES <= MAX_PACKET);
const _: () = assert!(AROUND + 4 + PART_BYTES <= MAX_PACKET);
const _: () = assert!(AROUND + <ManoeuvreReport as Wire>::BYTES <= MAX_PACKET);

#[cfg(test)]
mod tests {
    extern crate std;
    use super::fixtures::{any_estimate, any_status, estimate, manoeuvre, status};
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    const COUNT: SequenceCount = SequenceCount::new(77);

    fn bytes(report: &impl Report) -> Vec<u8> {
        report.packet(123_456_789, COUNT, None).unwrap().bytes().to_vec()
    }

    /// Packet of this APID and user data with a valid checksum.
    fn sealed(apid: Apid, data: &[u8]) -> Vec<u8> {
        let secondary = Secondary::Telemetry { time_us: 0, slot: None };
        let header = Header { apid, sequence_count: COUNT, secondary };
        Packet::new(&header, None, &|out| out.put(data)).unwrap().bytes().to_vec()
    }

    #[test]
    fn every_kind_arrives_with_its_time_and_count() {
        let part = CheckpointPart::new(3, 7, &[1, 2, 3]).unwrap();
        for (packet, telemetry) in [
            (bytes(&estimate()), Telemetry::Estimate(estimate())),
            (bytes(&status()), Telemetry::Status(status())),
            (bytes(&part), Telemetry::Checkpoint(part)),
            (bytes(&manoeuvre()), Telemetry::Manoeuvre(manoeuvre())),
        ] {
            let received =
                Received { time_us: 123_456_789, sequence_count: COUNT, slot: None, telemetry };
            assert_eq!(Telemetry::decode(&packet), Ok(received));
        }
    }

    #[test]
    fn invalid_report_is_named() {
        let estimate = &bytes(&estimate())[15..];
        let data = &estimate[..estimate.len() - 2];
        let kind = "estimate";
        assert_eq!(
            Telemetry::decode(&sealed(packet::ESTIMATE, &data[..data.len() - 1])),
            Err(TelemetryError::Unreadable { kind, why: Unreadable::TooShort })
        );
        assert_eq!(
            Telemetry::decode(&sealed(packet::ESTIMATE, &[data, &[0, 0]].concat())),
            Err(TelemetryError::Unreadable { kind, why: Unreadable::TooLong(2) })
        );
        let mut unknown = data.to_vec();
        unknown[8] = 200;
        let why = Unreadable::UnknownCode { of: "EstimatorId", code: 200 };
        assert_eq!(
            Telemetry::decode(&sealed(packet::ESTIMATE, &unknown)),
            Err(TelemetryError::Unreadable { kind, why })
        );
        assert_eq!(
            Telemetry::decode(&sealed(Apid::new(9), &[])),
            Err(TelemetryError::UnknownKind { command: false, apid: 9 })
        );
        let command = crate::link::Command::Ping.packet(COUNT).unwrap();
        assert_eq!(
            Telemetry::decode(command.bytes()),
            Err(TelemetryError::UnknownKind { command: true, apid: 0x1f0 })
        );
    }

    proptest! {
        #[test]
        fn estimate_is_bit_exact(report in any_estimate()) {
            let packet = bytes(&report);
            let Ok(Received { telemetry: Telemetry::Estimate(read), .. }) = Telemetry::decode(&packet)
            else {
                return Err(TestCaseError::fail("not an estimate"));
            };
            // NaN differs from itself; its bits do not.
            let bits = |report: &EstimateReport| {
                (report.inertia_kg_m2.map(f32::to_bits), report.nis.map(f32::to_bits))
            };
            prop_assert_eq!(bits(&read), bits(&report));
            prop_assert_eq!(bytes(&read), packet);
        }

        #[test]
        fn status_is_exact(report in any_status()) {
            let read = Telemetry::decode(&bytes(&report)).unwrap().telemetry;
            prop_assert_eq!(read, Telemetry::Status(report));
        }

        #[test]
        fn checkpoint_is_reassembled(state in prop::collection::vec(any::<u8>(), 1..2000)) {
            let parts = state.len().div_ceil(PART_BYTES) as u16;
            let mut together: Vec<u8> = Vec::new();
            for (index, piece) in (0..).zip(state.chunks(PART_BYTES)) {
                let packet = bytes(&CheckpointPart::new(index, parts, piece).unwrap());
                let Telemetry::Checkpoint(part) = Telemetry::decode(&packet).unwrap().telemetry else {
                    return Err(TestCaseError::fail("not a checkpoint"));
                };
                prop_assert_eq!((part.index, part.parts), (index, parts));
                together.extend(part.bytes());
            }
            prop_assert!(CheckpointPart::new(0, 1, &[0; PART_BYTES + 1]).is_none());
            prop_assert_eq!(together, state);
        }

        #[test]
        fn any_user_data_is_read_without_a_panic(
            apid in 0x1f0_u16..0x1f5,
            data in prop::collection::vec(any::<u8>(), 0..230),
        ) {
            let _ = Telemetry::decode(&sealed(Apid::new(apid), &data));
        }
    }
}
