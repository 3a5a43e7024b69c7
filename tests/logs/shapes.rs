//! Logs as other programs export them. Each is read with the craft file that `init --from` drafts from
//! it, and gives the motion that was written.

use std::f64::consts::TAU;
use std::path::Path;

use host_sim::input::{Craft, RecordedLog, guess, log_file};

/// Rows of a log.
const ROWS: usize = 60;
/// Time between rows, s.
const STEP_S: f64 = 0.1;

/// One sample of the motion.
struct Sample {
    time_s: f64,
    rate_rad_s: [f64; 3],
    wheels_rad_s: [f64; 3],
}

fn samples() -> impl Iterator<Item = Sample> {
    (0..ROWS).map(|row| {
        let t = row as f64 * STEP_S;
        Sample {
            time_s: t,
            rate_rad_s: [
                0.3 * (0.9 * t).sin(),
                0.2 * (1.3 * t).cos(),
                0.1 + 0.05 * (0.7 * t).sin(),
            ],
            wheels_rad_s: [200.0 + 10.0 * t, -150.0 - 5.0 * t, 90.0 + 2.0 * t],
        }
    })
}

fn deg(rate: [f64; 3]) -> [f64; 3] {
    rate.map(f64::to_degrees)
}

fn rpm(speed: f64) -> f64 {
    speed * 60.0 / TAU
}

/// A log with this header and these rows.
fn log(header: &str, row: impl Fn(&Sample) -> String) -> String {
    let rows: Vec<String> = samples().map(|sample| row(&sample)).collect();
    format!("{header}\n{}\n", rows.join("\n"))
}

/// Reads a log with its own draft. What a person fills in is the spin inertia and the axis of wheels.
fn read(name: &str, text: &str) -> (String, RecordedLog) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    let source = log_file::read(&path, &Default::default()).unwrap();
    let draft = guess::draft(name, &source).unwrap();
    let filled = draft
        .replace("spin_inertia_kg_m2 = 0 ", "spin_inertia_kg_m2 = 1e-5 ")
        .replace("axis = [0, 0, 0]", "axis = [1, 1, 1]");
    let craft = Craft::from_toml("craft.toml", &filled).unwrap();
    let log = log_file::load(Path::new(&path), &craft).unwrap();
    (draft, log)
}

/// Compares a log with the motion, to the digits of its text.
fn assert_motion(log: &RecordedLog, wheels: usize, tolerance: f64) {
    assert_eq!(log.rows.len(), ROWS);
    for (row, sample) in log.rows.iter().zip(samples()) {
        assert_eq!(row.time_us, (sample.time_s * 1e6).round() as u64);
        for (found, expected) in row.rate_rad_s.iter().zip(sample.rate_rad_s) {
            assert!((found - expected).abs() < tolerance, "{row:?}");
        }
        assert_eq!(row.wheel_speed_rad_s.len(), wheels);
        for (found, expected) in row.wheel_speed_rad_s.iter().zip(sample.wheels_rad_s) {
            assert!((found - expected).abs() < 1e-3, "{row:?}");
        }
    }
    assert!(log.skipped_rows.is_empty(), "{:?}", log.skipped_rows);
}

#[test]
fn ros_bag() {
    let header = "/imu/header/stamp/secs,/imu/header/stamp/nsecs,/imu/header/frame_id,\
                  /imu/orientation/x,/imu/orientation/y,/imu/orientation/z,/imu/orientation/w,\
                  /imu/angular_velocity/x,/imu/angular_velocity/y,/imu/angular_velocity/z,\
                  /imu/linear_acceleration/x,/imu/linear_acceleration/y,/imu/linear_acceleration/z";
    let text = log(header, |sample| {
        let ns = (sample.time_s * 1e9).round() as u64 + 1_700_000_000_950_000_000;
        let [x, y, z] = sample.rate_rad_s;
        let (secs, nsecs) = (ns / 1_000_000_000, ns % 1_000_000_000);
        format!("{secs},{nsecs},imu_link,0,0,0,1,{x},{y},{z},0.1,0.2,9.81")
    });
    let (draft, log) = read("imu.csv", &text);
    assert_motion(&log, 0, 1e-12);
    assert_eq!(log.start_s, 1_700_000_000.95);
    assert!(draft.contains("time_unit = [\"s\", \"ns\"]"), "{draft}");
}

