//! Connection limits: in total, per address, and for idle connections.
//!
//! A connection serves one request. At a limit, or without free file descriptors, the oldest
//! connection without a complete request is closed in favour of the new one.

use std::convert::Infallible;
use std::io;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::Router;
use axum::http::{HeaderValue, StatusCode, header};
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Notify;

/// Limits of the server.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Connections in total.
    pub total: usize,
    /// Connections per address.
    pub per_address: usize,
    /// Timeout for the request line and headers.
    pub header_timeout: Duration,
    /// Timeout for a request and its response.
    pub request_timeout: Duration,
    /// Timeout for a web-socket client to accept a message.
    pub message_timeout: Duration,
    /// Time after which a silent web-socket client gets a ping, and timeout for its response.
    pub ping_after: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            total: 128,
            // A page has three, and a few more while it loads.
            per_address: 32,
            header_timeout: Duration::from_secs(10),
            // The viewer's 42 MB at 1.2 Mbit/s.
            request_timeout: Duration::from_secs(300),
            message_timeout: Duration::from_secs(10),
            ping_after: Duration::from_secs(20),
        }
    }
}

/// Maximum size of the request line and headers, bytes.
const MAX_HEADERS: usize = 1 << 14;
/// Delay after a failed accept.
const RETRY: Duration = Duration::from_millis(50);
/// Delay after a connection was closed in favour of a new one.
const CLOSE_DELAY: Duration = Duration::from_millis(1);

const FULL: &[u8] =
    b"HTTP/1.1 503 Service Unavailable\r\nconnection: close\r\ncontent-length: 42\r\n\
    cross-origin-resource-policy: same-origin\r\n\r\n\
    too many connections; close another viewer";

/// Serves connections for as long as it is polled.
pub(super) async fn accept(listener: TcpListener, router: Router, limits: Limits) {
    let connections = Arc::new(Connections::new(limits));
    loop {
        match listener.accept().await {
            Ok((stream, peer)) => match Connections::take(&connections, peer.ip()) {
                Some(slot) => drop(tokio::spawn(serve(stream, slot, router.clone()))),
                None => refuse(stream),
            },
            Err(fault) if is_client_error(&fault) => {}
            // No file descriptors or no memory left.
            Err(_) => {
                let closed = connections.close_oldest(|_| true);
                tokio::time::sleep(if closed { CLOSE_DELAY } else { RETRY }).await;
            }
        }
    }
}

/// Whether a client's connection failed, and not the listening socket.
fn is_client_error(fault: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset, Interrupted};
    [
        ConnectionAborted,
        ConnectionRefused,
        ConnectionReset,
        Interrupted,
    ]
    .contains(&fault.kind())
}

/// Sends an error response without waiting.
fn refuse(stream: TcpStream) {
    if let Ok(mut stream) = stream.into_std() {
        // A partial write is acceptable.
        let _ = io::Write::write(&mut stream, FULL);
    }
}

