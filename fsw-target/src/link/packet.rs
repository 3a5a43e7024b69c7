//! CCSDS space packets with a checksum.
//!
//! Input and output: a [`Header`] with user data, and the bytes of the packet.
//!
//! | bytes | content | source |
//! |---|---|---|
//! | 0 to 5 | primary header | CCSDS 133.0-B-2, 4.1.3 |
//! | 6 to 14 | telemetry: on-board time of the packet, µs, u64; key slot of the tag plus one, u8 | secondary header, 4.1.4.2 |
//! | 6 to 10 | telecommand with a tag: key slot, u8; counter, u32 | secondary header, 4.1.4.2 |
//! | … | user data | `link.md` |
//! | 16, if tagged | tag of all bytes before it | [`super::authentication`] |
//! | last 2 | checksum of all bytes before it | ECSS-E-ST-70-41C, annex B |
//!
//! Packets are unsegmented. The crate `spacepackets` writes and reads the primary header. Its packet
//! builders and readers are not used: they slice by lengths unknown to the compiler, which would
//! leave panicking code in the image.

use super::authentication::{Key, TAG_BYTES, Tag};
use super::frame::MAX_PACKET;
use super::wire::{Reader, Wire, Writer};
use arbitrary_int::{u3, u11, u14};
use core::fmt;
use crc::{CRC_16_IBM_3740, Crc, NoTable};
use spacepackets::{PacketId, PacketSequenceControl, SequenceFlags, SpacePacketHeader};

pub use arbitrary_int::{u11 as Apid, u14 as SequenceCount};
pub use spacepackets::PacketType;

/// APID of telecommands.
pub const COMMAND: Apid = u11::new(0x1f0);
/// APID of [`EstimateReport`](super::telemetry::EstimateReport).
pub const ESTIMATE: Apid = u11::new(0x1f1);
/// APID of [`StatusReport`](super::telemetry::StatusReport).
pub const STATUS: Apid = u11::new(0x1f2);
/// APID of [`CheckpointPart`](super::telemetry::CheckpointPart).
pub const CHECKPOINT: Apid = u11::new(0x1f3);
/// APID of [`ManoeuvreReport`](super::telemetry::ManoeuvreReport).
pub const MANOEUVRE: Apid = u11::new(0x1f4);

/// CRC-16, polynomial 0x1021, initial value 0xffff, not reflected. Bit by bit: a table would take 512
/// bytes of flash, and a packet of 200 bytes about 8,000 instructions less, 0.05 ms.
static CHECKSUM: Crc<u16, NoTable> = Crc::<u16, NoTable>::new(&CRC_16_IBM_3740);

/// Length of the checksum, bytes.
const CHECKSUM_BYTES: usize = 2;

/// Header fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Application process identifier: the kind of packet.
    pub apid: Apid,
    /// Sequence count of the APID, modulo 2¹⁴.
    pub sequence_count: SequenceCount,
    /// Secondary header.
    pub secondary: Secondary,
}

/// Secondary header: type of the packet, and whether it ends with a tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Secondary {
    /// Telecommand without a tag.
    Plain,
    /// Telecommand with a tag.
    Tagged {
        /// Key slot of the tag.
        slot: u8,
        /// Counter of the slot.
        counter: u32,
    },
    /// Telemetry.
    Telemetry {
        /// On-board time of the packet, µs.
        time_us: u64,
        /// Key slot of the tag; `None` for a packet without a tag.
        slot: Option<u8>,
    },
}

impl Secondary {
    fn packet_type(&self) -> PacketType {
        match self {
            Self::Plain | Self::Tagged { .. } => PacketType::Tc,
            Self::Telemetry { .. } => PacketType::Tm,
        }
    }

    /// True if the packet ends with a tag.
    fn is_tagged(&self) -> bool {
        !matches!(self, Self::Plain | Self::Telemetry { slot: None, .. })
    }

    fn put(&self, out: &mut Writer<'_>) {
        match self {
            Self::Plain => {}
            Self::Tagged { slot, counter } => {
                slot.put(out);
                counter.put(out);
            }
            Self::Telemetry { time_us, slot } => {
                time_us.put(out);
                slot.map_or(0, |slot| slot.saturating_add(1)).put(out);
            }
        }
    }

    fn take(id: PacketId, from: &mut Reader<'_>) -> Result<Self, PacketError> {
        let missing = |_| PacketError::Unsupported;
        Ok(match (id.packet_type, id.sec_header_flag) {
            (PacketType::Tc, false) => Self::Plain,
            (PacketType::Tc, true) => Self::Tagged {
                slot: Wire::take(from).map_err(missing)?,
                counter: Wire::take(from).map_err(missing)?,
            },
            (PacketType::Tm, true) => Self::Telemetry {
                time_us: Wire::take(from).map_err(missing)?,
                slot: u8::take(from).map_err(missing)?.checked_sub(1),
            },
            (PacketType::Tm, false) => return Err(PacketError::Unsupported),
        })
    }
}

