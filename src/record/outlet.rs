//! Where messages leave the program: a file, a viewer, or both at once.
//!
//! Rerun has a sink for several destinations, but its flush does not tell which of them failed.
//! Here that matters: a viewer that is closed must not end a run that is also being saved.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

use rerun::{
    log::LogMsg,
    sink::{FileSink, GrpcSink, LogSink, SinkFlushError},
};

/// Set once the viewer does not take messages any more; shared with the recorder.
#[derive(Clone, Debug, Default)]
pub struct ViewerLost(Arc<AtomicBool>);

impl ViewerLost {
    /// Whether the viewer has gone.
    pub fn get(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }

    fn set(&self) {
        self.0.store(true, Ordering::Release);
    }
}

/// Sends to the file first, then to the viewer as long as it is there.
pub struct FileAndViewer {
    /// The file.
    pub file: FileSink,
    /// The viewer.
    pub viewer: GrpcSink,
    /// Raised when the viewer fails.
    pub lost: ViewerLost,
}

impl LogSink for FileAndViewer {
    fn send(&self, message: LogMsg) {
        if self.lost.get() {
            self.file.send(message);
        } else {
            self.file.send(message.clone());
            self.viewer.send(message);
        }
    }

    /// Fails only when the file fails.
    fn flush_blocking(&self, timeout: Duration) -> Result<(), SinkFlushError> {
        LogSink::flush_blocking(&self.file, timeout)?;
        if !self.lost.get()
            && self
                .viewer
                .flush_blocking(timeout.min(VIEWER_PATIENCE))
                .is_err()
        {
            self.lost.set();
        }
        Ok(())
    }

    fn defers_finalization_to_shutdown(&self) -> bool {
        true
    }
}

/// How long a viewer may take to swallow what was sent.
pub const VIEWER_PATIENCE: Duration = Duration::from_secs(5);
