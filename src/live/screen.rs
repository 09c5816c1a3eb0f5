//! What of a live run goes to a screen: of each kind of picture the latest, a few times a second.

use std::mem::Discriminant;
use std::time::{Duration, Instant};

use crate::pipeline::message::Record;
use crate::pipeline::{Delivery, Sink, SinkError};

/// Wall time between two pictures of a kind.
const BETWEEN: Duration = Duration::from_millis(150);

/// Thins out pictures and the run's health on the way to a viewer, by wall time: at a fast pace they come faster than anybody sees.
pub struct Screen<S> {
    viewer: S,
    kinds: Vec<Kind>,
}

/// Pictures of a kind.
struct Kind {
    of: Discriminant<Record>,
    shown: Option<Instant>,
    /// The latest that has not been shown.
    waiting: Option<Record>,
}

impl<S: Sink> Screen<S> {
    /// Shows to a viewer.
    pub fn new(viewer: S) -> Self {
        Self {
            viewer,
            kinds: Vec::new(),
        }
    }

    /// Shows the pictures whose time has come.
    fn show_due(&mut self, now: Instant) -> Result<(), SinkError> {
        for kind in &mut self.kinds {
            let due = kind.shown.is_none_or(|shown| now >= shown + BETWEEN);
            if due && let Some(picture) = kind.waiting.take() {
                kind.shown = Some(now);
                self.viewer.accept(picture)?;
            }
        }
        Ok(())
    }
}

impl<S: Sink> Sink for Screen<S> {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        // Of the health it is enough, too, to be told of late.
        if !record.is_picture() && !matches!(record, Record::Health(_)) {
            self.viewer.accept(record)?;
            return self.show_due(Instant::now());
        }
        let of = std::mem::discriminant(&record);
        match self.kinds.iter_mut().find(|kind| kind.of == of) {
            Some(kind) => kind.waiting = Some(record),
            None => self.kinds.push(Kind {
                of,
                shown: None,
                waiting: Some(record),
            }),
        }
        self.show_due(Instant::now())
    }

    /// The latest pictures of a run that stands still are shown, too.
    fn idle(&mut self) -> Result<(), SinkError> {
        self.show_due(Instant::now())
    }

    fn delivery(&self) -> Delivery {
        Delivery::LatestPictures
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        for kind in &mut self.kinds {
            if let Some(picture) = kind.waiting.take() {
                self.viewer.accept(picture)?;
            }
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
        Record::Narration { time, text }
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
            .filter(|r| matches!(r, Record::Narration { .. }));
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
