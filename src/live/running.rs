//! A session on a thread of its own.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::session::Session;
use crate::pipeline::PipelineError;
use crate::pipeline::message::Summary;

/// How often it is looked whether it has ended.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// A session that goes on beside whoever started it.
#[derive(Debug)]
pub struct Running(JoinHandle<Result<Option<Summary>, PipelineError>>);

impl Running {
    /// Starts a session, see [`Session::run`].
    ///
    /// # Errors
    /// When there is no thread to be had.
    pub fn start(
        session: &Arc<Session>,
        notice: Arc<dyn Fn(&str) + Send + Sync>,
    ) -> Result<Self, PipelineError> {
        let name = "session";
        let session = Arc::clone(session);
        std::thread::Builder::new()
            .name(name.to_owned())
            .spawn(move || session.run(&notice))
            .map(Self)
            .map_err(|source| PipelineError::Thread { name, source })
    }

    /// Whether it has ended.
    pub fn is_over(&self) -> bool {
        self.0.is_finished()
    }

    /// Waits for its end, but not for longer than this.
    pub fn wait(&self, patience: Duration) {
        let until = Instant::now() + patience;
        while !self.is_over() && Instant::now() < until {
            std::thread::sleep(LOOK_EVERY);
        }
    }

    /// What the last run came to; waits for it. `None` if there was none.
    ///
    /// # Errors
    /// Those of [`Session::run`]; a panic is one.
    pub fn end(self) -> Result<Option<Summary>, PipelineError> {
        self.0.join().unwrap_or_else(|panic| {
            Err(PipelineError::Panic {
                name: "session",
                message: crate::pipeline::panic_message(&*panic),
            })
        })
    }
}
