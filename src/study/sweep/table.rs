//! Tables of a sweep: an Arrow stream with one record batch per point while it grows, and a finished table as an
//! Arrow file, Parquet or CSV.
//!
//! A stream that ends early can be read up to its last complete batch, also by any other reader of Arrow's streaming
//! format. Each parameter has a column of the name of its key, in the unit of the scene file; all other columns are
//! in SI units. A failed point has its message in the column `error`; its other results are null.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::RecordBatch;
use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_ipc::writer::StreamWriter;
use arrow_schema::{DataType, Field, FieldRef, Schema, SchemaRef};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};
use serde_arrow::schema::{SchemaLike, TracingOptions};
use serde_json::{Value, json};

use super::plan::PlanRecord;
use super::{Place, Start, SweepPlan, SweepPoint};
use crate::export::{OutputError, replace_file};
use crate::foreign::table::read_batches;
use crate::foreign::{one_line, open_file, without_panic};
use crate::study::response::SettledResponse;
use crate::study::{StudyError, table};

/// Error when reading or writing a table.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The file cannot be opened.
    #[error("cannot read `{0}`")]
    Read(PathBuf, #[source] io::Error),
    /// The file is not a valid table of a sweep; what is wrong with it.
    #[error("`{0}` is not a sweep table: {1}")]
    Invalid(PathBuf, String),
    /// The file belongs to a sweep with another plan; the first difference between the plans.
    #[error(
        "`{0}` belongs to another sweep: {1}; choose another --out, or use the same scene and options"
    )]
    OtherSweep(PathBuf, String),
    /// Writing failed. Points written earlier are kept.
    #[error("writing `{0}` failed; the points written before are kept: continue with --resume")]
    Write(PathBuf, #[source] io::Error),
    /// The sweep was stopped, or no thread could be started.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The file was removed or moved during the sweep.
    #[error(
        "`{0}` was removed or moved during the sweep, so further points would be lost; repeat the sweep with an --out \
         folder that is not moved"
    )]
    Removed(PathBuf, #[source] io::Error),
}

impl TableError {
    /// The file is not a valid table, for this reason.
    pub fn invalid(path: &Path, reason: impl Into<String>) -> Self {
        Self::Invalid(path.to_owned(), reason.into())
    }
}

/// Writer of a table that grows: an Arrow stream, point by point.
pub struct TableWriter {
    path: PathBuf,
    schema: SchemaRef,
    stream: StreamWriter<File>,
}

/// A sweep table read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepTable {
    /// Identity of the sweep's plan ([`SweepPlan::identity`]).
    pub identity: String,
    /// The points in the order of the file.
    pub points: Vec<SweepPoint>,
    /// Whether the file ends within a batch; that batch is not among the points.
    pub truncated: bool,
}

impl TableWriter {
    /// Creates a table that contains the `known` points. An existing file is replaced.
    ///
    /// # Errors
    /// [`TableError::Write`].
    pub fn new(path: &Path, plan: &SweepPlan, known: &[SweepPoint]) -> Result<Self, TableError> {
        // The old file is replaced only once the new one holds all its points.
        let begun = replace_file(path, |out: &mut BufWriter<&File>| {
            let (file, schema) = (out.get_ref().try_clone()?, schema(plan)?);
            let mut growing = Self {
                path: path.to_owned(),
                stream: StreamWriter::try_new(file, &schema).map_err(table::unwrapped)?,
                schema,
            };
            for point in known {
                growing.write(point)?;
            }
            Ok(growing)
        });
        begun.map_err(|OutputError { path, source }| TableError::Write(path, source))
    }

    fn write(&mut self, point: &SweepPoint) -> io::Result<()> {
        let batch = table::batch(&self.schema, &vec![Row::new(point)])?;
        self.stream.write(&batch).map_err(table::unwrapped)?;
        self.stream.flush().map_err(table::unwrapped)
    }

    /// Adds a point and flushes it to the operating system.
    ///
    /// # Errors
    /// [`TableError::Write`], [`TableError::Removed`].
    pub fn add(&mut self, point: &SweepPoint) -> Result<(), TableError> {
        let written = self.write(point);
        written.map_err(|source| TableError::Write(self.path.clone(), source))?;
        // Writes to a removed file succeed, but the data are lost.
        let file = self.path.symlink_metadata();
        file.map(drop)
            .map_err(|source| TableError::Removed(self.path.clone(), source))
    }
}

/// Writes a finished table sorted by index: Parquet or CSV if the name ends so, otherwise an Arrow file. Equal points
/// give equal bytes.
///
/// # Errors
/// [`TableError::Write`]; an existing file is then unchanged.
pub fn write_table(path: &Path, plan: &SweepPlan, points: &[SweepPoint]) -> Result<(), TableError> {
    let mut rows: Vec<Row<'_>> = points.iter().map(Row::new).collect();
    rows.sort_by_key(|row| row.place.index);
    let written = table::write(path, schema(plan), &rows);
    written.map_err(|OutputError { path, source }| TableError::Write(path, source))
}

/// Reads a table: an Arrow stream, an Arrow file or Parquet. A truncated stream, from a process that was killed, yields
/// all complete points.
///
/// # Errors
/// [`TableError::Read`], [`TableError::Invalid`].
pub fn read_table(path: &Path) -> Result<SweepTable, TableError> {
    // The Arrow library panics on some damaged files.
    without_panic(|| read_points(path)).unwrap_or_else(|| {
        let reason = "it is damaged; restore a copy, or choose another --out";
        Err(TableError::invalid(path, reason))
    })
}