/// Serves the request of a connection. A web socket keeps the slot.
async fn serve(stream: TcpStream, slot: ConnectionSlot, router: Router) {
    let slot = Arc::new(slot);
    let limits = slot.limits();
    let close = Arc::clone(&slot.close);
    let service = TowerToHyperService::new(router);
    let service = service_fn(move |mut request: hyper::Request<Incoming>| {
        slot.mark_requested();
        request.extensions_mut().insert(Arc::clone(&slot));
        let answered = service.call(request);
        async {
            let mut response = answered.await?;
            if response.status() != StatusCode::SWITCHING_PROTOCOLS {
                let close = HeaderValue::from_static("close");
                response.headers_mut().insert(header::CONNECTION, close);
            }
            Ok::<_, Infallible>(response)
        }
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(limits.header_timeout)
        .max_buf_size(MAX_HEADERS)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
    tokio::select! {
        // A connection error concerns only its client.
        _ = tokio::time::timeout(limits.request_timeout, connection) => {}
        () = close.notified() => {}
    }
}

/// Open connections.
#[derive(Debug)]
struct Connections {
    limits: Limits,
    /// Oldest first.
    open: Mutex<Vec<Connection>>,
}

#[derive(Debug)]
struct Connection {
    address: IpAddr,
    /// Whether the request is still incomplete.
    incomplete: bool,
    /// Signal to close the connection; also its identity.
    close: Arc<Notify>,
}

/// A connection slot, released on drop.
#[derive(Debug)]
pub(super) struct ConnectionSlot {
    connections: Arc<Connections>,
    close: Arc<Notify>,
}

impl Connections {
    fn new(limits: Limits) -> Self {
        Self {
            limits,
            open: Mutex::default(),
        }
    }

    /// Takes a slot for a new connection, if possible.
    fn take(connections: &Arc<Self>, address: IpAddr) -> Option<ConnectionSlot> {
        let address = network(address);
        let is_own = |taken: &Connection| taken.address == address;
        let (own, all) = {
            let taken = connections.open();
            (
                taken.iter().filter(|taken| is_own(taken)).count(),
                taken.len(),
            )
        };
        let admitted = if own >= connections.limits.per_address {
            connections.close_oldest(is_own)
        } else if all >= connections.limits.total {
            connections.close_oldest(|_| true)
        } else {
            true
        };
        admitted.then(|| {
            let close = Arc::<Notify>::default();
            connections.open().push(Connection {
                address,
                incomplete: true,
                close: Arc::clone(&close),
            });
            ConnectionSlot {
                connections: Arc::clone(connections),
                close,
            }
        })
    }

    /// Closes the oldest selected connection without a complete request. Returns whether there was one.
    fn close_oldest(&self, of: impl Fn(&Connection) -> bool) -> bool {
        let mut taken = self.open();
        let oldest = taken.iter().position(|taken| taken.incomplete && of(taken));
        if let Some(oldest) = oldest {
            taken.remove(oldest).close.notify_one();
        }
        oldest.is_some()
    }

    fn open(&self) -> MutexGuard<'_, Vec<Connection>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl ConnectionSlot {
    /// Limits of the server.
    pub fn limits(&self) -> Limits {
        self.connections.limits
    }

    /// Marks the request as complete.
    fn mark_requested(&self) {
        let mut taken = self.connections.open();
        let own = taken.iter_mut().find(|taken| self.is(taken));
        if let Some(taken) = own {
            taken.incomplete = false;
        }
    }

    fn is(&self, taken: &Connection) -> bool {
        Arc::ptr_eq(&taken.close, &self.close)
    }
}

impl Drop for ConnectionSlot {
    fn drop(&mut self) {
        self.connections.open().retain(|taken| !self.is(taken));
    }
}

/// Address used for the limit: for IPv6 the /64 network, all of which may belong to one client.
fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(six) => Ipv6Addr::from_bits(six.to_bits() >> 64 << 64).into(),
        four => four,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn connections() -> Arc<Connections> {
        Arc::new(Connections::new(Limits {
            total: 8,
            per_address: 3,
            ..Limits::default()
        }))
    }

    fn address(number: u32) -> IpAddr {
        std::net::Ipv4Addr::from_bits(number).into()
    }

    #[test]
    fn one_address_cannot_take_all_slots() {
        let connections = connections();
        let take = |number| Connections::take(&connections, address(number));
        let own: Vec<ConnectionSlot> = (0..3).map(|_| take(1).unwrap()).collect();
        own.iter().for_each(ConnectionSlot::mark_requested);
        assert!(take(1).is_none(), "all its connections have a request");
        let other = take(2).unwrap();
        drop(own);
        assert!(take(1).is_some());
        assert!(
            !connections
                .open()
                .iter()
                .any(|taken| taken.incomplete && !other.is(taken))
        );
    }

    #[tokio::test]
    async fn the_oldest_idle_connection_is_closed_for_a_new_one() {
        let connections = connections();
        let take = |number| Connections::take(&connections, address(number));
        let asked = take(0).unwrap();
        asked.mark_requested();
        let oldest = take(1).unwrap();
        let others: Vec<ConnectionSlot> = (2..8).map(|k| take(k).unwrap()).collect();
        let new = take(1000).unwrap();
        oldest.close.notified().await;
        assert_eq!(connections.open().len(), 8);
        others.iter().for_each(ConnectionSlot::mark_requested);
        new.mark_requested();
        assert!(take(1001).is_none());
        drop(oldest);
        assert_eq!(connections.open().len(), 8, "its slot is already reused");
        drop(asked);
        assert!(take(1001).is_some());
    }

    #[test]
    fn an_ipv6_network_counts_as_one_address() {
        let [one, same, other] = ["2001:db8::1", "2001:db8::f:2", "2001:db8:0:1::1"]
            .map(|text| network(text.parse().unwrap()));
        assert!(one == same && one != other);
        assert_eq!(
            network("::ffff:10.0.0.1".parse().unwrap()),
            address(0x0a00_0001)
        );
    }
}
