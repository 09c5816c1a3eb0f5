//! Tables of a sweep: an Arrow stream with one record batch per point while it grows, and a finished table as an
//! Arrow file, Parquet or CSV.
//!
//! A stream that ends early can be read up to its last complete batch, also by any other reader of Arrow's streaming
//! format. Each parameter has a column of the name of its key, in the unit of the scene file; all other columns are
//! in SI units, and the tilt in degrees. A failed point has its message in the column `error`; its other results are
//! null.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use arrow_ipc::writer::StreamWriter;
use arrow_schema::SchemaRef;
use serde_json::Value;

use super::row::{IDENTITY, batch, points, schema};
use super::{SweepPlan, SweepPoint};
use crate::export::{OutputError, replace_file};
use crate::foreign::table::read_batches;
use crate::foreign::{one_line, open_file, without_panic};
use crate::study::{StudyError, table};

/// Number of points in a batch of a finished table.
const BATCH: usize = 1024;

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
    /// Plan of the sweep.
    pub plan: SweepPlan,
    /// Identity of the plan ([`SweepPlan::identity`]), which has the version of the program, too.
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
        let failed = |source| TableError::Write(path.to_owned(), source);
        let schema = schema(plan).map_err(failed)?;
        // The old file is replaced only once the new one holds all its points.
        let mut kept = None;
        replace_file(path, |out: &mut BufWriter<&File>| {
            let file = out.get_ref().try_clone()?;
            let mut stream = StreamWriter::try_new(file, &schema).map_err(io::Error::other)?;
            for point in known {
                stream
                    .write(&batch(&schema, &[point])?)
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
        let written = batch(&self.schema, &[point]).and_then(|batch| {
            self.stream.write(&batch).map_err(table::unwrapped)?;
            self.stream.flush().map_err(table::unwrapped)
        });
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
    let mut points: Vec<&SweepPoint> = points.iter().collect();
    points.sort_by_key(|point| point.place.index);
    let write = || {
        let schema = schema(plan)?;
        let batches = points.chunks(BATCH).map(|points| batch(&schema, points));
        let batches = batches.collect::<io::Result<Vec<_>>>()?;
        table::write(path, &schema, &batches).map_err(|error| error.source)
    };
    write().map_err(|source| TableError::Write(path.to_owned(), source))
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
        foreign("its metadata has no sweep plan of this version; choose another --out")
    })?;
    let plan = SweepPlan::from_identity(&identity).map_err(|reason| {
        foreign(&format!(
            "its sweep plan cannot be read ({reason}); it may be of another version: choose another --out"
        ))
    })?;
    let mut found = SweepTable {
        plan,
        identity,
        points: Vec::new(),
        truncated: false,
    };
    for batch in batches {
        let Ok(batch) = batch else {
            found.truncated = true;
            break;
        };
        let read = points(&batch, &found.plan).map_err(|reason| foreign(&one_line(reason)))?;
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
