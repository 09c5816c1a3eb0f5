//! A second run next to the first one, for comparison. It starts when a client first asks for it.

use std::sync::{Arc, Mutex};

use crate::live::lock;
use crate::live::session::Session;
use crate::live::session_thread::SessionThread;

/// The second run of a page.
pub(super) struct SecondRun {
    pub session: Arc<Session>,
    thread: Mutex<Option<SessionThread>>,
}

impl SecondRun {
    /// Prepares a run.
    pub fn new(session: Arc<Session>) -> Self {
        Self {
            session,
            thread: Mutex::default(),
        }
    }

    /// Starts the run unless it runs already.
    ///
    /// # Errors
    /// If the thread cannot be started.
    pub fn start(&self) -> Result<(), crate::pipeline::PipelineError> {
        let mut thread = lock(&self.thread);
        if thread.is_none() {
            *thread = Some(SessionThread::start(&self.session)?);
        }
        Ok(())
    }

    /// Ends the run.
    ///
    /// # Errors
    /// The error of the run.
    pub fn end(&self) -> std::io::Result<()> {
        self.session.end();
        let thread = lock(&self.thread).take();
        let ended = thread.map_or(Ok(None), SessionThread::end);
        ended.map(drop).map_err(std::io::Error::other)
    }
}
