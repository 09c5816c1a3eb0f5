//! Reading a column of numbers from a recording of this program or of another one.
//!
//! A recording stores numbers as rows of the archetype `Scalars`, with one or several series per row. A
//! column is one series: `probe/displacement` is the only series of that entity, `modes/q[3]` the fourth
//! series (counted from 0) of `modes/q`.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;

use crate::record::sdk::{Scalars, SeriesLines, TimelineName, log::Chunk, time::TimeType};

use super::messages::{Chunks, Damage};
use super::{RERUN_VERSION, paths};
use crate::foreign::{open_file, without_panic};

/// Maximum number of rows of a column. A row takes 32 bytes while it is read.
const MAX_ROWS: usize = 100_000_000;

/// A column of numbers with its times.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Path of the entity, with the index of the series if there are several.
    pub name: String,
    /// Unit, if the name of the series has the form `displacement, µm`; else empty.
    pub unit: String,
    /// Time of each value, s, in ascending order. On a timeline of wall-clock time they are relative to the
    /// first row, because a date in s leaves too few digits for fractions.
    pub times: Vec<f64>,
    /// The values; they can be non-finite.
    pub values: Vec<f64>,
    /// Damage or truncation of the recording; the data after it are not read.
    pub damage: Option<Damage>,
}

/// A recording, or a column of it, that cannot be read: which, why, and the remedy.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct ReadError {
    message: String,
    /// Error of the system, if the file cannot be opened.
    source: Option<io::Error>,
}

impl From<String> for ReadError {
    fn from(message: String) -> Self {
        let source = None;
        Self { message, source }
    }
}

/// A file that is no recording.
fn no_recording(path: &Path, reason: &str) -> ReadError {
    let file = path.display();
    let wanted = format!("a recording that Rerun {RERUN_VERSION} can read");
    format!("{file} is not {wanted}: {reason}; create one with `--save FILE.rrd`").into()
}

/// Names separated by commas.
fn list(names: &[String]) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    names.join(", ")
}

/// Reads a column of numbers of a recording, with the rows in the order of their times. The timeline is the
/// simulated time of this program if available, else a timeline of durations, else one of dates (the log time
/// of a row is the last choice). `None` selects the only column, or the displacement of the probe in a recording
/// of this program. Of several recordings in one file, the first is read.
///
/// A truncated or damaged recording is read up to the damage, which [`Series::damage`] describes. Lengths in
/// the file are not trusted: the memory used is that of the column and of one message.
///
/// # Errors
/// [`ReadError`] if the file cannot be read or the column does not exist.
pub fn read_series(path: &Path, column: Option<&str>) -> Result<Series, ReadError> {
    without_panic(|| read(path, column, MAX_ROWS))
        .unwrap_or_else(|| Err(no_recording(path, "the data cannot be decoded")))
}

/// Checks that a file is a recording that this version of Rerun can read.
///
/// # Errors
/// If it cannot be opened, or is another file.
pub fn check_recording(path: &Path) -> Result<(), ReadError> {
    open(path).map(drop)
}

/// Opens a recording.
fn open(path: &Path) -> Result<Chunks<BufReader<File>>, ReadError> {
    let shown = path.display();
    let (file, _) = open_file(path).map_err(|source| ReadError {
        message: format!("cannot open the recording {shown}; check the path"),
        source: Some(source),
    })?;
    Chunks::new(file).map_err(|fault| no_recording(path, &fault.to_string()))
}

