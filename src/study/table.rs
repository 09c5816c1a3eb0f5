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
use arrow_schema::{ArrowError, DataType, FieldRef, SchemaRef};
use parquet::arrow::ArrowWriter;
use serde::Serialize;

use crate::export::{OutputError, replace_file};

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

/// Writes a finished table; an existing file is replaced.
///
/// # Errors
/// If the file cannot be written; an existing file is then unchanged.
pub(super) fn write(
    path: &Path,
    schema: &SchemaRef,
    batches: &[RecordBatch],
) -> Result<(), OutputError> {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    replace_file(path, |out| match ending.to_str() {
        Some("parquet") => write_parquet(out, schema, batches),
        Some("csv") => write_csv(out, schema, batches),
        _ => write_arrow(out, schema, batches),
    })
}

/// Writes rows with some columns, as [`write()`].
pub(super) fn write_rows<R: Serialize>(
    path: &Path,
    fields: Result<Vec<FieldRef>, serde_arrow::Error>,
    rows: &[R],
) -> Result<(), OutputError> {
    let batch = fields.and_then(|fields| serde_arrow::to_record_batch(&columns(fields), &rows));
    let batch = batch.map_err(|error| OutputError {
        path: path.to_owned(),
        source: io::Error::other(error),
    })?;
    write(path, &batch.schema(), &[batch])
}

fn write_arrow(out: impl Write, schema: &SchemaRef, batches: &[RecordBatch]) -> io::Result<()> {
    let mut file = FileWriter::try_new(out, schema).map_err(unwrapped)?;
    for batch in batches {
        file.write(batch).map_err(unwrapped)?;
    }
    file.finish().map_err(unwrapped)
}

fn write_parquet(
    out: impl Write + Send,
    schema: &SchemaRef,
    batches: &[RecordBatch],
) -> io::Result<()> {
    let mut file = ArrowWriter::try_new(out, schema.clone(), None).map_err(io::Error::other)?;
    for batch in batches {
        file.write(batch).map_err(io::Error::other)?;
    }
    file.close().map(drop).map_err(io::Error::other)
}

fn write_csv(out: impl Write, schema: &SchemaRef, batches: &[RecordBatch]) -> io::Result<()> {
    let fields = schema.fields().iter().enumerate();
    let single = fields.filter(|(_, field)| is_single(field));
    let single: Vec<usize> = single.map(|(k, _)| k).collect();
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record(single.iter().map(|&k| schema.field(k).name()))?;
    for batch in batches {
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
