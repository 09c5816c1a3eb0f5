//! Where records go.

use super::message::Record;

/// The error of a sink, whatever its kind.
pub type SinkError = Box<dyn std::error::Error + Send + Sync>;

/// What a sink must be given when it is slower than the analysis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Delivery {
    /// Every record: the sender waits.
    #[default]
    Everything,
    /// Waiting pictures ([`Record::is_picture`]) may be replaced by the latest of their kind;
    /// the sender counts them and says so in [`Health::drops`](super::message::Health::drops).
    LatestPictures,
}

/// Takes records in order, on one thread. The pipeline's tests use a `Vec`; `record` writes Rerun.
pub trait Sink: Send {
    /// Takes one record.
    ///
    /// # Errors
    /// When the record cannot be kept (disk full, encoding fault); the run then stops.
    fn accept(&mut self, record: Record) -> Result<(), SinkError>;

    /// What may be left out when the sink is behind; by default nothing.
    fn delivery(&self) -> Delivery {
        Delivery::Everything
    }

    /// Called now and then while no record comes, as when a steered run stands still.
    ///
    /// # Errors
    /// As [`Sink::accept`].
    fn idle(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    /// Called once after the last record: flush all that is pending.
    ///
    /// # Errors
    /// When pending data cannot be written.
    fn finish(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    /// Called when the run has failed, [`Sink::finish`] included: keep what there is readable, but do
    /// not put it in the place of an older result. After a `finish` that went well it does nothing.
    fn abandon(&mut self) {}
}

impl Sink for Vec<Record> {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        self.push(record);
        Ok(())
    }
}

/// Gives every record to each of several sinks.
#[derive(Default)]
pub struct Tee {
    sinks: Vec<Box<dyn Sink>>,
}

impl Tee {
    /// To all of `sinks`, in their order.
    pub fn new(sinks: Vec<Box<dyn Sink>>) -> Self {
        Self { sinks }
    }
}

impl Sink for Tee {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        self.sinks
            .iter_mut()
            .try_for_each(|sink| sink.accept(record.clone()))
    }

    fn idle(&mut self) -> Result<(), SinkError> {
        self.sinks.iter_mut().try_for_each(|sink| sink.idle())
    }

    fn delivery(&self) -> Delivery {
        let everything = self
            .sinks
            .iter()
            .any(|sink| sink.delivery() == Delivery::Everything);
        if everything {
            Delivery::Everything
        } else {
            Delivery::LatestPictures
        }
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        // The first fault stops the rest: what has not been put in its place yet stays out of it.
        self.sinks.iter_mut().try_for_each(|sink| sink.finish())
    }

    fn abandon(&mut self) {
        self.sinks.iter_mut().for_each(|sink| sink.abandon());
    }
}
