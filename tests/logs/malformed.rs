//! Malformed files. A message names the file and the line or column, the fault, and the remedy. A log
//! with usable rows is read: the other rows are counted by reason, and named in a note.

use host_sim::input::{Craft, InputError, RecordedLog, log_file};

const HEADER: &str = "t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s";

/// A log with rows at 10 Hz, some replaced.
fn log(rows: usize, replaced: &[(usize, &str)]) -> Vec<u8> {
    let row = |index: usize| match replaced.iter().find(|(at, _)| *at == index) {
        Some((_, text)) => (*text).to_owned(),
        None => format!("{}.{},0.{index},0.2,0.3", index / 10, index % 10),
    };
    let rows: Vec<String> = (0..rows).map(row).collect();
    format!("{HEADER}\n{}\n", rows.join("\n")).into_bytes()
}

fn load(bytes: &[u8], craft: &str) -> Result<RecordedLog, InputError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    std::fs::write(&path, bytes).unwrap();
    log_file::load(&path, &Craft::from_toml("craft.toml", craft).unwrap())
}

/// A log that is refused, and parts of its message.
struct Refused {
    name: &'static str,
    bytes: Vec<u8>,
    craft: &'static str,
    message: &'static [&'static str],
}

fn refused(
    name: &'static str,
    bytes: impl Into<Vec<u8>>,
    craft: &'static str,
    message: &'static [&'static str],
) -> Refused {
    Refused { name, bytes: bytes.into(), craft, message }
}

const WHEEL: &str = "[[wheel]]\naxis = [1, 0, 0]\nspin_inertia_kg_m2 = 1e-5\n";
const MAPPED: &str = "[log]\ntime = \"t\"\n[log.gyro]\ncolumns = [\"x\", \"y\", \"z\"]\n";

#[rustfmt::skip]
fn refused_logs() -> Vec<Refused> {
    let stamps = |stamp: fn(usize) -> String| {
        let row = |index| format!("{},0.{index},0.2,0.3\n", stamp(index));
        format!("{HEADER}\n{}", (0..40).map(row).collect::<String>())
    };
    vec![
        refused("empty", "", "", &["log.csv: the file is empty", "the first line must name the columns"]),
        refused("blank lines", "\n \n\n", "", &["log.csv: the file is empty"]),
        refused("header alone", format!("{HEADER}\n"), "", &["log.csv: no row follows the header"]),
        refused("comments alone", "# a\n# b\n", "", &["log.csv: no row follows the header"]),
        refused("no header", "0,0.1,0.2,0.3\n0.1,0.1,0.2,0.3\n", "", &["log.csv:1: the first row has numbers only", "must name the columns"]),
        refused("other names", "time,wx,wy,wz\n0,1,2,3\n", "", &["log.csv:1: no column `t_s`", "[log] of the craft file", "init --from", "time, wx, wy, wz"]),
        refused("one axis missing", "t_s,gyro_x_rad_s,gyro_z_rad_s\n0,1,3\n", "", &["log.csv:1: no column `gyro_y_rad_s`"]),
        refused("column twice", format!("{HEADER},gyro_x_rad_s\n0,1,2,3,4\n"), "", &["log.csv:1: column `gyro_x_rad_s` appears twice", "remove or rename one"]),
        refused("no wheel in the log", log(9, &[]), WHEEL, &["log.csv:1: wheel columns of the log: 0, [[wheel]] tables of the craft file: 1", "[log.wheels]"]),
        refused("no wheel in the craft", format!("{HEADER},wheel_1_rad_s\n0,1,2,3,4\n"), "", &["log.csv:1: wheel columns of the log: 1", "add one [[wheel]] table"]),
        refused("mapped column missing", "t,x,y,w\n0,1,2,3\n", MAPPED, &["log.csv:1: no column `z`", "the columns are: t, x, y, w"]),
        refused("only words", format!("{HEADER}\na,b,c,d\ne,f,g,h\n"), "", &["log.csv:2: column `gyro_x_rad_s`: \"b\" is not a number"]),
        refused("every row short", format!("{HEADER}\n0,1\n1,2\n"), "", &["log.csv:2: 2 cells, but the header names 4 columns", "complete or remove the row"]),
        refused("decimal commas between commas", format!("{HEADER}\n0,0,0,1,0,2,0,3\n0,1,0,1,0,2,0,3\n"), "", &["log.csv:2: 8 cells, but the header names only 4 columns", "decimal commas require semicolons or tabs"]),
        refused("time backwards", stamps(|i| (400 - i).to_string()), "", &["log.csv:3: column `t_s`: time runs backwards, from 400 to 399", "sort the rows"]),
        refused("few digits", stamps(|_| "1.7e9".to_owned()), "", &["log.csv:3: column `t_s`: time stamps have too few digits: 39 of 40", "export the column with all its digits"]),
        refused("time in a unit too small", stamps(|i| format!("0.00000{:02}", i)), "", &["log.csv:", "fall on the same microsecond", "check that the unit is the second"]),
        refused("american dates", stamps(|i| format!("05/01/2024 12:00:{i:02}")), "", &["log.csv:2: column `t_s`: \"05/01/2024 12:00:00\" is not a known form of a date", "ISO 8601"]),
        refused("infinite", format!("{HEADER}\n0,inf,0,0\n1,inf,0,0\n"), "", &["log.csv:2: column `gyro_x_rad_s`: inf is not a finite number"]),
        refused("not text", b"\x7fELF\x02\x01\x01\0\0\0\0".to_vec(), "", &["log.csv:1: not text", "CSV or Parquet"]),
        refused("spreadsheet", b"PK\x03\x04\x14\0\x06\0".to_vec(), "", &["log.csv:1: not text", "CSV or Parquet"]),
        refused("damaged gzip", b"\x1f\x8b\x08\0\xff\xff\xff\xff\0\0".to_vec(), "", &["log.csv: cannot be read: "]),
        refused("damaged Parquet", b"PAR1\0\0\0\0\x04\0\0\0PAR1".to_vec(), "", &["log.csv: cannot be read: "]),
    ]
}

