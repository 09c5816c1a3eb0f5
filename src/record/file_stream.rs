//! A recording stream whose end is a file: how it is opened, and how the file is made whole.

use std::{path::Path, sync::Arc, time::Duration};

use super::{
    check_memory,
    error::RecordError,
    part_file::PartFile,
    rrd_file::{RrdFile, Writing},
    stream::RecordingStream,
};

/// Wall time that what is logged may wait for more of its kind where a viewer is watching: short enough
/// that views agree.
const WATCHED: Duration = Duration::from_millis(30);
/// The same where there is only a file, which is to be readable to within a second of its end
/// whatever happens. What is logged meanwhile shares its chunks: each has a line in the index, which
/// is kept in memory until the file's end and takes some 6 kB a line.
const UNWATCHED: Duration = Duration::from_millis(800);

/// Wall time that what is logged may wait for more of its kind.
pub fn lag(watched: bool) -> Duration {
    if watched { WATCHED } else { UNWATCHED }
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
    let mut rrd = begin(&file)?;
    let rec = RecordingStream::new(application, Arc::new(rrd.writer()))?;
    draw(&rec)?;
    seal(&rec, &mut rrd, &file)?;
    file.keep()
}

/// Begins to write into a part file.
pub fn begin(file: &PartFile) -> Result<RrdFile, RecordError> {
    let writing = Writing::begin(file.part()).map_err(|source| file.refused(source))?;
    RrdFile::start(writing).map_err(|source| file.without_thread(source))
}

/// Pushes everything out, and learns of faults: logging itself never reports one.
pub fn flush(rec: &RecordingStream, rrd: &RrdFile, file: &PartFile) -> Result<(), RecordError> {
    rec.send_waiting()?;
    rrd.flush().map_err(|reason| file.write_error(reason))?;
    // A file whose name is gone takes everything and keeps nothing.
    file.still_there()
}

/// Pushes everything out and closes the file; its index is written then.
pub fn seal(rec: &RecordingStream, rrd: &mut RrdFile, file: &PartFile) -> Result<(), RecordError> {
    flush(rec, rrd, file)?;
    rrd.seal().map_err(|reason| file.write_error(reason))
}
