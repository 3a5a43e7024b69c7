//! `panics`: panics at once. The failure must reach the caller of the image.
//!
//! | | |
//! |---|---|
//! | purpose | test of log, panic handler and exit status |
//! | log | defmt, on RTT and on USART1: location of the panic |
//! | end | always a failure |

#![cfg_attr(target_os = "none", no_std, no_main)]

use core::hint::black_box;

/// Read past the end of an array, hidden from the compiler.
fn index_out_of_bounds() -> u8 {
    let elements = black_box([1_u8, 2, 3]);
    let index = black_box(7_usize);
    elements[index]
}

#[cfg(target_os = "none")]
fsw_target::ends_by!(fsw_target::arch::exit::end_after);

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    use fsw_target::arch::exit;
    use fsw_target::board::Board;
    use fsw_target::runtime::log;

    if let Some(board) = Board::take() {
        log::init(board.link.into_log_output());
    }
    defmt::info!("about to panic");
    defmt::info!("unreachable: {=u8}", index_out_of_bounds());
    exit::success()
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("unreachable: {}", index_out_of_bounds());
}
