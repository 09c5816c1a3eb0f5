//! A sweep on disk: an Arrow stream, a batch a point, so that whatever is whole can be read.
//!
//! `pyarrow.ipc.open_stream(path).read_pandas()` reads it, and so does any program that reads
//! Arrow's streaming format. A point without a response has its reason in `error` and nothing else.

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
use crate::export::{OutputError, replace_file};
use crate::foreign::arrow::ArrowStream;
use crate::foreign::{one_line, open_file, without_panic};
use crate::study::NoThread;

/// Key of the schema's metadata under which the sweep says what it is ([`SweepPlan::identity`]).
pub const IDENTITY: &str = "squeakscope sweep";

/// Why a table cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The file cannot be opened.
    #[error("cannot read `{path}`")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is no table of a sweep.
    #[error("`{path}` is no table of a sweep: {reason}")]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// It belongs to another sweep.
    #[error(
        "`{path}` is of another sweep: {difference}; give another --out, or the same scene and options"
    )]
    Another {
        /// The file.
        path: PathBuf,
        /// The first thing that differs.
        difference: String,
    },
    /// Writing failed. The points in the file before are still there.
    #[error(
        "writing `{path}` failed; the points written before are kept, and --resume goes on from them"
    )]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The sweep cannot be begun.
    #[error(transparent)]
    Begin(#[from] NoThread),
    /// The file was taken away while points were added to it.
    #[error(
        "`{path}` was removed or moved while the sweep was running, and what comes now would be lost; run again into a folder that stays"
    )]
    Gone {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

/// A table that points are added to.
pub struct TableWriter {
    path: PathBuf,
    schema: SchemaRef,
    stream: StreamWriter<File>,
}

/// A table as read.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepTable {
    /// What it is the table of.
    pub identity: String,
    /// Its points, in the order of the file.
    pub points: Vec<SweepPoint>,
    /// Whether the file breaks off in the middle of a point, which is then not among them.
    pub torn: bool,
}

