//! A session on its own thread.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::session::Session;
use crate::pipeline::PipelineError;
use crate::pipeline::message::Summary;

/// Polling interval of [`SessionThread::wait`].
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// A session that runs on a background thread.
#[derive(Debug)]
pub struct SessionThread(JoinHandle<Result<Option<Summary>, PipelineError>>);

impl SessionThread {
    /// Starts a session, see [`Session::run`].
    ///
    /// # Errors
    /// If the thread cannot be started.
    pub fn start(session: &Arc<Session>) -> Result<Self, PipelineError> {
        let name = "session";
        let session = Arc::clone(session);
        std::thread::Builder::new()
            .name(name.to_owned())
            .spawn(move || session.run())
            .map(Self)
            .map_err(|source| PipelineError::Thread { name, source })
    }

    /// Whether the session has ended.
    pub fn is_finished(&self) -> bool {
        self.0.is_finished()
    }

    /// Waits for the end of the session, at most for the given time.
    pub fn wait(&self, patience: Duration) {
        let until = Instant::now() + patience;
        while !self.is_finished() && Instant::now() < until {
            std::thread::sleep(LOOK_EVERY);
        }
    }

    /// Waits for the end of the session. Returns the summary of its last run, or `None` if there was none.
    ///
    /// # Errors
    /// Errors of [`Session::run`]. A panic counts as an error.
    pub fn end(self) -> Result<Option<Summary>, PipelineError> {
        self.0.join().unwrap_or_else(|panic| {
            Err(PipelineError::Panic {
                name: "session",
                message: crate::pipeline::panic_message(&*panic),
            })
        })
    }
}
