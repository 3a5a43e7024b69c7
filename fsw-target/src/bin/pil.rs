//! `pil`: the flight computer with its sensors and its flash at the other end of a serial line.
//!
//! | | |
//! |---|---|
//! | purpose | comparison of the flight computer on its processor with the one on a PC, sample by sample |
//! | rate | lock-step with the simulator |
//! | sensors | on USART2 (PA2, PA3, 115200 baud 8N1): see `fsw_target::stand_in::tunnel` |
//! | telemetry | on USART1 (PA9, PA10, 115200 baud 8N1), as in flight: an estimate after each sample; telecommands |
//! | log | defmt on RTT |
//! | end | halts after the last sample, or when the simulator is silent; a failure restarts the image |
//!
//! `host-sim pil` builds this image, runs it in QEMU and simulates the sensors.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod on_target {
    use fsw_target::arch::exit;
    use fsw_target::board::{self, Board};
    use fsw_target::flight::computer::Computer;
    use fsw_target::flight::manoeuvre::Manoeuvre;
    use fsw_target::flight::selected::SelectedEstimator;
    use fsw_target::runtime::stack;
    use fsw_target::stand_in::tunnel::parts::{self, Tunnelled};
    use fsw_target::stand_in::tunnel::{Setup, Tunnel, TunnelError};
    use static_cell::{ConstStaticCell, StaticCell};

    // The simulator detects and reports the restart.
    fsw_target::ends_by!(exit::restart_after);

    type Line = Tunnel<board::Tunnel>;
    type PilComputer = Computer<'static, Tunnelled<'static, board::Tunnel, board::Link>>;

    // In static memory and built in place, as in the flight image, so that the stack is the same.
    static LINE: StaticCell<Line> = StaticCell::new();
    static ESTIMATOR: ConstStaticCell<SelectedEstimator> =
        ConstStaticCell::new(SelectedEstimator::uninitialised());
    static MANOEUVRE: StaticCell<Manoeuvre> = StaticCell::new();
    static COMPUTER: StaticCell<Option<PilComputer>> = StaticCell::new();

    #[cortex_m_rt::entry]
    fn main() -> ! {
        if let Some((line, link)) = lines() {
            match fly(line, link) {
                Ok(()) => defmt::info!("end of the flight"),
                Err(why) => {
                    defmt::error!("{=str}", why);
                    // The log keeps the reason if the line fails too.
                    let _ = line.report_failure(why);
                }
            }
        }
        loop {
            cortex_m::asm::wfi();
        }
    }

    /// Tunnel and link of the board.
    #[inline(never)]
    fn lines() -> Option<(&'static Line, board::Link)> {
        let board = Board::take()?;
        Some((LINE.init_with(|| Tunnel::new(board.tunnel)), board.link))
    }

    /// Steps all samples of the simulator.
    ///
    /// # Errors
    /// The reason, for simulator and log.
    fn fly(line: &'static Line, link: board::Link) -> Result<(), &'static str> {
        let computer = set_up(line, link)?;
        computer.start();
        while line.end().is_none() {
            computer.poll();
            line.pause(computer.waiting_bytes() > 0);
        }
        match line.end() {
            Some(TunnelError::No) => Ok(()),
            _ => Err("no answer from the simulator"),
        }
    }

    /// Computer with its estimator. Calls in sequence: each uses the stack alone.
    #[inline(never)]
    fn set_up(
        line: &'static Line,
        link: board::Link,
    ) -> Result<&'static mut PilComputer, &'static str> {
        let setup = line.hello().map_err(|_| "no setup from the simulator")?;
        let selected = estimator(line, &setup)?;
        let manoeuvre = manoeuvre(selected).ok_or("the manoeuvre exists already")?;
        bring_up(line, &setup, (selected, manoeuvre), link)
    }

    /// Computer on the tunnel. Not inlined: its stack is free again in the loop.
    #[inline(never)]
    fn bring_up(
        line: &'static Line,
        setup: &Setup,
        kept: (&'static mut SelectedEstimator, &'static mut Manoeuvre),
        link: board::Link,
    ) -> Result<&'static mut PilComputer, &'static str> {
        let place = COMPUTER.try_init(None).ok_or("the computer exists already")?;
        let computer = parts::computer(line, setup, kept, link, stack::high_water_bytes)
            .map_err(|_| "the sensors reject their setup")?;
        Ok(place.insert(computer))
    }

    /// Manoeuvre for the wheels of the craft. Not inlined, as the estimator.
    #[inline(never)]
    fn manoeuvre(estimator: &SelectedEstimator) -> Option<&'static mut Manoeuvre> {
        MANOEUVRE.try_init(Manoeuvre::new(estimator.craft().spin_inertia_kg_m2))
    }

    /// Configured estimator. Not inlined: its stack is free again in the loop.
    #[inline(never)]
    fn estimator(
        line: &Line,
        setup: &Setup,
    ) -> Result<&'static mut SelectedEstimator, &'static str> {
        let stated = line.hardware().map_err(|_| "no stated hardware from the simulator")?;
        let estimator = ESTIMATOR.try_take().ok_or("the estimator exists already")?;
        estimator.configure(setup.craft(&stated)).map_err(|_| "the estimator rejects the craft")?;
        Ok(estimator)
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("pil runs on the target only: host-sim pil SCENARIO");
}
