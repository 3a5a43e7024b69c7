//! A table of named columns, as CSV and as Parquet.

use std::fs::File;
use std::io::{self, BufWriter};
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::{ByteArray, DataType};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::RowGroupReader;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

/// Columns of equal length.
#[derive(Clone, Debug, Default)]
pub(super) struct Frame {
    columns: Vec<(String, Cells)>,
}

/// Cells of a column; none for a missing value.
#[derive(Clone, Debug)]
pub enum Cells {
    /// Whole numbers.
    Count(Vec<Option<u64>>),
    /// Numbers.
    Number(Vec<Option<f64>>),
    /// Texts.
    Text(Vec<Option<String>>),
    /// True or false.
    Flag(Vec<Option<bool>>),
}

impl Frame {
    /// The columns by name.
    pub fn into_columns(self) -> Vec<(String, Cells)> {
        self.columns
    }

    /// Adds a column.
    pub fn add(&mut self, name: impl Into<String>, cells: Cells) {
        self.columns.push((name.into(), cells));
    }

    /// The cells of a column; none if there is no such column.
    pub fn column(&self, name: &str) -> Option<&Cells> {
        self.columns.iter().find(|(found, _)| found == name).map(|(_, cells)| cells)
    }

    /// Names of the columns.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|(name, _)| name.as_str())
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, cells)| cells.len())
    }

    /// Writes the table as CSV. A missing value is an empty cell. Numbers have the fewest digits that read back as the
    /// same `f64`.
    pub fn write_csv<W: io::Write>(&self, out: W) -> io::Result<()> {
        let mut out = csv::Writer::from_writer(out);
        self.write_csv_header(&mut out)?;
        self.write_csv_rows(&mut out)?;
        out.flush()
    }

    /// Writes the names of the columns.
    pub fn write_csv_header<W: io::Write>(&self, out: &mut csv::Writer<W>) -> io::Result<()> {
        Ok(out.write_record(self.names())?)
    }

    /// Writes the rows.
    pub fn write_csv_rows<W: io::Write>(&self, out: &mut csv::Writer<W>) -> io::Result<()> {
        for row in 0..self.rows() {
            out.write_record(self.columns.iter().map(|(_, cells)| cells.text(row)))?;
        }
        Ok(())
    }

    /// Writes the table as Parquet of one row group: see [`ParquetFile`].
    pub fn write_parquet(&self, out: BufWriter<File>) -> io::Result<()> {
        let mut file = ParquetFile::create(out, self)?;
        file.write(self)?;
        file.close(&[])?;
        Ok(())
    }

    /// Reads a row group of a file that [`ParquetFile`] has written.
    pub fn read(group: &dyn RowGroupReader) -> Result<Self, ParquetError> {
        let rows = group.metadata().num_rows() as usize;
        let mut frame = Self::default();
        for i in 0..group.num_columns() {
            let column = group.metadata().column(i).column_descr_ptr();
            frame.add(column.name(), Cells::read(group.get_column_reader(i)?, rows)?);
        }
        Ok(frame)
    }
}

/// A table as Parquet, written in row groups: compressed by zstd, every column optional.
pub(super) struct ParquetFile<W: io::Write + Send> {
    writer: SerializedFileWriter<W>,
}

impl<W: io::Write + Send> ParquetFile<W> {
    /// Begins a file with the columns of `frame`.
    pub fn create(out: W, frame: &Frame) -> io::Result<Self> {
        let fields: Vec<String> =
            frame.columns.iter().map(|(name, cells)| cells.field(name)).collect();
        let schema = parse_message_type(&format!("message runs {{ {} }}", fields.join(" ")));
        let compression = Compression::ZSTD(Default::default());
        let properties = WriterProperties::builder().set_compression(compression).build();
        let writer = schema.and_then(|schema| {
            SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))
        });
        Ok(Self { writer: writer.map_err(io::Error::other)? })
    }

    /// Writes the rows of a frame with the same columns as one row group.
    pub fn write(&mut self, frame: &Frame) -> io::Result<()> {
        self.write_group(frame).map_err(io::Error::other)
    }

    fn write_group(&mut self, frame: &Frame) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        for (_, cells) in &frame.columns {
            let Some(mut column) = group.next_column()? else { break };
            cells.write(column.untyped())?;
            column.close()?;
        }
        group.close()?;
        Ok(())
    }

    /// Completes the file with these keys and texts as metadata.
    pub fn close(mut self, metadata: &[(&str, String)]) -> io::Result<W> {
        for (key, text) in metadata {
            let entry = KeyValue::new((*key).to_owned(), text.clone());
            self.writer.append_key_value_metadata(entry);
        }
        self.writer.into_inner().map_err(io::Error::other)
    }
}

impl Cells {
    fn len(&self) -> usize {
        match self {
            Self::Count(cells) => cells.len(),
            Self::Number(cells) => cells.len(),
            Self::Text(cells) => cells.len(),
            Self::Flag(cells) => cells.len(),
        }
    }

    fn text(&self, row: usize) -> String {
        match self {
            Self::Count(cells) => cells[row].map(|x| x.to_string()),
            Self::Number(cells) => cells[row].map(|x| format!("{x:?}")),
            Self::Text(cells) => cells[row].clone(),
            Self::Flag(cells) => cells[row].map(|x| x.to_string()),
        }
        .unwrap_or_default()
    }

