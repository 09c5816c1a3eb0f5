//! What of a live run goes to a screen: of each kind of picture the latest, a few times a second.

use std::time::{Duration, Instant};

use crate::pipeline::message::Record;
use crate::pipeline::{Delivery, Latest, Sink, SinkError};

/// Wall time between two pictures of a kind.
const BETWEEN: Duration = Duration::from_millis(150);

/// Thins out pictures and the run's health on the way to a viewer, by wall time: at a fast pace they come faster than anybody sees.
pub struct Screen<S> {
    viewer: S,
    waiting: Latest,
}

impl<S: Sink> Screen<S> {
    /// Shows to a viewer.
    pub fn new(viewer: S) -> Self {
        let waiting = Latest::default();
        Self { viewer, waiting }
    }

    /// Shows the pictures whose time has come.
    fn show_due(&mut self) -> Result<(), SinkError> {
        let mut due = self.waiting.take_due(Instant::now(), BETWEEN).into_iter();
        due.try_for_each(|picture| self.viewer.accept(picture))
    }
}

impl<S: Sink> Sink for Screen<S> {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        // Of the health the latest is enough, too.
        if record.is_picture() || matches!(record, Record::Health(_)) {
            self.waiting.put(record);
        } else {
            self.viewer.accept(record)?;
        }
        self.show_due()
    }

    /// The latest pictures of a run that stands still are shown, too.
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

    fn picture(time: f64) -> Record {
        Record::Embedding {
            time,
            points: vec![],
        }
    }

    fn words(time: f64) -> Record {
        let text = String::new();
        Record::Warning { time, text }
    }

    #[test]
    fn the_latest_picture_is_shown_and_words_are_never_lost() {
        let mut screen = Screen::new(Vec::new());
        for k in 0..50 {
            screen.accept(picture(f64::from(k))).unwrap();
            screen.accept(words(f64::from(k))).unwrap();
        }
        screen.finish().unwrap();
        let told = screen
            .viewer
            .iter()
            .filter(|r| matches!(r, Record::Warning { .. }));
        assert_eq!(told.count(), 50);
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
