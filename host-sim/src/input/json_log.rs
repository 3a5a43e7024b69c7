//! Logs as JSON: an object for each line, a list of objects, or one object of columns.
//!
//! Members of an object have names with points, `imu.rate`, and elements of a list `rate[0]`, as in Parquet. A line that
//! is no object is a row at fault. A column is a list, or an object by row number as pandas writes it.

use std::collections::HashMap;

use csv::StringRecord;
use flight_input::InputError;
use flight_input::csv_source::{CsvSource, MAX_ROWS};
use flight_input::error::{Place, Problem};
use serde_json::Value;

/// Most columns of a log.
const MAX_COLUMNS: usize = 10_000;

/// True for a text that begins as JSON does.
pub(super) fn is_json(bytes: &[u8]) -> bool {
    let start = bytes.iter().find(|byte| !byte.is_ascii_whitespace());
    // `[` may begin the name of a column.
    match start {
        Some(b'{') => true,
        Some(b'[') => bytes.iter().filter(|byte| !byte.is_ascii_whitespace()).nth(1) == Some(&b'{'),
        _ => false,
    }
}

/// The table of a JSON text.
///
/// # Errors
/// No object, too many rows or columns, a list that is not closed.
pub(super) fn read(file: &str, bytes: &[u8]) -> Result<CsvSource, InputError> {
    let failed = |line, message: String| InputError {
        place: Place { file: file.to_owned(), line },
        problem: Problem::Unreadable(std::io::Error::other(message)),
    };
    if let Some((columns, records)) = serde_json::from_slice(bytes).ok().and_then(columns_of) {
        return CsvSource::from_records(file, columns, records);
    }
    let mut table = Table::default();
    if bytes.trim_ascii_start().starts_with(b"[") {
        let list: Vec<Value> = serde_json::from_slice(bytes)
            .map_err(|error| failed(Some(error.line() as u64), error.to_string()))?;
        list.iter().for_each(|value| table.add(Some(value)));
    } else {
        for line in bytes.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii) {
            if !line.is_empty() {
                table.add(serde_json::from_slice(line).ok().as_ref());
            }
        }
    }
    if table.rows.len() > MAX_ROWS || table.columns.len() > MAX_COLUMNS {
        let (rows, columns) = (table.rows.len(), table.columns.len());
        let limits = format!("at most {MAX_ROWS} rows and {MAX_COLUMNS} columns are read");
        return Err(failed(None, format!("{rows} rows of {columns} columns; {limits}")));
    }
    if table.columns.is_empty() {
        let message =
            "no JSON object in a line; write an object for each sample, as {\"t_s\": 0.1, …}";
        return Err(failed(Some(1), message.to_owned()));
    }
    let columns = table.columns.len();
    let records = table.rows.into_iter().map(|row| record(row, columns)).collect();
    CsvSource::from_records(file, table.columns, records)
}

/// Names and rows of one object of columns: lists, or objects by row number, all of one length of at least two.
fn columns_of(value: Value) -> Option<(Vec<String>, Vec<StringRecord>)> {
    let Value::Object(members) = value else { return None };
    let cell = |value: Value| match value {
        Value::Null => Some(String::new()),
        Value::String(text) => Some(text),
        Value::Array(_) | Value::Object(_) => None,
        other => Some(other.to_string()),
    };
    let cells = |column: Value| match column {
        Value::Array(values) => values.into_iter().map(cell).collect::<Option<Vec<String>>>(),
        Value::Object(rows) => {
            let number = |(row, value): (String, Value)| Some((row.parse::<u64>().ok()?, value));
            let mut rows: Vec<(u64, Value)> =
                rows.into_iter().map(number).collect::<Option<_>>()?;
            rows.sort_by_key(|(row, _)| *row);
            rows.into_iter().map(|(_, value)| cell(value)).collect()
        }
        _ => None,
    };
    let mut names = Vec::new();
    let mut columns = Vec::new();
    for (name, column) in members {
        names.push(name);
        columns.push(cells(column)?);
    }
    let rows = columns.first()?.len();
    let is_table = rows > 1 && rows <= MAX_ROWS && columns.iter().all(|c| c.len() == rows);
    let record = |row: usize| columns.iter().map(|column| column[row].as_str()).collect();
    is_table.then(|| (names, (0..rows).map(record).collect()))
}

/// Cells by column; none for a line that is no object.
type Row = Option<Vec<(usize, String)>>;

/// Rows with the columns that they have.
#[derive(Default)]
struct Table {
    columns: Vec<String>,
    places: HashMap<String, usize>,
    rows: Vec<Row>,
}

