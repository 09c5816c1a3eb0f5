//! The end of a stream that is a file.
//!
//! Rerun has a sink of its own for files, but once it has met a fault it only says that its thread has
//! ended, and half a message stays at the file's end. Here the fault keeps the system's own words, and
//! a file that cannot go on breaks off between two messages, where every reader finds its way.

use std::{
    fmt,
    fs::{File, OpenOptions},
    io,
    path::Path,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use rerun::{
    external::{
        re_build_info::CrateVersion,
        re_log_encoding::{EncodeError, Encoder, EncodingOptions},
    },
    log::LogMsg,
    sink::{LogSink, SinkFlushError},
};

/// Writes messages into a file; the clones write into the same one.
#[derive(Clone)]
pub struct RrdFile(Arc<Mutex<State>>);

enum State {
    Writing(Box<Writing>),
    /// No message can be added any more, and why.
    Broken(String),
    /// The index is at its end.
    Sealed,
}

struct Writing {
    encoder: Encoder<File>,
    /// The same file, to cut off what a failed write leaves of a message.
    file: File,
    /// Bytes of whole messages.
    whole: u64,
}

impl RrdFile {
    /// Begins a recording in a file that is there and empty.
    ///
    /// # Errors
    /// What the system says.
    pub fn create(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().write(true).open(path)?;
        let encoder = Encoder::new_eager(
            CrateVersion::LOCAL,
            EncodingOptions::PROTOBUF_COMPRESSED,
            file.try_clone()?,
        )
        .map_err(|fault| match fault {
            EncodeError::Write(source) => source,
            other => io::Error::other(other),
        })?;
        let whole = file.metadata()?.len();
        let writing = Writing {
            encoder,
            file,
            whole,
        };
        let state = State::Writing(Box::new(writing));
        Ok(Self(Arc::new(Mutex::new(state))))
    }

    /// Writes the index, after which nothing more is taken.
    ///
    /// # Errors
    /// Why the file is not whole.
    pub fn seal(&self) -> Result<(), String> {
        let mut state = self.state();
        if let State::Writing(writing) = &mut *state {
            *state = match writing.encoder.finish() {
                Ok(()) => State::Sealed,
                Err(fault) => writing.broken(&fault),
            };
        }
        match &*state {
            State::Broken(reason) => Err(reason.clone()),
            State::Writing(_) | State::Sealed => Ok(()),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // A panic while a message was being encoded leaves the file as it was before.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Writing {
    /// Gives up, with whole messages only.
    fn broken(&mut self, fault: &EncodeError) -> State {
        // The encoder adds an index when it is dropped, which would come after the gap.
        self.encoder.do_not_emit_footer();
        let cut = self.file.set_len(self.whole);
        let said = match fault {
            EncodeError::Write(source) => source.to_string(),
            other => other.to_string(),
        };
        State::Broken(match cut {
            Ok(()) => said,
            Err(uncut) => format!("{said}, and its last message is torn: {uncut}"),
        })
    }
}

impl LogSink for RrdFile {
    fn send(&self, message: LogMsg) {
        let mut state = self.state();
        if let State::Writing(writing) = &mut *state {
            match writing.encoder.append(&message) {
                Ok(bytes) => writing.whole += bytes,
                Err(fault) => *state = writing.broken(&fault),
            }
        }
    }

    /// Each message is written when it is sent; what is left to do is to tell of faults.
    fn flush_blocking(&self, _: Duration) -> Result<(), SinkFlushError> {
        match &*self.state() {
            State::Broken(reason) => Err(SinkFlushError::failed(reason.clone())),
            State::Writing(_) | State::Sealed => Ok(()),
        }
    }
}

impl fmt::Debug for RrdFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RrdFile").finish_non_exhaustive()
    }
}
