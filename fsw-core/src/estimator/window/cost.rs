//! What slices of work cost: instructions of a Cortex-M4F in single precision, in hundreds, at most.
//!
//! Counted by `bench` (see the workspace's `fsw-target`), and rounded up.

use super::pass::Stage;

/// Hundreds of instructions.
pub type Cost = u32;

/// Next to nothing.
pub const LITTLE: Cost = 1;
/// A copy of a factor.
pub const COPY: Cost = 5;
/// A block rebuilt: two unpacked, one packed.
pub const REBUILD: Cost = 13;
/// Variances of the six elements.
pub const VARIANCES: Cost = 5;
/// The first look for a point to start from.
pub const FIRST_POINT: Cost = 14;
/// What a solution says of its front.
pub const JUDGE: Cost = 4;
/// A plausible point on the way to a solution.
pub const CHOOSE: Cost = 12;
/// A pass begun.
pub const BEGIN: Cost = 7;
/// What is left of a window.
pub const CONCLUDE: Cost = 4;
/// A block averaged, packed and watched.
pub const BLOCK: Cost = 12;

/// One of the slices that `slices_per_step` counts: a row of U unknowns.
pub const fn slice<const U: usize>() -> Cost {
    row::<U>()
}

/// A row added to a factor of U unknowns, made and weighed: two products for each pair of them.
pub const fn row<const U: usize>() -> Cost {
    (U * U) as Cost / 24 + 4
}

/// A row of what is held, or as much work on six elements.
pub const fn hold<const U: usize>() -> Cost {
    row::<U>()
}

/// A slice of a pass; where it is told from a spike a row is looked at twice.
pub const fn of_pass<const U: usize>(stage: Stage, is_armed: bool) -> Cost {
    match stage {
        Stage::Look => 12,
        Stage::GoOn => 8,
        Stage::Cross => U as Cost / 2 + 8,
        Stage::Row(_) if is_armed => row::<U>() * 3 / 2,
        Stage::Row(_) => row::<U>(),
    }
}