#[test]
fn rostopic_echo() {
    let header = "%time,field.header.seq,field.header.stamp,field.angular_velocity.x,\
                  field.angular_velocity.y,field.angular_velocity.z";
    let text = log(header, |sample| {
        let ns = (sample.time_s * 1e9).round() as u64 + 1_700_000_000_000_000_000;
        let [x, y, z] = sample.rate_rad_s;
        format!("{ns},1,{ns},{x},{y},{z}")
    });
    assert_motion(&read("imu.csv", &text).1, 0, 1e-12);
}

#[test]
fn phyphox() {
    let header = "\"Time (s)\",\"Gyroscope x (rad/s)\",\"Gyroscope y (rad/s)\",\"Gyroscope z (rad/s)\",\
                  \"Absolute (rad/s)\"";
    let row = |sample: &Sample| {
        let [x, y, z] = sample.rate_rad_s;
        format!("{:.9E},{x:.9E},{y:.9E},{z:.9E},{:.9E}", sample.time_s, x.hypot(y).hypot(z))
    };
    assert_motion(&read("Raw Data.csv", &log(header, row)).1, 0, 1e-9);
    // As a German telephone exports it.
    let semicolons = |text: &str| text.replace(',', ";").replace('.', ",");
    let text = log(&header.replace(',', ";"), |sample| semicolons(&row(sample)));
    assert_motion(&read("Raw Data.csv", &text).1, 0, 1e-9);
}

#[test]
fn matlab() {
    let header = "Time,omega_1,omega_2,omega_3,wheelSpeed_1,wheelSpeed_2,wheelSpeed_3";
    let row = |sample: &Sample, time: String| {
        let [x, y, z] = sample.rate_rad_s;
        let [a, b, c] = sample.wheels_rad_s;
        format!("{time},{x:.15},{y:.15},{z:.15},{a},{b},{c}")
    };
    let text = log(header, |sample| row(sample, format!("{} sec", sample.time_s)));
    let (draft, of_durations) = read("flight.csv", &text);
    assert_motion(&of_durations, 3, 1e-12);
    assert!(draft.contains("CONFIRM: not in the header; values up to 259"), "{draft}");
    // A datetime, and a duration across a day.
    let forms: [fn(f64) -> String; 2] = [
        |time_s| format!("26-Nov-2026 12:00:{time_s:06.3}"),
        |time_s| {
            let (hours, seconds) =
                if time_s < 3.0 { (23, 57.0 + time_s) } else { (24, time_s - 3.0) };
            format!("{hours}:{}:{seconds:06.3}", if hours == 23 { "59" } else { "00" })
        },
    ];
    for form in forms {
        let (draft, read) =
            read("flight.csv", &log(header, |sample| row(sample, form(sample.time_s))));
        assert_motion(&read, 3, 1e-12);
        assert!(draft.contains("time_unit = \"utc\""), "{draft}");
    }
}

#[test]
fn yamcs() {
    // Parameters by their qualified names, tabs, a cell only where a parameter has a new value.
    let header = "Time\t/ADCS/GYRO_X_DPS\t/ADCS/GYRO_Y_DPS\t/ADCS/GYRO_Z_DPS\t/ADCS/RW1_SPEED_RPM\t\
                  /ADCS/RW2_SPEED_RPM\t/ADCS/RW3_SPEED_RPM\t/ADCS/RW1_CURRENT_MA";
    let text = log(header, |sample| {
        let [x, y, z] = deg(sample.rate_rad_s);
        let [a, b, c] = sample.wheels_rad_s.map(rpm);
        let milliseconds = (sample.time_s * 1e3).round() as u64;
        let time =
            format!("2024-05-01T12:00:{:02}.{:03}Z", milliseconds / 1000, milliseconds % 1000);
        let wheels = match milliseconds % 1000 {
            0 => format!("{a}\t{b}\t{c}\t12"),
            _ => "\t\t\t".to_owned(),
        };
        format!("{time}\t{x}\t{y}\t{z}\t{wheels}")
    });
    let (_, log) = read("parameters.tsv", &text);
    // The last reading of the wheels is at 5 s.
    assert_eq!((log.rows.len(), log.skipped_rows["no_reading"]), (51, 9));
    assert_eq!(log.start_s, 1_714_564_800.0);
    for (row, sample) in log.rows.iter().zip(samples()) {
        assert!((row.rate_rad_s[0] - sample.rate_rad_s[0]).abs() < 1e-12);
        assert!((row.wheel_speed_rad_s[0] - sample.wheels_rad_s[0]).abs() < 1e-9);
    }
    assert_eq!(log.interpolation.unwrap().period_s, 1.0);
}

