//! Sources of frames, and consumers of records.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::PipelineError;
use super::message::{Frame, Header, Record};

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

/// Error of any sink.
pub type SinkError = Box<dyn std::error::Error + Send + Sync>;

/// Consumes records in order, on one thread. The tests of the pipeline use a `Vec`; `record` writes Rerun.
pub trait Sink: Send {
    /// Consumes one record.
    ///
    /// # Errors
    /// If the record cannot be stored (full disk, encoding error). The run then stops.
    fn accept(&mut self, record: Record) -> Result<(), SinkError>;

    /// Whether a waiting picture ([`Record::is_picture`]) may be replaced by a newer one of its kind when the sink is
    /// slower than the analysis; by default it must receive every record, and the analysis waits. The number of replaced
    /// pictures is reported in [`Health::drops`](super::message::Health::drops).
    fn may_skip_pictures(&self) -> bool {
        false
    }

    /// Called repeatedly while no record arrives, for example while an interactive run is paused.
    ///
    /// # Errors
    /// As [`Sink::accept`].
    fn idle(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    /// Called once after the last record. Flushes all pending data. A sink that is dropped without it belongs to a run that has
    /// failed: its partial result stays readable, but does not replace an older one.
    ///
    /// # Errors
    /// If pending data cannot be written.
    fn finish(&mut self) -> Result<(), SinkError> {
        Ok(())
    }
}

impl Sink for Vec<Record> {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        self.push(record);
        Ok(())
    }
}

/// The records that follow from a record.
type Derive = dyn FnMut(&Record) -> Vec<Record> + Send;

/// Passes every record to several sinks.
pub struct Tee<'a> {
    sinks: Vec<Box<dyn Sink + 'a>>,
    derive: Box<Derive>,
}

impl<'a> Tee<'a> {
    /// Passes records to `sinks` in the given order.
    pub fn new(sinks: Vec<Box<dyn Sink + 'a>>) -> Self {
        let derive = Box::new(|_: &Record| Vec::new());
        Self { sinks, derive }
    }

    /// The same, with the records that a function derives from each record after it.
    pub fn deriving(self, derive: impl FnMut(&Record) -> Vec<Record> + Send + 'static) -> Self {
        let derive = Box::new(derive);
        Self { derive, ..self }
    }
}

impl Sink for Tee<'_> {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        let derived = (self.derive)(&record);
        for record in [record].into_iter().chain(derived) {
            for sink in &mut self.sinks {
                sink.accept(record.clone())?;
            }
        }
        Ok(())
    }

    fn idle(&mut self) -> Result<(), SinkError> {
        self.sinks.iter_mut().try_for_each(|sink| sink.idle())
    }

    fn may_skip_pictures(&self) -> bool {
        // A sink that must receive everything decides.
        self.sinks.iter().all(|sink| sink.may_skip_pictures())
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        // After the first error the remaining sinks must not replace older results.
        self.sinks.iter_mut().try_for_each(|sink| sink.finish())
    }
}
