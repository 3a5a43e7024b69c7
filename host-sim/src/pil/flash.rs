//! Model of a NOR flash: writing clears bits, erasing sets the bits of whole pages.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use fsw_target::stand_in::tunnel::{FLASH_BYTES, PAGE_BYTES};

/// Content of the flash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlashModel {
    bytes: Vec<u8>,
}

/// An address outside the flash, or an erasure of part of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutOfBounds;

impl Default for FlashModel {
    /// Erased.
    fn default() -> Self {
        Self { bytes: vec![0xFF; FLASH_BYTES as usize] }
    }
}

impl FlashModel {
    /// All bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Bytes from an address on.
    fn range(&mut self, from: u32, length: usize) -> Result<&mut [u8], OutOfBounds> {
        let from = from as usize;
        let to = from.checked_add(length).ok_or(OutOfBounds)?;
        self.bytes.get_mut(from..to).ok_or(OutOfBounds)
    }
}

impl NorFlashError for OutOfBounds {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::OutOfBounds
    }
}

impl ErrorType for FlashModel {
    type Error = OutOfBounds;
}

impl ReadNorFlash for FlashModel {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), OutOfBounds> {
        let from = self.range(offset, bytes.len())?;
        bytes.copy_from_slice(from);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for FlashModel {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = PAGE_BYTES as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), OutOfBounds> {
        let is_whole = from.is_multiple_of(PAGE_BYTES) && to.is_multiple_of(PAGE_BYTES);
        let length = to.checked_sub(from).filter(|_| is_whole).ok_or(OutOfBounds)?;
        self.range(from, length as usize)?.fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), OutOfBounds> {
        for (cell, byte) in self.range(offset, bytes.len())?.iter_mut().zip(bytes) {
            *cell &= byte;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn writing_clears_bits_and_erasing_sets_them() {
        let mut flash = FlashModel::default();
        flash.write(4096, &[0xF0, 0x0F, 0, 0xFF]).unwrap();
        flash.write(4096, &[0x3C; 4]).unwrap();
        let mut read = [0; 5];
        flash.read(4096, &mut read).unwrap();
        assert_eq!(read, [0x30, 0x0C, 0, 0x3C, 0xFF]);
        flash.erase(4096, 8192).unwrap();
        assert_eq!(flash, FlashModel::default());
    }

    #[test]
    fn access_out_of_bounds_is_rejected() {
        let mut flash = FlashModel::default();
        assert_eq!(flash.read(FLASH_BYTES - 1, &mut [0; 2]), Err(OutOfBounds));
        assert_eq!(flash.write(u32::MAX, &[0; 2]), Err(OutOfBounds));
        assert_eq!(flash.erase(1, 4097), Err(OutOfBounds));
        assert_eq!(flash.erase(4096, 0), Err(OutOfBounds));
    }
}
