//! A thin layer over the recording stream: rows at a time on the one timeline.

use rerun::{
    AsComponents, RecordingStream, SerializationError, SerializedComponentColumn, TimeCell,
    TimeColumn,
};

use super::{error::RecordError, paths};

/// Nanoseconds on the timeline of a simulated time in s.
pub fn nanos(time: f64) -> i64 {
    (time * 1e9).round() as i64
}

/// Logs one row at a simulated time (s).
pub fn log_at(
    rec: &RecordingStream,
    path: impl Into<rerun::EntityPath>,
    time: f64,
    what: &dyn AsComponents,
) -> Result<(), RecordError> {
    rec.set_time(paths::TIMELINE, TimeCell::from_duration_nanos(nanos(time)));
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