impl Table {
    fn add(&mut self, value: Option<&Value>) {
        let row = value.filter(|value| value.is_object()).map(|value| {
            let mut row = Vec::new();
            self.flatten("", value, &mut row);
            row
        });
        self.rows.push(row);
    }

    fn flatten(&mut self, name: &str, value: &Value, row: &mut Vec<(usize, String)>) {
        match value {
            Value::Object(members) => {
                let point = if name.is_empty() { "" } else { "." };
                for (inner, value) in members {
                    self.flatten(&format!("{name}{point}{inner}"), value, row);
                }
            }
            Value::Array(elements) => {
                for (index, value) in elements.iter().enumerate() {
                    self.flatten(&format!("{name}[{index}]"), value, row);
                }
            }
            Value::Null => {}
            Value::String(text) => row.push((self.place(name), text.clone())),
            other => row.push((self.place(name), other.to_string())),
        }
    }

    fn place(&mut self, name: &str) -> usize {
        if let Some(place) = self.places.get(name) {
            return *place;
        }
        self.columns.push(name.to_owned());
        self.places.insert(name.to_owned(), self.columns.len() - 1);
        self.columns.len() - 1
    }
}

/// A row with all columns. One cell too many marks a line that is no object.
fn record(row: Row, columns: usize) -> StringRecord {
    let Some(cells) = row else { return StringRecord::from(vec![""; columns + 1]) };
    let mut texts = vec![String::new(); columns];
    for (place, text) in cells {
        texts[place] = text;
    }
    StringRecord::from(texts)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(text: &str) -> (Vec<String>, Vec<Vec<String>>) {
        let source = read("log.jsonl", text.as_bytes()).unwrap();
        let rows = source.rows().iter().map(|row| row.cells().iter().map(str::to_owned).collect());
        (source.columns().to_vec(), rows.collect())
    }

    #[test]
    fn members_and_elements_are_columns() {
        let line =
            |t| format!("{{\"t\": {t}, \"imu\": {{\"w\": [0.5, -1e-7, null]}}, \"ok\": true}}");
        let lines = format!("{}\n\n{}\n", line("1743296360000000001"), line("2"));
        let list = format!(" [{},\n {}]", line("1743296360000000001"), line("2"));
        for text in [lines, list] {
            assert!(is_json(text.as_bytes()));
            let (columns, rows) = cells(&text);
            assert_eq!(columns, ["imu.w[0]", "imu.w[1]", "ok", "t"]);
            assert_eq!(rows[0], ["0.5", "-1e-7", "true", "1743296360000000001"]);
            assert_eq!(rows[1][3], "2");
        }
    }

    /// pandas: `to_json(orient="list")` by way of a dictionary, and `to_json()`, whose rows are not in order as texts.
    #[test]
    fn one_object_of_columns_is_a_table() {
        let number = |row: usize| format!("\"{row}\": {row}.5");
        let by_number: Vec<String> = (0..12).map(number).collect();
        let by_number = by_number.join(", ");
        let list: Vec<String> = (0..12).map(|row| format!("{row}.5")).collect();
        let list = list.join(", ");
        for text in [
            format!("{{\"t\": [{list}], \"wx\": [{list}]}}"),
            format!("{{\"t\": {{{by_number}}},\n \"wx\": {{{by_number}}}}}"),
        ] {
            let (columns, rows) = cells(&text);
            assert_eq!(columns, ["t", "wx"]);
            assert_eq!(
                (rows.len(), &rows[2], &rows[11][0]),
                (12, &rows_of("2.5"), &"11.5".to_owned())
            );
        }
        // Lists of unequal length, or one sample with a vector, are no columns.
        assert_eq!(cells("{\"t\": 1, \"w\": [1, 2]}").1.len(), 1);
        assert_eq!(cells("{\"t\": [1], \"w\": [1, 2]}").1.len(), 1);
    }

    fn rows_of(cell: &str) -> Vec<String> {
        vec![cell.to_owned(); 2]
    }

    #[test]
    fn absent_members_are_empty_and_a_cut_line_is_at_fault() {
        let (columns, rows) = cells("{\"a\": 1}\n{\"b\": 2}\n{\"a\": 3, \"b\"");
        assert_eq!(columns, ["a", "b"]);
        assert_eq!(rows, [vec!["1", ""], vec!["", "2"], vec!["", "", ""]]);
    }

    #[test]
    fn texts_without_an_object_are_rejected() {
        for (text, part) in
            [("{", "no JSON object"), ("[{\"a\": 1}", "EOF"), ("{}", "no JSON object")]
        {
            let error = read("log.json", text.as_bytes()).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
        assert!(!is_json(b"[t],[wx]\n1,2\n") && !is_json(b"t,wx\n"));
    }
}
