//! A recording stream whose end is a file: how it is opened, and how the file is made whole.

use std::time::Duration;

use rerun::{
    RecordingStream, RecordingStreamBuilder,
    log::ChunkBatcherConfig,
    sink::{BufferedSink, FileSink, LogSink},
};

use super::{error::RecordError, part_file::PartFile};

/// Wall time that what is logged may wait for more of its kind where a viewer is watching: short enough
/// that views agree.
const WATCHED: Duration = Duration::from_millis(30);
/// The same where there is only a file, which is to be readable to within a second of its end
/// whatever happens. What is logged meanwhile shares its chunks: each has a line in the index, which
/// is kept in memory until the file's end and takes some 6 kB a line.
const UNWATCHED: Duration = Duration::from_millis(800);
/// How long a flush may take before the disk counts as stuck.
pub const FLUSH_PATIENCE: Duration = Duration::from_secs(20);

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

/// Writes into a part file.
pub fn sink(file: &PartFile) -> Result<FileSink, RecordError> {
    FileSink::new(file.part()).map_err(|error| file.write_error(error.to_string()))
}

/// Closes the file of a stream that has been flushed; its index is written then.
pub fn seal(rec: &RecordingStream, file: &PartFile) -> Result<(), RecordError> {
    // Swapping in a sink that keeps nothing drops the one that writes, which adds the index.
    // Rerun reports no failure there, but an index that could not be written adds nothing.
    let before = file.len()?;
    rec.set_sink(Box::new(BufferedSink::new()));
    rec.flush_with_timeout(FLUSH_PATIENCE)
        .map_err(|error| file.write_error(error.to_string()))?;
    if file.len()? <= before {
        return Err(file.write_error("the index at its end is missing".to_owned()));
    }
    Ok(())
}
