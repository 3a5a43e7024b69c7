//! What slices of work cost: instructions of a Cortex-M4F in single precision, at most.
//!
//! Counted one by one in QEMU, on the flights of `bench` (see the workspace's `fsw-target`) with 9 and with
//! 15 unknowns, where a factor's share goes with the square of their number. `bench` itself counts
//! whole steps: where one costs more than [`usual`], a number here is too low.

use super::pass::Stage;

/// Instructions.
pub type Cost = u32;

/// What a step may cost unless the configuration says otherwise: 6,000 for momentum and inertia, 10,000
/// where torque or bias are unknowns, 12,000 with drag.
pub const fn usual<const U: usize>() -> Cost {
    match U {
        ..12 => 6_000,
        12..18 => 10_000,
        18.. => 12_000,
    }
}

/// A step that does none of the work below: the gate, an average, the outcome.
pub const fn step<const U: usize>() -> Cost {
    8 * U as Cost + 790
}

/// What a linear start adds to it.
pub const fn step_of_linear<const U: usize>() -> Cost {
    25 * U as Cost + 60
}

/// A block averaged, packed and watched.
pub const BLOCK: Cost = 1_550;

/// What a linear start adds to it: three rows.
pub const fn block_of_linear<const U: usize>() -> Cost {
    squares::<U>(2_000, 0)
}

/// What a window that opens with it adds to it.
pub const fn open<const U: usize>() -> Cost {
    squares::<U>(3_300, 0)
}

/// To go on in the same block.
pub const NEXT: Cost = 40;

/// To find out what comes next, before each of the slices below.
pub const fn next<const U: usize>() -> Cost {
    4 * U as Cost + 64
}

/// Next to nothing.
pub const LITTLE: Cost = 160;

/// A block rebuilt: two unpacked, one packed.
pub const REBUILD: Cost = 1_215;

/// What a solution says of its front.
pub const JUDGE: Cost = 440;

/// So many hundredths of an instruction for each pair of unknowns, and so many in any case.
const fn squares<const U: usize>(hundredths: Cost, fixed: Cost) -> Cost {
    (U * U) as Cost * hundredths / 100 + fixed
}

/// Variances of the six elements, where motion is unstable.
pub const fn stability<const U: usize>() -> Cost {
    squares::<U>(530, 600)
}

/// A copy of a factor.
pub const fn copy<const U: usize>() -> Cost {
    squares::<U>(525, 215)
}

/// The first look for a point to start from.
pub const fn first_point<const U: usize>() -> Cost {
    squares::<U>(575, 650)
}

/// A plausible point on the way to a solution.
pub const fn choose<const U: usize>() -> Cost {
    squares::<U>(655, 1_230)
}

/// A pass begun.
pub const fn begin<const U: usize>() -> Cost {
    squares::<U>(1_378, 205)
}

/// A row of what is held.
pub const fn hold<const U: usize>() -> Cost {
    squares::<U>(215, 780)
}

/// The same of a window that ends, or what it comes to.
pub const fn hold_at_the_end<const U: usize>() -> Cost {
    hold::<U>() + 140
}

/// A slice of a linear start's solution.
pub const fn start<const U: usize>() -> Cost {
    squares::<U>(690, 1_165)
}

/// An equation carried on, of three, and then the next window begun.
pub const fn carry<const U: usize>(done: usize) -> Cost {
    match done {
        0 => squares::<U>(1_525, 90),
        1 | 2 => squares::<U>(546, 425),
        _ => squares::<U>(2_470, 760),
    }
}

/// A slice of a pass; where it is told from a spike a row is looked at twice. A row takes two products
/// for each pair of unknowns.
pub const fn of_pass<const U: usize>(stage: Stage, is_armed: bool) -> Cost {
    match stage {
        Stage::Look => 945,
        Stage::GoOn => 735,
        Stage::MoveOn => 1_230,
        Stage::Differentiate => 20 * U as Cost + 1_365,
        Stage::Row(_) if is_armed => squares::<U>(641, 565),
        Stage::Row(_) => squares::<U>(430, 370),
    }
}

/// The same of a window that ends.
pub const fn of_the_end<const U: usize>(stage: Stage, is_armed: bool) -> Cost {
    of_pass::<U>(stage, is_armed) + 220
}
