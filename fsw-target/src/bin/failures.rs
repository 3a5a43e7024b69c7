//! `failures`: fails in each way that there is, restarts as the flight image does, and tells.
//!
//! | | |
//! |---|---|
//! | purpose | test of the fault handlers, the restart, and the stack's place in memory |
//! | log | defmt, on RTT and on USART1: each failure as it is caught, and again in the next life |
//! | end | success in the life after the last failure; failure if a static was overwritten |

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

    /// What the statics hold.
    const PATTERN: u32 = 0xc0de_cafe;

    /// Statics that an overflowing stack would overwrite: it goes on until it leaves the RAM.
    static STATICS: [AtomicU32; 256] = [const { AtomicU32::new(PATTERN) }; 256];

    /// Looks at the statics while the failure is fresh, then ends as the flight image does.
    fn failed(failure: Failure) -> ! {
        if STATICS.iter().any(|word| word.load(Ordering::Relaxed) != PATTERN) {
            defmt::error!("statics were overwritten");
            exit::failure()
        }
        exit::restart_after(failure)
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let last_run = restart::take_last_run();
        if let Some(board) = Board::take() {
            log::init(board.link.into_log_output());
        }
        defmt::info!("life {=u32}, ended last by {}", last_run.failures, last_run.failure);
        match last_run.failures {
            0 => defmt::info!("{=f32}", descend(0.0)),
            1 => defmt::info!("{=u32}", leap()),
            2 => cortex_m::asm::udf(),
            3 => SCB::set_pendst(), // nothing serves SysTick
            4 => defmt::info!("{=u8}", index_out_of_bounds()),
            _ => succeed(),
        }
        defmt::error!("that should have failed");
        exit::failure()
    }

    /// Calls itself for ever, which the compiler is kept from seeing. With floating point, so that
    /// the fault has those registers to save too.
    #[inline(never)]
    fn descend(depth: f32) -> f32 {
        let frame = black_box([depth; 10]);
        if black_box(true) { descend(depth + 1.0) + frame.iter().sum::<f32>() } else { depth }
    }

    /// Needs more stack than there is at once, and uses the far end of it only.
    #[inline(never)]
    fn leap() -> u32 {
        black_box([0_u32; 25_000])[7]
    }

    /// Reads past the end of an array, which the compiler is kept from seeing.
    fn index_out_of_bounds() -> u8 {
        let elements = black_box([1_u8, 2, 3]);
        let index = black_box(7_usize);
        elements[index]
    }

    /// After a life's start the stack has been used, but not all of it.
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
    println!("fails on the target only: cargo qemu failures");
}
