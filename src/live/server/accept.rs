//! Connections: a limited number, each for one request or one web socket.

use std::sync::Arc;
use std::time::Duration;

use axum::{Extension, Router};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Limits of the server.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Connections at a time; further ones wait. A page has three, and a few more while it loads.
    pub connections: usize,
    /// Time for the request line and headers.
    pub header_timeout: Duration,
    /// Time for a web-socket client to accept a message.
    pub message_timeout: Duration,
    /// Time after which a silent web-socket client gets a ping, and time for its response.
    pub ping_after: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            connections: 128,
            header_timeout: Duration::from_secs(3),
            message_timeout: Duration::from_secs(10),
            ping_after: Duration::from_secs(20),
        }
    }
}

/// Time for a request and its response: the viewer's 42 MB, or a recording.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(600);
/// Maximum size of the request line and headers, bytes.
const MAX_HEADERS: usize = 1 << 14;
/// Delay after a failed accept.
const RETRY: Duration = Duration::from_millis(50);

/// A connection, which counts until it is dropped. A web socket keeps it.
#[derive(Debug)]
pub(super) struct Connection {
    pub limits: Limits,
    _slot: OwnedSemaphorePermit,
}

/// Serves connections for as long as it is polled.
pub(super) async fn accept(listener: TcpListener, router: Router, limits: Limits) {
    let free = Arc::new(Semaphore::new(limits.connections));
    // The semaphore is never closed.
    while let Ok(slot) = Arc::clone(&free).acquire_owned().await {
        match listener.accept().await {
            Ok((stream, _)) => {
                let connection = Connection {
                    limits,
                    _slot: slot,
                };
                tokio::spawn(serve(stream, connection, router.clone()));
            }
            // The client has gone, or no file descriptors are left: incomplete requests end soon.
            Err(_) => tokio::time::sleep(RETRY).await,
        }
    }
}

async fn serve(stream: TcpStream, connection: Connection, router: Router) {
    let header_timeout = connection.limits.header_timeout;
    let router = router.layer(Extension(Arc::new(connection)));
    let served = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(header_timeout)
        .max_buf_size(MAX_HEADERS)
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(router))
        .with_upgrades();
    // A connection error concerns only its client.
    let _ = tokio::time::timeout(REQUEST_TIMEOUT, served).await;
}
