//! `failures`: produces every kind of failure in turn, each followed by a restart as in flight.
//!
//! | | |
//! |---|---|
//! | purpose | test of fault handlers, restart, and stack limit |
//! | log | defmt, on RTT and on USART1: each failure when caught, and again after the restart |
//! | end | success after the last failure; failure if a static was overwritten |

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod on_target {
    use core::hint::black_box;
    use core::sync::atomic::{AtomicU32, Ordering};
    use cortex_m::peripheral::SCB;
    use fsw_target::arch::exit;
    use fsw_target::board::Board;
    use fsw_target::runtime::failure::Failure;
    use fsw_target::runtime::{log, restart, stack};

    fsw_target::ends_by!(failed);

    /// Value of the statics.
    const PATTERN: u32 = 0xc0de_cafe;

    /// Statics that an undetected stack overflow would overwrite.
    static STATICS: [AtomicU32; 256] = [const { AtomicU32::new(PATTERN) }; 256];

    /// Checks the statics after a failure, then restarts as the flight image does.
    fn failed(failure: Failure) -> ! {
        if STATICS.iter().any(|word| word.load(Ordering::Relaxed) != PATTERN) {
            defmt::error!("statics were overwritten");
            exit::failure()
        }
        exit::restart_after(failure)
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let last_run = restart::take_last_run(false);
        if let Some(board) = Board::take() {
            log::init(board.link.into_log_output());
        }
        defmt::info!("start {=u32}, last failure {}", last_run.failures, last_run.failure);
        match last_run.failures {
            0 => defmt::info!("{=f32}", recurse(0.0)),
            1 => defmt::info!("{=u32}", overflow_at_once()),
            2 => cortex_m::asm::udf(),
            3 => SCB::set_pendst(), // SysTick has no handler
            4 => defmt::info!("{=u8}", index_out_of_bounds()),
            _ => succeed(),
        }
        defmt::error!("expected failure did not occur");
        exit::failure()
    }

    /// Recursion without end, hidden from the compiler. Uses floating point, so that the fault also
    /// saves those registers.
    #[inline(never)]
    fn recurse(depth: f32) -> f32 {
        let frame = black_box([depth; 10]);
        if black_box(true) { recurse(depth + 1.0) + frame.iter().sum::<f32>() } else { depth }
    }

    /// One frame larger than the stack, accessed at its far end only.
    #[inline(never)]
    fn overflow_at_once() -> u32 {
        black_box([0_u32; 25_000])[7]
    }

    /// Read past the end of an array, hidden from the compiler.
    fn index_out_of_bounds() -> u8 {
        let elements = black_box([1_u8, 2, 3]);
        let index = black_box(7_usize);
        elements[index]
    }

    /// Checks that the stack is used in part, and ends the image.
    fn succeed() -> ! {
        let used_bytes = stack::high_water_bytes();
        defmt::info!("stack: {=u32} of {=u32} bytes used", used_bytes, stack::size_bytes());
        if used_bytes == 0 || used_bytes >= stack::size_bytes() {
            exit::failure()
        }
        exit::success()
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("failures runs on the target only: cargo qemu failures");
}
