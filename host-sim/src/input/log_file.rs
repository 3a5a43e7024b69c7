//! Logs as files: CSV, plain or compressed by gzip, Parquet, JSON, or standard input.
//!
//! The kind of a file is that of its first bytes, whatever its name. A Parquet file becomes a table of
//! texts as a CSV file is, with the shortest decimals that read back as the same numbers; its rows count
//! from 1 in messages.

use std::io;
use std::path::{Path, PathBuf};

use csv::StringRecord;
use flate2::read::MultiGzDecoder;
use flight_input::craft::{Craft, LogFormat, SensorFormat};
use flight_input::csv_dialect::CsvOptions;
use flight_input::csv_source::CsvSource;
use flight_input::error::{Place, Problem};
use flight_input::log::LogTables;
use flight_input::text::{checked_size, read_all, read_bytes, read_up_to};
use flight_input::{InputError, RecordedLog};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;

use super::json_log;

/// Name of standard input.
const STDIN: &str = "-";
/// First bytes of a gzip file.
const GZIP: [u8; 2] = [0x1f, 0x8b];
/// First bytes of a Parquet file.
const PARQUET: &[u8] = b"PAR1";
/// Endings of the names of logs in a folder.
const ENDINGS: [&str; 10] =
    ["csv", "txt", "tsv", "dat", "gz", "parquet", "pq", "log", "jsonl", "ndjson"];

/// The log at `path` in the format that the craft states.
///
/// # Errors
/// A file cannot be read, or is no log of this format.
pub fn load(path: &Path, craft: &Craft) -> Result<RecordedLog, InputError> {
    let format = &craft.log;
    let beside = |sensor: &Option<SensorFormat>| {
        let file = sensor.as_ref().and_then(|sensor| sensor.file.as_deref());
        file.map(|file| read(&companion(path, format, file), &format.csv)).transpose()
    };
    let tables = LogTables {
        log: read(path, &format.csv)?,
        wheels: beside(&format.wheels)?,
        torque: beside(&format.torque)?,
        attitude: beside(&format.attitude)?,
    };
    RecordedLog::from_tables(&tables, format, craft.wheels.len())
}

/// A log of columns in the format that the craft states; `name` is that of the log in errors. Columns have the cells that
/// a CSV file has, and equal lengths.
///
/// # Errors
/// The columns are no log of this format.
pub fn of_columns(
    name: &str,
    columns: Vec<String>,
    cells: &[Vec<String>],
    craft: &Craft,
) -> Result<RecordedLog, InputError> {
    let source = source_of_columns(name, columns, cells)?;
    RecordedLog::from_tables(&source.into(), &craft.log, craft.wheels.len())
}

/// The table of columns, as of [`of_columns`].
///
/// # Errors
/// No rows.
pub fn source_of_columns(
    name: &str,
    columns: Vec<String>,
    cells: &[Vec<String>],
) -> Result<CsvSource, InputError> {
    let rows = cells.iter().map(Vec::len).min().unwrap_or(0);
    let record = |row: usize| cells.iter().map(|column| column[row].as_str()).collect();
    let records: Vec<StringRecord> = (0..rows).map(record).collect();
    CsvSource::from_records(name, columns, records)
}

/// The table in a file of any kind.
///
/// # Errors
/// The file cannot be read, or has no rows.
pub fn read(path: &Path, options: &CsvOptions) -> Result<CsvSource, InputError> {
    let (file, bytes) = if path == Path::new(STDIN) {
        ("standard input".to_owned(), read_all("standard input", io::stdin())?)
    } else {
        (path.display().to_string(), read_bytes(path)?)
    };
    decode(&file, bytes, options)
}

fn decode(file: &str, bytes: Vec<u8>, options: &CsvOptions) -> Result<CsvSource, InputError> {
    if bytes.starts_with(&GZIP) {
        return decode(file, unzip(file, &bytes)?, options);
    }
    if bytes.starts_with(PARQUET) {
        return parquet(file, bytes);
    }
    if json_log::is_json(&bytes) {
        return json_log::read(file, &bytes);
    }
    CsvSource::decode_unchecked(file, &bytes, options)
}

/// The content of a gzip file. One that is cut gives what there is of it.
fn unzip(file: &str, bytes: &[u8]) -> Result<Vec<u8>, InputError> {
    let mut content = Vec::new();
    match read_up_to(MultiGzDecoder::new(bytes), &mut content) {
        Err(error) if content.is_empty() => Err(unreadable(file, error)),
        _ => checked_size(file, content),
    }
}

