//! Buffer for pictures that keeps the newest of each kind.

use std::mem::discriminant;

use super::message::Record;

/// Buffered records, at most one of each kind. A new record replaces the buffered one.
#[derive(Debug, Default)]
pub(super) struct LatestPerKind(Vec<Record>);

impl LatestPerKind {
    /// Buffers a record. Returns whether it replaces an older one.
    pub fn put(&mut self, record: Record) -> bool {
        let kind = discriminant(&record);
        match self.0.iter_mut().find(|known| discriminant(*known) == kind) {
            Some(known) => {
                *known = record;
                true
            }
            None => {
                self.0.push(record);
                false
            }
        }
    }

    /// Number of buffered records.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Removes and returns all buffered records.
    pub fn take_all(&mut self) -> Vec<Record> {
        std::mem::take(&mut self.0)
    }
}