impl Header {
    fn primary(&self, packet_bytes: usize) -> Option<SpacePacketHeader> {
        // The length field holds the number of bytes after the primary header, minus one.
        let after = packet_bytes.checked_sub(SpacePacketHeader::LENGTH)?.checked_sub(1)?;
        let has_secondary = self.secondary != Secondary::Plain;
        Some(SpacePacketHeader::new(
            PacketId::new(self.secondary.packet_type(), has_secondary, self.apid),
            PacketSequenceControl::new(SequenceFlags::Unsegmented, self.sequence_count),
            u16::try_from(after).ok()?,
        ))
    }
}

/// A packet of at most [`MAX_PACKET`] bytes.
#[derive(Clone, Copy, Debug)]
pub struct Packet {
    bytes: [u8; MAX_PACKET],
    length: usize,
}

impl Packet {
    /// A packet with the user data that `body` writes, tagged with `key` if its header requires a tag.
    /// `None` above [`MAX_PACKET`] bytes, or without the required key.
    #[inline(never)] // one copy for every report
    pub fn new(header: &Header, key: Option<&Key>, body: &dyn Fn(&mut Writer<'_>)) -> Option<Self> {
        let mut bytes = [0; MAX_PACKET];
        let (primary_header, after) =
            bytes.split_first_chunk_mut::<{ SpacePacketHeader::LENGTH }>()?;
        let mut writer = Writer::new(after);
        header.secondary.put(&mut writer);
        body(&mut writer);
        let tag_at = SpacePacketHeader::LENGTH + writer.finish()?;
        let tag_bytes = if header.secondary.is_tagged() { TAG_BYTES } else { 0 };
        let checksum_at = tag_at + tag_bytes;
        let length = checksum_at + CHECKSUM_BYTES;
        header.primary(length)?.write_to_slice(primary_header).ok()?;
        if tag_bytes > 0 {
            let tag = key?.tag(bytes.get(..tag_at)?);
            Writer::new(bytes.get_mut(tag_at..checksum_at)?).put(&tag);
        }
        let checksum = CHECKSUM.checksum(bytes.get(..checksum_at)?);
        Writer::new(bytes.get_mut(checksum_at..length)?).put(&checksum.to_be_bytes());
        Some(Self { bytes, length })
    }

    /// The whole packet, from the primary header to the checksum.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

/// Reason for bytes that are not a packet of this link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PacketError {
    /// Shorter than the length field.
    Truncated,
    /// Longer than the length field.
    TooLong,
    /// Wrong checksum.
    WrongChecksum,
    /// Another version of the standard, a segment, or without its secondary header or tag.
    Unsupported,
}

impl fmt::Display for PacketError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Truncated => "packet shorter than its length field",
            Self::TooLong => "packet longer than its length field",
            Self::WrongChecksum => "packet with a wrong checksum",
            Self::Unsupported => {
                "packet of another version, segmented, or without its secondary header or tag"
            }
        })
    }
}

impl core::error::Error for PacketError {}

/// An intact packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parsed<'a> {
    /// Header.
    pub header: Header,
    /// User data.
    pub data: &'a [u8],
    /// All bytes before the tag, and the tag; `None` for a packet without a tag.
    tagged: Option<(&'a [u8], &'a Tag)>,
}

impl Parsed<'_> {
    /// True if the packet has a tag, and it is that of `key`.
    pub fn is_authentic(&self, key: &Key) -> bool {
        self.tagged.is_some_and(|(bytes, tag)| key.verifies(bytes, tag))
    }
}

/// Header and user data of an intact packet. A tag is not verified.
///
/// # Errors
/// See [`PacketError`]; the first that applies.
pub fn parse(bytes: &[u8]) -> Result<Parsed<'_>, PacketError> {
    let (before, checksum) = split_end(bytes).ok_or(PacketError::Truncated)?;
    let (primary, after) = before
        .split_first_chunk::<{ SpacePacketHeader::LENGTH }>()
        .ok_or(PacketError::Truncated)?;
    let (primary, _) =
        SpacePacketHeader::from_be_bytes(primary).map_err(|_| PacketError::Truncated)?;
    match bytes.len().cmp(&primary.packet_len()) {
        core::cmp::Ordering::Less => return Err(PacketError::Truncated),
        core::cmp::Ordering::Greater => return Err(PacketError::TooLong),
        core::cmp::Ordering::Equal => {}
    }
    if CHECKSUM.checksum(before) != u16::from_be_bytes(*checksum) {
        return Err(PacketError::WrongChecksum);
    }
    let SpacePacketHeader { version, packet_id, psc, .. } = primary;
    if version != u3::new(0) || psc.seq_flags != SequenceFlags::Unsegmented {
        return Err(PacketError::Unsupported);
    }
    let mut reader = Reader::new(after);
    let secondary = Secondary::take(packet_id, &mut reader)?;
    let header = Header { apid: packet_id.apid, sequence_count: psc.seq_count, secondary };
    let data = reader.rest();
    if !secondary.is_tagged() {
        return Ok(Parsed { header, data, tagged: None });
    }
    let (data, _) = split_end::<TAG_BYTES>(data).ok_or(PacketError::Unsupported)?;
    let tagged = split_end::<TAG_BYTES>(before);
    Ok(Parsed { header, data, tagged })
}