fn unreadable(file: &str, error: io::Error) -> InputError {
    let place = Place { file: file.to_owned(), line: None };
    InputError { place, problem: Problem::Unreadable(error) }
}

/// The table of a Parquet file. Nested columns have names with points.
fn parquet(file: &str, bytes: Vec<u8>) -> Result<CsvSource, InputError> {
    let failed = |error: parquet::errors::ParquetError| unreadable(file, io::Error::other(error));
    let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).map_err(failed)?;
    let mut columns = Vec::new();
    let mut records = Vec::new();
    for row in reader.get_row_iter(None).map_err(failed)? {
        let row = row.map_err(failed)?;
        let mut cells = Vec::new();
        row.get_column_iter().for_each(|(name, field)| flatten(name, field, &mut cells));
        if columns.is_empty() {
            columns = cells.iter().map(|(name, _)| name.clone()).collect();
        }
        records.push(cells.into_iter().map(|(_, text)| text).collect::<StringRecord>());
    }
    CsvSource::from_records(file, columns, records)
}

/// The cells of a field: one, or those of a group or list. Times are in seconds since 1970.
fn flatten(name: &str, field: &Field, cells: &mut Vec<(String, String)>) {
    let mut cell = |text: String| cells.push((name.to_owned(), text));
    match field {
        Field::Null => cell(String::new()),
        // Debug: the shortest decimal that reads back as the same number.
        Field::Float(value) => cell(format!("{value:?}")),
        Field::Double(value) => cell(format!("{value:?}")),
        Field::Str(text) => cell(text.clone()),
        Field::TimestampMillis(value) => cell(format!("{}.{:03}", value / 1000, value % 1000)),
        Field::TimestampMicros(value) => {
            cell(format!("{}.{:06}", value / 1_000_000, value % 1_000_000));
        }
        Field::Group(row) => {
            row.get_column_iter()
                .for_each(|(inner, field)| flatten(&format!("{name}.{inner}"), field, cells));
        }
        Field::ListInternal(list) => {
            for (index, field) in list.elements().iter().enumerate() {
                flatten(&format!("{name}[{index}]"), field, cells);
            }
        }
        other => cell(other.to_string()),
    }
}

/// The file of a sensor beside the log at `path`: `*` of its name stands for the text that `*` of
/// `[log] file` stands for, or for the name of the log without its ending.
fn companion(path: &Path, format: &LogFormat, file: &str) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let stated = format.file.as_deref().and_then(|pattern| star(pattern, &name));
    let stem = stated.unwrap_or_else(|| name.split('.').next().unwrap_or_default());
    path.with_file_name(file.replace('*', stem))
}

/// Text for which `*` of a pattern stands in a name; none if the name is another.
fn star<'a>(pattern: &str, name: &'a str) -> Option<&'a str> {
    match pattern.split_once('*') {
        Some((start, end)) => name.strip_prefix(start)?.strip_suffix(end),
        None => (pattern == name).then_some(""),
    }
}

