//! A thin layer over the recording stream: rows, one or many at a time, on the one timeline that a
//! recording has.

use rerun::{
    AsComponents, RecordingStream, SerializationError, SerializedComponentColumn, TimeCell,
    TimeColumn, TimelineName,
};

use super::{error::RecordError, paths};

/// Nanoseconds on the timeline of a simulated time in s.
pub fn nanos(time: f64) -> i64 {
    (time * 1e9).round() as i64
}

/// A place on a timeline. A time in s is one on that of simulated time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    timeline: TimelineName,
    cell: TimeCell,
}

impl Moment {
    /// A tick of a timeline that counts.
    pub fn tick(timeline: TimelineName, tick: i64) -> Self {
        Self {
            timeline,
            cell: TimeCell::from_sequence(tick),
        }
    }
}

impl From<f64> for Moment {
    fn from(time: f64) -> Self {
        Self {
            timeline: paths::TIMELINE.into(),
            cell: TimeCell::from_duration_nanos(nanos(time)),
        }
    }
}

/// Logs one row at a simulated time (s), or at another place on a timeline.
pub fn log_at(
    rec: &RecordingStream,
    path: impl Into<rerun::EntityPath>,
    at: impl Into<Moment>,
    what: &dyn AsComponents,
) -> Result<(), RecordError> {
    let Moment { timeline, cell } = at.into();
    rec.set_time(timeline, cell);
    Ok(rec.log(path, what)?)
}

/// Sends many rows at once; `times` in ns, one a row.
pub fn send_rows<I>(
    rec: &RecordingStream,
    path: &str,
    times: &[i64],
    columns: Result<I, SerializationError>,
) -> Result<(), RecordError>
where
    I: Iterator<Item = SerializedComponentColumn>,
{
    let index = TimeColumn::new_duration_nanos(paths::TIMELINE, times.iter().copied());
    Ok(rec.send_columns(path, [index], columns?)?)
}
