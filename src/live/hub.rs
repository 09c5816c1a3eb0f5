//! The recording of a live run for viewers that connect at any time.

use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tokio::sync::broadcast;

use crate::record::{EncodedMessage, MessageReceiver};

/// Approximate size of the history for a new viewer, bytes.
const HISTORY_BYTES: usize = 8 << 20;
/// Queue length of a viewer, in pieces. A viewer with a longer backlog loses pieces.
const QUEUE: usize = 1 << 14;

/// Bytes of a recording, shared by all viewers.
pub type Bytes = std::sync::Arc<[u8]>;

/// An update for a viewer: a new piece.
#[derive(Clone, Debug)]
pub struct Update {
    /// Content.
    pub bytes: Bytes,
    /// Name of its data.
    pub name: Name,
    /// Whether the data are static: no viewer may miss them.
    pub is_static: bool,
    /// Whether the piece starts another recording.
    pub starts_recording: bool,
    /// Newest simulated time in the piece, s.
    pub end_time: Option<f64>,
}

/// The hub of all viewers: stores what a new viewer needs, and broadcasts new pieces without waiting for any
/// viewer.
pub struct Hub {
    state: Mutex<State>,
    updates: broadcast::Sender<Update>,
}

#[derive(Default)]
struct State {
    /// Static pieces, in the order of their first occurrence.
    static_messages: Vec<(Name, Bytes)>,
    /// Recent temporal pieces, oldest first.
    past: VecDeque<Row>,
    /// Size of `past`, bytes.
    size: usize,
    /// Older pieces that are still the newest of their name, by number.
    still: BTreeMap<u64, Row>,
    /// Number of the newest piece of each name.
    last: HashMap<Name, u64>,
    /// Number of pieces so far.
    count: u64,
}

/// Name of the data of a piece.
pub type Name = std::sync::Arc<str>;

/// A temporal piece.
struct Row {
    number: u64,
    name: Name,
    bytes: Bytes,
}

/// Subscription of a new viewer: the history, and the new pieces.
pub struct Subscription {
    /// History, in order.
    pub past: Vec<Bytes>,
    /// New pieces. A receiver that lags too far behind loses some and gets an error.
    pub updates: broadcast::Receiver<Update>,
}

impl State {
    fn set(&mut self, name: Name, bytes: Bytes) {
        match self
            .static_messages
            .iter_mut()
            .find(|(known, _)| *known == name)
        {
            Some((_, known)) => *known = bytes,
            None => self.static_messages.push((name, bytes)),
        }
    }

    fn add(&mut self, name: Name, bytes: Bytes) {
        self.count += 1;
        let number = self.count;
        if let Some(before) = self.last.insert(Name::clone(&name), number) {
            self.still.remove(&before);
        }
        self.size += bytes.len();
        self.past.push_back(Row {
            number,
            name,
            bytes,
        });
        while self.size > HISTORY_BYTES {
            let Some(oldest) = self.past.pop_front() else {
                break;
            };
            self.size -= oldest.bytes.len();
            if self.last.get(&oldest.name) == Some(&oldest.number) {
                self.still.insert(oldest.number, oldest);
            }
        }
    }
}

impl Default for Hub {
    fn default() -> Self {
        Self {
            state: Mutex::default(),
            updates: broadcast::channel(QUEUE).0,
        }
    }
}

impl Hub {
    /// Clears the stored recording before another one starts.
    pub fn begin(&self) {
        *self.state() = State::default();
    }

    /// Connects a viewer.
    pub fn subscribe(&self) -> Subscription {
        // With the lock held, the viewer gets every piece exactly once.
        let state = self.state();
        let static_messages = state.static_messages.iter().map(|(_, piece)| piece);
        let rows = state.still.values().chain(&state.past);
        Subscription {
            past: static_messages
                .chain(rows.map(|row| &row.bytes))
                .cloned()
                .collect(),
            updates: self.updates.subscribe(),
        }
    }