impl TableWriter {
    /// Starts a table in place of a file of that name, with some points known already.
    ///
    /// # Errors
    /// [`TableError::Write`].
    pub fn new(path: &Path, identity: &str, known: &[SweepPoint]) -> Result<Self, TableError> {
        let failed = |source| TableError::Write {
            path: path.to_owned(),
            source,
        };
        let schema = schema(identity).map_err(|e| failed(io::Error::other(e)))?;
        // The old file stays until all that it holds is in the new one.
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

    /// Adds a point; it is on its way to the disk when this returns.
    ///
    /// # Errors
    /// [`TableError::Write`], [`TableError::Gone`].
    pub fn add(&mut self, point: &SweepPoint) -> Result<(), TableError> {
        let written = batch(&self.schema, point).and_then(|batch| {
            self.stream.write(&batch).map_err(unwrapped)?;
            self.stream.flush().map_err(unwrapped)
        });
        written.map_err(|source| TableError::Write {
            path: self.path.clone(),
            source,
        })?;
        // A file whose name is gone takes everything and keeps nothing.
        let there = self.path.symlink_metadata();
        there.map(drop).map_err(|source| TableError::Gone {
            path: self.path.clone(),
            source,
        })
    }
}

/// Writes a whole table, the points in their order: the same points give the same bytes.
///
/// # Errors
/// [`TableError::Write`]; what was there before is then unchanged.
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

/// Reads a table. One that breaks off, because whoever wrote it was killed, gives all whole points.
///
/// # Errors
/// [`TableError::Read`], [`TableError::Foreign`].
pub fn read_table(path: &Path) -> Result<SweepTable, TableError> {
    // The library panics on some damaged files.
    without_panic(|| read_points(path)).unwrap_or_else(|| {
        Err(TableError::Foreign {
            path: path.to_owned(),
            reason: "it is damaged; take a copy of it, or begin anew".to_owned(),
        })
    })
}

fn read_points(path: &Path) -> Result<SweepTable, TableError> {
    let foreign = |reason: String| TableError::Foreign {
        path: path.to_owned(),
        reason,
    };
    let (file, length) = open_file(path).map_err(|source| TableError::Read {
        path: path.to_owned(),
        source,
    })?;
    if length == 0 {
        return Err(foreign("it is empty; remove it".to_owned()));
    }
    let mut stream =
        ArrowStream::new(BufReader::new(file)).map_err(|fault| foreign(fault.to_string()))?;
    let identity = stream.schema().metadata().get(IDENTITY).cloned();
    let identity = identity.ok_or_else(|| foreign("it does not say what sweep it is of".into()))?;
    let mut table = SweepTable {
        identity,
        points: Vec::new(),
        torn: false,
    };
    loop {
        let batch = match stream.next_batch() {
            Ok(Some(batch)) => batch,
            Ok(None) => return Ok(table),
            Err(_) => {
                table.torn = true;
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
    /// Refuses a table of another sweep than `plan`'s, or one that has no place for a point.
    ///
    /// # Errors
    /// [`TableError::Another`]; `path` is what it was read from.
    pub fn check(&self, plan: &SweepPlan, path: &Path) -> Result<(), TableError> {
        check_identity(&self.identity, &plan.identity(), path)?;
        let misplaced = self.points.iter().find(|point| {
            let index = point.place.index;
            index >= plan.len() || plan.place(index) != point.place
        });
        match misplaced {
            None => Ok(()),
            Some(point) => Err(TableError::Foreign {
                path: path.to_owned(),
                reason: format!("its point {} is not where it should be", point.place.index),
            }),
        }
    }
}

/// Refuses an identity that is not the one wanted, and names the first line that differs.
pub(super) fn check_identity(found: &str, wanted: &str, path: &Path) -> Result<(), TableError> {
    if found == wanted {
        return Ok(());
    }
    let tables = [found, wanted].map(|text| text.parse::<toml::Table>().unwrap_or_default());
    let [found, wanted] = &tables;
    let difference =
        difference("", found, wanted).unwrap_or_else(|| "it says otherwise".to_owned());
    Err(TableError::Another {
        path: path.to_owned(),
        difference,
    })
}

/// The first key whose values differ, with both.
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
                .or_else(|| Some(format!("`{path}` has {} and {}", found.len(), wanted.len())))
        }
        // A scene's text: the first line that differs.
        [Some(Value::String(found)), Some(Value::String(wanted))] => {
            let mut pairs = found.lines().zip(wanted.lines());
            let [found, wanted] = match pairs.find(|(a, b)| a != b) {
                Some((found, wanted)) => [found, wanted],
                None => ["a scene", "a longer or shorter one"],
            };
            Some(format!(
                "`{path}` has `{found}` where now there is `{wanted}`"
            ))
        }
        pair => {
            let [found, wanted] = pair.map(brief);
            Some(format!("`{path}` is {found} where now it is {wanted}"))
        }
    }
}

/// A value in a few words.
fn brief(value: Option<&Value>) -> String {
    match value {
        None => "not there".to_owned(),
        Some(Value::Array(all)) if all.len() > 4 => {
            let ends = [all.first(), all.last()].map(brief);
            format!("{} values from {} to {}", all.len(), ends[0], ends[1])
        }
        Some(value) => value.to_string(),
    }
}

/// Columns of the short table, beside the point's place.
const COLUMNS: [&str; 24] = [
    "settled",
    "transient_s",
    "regime",
    "confidence",
    "amplitude_um",
    "rms_velocity_mm_per_s",
    "peak_velocity_mm_per_s",
    "line_1_hz",
    "line_1_um",
    "line_1_name",
    "line_2_hz",
    "line_2_um",
    "line_2_name",
    "floor_share",
    "exponent_1_per_s",
    "half_width_1_per_s",
    "exponent_2_per_s",
    "half_width_2_per_s",
    "exponent_3_per_s",
    "half_width_3_per_s",
    "determinism",
    "recurrence_period_ms",
    "unstable_modes",
    "error",
];

/// Writes the short table: a row a point with what is one number, in the units of the scene file.
///
/// # Errors
/// [`TableError::Write`]; what was there before is then unchanged.
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

/// A short table that points are added to, in the order in which they come.
pub struct CsvWriter {
    path: PathBuf,
    csv: csv::Writer<File>,
}

impl CsvWriter {
    /// Starts a table in place of a file of that name, with some points known already.
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

    /// Adds a point; it is on its way to the disk when this returns.
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

/// The line of a point.
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
        vec![found.floor_share.to_string()],
        (0..3).flat_map(exponent).collect(),
        vec![
            number(found.recurrence.as_ref().and_then(|r| r.determinism)),
            number(found.recurrence_period.map(|period| 1e3 * period)),
            unstable.map(|count| count.to_string()).unwrap_or_default(),
        ],
    ];
    for (cell, text) in cells.iter_mut().zip(parts.concat()) {
        *cell = text;
    }
    cells
}

/// The schema of all tables, with the identity of one.
fn schema(identity: &str) -> Result<SchemaRef, serde_arrow::Error> {
    let fields = Row::fields()?;
    let metadata = HashMap::from([(IDENTITY.to_owned(), identity.to_owned())]);
    Ok(Arc::new(Schema::new_with_metadata(fields, metadata)))
}

