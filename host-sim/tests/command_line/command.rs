//! `command`: telecommands for the serial port of the flight computer.

use std::fs;

use fsw_core::Prior;
use fsw_target::flight::selected::EstimatorId;
use fsw_target::link::authentication::Key;
use fsw_target::link::uplink::UplinkCounters;
use fsw_target::link::{Command, Uplink};
use tempfile::TempDir;

use crate::program::{host_sim, rejected};

/// Telecommands that a flight computer accepts from the bytes on stdout.
fn accepted(uplink: &mut Uplink, arguments: &[&str]) -> Vec<Command> {
    let output = host_sim(&[&["command"], arguments].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout.iter().filter_map(|byte| uplink.push(*byte)).collect()
}

#[test]
fn flight_computer_accepts_every_telecommand() {
    let prior = Prior {
        inertia_kg_m2: [14.2, 17.3, 20.3, 0.0867, -0.1357, 0.6016],
        sigma_kg_m2: [3.0, 3.0, 3.0, 1.0, 1.0, 1e-3],
    };
    let numbers = "set-prior --inertia 14.2 17.3 20.3 0.0867 -0.1357 0.6016 --sigma 3 3 3 1 1 1e-3";
    let mut uplink = Uplink::default();
    for (line, command) in [
        ("ping", Command::Ping),
        ("reset", Command::Reset),
        (numbers, Command::SetPrior(prior)),
        ("open-window", Command::OpenWindow),
        ("close-window", Command::CloseWindow),
        ("select window", Command::Select(EstimatorId::Window)),
        ("select joint-ekf", Command::Select(EstimatorId::JointEkf)),
        ("select ekf-sgf-rls", Command::Select(EstimatorId::EkfSgfRls)),
        ("save-checkpoint", Command::SaveCheckpoint),
        ("dump-checkpoint", Command::DumpCheckpoint),
        ("set-telemetry-period 250", Command::SetTelemetryPeriod { ms: 250 }),
        ("set-torque 1e-3 -2e-3 .5", Command::SetTorque([1e-3, -2e-3, 0.5])),
        ("change-key 2", Command::ChangeKey { slot: 2 }),
        ("tag-telemetry on", Command::TagTelemetry(true)),
        ("tag-telemetry off", Command::TagTelemetry(false)),
        ("reboot", Command::Reboot),
        ("user-data 12000000000000000c", Command::StartManoeuvre { at_us: 12 }),
        ("start-manoeuvre now", Command::StartManoeuvre { at_us: 0 }),
        ("abort-manoeuvre", Command::AbortManoeuvre),
        ("assume-wheel-speed 3", Command::AssumeWheelSpeed { wheel: 3, speed_rad_s: None }),
        (
            "assume-wheel-speed 1 -2.5",
            Command::AssumeWheelSpeed { wheel: 1, speed_rad_s: Some(-2.5) },
        ),
    ] {
        let words: Vec<&str> = line.split(' ').collect();
        assert_eq!(accepted(&mut uplink, &words), [Command::StartSequence, command], "{line}");
    }
    assert_eq!(uplink.counters(), UplinkCounters { accepted: 42, ..UplinkCounters::NONE });
}

#[test]
fn start_of_the_sequence_is_sent_alone() {
    let mut uplink = Uplink::default();
    assert_eq!(accepted(&mut uplink, &["start-sequence"]), [Command::StartSequence]);
    assert_eq!(accepted(&mut uplink, &["ping", "--sequence", "1"]), [Command::Ping]);
}

#[test]
fn telecommand_with_an_explicit_count_is_accepted_once() {
    let mut uplink = Uplink::default();
    let reset = ["reset", "--sequence", "41"];
    assert_eq!(accepted(&mut uplink, &reset), [Command::Reset]);
    assert_eq!(accepted(&mut uplink, &reset), []);
    assert_eq!(uplink.counters().replayed, 1);
}

#[test]
fn bytes_are_those_of_the_documentation() {
    let link = fs::read_to_string("../fsw-target/src/link/link.md").unwrap();
    let output = host_sim(&["command", "set-torque", "1e-3", "-2e-3", "5e-4", "--sequence", "5"]);
    let bytes: Vec<String> = output.stdout.iter().map(|byte| format!("{byte:02x}")).collect();
    assert!(link.contains(&format!("```text\n{}\n```", bytes.join(" "))), "{bytes:?}");
}

#[test]
fn prior_is_read_from_a_craft_file() {
    let folder = TempDir::new().unwrap();
    let craft = |name: &str, text: &str| {
        let file = folder.path().join(name);
        fs::write(&file, text).unwrap();
        file.to_str().unwrap().to_owned()
    };
    let known = craft(
        "known.toml",
        "[prior]\ninertia_kg_m2 = [2, 2, 3, 0, 0, 0]\nsigma_kg_m2 = [1, 1, 1, 1, 1, 1]\n",
    );
    let inertia_kg_m2 = [2.0, 2.0, 3.0, 0.0, 0.0, 0.0];
    let prior = Command::SetPrior(Prior { inertia_kg_m2, sigma_kg_m2: [1.0; 6] });
    let commands =
        accepted(&mut Uplink::default(), &["set-prior", "--craft", &known, "--sequence", "1"]);
    assert_eq!(commands, [prior]);
    let unknown = craft("unknown.toml", "");
    rejected(
        &host_sim(&["command", "set-prior", "--craft", &unknown]),
        &["unknown.toml", "[prior]"],
    );
}

#[test]
fn telecommand_that_the_computer_rejects_is_rejected() {
    for (line, named) in [
        ("set-torque 0 0 101", "100 N m"),
        ("set-torque 0 0 NaN", "100 N m"),
        ("set-torque 0 0", "<Z_N_M>"),
        ("set-telemetry-period 10", "50 ms"),
        ("set-telemetry-period -10", "-10"),
        ("set-prior --inertia 1 1 3 0 0 0 --sigma 1 1 1 1 1 1", "no rigid body"),
        ("set-prior --inertia 1 1 1 0 0 0 --sigma 1 1 0 1 1 1", "sigma"),
        ("set-prior --inertia 1 1 1 0 0 0", "--sigma"),
        ("set-prior", "--craft"),
        ("select joint-ekf-published", "ekf-sgf-rls"),
        ("reset --sequence 16384", "16384"),
        ("", "reset"),
    ] {
        let words: Vec<&str> = line.split_whitespace().collect();
        rejected(&host_sim(&[&["command"], &words[..]].concat()), &[named]);
    }
}

/// Key of slot 1 by `derive-key`, in a file of the folder.
fn slot_key(folder: &TempDir, digits: &str, generation: &str) -> String {
    let master = folder.path().join("master.key");
    fs::write(&master, digits).unwrap();
    let path = master.to_str().unwrap();
    let output = host_sim(&["derive-key", path, "--slot", "1", "--generation", generation]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let key = folder.path().join(format!("slot1.{generation}.key"));
    fs::write(&key, output.stdout).unwrap();
    key.to_str().unwrap().to_owned()
}

#[test]
fn flight_computer_with_a_key_accepts_a_tagged_telecommand_once() {
    let folder = TempDir::new().unwrap();
    let digits = "000102030405060708090a0b0c0d0e0f";
    let key = slot_key(&folder, digits, "0");
    // Example of the link's documentation.
    assert_eq!(fs::read_to_string(&key).unwrap(), "e4c9fa0ab1983240db6698e7b2ee1871\n");
    let mut uplink = Uplink::new(Some(Key::new(std::array::from_fn(|byte| byte as u8))));
    let reset = ["reset", "--key", &key, "--counter", "5"];
    assert_eq!(accepted(&mut uplink, &reset), [Command::Reset]);
    assert_eq!(accepted(&mut uplink, &reset), [], "replayed");
    assert_eq!(accepted(&mut uplink, &["reset"]), [], "without a tag");
    assert_eq!(uplink.counters().unauthenticated, 2);
    let other = slot_key(&folder, digits, "1");
    assert_eq!(accepted(&mut uplink, &["reset", "--key", &other, "--counter", "6"]), []);
    let slot_2 = ["reset", "--key", &key, "--counter", "6", "--slot", "2"];
    assert_eq!(accepted(&mut uplink, &slot_2), []);
    assert_eq!(uplink.counters().wrong_tag, 2);
}

#[test]
fn bad_key_is_named_with_its_file_and_remedy() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("short.key");
    for content in
        ["", "0011", "+0102030405060708090a0b0c0d0e0f0", "gg0102030405060708090a0b0c0d0e0f"]
    {
        fs::write(&file, content).unwrap();
        let path = file.to_str().unwrap();
        let output = host_sim(&["command", "reset", "--key", path, "--counter", "1"]);
        rejected(&output, &["short.key", "32 hexadecimal digits"]);
    }
    let output = host_sim(&["command", "reset", "--key", "none.key", "--counter", "1"]);
    rejected(&output, &["none.key"]);
    let output = host_sim(&["command", "reset", "--key", "none.key"]);
    rejected(&output, &["--counter"]);
}
