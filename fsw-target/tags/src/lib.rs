//! AES-128-CMAC tags, and keys derived from a master key.
//!
//! Input: a key, and the bytes of a packet. Output: the tag (NIST SP 800-38B, RFC 4493), or the verdict on
//! one; the key of a slot (NIST SP 800-108r1).
//!
//! Cipher and code are the crates `aes` and `cmac` of RustCrypto; `aes` takes the same time for every
//! key and message (bit-sliced, no table).
//!
//! Reason for a separate crate: the optimisation level is set per crate. At the smallest size, the level
//! of `fsw-target`, the compiler leaves a check of bounds in the key schedule, and with it code that panics;
//! at the level of this crate it leaves none.

#![no_std]

use aes::Aes128;
use cmac::{Cmac, KeyInit, Mac};
use core::fmt;

/// Length of a tag, bytes.
pub const TAG_BYTES: usize = 16;

/// Length of a key, bytes.
pub const KEY_BYTES: usize = 16;

/// Label of the key derivation.
const LABEL: &[u8] = b"telecommand slot";

/// Tag of a packet.
pub type Tag = [u8; TAG_BYTES];

/// Key of a slot, or master key.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Key([u8; KEY_BYTES]);

/// The key is not printed.
impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key")
    }
}

impl Key {
    /// A key of 128 random bits.
    pub const fn new(bytes: [u8; KEY_BYTES]) -> Self {
        Self(bytes)
    }

    /// Bytes of the key.
    pub const fn bytes(&self) -> &[u8; KEY_BYTES] {
        &self.0
    }

    /// Key of a slot, with this key as the master key: `CMAC(master, 1 ‖ label ‖ 0 ‖ slot ‖ generation ‖
    /// 128)`, the first and the last number in 32 bits. NIST SP 800-108r1, section 4.1, one iteration.
    #[inline(never)]
    pub fn of_slot(&self, slot: u8, generation: u32) -> Self {
        let mut mac = self.mac();
        mac.update(&1_u32.to_be_bytes());
        mac.update(LABEL);
        mac.update(&[0, slot]);
        mac.update(&generation.to_be_bytes());
        mac.update(&(8 * KEY_BYTES as u32).to_be_bytes());
        Self(mac.finalize().into_bytes().into())
    }

    /// Tag of a packet up to its tag.
    #[inline(never)]
    pub fn tag(&self, bytes: &[u8]) -> Tag {
        let mut mac = self.mac();
        mac.update(bytes);
        mac.finalize().into_bytes().into()
    }

    /// True if `tag` is that of the bytes. Takes the same time for every wrong tag.
    #[inline(never)]
    pub fn verifies(&self, bytes: &[u8], tag: &Tag) -> bool {
        let mut mac = self.mac();
        mac.update(bytes);
        mac.verify(tag.into()).is_ok()
    }

    fn mac(&self) -> Cmac<Aes128> {
        Cmac::<Aes128>::new(&self.0.into())
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    /// RFC 4493, section 4: key, and the first bytes of the message of its examples.
    const KEY: Key = Key::new([
        0x2b, 0x7e, 0x15, 0x16, 0x28, 0xae, 0xd2, 0xa6, 0xab, 0xf7, 0x15, 0x88, 0x09, 0xcf, 0x4f,
        0x3c,
    ]);
    const MESSAGE: [u8; 40] = [
        0x6b, 0xc1, 0xbe, 0xe2, 0x2e, 0x40, 0x9f, 0x96, 0xe9, 0x3d, 0x7e, 0x11, 0x73, 0x93, 0x17,
        0x2a, 0xae, 0x2d, 0x8a, 0x57, 0x1e, 0x03, 0xac, 0x9c, 0x9e, 0xb7, 0x6f, 0xac, 0x45, 0xaf,
        0x8e, 0x51, 0x30, 0xc8, 0x1c, 0x46, 0xa3, 0x5c, 0xe4, 0x11,
    ];

    #[test]
    fn tags_are_those_of_rfc_4493() {
        for (length, tag) in [
            (0, 0xbb1d6929_e9593728_7fa37d12_9b756746_u128),
            (16, 0x070a16b4_6b4d4144_f79bdd9d_d04a287c),
            (40, 0xdfa66747_de9ae630_30ca3261_1497c827),
        ] {
            assert_eq!(KEY.tag(&MESSAGE[..length]), tag.to_be_bytes(), "example of {length} bytes");
            assert!(KEY.verifies(&MESSAGE[..length], &tag.to_be_bytes()));
        }
    }

    #[test]
    fn wrong_bit_of_tag_message_or_key_is_detected() {
        let tag = KEY.tag(&MESSAGE);
        for bit in 0..8 * TAG_BYTES {
            let mut wrong = tag;
            wrong[bit / 8] ^= 1 << (bit % 8);
            assert!(!KEY.verifies(&MESSAGE, &wrong));
            let mut other = *KEY.bytes();
            other[bit / 8] ^= 1 << (bit % 8);
            assert!(!Key::new(other).verifies(&MESSAGE, &tag));
        }
        for bit in 0..8 * MESSAGE.len() {
            let mut wrong = MESSAGE;
            wrong[bit / 8] ^= 1 << (bit % 8);
            assert!(!KEY.verifies(&wrong, &tag));
        }
    }

    #[test]
    fn every_slot_and_generation_has_its_own_key() {
        let mut keys = std::vec::Vec::new();
        for slot in 0..4 {
            for generation in [0, 1, 2, 256, u32::MAX] {
                keys.push(*KEY.of_slot(slot, generation).bytes());
            }
        }
        let count = keys.len();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), count);
    }
}
