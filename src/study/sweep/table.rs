//! Tables of a sweep: an Arrow stream with one record batch per point, and a CSV summary.
//!
//! An Arrow file that ends early can be read up to its last complete batch. Any reader of the Arrow streaming
//! format works, for example `pyarrow.ipc.open_stream(path).read_pandas()`. A failed point has its message in
//! the column `error`; its other results are null.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufReader, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::RecordBatch;
use arrow_ipc::writer::StreamWriter;
use arrow_schema::{ArrowError, FieldRef, Schema, SchemaRef};
use toml::Value;

use super::row::Row;
use super::{SweepPlan, SweepPoint};
use crate::analysis::{ClosedCurves, RecurrencePeriod};
use crate::export::{OutputError, replace_file};
use crate::foreign::arrow::ArrowStream;
use crate::foreign::{one_line, open_file, without_panic};
use crate::study::ThreadSpawnError;

/// Key of the schema metadata that holds the plan of the sweep ([`SweepPlan::identity`]).
pub const IDENTITY: &str = "squeakscope sweep";

/// Error when reading or writing a table.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The file cannot be opened.
    #[error("cannot read `{path}`")]
    Read {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The file is not a valid table of a sweep.
    #[error("`{path}` is not a sweep table: {reason}")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// What is wrong with the file.
        reason: String,
    },
    /// The file belongs to a sweep with another plan.
    #[error(
        "`{path}` belongs to another sweep: {difference}; choose another --out, or use the same scene and \
         options"
    )]
    OtherSweep {
        /// The file.
        path: PathBuf,
        /// The first difference between the plans.
        difference: String,
    },
    /// Writing failed. Points written earlier are kept.
    #[error("writing `{path}` failed; the points written before are kept: continue with --resume")]
    Write {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// No thread of the sweep could be started.
    #[error(transparent)]
    Threads(#[from] ThreadSpawnError),
    /// The file was removed or moved during the sweep.
    #[error(
        "`{path}` was removed or moved during the sweep, so further points would be lost; repeat the sweep \
         with an --out folder that is not moved"
    )]
    Removed {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
}

/// Writer of an Arrow table, point by point.
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
    pub fn new(path: &Path, identity: &str, known: &[SweepPoint]) -> Result<Self, TableError> {
        let failed = |source| TableError::Write {
            path: path.to_owned(),
            source,
        };
        let schema = schema(identity).map_err(|e| failed(io::Error::other(e)))?;
        // The old file is replaced only once the new one holds all its points.
        let mut kept = None;
        replace_file(path, |out: &mut BufWriter<&File>| {
            let file = out.get_ref().try_clone()?;
            let mut stream = StreamWriter::try_new(file, &schema).map_err(io::Error::other)?;
            for point in known {
                stream
                    .write(&batch(&schema, point)?)
                    .map_err(io::Error::other)?;
            }
            stream.flush().map_err(io::Error::other)?;
            kept = Some(stream);
            Ok(())
        })
        .map_err(|OutputError { source, .. }| failed(source))?;
        let stream = kept.ok_or_else(|| failed(io::Error::other("no file was made")))?;
        Ok(Self {
            path: path.to_owned(),
            schema,
            stream,
        })
    }

    /// Adds a point and flushes it to the operating system.
    ///
    /// # Errors
    /// [`TableError::Write`], [`TableError::Removed`].
    pub fn add(&mut self, point: &SweepPoint) -> Result<(), TableError> {
        let written = batch(&self.schema, point).and_then(|batch| {
            self.stream.write(&batch).map_err(unwrapped)?;
            self.stream.flush().map_err(unwrapped)
        });
        written.map_err(|source| TableError::Write {
            path: self.path.clone(),
            source,
        })?;
        // Writes to a removed file succeed, but the data are lost.
        let there = self.path.symlink_metadata();
        there.map(drop).map_err(|source| TableError::Removed {
            path: self.path.clone(),
            source,
        })
    }
}

