//! Consumers of records.

use super::message::Record;

/// Error of any sink.
pub type SinkError = Box<dyn std::error::Error + Send + Sync>;

/// Delivery to a sink: which records it must receive when it is slower than the analysis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Delivery {
    /// Every record. The sender waits.
    #[default]
    Everything,
    /// A waiting picture ([`Record::is_picture`]) may be replaced by a newer one of its kind. The number of
    /// replaced pictures is reported in [`Health::drops`](super::message::Health::drops).
    LatestPictures,
}

/// Consumes records in order, on one thread. The tests of the pipeline use a `Vec`; `record` writes Rerun.
pub trait Sink: Send {
    /// Consumes one record.
    ///
    /// # Errors
    /// If the record cannot be stored (full disk, encoding error). The run then stops.
    fn accept(&mut self, record: Record) -> Result<(), SinkError>;

    /// Which records may be dropped if the sink is too slow; by default none.
    fn delivery(&self) -> Delivery {
        Delivery::Everything
    }

    /// Called repeatedly while no record arrives, for example while an interactive run is paused.
    ///
    /// # Errors
    /// As [`Sink::accept`].
    fn idle(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    /// Called once after the last record. Flushes all pending data.
    ///
    /// # Errors
    /// If pending data cannot be written.
    fn finish(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    /// Called if the run or [`Sink::finish`] has failed. Keeps the partial result readable, but does not
    /// replace an older result with it. After a successful `finish` it does nothing.
    fn abandon(&mut self) {}
}

impl Sink for Vec<Record> {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        self.push(record);
        Ok(())
    }
}

/// Gives events that follow a record.
type EventsOf = Box<dyn FnMut(&Record) -> Vec<Record> + Send>;

/// Passes every record to several sinks.
#[derive(Default)]
pub struct Tee {
    sinks: Vec<Box<dyn Sink>>,
    events: Option<EventsOf>,
}

impl Tee {
    /// Passes records to `sinks` in the given order.
    pub fn new(sinks: Vec<Box<dyn Sink>>) -> Self {
        Self {
            sinks,
            events: None,
        }
    }

    /// Adds the events that `of` gives for a record, after it.
    #[must_use]
    pub fn with_events(self, of: impl FnMut(&Record) -> Vec<Record> + Send + 'static) -> Self {
        Self {
            events: Some(Box::new(of)),
            ..self
        }
    }
}

impl Sink for Tee {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        let events = self.events.as_mut().map(|of| of(&record));
        for record in [record].into_iter().chain(events.unwrap_or_default()) {
            for sink in &mut self.sinks {
                sink.accept(record.clone())?;
            }
        }
        Ok(())
    }

    fn idle(&mut self) -> Result<(), SinkError> {
        self.sinks.iter_mut().try_for_each(|sink| sink.idle())
    }

    fn delivery(&self) -> Delivery {
        // A sink that must receive everything decides.
        let deliveries = self.sinks.iter().map(|sink| sink.delivery());
        deliveries.min().unwrap_or_default()
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        // After the first error the remaining sinks must not replace older results.
        self.sinks.iter_mut().try_for_each(|sink| sink.finish())
    }

    fn abandon(&mut self) {
        self.sinks.iter_mut().for_each(|sink| sink.abandon());
    }
}
