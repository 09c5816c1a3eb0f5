//! A web socket whose other end may flood, fall silent, or never read.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::response::Response;
use tokio::time::{Instant, sleep_until, timeout, timeout_at};

use super::accept::Seat;

/// Bytes of a message from a client, at most.
const LONGEST: usize = 1 << 12;
/// Messages that are read, a second and at once. Beyond that a client waits, on the network and not in memory.
const READ: [f64; 2] = [500.0, 1000.0];
/// What commands may cost, a second and at once; see [`Command::cost`](super::super::Command).
pub(super) const COMMANDS: [f64; 2] = [100.0, 200.0];

/// The client has gone, or does not read.
#[derive(Debug)]
pub(super) struct Gone;

/// A client at the other end of a web socket.
#[derive(Debug)]
pub(super) struct Client {
    socket: WebSocket,
    reading: Allowance,
    commands: Allowance,
    /// When it last said something, or was asked to.
    heard: Instant,
    /// Whether it was asked since.
    asked: bool,
    /// Free for others when the client goes.
    seat: Arc<Seat>,
}

impl Client {
    /// Turns a request into a web socket, and attends to it until that is over.
    pub fn attend<F>(
        upgrade: WebSocketUpgrade,
        seat: Arc<Seat>,
        attend: impl FnOnce(Self) -> F + Send + 'static,
    ) -> Response
    where
        F: Future<Output = Result<(), Gone>> + Send + 'static,
    {
        upgrade
            .max_message_size(LONGEST)
            .max_frame_size(LONGEST)
            .on_upgrade(move |socket| async move {
                let now = Instant::now();
                let client = Self {
                    socket,
                    reading: Allowance::new(READ, now),
                    commands: Allowance::new(COMMANDS, now),
                    heard: now,
                    asked: false,
                    seat,
                };
                // However it ended, it is over.
                let _ = attend(client).await;
            })
    }

    /// The next message. May be given up while it waits; nothing is lost.
    ///
    /// # Errors
    /// [`Gone`].
    pub async fn recv(&mut self) -> Result<Message, Gone> {
        loop {
            sleep_until(self.reading.has(0.0)).await;
            match timeout_at(self.heard + self.seat.limits().silence, self.socket.recv()).await {
                Ok(Some(Ok(Message::Close(_)) | Err(_)) | None) => return Err(Gone),
                Ok(Some(Ok(message))) => {
                    (self.heard, self.asked) = (Instant::now(), false);
                    self.reading.take(1.0, self.heard);
                    return Ok(message);
                }
                Err(_) if self.asked => return Err(Gone),
                Err(_) => {
                    (self.heard, self.asked) = (Instant::now(), true);
                    self.send(Message::Ping(Default::default())).await?;
                }
            }
        }
    }

    /// Whether a command that costs so much is allowed now.
    pub fn may(&mut self, cost: f64) -> bool {
        let now = Instant::now();
        let allowed = self.commands.has(cost) <= now;
        if allowed {
            self.commands.take(cost, now);
        }
        allowed
    }

    /// Sends a message; one that is not taken in for long ends the connection.
    ///
    /// # Errors
    /// [`Gone`].
    pub async fn send(&mut self, message: Message) -> Result<(), Gone> {
        match timeout(self.seat.limits().for_message, self.socket.send(message)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) | Err(_) => Err(Gone),
        }
    }
}

/// So much a second, and so much at once.
#[derive(Debug)]
struct Allowance {
    per_second: f64,
    at_once: f64,
    /// What was left at a time; may be less than nothing.
    left: f64,
    at: Instant,
}

impl Allowance {
    fn new([per_second, at_once]: [f64; 2], now: Instant) -> Self {
        Self {
            per_second,
            at_once,
            left: at_once,
            at: now,
        }
    }

    /// From when on there is so much of it.
    fn has(&self, cost: f64) -> Instant {
        let missing = (cost - self.left).max(0.0);
        self.at + Duration::from_secs_f64(missing / self.per_second)
    }

    fn take(&mut self, cost: f64, now: Instant) {
        let gained = self.per_second * (now - self.at).as_secs_f64();
        self.left = (self.left + gained).min(self.at_once) - cost;
        self.at = now;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_allowance_grows_with_time_and_not_beyond_its_limit() {
        let began = Instant::now();
        let after = |seconds| began + Duration::from_secs_f64(seconds);
        let mut allowance = Allowance::new([10.0, 20.0], began);
        let mut allowed = |cost: f64, now: Instant| {
            let has = allowance.has(cost) <= now;
            if has {
                allowance.take(cost, now);
            }
            has
        };
        let mut flood = |now| (0..1000).filter(|_| allowed(1.0, now)).count();
        assert_eq!(flood(began), 20, "at once");
        assert_eq!(flood(after(0.5)), 5);
        assert_eq!(flood(after(100.0)), 20, "not for ever");
        assert!(!allowed(5.0, after(100.4)) && allowed(5.0, after(100.5)));
    }
}
