//! Who is let in: a limit of connections in all and for each address, and none that only waits.
//!
//! A connection has one request. Where there are too many, or no file descriptors are left, the one that has been
//! waited for longest without a whole request makes room for the newcomer.

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

/// How much of the server there is for a client.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Connections in all.
    pub in_all: usize,
    /// Connections of one address.
    pub per_address: usize,
    /// Wall time for a request's line and headers.
    pub for_headers: Duration,
    /// Wall time for a request and its answer.
    pub for_answer: Duration,
    /// Wall time for the client of a web socket to take in a message.
    pub for_message: Duration,
    /// Wall time after which a silent client of a web socket is asked whether it is there, and has to answer.
    pub silence: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            in_all: 128,
            // A page has three, and a few while it loads.
            per_address: 32,
            for_headers: Duration::from_secs(10),
            // The viewer's 42 MB at 1.2 Mbit/s.
            for_answer: Duration::from_secs(300),
            for_message: Duration::from_secs(10),
            silence: Duration::from_secs(20),
        }
    }
}

/// Bytes of a request's line and headers.
const HEADERS: usize = 1 << 14;
/// How long is waited when the system accepts nobody.
const RETRY: Duration = Duration::from_millis(50);
/// How long is waited for a connection to be closed that makes room.
const CLOSED: Duration = Duration::from_millis(1);

const FULL: &[u8] =
    b"HTTP/1.1 503 Service Unavailable\r\nconnection: close\r\ncontent-length: 42\r\n\
    cross-origin-resource-policy: same-origin\r\n\r\n\
    too many connections: close a page of this";

/// Serves whoever comes, for as long as it is polled.
pub(super) async fn accept(listener: TcpListener, router: Router, limits: Limits) {
    let seats = Arc::new(Seats::new(limits));
    loop {
        match listener.accept().await {
            Ok((stream, peer)) => match Seats::take(&seats, peer.ip()) {
                Some(seat) => drop(tokio::spawn(attend(stream, seat, router.clone()))),
                None => refuse(stream),
            },
            Err(fault) if is_of_the_client(&fault) => {}
            // There are no descriptors left, or no memory.
            Err(_) => {
                let made_room = seats.make_room(|_| true);
                tokio::time::sleep(if made_room { CLOSED } else { RETRY }).await;
            }
        }
    }
}

/// Whether it is a client's connection that failed, not the listening.
fn is_of_the_client(fault: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset, Interrupted};
    [
        ConnectionAborted,
        ConnectionRefused,
        ConnectionReset,
        Interrupted,
    ]
    .contains(&fault.kind())
}

/// Tells a client, if it still listens, that there is no room.
fn refuse(stream: TcpStream) {
    if let Ok(mut stream) = stream.into_std() {
        // Without waiting; what fits nowhere is lost.
        let _ = io::Write::write(&mut stream, FULL);
    }
}