/// The last N bytes apart. Compiled for size, `split_last_chunk` keeps the panic of `split_at`.
pub(crate) fn split_end<const N: usize>(bytes: &[u8]) -> Option<(&[u8], &[u8; N])> {
    let (before, end) = bytes.split_at_checked(bytes.len().checked_sub(N)?)?;
    Some((before, end.try_into().ok()?))
}

/// True if `count` is new: 1 to 8191 ahead of `last`, modulo 2¹⁴. The other half of all counts, `last`
/// included, is old.
pub fn is_ahead(count: SequenceCount, last: SequenceCount) -> bool {
    let ahead = count.wrapping_sub(last).value();
    (1..1 << 13).contains(&ahead)
}

/// The following count, modulo 2¹⁴.
pub fn next(count: SequenceCount) -> SequenceCount {
    count.wrapping_add(u14::new(1))
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    const TELECOMMAND: Header =
        Header { apid: COMMAND, sequence_count: u14::new(0x0123), secondary: Secondary::Plain };

    const KEY: Key = Key::new([7; 16]);

    fn bytes(header: &Header, data: &[u8]) -> Vec<u8> {
        Packet::new(header, Some(&KEY), &|out| out.put(data)).unwrap().bytes().to_vec()
    }

    /// Header and user data of an intact packet.
    fn parsed(bytes: &[u8]) -> (Header, &[u8]) {
        let parsed = parse(bytes).unwrap();
        (parsed.header, parsed.data)
    }

    #[test]
    fn checksum_has_its_published_check_value() {
        assert_eq!(CHECKSUM.checksum(b"123456789"), 0x29b1);
    }

    #[test]
    fn checksum_matches_the_examples_of_the_standard() {
        // ECSS-E-ST-70-41C, annex B.1.5: data and checksum.
        for (data, checksum) in [
            (&[0x00, 0x00][..], 0x1d0f),
            (&[0x00, 0x00, 0x00], 0xcc9c),
            (&[0xab, 0xcd, 0xef, 0x01], 0x04a2),
            (&[0x14, 0x56, 0xf8, 0x9a, 0x00, 0x01], 0x7fd5),
        ] {
            assert_eq!(CHECKSUM.checksum(data), checksum);
        }
    }

    #[test]
    fn telecommand_has_the_layout_of_the_standard() {
        // Version 000, type 1, no secondary header, APID 001 1111 0000; unsegmented 11, count 0x0123;
        // length field 3: two bytes of data and two of checksum, minus one.
        let made = [0b0001_0001, 0b1111_0000, 0b1100_0001, 0x23, 0x00, 0x03, 0xca, 0xfe];
        let sent = bytes(&TELECOMMAND, &[0xca, 0xfe]);
        assert_eq!(sent[..8], made);
        assert_eq!(sent[8..], bit_by_bit(&made).to_be_bytes());
        assert_eq!(parsed(&sent), (TELECOMMAND, &[0xca, 0xfe][..]));
    }

    #[test]
    fn telemetry_has_the_layout_of_the_standard() {
        let header = Header {
            apid: STATUS,
            sequence_count: u14::new(0x3fff),
            secondary: Secondary::Telemetry { time_us: 0x0102_0304_0506_0708, slot: None },
        };
        let sent = bytes(&header, &[0xca]);
        let primary = [0b0000_1001, 0b1111_0010, 0b1111_1111, 0xff, 0x00, 0x0b];
        assert_eq!(sent[..6], primary);
        assert_eq!(sent[6..16], [1, 2, 3, 4, 5, 6, 7, 8, 0, 0xca]);
        assert_eq!(sent[16..], bit_by_bit(&sent[..16]).to_be_bytes());
        assert_eq!(parsed(&sent), (header, &[0xca][..]));
        assert!(!parse(&sent).unwrap().is_authentic(&KEY), "no tag");
    }

    #[test]
    fn tag_covers_all_bytes_before_it() {
        let telecommand = Secondary::Tagged { slot: 2, counter: 0x0102_0304 };
        let telemetry = Secondary::Telemetry { time_us: 5, slot: Some(2) };
        for (secondary, start) in [(telecommand, 11), (telemetry, 15)] {
            let header = Header { secondary, ..TELECOMMAND };
            let sent = bytes(&header, &[0xca, 0xfe]);
            assert_eq!(sent.len(), start + 2 + TAG_BYTES + 2);
            assert_eq!(sent[start + 2..start + 18], KEY.tag(&sent[..start + 2]));
            assert_eq!(parsed(&sent), (header, &[0xca, 0xfe][..]));
            assert!(parse(&sent).unwrap().is_authentic(&KEY));
            assert!(!parse(&sent).unwrap().is_authentic(&Key::new([8; 16])));
            assert!(Packet::new(&header, None, &|_| ()).is_none(), "no key");
        }
    }

    /// Checksum by the shift register of the standard.
    fn bit_by_bit(data: &[u8]) -> u16 {
        let mut register = 0xffff_u16;
        for bit in data.iter().flat_map(|byte| (0..8).rev().map(move |shift| byte >> shift & 1)) {
            let feedback = u16::from(bit) ^ register >> 15;
            register = (register << 1) ^ (feedback * 0x1021);
        }
        register
    }

    #[test]
    fn only_an_unsegmented_packet_of_version_0_is_accepted() {
        let good = bytes(&TELECOMMAND, &[1, 2, 3]);
        for length in 0..good.len() {
            assert_eq!(parse(&good[..length]), Err(PacketError::Truncated), "{length} bytes");
        }
        let longer = [&good[..], &[0]].concat();
        assert_eq!(parse(&longer), Err(PacketError::TooLong));
        let sealed = |mut packet: Vec<u8>| {
            let end = packet.len() - 2;
            let checksum = bit_by_bit(&packet[..end]).to_be_bytes();
            packet[end..].copy_from_slice(&checksum);
            packet
        };
        let change = |at: usize, bits: u8| {
            let mut packet = good.clone();
            packet[at] ^= bits;
            sealed(packet)
        };
        let version_1 = change(0, 0b0010_0000);
        let first_segment = change(2, 0b1000_0000);
        let tagged_in_three_bytes = change(0, 0b0000_1000);
        let telemetry_without_time = change(0, 0b0001_0000);
        for packet in [version_1, first_segment, tagged_in_three_bytes, telemetry_without_time] {
            assert_eq!(parse(&packet), Err(PacketError::Unsupported));
        }
    }

    /// Every single bit, every pair of bits and every burst of up to 16 bits of a telecommand: the checksum detects them.
    #[test]
    fn every_pair_and_burst_of_wrong_bits_is_detected() {
        let good = bytes(&TELECOMMAND, &[11, 0x3a, 0x83, 0x12, 0x6f, 0xbb, 0x03, 0x12, 0x6f]);
        let bits = 8 * good.len();
        let rejected = |wrong: &[usize]| {
            let mut packet = good.clone();
            for bit in wrong {
                packet[bit / 8] ^= 0x80 >> (bit % 8);
            }
            assert!(parse(&packet).is_err(), "bits {wrong:?}");
        };
        for first in 0..bits {
            rejected(&[first]);
            for second in first + 1..bits {
                rejected(&[first, second]);
            }
        }
        for burst in 1..=u16::MAX {
            let pattern: Vec<usize> = (0..16).filter(|bit| burst >> bit & 1 == 1).collect();
            for first in (0..bits - 15).step_by(5) {
                rejected(&pattern.iter().map(|bit| first + bit).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn half_of_all_counts_is_ahead() {
        let ahead = |count, last| is_ahead(u14::new(count), u14::new(last));
        for last in [0, 1, 8191, 8192, 16_383] {
            for (step, expected) in
                [(0, false), (1, true), (8191, true), (8192, false), (16_383, false)]
            {
                assert_eq!(ahead((last + step) % 16_384, last), expected, "{last} + {step}");
            }
        }
        assert_eq!(next(u14::new(16_383)), u14::new(0));
    }

    proptest! {
        #[test]
        fn any_bytes_are_parsed_without_a_panic(
            noise in prop::collection::vec(any::<u8>(), 0..=MAX_PACKET),
        ) {
            let _ = parse(&noise);
        }

        #[test]
        fn every_corrupted_byte_is_detected(
            data in prop::collection::vec(any::<u8>(), 0..200),
            at in any::<prop::sample::Index>(),
            bits in 1_u8..,
        ) {
            let mut packet = bytes(&TELECOMMAND, &data);
            let at = at.index(packet.len());
            packet[at] ^= bits;
            prop_assert!(parse(&packet).is_err());
        }
    }
}