    /// Field of a Parquet schema.
    fn field(&self, name: &str) -> String {
        match self {
            Self::Count(_) => format!("OPTIONAL INT64 {name} (INTEGER(64,false));"),
            Self::Number(_) => format!("OPTIONAL DOUBLE {name};"),
            Self::Text(_) => format!("OPTIONAL BYTE_ARRAY {name} (UTF8);"),
            Self::Flag(_) => format!("OPTIONAL BOOLEAN {name};"),
        }
    }

    fn read(column: ColumnReader, rows: usize) -> Result<Self, ParquetError> {
        let map = |text: ByteArray| String::from_utf8_lossy(text.data()).into_owned();
        Ok(match column {
            ColumnReader::Int64ColumnReader(column) => {
                let cells = read_column(column, rows)?.into_iter();
                Self::Count(cells.map(|cell| cell.map(i64::cast_unsigned)).collect())
            }
            ColumnReader::DoubleColumnReader(column) => Self::Number(read_column(column, rows)?),
            ColumnReader::ByteArrayColumnReader(column) => {
                let cells = read_column(column, rows)?.into_iter();
                Self::Text(cells.map(|cell| cell.map(map)).collect())
            }
            ColumnReader::BoolColumnReader(column) => Self::Flag(read_column(column, rows)?),
            _ => return Err(ParquetError::General("a column of another type".to_owned())),
        })
    }

    fn write(&self, column: &mut ColumnWriter<'_>) -> Result<(), ParquetError> {
        match (self, column) {
            (Self::Count(cells), ColumnWriter::Int64ColumnWriter(out)) => {
                // Two's complement: the schema says that the number is unsigned.
                let values: Vec<i64> = cells.iter().flatten().map(|x| x.cast_signed()).collect();
                out.write_batch(&values, Some(&levels(cells)), None)?;
            }
            (Self::Number(cells), ColumnWriter::DoubleColumnWriter(out)) => {
                let values: Vec<f64> = cells.iter().flatten().copied().collect();
                out.write_batch(&values, Some(&levels(cells)), None)?;
            }
            (Self::Text(cells), ColumnWriter::ByteArrayColumnWriter(out)) => {
                let values: Vec<ByteArray> =
                    cells.iter().flatten().map(|x| x.as_str().into()).collect();
                out.write_batch(&values, Some(&levels(cells)), None)?;
            }
            (Self::Flag(cells), ColumnWriter::BoolColumnWriter(out)) => {
                let values: Vec<bool> = cells.iter().flatten().copied().collect();
                out.write_batch(&values, Some(&levels(cells)), None)?;
            }
            _ => return Err(ParquetError::General("a column of another type".to_owned())),
        }
        Ok(())
    }
}

/// All values of a column of one row group, with their definition levels.
fn read_column<T: DataType>(
    mut column: ColumnReaderImpl<T>,
    rows: usize,
) -> Result<Vec<Option<T::T>>, ParquetError> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    column.read_records(rows, Some(&mut levels), None, &mut values)?;
    let mut values = values.into_iter();
    let cells: Vec<_> =
        levels.iter().map(|level| (*level > 0).then(|| values.next()).flatten()).collect();
    match cells.len() == rows {
        true => Ok(cells),
        false => Err(ParquetError::General(format!("{} of {rows} rows", cells.len()))),
    }
}

/// Definition levels: one for a value, zero for none.
fn levels<T>(cells: &[Option<T>]) -> Vec<i16> {
    cells.iter().map(|cell| i16::from(cell.is_some())).collect()
}

#[cfg(test)]
mod tests {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;

    use super::*;

    fn example() -> Frame {
        let mut frame = Frame::default();
        frame.add("seed", Cells::Count(vec![Some(7), Some(u64::MAX)]));
        frame.add("jxx_kg_m2", Cells::Number(vec![None, Some(-1e-9)]));
        frame.add("status", Cells::Text(vec![Some("a,b".to_owned()), None]));
        frame.add("converged", Cells::Flag(vec![Some(true), None]));
        frame
    }

    #[test]
    fn csv_has_empty_cells_for_missing_values() {
        let mut bytes = Vec::new();
        example().write_csv(&mut bytes).unwrap();
        assert_eq!(
            String::from_utf8(bytes).unwrap(),
            "seed,jxx_kg_m2,status,converged\n7,,\"a,b\",true\n18446744073709551615,-1e-9,,\n"
        );
    }

    #[test]
    fn parquet_reads_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.parquet");
        example().write_parquet(BufWriter::new(File::create(&path).unwrap())).unwrap();
        let reader = SerializedFileReader::new(File::open(&path).unwrap()).unwrap();
        let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 2);
        assert_eq!((rows[0].get_ulong(0).unwrap(), rows[1].get_ulong(0).unwrap()), (7, u64::MAX));
        assert_eq!(rows[1].get_double(1).unwrap(), -1e-9);
        assert!(rows[0].get_double(1).is_err() && rows[0].get_bool(3).unwrap());
        assert_eq!(rows[0].get_string(2).unwrap(), "a,b");
        let frame = Frame::read(reader.get_row_group(0).unwrap().as_ref()).unwrap();
        let text = |frame: &Frame| {
            let mut bytes = Vec::new();
            frame.write_csv(&mut bytes).unwrap();
            bytes
        };
        assert_eq!(text(&frame), text(&example()));
    }
}