fn read(path: &Path, column: Option<&str>, most: usize) -> Result<Series, ReadError> {
    let file = path.display();
    let asked = column.map(split);
    let (mut entities, damage) = read_entities(path, asked, most)?;
    let (name, index) = match (asked, entities.first_key_value()) {
        (Some((name, index)), _) => (name.to_owned(), index),
        (None, Some((only, _))) if entities.len() == 1 => (only.clone(), None),
        (None, _) => (String::new(), None),
    };
    let width = |name: &str| entities.get(name).map_or(0, |entity| entity.width);
    let index = match (index, width(&name)) {
        (None, 1) => 0,
        (Some(index), width) if index < width => index,
        _ if column.is_none() && width(paths::DISPLACEMENT) == 1 => {
            return read(path, Some(paths::DISPLACEMENT), most);
        }
        _ => {
            let missing = match column {
                Some(column) => format!("has no column `{column}`"),
                None => "does not have exactly one column; specify one".to_owned(),
            };
            let columns = entities.iter().map(|(name, entity)| entity.columns(name));
            let damaged = damage.map_or_else(String::new, |damage| {
                format!("; the recording is damaged at {damage}")
            });
            let columns = list(&columns.collect::<Vec<_>>());
            let text = format!("{file} {missing}; available columns: {columns}{damaged}");
            return Err(text.into());
        }
    };
    let mut entity = entities.remove(&name).unwrap_or_default();
    let label = entity.column(&name, index);
    let Some(clock) = entity.clock else {
        let timelines = entity.timelines.keys().map(ToString::to_string);
        let timelines = list(&timelines.collect::<Vec<_>>());
        let text = format!(
            "column `{label}` of {file} has no time: its timelines are sequence numbers ({timelines}); \
             log it with a duration or a date"
        );
        return Err(text.into());
    };
    entity.rows.sort_by_key(|(nanos, _)| *nanos);
    let first = entity.rows.first().map_or(0, |first| first.0);
    // Dates start at the first row.
    let zero = if clock.rank >= 2 { first } else { 0 };
    let seconds = |(nanos, _): &(i64, f64)| 1e-9 * nanos.saturating_sub(zero) as f64;
    Ok(Series {
        name: label,
        unit: entity.unit(index),
        times: entity.rows.iter().map(seconds).collect(),
        values: entity.rows.iter().map(|(_, value)| *value).collect(),
        damage,
    })
}

/// Splits the name of a column into entity and index.
fn split(column: &str) -> (&str, Option<usize>) {
    let column = column.trim_start_matches('/');
    let indexed = column.strip_suffix(']');
    let indexed = indexed.and_then(|rest| rest.rsplit_once('['));
    let indexed = indexed.and_then(|(name, index)| Some((name, index.parse().ok()?)));
    indexed.map_or((column, None), |(name, index)| (name, Some(index)))
}

/// The numbers of one entity.
#[derive(Default)]
struct Entity {
    /// Maximum number of series per row.
    width: usize,
    /// Names of the series, if logged.
    names: Vec<String>,
    timelines: BTreeMap<TimelineName, TimeType>,
    /// The best timeline in seconds found so far.
    clock: Option<Clock>,
    /// Time (ns on that timeline) and value of every row of the requested series, in the order of the file.
    rows: Vec<(i64, f64)>,
}

/// A timeline in seconds; a lower rank is preferred.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Clock {
    rank: u8,
    timeline: TimelineName,
}

impl Clock {
    fn of(timeline: TimelineName, kind: TimeType) -> Option<Self> {
        let rank = match kind {
            TimeType::DurationNs if timeline.as_str() == paths::TIMELINE => 0,
            TimeType::DurationNs => 1,
            // Rerun's log time is the time of logging, not of the measurement.
            TimeType::TimestampNs if timeline == TimelineName::log_time() => 3,
            TimeType::TimestampNs => 2,
            TimeType::Sequence => return None,
        };
        Some(Self { rank, timeline })
    }
}

impl Entity {
    /// Adds the information of a chunk, and the rows of the requested series.
    fn take(&mut self, chunk: &Chunk, wanted: Option<usize>) {
        let names = SeriesLines::descriptor_names().component;
        for row in chunk.iter_slices::<String>(names) {
            self.names = row.iter().map(|name| name.to_string()).collect();
        }
        let numbers = Scalars::descriptor_scalars().component;
        let widths = chunk.iter_slices::<f64>(numbers).map(<[f64]>::len);
        let width = widths.max().unwrap_or(0);
        if width == 0 || chunk.is_static() {
            return;
        }
        self.width = self.width.max(width);
        let mut here = None;
        for (name, times) in chunk.timelines() {
            let kind = times.timeline().typ();
            self.timelines.insert(*name, kind);
            here = [here, Clock::of(*name, kind)].into_iter().flatten().min();
        }
        if let (Some(index), Some(clock)) = (wanted, here) {
            self.take_rows(chunk, index, clock);
        }
    }

