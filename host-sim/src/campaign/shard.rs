//! Part of a campaign that one process flies.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use thiserror::Error;

/// Shard `number` of `count`: a contiguous range of the runs. Numbers count from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    number: u64,
    count: u64,
}

/// Reason why a text or a pair of numbers is no shard.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("give I/N with I from 1 to N, as 3/64 for the third of 64")]
pub struct InvalidShard;

impl Shard {
    /// The whole campaign.
    pub const WHOLE: Self = Self { number: 1, count: 1 };

    /// Shard `number` of `count`.
    ///
    /// # Errors
    /// The number is not in 1 to `count`.
    pub fn new(number: u64, count: u64) -> Result<Self, InvalidShard> {
        (1..=count).contains(&number).then_some(Self { number, count }).ok_or(InvalidShard)
    }

    /// Number of the shard, from 1.
    pub fn number(self) -> u64 {
        self.number
    }

    /// Number of shards.
    pub fn count(self) -> u64 {
        self.count
    }

    /// Indices of its runs in a campaign of `runs`: `⌊R (I − 1) / N⌋` up to `⌊R I / N⌋`. The sizes of two shards
    /// differ by one run at most.
    pub fn runs_of(self, runs: u64) -> Range<u64> {
        // A share of a u64 is a u64.
        let edge =
            |shard: u64| (u128::from(runs) * u128::from(shard) / u128::from(self.count)) as u64;
        edge(self.number - 1)..edge(self.number)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}/{}", self.number, self.count)
    }
}

impl FromStr for Shard {
    type Err = InvalidShard;

    fn from_str(text: &str) -> Result<Self, InvalidShard> {
        let (number, count) = text.split_once('/').ok_or(InvalidShard)?;
        let parse = |text: &str| text.parse().map_err(|_| InvalidShard);
        Self::new(parse(number)?, parse(count)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_partition_the_runs_in_their_order() {
        for (runs, count) in [(20, 1), (20, 7), (64, 64), (3, 5), (u64::MAX, 3)] {
            let mut next = 0;
            for number in 1..=count {
                let range = Shard::new(number, count).unwrap().runs_of(runs);
                assert_eq!(range.start, next);
                let size = range.end - range.start;
                assert!((runs / count..=runs / count + 1).contains(&size), "{runs} {number}");
                next = range.end;
            }
            assert_eq!(next, runs);
        }
    }

    #[test]
    fn numbers_count_from_one() {
        assert_eq!("3/64".parse(), Shard::new(3, 64));
        assert_eq!(Shard::new(3, 64).unwrap().to_string(), "3/64");
        for text in ["0/4", "5/4", "1/0", "1", "a/4", "1/4/4", "-1/4", ""] {
            assert_eq!(text.parse::<Shard>(), Err(InvalidShard), "{text}");
        }
    }
}