#[test]
fn unusable_logs_are_refused() {
    for Refused { name, bytes, craft, message } in refused_logs() {
        let error = load(&bytes, craft).expect_err(name).to_string();
        let error = error.rsplit_once('/').map_or(error.as_str(), |(_, end)| end);
        let whole = load(&bytes, craft).unwrap_err().to_string();
        for part in message {
            assert!(whole.contains(part), "{name}: {error}\n  expected: {part}");
        }
        assert!(whole.lines().count() <= 2, "{name}: {whole}");
    }
}

/// Damage of some rows of a log: its name, rows with their new text, what is counted, and what the note names.
type Damage =
    (&'static str, &'static [(usize, &'static str)], &'static [(&'static str, u64)], &'static str);

#[rustfmt::skip]
const DAMAGED: [Damage; 10] = [
    ("cut row", &[(29, "2.9,1,2")], &[("incomplete", 1)], "line 31: the file is cut in mid-row"),
    ("empty cell", &[(3, "0.3,,0.2,0.3")], &[("empty_cell", 1)], "line 5: column `gyro_x_rad_s` is empty"),
    ("NaN", &[(3, "0.3,nan,0.2,0.3")], &[("not_finite", 1)], "line 5: column `gyro_x_rad_s`: nan"),
    ("word", &[(3, "0.3,N/A,0.2,0.3")], &[("not_a_number", 1)], "line 5: column `gyro_x_rad_s`: \"N/A\""),
    ("cell too many", &[(3, "0.3,1,0.2,0.3,7")], &[("surplus_cells", 1)], "line 5: 5 cells"),
    ("open quote", &[(3, "0.3,\"1,0.2,0.3")], &[("not_a_number", 1)], "line 5: column `gyro_x_rad_s`: \"\"1\""),
    ("stamp a day ahead", &[(3, "86400,1,0.2,0.3")], &[("time_ahead", 1)], "line 5: column `t_s`: 86400 is ahead"),
    ("row twice", &[(3, "0.2,0.2,0.2,0.3")], &[("repeated_row", 1)], "line 5: the row is equal to the previous one"),
    ("header again", &[(3, HEADER)], &[("repeated_header", 1)], "line 5: the names of the columns again"),
    ("three faults", &[(3, "x,1,2,3"), (5, "0.5"), (9, "0.9,,,")], &[("empty_cell", 1), ("incomplete", 1), ("not_a_number", 1)], "line 5: column `t_s`: \"x\" is not a number; line 7: 1 cells"),
];

#[test]
fn damaged_rows_are_counted_and_named() {
    const ROWS: usize = 30;
    for (name, replaced, counts, note) in DAMAGED {
        let log = load(&log(ROWS, replaced), "").unwrap_or_else(|error| panic!("{name}: {error}"));
        let counted: Vec<(&str, u64)> =
            log.skipped_rows.iter().map(|(reason, rows)| (*reason, *rows)).collect();
        assert_eq!(counted, counts, "{name}");
        let skipped: u64 = log.skipped_rows.values().sum();
        assert_eq!(log.rows.len() + skipped as usize, ROWS, "{name}: nothing is lost");
        assert!(log.notes.iter().any(|found| found.contains(note)), "{name}: {:?}", log.notes);
    }
}

/// Craft files that are refused, and parts of the message.
#[rustfmt::skip]
const CRAFTS: [(&str, &[&str]); 16] = [
    ("[[wheel]\n", &["craft.toml:1: not valid TOML", "correct the line"]),
    ("[gyro]\nnoise_rad_s = 1,5\n", &["craft.toml:2: not valid TOML", "noise_rad_s = 1,5"]),
    ("[gyro]\nnoise_rad_s = \"1e-4\"\n", &["craft.toml:2: wrong type of value", "expected a number"]),
    ("[gyro]\nnoise = 1e-4\n", &["craft.toml:2: unknown key `noise`", "did you mean `noise_rad_s`?"]),
    ("[gyro]\nnoise_rad_s = -1\n", &["craft.toml:2: `gyro.noise_rad_s` is -1; it must be positive"]),
    ("[gyros]\n", &["craft.toml:1: unknown key `gyros`", "did you mean `gyro`?"]),
    ("gyro = 3\n", &["craft.toml:1: wrong type of value", "expected a table"]),
    ("[[wheel]]\naxis = [0, 0, 0]\nspin_inertia_kg_m2 = 1e-5\n", &["craft.toml:2: `wheel[1].axis` is [0, 0, 0]", "at least one entry other than zero"]),
    ("[[wheel]]\naxis = [1, 0]\nspin_inertia_kg_m2 = 1e-5\n", &["craft.toml:2: `wheel[1].axis` has 2 entries, but takes 3"]),
    ("[[wheel]]\naxis = [1, 0, 0]\nspin_inertia_kg_m2 = 0\n", &["craft.toml:3: `wheel[1].spin_inertia_kg_m2` is 0; it must be positive"]),
    ("[[wheel]]\naxis = [1, 0, 0]\n", &["craft.toml:1: missing key `spin_inertia_kg_m2`", "add it"]),
    ("[prior]\ninertia_kg_m2 = [1, 1, 3, 0, 0, 0]\nsigma_kg_m2 = [1, 1, 1, 1, 1, 1]\n", &["craft.toml:2: `prior.inertia_kg_m2`", "not the inertia of a rigid body", "check signs, unit"]),
    ("[log]\ntime_unit = \"fortnights\"\n", &["craft.toml:2: unknown word \"fortnights\"", "allowed here: s, ms, us, ns, min, h, d, week, utc"]),
    ("[log.gyro]\ncolumns = [\"x\", \"y\"]\n", &["craft.toml:2: `log.gyro.columns` has 2 entries, but takes 3"]),
    ("[log.gyro]\ncolumns = [\"x\", \"y\", \"z\"]\nunit = \"deg\"\n", &["craft.toml:3: unknown word \"deg\"", "allowed here: rad/s"]),
    ("[log.wheels]\ncolumns = [\"rw1\"]\nunit = \"rpm\"\n", &["craft.toml:2: `log.wheels.columns` has 1 entries, but takes 0"]),
];

#[test]
fn malformed_craft_files_are_refused() {
    for (text, message) in CRAFTS {
        let error = Craft::from_toml("craft.toml", text).expect_err(text).to_string();
        for part in message {
            assert!(error.contains(part), "{text}: {error}\n  expected: {part}");
        }
    }
}