    /// Adds the rows of a chunk unless a better timeline is known.
    fn take_rows(&mut self, chunk: &Chunk, index: usize, here: Clock) {
        let known = *self.clock.get_or_insert(here);
        if here > known {
            return;
        }
        if here < known {
            self.rows.clear();
            self.clock = Some(here);
        }
        let numbers = Scalars::descriptor_scalars().component;
        let times = chunk.iter_component_indices(here.timeline, numbers);
        for ((time, _), values) in times.zip(chunk.iter_slices::<f64>(numbers)) {
            if let Some(value) = values.get(index) {
                self.rows.push((time.as_i64(), *value));
            }
        }
    }

    /// Name of series `index` of the entity `name`.
    fn column(&self, name: &str, index: usize) -> String {
        if self.width == 1 {
            name.to_owned()
        } else {
            format!("{name}[{index}]")
        }
    }

    /// Names of all columns of the entity `name`.
    fn columns(&self, name: &str) -> String {
        match self.width {
            1 => name.to_owned(),
            width => format!("{name}[0] to {name}[{}]", width - 1),
        }
    }

    fn unit(&self, index: usize) -> String {
        let name = self.names.get(index);
        let unit = name.and_then(|name| name.rsplit_once(", "));
        unit.map_or_else(String::new, |(_, unit)| unit.to_owned())
    }
}

/// The entities with numbers, by path, and the damage of the recording. The rows are those of the requested
/// series, or of the first one.
fn read_entities(
    path: &Path,
    asked: Option<(&str, Option<usize>)>,
    most: usize,
) -> Result<(BTreeMap<String, Entity>, Option<Damage>), ReadError> {
    let file = path.display();
    let mut chunks = open(path)?;
    let mut entities = BTreeMap::<String, Entity>::new();
    let mut first = None;
    let index = asked.and_then(|(_, index)| index).unwrap_or(0);
    for chunk in &mut chunks {
        let name = chunk.entity_path().to_string();
        let name = name.trim_start_matches('/').to_owned();
        let wanted = asked.map(|(name, _)| name).or(first.as_deref());
        let is_wanted = wanted.is_none_or(|wanted| wanted == name);
        let entity = entities.entry(name.clone()).or_default();
        entity.take(&chunk, is_wanted.then_some(index));
        if entity.rows.len() > most {
            let column = entity.column(&name, index);
            let rows = format!("more than {most} rows; split the recording");
            return Err(format!("column `{column}` of {file} has {rows}").into());
        }
        if entity.width > 0 {
            first.get_or_insert(name);
        }
    }
    entities.retain(|_, entity| entity.width > 0);
    match chunks.damage() {
        Some(damage) if entities.is_empty() => {
            let none = "there are no numbers before the damage";
            Err(format!("{file} is damaged at {damage}; {none}").into())
        }
        damage => Ok((entities, damage)),
    }
}

#[cfg(test)]
mod tests {
    use crate::record::sdk::{RecordingStream, RecordingStreamBuilder, TimeCell};

    use super::*;
    use crate::pipeline::Sink;
    use crate::record::{Output, RerunSink, tests::demo};

    /// A recording of another program, written by `log`.
    fn foreign(path: &Path, log: impl Fn(&RecordingStream)) {
        let rec = RecordingStreamBuilder::new("other").save(path).unwrap();
        log(&rec);
        rec.flush_blocking().unwrap();
    }

    #[test]
    fn recordings_of_this_program_return_their_samples() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.rrd");
        let output = Output {
            save: Some(path.clone()),
            ..Output::default()
        };
        let mut sink = RerunSink::new(&output, demo::spec()).unwrap();
        for record in demo::records(0.01) {
            sink.accept(record).unwrap();
        }
        sink.finish().unwrap();

