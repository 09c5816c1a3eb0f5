//! Reading back: one column of numbers of any recording, ours or anybody's.
//!
//! A recording holds numbers as rows of the archetype `Scalars`, one or several series a row. A
//! column is one series: `probe/displacement` is the only series of that entity, `modes/q[3]`
//! the fourth (counted from 0) of `modes/q`.

use std::{
    collections::BTreeMap,
    fmt,
    fs::File,
    io::BufReader,
    path::{Path, PathBuf},
};

use rerun::{
    Scalars, SeriesLines, TimelineName,
    external::re_log_encoding::DecoderApp,
    log::{Chunk, LogMsg},
    time::TimeType,
};

use super::paths;

/// A column of numbers with its times.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Path of its entity, with the index of the series where there are several.
    pub name: String,
    /// Unit, if the recording names the series like `displacement, µm`; else empty.
    pub unit: String,
    /// When each value holds, s, not falling. On a timeline of wall-clock time they count from the
    /// first row, because a date in s leaves too few digits for fractions.
    pub times: Vec<f64>,
    /// The values; not always finite.
    pub values: Vec<f64>,
}

/// Why there is no column.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened.
    #[error("cannot open the recording {}; check the path", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The file cannot be decoded.
    #[error("{} is no recording that Rerun {version} reads: {reason}; a recording comes from `--save FILE.rrd`", path.display(), version = super::RERUN_VERSION)]
    Format {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// Nothing was asked for and there is more than one column, or what was asked for is not
    /// there.
    #[error("{} {}; it has {}", path.display(), missing(asked.as_deref()), list(columns))]
    Column {
        /// The file.
        path: PathBuf,
        /// What was asked for.
        asked: Option<String>,
        /// What is there: entity by entity, such as `tilt` or `modes/q[0] to modes/q[10]`.
        columns: Vec<String>,
    },
    /// The column has no time in seconds.
    #[error("column `{column}` of {} has no time: its timelines only count ({}); log it with a duration or a date", path.display(), list(timelines))]
    Time {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
        /// The timelines it has.
        timelines: Vec<String>,
    },
}

fn missing(asked: Option<&str>) -> String {
    match asked {
        Some(column) => format!("has no column `{column}`"),
        None => "has not one column but several, or none; say which".to_owned(),
    }
}

fn list(names: &[String]) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    names.join(", ")
}

/// Reads a column of numbers of a recording: rows in the order of their times. The simulated
/// time of this program is taken if it is there, else a timeline of durations, else one of
/// dates (when a row was logged last of all). `None` takes the only column there is. A recording that breaks off is read as far as
/// it goes; of several in one file, the first.
///
/// # Errors
/// [`ReadError`].
pub fn read_series(path: &Path, column: Option<&str>) -> Result<Series, ReadError> {
    let entities = read_entities(path)?;
    let no_column = || ReadError::Column {
        path: path.to_owned(),
        asked: column.map(str::to_owned),
        columns: entities
            .iter()
            .map(|(name, entity)| entity.columns(name))
            .collect(),
    };
    let (name, index) = match column {
        Some(asked) => split(asked),
        None => {
            let mut names = entities.keys();
            match (names.next(), names.next()) {
                (Some(only), None) => (only.as_str(), None),
                _ => return Err(no_column()),
            }
        }
    };
    let (name, entity) = entities.get_key_value(name).ok_or_else(no_column)?;
    let index = match (index, entity.width) {
        (None, 1) => 0,
        (Some(index), width) if index < width => index,
        _ => return Err(no_column()),
    };
    let label = entity.column(name, index);
    let Some((timeline, is_date)) = entity.clock() else {
        return Err(ReadError::Time {
            path: path.to_owned(),
            column: label,
            timelines: entity.timelines.keys().map(ToString::to_string).collect(),
        });
    };
    let mut rows = entity.rows(timeline, index);
    rows.sort_by_key(|(nanos, _)| *nanos);
    let zero = rows
        .first()
        .map_or(0, |first| if is_date { first.0 } else { 0 });
    Ok(Series {
        name: label,
        unit: entity.unit(index),
        times: rows
            .iter()
            .map(|(nanos, _)| 1e-9 * (nanos - zero) as f64)
            .collect(),
        values: rows.into_iter().map(|(_, value)| value).collect(),
    })
}

/// Entity and index of a column's name.
fn split(column: &str) -> (&str, Option<usize>) {
    let column = column.trim_start_matches('/');
    let indexed = column
        .strip_suffix(']')
        .and_then(|rest| rest.rsplit_once('['))
        .and_then(|(name, index)| Some((name, index.parse().ok()?)));
    indexed.map_or((column, None), |(name, index)| (name, Some(index)))
}

/// All numbers of one entity.
#[derive(Default)]
struct Entity {
    chunks: Vec<Chunk>,
    /// Series a row, at most.
    width: usize,
    /// Names of the series, as far as they are told.
    names: Vec<String>,
    timelines: BTreeMap<TimelineName, TimeType>,
}

impl Entity {
    /// Takes what a chunk says of numbers.
    fn take(&mut self, chunk: Chunk) {
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
        for (name, times) in chunk.timelines() {
            self.timelines.insert(*name, times.timeline().typ());
        }
        self.chunks.push(chunk);
    }

