//! A recording stream into a file: opening, flushing, closing.

use std::{path::Path, sync::Arc, time::Duration};

use super::{
    check_memory,
    error::RecordError,
    part_file::PartFile,
    rrd_file::{RrdEncoder, RrdFile},
    stream::RecordingStream,
};

/// Maximum wall time that rows wait for a larger batch while a viewer is connected: short, so that views
/// agree.
const WATCHED: Duration = Duration::from_millis(30);
/// The same for a file without a viewer. The file must be readable to within a second of its end at any time.
/// Rows of this time share a chunk; each chunk has an entry in the index, which takes about 6 kB of memory
/// until the end of the file.
const UNWATCHED: Duration = Duration::from_millis(800);

/// Maximum wall time that rows wait for a larger batch.
pub fn lag(watched: bool) -> Duration {
    if watched { WATCHED } else { UNWATCHED }
}

/// Saves a recording of an application; `draw` logs its content. The file appears under its name only when it
/// is complete.
///
/// # Errors
/// [`RecordError::Memory`], [`RecordError::Create`], [`RecordError::Write`], [`RecordError::Rename`], and
/// those of `draw`; an existing file at `path` is then unchanged.
pub fn save(
    path: &Path,
    application: &'static str,
    draw: impl FnOnce(&RecordingStream) -> Result<(), RecordError>,
) -> Result<(), RecordError> {
    check_memory()?;
    let file = PartFile::create(path)?;
    let mut rrd = begin(&file)?;
    let rec = RecordingStream::new(application, Arc::new(rrd.writer()))?;
    draw(&rec)?;
    seal(&rec, &mut rrd, &file)?;
    file.commit()
}

/// Starts to write a part file.
pub fn begin(file: &PartFile) -> Result<RrdFile, RecordError> {
    let writing = RrdEncoder::begin(file.part()).map_err(|source| file.creation_error(source))?;
    RrdFile::start(writing).map_err(|source| file.thread_error(source))
}

/// Writes all pending data and returns write errors, which logging does not report.
pub fn flush(rec: &RecordingStream, rrd: &RrdFile, file: &PartFile) -> Result<(), RecordError> {
    rec.send_pending()?;
    rrd.flush().map_err(|reason| file.write_error(reason))?;
    // A file that was removed accepts data that are lost when it is closed.
    file.check_exists()
}

/// Writes all pending data and the index, and closes the file.
pub fn seal(rec: &RecordingStream, rrd: &mut RrdFile, file: &PartFile) -> Result<(), RecordError> {
    flush(rec, rrd, file)?;
    rrd.seal().map_err(|reason| file.write_error(reason))
}
