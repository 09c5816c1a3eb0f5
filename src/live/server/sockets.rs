//! The web sockets: control, recording and sound.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Instant;

use axum::Extension;
use axum::extract::State;
use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocketUpgrade};
use axum::response::Response;
use serde::{Deserialize, Serialize};
use tokio::sync::broadcast::error::{RecvError, TryRecvError};
use tokio::time::MissedTickBehavior;

use super::accept::Seat;
use super::client::{Client, Gone};
use super::shared::{PANEL_EVERY, Shared};
use crate::live::command::{Command, HARD, KICKS, PACES};
use crate::live::flow::Flow;
use crate::live::hub::{Name, News, Ticket};
use crate::live::session::Session;

/// Bytes of a message to a viewer, about.
const MESSAGE: usize = 1 << 20;
/// Why a connection is closed that lags too far behind.
const TOO_SLOW: u16 = 4000;

/// What the page is told once.
#[derive(Serialize)]
struct Welcome {
    version: &'static str,
    scenes: Vec<[String; 2]>,
    paces: [f64; 2],
    kicks: [f64; 2],
    hard_kick: f64,
    sound_rate: u32,
}

pub(super) async fn control(
    State(shared): State<Arc<Shared>>,
    Extension(seat): Extension<Arc<Seat>>,
    upgrade: WebSocketUpgrade,
) -> Response {
    Client::attend(upgrade, seat, |client| controlled(client, shared))
}

/// A message to the page: an object with one key.
fn message(key: &str, value: &impl Serialize) -> Message {
    let value = serde_json::to_value(value).unwrap_or_default();
    let text = serde_json::json!({ key: value }).to_string();
    Message::Text(Utf8Bytes::from(text))
}

/// Talks with a control panel until it goes.
async fn controlled(mut client: Client, shared: Arc<Shared>) -> Result<(), Gone> {
    let session = &shared.session;
    let welcome = Welcome {
        version: crate::VERSION,
        scenes: session.scenes(),
        paces: PACES,
        kicks: KICKS,
        hard_kick: HARD,
        sound_rate: crate::sound::RATE,
    };
    let mut bands = shared.bands.clone();
    let first = [
        message("welcome", &welcome),
        message("bands", &*bands.borrow_and_update()),
    ];
    for message in first {
        client.send(message).await?;
    }
    let mut tick = tokio::time::interval(PANEL_EVERY);
    tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut told = None;
    loop {
        let answer = tokio::select! {
            asked = client.recv() => match asked? {
                Message::Text(text) => Some(carried_out(&mut client, session, text.as_str()).await),
                _ => None,
            },
            Ok(()) = bands.changed() => {
                Some(message("bands", &*bands.borrow_and_update()))
            }
            _ = tick.tick() => {
                let panel = session.panel();
                let changed = told.as_ref() != Some(&panel);
                let news = changed.then(|| message("panel", &panel));
                told = Some(panel);
                news
            }
        };
        if let Some(answer) = answer {
            client.send(answer).await?;
        }
    }
}

/// Does what a text asks for; the answer says whether it was done.
async fn carried_out(client: &mut Client, session: &Arc<Session>, text: &str) -> Message {
    let command: Command = match serde_json::from_str(text) {
        Ok(command) => command,
        Err(fault) => return message("refused", &format!("not a command: {fault}")),
    };
    if !client.may(command.cost()) {
        return message("refused", &"too many commands: wait a moment");
    }
    let session = Arc::clone(session);
    // Reading a scene takes a moment.
    let obeyed = tokio::task::spawn_blocking(move || session.obey(&command)).await;
    match obeyed {
        Ok(Ok(())) => message("done", &text),
        Ok(Err(refused)) => message("refused", &refused.to_string()),
        Err(fault) => message("refused", &fault.to_string()),
    }
}

pub(super) async fn stream(
    State(shared): State<Arc<Shared>>,
    Extension(seat): Extension<Arc<Seat>>,
    upgrade: WebSocketUpgrade,
) -> Response {
    Client::attend(upgrade, seat, |client| streamed(client, shared))
}

