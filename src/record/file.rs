//! A recording stream into a file, written by its own thread.
//!
//! Rerun's file sink is not used: after an error it reports only that its thread has ended, and half a
//! message remains at the end of the file. Here the system's error is kept, and the file of a failed write
//! ends after a complete message, so every reader can read it. A disk that does not respond delays the caller
//! for a limited time only; in that case alone the thread is not joined.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crate::record::sdk::build_info;
use crate::record::sdk::external::re_log_encoding::{EncodeError, Encoder, EncodingOptions};
use crate::record::sdk::log::LogMsg;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};

use super::check_memory;
use super::error::RecordError;
use super::part_file::PartFile;
use super::stream::{MessageSink, RecordingStream};

/// Maximum number of messages in the queue.
const QUEUE_LENGTH: usize = 16;
/// Time without a response after which a disk counts as stuck.
const DISK_TIMEOUT: Duration = Duration::from_secs(20);

/// Saves a recording of an application; `draw` logs its content. The file appears under its name only when it
/// is complete.
///
/// # Errors
/// [`RecordError::Memory`], [`RecordError::Create`], [`RecordError::Write`], [`RecordError::Rename`], and
/// [`RecordError::Encode`]; an existing file at `path` is then unchanged.
pub fn save(
    path: &Path,
    application: &'static str,
    draw: impl FnOnce(&RecordingStream),
) -> Result<(), RecordError> {
    check_memory()?;
    let mut file = RecordingFile::begin(PartFile::create(path)?)?;
    let rec = RecordingStream::new(application, Arc::new(file.writer()));
    draw(&rec);
    file.seal(&rec)?;
    file.part.commit()
}

/// A recording that is being written to a part file. Dropping it writes the index if possible.
#[derive(Debug)]
pub struct RecordingFile {
    /// The file.
    pub part: PartFile,
    writer: RrdWriter,
    thread: Option<JoinHandle<Result<(), String>>>,
}

/// The writer of an `.rrd` file: sends messages to the thread that writes it.
#[derive(Clone, Debug)]
pub struct RrdWriter {
    commands: Sender<Command>,
    /// The disk did not respond in time.
    stuck: Arc<AtomicBool>,
}

/// A command for the writing thread.
enum Command {
    Write(LogMsg),
    /// Reply when all previous messages are written.
    Flush(Sender<Result<(), String>>),
    /// Write the index and end.
    Seal,
}

impl RecordingFile {
    /// Starts the thread that writes a part file.
    ///
    /// # Errors
    /// [`RecordError::Create`] and [`RecordError::Thread`]; the part file is then removed.
    pub fn begin(part: PartFile) -> Result<Self, RecordError> {
        let open = Open::begin(part.part());
        let open = open.map_err(|error| RecordError::Create(part.abandon(), error))?;
        let (commands, received) = bounded(QUEUE_LENGTH);
        let thread = thread::Builder::new()
            .name("recording".to_owned())
            .spawn(move || write(open, &received))
            .map_err(|error| RecordError::Thread(part.abandon(), error))?;
        let writer = RrdWriter {
            commands,
            stuck: Arc::default(),
        };
        Ok(Self {
            part,
            writer,
            thread: Some(thread),
        })
    }

    /// A handle that sends messages to the file.
    pub fn writer(&self) -> RrdWriter {
        self.writer.clone()
    }

    /// Writes all pending data of a stream and returns write errors, which logging does not report.
    ///
    /// # Errors
    /// [`RecordError::Write`] and [`RecordError::Removed`].
    pub fn flush(&self, rec: &RecordingStream) -> Result<(), RecordError> {
        rec.send_pending()?;
        let written = self.wait();
        written.map_err(|reason| self.part.write_error(reason))?;
        // A file that was removed accepts data that are lost when it is closed.
        self.part.check_exists()
    }

    /// Writes all pending data of a stream and the index, and closes the file.
    ///
    /// # Errors
    /// As [`RecordingFile::flush`].
    pub fn seal(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        self.flush(rec)?;
        let closed = self.close();
        closed.map_err(|reason| self.part.write_error(reason))
    }

