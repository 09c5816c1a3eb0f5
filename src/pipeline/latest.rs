//! Buffer for pictures that keeps the newest of each kind.

use std::mem::Discriminant;
use std::time::{Duration, Instant};

use super::message::Record;

/// Buffered records, at most one of each kind. A new record replaces the buffered one.
#[derive(Debug, Default)]
pub(crate) struct LatestPerKind {
    kinds: Vec<Kind>,
}

/// Buffer of one kind of record.
#[derive(Debug)]
struct Kind {
    of: Discriminant<Record>,
    waiting: Option<Record>,
    /// Time at which [`LatestPerKind::take_due`] last returned a record of this kind.
    taken: Option<Instant>,
}

impl LatestPerKind {
    /// Buffers a record. Returns whether it replaces an older one.
    pub fn put(&mut self, record: Record) -> bool {
        let of = std::mem::discriminant(&record);
        match self.kinds.iter_mut().find(|kind| kind.of == of) {
            Some(kind) => kind.waiting.replace(record).is_some(),
            None => {
                self.kinds.push(Kind {
                    of,
                    waiting: Some(record),
                    taken: None,
                });
                false
            }
        }
    }

    /// Number of buffered records.
    pub fn len(&self) -> usize {
        let waiting = self.kinds.iter().filter(|kind| kind.waiting.is_some());
        waiting.count()
    }

    /// Removes and returns all buffered records.
    pub fn take_all(&mut self) -> Vec<Record> {
        let kinds = self.kinds.iter_mut();
        kinds.filter_map(|kind| kind.waiting.take()).collect()
    }

    /// Removes and returns the records of those kinds that were last returned at least `between` ago.
    pub fn take_due(&mut self, now: Instant, between: Duration) -> Vec<Record> {
        let is_due = |kind: &&mut Kind| kind.taken.is_none_or(|taken| now >= taken + between);
        let due = self.kinds.iter_mut().filter(is_due);
        let taken = due.filter_map(|kind| {
            let record = kind.waiting.take()?;
            kind.taken = Some(now);
            Some(record)
        });
        taken.collect()
    }
}
