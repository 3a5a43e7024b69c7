//! `flight`: the flight computer.
//!
//! | | |
//! |---|---|
//! | purpose | estimates the inertia from a BMI088 and four wheel tachometers, for ever |
//! | rate | 100 samples a second, each stepped before the next |
//! | spacecraft | `craft.toml`, at the root of this crate |
//! | telemetry | space packets on USART1, 115200 baud: estimate and status once a second; commands there too |
//! | log | defmt on RTT, for a probe; it is not mirrored, since the port is telemetry's |
//! | end | none: a failure restarts it and is told afterwards |
//!
//! The same file runs in QEMU: no gyro answers there, which is reported, and the loop goes on.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod on_target {
    use fsw_target::arch::exit;
    use fsw_target::board::{
        Board, CheckpointFlash, GyroBus, GyroDataReady, Link, Services, WheelCaptures,
    };
    use fsw_target::drivers::gyro::bmi088::{Bmi088, Settings};
    use fsw_target::drivers::gyro::bus::Spi;
    use fsw_target::drivers::wheel_tach::{Config, WheelTach};
    use fsw_target::flight::computer::{Computer, Parts, Reporting};
    use fsw_target::flight::craft::{FLOWN, WHEELS};
    use fsw_target::flight::flight_loop::Sensors;
    use fsw_target::flight::selected::SelectedEstimator;
    use fsw_target::flight::sensors::CommandedTorque;
    use fsw_target::runtime::failure::{Failure, Kind};
    use fsw_target::runtime::restart;
    use static_cell::{ConstStaticCell, StaticCell};

    fsw_target::ends_by!(exit::restart_after);

    /// Edges of a turn, both flanks of one channel: twelve pulses, as of a motor with six pole pairs
    /// and Hall sensors.
    const EDGES_PER_TURN: u16 = 24;
    /// The fastest wheel, rad/s: 6000 rpm. Half the time between its edges is the shortest that counts.
    const FASTEST_RAD_S: f32 = 628.0;
    const SHORTEST_EDGE_S: f32 =
        0.5 * core::f32::consts::TAU / (FASTEST_RAD_S * EDGES_PER_TURN as f32);
    /// A wheel without an edge for so long stands still, s: it turns by less than 0.52 rad/s.
    const ZERO_AFTER_S: f32 = 0.5;

    struct OnStm32f405;

    impl Parts for OnStm32f405 {
        type DataReady = GyroDataReady;
        type Gyro = Bmi088<Spi<GyroBus>>;
        type Wheels = WheelTach<WheelCaptures, WHEELS>;
        type Torque = CommandedTorque;
        type Link = Link;
        type Flash = CheckpointFlash;
        type Board = Services;
    }

    /// In static memory, so that the loop has the stack for itself. They are built where they stay,
    /// the estimators when they go on board: there is no room for them on the stack.
    static ESTIMATOR: ConstStaticCell<SelectedEstimator> =
        ConstStaticCell::new(SelectedEstimator::uninitialised());
    static COMPUTER: StaticCell<Option<Computer<'static, OnStm32f405>>> = StaticCell::new();

    #[cortex_m_rt::entry]
    fn main() -> ! {
        // One after the other: neither takes the stack of both.
        let Some(computer) = estimators().and_then(bring_up) else {
            // What this image is built of doesn't fit together: a test would have shown it.
            defmt::error!("the board is taken, or the craft or its tachometers are refused");
            exit::restart_after(Failure { kind: Kind::Panic, at: 0, from: 0 })
        };
        computer.start();
        loop {
            computer.poll();
        }
    }

    /// The computer on its board. A function of its own: what it takes of the stack is free again for
    /// the loop.
    #[inline(never)]
    fn bring_up(
        estimator: &'static mut SelectedEstimator,
    ) -> Option<&'static mut Computer<'static, OnStm32f405>> {
        let last_run = restart::take_last_run();
        let board = Board::take()?;
        let report = board.report();
        defmt::info!("flight, after {}: {}", last_run, report);
        let services = Services::start(board.watchdog, report.reset_cause, last_run);
        let tachometers = Config {
            edges_per_turn: FLOWN.spin_inertia_kg_m2.map(edges_per_turn),
            reversed: [false; WHEELS],
            zero_after_s: ZERO_AFTER_S,
        };
        let captures = board.captures.start(SHORTEST_EDGE_S);
        let sensors = Sensors {
            data_ready: board.data_ready,
            gyro: Bmi088::new(Spi::new(board.gyro_bus), Settings::default()),
            wheels: WheelTach::new(captures, &tachometers).ok()?,
            torque: CommandedTorque::default(),
        };
        Some(COMPUTER.try_init(None)?.insert(Computer::new(
            estimator,
            sensors,
            board.link,
            board.flash,
            services,
            Reporting::default(),
        )))
    }

    #[inline(never)]
    fn estimators() -> Option<&'static mut SelectedEstimator> {
        let estimator = ESTIMATOR.try_take()?;
        estimator.configure(FLOWN).ok()?;
        Some(estimator)
    }

    /// No sensor where there is no wheel.
    fn edges_per_turn(spin_inertia_kg_m2: f32) -> u16 {
        if spin_inertia_kg_m2 > 0.0 { EDGES_PER_TURN } else { 0 }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("`flight` runs on the board: cargo target build -p fsw-target --bin flight");
}