/// A point as a batch of one row.
fn batch(schema: &SchemaRef, point: &SweepPoint) -> io::Result<RecordBatch> {
    let fields: Vec<FieldRef> = schema.fields().iter().cloned().collect();
    let rows = [Row::new(point)];
    let batch = serde_arrow::to_record_batch(&fields, &rows).map_err(io::Error::other)?;
    batch.with_schema(schema.clone()).map_err(io::Error::other)
}

/// The error of the disk, if that is what it is.
fn unwrapped(error: ArrowError) -> io::Error {
    match error {
        ArrowError::IoError(_, source) => source,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Parameter, Scene};
    use crate::study::response::ResponsePlan;
    use crate::study::sweep::tests::run;
    use crate::study::sweep::{Axis, Shard, Start};

    /// A plan with a point that cannot be, and its points.
    fn swept() -> (SweepPlan, Vec<SweepPoint>) {
        let scene = Scene::load("torus-3deg").unwrap();
        let plan = SweepPlan {
            scene: scene
                .with_values(&[(Parameter::named("nodes").unwrap(), 28.0)])
                .unwrap(),
            axes: vec![Axis::new(
                Parameter::named("socket.diameter_mm").unwrap(),
                [31.0, 31.9, 32.0],
            )],
            starts: vec![Start::Up],
            response: ResponsePlan {
                least: 0.02,
                most: 0.02,
                measure: 0.01,
                exponents: 2,
                portrait: true,
                most_calls: None,
            },
        };
        let points = run(&plan, Shard::WHOLE, &[], 1);
        assert!(points[0].outcome.is_err() && points[2].outcome.is_ok());
        (plan, points)
    }

    #[test]
    fn a_table_gives_back_what_was_put_in_and_survives_being_torn() {
        let (plan, points) = swept();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sweep.arrow");
        let mut table = TableWriter::new(&path, &plan.identity(), &points[..1]).unwrap();
        table.add(&points[2]).unwrap();
        table.add(&points[1]).unwrap();
        // As it is after kill -9: no end of the stream.
        let read = read_table(&path).unwrap();
        assert_eq!(read.points, [0, 2, 1].map(|k| points[k].clone()));
        assert!(!read.torn && read.check(&plan, &path).is_ok());
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() - 100]).unwrap();
        let torn = read_table(&path).unwrap();
        assert_eq!((torn.points.len(), torn.torn), (2, true));
        // Going on from it.
        let mut table = TableWriter::new(&path, &torn.identity, &torn.points).unwrap();
        table.add(&points[1]).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), whole);
        // In order, the bytes are those of the points alone.
        let mut shuffled = [2, 0, 1].map(|k| points[k].clone());
        write_table(&path, &plan.identity(), &mut shuffled).unwrap();
        let sorted = std::fs::read(&path).unwrap();
        write_table(&path, &plan.identity(), &mut points.clone()).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), sorted);
        assert_eq!(read_table(&path).unwrap().points, points);
    }

    #[test]
    fn another_sweep_is_refused_with_what_differs() {
        let (plan, points) = swept();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sweep.arrow");
        write_table(&path, &plan.identity(), &mut points.clone()).unwrap();
        let other = SweepPlan {
            starts: vec![Start::Down],
            ..plan
        };
        let refused = read_table(&path).unwrap().check(&other, &path).unwrap_err();
        let words = refused.to_string();
        assert!(
            words.contains("`starts` is [\"up\"] where now it is [\"down\"]"),
            "{words}"
        );
        std::fs::write(&path, "no table").unwrap();
        assert!(matches!(read_table(&path), Err(TableError::Foreign { .. })));
        let missing = read_table(&folder.path().join("missing"));
        assert!(matches!(missing, Err(TableError::Read { .. })));
    }

    #[test]
    fn the_short_table_has_a_cell_for_each_column() {
        let (plan, points) = swept();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sweep.csv");
        write_csv(&path, &plan, &points).unwrap();
        let mut csv = csv::Reader::from_path(&path).unwrap();
        let head = csv.headers().unwrap().clone();
        assert_eq!(&head[2], "socket.diameter_mm");
        let rows: Vec<csv::StringRecord> = csv.records().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 3);
        let cell = |row: usize, name: &str| {
            let place = head.iter().position(|h| h == name).unwrap();
            rows[row][place].to_owned()
        };
        assert!(cell(0, "error").contains("socket.diameter_mm"));
        let found = points[1].outcome.as_ref().unwrap();
        assert_eq!(cell(1, "regime"), found.regime.to_string());
        assert_eq!(cell(1, "unstable_modes"), "4");
        assert_eq!(cell(1, "amplitude_um"), (1e6 * found.amplitude).to_string());
        assert_eq!(
            cell(1, "exponent_2_per_s"),
            found.exponents.as_ref().unwrap().exponents[1]
                .value
                .to_string()
        );
    }
}
