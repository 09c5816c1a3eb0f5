//! Sender of the channel to the recorder.

use std::mem::discriminant;

use crossbeam_channel::{Sender, TrySendError};

use super::endpoints::{Sink, SinkError};
use super::message::Record;

/// Error of a channel that is closed; the recorder has the reason.
const STOPPED: &str = "the recorder has stopped";

/// Sends records to the recorder. If the sink permits it, a picture that cannot be sent at once may be
/// replaced by the next one of its kind. Samples, texts and numbers always wait.
#[derive(Debug)]
pub(super) struct RecordSender {
    sender: Sender<Record>,
    /// See [`Sink::may_skip_pictures`].
    may_skip_pictures: bool,
    /// Pictures that could not be sent yet, at most one of each kind.
    buffered: Vec<Record>,
    drops: u64,
}

impl RecordSender {
    pub fn new(sender: Sender<Record>, may_skip_pictures: bool) -> Self {
        Self {
            sender,
            may_skip_pictures,
            buffered: Vec::new(),
            drops: 0,
        }
    }

    /// Number of pictures replaced so far.
    pub fn drops(&self) -> u64 {
        self.drops
    }

    /// Number of records that wait for the recorder.
    pub fn waiting(&self) -> usize {
        self.sender.len() + self.buffered.len()
    }

    /// Sends all buffered pictures and waits until they are accepted.
    pub fn flush(&mut self) -> Result<(), SinkError> {
        for record in self.buffered.drain(..) {
            self.sender.send(record).map_err(|_| STOPPED)?;
        }
        Ok(())
    }

    fn send_or_buffer(&mut self, record: Record) -> Result<(), SinkError> {
        match self.sender.try_send(record) {
            Ok(()) => Ok(()),
            Err(TrySendError::Disconnected(_)) => Err(STOPPED.into()),
            Err(TrySendError::Full(record)) => {
                let waiting = self.buffered.len();
                self.buffered
                    .retain(|known| discriminant(known) != discriminant(&record));
                self.drops += (waiting - self.buffered.len()) as u64;
                self.buffered.push(record);
                Ok(())
            }
        }
    }
}

impl Sink for RecordSender {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        if self.may_skip_pictures {
            for buffered in std::mem::take(&mut self.buffered) {
                self.send_or_buffer(buffered)?;
            }
            if record.is_picture() {
                return self.send_or_buffer(record);
            }
        }
        Ok(self.sender.send(record).map_err(|_| STOPPED)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A record that a newer one replaces.
    fn picture(time: f64) -> Record {
        Record::Embedding {
            time,
            points: vec![],
        }
    }

    /// A record that is never dropped.
    fn text(time: f64) -> Record {
        let text = String::new();
        Record::Warning { time, text }
    }

    /// While the recorder is blocked, the newest picture of a kind is kept and no text is lost.
    #[test]
    fn the_newest_picture_replaces_older_ones() {
        let (sender, receiver) = crossbeam_channel::bounded(1);
        let mut record_sender = RecordSender::new(sender, true);
        record_sender.accept(text(0.0)).unwrap();
        for k in 1..=5 {
            record_sender.accept(picture(f64::from(k))).unwrap();
        }
        assert_eq!((record_sender.drops(), record_sender.waiting()), (4, 2));
        let reader = std::thread::spawn(move || receiver.iter().collect::<Vec<_>>());
        record_sender.flush().unwrap();
        record_sender.accept(text(6.0)).unwrap();
        drop(record_sender);
        let got = reader.join().unwrap();
        assert!(matches!(got[0], Record::Warning { time: 0.0, .. }));
        assert!(matches!(got[1], Record::Embedding { time: 5.0, .. }));
        assert!(matches!(got[2], Record::Warning { time: 6.0, .. }));
        assert_eq!(got.len(), 3);
    }

    #[test]
    fn every_picture_waits_when_saving() {
        let (sender, receiver) = crossbeam_channel::bounded(1);
        let mut record_sender = RecordSender::new(sender, false);
        let reader = std::thread::spawn(move || receiver.iter().count());
        for k in 0..50 {
            record_sender.accept(picture(f64::from(k))).unwrap();
        }
        assert_eq!(record_sender.drops(), 0);
        drop(record_sender);
        assert_eq!(reader.join().unwrap(), 50);
    }

    #[test]
    fn a_stopped_recorder_is_an_error() {
        let (sender, receiver) = crossbeam_channel::bounded(1);
        drop(receiver);
        let mut record_sender = RecordSender::new(sender, true);
        assert!(
            record_sender.accept(text(0.0)).is_err() && record_sender.accept(picture(0.0)).is_err()
        );
    }
}
