//! The recording of a live run for viewers that come and go.

use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tokio::sync::broadcast;

use crate::record::{Audience, Piece};

/// Bytes of the past that a viewer is given that comes late, about.
const PAST: usize = 8 << 20;
/// Pieces that may wait for a viewer; one that has more of them before it has lost some.
const WAITING: usize = 1 << 14;

/// A shared piece of a recording.
pub type Bytes = std::sync::Arc<[u8]>;

/// A piece that comes now.
#[derive(Clone, Debug)]
pub struct News {
    /// The piece.
    pub bytes: Bytes,
    /// What it is of.
    pub name: Name,
    /// Whether it holds at all times: nobody may miss it.
    pub lasting: bool,
    /// Whether another recording begins with it.
    pub begins: bool,
    /// Simulated time of the newest that it tells, s.
    pub until: Option<f64>,
}

/// Keeps what a viewer needs that comes late, and hands on what comes, without ever waiting for anybody.
pub struct Hub {
    state: Mutex<State>,
    news: broadcast::Sender<News>,
}

#[derive(Default)]
struct State {
    /// Pieces that hold at all times, in the order of their first coming.
    lasting: Vec<(Name, Bytes)>,
    /// The last of the others, oldest first.
    past: VecDeque<Row>,
    /// Their bytes.
    size: usize,
    /// Older ones that are still the last of their name, by number.
    still: BTreeMap<u64, Row>,
    /// Number of the last piece of each name.
    last: HashMap<Name, u64>,
    /// Pieces so far.
    count: u64,
}

/// What pieces are of.
pub type Name = std::sync::Arc<str>;

/// A piece that holds from its time on.
struct Row {
    number: u64,
    name: Name,
    bytes: Bytes,
}

/// What a viewer gets: all that it has missed, and then what comes.
pub struct Ticket {
    /// The past, in order.
    pub past: Vec<Bytes>,
    /// The pieces to come. One that lags too far behind loses some and is told so.
    pub news: broadcast::Receiver<News>,
}

impl State {
    fn set(&mut self, name: Name, bytes: Bytes) {
        match self.lasting.iter_mut().find(|(known, _)| *known == name) {
            Some((_, known)) => *known = bytes,
            None => self.lasting.push((name, bytes)),
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
        while self.size > PAST {
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
            news: broadcast::channel(WAITING).0,
        }
    }
}

impl Hub {
    /// Forgets the recording so far: another one begins.
    pub fn begin(&self) {
        *self.state() = State::default();
    }

    /// Lets somebody in.
    pub fn enter(&self) -> Ticket {
        // Held, so that no piece comes twice or never.
        let state = self.state();
        let lasting = state.lasting.iter().map(|(_, piece)| piece);
        let rows = state.still.values().chain(&state.past);
        Ticket {
            past: lasting.chain(rows.map(|row| &row.bytes)).cloned().collect(),
            news: self.news.subscribe(),
        }
    }

    /// The last pieces of some names, oldest first: for one who has missed them.
    pub fn last(&self, names: &HashSet<Name>) -> Vec<Bytes> {
        let state = self.state();
        let rows = state.still.values().chain(&state.past);
        let wanted = rows.filter(|row| {
            names.contains(&row.name) && state.last.get(&row.name) == Some(&row.number)
        });
        wanted.map(|row| row.bytes.clone()).collect()
    }

    /// How many are watching.
    pub fn watching(&self) -> usize {
        self.news.receiver_count()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Audience for Hub {
    fn hear(&self, piece: Piece) {
        let Piece {
            bytes,
            name,
            lasting,
            begins,
            until,
        } = piece;
        let (bytes, name) = (Bytes::from(bytes), Name::from(name));
        let mut state = self.state();
        match lasting {
            true => state.set(Name::clone(&name), bytes.clone()),
            false => state.add(Name::clone(&name), bytes.clone()),
        }
        // Nobody may be there.
        let _ = self.news.send(News {
            bytes,
            name,
            lasting,
            begins,
            until,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(text: &str, name: &str, lasting: bool) -> Piece {
        Piece {
            bytes: text.as_bytes().to_vec(),
            name: name.to_owned(),
            lasting,
            ..Piece::default()
        }
    }

    fn texts(pieces: &[Bytes]) -> Vec<String> {
        let text = |piece: &Bytes| String::from_utf8(piece.to_vec()).unwrap();
        pieces.iter().map(text).collect()
    }

    #[test]
    fn a_late_viewer_gets_what_lasts_once_and_what_passed() {
        let hub = Hub::default();
        for (text, name, lasting) in [
            ("store", "s", true),
            ("axes", "a", true),
            ("row 1", "r", false),
            ("axes, better", "a", true),
            ("row 2", "r", false),
        ] {
            hub.hear(piece(text, name, lasting));
        }
        let mut ticket = hub.enter();
        assert_eq!(
            texts(&ticket.past),
            ["store", "axes, better", "row 1", "row 2"]
        );
        hub.hear(piece("row 3", "r", false));
        let news = ticket.news.try_recv().unwrap();
        assert!(!news.lasting);
        assert_eq!(texts(&[news.bytes]), ["row 3"]);
        assert_eq!(hub.watching(), 1);
        hub.begin();
        assert!(hub.enter().past.is_empty());
    }

    /// Where nodes are is told once; how they do, again and again.
    #[test]
    fn the_past_has_an_end_but_the_last_of_each_name_stays() {
        let hub = Hub::default();
        hub.hear(piece("store", "s", true));
        hub.hear(piece("places", "places", false));
        let large = "x".repeat(1 << 20);
        for _ in 0..80 {
            hub.hear(piece(&large, "states", false));
        }
        let past = hub.enter().past;
        assert_eq!(past.len(), 2 + 8);
        assert_eq!(texts(&past[..2]), ["store", "places"]);
        let names = ["places", "states"].map(Name::from).into_iter().collect();
        assert_eq!(hub.last(&names).len(), 2);
        hub.hear(piece("elsewhere", "places", false));
        let past = hub.enter().past;
        assert_eq!(texts(&past[past.len() - 1..]), ["elsewhere"]);
        assert!(past.iter().all(|piece| **piece != *b"places"));
    }

    #[test]
    fn a_viewer_that_does_not_read_holds_nobody_up() {
        let hub = Hub::default();
        let mut ticket = hub.enter();
        for _ in 0..2 * WAITING {
            hub.hear(piece("row", "r", false));
        }
        let lost = ticket.news.try_recv().unwrap_err();
        assert!(matches!(lost, broadcast::error::TryRecvError::Lagged(_)));
    }
}
