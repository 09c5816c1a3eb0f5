//! Limits the rate of pictures from a live run to a viewer.

use std::time::{Duration, Instant};

use crate::pipeline::message::Record;
use crate::pipeline::{Delivery, LatestPerKind, Sink, SinkError};

/// Minimum wall time between two pictures of a kind.
const BETWEEN: Duration = Duration::from_millis(150);

/// A throttled sink: passes at most one picture of a kind per interval of wall time to a viewer, always the
/// newest. Health records are treated as pictures. All other records are passed unchanged.
pub struct ThrottledSink<S> {
    viewer: S,
    waiting: LatestPerKind,
}

impl<S: Sink> ThrottledSink<S> {
    /// Limits the pictures for a viewer.
    pub fn new(viewer: S) -> Self {
        let waiting = LatestPerKind::default();
        Self { viewer, waiting }
    }

    /// Passes the pictures that are due.
    fn show_due(&mut self) -> Result<(), SinkError> {
        let mut due = self.waiting.take_due(Instant::now(), BETWEEN).into_iter();
        due.try_for_each(|picture| self.viewer.accept(picture))
    }
}

impl<S: Sink> Sink for ThrottledSink<S> {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        // The newest health record is sufficient, too.
        if record.is_picture() || matches!(record, Record::Health(_)) {
            self.waiting.put(record);
        } else {
            self.viewer.accept(record)?;
        }
        self.show_due()
    }

    /// Also passes the last pictures of a paused run.
    fn idle(&mut self) -> Result<(), SinkError> {
        self.show_due()
    }

    fn delivery(&self) -> Delivery {
        Delivery::LatestPictures
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        for picture in self.waiting.take_all() {
            self.viewer.accept(picture)?;
        }
        self.viewer.finish()
    }

    fn abandon(&mut self) {
        self.viewer.abandon();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::{picture_record as picture, text_record as text};

    #[test]
    fn the_newest_picture_is_shown_and_no_text_is_lost() {
        let mut screen = ThrottledSink::new(Vec::new());
        for k in 0..50 {
            screen.accept(picture(f64::from(k))).unwrap();
            screen.accept(text(f64::from(k))).unwrap();
        }
        screen.finish().unwrap();
        let texts = screen
            .viewer
            .iter()
            .filter(|r| matches!(r, Record::Warning { .. }));
        assert_eq!(texts.count(), 50);
        let shown: Vec<f64> = screen
            .viewer
            .iter()
            .filter_map(|record| match record {
                Record::Embedding { time, .. } => Some(*time),
                _ => None,
            })
            .collect();
        assert_eq!(shown.first(), Some(&0.0));
        assert_eq!(shown.last(), Some(&49.0));
        assert!(shown.len() < 50, "{}", shown.len());
    }
}
