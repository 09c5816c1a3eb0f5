//! A web socket with limits for flooding, silent and slow clients.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::response::Response;
use tokio::time::{Instant, sleep_until, timeout, timeout_at};

use super::accept::ConnectionSlot;

/// Maximum size of a message from a client, bytes.
const MAX_MESSAGE: usize = 1 << 12;
/// Messages read per second, and burst. The excess waits on the network and not in memory.
const READ_RATE: [f64; 2] = [500.0, 1000.0];
/// Cost of commands per second, and burst; see [`Command::cost`](super::super::Command).
pub(super) const COMMAND_RATE: [f64; 2] = [100.0, 200.0];

/// The client has disconnected or does not read.
#[derive(Debug)]
pub(super) struct Disconnected;

/// The client of a web socket.
#[derive(Debug)]
pub(super) struct Client {
    socket: WebSocket,
    reading: TokenBucket,
    commands: TokenBucket,
    /// Time of its last message or of the last ping.
    last_message: Instant,
    /// Whether a ping was sent since its last message.
    pinged: bool,
    /// Connection slot, released when the client disconnects.
    slot: Arc<ConnectionSlot>,
}

impl Client {
    /// Upgrades a request to a web socket and serves it until it is closed.
    pub fn serve<F>(
        upgrade: WebSocketUpgrade,
        slot: Arc<ConnectionSlot>,
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
                    reading: TokenBucket::new(READ_RATE, now),
                    commands: TokenBucket::new(COMMAND_RATE, now),
                    last_message: now,
                    pinged: false,
                    slot,
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
        loop {
            sleep_until(self.reading.available_at(0.0)).await;
            match timeout_at(
                self.last_message + self.slot.limits().ping_after,
                self.socket.recv(),
            )
            .await
            {
                Ok(Some(Ok(Message::Close(_)) | Err(_)) | None) => return Err(Disconnected),
                Ok(Some(Ok(message))) => {
                    (self.last_message, self.pinged) = (Instant::now(), false);
                    self.reading.take(1.0, self.last_message);
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

    /// Whether a command of the given cost is allowed now; if so, the cost is deducted.
    pub fn allow(&mut self, cost: f64) -> bool {
        let now = Instant::now();
        let allowed = self.commands.available_at(cost) <= now;
        if allowed {
            self.commands.take(cost, now);
        }
        allowed
    }

    /// Sends a message. A client that does not accept it in time is disconnected.
    ///
    /// # Errors
    /// [`Disconnected`].
    pub async fn send(&mut self, message: Message) -> Result<(), Disconnected> {
        match timeout(
            self.slot.limits().message_timeout,
            self.socket.send(message),
        )
        .await
        {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) | Err(_) => Err(Disconnected),
        }
    }
}

/// Token bucket: a rate per second and a burst size.
#[derive(Debug)]
pub(super) struct TokenBucket {
    rate: f64,
    burst: f64,
    /// Tokens left at the time `at`; may be negative.
    left: f64,
    at: Instant,
}

impl TokenBucket {
    pub fn new([rate, burst]: [f64; 2], now: Instant) -> Self {
        Self {
            rate,
            burst,
            left: burst,
            at: now,
        }
    }

    /// Time from which on the given number of tokens is available.
    pub fn available_at(&self, cost: f64) -> Instant {
        let missing = (cost - self.left).max(0.0);
        self.at + Duration::from_secs_f64(missing / self.rate)
    }

    pub fn take(&mut self, cost: f64, now: Instant) {
        let gained = self.rate * (now - self.at).as_secs_f64();
        self.left = (self.left + gained).min(self.burst) - cost;
        self.at = now;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_bucket_refills_up_to_its_burst_size() {
        let began = Instant::now();
        let after = |seconds| began + Duration::from_secs_f64(seconds);
        let mut bucket = TokenBucket::new([10.0, 20.0], began);
        let mut allowed = |cost: f64, now: Instant| {
            let has = bucket.available_at(cost) <= now;
            if has {
                bucket.take(cost, now);
            }
            has
        };
        let mut flood = |now| (0..1000).filter(|_| allowed(1.0, now)).count();
        assert_eq!(flood(began), 20, "burst");
        assert_eq!(flood(after(0.5)), 5);
        assert_eq!(flood(after(100.0)), 20, "limited to the burst size");
        assert!(!allowed(5.0, after(100.4)) && allowed(5.0, after(100.5)));
    }
}
