//! Points of a sweep as record batches of a table.

use std::io;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_schema::{DataType, Field, FieldRef, Schema, SchemaRef};

use super::row::Row;
use super::{SweepPlan, SweepPoint};
use crate::study::table;

/// Key of the schema metadata that holds the plan of the sweep ([`SweepPlan::identity`]). It ends with the version of the
/// format.
pub const IDENTITY: &str = "squeakscope sweep 3";

/// Key of the metadata of a field that holds a parameter of the sweep.
const PARAMETER: &str = "squeakscope parameter";

/// The columns of the table of a sweep, with its identity.
pub(super) fn schema(plan: &SweepPlan) -> io::Result<SchemaRef> {
    let mut fields = table::columns(Row::fields().map_err(io::Error::other)?);
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
pub(super) fn batch(plan: &SweepPlan, points: &[&SweepPoint]) -> io::Result<RecordBatch> {
    let rows = points.iter().map(|point| Row::new((*point).clone()));
    let rows: Vec<Row> = rows.collect();
    let fields = Row::fields().map_err(io::Error::other)?;
    let results = serde_arrow::to_record_batch(&fields, &rows).map_err(io::Error::other)?;
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
    let rows: Vec<Row> = serde_arrow::from_record_batch(batch).map_err(|e| e.to_string())?;
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