fn read_points(path: &Path) -> Result<SweepTable, TableError> {
    let foreign = |reason: &str| TableError::invalid(path, reason);
    let (file, length) =
        open_file(path).map_err(|source| TableError::Read(path.to_owned(), source))?;
    if length == 0 {
        return Err(foreign("it is empty; remove it, or choose another --out"));
    }
    let (schema, batches) = read_batches(file).map_err(|fault| foreign(&fault.to_string()))?;
    let identity = schema.metadata().get(IDENTITY).cloned();
    let identity = identity.ok_or_else(|| {
        foreign("its metadata has no sweep plan of this version; repeat the sweep, or choose another --out")
    })?;
    let plan = PlanRecord::parse(&identity).map_err(|reason| {
        foreign(&format!(
            "its sweep plan cannot be read ({reason}); it may be of another version: choose another --out"
        ))
    })?;
    // The file of modes of the scene need not be at hand.
    let plan = plan.plan(());
    let mut found = SweepTable {
        identity,
        points: Vec::new(),
        truncated: false,
    };
    for batch in batches {
        let Ok(batch) = batch else {
            found.truncated = true;
            break;
        };
        let read = points(&batch, &plan).map_err(|reason| foreign(&one_line(reason)))?;
        found.points.extend(read);
    }
    Ok(found)
}

impl SweepTable {
    /// Checks that the table belongs to `plan`.
    ///
    /// # Errors
    /// [`TableError::OtherSweep`]; it names `path`.
    pub fn check(&self, plan: &SweepPlan, path: &Path) -> Result<(), TableError> {
        let wanted = plan.identity();
        if self.identity == wanted {
            return Ok(());
        }
        let difference = difference([&self.identity, &wanted]);
        Err(TableError::OtherSweep(path.to_owned(), difference))
    }
}

/// The first entries that differ.
fn difference(identities: [&str; 2]) -> String {
    let [found, wanted] = identities.map(|text| {
        let plan: Value = toml_edit::de::from_str(text).unwrap_or_default();
        entries("", &plan)
    });
    let mut places = 0..found.len().max(wanted.len());
    let place = places.find(|k| found.get(*k) != wanted.get(*k));
    let [found, wanted] = [&found, &wanted].map(|entries| {
        let entry = place.and_then(|place| entries.get(place));
        entry.map_or("nothing more", String::as_str)
    });
    format!("`{found}` in the file and `{wanted}` in this sweep")
}

/// Each number, word and line of a text of a plan, after its key.
fn entries(key: &str, value: &Value) -> Vec<String> {
    match value {
        Value::Object(table) => {
            let pairs = table.iter();
            pairs.flat_map(|(key, value)| entries(key, value)).collect()
        }
        Value::Array(list) => list.iter().flat_map(|value| entries(key, value)).collect(),
        Value::String(text) => text.lines().map(|line| format!("{key}: {line}")).collect(),
        value => vec![format!("{key}: {value}")],
    }
}

/// Key of the schema metadata that holds the plan of the sweep ([`SweepPlan::identity`]). It ends with the version of the
/// format.
const IDENTITY: &str = "squeakscope sweep 4";

/// A point; missing values are null.
#[derive(Serialize, JsonSchema)]
pub struct Row<'a> {
    #[serde(flatten)]
    place: &'a Place,
    /// Error message of a point without a response.
    error: Option<&'a str>,
    /// Frequency of the strongest line, Hz.
    frequency_hz: Option<f64>,
    /// Largest Lyapunov exponent, 1/s.
    largest_exponent_per_s: Option<f64>,
    /// Half-width of the 95 % interval of the largest exponent, 1/s.
    largest_exponent_half_width_per_s: Option<f64>,
    #[serde(flatten)]
    found: Option<&'a SettledResponse>,
}

/// What is read of a row of a table, except the values of the axes.
#[derive(Deserialize)]
struct StoredRow {
    index: usize,
    start: Start,
    error: Option<String>,
    #[serde(flatten)]
    found: Option<SettledResponse>,
}

impl<'a> Row<'a> {
    /// The row of a point.
    fn new(point: &'a SweepPoint) -> Self {
        let found = point.found();
        let largest = found.and_then(|found| found.exponents.as_ref()?.exponents.first());
        Self {
            place: &point.place,
            error: point.outcome.as_ref().err().map(String::as_str),
            frequency_hz: found.and_then(|found| Some(found.lines.first()?.frequency)),
            largest_exponent_per_s: largest.map(|largest| largest.value),
            largest_exponent_half_width_per_s: largest.map(|largest| largest.half_width),
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
        let number = |name: &str| Arc::new(Field::new(name, DataType::Float64, true));
        let mut fields: Vec<FieldRef> = vec![
            Arc::new(Field::new("index", DataType::UInt64, false)),
            Arc::new(Field::new("start", DataType::LargeUtf8, false)),
            Arc::new(Field::new("error", DataType::LargeUtf8, true)),
            number("frequency_hz"),
            number("largest_exponent_per_s"),
            number("largest_exponent_half_width_per_s"),
        ];
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
        Row::new(&point).serialize(to)
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

/// The points of a record batch of a plan, or the reason why it has none.
fn points(batch: &RecordBatch, plan: &SweepPlan<()>) -> Result<Vec<SweepPoint>, String> {
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
            (None, Some(found)) => Ok(found),
            (None, None) => return Err(format!("the response of point {index} is incomplete")),
        };
        Ok(SweepPoint { place, outcome })
    });
    points.collect()
}