/// The logs that a path of the command line stands for: itself, or the logs of a folder by name, those
/// of `[log] file` where stated.
///
/// # Errors
/// The folder cannot be read, or has no log.
pub fn expand(path: &Path, format: &LogFormat) -> Result<Vec<PathBuf>, InputError> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let file = path.display().to_string();
    let entries = std::fs::read_dir(path).map_err(|error| unreadable(&file, error))?;
    let own = [&format.wheels, &format.torque, &format.attitude];
    let is_companion = |name: &str| {
        let files = own.iter().filter_map(|sensor| sensor.as_ref()?.file.as_deref());
        files.into_iter().any(|pattern| star(pattern, name).is_some())
    };
    let is_log = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match &format.file {
            Some(pattern) => star(pattern, &name).is_some(),
            None => ENDINGS.contains(&ending.as_str()) && !is_companion(&name),
        }
    };
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut logs: Vec<PathBuf> = paths.filter(|path| path.is_file() && is_log(path)).collect();
    logs.sort();
    if logs.is_empty() {
        let wanted = format.file.clone().unwrap_or_else(|| format!("*.{}", ENDINGS.join(", *.")));
        let problem = Problem::NoLogs { wanted };
        return Err(InputError { place: Place { file, line: None }, problem });
    }
    Ok(logs)
}

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::sync::Arc;

    use flate2::write::GzEncoder;
    use parquet::data_type::{DoubleType, Int64Type};
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;

    use super::*;

    const LOG: &str = "t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s\n0,1,2,3\n0.1,4,5,0.6\n";

    fn zipped(text: &str) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(text.as_bytes()).unwrap();
        encoder.finish().unwrap()
    }

    fn log(bytes: Vec<u8>) -> Result<RecordedLog, InputError> {
        let source = decode("log", bytes, &CsvOptions::default())?;
        RecordedLog::from_tables(&source.into(), &LogFormat::default(), 0)
    }

    /// A Parquet file with the columns of a log.
    fn parquet_file(codec: parquet::basic::Compression) -> Vec<u8> {
        let schema = "message log { required int64 t_s (TIMESTAMP(MICROS,true)); \
                      required double gyro_x_rad_s; required double gyro_y_rad_s; \
                      optional double gyro_z_rad_s; }";
        let schema = Arc::new(parse_message_type(schema).unwrap());
        let properties = WriterProperties::builder().set_compression(codec).build();
        let mut writer =
            SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties)).unwrap();
        let mut group = writer.next_row_group().unwrap();
        let mut column = group.next_column().unwrap().unwrap();
        let times = [1_700_000_000_000_000, 1_700_000_000_100_000, 1_700_000_000_200_000];
        column.typed::<Int64Type>().write_batch(&times, None, None).unwrap();
        column.close().unwrap();
        for values in [[1.0, 4.0, 7.0], [2.0, 5.0, 8.0], [3.0, 0.6, f64::NAN]] {
            let mut column = group.next_column().unwrap().unwrap();
            let levels = values.map(|value| i16::from(!value.is_nan()));
            let defined =
                values.iter().filter(|value| !value.is_nan()).copied().collect::<Vec<_>>();
            column.typed::<DoubleType>().write_batch(&defined, Some(&levels), None).unwrap();
            column.close().unwrap();
        }
        group.close().unwrap();
        writer.into_inner().unwrap()
    }

    #[test]
    fn kinds_of_files_are_known_by_their_bytes() {
        let plain = log(LOG.as_bytes().to_vec()).unwrap();
        assert_eq!(log(zipped(LOG)).unwrap().rows, plain.rows);
        for codec in [
            parquet::basic::Compression::UNCOMPRESSED,
            parquet::basic::Compression::SNAPPY,
            parquet::basic::Compression::ZSTD(Default::default()),
        ] {
            let of_parquet = log(parquet_file(codec)).unwrap();
            let values = |log: &RecordedLog| {
                log.rows.iter().map(|row| (row.time_us, row.rate_rad_s)).collect::<Vec<_>>()
            };
            assert_eq!(values(&of_parquet), values(&plain));
            assert_eq!(of_parquet.start_s, 1.7e9);
            assert_eq!(
                of_parquet.skipped_rows.get("incomplete"),
                Some(&1),
                "{:?}",
                of_parquet.skipped_rows
            );
        }
    }

    #[test]
    fn damaged_files_are_named() {
        let whole = zipped(&LOG.repeat(50));
        assert!(log(whole[..whole.len() - 9].to_vec()).is_ok());
        let message = log(whole[..6].to_vec()).unwrap_err().to_string();
        assert!(message.starts_with("log: cannot be read: "), "{message}");
        let cut = parquet_file(parquet::basic::Compression::SNAPPY)[..100].to_vec();
        let message = log(cut).unwrap_err().to_string();
        assert!(message.starts_with("log: cannot be read: "), "{message}");
    }

    #[test]
    fn companion_has_the_text_of_the_star() {
        let mut format = LogFormat::default();
        let of = |format: &LogFormat, file| companion(Path::new("logs/a_gyro.csv"), format, file);
        assert_eq!(of(&format, "*.rw.csv"), Path::new("logs/a_gyro.rw.csv"));
        format.file = Some("*_gyro.csv".to_owned());
        assert_eq!(of(&format, "*_rw.csv"), Path::new("logs/a_rw.csv"));
        assert_eq!(of(&format, "rw.csv"), Path::new("logs/rw.csv"));
    }

    #[test]
    fn logs_of_a_folder_are_found_by_name() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b_gyro.csv", "a_gyro.csv", "a_rw.csv", "notes.md"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let names = |format: &LogFormat| {
            let paths = expand(folder.path(), format).unwrap();
            let name = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
            paths.iter().map(name).collect::<Vec<_>>()
        };
        let mut format = LogFormat::default();
        assert_eq!(names(&format), ["a_gyro.csv", "a_rw.csv", "b_gyro.csv"]);
        format.file = Some("*_gyro.csv".to_owned());
        assert_eq!(names(&format), ["a_gyro.csv", "b_gyro.csv"]);
        format.file = Some("*.mat".to_owned());
        let message = expand(folder.path(), &format).unwrap_err().to_string();
        assert!(message.contains("no log in this folder; wanted: *.mat"), "{message}");
    }
}
