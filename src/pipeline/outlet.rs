//! The last channel's sender: what waits, and what may be replaced.

use crossbeam_channel::{Sender, TrySendError};

use super::error::RecorderGone;
use super::latest::Latest;
use super::message::Record;
use super::sink::{Delivery, Sink, SinkError};

/// Sends records on. A picture that cannot be sent at once may be replaced by the next of its kind,
/// where the sink allows it; samples, words and numbers always wait.
#[derive(Debug)]
pub(super) struct Outlet {
    sender: Sender<Record>,
    delivery: Delivery,
    /// Pictures that could not be sent yet.
    held: Latest,
    drops: u64,
}

impl Outlet {
    pub fn new(sender: Sender<Record>, delivery: Delivery) -> Self {
        Self {
            sender,
            delivery,
            held: Latest::default(),
            drops: 0,
        }
    }

    /// Pictures replaced so far.
    pub fn drops(&self) -> u64 {
        self.drops
    }

    /// Records that wait for the recorder.
    pub fn waiting(&self) -> usize {
        self.sender.len() + self.held.len()
    }

    /// Sends what is still held; waits for it.
    pub fn flush(&mut self) -> Result<(), RecorderGone> {
        for record in self.held.take_all() {
            self.sender.send(record).map_err(|_| RecorderGone)?;
        }
        Ok(())
    }

    fn send_or_hold(&mut self, record: Record) -> Result<(), RecorderGone> {
        match self.sender.try_send(record) {
            Ok(()) => Ok(()),
            Err(TrySendError::Disconnected(_)) => Err(RecorderGone),
            Err(TrySendError::Full(record)) => {
                self.drops += u64::from(self.held.put(record));
                Ok(())
            }
        }
    }
}

impl Sink for Outlet {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        if self.delivery == Delivery::LatestPictures {
            for held in self.held.take_all() {
                self.send_or_hold(held)?;
            }
            if record.is_picture() {
                return Ok(self.send_or_hold(record)?);
            }
        }
        Ok(self.sender.send(record).map_err(|_| RecorderGone)?)
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

    /// While the recorder is stuck, the latest picture of a kind survives; words are never lost.
    #[test]
    fn latest_picture_wins() {
        let (sender, receiver) = crossbeam_channel::bounded(1);
        let mut outlet = Outlet::new(sender, Delivery::LatestPictures);
        outlet.accept(words(0.0)).unwrap();
        for k in 1..=5 {
            outlet.accept(picture(f64::from(k))).unwrap();
        }
        assert_eq!((outlet.drops(), outlet.waiting()), (4, 2));
        let reader = std::thread::spawn(move || receiver.iter().collect::<Vec<_>>());
        outlet.flush().unwrap();
        outlet.accept(words(6.0)).unwrap();
        drop(outlet);
        let got = reader.join().unwrap();
        assert!(matches!(got[0], Record::Warning { time: 0.0, .. }));
        assert!(matches!(got[1], Record::Embedding { time: 5.0, .. }));
        assert!(matches!(got[2], Record::Warning { time: 6.0, .. }));
        assert_eq!(got.len(), 3);
    }

    #[test]
    fn everything_waits_when_saving() {
        let (sender, receiver) = crossbeam_channel::bounded(1);
        let mut outlet = Outlet::new(sender, Delivery::Everything);
        let reader = std::thread::spawn(move || receiver.iter().count());
        for k in 0..50 {
            outlet.accept(picture(f64::from(k))).unwrap();
        }
        assert_eq!(outlet.drops(), 0);
        drop(outlet);
        assert_eq!(reader.join().unwrap(), 50);
    }

    #[test]
    fn a_dead_recorder_is_an_error() {
        let (sender, receiver) = crossbeam_channel::bounded(1);
        drop(receiver);
        let mut outlet = Outlet::new(sender, Delivery::LatestPictures);
        assert!(outlet.accept(words(0.0)).is_err() && outlet.accept(picture(0.0)).is_err());
    }
}
