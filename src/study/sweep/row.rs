//! A sweep point as a row of a table and as an object in JSON.

use std::collections::HashMap;
use std::io;
use std::sync::Arc;

use arrow_array::RecordBatch;
use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_schema::{DataType, Field, FieldRef, Schema, SchemaRef};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};
use serde_arrow::schema::{SchemaLike, TracingOptions};
use serde_json::json;

use super::{Place, Start, SweepPlan, SweepPoint};
use crate::analysis::recurrence::RecurrenceKind;
use crate::dynamics::Exponent;
use crate::number::degrees;
use crate::study::response::SettledResponse;
use crate::study::table;

/// Key of the schema metadata that holds the plan of the sweep ([`SweepPlan::identity`]). It ends with the version of the
/// format.
pub const IDENTITY: &str = "squeakscope sweep 3";

/// A point; missing values are null.
#[derive(Serialize, JsonSchema)]
pub struct Row {
    #[serde(flatten)]
    place: Place,
    /// Error message of a point without a response.
    error: Option<String>,
    #[serde(flatten)]
    leading: Leading,
    #[serde(flatten)]
    found: Option<SettledResponse>,
}

/// What is read of a row of a table, except the values of the axes.
#[derive(Deserialize)]
struct StoredRow {
    index: usize,
    start: Start,
    error: Option<String>,
    kaplan_yorke: Option<f64>,
    kaplan_yorke_half_width: Option<f64>,
    #[serde(flatten)]
    found: Option<SettledResponse>,
}

/// The first entries of the lists of a response, and numbers that follow from them: for readers that have no lists.
#[derive(Default, Serialize, Deserialize, JsonSchema)]
struct Leading {
    /// Frequency of line 1, the strongest, Hz.
    line_1_hz: Option<f64>,
    /// Amplitude of line 1, m.
    line_1_amplitude_m: Option<f64>,
    /// Name of line 1.
    line_1_name: Option<String>,
    /// Frequency of line 2, the second strongest, Hz.
    line_2_hz: Option<f64>,
    /// Amplitude of line 2, m.
    line_2_amplitude_m: Option<f64>,
    /// Name of line 2.
    line_2_name: Option<String>,
    /// Exponent 1, the largest, 1/s.
    exponent_1_per_s: Option<f64>,
    /// Half-width of the 95 % interval of exponent 1, 1/s.
    exponent_1_half_width_per_s: Option<f64>,
    /// Exponent 2, 1/s.
    exponent_2_per_s: Option<f64>,
    /// Half-width of the 95 % interval of exponent 2, 1/s.
    exponent_2_half_width_per_s: Option<f64>,
    /// Exponent 3, 1/s.
    exponent_3_per_s: Option<f64>,
    /// Half-width of the 95 % interval of exponent 3, 1/s.
    exponent_3_half_width_per_s: Option<f64>,
    /// Finest recurrence period, s.
    recurrence_period_finest_s: Option<f64>,
    /// Recurrence period of the beat, s.
    recurrence_period_beat_s: Option<f64>,
    /// Doubled recurrence period, s.
    recurrence_period_doubled_s: Option<f64>,
    /// Kaplan-Yorke dimension; `null` if too few exponents are known.
    kaplan_yorke: Option<f64>,
    /// Half-width of the 95 % interval of the Kaplan-Yorke dimension.
    kaplan_yorke_half_width: Option<f64>,
    /// Tilt of the load, degrees.
    tilt_deg: Option<f64>,
    /// Number of unstable linear modes.
    unstable_modes: Option<u64>,
}

impl Leading {
    fn of(found: &SettledResponse) -> Self {
        let line = |k: usize| found.lines.get(k);
        let exponent = |k: usize| found.exponents.as_ref()?.exponents.get(k);
        let period = |kind| {
            let longest = found.recurrence_periods.last(kind)?;
            Some(longest.period)
        };
        let dimension = found.exponents.as_ref().and_then(|all| all.kaplan_yorke);
        let linear = found.linear.as_ref();
        Self {
            line_1_hz: line(0).map(|line| line.frequency),
            line_1_amplitude_m: line(0).map(|line| line.amplitude),
            line_1_name: line(0).map(|line| line.label.clone()),
            line_2_hz: line(1).map(|line| line.frequency),
            line_2_amplitude_m: line(1).map(|line| line.amplitude),
            line_2_name: line(1).map(|line| line.label.clone()),
            exponent_1_per_s: exponent(0).map(|e| e.value),
            exponent_1_half_width_per_s: exponent(0).map(|e| e.half_width),
            exponent_2_per_s: exponent(1).map(|e| e.value),
            exponent_2_half_width_per_s: exponent(1).map(|e| e.half_width),
            exponent_3_per_s: exponent(2).map(|e| e.value),
            exponent_3_half_width_per_s: exponent(2).map(|e| e.half_width),
            recurrence_period_finest_s: period(RecurrenceKind::Finest),
            recurrence_period_beat_s: period(RecurrenceKind::Beat),
            recurrence_period_doubled_s: period(RecurrenceKind::Doubled),
            kaplan_yorke: dimension.map(|d| d.value),
            kaplan_yorke_half_width: dimension.map(|d| d.half_width),
            tilt_deg: linear.map(|linear| degrees(linear.tilt)),
            unstable_modes: linear.map(|linear| linear.unstable().count() as u64),
        }
    }
}