/// Writes a complete table sorted by index. Equal points give equal bytes.
///
/// # Errors
/// [`TableError::Write`]; an existing file is then unchanged.
pub fn write_table(
    path: &Path,
    identity: &str,
    points: &mut [SweepPoint],
) -> Result<(), TableError> {
    points.sort_by_key(|point| point.place.index);
    let mut table = TableWriter::new(path, identity, points)?;
    let finished = table.stream.finish().map_err(unwrapped);
    finished.map_err(|source| TableError::Write {
        path: path.to_owned(),
        source,
    })
}

/// Reads a table. A truncated file, from a process that was killed, yields all complete points.
///
/// # Errors
/// [`TableError::Read`], [`TableError::Invalid`].
pub fn read_table(path: &Path) -> Result<SweepTable, TableError> {
    // The Arrow library panics on some damaged files.
    without_panic(|| read_points(path)).unwrap_or_else(|| {
        Err(TableError::Invalid {
            path: path.to_owned(),
            reason: "it is damaged; restore a copy, or choose another --out".to_owned(),
        })
    })
}

fn read_points(path: &Path) -> Result<SweepTable, TableError> {
    let foreign = |reason: String| TableError::Invalid {
        path: path.to_owned(),
        reason,
    };
    let (file, length) = open_file(path).map_err(|source| TableError::Read {
        path: path.to_owned(),
        source,
    })?;
    if length == 0 {
        return Err(foreign(
            "it is empty; remove it, or choose another --out".to_owned(),
        ));
    }
    let mut stream =
        ArrowStream::new(BufReader::new(file)).map_err(|fault| foreign(fault.to_string()))?;
    let identity = stream.schema().metadata().get(IDENTITY).cloned();
    let identity = identity.ok_or_else(|| foreign("its metadata has no sweep plan".into()))?;
    let mut table = SweepTable {
        identity,
        points: Vec::new(),
        truncated: false,
    };
    loop {
        let batch = match stream.next_batch() {
            Ok(Some(batch)) => batch,
            Ok(None) => return Ok(table),
            Err(_) => {
                table.truncated = true;
                return Ok(table);
            }
        };
        let rows: Vec<Row> =
            serde_arrow::from_record_batch(&batch).map_err(|error| foreign(one_line(error)))?;
        for row in rows {
            table.points.push(row.into_point().map_err(&foreign)?);
        }
    }
}

impl SweepTable {
    /// Checks that the table belongs to `plan` and that all its points are points of the plan.
    ///
    /// # Errors
    /// [`TableError::OtherSweep`] or [`TableError::Invalid`]; they name `path`.
    pub fn check(&self, plan: &SweepPlan, path: &Path) -> Result<(), TableError> {
        check_identity(&self.identity, &plan.identity(), path)?;
        let misplaced = self.points.iter().find(|point| {
            let index = point.place.index;
            index >= plan.len() || plan.place(index) != point.place
        });
        match misplaced {
            None => Ok(()),
            Some(point) => Err(TableError::Invalid {
                path: path.to_owned(),
                reason: format!("its point {} does not match the plan", point.place.index),
            }),
        }
    }
}

/// Checks an identity; the error names the first line that differs.
pub(super) fn check_identity(found: &str, wanted: &str, path: &Path) -> Result<(), TableError> {
    if found == wanted {
        return Ok(());
    }
    let tables = [found, wanted].map(|text| text.parse::<toml::Table>().unwrap_or_default());
    let [found, wanted] = &tables;
    let difference = difference("", found, wanted)
        .unwrap_or_else(|| "its plan is written differently".to_owned());
    Err(TableError::OtherSweep {
        path: path.to_owned(),
        difference,
    })
}

