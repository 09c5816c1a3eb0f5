//! Web sockets for control, views and audio.

use std::sync::Arc;
use std::time::Duration;

use axum::Extension;
use axum::extract::State;
use axum::extract::ws::{Message, Utf8Bytes, WebSocketUpgrade};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use tokio::sync::broadcast::error::RecvError;
use tokio::time::{Instant, MissedTickBehavior, sleep_until};

use super::Shared;
use super::accept::Connection;
use super::client::{Client, Disconnected};
use super::roles::Role;
use crate::live::audio::AudioInfo;
use crate::live::command::{Command, HARD_KICK};
use crate::live::session::Session;
use crate::live::views::ViewCursor;

/// Interval at which a changed panel is sent.
const PANEL_EVERY: Duration = Duration::from_millis(50);
/// Bytes per second for the views.
const VIEWS_RATE: f64 = 2e6;
/// Maximum number of messages for the views that are sent but not drawn.
const VIEWS_AHEAD: u64 = 3;

pub(super) async fn control(
    State(shared): State<Arc<Shared>>,
    Extension(role): Extension<Role>,
    (Extension(session), Extension(connection), upgrade): Opening,
) -> Response {
    // A second run starts with its first client.
    if let Some(second) = &shared.second
        && Arc::ptr_eq(second, &session)
        && let Err(fault) = second.start()
    {
        return (StatusCode::SERVICE_UNAVAILABLE, fault.to_string()).into_response();
    }
    Client::serve(upgrade, connection, move |client| {
        serve_control(client, shared, session, role)
    })
}

/// A message to the page: a JSON object with one key.
fn message(key: &str, value: &impl Serialize) -> Message {
    let text = serde_json::json!({ key: value }).to_string();
    Message::Text(Utf8Bytes::from(text))
}

/// Serves a control panel until it disconnects.
async fn serve_control(
    mut client: Client,
    shared: Arc<Shared>,
    session: Arc<Session>,
    role: Role,
) -> Result<(), Disconnected> {
    let session = &session;
    let controls = role == Role::Presenter;
    let welcome = serde_json::json!({
        "scenes": session.scenes(),
        "hard_kick_mm_per_s": HARD_KICK,
        "audio_rate_hz": crate::sound::RATE,
        // Whether the client may send commands.
        "controls": controls,
        // Whether a second run is available, for comparison.
        "compares": shared.second.is_some(),
        // Address (URL) for an audience that only watches, if other machines can reach the page.
        "audience_url": shared.audience_url.as_ref().filter(|_| controls),
    });
    client.send(message("welcome", &welcome)).await?;
    let mut tick = tokio::time::interval(PANEL_EVERY);
    tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut sent = None;
    loop {
        let answer = tokio::select! {
            asked = client.recv() => match asked? {
                Message::Text(_) if role == Role::Audience => {
                    Some(message("refused", &"this address only watches; the presenter controls the run"))
                }
                Message::Text(text) => Some(apply(session, text.as_str()).await),
                _ => None,
            },
            _ = tick.tick() => {
                let panel = session.panel();
                let changed = sent.as_ref() != Some(&panel);
                let message = changed.then(|| message("panel", &panel));
                sent = Some(panel);
                message
            }
        };
        if let Some(answer) = answer {
            client.send(answer).await?;
        }
    }
}

/// Applies a command and returns the response.
async fn apply(session: &Arc<Session>, text: &str) -> Message {
    let command: Command = match serde_json::from_str(text) {
        Ok(command) => command,
        Err(fault) => return message("refused", &format!("invalid command: {fault}")),
    };
    let session = Arc::clone(session);
    // Loading a scene takes a moment.
    let applied = tokio::task::spawn_blocking(move || session.apply(&command)).await;
    match applied {
        Ok(Ok(())) => message("done", &text),
        Ok(Err(refused)) => message("refused", &refused.to_string()),
        Err(fault) => message("refused", &fault.to_string()),
    }
}

/// What opens a web socket of a run.
type Opening = (
    Extension<Arc<Session>>,
    Extension<Arc<Connection>>,
    WebSocketUpgrade,
);

pub(super) async fn views(
    (Extension(session), Extension(connection), upgrade): Opening,
) -> Response {
    Client::serve(upgrade, connection, |client| serve_views(client, session))
}

/// Sends the data of the views as often as the client draws them, at most [`VIEWS_RATE`].
async fn serve_views(mut client: Client, session: Arc<Session>) -> Result<(), Disconnected> {
    let store = &session.views;
    let mut changes = store.subscribe();
    // The present picture, even of a paused run.
    changes.mark_changed();
    let mut cursor = ViewCursor::default();
    let mut due = Instant::now();
    let (mut sent, mut drawn) = (0_u64, 0_u64);
    loop {
        let news = async {
            sleep_until(due).await;
            changes.changed().await
        };
        tokio::select! {
            received = client.recv() => {
                if let Message::Text(text) = received?
                    && let Ok(ViewAcknowledgement { drawn: number }) = serde_json::from_str(text.as_str())
                {
                    drawn = number.clamp(drawn, sent);
                }
            }
            changed = news, if sent < drawn + VIEWS_AHEAD => {
                if changed.is_err() {
                    return Ok(());
                }
                if let Some(message) = store.next(&mut cursor) {
                    due = Instant::now() + Duration::from_secs_f64(message.len() as f64 / VIEWS_RATE);
                    sent += 1;
                    client.send(Message::Binary(message.into())).await?;
                }
            }
        }
    }
}

/// Acknowledgement of the views.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewAcknowledgement {
    /// Number of messages drawn since the connection.
    drawn: u64,
}

pub(super) async fn sound(
    (Extension(session), Extension(connection), upgrade): Opening,
) -> Response {
    Client::serve(upgrade, connection, |client| serve_sound(client, session))
}

/// Streams audio to a listener until it disconnects. A slow listener misses some.
async fn serve_sound(mut client: Client, session: Arc<Session>) -> Result<(), Disconnected> {
    let mut blocks = session.audio.subscribe();
    let mut sent = AudioInfo::default();
    loop {
        let sound = tokio::select! {
            sound = blocks.recv() => match sound {
                Ok(sound) => sound,
                Err(RecvError::Lagged(_)) => continue,
                Err(RecvError::Closed) => return Ok(()),
            },
            asked = client.recv() => {
                asked?;
                continue;
            }
        };
        let (info, sound) = &*sound;
        let change = (info.time_stretch - sent.time_stretch).abs();
        if info.what != sent.what || change > 0.02 * sent.time_stretch {
            client.send(message("audio", info)).await?;
            sent = info.clone();
        }
        let bytes: Vec<u8> = sound.iter().flat_map(|x| x.to_le_bytes()).collect();
        client.send(Message::Binary(bytes.into())).await?;
    }
}
