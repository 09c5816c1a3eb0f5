//! A recording stream whose end is a file: how it is opened, and how the file is made whole.

use std::time::Duration;

use rerun::{
    RecordingStream, RecordingStreamBuilder,
    log::ChunkBatcherConfig,
    sink::{BufferedSink, FileSink, LogSink},
};

use super::{error::RecordError, part_file::PartFile};

/// Wall time that pictures, logged one by one, may lag behind the columns of samples: short
/// enough that views agree while a run is watched or a file is loading.
const PICTURE_LAG: Duration = Duration::from_millis(20);
/// How long a flush may take before the disk counts as stuck.
pub const FLUSH_PATIENCE: Duration = Duration::from_secs(20);

/// A stream of an application into a sink.
pub fn open(
    application: &'static str,
    sink: Box<dyn LogSink>,
) -> Result<RecordingStream, RecordError> {
    let batcher = ChunkBatcherConfig {
        flush_tick: PICTURE_LAG,
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
