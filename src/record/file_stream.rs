//! A recording stream whose end is a file: how it is opened, and how the file is made whole.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom},
    mem::ManuallyDrop,
    path::Path,
    time::Duration,
};

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

/// Saves a recording of an application that `draw` logs at once. The file takes its name only when it is
/// whole.
///
/// # Errors
/// [`RecordError::Create`], [`RecordError::Write`], [`RecordError::Rename`], and those of `draw`; what
/// was at `path` before is then unchanged.
pub fn save(
    path: &Path,
    application: &'static str,
    draw: impl FnOnce(&RecordingStream) -> Result<(), RecordError>,
) -> Result<(), RecordError> {
    let file = PartFile::create(path)?;
    // After a failure the stream is leaked: dropping it waits for a disk that may never answer.
    let rec = ManuallyDrop::new(open(application, Box::new(sink(&file)?), false)?);
    draw(&rec)?;
    rec.flush_with_timeout(FLUSH_PATIENCE)
        .map_err(|error| file.write_error(error.to_string()))?;
    seal(&rec, &file)?;
    drop(ManuallyDrop::into_inner(rec));
    file.keep()
}

/// Writes into a part file.
pub fn sink(file: &PartFile) -> Result<FileSink, RecordError> {
    FileSink::new(file.part()).map_err(|error| file.write_error(error.to_string()))
}

/// Closes the file of a stream that has been flushed; its index is written then.
pub fn seal(rec: &RecordingStream, file: &PartFile) -> Result<(), RecordError> {
    // Swapping in a sink that keeps nothing drops the one that writes, which adds the index.
    rec.set_sink(Box::new(BufferedSink::new()));
    rec.flush_with_timeout(FLUSH_PATIENCE)
        .map_err(|error| file.write_error(error.to_string()))?;
    // Rerun reports no failure there.
    if !is_whole(file.part()).map_err(|error| file.write_error(error.to_string()))? {
        return Err(file.write_error("its end is missing, as on a full disk".to_owned()));
    }
    Ok(())
}

/// Whether a recording has all that was written to it: at its very end stands where its index is, and
/// that is just before this end. What was lost in between would have moved it.
///
/// The end, 32 bytes: start and length of the index, two 64-bit numbers; its checksum, 32 bits; `RRF2`
/// and `FOOT`; the number of indices, 32 bits, which is 1. All little-endian.
fn is_whole(path: &Path) -> io::Result<bool> {
    const END: u64 = 32;
    let mut file = File::open(path)?;
    let size = file.metadata()?.len();
    if size < END {
        return Ok(false);
    }
    file.seek(SeekFrom::Start(size - END))?;
    let mut end = [0; END as usize];
    file.read_exact(&mut end)?;
    let number = |at: usize| u64::from_le_bytes(std::array::from_fn(|k| end[at + k]));
    let index_end = number(0).checked_add(number(8));
    Ok(end[20..] == *b"RRF2FOOT\x01\0\0\0" && index_end == Some(size - END))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file that lacks bytes anywhere is not taken for whole.
    #[test]
    fn what_a_full_disk_leaves_is_not_whole() {
        let folder = tempfile::tempdir().unwrap();
        let part = PartFile::create(&folder.path().join("a.rrd")).unwrap();
        let rec = open("test", Box::new(sink(&part).unwrap()), false).unwrap();
        rec.log("words", &rerun::TextLog::new("something")).unwrap();
        rec.flush_with_timeout(FLUSH_PATIENCE).unwrap();
        assert!(!is_whole(part.part()).unwrap());
        seal(&rec, &part).unwrap();
        let whole = std::fs::read(part.part()).unwrap();
        let lacking = |from: usize, to: usize| {
            let path = folder.path().join("b");
            std::fs::write(&path, [&whole[..from], &whole[to..]].concat()).unwrap();
            !is_whole(&path).unwrap()
        };
        let size = whole.len();
        assert!(!lacking(size, size));
        assert!(lacking(size - 1, size) && lacking(size - 40, size) && lacking(0, size));
        assert!(lacking(size / 2, size / 2 + 7));
    }
}