/// The first key whose values differ, with both values.
fn difference(path: &str, found: &toml::Table, wanted: &toml::Table) -> Option<String> {
    let keys = found.keys().chain(wanted.keys());
    let key = keys
        .into_iter()
        .find(|key| found.get(*key) != wanted.get(*key))?;
    let path = format!("{path}{key}");
    let pair = [found, wanted].map(|table| table.get(key));
    match pair {
        [Some(Value::Table(found)), Some(Value::Table(wanted))] => {
            difference(&format!("{path}."), found, wanted)
        }
        [Some(Value::Array(found)), Some(Value::Array(wanted))]
            if found.iter().chain(wanted).all(Value::is_table) =>
        {
            let both = found.iter().zip(wanted);
            let mut both = both.filter_map(|(a, b)| Some((a.as_table()?, b.as_table()?)));
            both.find_map(|(a, b)| difference(&format!("{path}."), a, b))
                .or_else(|| {
                    Some(format!(
                        "`{path}` has {} entries in the file and {} in this sweep",
                        found.len(),
                        wanted.len()
                    ))
                })
        }
        // For the text of a scene: the first line that differs.
        [Some(Value::String(found)), Some(Value::String(wanted))] => {
            let mut pairs = found.lines().zip(wanted.lines());
            let [found, wanted] = match pairs.find(|(a, b)| a != b) {
                Some((found, wanted)) => [found, wanted],
                None => ["a scene", "a longer or shorter one"],
            };
            Some(format!(
                "`{path}` has `{found}` in the file and `{wanted}` in this sweep"
            ))
        }
        pair => {
            let [found, wanted] = pair.map(brief);
            Some(format!(
                "`{path}` is {found} in the file and {wanted} in this sweep"
            ))
        }
    }
}

/// A short form of a value.
fn brief(value: Option<&Value>) -> String {
    match value {
        None => "missing".to_owned(),
        Some(Value::Array(all)) if all.len() > 4 => {
            let ends = [all.first(), all.last()].map(brief);
            format!("{} values from {} to {}", all.len(), ends[0], ends[1])
        }
        Some(value) => value.to_string(),
    }
}

/// Columns of the CSV table after the point's place.
const COLUMNS: [&str; 29] = [
    "settled",
    "transient_s",
    "regime",
    "confidence",
    "amplitude_um",
    "rms_velocity_mm_per_s",
    "peak_velocity_mm_per_s",
    "line_1_hz",
    "line_1_amplitude_um",
    "line_1_name",
    "line_2_hz",
    "line_2_amplitude_um",
    "line_2_name",
    "broadband_share",
    "exponent_1_per_s",
    "exponent_1_half_width_per_s",
    "exponent_2_per_s",
    "exponent_2_half_width_per_s",
    "exponent_3_per_s",
    "exponent_3_half_width_per_s",
    "determinism",
    "recurrence_period_finest_ms",
    "recurrence_period_beat_ms",
    "recurrence_period_doubled_ms",
    "unstable_modes",
    "doubling",
    "section_curves",
    "section_windings",
    "error",
];

/// Writes the CSV table: one row per point with its scalar results, in the units of the column names.
///
/// # Errors
/// [`TableError::Write`]; an existing file is then unchanged.
pub fn write_csv(path: &Path, plan: &SweepPlan, points: &[SweepPoint]) -> Result<(), TableError> {
    let written = replace_file(path, |out| {
        let mut csv = csv::Writer::from_writer(out);
        let axes = plan.axes.iter().map(|axis| axis.parameter().path());
        csv.write_record(["index", "start"].into_iter().chain(axes).chain(COLUMNS))?;
        for point in points {
            csv.write_record(record(point))?;
        }
        csv.flush()
    });
    written.map_err(|OutputError { source, .. }| TableError::Write {
        path: path.to_owned(),
        source,
    })
}

/// Writer of a CSV table, point by point in the order of arrival.
pub struct CsvWriter {
    path: PathBuf,
    csv: csv::Writer<File>,
}

impl CsvWriter {
    /// Creates a table that contains the `known` points. An existing file is replaced.
    ///
    /// # Errors
    /// [`TableError::Write`].
    pub fn new(path: &Path, plan: &SweepPlan, known: &[SweepPoint]) -> Result<Self, TableError> {
        write_csv(path, plan, known)?;
        let file = File::options().append(true).open(path);
        let file = file.map_err(|source| TableError::Write {
            path: path.to_owned(),
            source,
        })?;
        Ok(Self {
            path: path.to_owned(),
            csv: csv::Writer::from_writer(file),
        })
    }

