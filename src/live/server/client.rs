//! A web socket with limits for flooding, silent and slow clients.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::response::Response;
use tokio::time::{Instant, sleep_until, timeout, timeout_at};

use super::accept::Connection;

/// Maximum size of a message from a client, bytes: a bookmark with a state of 1,000 numbers.
const MAX_MESSAGE: usize = 1 << 15;
/// Time between two messages from a client. The excess waits on the network and not in memory.
const READ_EVERY: Duration = Duration::from_millis(2);

/// The client has disconnected or does not read.
#[derive(Debug)]
pub(super) struct Disconnected;

/// The client of a web socket.
#[derive(Debug)]
pub(super) struct Client {
    socket: WebSocket,
    connection: Arc<Connection>,
    /// Time from which on its next message is read.
    next_read: Instant,
    /// Time of its last message or of the last ping.
    last_message: Instant,
    /// Whether a ping was sent since its last message.
    pinged: bool,
}

impl Client {
    /// Upgrades a request to a web socket and serves it until it is closed.
    pub fn serve<F>(
        upgrade: WebSocketUpgrade,
        connection: Arc<Connection>,
        serve: impl FnOnce(Self) -> F + Send + 'static,
    ) -> Response
    where
        F: Future<Output = Result<(), Disconnected>> + Send + 'static,
    {
        upgrade
            .max_message_size(MAX_MESSAGE)
            .max_frame_size(MAX_MESSAGE)
            .on_upgrade(move |socket| async move {
                let now = Instant::now();
                let client = Self {
                    socket,
                    connection,
                    next_read: now,
                    last_message: now,
                    pinged: false,
                };
                // Every error means that the connection is closed.
                let _ = serve(client).await;
            })
    }

    /// The next message. Cancel-safe.
    ///
    /// # Errors
    /// [`Disconnected`].
    pub async fn recv(&mut self) -> Result<Message, Disconnected> {
        sleep_until(self.next_read).await;
        loop {
            let ping_at = self.last_message + self.connection.limits.ping_after;
            match timeout_at(ping_at, self.socket.recv()).await {
                Ok(Some(Ok(Message::Close(_)) | Err(_)) | None) => return Err(Disconnected),
                Ok(Some(Ok(message))) => {
                    (self.last_message, self.pinged) = (Instant::now(), false);
                    self.next_read = self.last_message + READ_EVERY;
                    return Ok(message);
                }
                Err(_) if self.pinged => return Err(Disconnected),
                Err(_) => {
                    (self.last_message, self.pinged) = (Instant::now(), true);
                    self.send(Message::Ping(Default::default())).await?;
                }
            }
        }
    }

    /// Sends a message. A client that does not accept it in time is disconnected.
    ///
    /// # Errors
    /// [`Disconnected`].
    pub async fn send(&mut self, message: Message) -> Result<(), Disconnected> {
        let sent = self.socket.send(message);
        match timeout(self.connection.limits.message_timeout, sent).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) | Err(_) => Err(Disconnected),
        }
    }
}