#[test]
fn cosmos() {
    let header = "# Data extracted by the ground system\nTARGET\tPACKET\tRECEIVED_TIMESECONDS\t\
                  PACKET_TIMESECONDS\tGYRO_RATE_X\tGYRO_RATE_Y\tGYRO_RATE_Z\tRW_SPEED_1\tRW_SPEED_2\t\
                  RW_SPEED_3\tRW_TEMP_1";
    let text = log(header, |sample| {
        let [x, y, z] = sample.rate_rad_s;
        let [a, b, c] = sample.wheels_rad_s.map(rpm);
        let time = 1_700_000_000.0 + sample.time_s;
        format!(
            "SAT\tADCS\t{:.2}\t{time:.1}\t{x}\t{y}\t{z}\t{a:.6}\t{b:.6}\t{c:.6}\t21",
            time + 1.3
        )
    });
    let (draft, log) = read("extract.txt", &text);
    assert_motion(&log, 3, 1e-12);
    assert!(draft.contains("unit = \"rpm\"") && draft.contains("as a time since 1970"), "{draft}");
}

#[test]
fn betaflight_blackbox() {
    let header = "\"Product\",\"Blackbox flight data recorder by Nicholas Sherlock\"\n\
                  \"firmwareType\",\"Cleanflight\"\n\"gyro_scale\",\"0x3f800000\"\n\
                  loopIteration, time (us), axisP[0], axisP[1], axisP[2], gyroADC[0] (deg/s), \
                  gyroADC[1] (deg/s), gyroADC[2] (deg/s), accSmooth[0], accSmooth[1], accSmooth[2]";
    let text = log(header, |sample| {
        let [x, y, z] = deg(sample.rate_rad_s);
        let us = (sample.time_s * 1e6).round() as u64 + 31_415_926;
        format!("{}, {us}, 1, 2, 3, {x}, {y}, {z}, 11, 22, 2048", us / 1000)
    });
    let (_, log) = read("LOG00001.01.csv", &text);
    assert_motion(&log, 0, 1e-12);
}

#[test]
fn px4_sensor_combined() {
    let header = "timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],gyro_integral_dt,\
                  accelerometer_timestamp_relative,accelerometer_m_s2[0],accelerometer_m_s2[1],\
                  accelerometer_m_s2[2],accelerometer_integral_dt,accelerometer_clipping,gyro_clipping";
    let text = log(header, |sample| {
        let [x, y, z] = sample.rate_rad_s;
        let us = (sample.time_s * 1e6).round() as u64 + 112_574_307;
        format!("{us},{x},{y},{z},100000,0,0.1,-0.2,-9.8,100000,0,0")
    });
    let (draft, log) = read("log_sensor_combined_0.csv", &text);
    assert_motion(&log, 0, 1e-12);
    let is_unit =
        |line: &str| line.starts_with("unit = \"rad/s\"") && line.ends_with("# as in the header");
    assert!(draft.lines().any(is_unit), "{draft}");
    assert!(draft.contains("CONFIRM: by its increments"), "{draft}");
}

/// A time of day from a minute before midnight UTC on 1 April 2025, and its date.
fn instant(time_s: f64) -> chrono::DateTime<chrono::Utc> {
    let start = chrono::DateTime::from_timestamp(1_743_551_940, 0).unwrap();
    start + chrono::Duration::microseconds((time_s * 1e6).round() as i64)
}