    /// Adds a point and flushes it to the operating system.
    ///
    /// # Errors
    /// [`TableError::Write`].
    pub fn add(&mut self, point: &SweepPoint) -> Result<(), TableError> {
        let written = self
            .csv
            .write_record(record(point))
            .map_err(io::Error::from);
        written
            .and_then(|()| self.csv.flush())
            .map_err(|source| TableError::Write {
                path: self.path.clone(),
                source,
            })
    }
}

/// The CSV row of a point.
fn record(point: &SweepPoint) -> impl Iterator<Item = String> {
    let place = &point.place;
    let head = [place.index.to_string(), place.start.to_string()];
    let values: Vec<String> = place.values.iter().map(f64::to_string).collect();
    head.into_iter().chain(values).chain(cells(point))
}

/// The cells of [`COLUMNS`].
fn cells(point: &SweepPoint) -> [String; COLUMNS.len()] {
    let mut cells = [const { String::new() }; COLUMNS.len()];
    let found = match &point.outcome {
        Ok(found) => found,
        Err(error) => {
            cells[COLUMNS.len() - 1].clone_from(error);
            return cells;
        }
    };
    let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
    let line = |k: usize| match found.lines.get(k) {
        Some(line) => [
            line.frequency.to_string(),
            (1e6 * line.amplitude).to_string(),
            line.label.clone(),
        ],
        None => [const { String::new() }; 3],
    };
    let exponent = |k: usize| {
        let exponent = found.exponents.as_ref().and_then(|s| s.exponents.get(k));
        [exponent.map(|e| e.value), exponent.map(|e| e.half_width)].map(number)
    };
    let period = |found: Option<&RecurrencePeriod>| number(found.map(|found| 1e3 * found.period));
    let curves = |of: fn(&ClosedCurves) -> usize| {
        let count = found.curves.as_ref().map(of);
        count.map(|count| count.to_string()).unwrap_or_default()
    };
    let unstable = found
        .linear
        .as_ref()
        .map(|linear| linear.unstable().count());
    let parts = [
        vec![
            found.settled.to_string(),
            found.transient.to_string(),
            found.regime.to_string(),
            found.confidence.to_string(),
            (1e6 * found.amplitude).to_string(),
            (1e3 * found.rms_velocity).to_string(),
            (1e3 * found.peak_velocity).to_string(),
        ],
        line(0).to_vec(),
        line(1).to_vec(),
        vec![found.broadband_share.to_string()],
        (0..3).flat_map(exponent).collect(),
        vec![
            number(found.recurrence.as_ref().and_then(|r| r.determinism)),
            period(found.recurrence_periods.finest()),
            period(found.recurrence_periods.beat()),
            period(found.recurrence_periods.doubled()),
            unstable.map(|count| count.to_string()).unwrap_or_default(),
            found.doubling.to_string(),
            curves(|curves| curves.count),
            curves(|curves| curves.windings),
        ],
    ];
    for (cell, text) in cells.iter_mut().zip(parts.concat()) {
        *cell = text;
    }
    cells
}

/// The schema of all tables, with the identity of one sweep.
fn schema(identity: &str) -> Result<SchemaRef, serde_arrow::Error> {
    let fields = Row::fields()?;
    let metadata = HashMap::from([(IDENTITY.to_owned(), identity.to_owned())]);
    Ok(Arc::new(Schema::new_with_metadata(fields, metadata)))
}

/// A point as a record batch of one row.
fn batch(schema: &SchemaRef, point: &SweepPoint) -> io::Result<RecordBatch> {
    let fields: Vec<FieldRef> = schema.fields().iter().cloned().collect();
    let rows = [Row::new(point)];
    let batch = serde_arrow::to_record_batch(&fields, &rows).map_err(io::Error::other)?;
    batch.with_schema(schema.clone()).map_err(io::Error::other)
}

/// The I/O error within an Arrow error, if there is one.
fn unwrapped(error: ArrowError) -> io::Error {
    match error {
        ArrowError::IoError(_, source) => source,
        other => io::Error::other(other),
    }
}