impl Row {
    /// The row of a point.
    fn new(point: SweepPoint) -> Self {
        let (found, error) = match point.outcome {
            Ok(found) => (Some(found), None),
            Err(error) => (None, Some(error)),
        };
        Self {
            place: point.place,
            error,
            leading: found.as_ref().map(Leading::of).unwrap_or_default(),
            found,
        }
    }

    /// The columns of all rows without the values of the axes. Those of a response are null for a failed point.
    fn fields() -> Result<Vec<FieldRef>, serde_arrow::Error> {
        // Words are plain text: the batches of an Arrow file may not differ in a dictionary.
        let word = |name| json!({"name": name, "data_type": "LargeUtf8"});
        let pair = json!([{"name": "element", "data_type": "F64"}]);
        let pairs = json!([{"name": "element", "data_type": "LargeList", "children": pair}]);
        let options = TracingOptions::default()
            .overwrite("regime", word("regime"))?
            .overwrite("recurrence_periods.element.kind", word("kind"))?
            .overwrite(
                "section_m",
                json!({"name": "section_m", "data_type": "LargeList", "children": pairs}),
            )?;
        let found = Vec::<FieldRef>::from_type::<SettledResponse>(options)?;
        let nullable = |field: FieldRef| Arc::new(field.as_ref().clone().with_nullable(true));
        let mut fields: Vec<FieldRef> = vec![
            Arc::new(Field::new("index", DataType::UInt64, false)),
            Arc::new(Field::new("start", DataType::LargeUtf8, false)),
            Arc::new(Field::new("error", DataType::LargeUtf8, true)),
        ];
        fields.extend(Vec::<FieldRef>::from_type::<Leading>(
            TracingOptions::default(),
        )?);
        fields.extend(found.into_iter().map(nullable));
        Ok(fields)
    }
}

/// In JSON a point has no portrait and no final state; only the table has them.
impl Serialize for SweepPoint {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut point = self.clone();
        if let Ok(found) = &mut point.outcome {
            found.portrait = None;
            found.state.clear();
        }
        Row::new(point).serialize(to)
    }
}

/// The columns of the table of a sweep, with its identity.
pub(super) fn schema(plan: &SweepPlan) -> io::Result<SchemaRef> {
    let mut fields = table::columns(Row::fields().map_err(io::Error::other)?);
    // After the index and the start.
    let parameters = plan.axes.iter().map(|axis| {
        let field = Field::new(&axis.name, DataType::Float64, false);
        table::measured_in(&Arc::new(field), axis.unit())
    });
    fields.splice(2..2, parameters);
    let identity = HashMap::from([(IDENTITY.to_owned(), plan.identity())]);
    Ok(Arc::new(Schema::new_with_metadata(fields, identity)))
}

/// Points as a record batch with the columns of a plan.
pub(super) fn batch(schema: &SchemaRef, points: &[&SweepPoint]) -> io::Result<RecordBatch> {
    let rows = points.iter().map(|point| Row::new((*point).clone()));
    let batch = serde_arrow::to_record_batch(schema.fields(), &rows.collect::<Vec<_>>());
    let batch = batch.map_err(io::Error::other)?;
    batch
        .with_schema(Arc::clone(schema))
        .map_err(io::Error::other)
}

/// The points of a record batch of a plan, or the reason why it has none.
pub(super) fn points(batch: &RecordBatch, plan: &SweepPlan) -> Result<Vec<SweepPoint>, String> {
    let rows: Vec<StoredRow> = serde_arrow::from_record_batch(batch).map_err(|e| e.to_string())?;
    let stored = |name: &str, row: usize| {
        let column = batch.column_by_name(name)?;
        Some(column.as_primitive_opt::<Float64Type>()?.value(row))
    };
    let points = rows.into_iter().enumerate().map(|(k, row)| {
        let index = row.index;
        let place = (index < plan.size()).then(|| plan.place(index));
        let place = place.filter(|place| {
            let mut values = place.named.iter();
            row.start == place.start && values.all(|(name, at)| stored(name, k) == Some(*at))
        });
        let place = place.ok_or_else(|| format!("its point {index} does not match the plan"))?;
        let outcome = match (row.error, row.found) {
            (Some(error), _) => Err(error),
            (None, Some(mut found)) => {
                let dimension = row.kaplan_yorke.zip(row.kaplan_yorke_half_width);
                if let Some(exponents) = &mut found.exponents {
                    exponents.kaplan_yorke =
                        dimension.map(|(value, half_width)| Exponent { value, half_width });
                }
                Ok(found)
            }
            (None, None) => return Err(format!("the response of point {index} is incomplete")),
        };
        Ok(SweepPoint { place, outcome })
    });
    points.collect()
}
