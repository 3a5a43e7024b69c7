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
    use fsw_target::app::Sensors;
    use fsw_target::board::{
        Board, CheckpointFlash, GyroBus, GyroDataReady, Link, Services, WheelCaptures,
    };
    use fsw_target::computer::{Computer, Parts, Reporting};
    use fsw_target::craft::{FLOWN, WHEELS};
    use fsw_target::drivers::gyro::bmi088::{Bmi088, Settings};
    use fsw_target::drivers::gyro::bus::Spi;
    use fsw_target::drivers::wheel_tach::{Config, WheelTach};
    use fsw_target::failure::{Failure, Kind};
    use fsw_target::onboard::Onboard;
    use fsw_target::restart;
    use fsw_target::sensors::CommandedTorque;
    use static_cell::StaticCell;

    fsw_target::ends_by!(restart::failed);

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

    static ONBOARD: StaticCell<Onboard> = StaticCell::new();

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let last_life = restart::take_last_life();
        defmt::info!("flight, after {}", last_life);
        let Some(board) = Board::take() else { refuse(1) };
        let report = board.report();
        defmt::info!("{}", report);
        let services = Services::start(board.watchdog, report.reset_cause, last_life);
        let captures = board.captures.start(SHORTEST_EDGE_S);
        let tachometers = Config {
            edges_per_turn: FLOWN.spin_inertia_kg_m2.map(edges_per_turn),
            reversed: [false; WHEELS],
            zero_after_s: ZERO_AFTER_S,
        };
        let Ok(wheels) = WheelTach::new(captures, &tachometers) else { refuse(2) };
        let Ok(onboard) = Onboard::new(FLOWN) else { refuse(3) };
        let sensors = Sensors {
            data_ready: board.data_ready,
            gyro: Bmi088::new(Spi::new(board.gyro_bus), Settings::default()),
            wheels,
            torque: CommandedTorque::default(),
        };
        let mut computer = Computer::<OnStm32f405>::start(
            ONBOARD.init(onboard),
            sensors,
            board.link,
            board.flash,
            services,
            Reporting::default(),
        );
        loop {
            computer.poll();
        }
    }

    /// No sensor where there is no wheel.
    fn edges_per_turn(spin_inertia_kg_m2: f32) -> u16 {
        if spin_inertia_kg_m2 > 0.0 { EDGES_PER_TURN } else { 0 }
    }

    /// What this image is built of doesn't fit together: a test would have shown it.
    fn refuse(step: u32) -> ! {
        defmt::error!("start-up step {=u32} failed", step);
        restart::failed(Failure { kind: Kind::Panic, at: step, from: 0 })
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("`flight` runs on the board: cargo target build -p fsw-target --bin flight");
}