/// Serves the request of a connection. A web socket takes the seat along.
async fn attend(stream: TcpStream, seat: Seat, router: Router) {
    let seat = Arc::new(seat);
    let limits = seat.limits();
    let dismissed = Arc::clone(&seat.dismissed);
    let service = TowerToHyperService::new(router);
    let service = service_fn(move |mut request: hyper::Request<Incoming>| {
        seat.has_asked();
        request.extensions_mut().insert(Arc::clone(&seat));
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
        .header_read_timeout(limits.for_headers)
        .max_buf_size(HEADERS)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
    tokio::select! {
        // Whatever ends it is the client's affair.
        _ = tokio::time::timeout(limits.for_answer, connection) => {}
        () = dismissed.notified() => {}
    }
}

/// The connections that there are.
#[derive(Debug)]
struct Seats {
    limits: Limits,
    /// Oldest first.
    taken: Mutex<Vec<Taken>>,
}

#[derive(Debug)]
struct Taken {
    address: IpAddr,
    /// Whether there is no whole request yet.
    waits: bool,
    /// Also what it is known by.
    dismissed: Arc<Notify>,
}

/// A connection's place, free again when this is dropped.
#[derive(Debug)]
pub(super) struct Seat {
    seats: Arc<Seats>,
    dismissed: Arc<Notify>,
}

impl Seats {
    fn new(limits: Limits) -> Self {
        Self {
            limits,
            taken: Mutex::default(),
        }
    }

    /// A place for a newcomer, if there is one.
    fn take(seats: &Arc<Self>, address: IpAddr) -> Option<Seat> {
        let address = network(address);
        let is_own = |taken: &Taken| taken.address == address;
        let (own, all) = {
            let taken = seats.taken();
            (
                taken.iter().filter(|taken| is_own(taken)).count(),
                taken.len(),
            )
        };
        let room = if own >= seats.limits.per_address {
            seats.make_room(is_own)
        } else if all >= seats.limits.in_all {
            seats.make_room(|_| true)
        } else {
            true
        };
        room.then(|| {
            let dismissed = Arc::<Notify>::default();
            seats.taken().push(Taken {
                address,
                waits: true,
                dismissed: Arc::clone(&dismissed),
            });
            Seat {
                seats: Arc::clone(seats),
                dismissed,
            }
        })
    }

    /// Dismisses the oldest of some that only wait; whether there was one.
    fn make_room(&self, of: impl Fn(&Taken) -> bool) -> bool {
        let mut taken = self.taken();
        let oldest = taken.iter().position(|taken| taken.waits && of(taken));
        if let Some(oldest) = oldest {
            taken.remove(oldest).dismissed.notify_one();
        }
        oldest.is_some()
    }

    fn taken(&self) -> MutexGuard<'_, Vec<Taken>> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Seat {
    /// How much there is for a client.
    pub fn limits(&self) -> Limits {
        self.seats.limits
    }

    /// Notes that there is a whole request.
    fn has_asked(&self) {
        let mut taken = self.seats.taken();
        let own = taken.iter_mut().find(|taken| self.is(taken));
        if let Some(taken) = own {
            taken.waits = false;
        }
    }

    fn is(&self, taken: &Taken) -> bool {
        Arc::ptr_eq(&taken.dismissed, &self.dismissed)
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.seats.taken().retain(|taken| !self.is(taken));
    }
}

/// What counts as one address: of IPv6 the network, whose every address one client may have.
fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(six) => Ipv6Addr::from_bits(six.to_bits() >> 64 << 64).into(),
        four => four,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seats() -> Arc<Seats> {
        Arc::new(Seats::new(Limits {
            in_all: 8,
            per_address: 3,
            ..Limits::default()
        }))
    }

    fn address(number: u32) -> IpAddr {
        std::net::Ipv4Addr::from_bits(number).into()
    }

    #[test]
    fn one_address_does_not_take_all_places() {
        let seats = seats();
        let take = |number| Seats::take(&seats, address(number));
        let own: Vec<Seat> = (0..3).map(|_| take(1).unwrap()).collect();
        own.iter().for_each(Seat::has_asked);
        assert!(take(1).is_none(), "all of them have a request");
        let other = take(2).unwrap();
        drop(own);
        assert!(take(1).is_some());
        assert!(
            !seats
                .taken()
                .iter()
                .any(|taken| taken.waits && !other.is(taken))
        );
    }

    #[tokio::test]
    async fn the_oldest_that_only_waits_makes_room() {
        let seats = seats();
        let take = |number| Seats::take(&seats, address(number));
        let asked = take(0).unwrap();
        asked.has_asked();
        let oldest = take(1).unwrap();
        let others: Vec<Seat> = (2..8).map(|k| take(k).unwrap()).collect();
        let newcomer = take(1000).unwrap();
        oldest.dismissed.notified().await;
        assert_eq!(seats.taken().len(), 8);
        others.iter().for_each(Seat::has_asked);
        newcomer.has_asked();
        assert!(take(1001).is_none());
        drop(oldest);
        assert_eq!(seats.taken().len(), 8, "its place was given away");
        drop(asked);
        assert!(take(1001).is_some());
    }

    #[test]
    fn a_network_of_ipv6_counts_as_one_address() {
        let [one, same, other] = ["2001:db8::1", "2001:db8::f:2", "2001:db8:0:1::1"]
            .map(|text| network(text.parse().unwrap()));
        assert!(one == same && one != other);
        assert_eq!(
            network("::ffff:10.0.0.1".parse().unwrap()),
            address(0x0a00_0001)
        );
    }
}
