//! Where records go.

use super::message::Record;

/// The error of a sink, whatever its kind.
pub type SinkError = Box<dyn std::error::Error + Send + Sync>;

/// Takes records in order, on one thread. The pipeline's tests use a `Vec`; `record` writes Rerun.
pub trait Sink: Send {
    /// Takes one record.
    ///
    /// # Errors
    /// When the record cannot be kept (disk full, encoding fault); the run then stops.
    fn accept(&mut self, record: Record) -> Result<(), SinkError>;

    /// Called once after the last record: flush all that is pending.
    ///
    /// # Errors
    /// When pending data cannot be written.
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
