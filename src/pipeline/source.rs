//! Sources of frames.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::PipelineError;
use super::message::{Frame, Header};

/// Yields the frames of a run: a [`Simulation`](super::Simulation), or the [`SignalSource`](super::SignalSource) of a
/// recorded signal.
pub trait Source: Send {
    /// The data known before the first frame. `command` is the command line.
    fn header(&self, command: &str) -> Header;

    /// Sets a flag that stops the run once it is true. The present frame then ends with the last computed
    /// sample. A source whose frames take no time may ignore it.
    fn set_stop_flag(&mut self, stop: &Arc<AtomicBool>) {
        let _ = stop;
    }

    /// The next frame, which starts where the previous one ended; `None` after the last frame, and if the run
    /// was stopped before the first sample of the frame.
    ///
    /// # Errors
    /// If the next frame cannot be computed.
    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError>;

    /// Whether the last frame has been returned.
    fn is_finished(&self) -> bool;
}
