//! A table of named columns, as CSV and as Parquet.

use std::fs::File;
use std::io::{self, BufWriter};
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

/// Columns of equal length.
#[derive(Clone, Debug, Default)]
pub(super) struct Frame {
    columns: Vec<(String, Cells)>,
}

/// Cells of a column; none for a missing value.
#[derive(Clone, Debug)]
pub(super) enum Cells {
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
    /// Adds a column.
    pub fn add(&mut self, name: impl Into<String>, cells: Cells) {
        self.columns.push((name.into(), cells));
    }

    /// Writes the table as CSV. A missing value is an empty cell. Numbers have the fewest digits that read back as the
    /// same `f64`.
    pub fn write_csv<W: io::Write>(&self, out: W) -> io::Result<()> {
        let mut out = csv::Writer::from_writer(out);
        out.write_record(self.columns.iter().map(|(name, _)| name))?;
        let rows = self.columns.first().map_or(0, |(_, cells)| cells.len());
        for row in 0..rows {
            out.write_record(self.columns.iter().map(|(_, cells)| cells.text(row)))?;
        }
        out.flush()
    }

    /// Writes the table as Parquet, compressed by zstd, one row group, every column optional.
    pub fn write_parquet(&self, out: BufWriter<File>) -> io::Result<()> {
        self.parquet(out).map_err(io::Error::other)
    }

    fn parquet(&self, out: BufWriter<File>) -> Result<(), ParquetError> {
        let fields: Vec<String> =
            self.columns.iter().map(|(name, cells)| cells.field(name)).collect();
        let schema = parse_message_type(&format!("message runs {{ {} }}", fields.join(" ")))?;
        let compression = Compression::ZSTD(Default::default());
        let properties = WriterProperties::builder().set_compression(compression).build();
        let mut file = SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))?;
        let mut group = file.next_row_group()?;
        for (_, cells) in &self.columns {
            let Some(mut column) = group.next_column()? else { break };
            cells.write(column.untyped())?;
            column.close()?;
        }
        group.close()?;
        file.close()?;
        Ok(())
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
    }
}