    /// The timeline in seconds that serves best, and whether it tells dates.
    fn clock(&self) -> Option<(TimelineName, bool)> {
        let rank = |(name, kind): (&TimelineName, &TimeType)| match kind {
            TimeType::DurationNs if name.as_str() == paths::TIMELINE => Some(0),
            TimeType::DurationNs => Some(1),
            // Rerun's own, when a row was logged: not when it was measured.
            TimeType::TimestampNs if *name == TimelineName::log_time() => Some(3),
            TimeType::TimestampNs => Some(2),
            TimeType::Sequence => None,
        };
        let ranked = self.timelines.iter();
        let ranked = ranked.filter_map(|(name, kind)| Some((rank((name, kind))?, *name)));
        let (rank, name) = ranked.min()?;
        Some((name, rank >= 2))
    }

    /// Time (ns) and value of every row that has them, in the order of the file.
    fn rows(&self, timeline: TimelineName, index: usize) -> Vec<(i64, f64)> {
        let numbers = Scalars::descriptor_scalars().component;
        let mut rows = Vec::new();
        for chunk in &self.chunks {
            let times = chunk.iter_component_indices(timeline, numbers);
            for ((time, _), values) in times.zip(chunk.iter_slices::<f64>(numbers)) {
                if let Some(value) = values.get(index) {
                    rows.push((time.as_i64(), *value));
                }
            }
        }
        rows
    }

    /// The name of series `index` of the entity `name`.
    fn column(&self, name: &str, index: usize) -> String {
        if self.width == 1 {
            name.to_owned()
        } else {
            format!("{name}[{index}]")
        }
    }

    /// All columns of the entity `name`.
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

/// The entities with numbers, by path.
fn read_entities(path: &Path) -> Result<BTreeMap<String, Entity>, ReadError> {
    let open = |source| ReadError::Open {
        path: path.to_owned(),
        source,
    };
    let format = |reason: &dyn fmt::Display| ReadError::Format {
        path: path.to_owned(),
        reason: reason.to_string(),
    };
    let file = File::open(path).map_err(open)?;
    if file.metadata().map_err(open)?.is_dir() {
        return Err(open(std::io::ErrorKind::IsADirectory.into()));
    }
    let mut entities = BTreeMap::<String, Entity>::new();
    let mut recording = None;
    let mut empty = true;
    for message in DecoderApp::decode_lazy(BufReader::new(file)) {
        empty = false;
        let LogMsg::ArrowMsg(store, message) = message.map_err(|fault| format(&fault))? else {
            continue;
        };
        if store.is_blueprint() || *recording.get_or_insert_with(|| store.clone()) != store {
            continue;
        }
        let chunk = Chunk::from_arrow_msg(&message).map_err(|fault| format(&fault))?;
        let name = chunk.entity_path().to_string();
        let name = name.trim_start_matches('/').to_owned();
        entities.entry(name).or_default().take(chunk);
    }
    if empty {
        return Err(format(&"nothing in it can be read"));
    }
    entities.retain(|_, entity| entity.width > 0);
    Ok(entities)
}

#[cfg(test)]
mod tests {
    use rerun::{RecordingStream, RecordingStreamBuilder, TimeCell};

    use super::*;
    use crate::pipeline::Sink;
    use crate::record::{Output, RerunSink, demo};

    /// A recording of somebody else's, written by `log`.
    fn foreign(path: &Path, log: impl Fn(&RecordingStream)) {
        let rec = RecordingStreamBuilder::new("somebody").save(path).unwrap();
        log(&rec);
        rec.flush_blocking().unwrap();
    }

    #[test]
    fn our_own_recordings_give_back_their_samples() {
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

        for asked in [
            None,
            Some("nothing"),
            Some("modes/q"),
            Some("modes/q[11]"),
            Some("tilt[1]"),
        ] {
            let error = read_series(&path, asked).unwrap_err().to_string();
            assert!(error.contains("modes/q[0] to modes/q[10]"), "{error}");
            assert!(error.contains(asked.unwrap_or("say which")), "{error}");
        }
    }

    #[test]
    fn the_only_column_needs_no_name_and_rows_are_put_in_order() {
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
            "dates count from the first"
        );
    }

    #[test]
    fn a_count_is_no_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("foreign.rrd");
        foreign(&path, |rec| {
            rec.set_log_time_enabled(false);
            rec.set_time("beat", TimeCell::from_sequence(7));
            rec.log("volts", &Scalars::single(1.0)).unwrap();
        });
        let error = read_series(&path, Some("volts")).unwrap_err();
        assert!(matches!(error, ReadError::Time { .. }), "{error:?}");
        assert!(error.to_string().contains("beat"), "{error}");
    }

    #[test]
    fn what_is_no_recording_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("missing.rrd");
        for path in [missing.as_path(), folder.path()] {
            let error = read_series(path, None).unwrap_err();
            assert!(matches!(error, ReadError::Open { .. }), "{error:?}");
            assert!(error.to_string().contains(&path.display().to_string()));
        }
        let other = folder.path().join("other.rrd");
        for bytes in [&b""[..], b"RRF2", b"t,u\n0,1\n", &[0x5a; 4096]] {
            std::fs::write(&other, bytes).unwrap();
            let error = read_series(&other, None).unwrap_err();
            assert!(matches!(error, ReadError::Format { .. }), "{error:?}");
        }
    }
}
