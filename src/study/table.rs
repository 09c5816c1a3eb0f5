//! Tables on disk: an Arrow file, Parquet or CSV, by the ending of the name.
//!
//! Each column has its unit in its name and in the metadata of its field (`unit`). Columns of one value come first,
//! lists and structs after them; a CSV table has the columns of one value only.

use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt32Type, UInt64Type};
use arrow_array::{Array, RecordBatch};
use arrow_ipc::writer::FileWriter;
use arrow_schema::{ArrowError, DataType, FieldRef, Schema, SchemaRef};
use parquet::arrow::ArrowWriter;
use serde::Serialize;

use crate::export::{OutputError, replace_file};

/// Number of rows in a batch of a finished table.
const BATCH: usize = 1024;

/// Key of the unit in the metadata of a field.
const UNIT: &str = "unit";

/// Endings of column names and their units; the first that fits counts.
const UNITS: [(&str, &str); 6] = [
    ("_m_per_s", "m/s"),
    ("_per_s", "1/s"),
    ("_hz", "Hz"),
    ("_deg", "deg"),
    ("_m", "m"),
    ("_s", "s"),
];

/// The columns in the order of a table, with their units.
pub(super) fn columns(fields: Vec<FieldRef>) -> Vec<FieldRef> {
    let (single, lists): (Vec<_>, Vec<_>) = fields.into_iter().partition(is_single);
    let with_unit = |field: FieldRef| {
        let unit = UNITS.iter().find(|(end, _)| field.name().ends_with(end));
        measured_in(&field, unit.map_or("", |(_, unit)| unit))
    };
    single.into_iter().chain(lists).map(with_unit).collect()
}

/// The field with this unit; an empty one is that of a number without a unit.
pub(super) fn measured_in(field: &FieldRef, unit: &str) -> FieldRef {
    let mut metadata = field.metadata().clone();
    metadata.extend((!unit.is_empty()).then(|| (UNIT.to_owned(), unit.to_owned())));
    Arc::new(field.as_ref().clone().with_metadata(metadata))
}

/// Whether a column has one value per row.
fn is_single(field: &FieldRef) -> bool {
    !field.data_type().is_nested()
}

/// The schema of a table with some columns.
pub(super) fn schema(fields: Result<Vec<FieldRef>, serde_arrow::Error>) -> io::Result<SchemaRef> {
    let fields = fields.map_err(io::Error::other)?;
    Ok(Arc::new(Schema::new(columns(fields))))
}

/// Rows as a record batch with the columns of a schema.
pub(super) fn batch<R: Serialize>(schema: &SchemaRef, rows: &[R]) -> io::Result<RecordBatch> {
    let batch = serde_arrow::to_record_batch(schema.fields(), &rows).map_err(io::Error::other)?;
    let batch = batch.with_schema(Arc::clone(schema));
    batch.map_err(io::Error::other)
}

/// Writes a finished table: Parquet or CSV if the name ends so, otherwise an Arrow file. An existing file is replaced.
///
/// # Errors
/// If the file cannot be written; an existing file is then unchanged.
pub(super) fn write<R: Serialize>(
    path: &Path,
    schema: io::Result<SchemaRef>,
    rows: &[R],
) -> Result<(), OutputError> {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    replace_file(path, |out| {
        let schema = schema?;
        let batches = rows.chunks(BATCH).map(|rows| batch(&schema, rows));
        match ending.to_str() {
            Some("parquet") => {
                let file = ArrowWriter::try_new(out, Arc::clone(&schema), None);
                let mut file = file.map_err(io::Error::other)?;
                for batch in batches {
                    file.write(&batch?).map_err(io::Error::other)?;
                }
                file.close().map(drop).map_err(io::Error::other)
            }
            Some("csv") => write_csv(out, &schema, batches),
            _ => {
                let mut file = FileWriter::try_new(out, &schema).map_err(unwrapped)?;
                for batch in batches {
                    file.write(&batch?).map_err(unwrapped)?;
                }
                file.finish().map_err(unwrapped)
            }
        }
    })
}

fn write_csv(
    out: impl Write,
    schema: &SchemaRef,
    batches: impl Iterator<Item = io::Result<RecordBatch>>,
) -> io::Result<()> {
    let fields = schema.fields().iter().enumerate();
    let single = fields.filter(|(_, field)| is_single(field));
    let single: Vec<usize> = single.map(|(k, _)| k).collect();
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record(single.iter().map(|&k| schema.field(k).name()))?;
    for batch in batches {
        let batch = batch?;
        for row in 0..batch.num_rows() {
            let cells = single.iter().map(|&k| cell(batch.column(k), row));
            csv.write_record(cells.collect::<io::Result<Vec<_>>>()?)?;
        }
    }
    csv.flush()
}

/// A value as text; null is empty.
fn cell(column: &dyn Array, row: usize) -> io::Result<String> {
    if column.is_null(row) {
        return Ok(String::new());
    }
    Ok(match column.data_type() {
        DataType::Float64 => column.as_primitive::<Float64Type>().value(row).to_string(),
        DataType::UInt64 => column.as_primitive::<UInt64Type>().value(row).to_string(),
        DataType::UInt32 => column.as_primitive::<UInt32Type>().value(row).to_string(),
        DataType::Boolean => column.as_boolean().value(row).to_string(),
        DataType::LargeUtf8 => column.as_string::<i64>().value(row).to_owned(),
        other => return Err(io::Error::other(format!("a column of {other} has no text"))),
    })
}

/// The I/O error within an Arrow error, if there is one.
pub(super) fn unwrapped(error: ArrowError) -> io::Error {
    match error {
        ArrowError::IoError(_, source) => source,
        other => io::Error::other(other),
    }
}