/// Sends the recording to a viewer until it goes. One that takes it in too slowly misses some.
async fn streamed(mut client: Client, shared: Arc<Shared>) -> Result<(), Gone> {
    let session = &shared.session;
    let Ticket { past, mut news } = session.hub.enter();
    let mut flow = Flow::default();
    let mut missed: HashSet<Name> = HashSet::new();
    let mut waiting: Vec<u8> = Vec::new();
    for piece in past {
        waiting.extend_from_slice(&piece);
        if waiting.len() >= MESSAGE {
            let full = std::mem::take(&mut waiting);
            client.send(Message::Binary(full.into())).await?;
        }
    }
    loop {
        if !waiting.is_empty() {
            let full = std::mem::take(&mut waiting);
            client.send(Message::Binary(full.into())).await?;
            flow.sent(Instant::now());
        }
        let mut take = |news: News, waiting: &mut Vec<u8>| {
            if news.begins {
                flow.begin();
            }
            if news.lasting {
                waiting.extend_from_slice(&news.bytes);
            } else if flow.is_behind(Instant::now()) {
                missed.insert(news.name);
            } else {
                // What has been left out holds on until something else is told of the same.
                if !missed.is_empty() {
                    missed.remove(&news.name);
                    for piece in session.hub.last(&std::mem::take(&mut missed)) {
                        waiting.extend_from_slice(&piece);
                    }
                }
                waiting.extend_from_slice(&news.bytes);
                flow.tells(news.until);
            }
        };
        let mut lost = false;
        tokio::select! {
            piece = news.recv() => match piece {
                Ok(piece) => take(piece, &mut waiting),
                Err(RecvError::Lagged(_)) => lost = true,
                Err(RecvError::Closed) => return Ok(()),
            },
            told = client.recv() => {
                if let Message::Text(text) = told?
                    && let Ok(Seen { seen }) = serde_json::from_str(text.as_str())
                {
                    flow.saw(Instant::now(), seen);
                }
                continue;
            }
        };
        // What has come meanwhile goes along.
        while waiting.len() < MESSAGE && !lost {
            match news.try_recv() {
                Ok(piece) => take(piece, &mut waiting),
                Err(TryRecvError::Lagged(_)) => lost = true,
                Err(_) => break,
            }
        }
        if lost {
            return client.send(too_slow()).await;
        }
    }
}

/// What a viewer says of itself.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Seen {
    /// Simulated time up to which it shows the run, s.
    seen: f64,
}

pub(super) async fn sound(
    State(shared): State<Arc<Shared>>,
    Extension(seat): Extension<Arc<Seat>>,
    upgrade: WebSocketUpgrade,
) -> Response {
    Client::attend(upgrade, seat, |client| played(client, shared))
}

/// What a listener hears.
#[derive(Debug, Default, Serialize)]
struct Heard {
    /// In a few words.
    what: String,
    /// How many times slower, and so lower, than life.
    slower: f32,
}

impl Heard {
    /// Whether it is worth telling again.
    fn differs_from(&self, told: &Self) -> bool {
        self.what != told.what || (self.slower - told.slower).abs() > 0.02 * told.slower
    }
}

/// Plays to a listener until it goes. One that lags misses some.
async fn played(mut client: Client, shared: Arc<Shared>) -> Result<(), Gone> {
    let ear = &shared.session.ear;
    let mut news = ear.listen();
    let mut told = Heard::default();
    loop {
        let sound = tokio::select! {
            sound = news.recv() => match sound {
                Ok(sound) => sound,
                Err(RecvError::Lagged(_)) => continue,
                Err(RecvError::Closed) => return Ok(()),
            },
            asked = client.recv() => {
                asked?;
                continue;
            }
        };
        let heard = Heard {
            what: ear.words(),
            slower: ear.slower(),
        };
        if heard.differs_from(&told) {
            client.send(message("heard", &heard)).await?;
            told = heard;
        }
        let bytes: Vec<u8> = sound.iter().flat_map(|x| x.to_le_bytes()).collect();
        client.send(Message::Binary(bytes.into())).await?;
    }
}

/// Closes a connection that lags too far behind: the page connects anew.
fn too_slow() -> Message {
    Message::Close(Some(CloseFrame {
        code: TOO_SLOW,
        reason: "too slow".into(),
    }))
}
