//! One half of the flash: a mark, then records one after the other.

use super::Error;
use super::record::{self, CHUNK, Record};
use embedded_storage::nor_flash::NorFlash;

/// A half and its end of writing.
#[derive(Debug, Clone, Copy)]
pub struct Half {
    /// First offset.
    pub start: u32,
    /// Offset after the last byte.
    pub end: u32,
    /// Offset after the last written chunk; `None` if the half must be erased first.
    pub used: Option<u32>,
}

impl Half {
    /// True if the record lies in this half.
    pub fn contains(&self, record: &Record) -> bool {
        (self.start..self.end).contains(&record.at)
    }

    /// Calls `found` with every record, intact or not, and returns the offset after the last written
    /// chunk.
    ///
    /// Every chunk is read, those of a record too. A head whose write was interrupted may read as complete
    /// once records follow it: it hides none of them.
    #[inline(never)]
    pub fn scan<F: NorFlash>(
        &self,
        flash: &mut F,
        found: &mut dyn FnMut(Record),
    ) -> Result<u32, Error<F::Error>> {
        let mut at = self.start.saturating_add(CHUNK);
        let mut used = at;
        while at < self.end {
            let chunk = record::read(flash, at)?;
            let record = Record::of_head(at, &chunk).filter(|record| record.end() <= self.end);
            at = at.saturating_add(CHUNK);
            if let Some(record) = record {
                found(record);
                used = used.max(record.end());
            } else if !record::is_erased(&chunk) {
                used = used.max(at);
            }
        }
        Ok(used)
    }
}

/// Replaces `newest` by a newer record.
pub fn keep_newest(newest: &mut Option<Record>, record: Record) {
    if newest.is_none_or(|newest| record.order() > newest.order()) {
        *newest = Some(record);
    }
}
