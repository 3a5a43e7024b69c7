//! `flight`: the flight computer.
//!
//! | | |
//! |---|---|
//! | purpose | estimation of the inertia from the gyro and four wheel tachometers |
//! | rate | 100 samples/s, each stepped before the next |
//! | spacecraft | `craft.toml`, at the root of this crate |
//! | telemetry | space packets on USART1, 115200 baud: estimate and status once a second; telecommands on the same port |
//! | log | defmt on RTT, for a probe; USART1 carries telemetry only |
//! | end | none: a failure restarts the image and is reported after the restart |
//!
//! The same ELF file runs in QEMU, without a gyro: the status reports it, and the loop continues.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod on_target {
    use fsw_target::arch::exit;
    use fsw_target::board::{
        Board, GyroBus, GyroDataReady, Link, ResetCause, SectorPair, Services, SleepTick,
        WheelCaptures,
    };
    use fsw_target::drivers::gyro::bus::Spi;
    use fsw_target::drivers::gyro::fitted::{Chip, Settings};
    use fsw_target::drivers::wheel_tach::{Config, WheelTach};
    use fsw_target::flight::computer::{Computer, Parts, Reporting, Security};
    use fsw_target::flight::craft::{CRAFT, WHEELS};
    use fsw_target::flight::flight_loop::Sensors;
    use fsw_target::flight::key::MASTER_KEY;
    use fsw_target::flight::manoeuvre::Manoeuvre;
    use fsw_target::flight::selected::SelectedEstimator;
    use fsw_target::flight::sensors::{CommandedTorque, Gyro};
    use fsw_target::runtime::failure::{Failure, Kind};
    use fsw_target::runtime::restart;
    use static_cell::{ConstStaticCell, StaticCell};

    fsw_target::ends_by!(exit::restart_after);

    /// Edges per turn, both edges of one channel: twelve pulses, as from Hall sensors on a motor with
    /// six pole pairs.
    const EDGES_PER_TURN: u16 = 24;
    /// Highest wheel speed, rad/s: 6000 rpm.
    const FASTEST_RAD_S: f32 = 628.0;
    /// Shortest interval between edges, s: half of that at the highest speed.
    const SHORTEST_EDGE_S: f32 =
        0.5 * core::f32::consts::TAU / (FASTEST_RAD_S * EDGES_PER_TURN as f32);
    /// Time without an edge after which a wheel counts as standing, s: below 0.52 rad/s.
    const ZERO_AFTER_S: f32 = 0.5;
    /// Largest wheel acceleration, rad/s²: a motor torque of 5 mN m on 2.1e-5 kg m² gives 240.
    const LARGEST_ACCELERATION_RAD_S2: f32 = 300.0;

    struct OnStm32f405;

    impl Parts for OnStm32f405 {
        type DataReady = GyroDataReady;
        type Gyro = Chip<Spi<GyroBus>>;
        type Wheels = WheelTach<WheelCaptures, WHEELS>;
        type Torque = CommandedTorque;
        type Link = Link;
        type Flash = SectorPair;
        type CounterFlash = SectorPair;
        type Board = Services;
    }

    /// Estimator and computer in static memory, built in place: they exceed the stack.
    static ESTIMATOR: ConstStaticCell<SelectedEstimator> =
        ConstStaticCell::new(SelectedEstimator::uninitialised());
    static MANOEUVRE: StaticCell<Manoeuvre> = StaticCell::new();
    static COMPUTER: StaticCell<Option<Computer<'static, OnStm32f405>>> = StaticCell::new();

    #[cortex_m_rt::entry]
    fn main() -> ! {
        // Two functions in sequence: each uses the stack alone.
        let Some((computer, tick)) = estimator().and_then(bring_up) else {
            // Error of the build: craft or configuration. Covered by tests.
            defmt::error!("board already taken, or craft or tachometer configuration rejected");
            exit::restart_after(Failure { kind: Kind::Panic, at: 0, from: 0 })
        };
        computer.start();
        loop {
            computer.poll();
            // The transmitter is polled: no sleep while it has bytes.
            if computer.waiting_bytes() == 0 {
                tick.sleep();
            }
        }
    }

    /// Ends the sleep of the loop.
    #[cortex_m_rt::exception]
    fn SysTick() {}

    /// Computer on its board. Not inlined: its stack is free again in the loop.
    #[inline(never)]
    fn bring_up(
        estimator: &'static mut SelectedEstimator,
    ) -> Option<(&'static mut Computer<'static, OnStm32f405>, SleepTick)> {
        let board = Board::take()?;
        let report = board.report();
        let by_watchdog = report.reset_cause == ResetCause::IndependentWatchdog;
        let last_run = restart::take_last_run(by_watchdog);
        defmt::info!("flight, after {}: {}", last_run, report);
        let services = Services::start(board.watchdog, &report, last_run);
        let gyro = Chip::new(Spi::new(board.gyro_bus), Settings::default());
        let tachometers = Config {
            edges_per_turn: CRAFT.spin_inertia_kg_m2.map(edges_per_turn),
            reversed: [false; WHEELS],
            zero_after_s: ZERO_AFTER_S,
            largest_acceleration_rad_s2: LARGEST_ACCELERATION_RAD_S2,
            delay_us: Gyro::delay_us(&gyro),
        };
        let captures = board.captures.start(SHORTEST_EDGE_S);
        let sensors = Sensors {
            data_ready: board.data_ready,
            gyro,
            wheels: WheelTach::new(captures, &tachometers).ok()?,
            torque: CommandedTorque::default(),
        };
        let security = Security { flash: board.counter_flash, master: MASTER_KEY };
        let manoeuvre = manoeuvre(estimator)?;
        let computer = COMPUTER.try_init(None)?.insert(Computer::new(
            (estimator, manoeuvre),
            sensors,
            board.link,
            board.flash,
            security,
            services,
            Reporting::default(),
        ));
        Some((computer, SleepTick::start(board.syst)))
    }

    /// Configured estimator. Not inlined: its stack is free again in the loop.
    #[inline(never)]
    fn estimator() -> Option<&'static mut SelectedEstimator> {
        let estimator = ESTIMATOR.try_take()?;
        estimator.configure(CRAFT).ok()?;
        Some(estimator)
    }

    /// Manoeuvre for the wheels of the craft. Not inlined, as the estimator.
    #[inline(never)]
    fn manoeuvre(estimator: &SelectedEstimator) -> Option<&'static mut Manoeuvre> {
        MANOEUVRE.try_init(Manoeuvre::new(estimator.craft().spin_inertia_kg_m2))
    }

    /// Edges per turn of a wheel; zero for a place without a wheel.
    fn edges_per_turn(spin_inertia_kg_m2: f32) -> u16 {
        if spin_inertia_kg_m2 > 0.0 { EDGES_PER_TURN } else { 0 }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "flight runs on the target only; build: cargo target build -p fsw-target --bin flight"
    );
}
