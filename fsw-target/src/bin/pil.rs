//! `pil`: the flight computer with its sensors and its flash at the other end of a serial line.
//!
//! | | |
//! |---|---|
//! | purpose | shows that the flight computer does on its processor what it does on a PC, sample by sample |
//! | rate | lock-step: as fast as the simulator answers |
//! | sensors | on USART2 (PA2, PA3, 115200 baud 8N1): see `fsw_target::stand_in::tunnel` |
//! | telemetry | on USART1 (PA9, PA10, 115200 baud 8N1), as in flight: an estimate after each sample; commands |
//! | log | defmt on RTT |
//! | end | stands still once the flight is over, or the simulator silent; a failure restarts it |
//!
//! `host-sim pil` builds it, runs it in QEMU and plays the sensors.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod on_target {
    use fsw_target::arch::exit;
    use fsw_target::board::{self, Board};
    use fsw_target::flight::computer::Computer;
    use fsw_target::flight::selected::SelectedEstimator;
    use fsw_target::runtime::stack;
    use fsw_target::stand_in::tunnel::parts::{self, Tunnelled};
    use fsw_target::stand_in::tunnel::{Setup, Tunnel, TunnelError};
    use static_cell::{ConstStaticCell, StaticCell};

    // The simulator sees that it starts again, and says so.
    fsw_target::ends_by!(exit::restart_after);

    type Line = Tunnel<board::Tunnel>;
    type PilComputer = Computer<'static, Tunnelled<'static, board::Tunnel, board::Link>>;

    // As in the flight image: in static memory, so that the stack is what it is in flight, and built where
    // they stay.
    static LINE: StaticCell<Line> = StaticCell::new();
    static ESTIMATOR: ConstStaticCell<SelectedEstimator> =
        ConstStaticCell::new(SelectedEstimator::uninitialised());
    static COMPUTER: StaticCell<Option<PilComputer>> = StaticCell::new();

    #[cortex_m_rt::entry]
    fn main() -> ! {
        if let Some((line, link)) = lines() {
            match fly(line, link) {
                Ok(()) => defmt::info!("the flight is over"),
                Err(why) => {
                    defmt::error!("{=str}", why);
                    // If that isn't heard either, the log has it.
                    let _ = line.report_failure(why);
                }
            }
        }
        loop {
            cortex_m::asm::wfi();
        }
    }

    #[inline(never)]
    fn lines() -> Option<(&'static Line, board::Link)> {
        let board = Board::take()?;
        Some((LINE.init_with(|| Tunnel::new(board.tunnel)), board.link))
    }

    /// Flies until there are no further samples; the error says what was wrong.
    fn fly(line: &'static Line, link: board::Link) -> Result<(), &'static str> {
        let computer = set_up(line, link)?;
        computer.start();
        while line.end().is_none() {
            computer.poll();
            line.pause(computer.waiting_bytes() > 0);
        }
        match line.end() {
            Some(TunnelError::No) => Ok(()),
            _ => Err("the simulator doesn't answer"),
        }
    }

    /// One after the other: none takes the stack of all, and the loop that of none.
    #[inline(never)]
    fn set_up(
        line: &'static Line,
        link: board::Link,
    ) -> Result<&'static mut PilComputer, &'static str> {
        let setup = line.hello().map_err(|_| "no setup from the simulator")?;
        let estimator = estimators(&setup).ok_or("the estimators refuse the craft")?;
        bring_up(line, &setup, estimator, link)
    }

    /// The computer at the end of its line. A function of its own: what it takes of the stack is free again
    /// for the loop.
    #[inline(never)]
    fn bring_up(
        line: &'static Line,
        setup: &Setup,
        estimator: &'static mut SelectedEstimator,
        link: board::Link,
    ) -> Result<&'static mut PilComputer, &'static str> {
        let place = COMPUTER.try_init(None).ok_or("the computer is there already")?;
        let computer = parts::computer(line, setup, estimator, link, stack::high_water_bytes)
            .map_err(|_| "the sensors can't be as they are set up")?;
        Ok(place.insert(computer))
    }

    /// A function of its own: what it takes of the stack is free again for the loop.
    #[inline(never)]
    fn estimators(setup: &Setup) -> Option<&'static mut SelectedEstimator> {
        let estimator = ESTIMATOR.try_take()?;
        estimator.configure(setup.craft()).ok()?;
        Some(estimator)
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("pil runs on the target: host-sim pil SCENARIO");
}
