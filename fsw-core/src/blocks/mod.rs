//! Reduction of samples to blocks: averages over a few samples, stored in fixed memory, with the rest between motions.
//!
//! | module | content |
//! |---|---|
//! | [`block`] | averages over the samples of an interval, and their drive |
//! | [`span`] | course of the drive within a block |
//! | [`stretch`] | rest before the first block, and the size of the drive |
//! | [`storage`] | blocks in fixed storage, and their compaction |
//! | [`excitation`] | end of one motion and begin of the next |

pub mod block;
pub mod excitation;
pub mod span;
pub mod storage;
pub mod stretch;