#[test]
fn spreadsheets_of_any_language() {
    let row = |sample: &Sample, date: &str, between: &str| {
        let [x, y, z] = deg(sample.rate_rad_s);
        let [a, b, c] = sample.wheels_rad_s.map(rpm);
        let time = instant(sample.time_s).format(date).to_string();
        [time, x.to_string(), y.to_string(), z.to_string()]
            .into_iter()
            .chain([a, b, c].map(|speed| format!("{speed:.6}")))
            .collect::<Vec<_>>()
            .join(between)
    };
    // German: decimal commas, and one in the time of day.
    let header = "Zeit;Drehrate X [°/s];Drehrate Y [°/s];Drehrate Z [°/s];RW1 [U/min];RW2 [U/min];RW3 [U/min]";
    let text = log(header, |sample| row(sample, "%d.%m.%Y %H:%M:%S%.3f", ";").replace('.', ","));
    let dotted = |line: &str| {
        let (date, rest) = line.split_once(' ').unwrap_or((line, ""));
        format!("{} {rest}", date.replace(',', "."))
    };
    let text: Vec<String> = text.lines().map(dotted).collect();
    assert_motion(&read("export.csv", &text.join("\n")).1, 3, 1e-9);
    // American: quoted cells, month before day, AM and PM, separated thousands.
    let header = "\"Timestamp\",\"P (deg/sec)\",\"Q (deg/sec)\",\"R (deg/sec)\",\"Wheel A Speed (RPM)\",\
                  \"Wheel B Speed (RPM)\",\"Wheel C Speed (RPM)\"";
    let thousands = |cell: &str| match cell.split_once('.') {
        Some((whole, rest)) if whole.trim_start_matches('-').len() == 4 => {
            let at = whole.len() - 3;
            format!("{},{}.{rest}", &whole[..at], &whole[at..])
        }
        _ => cell.to_owned(),
    };
    let text = log(header, |sample| {
        let cells = row(sample, "%m/%d/%Y %I:%M:%S%.3f %p", ";");
        let cells: Vec<String> =
            cells.split(';').map(|cell| format!("\"{}\"", thousands(cell))).collect();
        cells.join(",")
    });
    assert!(text.contains("\"1,9"), "{text}");
    let (draft, log) = read("export.csv", &text);
    assert_motion(&log, 3, 1e-9);
    assert_eq!(log.start_s, 1_743_551_940.0);
    // 1 April and 4 January alike.
    assert!(draft.contains("day and month may be exchanged"), "{draft}");
}

#[test]
fn clocks_of_flight_dynamics() {
    let rates = |sample: &Sample| {
        let [x, y, z] = sample.rate_rad_s;
        format!("{x},{y},{z}")
    };
    // Modified Julian date, its resolution 0.9 µs.
    let text = log("MJD_UTC,wx,wy,wz", |sample| {
        format!("{:.11},{}", 60_767.0 + (86_340.0 + sample.time_s) / 86_400.0, rates(sample))
    });
    let (draft, mjd) = read("ephemeris.csv", &text);
    assert!(draft.contains("time_unit = \"d\""), "{draft}");
    assert_eq!(mjd.rows.len(), ROWS);
    for (row, sample) in mjd.rows.iter().zip(samples()) {
        assert!((row.time_us as f64 * 1e-6 - sample.time_s).abs() < 3e-6, "{row:?}");
    }
    // Week and second of GPS.
    let text = log("gps_week,gps_sow,omega_x,omega_y,omega_z", |sample| {
        format!("2360,{:.3},{}", 259_140.0 + sample.time_s, rates(sample))
    });
    assert_motion(&read("gps.csv", &text).1, 0, 1e-12);
    // STK, SPICE-like, without separators.
    for date in ["%d %b %Y %H:%M:%S%.3f", "%Y %b %d %H:%M:%S%.3f", "%Y%m%dT%H%M%S%.3f"] {
        let text =
            log("Time (UTCG),Rate X (rad/sec),Rate Y (rad/sec),Rate Z (rad/sec)", |sample| {
                format!("{},{}", instant(sample.time_s).format(date), rates(sample))
            });
        let (draft, log) = read("report.csv", &text);
        assert_motion(&log, 0, 1e-12);
        assert_eq!(log.start_s, 1_743_551_940.0, "{draft}");
    }
}

#[test]
fn json_lines() {
    let text = log("", |sample| {
        let [x, y, z] = sample.rate_rad_s;
        let ns = (sample.time_s * 1e9).round() as u64 + 1_700_000_000_000_000_000;
        let [a, b, c] = sample.wheels_rad_s;
        format!(
            "{{\"ts\": {ns}, \"imu\": {{\"angular_velocity\": {{\"x\": {x}, \"y\": {y}, \"z\": {z}}}}}, \
             \"wheels\": [{a}, {b}, {c}]}}"
        )
    });
    let (draft, log) = read("telemetry.jsonl", text.trim_start());
    assert_motion(&log, 3, 1e-12);
    assert!(draft.contains("imu.angular_velocity.x"), "{draft}");
}