    /// Waits until all messages sent so far are written; the error is the reason why they are not.
    fn wait(&self) -> Result<(), String> {
        let (done, answer) = bounded(1);
        self.writer.submit(Command::Flush(done));
        if !self.writer.is_stuck() {
            match answer.recv_timeout(DISK_TIMEOUT) {
                Ok(result) => return result,
                Err(RecvTimeoutError::Disconnected) => {
                    return Err("the writing thread ended".to_owned());
                }
                Err(RecvTimeoutError::Timeout) => self.writer.stuck.store(true, Ordering::Relaxed),
            }
        }
        let seconds = DISK_TIMEOUT.as_secs();
        Err(format!("the disk has not responded for {seconds} s"))
    }

    /// Writes the index and ends the thread; later messages are ignored.
    fn close(&mut self) -> Result<(), String> {
        let flushed = self.wait();
        // No timeout: the disk responded just now, and the time for the index depends on its length.
        match self.thread.take_if(|_| !self.writer.is_stuck()) {
            Some(thread) => {
                self.writer.submit(Command::Seal);
                let ended = thread.join();
                ended.unwrap_or_else(|_| Err("the writing thread panicked".to_owned()))
            }
            None => flushed,
        }
    }
}

impl Drop for RecordingFile {
    fn drop(&mut self) {
        if self.thread.is_some() {
            // The error that caused the drop is reported instead.
            let _ = self.close();
        }
    }
}

impl RrdWriter {
    fn is_stuck(&self) -> bool {
        self.stuck.load(Ordering::Relaxed)
    }

    fn submit(&self, command: Command) {
        if !self.is_stuck()
            && matches!(self.commands.send_timeout(command, DISK_TIMEOUT), Err(error) if error.is_timeout())
        {
            self.stuck.store(true, Ordering::Relaxed);
        }
    }
}

impl MessageSink for RrdWriter {
    fn send(&self, message: LogMsg) {
        self.submit(Command::Write(message));
    }
}

/// The encoder of an open `.rrd` file.
struct Open {
    encoder: Encoder<File>,
    /// The same file, used to remove an incomplete message after a failed write.
    file: File,
    /// Size of the complete messages, bytes.
    complete_bytes: u64,
}

/// Executes commands until the last one or until all senders are dropped. Returns the reason if the file is
/// incomplete.
fn write(mut open: Open, commands: &Receiver<Command>) -> Result<(), String> {
    // After a failed write, the reason; no more messages are written.
    let mut result = Ok(());
    for command in commands {
        let written = match &command {
            Command::Write(message) if result.is_ok() => open.append(message),
            Command::Seal if result.is_ok() => open.encoder.finish(),
            _ => Ok(()),
        };
        if let Err(fault) = written {
            result = Err(open.fail(&fault));
        }
        match command {
            Command::Write(_) => {}
            // The caller may have timed out.
            Command::Flush(done) => drop(done.send(result.clone())),
            Command::Seal => return result,
        }
    }
    Ok(())
}

impl Open {
    /// Starts a recording in an existing empty file.
    ///
    /// # Errors
    /// The error of the system.
    fn begin(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().write(true).open(path)?;
        let encoder = Encoder::new_eager(
            build_info().version,
            EncodingOptions::PROTOBUF_COMPRESSED,
            file.try_clone()?,
        )
        .map_err(|fault| match fault {
            EncodeError::Write(source) => source,
            other => io::Error::other(other),
        })?;
        let complete_bytes = file.metadata()?.len();
        Ok(Self {
            encoder,
            file,
            complete_bytes,
        })
    }

    fn append(&mut self, message: &LogMsg) -> Result<(), EncodeError> {
        self.complete_bytes += self.encoder.append(message)?;
        Ok(())
    }

    /// Stops the encoding, removes an incomplete message, and returns the reason.
    fn fail(&mut self, fault: &EncodeError) -> String {
        // The encoder would otherwise write an index when it is dropped.
        self.encoder.do_not_emit_footer();
        let cut = self.file.set_len(self.complete_bytes);
        let reason = match fault {
            EncodeError::Write(source) => source.to_string(),
            other => other.to_string(),
        };
        match cut {
            Ok(()) => reason,
            Err(uncut) => format!("{reason}, and the last message is incomplete: {uncut}"),
        }
    }
}