        let series = read_series(&path, Some(paths::DISPLACEMENT)).unwrap();
        assert_eq!(
            (series.name.as_str(), series.unit.as_str()),
            ("probe/displacement", "µm")
        );
        assert_eq!(series.values.len(), demo::samples(0.01));
        assert_eq!(series.times.len(), series.values.len());
        for (k, time) in series.times.iter().enumerate() {
            assert!((time - k as f64 / demo::SAMPLE_RATE).abs() < 1e-12);
        }
        let expected = demo::displacement(0.01);
        for (found, expected) in series.values.iter().zip(expected) {
            assert!((found - 1e6 * expected).abs() < 1e-12);
        }
        let mode = read_series(&path, Some("/modes/q[10]")).unwrap();
        assert_eq!(mode.name, "modes/q[10]");
        assert_eq!(mode.values.len(), series.values.len());

        let count = series.values.len();
        assert_eq!(
            read(&path, Some(paths::DISPLACEMENT), count).unwrap(),
            series
        );
        let refused = read(&path, Some(paths::DISPLACEMENT), count - 1).unwrap_err();
        assert!(refused.to_string().contains("more than"), "{refused}");

        // Unasked, it is the displacement of the probe.
        assert_eq!(read_series(&path, None).unwrap(), series);
        for asked in ["nothing", "modes/q", "modes/q[11]", "tilt[1]"] {
            let error = read_series(&path, Some(asked)).unwrap_err().to_string();
            assert!(error.contains("modes/q[0] to modes/q[10]"), "{error}");
            assert!(error.contains(asked), "{error}");
        }
    }

    #[test]
    fn the_only_column_needs_no_name_and_rows_are_sorted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("foreign.rrd");
        foreign(&path, |rec| {
            for k in [2, 0, 1] {
                let date =
                    TimeCell::from_timestamp_nanos_since_epoch(1_700_000_000_000_000_000 + k);
                rec.set_time("capture", date);
                rec.set_time("beat", TimeCell::from_sequence(7));
                rec.log("volts", &Scalars::single(k as f64)).unwrap();
            }
        });
        let series = read_series(&path, None).unwrap();
        assert_eq!((series.name.as_str(), series.unit.as_str()), ("volts", ""));
        assert_eq!(series.values, [0.0, 1.0, 2.0]);
        assert_eq!(
            series.times,
            [0.0, 1e-9, 2e-9],
            "dates are relative to the first row"
        );
    }

    #[test]
    fn a_sequence_is_not_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("foreign.rrd");
        foreign(&path, |rec| {
            rec.set_log_time_enabled(false);
            rec.set_time("beat", TimeCell::from_sequence(7));
            rec.log("volts", &Scalars::single(1.0)).unwrap();
        });
        let error = read_series(&path, Some("volts")).unwrap_err();
        let message = error.to_string();
        assert!(
            message.contains("has no time") && message.contains("beat"),
            "{error}"
        );
    }

    #[test]
    fn files_that_are_not_recordings_are_rejected() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("missing.rrd");
        for path in [missing.as_path(), folder.path()] {
            let error = read_series(path, None).unwrap_err();
            assert!(error.source.is_some(), "{error:?}");
            assert!(error.to_string().contains(&path.display().to_string()));
        }
        let other = folder.path().join("other.rrd");
        for bytes in [&b""[..], b"RRF2", b"t,u\n0,1\n", &[0x5a; 4096]] {
            std::fs::write(&other, bytes).unwrap();
            let error = read_series(&other, None).unwrap_err();
            let message = error.to_string();
            assert!(message.contains("is not a recording"), "{error:?}");
        }
        foreign(&other, |_| {});
        let bytes = std::fs::read(&other).unwrap();
        std::fs::write(&other, &bytes[..20]).unwrap();
        let error = read_series(&other, None).unwrap_err();
        assert!(error.to_string().contains("damaged at byte 12"), "{error}");
    }
}
