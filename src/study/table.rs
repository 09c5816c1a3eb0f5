//! Tables on disk: an Arrow file, Parquet or CSV, by the ending of the name.
//!
//! Each column has its unit in its name and in the metadata of its field (`unit`). Columns of one value come first,
//! lists and structs after them; a CSV table has only the former.

use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

use arrow_array::RecordBatch;
use arrow_ipc::writer::FileWriter;
use arrow_schema::{ArrowError, FieldRef, Schema, SchemaRef};
use erased_serde::Serialize as Erased;
use parquet::arrow::ArrowWriter;
use serde_json::Value;

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
    let is_single = |field: &FieldRef| !field.data_type().is_nested();
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

/// The schema of a table with some columns.
pub(super) fn schema(fields: Result<Vec<FieldRef>, serde_arrow::Error>) -> io::Result<SchemaRef> {
    let fields = fields.map_err(io::Error::other)?;
    Ok(Arc::new(Schema::new(columns(fields))))
}

/// Rows as a record batch with the columns of a schema.
pub(super) fn batch(schema: &SchemaRef, rows: &dyn Erased) -> io::Result<RecordBatch> {
    let batch = serde_arrow::to_record_batch(schema.fields(), &rows).map_err(io::Error::other)?;
    let batch = batch.with_schema(Arc::clone(schema));
    batch.map_err(io::Error::other)
}

/// Writes a finished table: Parquet or CSV if the name ends so, otherwise an Arrow file. An existing file is replaced.
///
/// # Errors
/// If the file cannot be written; an existing file is then unchanged.
pub(super) fn write(
    path: &Path,
    schema: io::Result<SchemaRef>,
    rows: &dyn Erased,
) -> Result<(), OutputError> {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    replace_file(path, |out| {
        let schema = schema?;
        match ending.to_str() {
            Some("parquet") => {
                let file = ArrowWriter::try_new(out, Arc::clone(&schema), None);
                let mut file = file.map_err(io::Error::other)?;
                let rows = batch(&schema, rows)?;
                file.write(&rows).map_err(io::Error::other)?;
                file.close().map(drop).map_err(io::Error::other)
            }
            Some("csv") => write_csv(out, &schema, rows),
            _ => {
                let mut file = FileWriter::try_new(out, &schema).map_err(unwrapped)?;
                file.write(&batch(&schema, rows)?).map_err(unwrapped)?;
                file.finish().map_err(unwrapped)
            }
        }
    })
}

fn write_csv(out: impl Write, schema: &Schema, rows: &dyn Erased) -> io::Result<()> {
    let fields = schema.fields().iter();
    let single = fields.take_while(|field| !field.data_type().is_nested());
    let names: Vec<&String> = single.map(|field| field.name()).collect();
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record(&names)?;
    for row in serde_json::to_value(rows)?.as_array().into_iter().flatten() {
        csv.write_record(names.iter().map(|name| cell(&row[*name])))?;
    }
    csv.flush()
}

/// A value as text; null is empty.
fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// The I/O error within an Arrow error, if there is one.
pub(super) fn unwrapped(error: ArrowError) -> io::Error {
    match error {
        ArrowError::IoError(_, source) => source,
        other => io::Error::other(other),
    }
}
