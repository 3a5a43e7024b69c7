//! What slices of work cost: instructions of a Cortex-M4F in single precision, at most.
//!
//! Counted one by one in QEMU, on the flights of `bench` (see the workspace's `fsw-target`), for each set of
//! unknowns: what a compiler makes of a factor depends on its size. What a linear start adds to steps and blocks
//! was counted with 9 and with 15, and goes with its products in between and beyond: with 12 a block's is
//! 230 too low, which whole steps have had room for. `bench` counts those: where one costs more than
//! [`usual`], a number here is too low.

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
    of_set::<U>([1_620, 2_880, 4_500, 6_480])
}

/// What a window that opens with it adds to it.
pub const fn open<const U: usize>() -> Cost {
    of_set::<U>([2_673, 4_752, 7_425, 10_692])
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

/// Of 9, 12, 15 and 18 unknowns.
const fn of_set<const U: usize>(costs: [Cost; 4]) -> Cost {
    match U {
        ..12 => costs[0],
        12..15 => costs[1],
        15..18 => costs[2],
        18.. => costs[3],
    }
}

/// Variances of the six elements, where motion is unstable.
pub const fn stability<const U: usize>() -> Cost {
    of_set::<U>([1_029, 1_363, 1_792, 2_317])
}

/// A copy of a factor.
pub const fn copy<const U: usize>() -> Cost {
    of_set::<U>([640, 971, 1_396, 1_916])
}

/// The first look for a point to start from.
pub const fn first_point<const U: usize>() -> Cost {
    of_set::<U>([1_115, 1_478, 1_943, 6_665])
}

/// A plausible point on the way to a solution.
pub const fn choose<const U: usize>() -> Cost {
    of_set::<U>([1_760, 2_330, 2_703, 7_231])
}

/// A pass begun.
pub const fn begin<const U: usize>() -> Cost {
    of_set::<U>([1_321, 2_387, 3_305, 4_669])
}

/// A rework that has come as far as the front compared with it.
pub const fn compare<const U: usize>() -> Cost {
    of_set::<U>([181, 303, 307, 307])
}

/// The same of one that has overtaken a front which waits, and is solved at once.
pub const fn compare_and_begin<const U: usize>() -> Cost {
    of_set::<U>([987, 1_319, 1_743, 2_252])
}

/// A row of what is held.
pub const fn hold<const U: usize>() -> Cost {
    of_set::<U>([954, 1_089, 1_263, 2_972])
}

/// The same of a window that ends, or what it comes to.
pub const fn hold_at_the_end<const U: usize>() -> Cost {
    hold::<U>() + 140
}

/// A slice of a linear start's solution.
pub const fn start<const U: usize>() -> Cost {
    of_set::<U>([1_723, 2_158, 2_717, 3_400])
}

/// An equation carried on, of three, and then the next window begun.
pub const fn carry<const U: usize>(done: usize) -> Cost {
    match done {
        0 => of_set::<U>([1_325, 2_415, 3_521, 6_510]),
        1 | 2 => of_set::<U>([867, 1_235, 1_653, 2_231]),
        _ => of_set::<U>([2_760, 4_507, 6_317, 8_762]),
    }
}

/// A slice of a pass; where it is told from a spike a row is looked at twice.
pub const fn of_pass<const U: usize>(stage: Stage, is_armed: bool) -> Cost {
    match stage {
        Stage::Look => 950,
        Stage::GoOn => 740,
        Stage::MoveOn => of_set::<U>([1_230, 1_230, 1_230, 1_303]),
        Stage::Differentiate => of_set::<U>([1_545, 1_677, 1_679, 1_831]),
        Stage::Row(_) if is_armed => of_set::<U>([1_084, 1_522, 2_010, 2_711]),
        Stage::Row(_) => of_set::<U>([718, 1_000, 1_337, 1_834]),
    }
}

/// The same of a window that ends.
pub const fn of_the_end<const U: usize>(stage: Stage, is_armed: bool) -> Cost {
    of_pass::<U>(stage, is_armed) + 220
}
