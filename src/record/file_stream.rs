//! A recording stream whose end is a file: how it is opened, and how the file is made whole.

use std::{mem::ManuallyDrop, path::Path, time::Duration};

use rerun::{
    RecordingStream, RecordingStreamBuilder,
    log::ChunkBatcherConfig,
    sink::{LogSink, SinkFlushError},
};

use super::{check_memory, error::RecordError, part_file::PartFile, rrd_file::RrdFile};

/// Wall time that what is logged may wait for more of its kind where a viewer is watching: short enough
/// that views agree.
const WATCHED: Duration = Duration::from_millis(30);
/// The same where there is only a file, which is to be readable to within a second of its end
/// whatever happens. What is logged meanwhile shares its chunks: each has a line in the index, which
/// is kept in memory until the file's end and takes some 6 kB a line.
const UNWATCHED: Duration = Duration::from_millis(800);
/// How long a flush may take before the disk counts as stuck.
const FLUSH_PATIENCE: Duration = Duration::from_secs(20);

/// Wall time that what is logged may wait for more of its kind.
pub fn lag(watched: bool) -> Duration {
    if watched { WATCHED } else { UNWATCHED }
}

/// A stream of an application into a sink, which a viewer may be watching.
pub fn open(
    application: &'static str,
    sink: Box<dyn LogSink>,
    watched: bool,
) -> Result<RecordingStream, RecordError> {
    let batcher = ChunkBatcherConfig {
        flush_tick: lag(watched),
        ..ChunkBatcherConfig::DEFAULT
    };
    let rec = RecordingStreamBuilder::new(application)
        .batcher_config(batcher)
        .buffered()?;
    // A recording has one timeline, its own; wall-clock ones would double the rows' size.
    rec.set_log_tick_enabled(false);
    rec.set_log_time_enabled(false);
    rec.set_sink(sink);
    Ok(rec)
}

/// Saves a recording of an application that `draw` logs at once. The file takes its name only when it is
/// whole.
///
/// # Errors
/// [`RecordError::Memory`], [`RecordError::Create`], [`RecordError::Write`], [`RecordError::Rename`], and those of `draw`; what
/// was at `path` before is then unchanged.
pub fn save(
    path: &Path,
    application: &'static str,
    draw: impl FnOnce(&RecordingStream) -> Result<(), RecordError>,
) -> Result<(), RecordError> {
    check_memory()?;
    let file = PartFile::create(path)?;
    let rrd = sink(&file)?;
    // After a failure the stream is leaked: dropping it waits for a disk that may never answer.
    let rec = ManuallyDrop::new(open(application, Box::new(rrd.clone()), false)?);
    draw(&rec)?;
    seal(&rec, &rrd, &file)?;
    drop(ManuallyDrop::into_inner(rec));
    file.keep()
}

/// Writes into a part file.
pub fn sink(file: &PartFile) -> Result<RrdFile, RecordError> {
    RrdFile::create(file.part()).map_err(|source| file.refused(source))
}

/// Pushes everything out, and learns of faults: logging itself never reports one.
pub fn flush(rec: &RecordingStream, file: &PartFile) -> Result<(), RecordError> {
    rec.flush_with_timeout(FLUSH_PATIENCE)
        .map_err(|error| match error {
            SinkFlushError::Failed { message } => file.write_error(message),
            SinkFlushError::Timeout => file.write_error(format!(
                "the disk has not answered for {} s",
                FLUSH_PATIENCE.as_secs()
            )),
        })?;
    // A file whose name is gone takes everything and keeps nothing.
    file.still_there()
}

/// Pushes everything out and closes the file; its index is written then.
pub fn seal(rec: &RecordingStream, rrd: &RrdFile, file: &PartFile) -> Result<(), RecordError> {
    flush(rec, file)?;
    rrd.seal().map_err(|reason| file.write_error(reason))
}
