//! Points of a sweep as record batches of a table.

use std::io;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_schema::{DataType, Field, FieldRef, Schema, SchemaRef};

use super::row::Row;
use super::{SweepPlan, SweepPoint};
use crate::number::degrees;
use crate::study::table;

/// Key of the schema metadata that holds the plan of the sweep ([`SweepPlan::identity`]).
pub const IDENTITY: &str = "squeakscope sweep";

/// Key of the metadata of a field that holds a parameter of the sweep.
const PARAMETER: &str = "squeakscope parameter";

/// Name of the column of tilts in a result and in a table.
const TILT: [&str; 2] = ["tilt_rad", "tilt_deg"];

/// The columns of the table of a sweep, with its identity.
pub(super) fn schema(plan: &SweepPlan) -> io::Result<SchemaRef> {
    let fields = Row::fields().map_err(io::Error::other)?;
    let fields = fields.into_iter().map(|field| renamed(&field, TILT));
    let mut fields = table::columns(fields.collect());
    // After the index and the start.
    let parameters = plan.axes.iter().map(|axis| {
        let path = axis.parameter().path();
        let field = Field::new(path, DataType::Float64, false);
        let field = field.with_metadata(table::note(PARAMETER, path));
        table::measured_in(&Arc::new(field), axis.parameter().unit())
    });
    fields.splice(2..2, parameters);
    let identity = table::note(IDENTITY, &plan.identity());
    Ok(Arc::new(Schema::new_with_metadata(fields, identity)))
}

/// Points as a record batch.
pub(super) fn batch(plan: &SweepPlan, points: &[SweepPoint]) -> io::Result<RecordBatch> {
    let rows: Vec<Row> = points.iter().map(Row::new).collect();
    let fields = Row::fields().map_err(io::Error::other)?;
    let results = serde_arrow::to_record_batch(&fields, &rows).map_err(io::Error::other)?;
    let results = converted(&results, TILT, degrees).map_err(io::Error::other)?;
    let schema = schema(plan)?;
    let mut axes = 0..;
    let columns = schema.fields().iter().map(|field| -> ArrayRef {
        match results.column_by_name(field.name()) {
            Some(column) if !is_parameter(field) => Arc::clone(column),
            _ => {
                let axis: usize = axes.next().unwrap_or_default();
                let values = points.iter().map(|point| point.place.values[axis]);
                Arc::new(values.collect::<Float64Array>())
            }
        }
    });
    let columns = columns.collect();
    RecordBatch::try_new(schema, columns).map_err(io::Error::other)
}

/// The points of a record batch, or the reason why it has none.
pub(super) fn points(batch: &RecordBatch) -> Result<Vec<SweepPoint>, String> {
    let [from, to] = TILT;
    let results = converted(batch, [to, from], f64::to_radians).map_err(|e| e.to_string())?;
    let rows: Vec<Row> = serde_arrow::from_record_batch(&results).map_err(|e| e.to_string())?;
    let fields = batch.schema();
    let fields = fields.fields().iter().zip(batch.columns());
    let axes: Vec<_> = fields
        .filter(|(field, _)| is_parameter(field))
        .map(|(field, column)| {
            let column = column.as_primitive_opt::<Float64Type>();
            column.ok_or_else(|| format!("the column `{}` has no numbers", field.name()))
        })
        .collect::<Result<_, _>>()?;
    let rows = rows.into_iter().enumerate();
    rows.map(|(k, row)| row.into_point(axes.iter().map(|axis| axis.value(k)).collect()))
        .collect()
}

fn is_parameter(field: &FieldRef) -> bool {
    field.metadata().contains_key(PARAMETER)
}

/// The field under the second name, if it has the first.
fn renamed(field: &FieldRef, [from, to]: [&str; 2]) -> FieldRef {
    match field.name() == from {
        true => Arc::new(field.as_ref().clone().with_name(to)),
        false => Arc::clone(field),
    }
}

/// The batch with one column converted and renamed.
fn converted(
    batch: &RecordBatch,
    names: [&str; 2],
    convert: fn(f64) -> f64,
) -> Result<RecordBatch, arrow_schema::ArrowError> {
    let schema = batch.schema();
    let fields = schema.fields().iter();
    let columns = fields.clone().zip(batch.columns()).map(|(field, column)| {
        match column.as_primitive_opt::<Float64Type>() {
            Some(numbers) if field.name() == names[0] => {
                Arc::new(numbers.unary::<_, Float64Type>(convert)) as ArrayRef
            }
            _ => Arc::clone(column),
        }
    });
    let columns: Vec<ArrayRef> = columns.collect();
    let fields: Vec<FieldRef> = fields.map(|field| renamed(field, names)).collect();
    RecordBatch::try_new(Arc::new(Schema::new(fields)), columns)
}