    /// Newest pieces of the given names, oldest first, for a viewer that has missed them.
    pub fn last(&self, names: &HashSet<Name>) -> Vec<Bytes> {
        let state = self.state();
        let rows = state.still.values().chain(&state.past);
        let wanted = rows.filter(|row| {
            names.contains(&row.name) && state.last.get(&row.name) == Some(&row.number)
        });
        wanted.map(|row| row.bytes.clone()).collect()
    }

    /// Number of connected viewers.
    pub fn watching(&self) -> usize {
        self.updates.receiver_count()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl MessageReceiver for Hub {
    fn receive(&self, piece: EncodedMessage) {
        let EncodedMessage {
            bytes,
            name,
            is_static,
            starts_recording,
            end_time,
        } = piece;
        let (bytes, name) = (Bytes::from(bytes), Name::from(name));
        let mut state = self.state();
        match is_static {
            true => state.set(Name::clone(&name), bytes.clone()),
            false => state.add(Name::clone(&name), bytes.clone()),
        }
        // There may be no viewer.
        let _ = self.updates.send(Update {
            bytes,
            name,
            is_static,
            starts_recording,
            end_time,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(text: &str, name: &str, is_static: bool) -> EncodedMessage {
        EncodedMessage {
            bytes: text.as_bytes().to_vec(),
            name: name.to_owned(),
            is_static,
            ..EncodedMessage::default()
        }
    }

    fn texts(pieces: &[Bytes]) -> Vec<String> {
        let text = |piece: &Bytes| String::from_utf8(piece.to_vec()).unwrap();
        pieces.iter().map(text).collect()
    }

    #[test]
    fn a_new_viewer_gets_static_data_once_and_the_history() {
        let hub = Hub::default();
        for (text, name, is_static) in [
            ("store", "s", true),
            ("axes", "a", true),
            ("row 1", "r", false),
            ("axes, better", "a", true),
            ("row 2", "r", false),
        ] {
            hub.receive(piece(text, name, is_static));
        }
        let mut subscription = hub.subscribe();
        assert_eq!(
            texts(&subscription.past),
            ["store", "axes, better", "row 1", "row 2"]
        );
        hub.receive(piece("row 3", "r", false));
        let update = subscription.updates.try_recv().unwrap();
        assert!(!update.is_static);
        assert_eq!(texts(&[update.bytes]), ["row 3"]);
        assert_eq!(hub.watching(), 1);
        hub.begin();
        assert!(hub.subscribe().past.is_empty());
    }

    /// The node positions are sent once, the node states continuously.
    #[test]
    fn the_history_is_bounded_but_keeps_the_newest_of_each_name() {
        let hub = Hub::default();
        hub.receive(piece("store", "s", true));
        hub.receive(piece("places", "places", false));
        let large = "x".repeat(1 << 20);
        for _ in 0..80 {
            hub.receive(piece(&large, "states", false));
        }
        let past = hub.subscribe().past;
        assert_eq!(past.len(), 2 + 8);
        assert_eq!(texts(&past[..2]), ["store", "places"]);
        let names = ["places", "states"].map(Name::from).into_iter().collect();
        assert_eq!(hub.last(&names).len(), 2);
        hub.receive(piece("elsewhere", "places", false));
        let past = hub.subscribe().past;
        assert_eq!(texts(&past[past.len() - 1..]), ["elsewhere"]);
        assert!(past.iter().all(|piece| **piece != *b"places"));
    }

    #[test]
    fn a_viewer_that_does_not_read_delays_nothing() {
        let hub = Hub::default();
        let mut subscription = hub.subscribe();
        for _ in 0..2 * QUEUE {
            hub.receive(piece("row", "r", false));
        }
        let lost = subscription.updates.try_recv().unwrap_err();
        assert!(matches!(lost, broadcast::error::TryRecvError::Lagged(_)));
    }
}
