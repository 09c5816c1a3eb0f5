//! Pictures that wait, of each kind the latest.

use std::mem::Discriminant;
use std::time::{Duration, Instant};

use super::message::Record;

/// Records that wait, at most one of a kind: a later one replaces an earlier one.
#[derive(Debug, Default)]
pub(crate) struct Latest {
    kinds: Vec<Kind>,
}

/// Records of a kind.
#[derive(Debug)]
struct Kind {
    of: Discriminant<Record>,
    waiting: Option<Record>,
    /// When one was last taken by [`Latest::take_due`].
    taken: Option<Instant>,
}

impl Latest {
    /// Lets a record wait; returns whether it replaces an earlier one.
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

    /// How many wait.
    pub fn len(&self) -> usize {
        let waiting = self.kinds.iter().filter(|kind| kind.waiting.is_some());
        waiting.count()
    }

    /// Takes all that wait.
    pub fn take_all(&mut self) -> Vec<Record> {
        let kinds = self.kinds.iter_mut();
        kinds.filter_map(|kind| kind.waiting.take()).collect()
    }

    /// Takes those of which the last one of the kind was taken long enough ago.
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