#[test]
fn bench_output_with_a_header_in_a_comment() {
    // Wheels by their momentum; 1e-5 kg m² is filled in.
    let header = "% Generated by the flat satellite\n% columns: MET[s] wx[mrad/s] wy[mrad/s] wz[mrad/s] \
                  h1[mNms] h2[mNms] h3[mNms]";
    let text = log(header, |sample| {
        let [x, y, z] = sample.rate_rad_s.map(|rate| rate * 1e3);
        let [a, b, c] = sample.wheels_rad_s.map(|speed| speed * 1e-5 * 1e3);
        format!(
            "{:10.3} {x:12.9} {y:12.9} {z:12.9} {a:12.9} {b:12.9} {c:12.9}",
            sample.time_s + 1e6
        )
    });
    let (draft, log) = read("run.dat", &text);
    assert_motion(&log, 3, 1e-9);
    assert!(draft.contains("unit = \"mN m s\""), "{draft}");
}

#[test]
fn counts_need_a_scale() {
    let text = log("t,gyro_raw_x,gyro_raw_y,gyro_raw_z", |sample| {
        let [x, y, z] = deg(sample.rate_rad_s).map(|rate| (rate / 0.0038).round());
        format!("{:.1},{x},{y},{z}", sample.time_s)
    });
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("raw.csv");
    std::fs::write(&path, &text).unwrap();
    let draft =
        guess::draft("raw.csv", &log_file::read(&path, &Default::default()).unwrap()).unwrap();
    let error = Craft::from_toml("craft.toml", &draft).unwrap_err().to_string();
    assert!(error.contains("log.gyro.scale"), "{error}");
    let filled = draft.replace("scale = 0 ", "scale = 0.0038 ");
    let log = log_file::load(&path, &Craft::from_toml("craft.toml", &filled).unwrap()).unwrap();
    assert_motion(&log, 0, 0.0038_f64.to_radians());
}

#[test]
fn one_value_in_each_row_is_named() {
    let rows = samples().flat_map(|sample| {
        ["GYRO_X", "GYRO_Y", "GYRO_Z"].map(|name| format!("{:.1},{name},0.1\n", sample.time_s))
    });
    let text = format!("time,channel,value\n{}", rows.collect::<String>());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.csv");
    std::fs::write(&path, &text).unwrap();
    let source = log_file::read(&path, &Default::default()).unwrap();
    let error = guess::draft("long.csv", &source).unwrap_err().to_string();
    assert!(error.contains("`channel` names a channel in each row"), "{error}");
}

#[test]
fn own_log_needs_no_confirmation() {
    let header =
        "t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,wheel_1_rad_s,wheel_2_rad_s,wheel_3_rad_s";
    let text = log(header, |sample| {
        let [x, y, z] = sample.rate_rad_s;
        let [a, b, c] = sample.wheels_rad_s;
        format!("{},{x},{y},{z},{a},{b},{c}", sample.time_s)
    });
    let (draft, log) = read("log.csv", &text);
    assert_motion(&log, 3, 1e-12);
    assert!(!draft.contains("# CONFIRM"), "{draft}");
}

#[test]
fn time_under_a_wrong_name_is_found_by_its_values() {
    let header = "t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s";
    for (factor, origin, reason) in
        [(1e3, 0, "CONFIRM: by its increments"), (1e9, 1_700_000_000, "as a time since 1970")]
    {
        let text = log(header, |sample| {
            let [x, y, z] = sample.rate_rad_s;
            let time = origin * 1_000_000_000 + (sample.time_s * factor).round() as u64;
            format!("{time},{x},{y},{z}")
        });
        let (draft, log) = read("log.csv", &text);
        assert_motion(&log, 0, 1e-12);
        assert!(draft.contains(reason), "{draft}");
    }
}

#[test]
fn units_row_and_counts() {
    let header = "T;P;Q;R\n[ms];[deg/s];[deg/s];[deg/s]";
    let text = log(header, |sample| {
        let [x, y, z] = deg(sample.rate_rad_s).map(|rate| rate / 0.0625);
        format!("{};{x};{y};{z}", (sample.time_s * 1e3).round())
    });
    let source = text.clone();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("counts.csv");
    std::fs::write(&path, source).unwrap();
    let craft = "[log]\ntime = \"T\"\ntime_unit = \"ms\"\n[log.gyro]\ncolumns = [\"P\", \"Q\", \"R\"]\n\
                 unit = \"deg/s\"\nscale = 0.0625\n";
    let craft = Craft::from_toml("craft.toml", craft).unwrap();
    assert_motion(&log_file::load(&path, &craft).unwrap(), 0, 1e-12);
}
