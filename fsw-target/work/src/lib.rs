//! Work of `window` on single blocks: nearly all slices of a fit.
//!
//! Compiled at `opt-level = "s"`. At `"z"`, the level of the other slices in `fsw-roster`, a block of a
//! pass takes 30,144 instructions instead of 18,112.

#![no_std]
#![forbid(unsafe_code)]

use fsw_core::estimator::window::Slice;
use fsw_steps::{Window9, Window12, Window15, Window18};

/// Slices that take in a block.
pub trait Blocks {
    /// As [`block_slice`](fsw_core::estimator::window::Window::block_slice).
    fn block(&mut self, kind: Slice) -> bool;
}

macro_rules! blocks_of_windows {
    ($($window:ty),*) => {
        $(impl Blocks for $window {
            #[inline(never)]
            fn block(&mut self, kind: Slice) -> bool {
                self.block_slice(kind)
            }
        })*
    };
}

blocks_of_windows!(Window9, Window12, Window15, Window18);
