//! `pil`: the flight computer with its sensors and its flash at the other end of a serial line.
//!
//! | | |
//! |---|---|
//! | purpose | shows that the flight computer does on its processor what it does on a PC, sample by sample |
//! | rate | lock-step: as fast as the simulator answers |
//! | sensors | on USART2 (PA2, PA3, 115200 baud 8N1): see `fsw_target::tunnel` |
//! | telemetry | on USART1 (PA9, PA10, 115200 baud 8N1), as in flight: an estimate after each sample; commands |
//! | log | defmt on RTT |
//! | end | stands still once the flight is over, or the simulator silent; a failure restarts it |
//!
//! `host-sim pil` builds it, runs it in QEMU and plays the sensors.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod on_target {
    use fsw_target::board::{self, Board};
    use fsw_target::onboard::Onboard;
    use fsw_target::restart;
    use fsw_target::tunnel::{Setup, Tunnel, TunnelError, parts};
    use static_cell::StaticCell;

    // The simulator sees that it starts again, and says so.
    fsw_target::ends_by!(restart::failed);

    /// Built where they stay: there is no room for them on the stack.
    static ONBOARD: StaticCell<Option<Onboard>> = StaticCell::new();

    #[cortex_m_rt::entry]
    fn main() -> ! {
        if let Some(board) = Board::take() {
            let tunnel = Tunnel::new(board.tunnel);
            match fly(&tunnel, board.link) {
                Ok(()) => defmt::info!("the flight is over"),
                Err(why) => {
                    defmt::error!("{=str}", why);
                    // If that isn't heard either, the log has it.
                    let _ = tunnel.give_up(why);
                }
            }
        }
        loop {
            cortex_m::asm::wfi();
        }
    }

    /// Flies until there are no further samples; the error says what was wrong.
    fn fly(tunnel: &Tunnel<board::Tunnel>, link: board::Link) -> Result<(), &'static str> {
        let setup = tunnel.hello().map_err(|_| "no setup from the simulator")?;
        let onboard = estimators(&setup).ok_or("the estimators refuse the craft")?;
        let mut computer = parts::computer(tunnel, &setup, onboard, link)
            .map_err(|_| "the sensors can't be as they are set up")?;
        computer.start();
        while tunnel.end().is_none() {
            computer.poll();
            tunnel.hold(computer.waiting_bytes() > 0);
        }
        match tunnel.end() {
            Some(TunnelError::No) => Ok(()),
            _ => Err("the simulator doesn't answer"),
        }
    }

    /// A function of its own: what it takes of the stack is free again for the loop.
    #[inline(never)]
    fn estimators(setup: &Setup) -> Option<&'static mut Onboard> {
        let craft = setup.craft();
        let wheels = craft.wheels().ok()?;
        let onboard = ONBOARD.try_init(None)?.insert(Onboard::unconfigured(craft, wheels));
        onboard.configure().ok()?;
        Some(onboard)
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("pil runs on the target: host-sim pil SCENARIO");
}
