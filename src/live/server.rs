//! Web servers: the page of a live run, and a recording in Rerun's web viewer.
//!
//! | path of the page | content |
//! |---|---|
//! | `/` | the page |
//! | `/control` | web socket: commands to the server, panel and rejections to the client, as JSON |
//! | `/views` | web socket: data of the views, binary, see [`ViewStore`](super::ViewStore) |
//! | `/sound` | web socket: sound at 48 kHz, 32-bit floats, binary |
//! | `/b/control`, `/b/views`, ... | the same for a second run, which starts with its first client |
//! | `/diagram.json` | branch diagram of the scene over the tilt, [`TiltDiagram`](crate::study::branch::TiltDiagram); 204 without one; the panel says when it is complete |
//! | `/tour.json` | the guided tour and the bookmarks |
//! | `/bookmark.json` | a bookmark of the present motion, with its state |
//! | `/lesson.json` | the pictures of the lesson, [`Panel`](crate::plot::Panel)s |
//! | `/recordings/NAME` | a complete recording of this session |
//!
//! If other machines can reach the page, its address contains a key that decides whether a client controls the run
//! or only watches ([`roles`]). Requests for another host name and requests from other pages are rejected ([`guard`]). The number of
//! connections is limited ([`accept`]), and so is the rate of messages of each client ([`client`]).

mod accept;
mod client;
mod files;
mod guard;
mod recording;
mod roles;
mod sockets;
#[cfg(test)]
mod tests;

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener, UdpSocket};
use std::sync::{Arc, LazyLock};
use std::thread::JoinHandle;

use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::middleware;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Extension, Router};
use re_web_viewer_server::WebViewerData;
use tokio::sync::oneshot;

pub use self::accept::Limits;
use self::guard::Access;
use self::roles::Keys;
use super::session::Session;
use super::tour::Tour;

/// Data shared by all connections of the page.
struct Shared {
    session: Arc<Session>,
    /// Address for an audience that only watches; `None` if only this machine can reach the page.
    audience_url: Option<String>,
    /// A second run for comparison.
    second: Option<Arc<Session>>,
}

/// Opens a port; 0 selects a free one.
///
/// # Errors
/// Errors of the operating system, for example if the port is in use.
pub fn bind(host: IpAddr, port: u16) -> io::Result<TcpListener> {
    let listener = TcpListener::bind((host, port))?;
    listener.set_nonblocking(true)?;
    Ok(listener)
}

/// An address that a browser can open: the unspecified address is replaced by one of this machine.
fn reachable(address: SocketAddr) -> SocketAddr {
    if !address.ip().is_unspecified() {
        return address;
    }
    // Addresses reserved for documentation. Nothing is sent; the socket only selects the outgoing interface.
    let (far, here) = if address.is_ipv4() {
        ("192.0.2.1:9", IpAddr::V4(Ipv4Addr::LOCALHOST))
    } else {
        ("[2001:db8::1]:9", IpAddr::V6(Ipv6Addr::LOCALHOST))
    };
    let way = UdpSocket::bind((address.ip(), 0)).and_then(|socket| {
        socket.connect(far)?;
        socket.local_addr()
    });
    SocketAddr::new(way.map_or(here, |way| way.ip()), address.port())
}

/// Serves until stopped.
fn serve(
    listener: TcpListener,
    router: Router,
    limits: Limits,
    stopped: oneshot::Receiver<()>,
) -> io::Result<()> {
    // Single-threaded: starting worker threads panics if the system provides no more threads.
    let runtime = tokio::runtime::Builder::new_current_thread()
        .max_blocking_threads(4)
        .enable_all()
        .build()?;
    let served = runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        tokio::select! {
            () = accept::accept(listener, router, limits) => {}
            _ = stopped => {}
        }
        Ok(())
    });
    // Closes connections that are still open.
    runtime.shutdown_background();
    served
}

/// Rerun's web viewer, 42 MB, embedded in the binary.
fn viewer() -> io::Result<&'static WebViewerData> {
    static VIEWER: LazyLock<Result<WebViewerData, String>> =
        LazyLock::new(|| WebViewerData::load(None).map_err(|fault| fault.to_string()));
    VIEWER.as_ref().map_err(|fault| io::Error::other(&**fault))
}

/// A running server on its own thread: of the page of a session, or of a recording.
pub struct Page {
    /// Stops the server when it is dropped.
    stop: oneshot::Sender<()>,
    serving: JoinHandle<io::Result<()>>,
    /// The second run of a page.
    second: Option<Arc<Session>>,
    url: String,
}

impl Page {
    /// Serves the page of a session, with a session for a second run next to the first one; it must not run yet.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn open(
        listener: TcpListener,
        session: Arc<Session>,
        second: Option<Arc<Session>>,
        limits: Limits,
    ) -> io::Result<Self> {
        let address = listener.local_addr()?;
        let keys = (!address.ip().is_loopback()).then(Keys::new);
        let plain = format!("http://{}/", reachable(address));
        let keyed = |key: &String| format!("{plain}?key={key}");
        let url = keys.as_ref().map(|keys| keyed(&keys.presenter));
        let shared = Arc::new(Shared {
            session,
            audience_url: keys.as_ref().map(|keys| keyed(&keys.audience)),
            second: second.clone(),
        });
        let page = Self::start(listener, keys, router(shared), limits)?;
        let url = url.unwrap_or(plain);
        Ok(Self {
            second,
            url,
            ..page
        })
    }

    /// Serves a recording in Rerun's web viewer.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn of_recording(listener: TcpListener, recording: &std::path::Path) -> io::Result<Self> {
        let router = recording::router(recording)?;
        Self::start(listener, None, router, Limits::default())
    }

    fn start(
        listener: TcpListener,
        keys: Option<Keys>,
        router: Router,
        limits: Limits,
    ) -> io::Result<Self> {
        let address = listener.local_addr()?;
        let access = Arc::new(Access { address, keys });
        let router = router.layer(middleware::from_fn_with_state(access, guard::guard));
        let (stop, stopped) = oneshot::channel();
        let serving = std::thread::Builder::new()
            .name("page".to_owned())
            .spawn(move || serve(listener, router, limits, stopped))?;
        Ok(Self {
            stop,
            serving,
            second: None,
            url: format!("http://{address}/"),
        })
    }

    /// Address of the page for the presenter; if it is served on all interfaces, the address for other machines.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Whether the server has stopped.
    pub fn is_finished(&self) -> bool {
        self.serving.is_finished()
    }

    /// Stops the server and the second run, and closes open connections.
    ///
    /// # Errors
    /// The error that stopped the server or the second run earlier.
    pub fn close(self) -> io::Result<()> {
        drop(self.stop);
        let panicked = |_| Err(io::Error::other("the thread of the page panicked"));
        let served = self.serving.join().unwrap_or_else(panicked);
        if let Some(second) = self.second {
            second.end();
            second.join().map_err(io::Error::other)?;
        }
        served
    }
}

fn router(shared: Arc<Shared>) -> Router {
    let mut router = files::routes(Router::new(), files::page());
    if let Some(second) = &shared.second {
        router = router.nest(guard::SECOND, run_routes(second));
    }
    router
        .route("/favicon.ico", get(favicon))
        .route("/diagram.json", get(diagram))
        .route("/tour.json", get(tour))
        .route("/recordings/{name}", get(recording))
        .merge(run_routes(&shared.session))
        .with_state(shared)
}

/// Web sockets of one run.
fn run_routes(session: &Arc<Session>) -> Router<Arc<Shared>> {
    Router::new()
        .route("/bookmark.json", get(bookmark))
        .route("/lesson.json", get(lesson))
        .route("/control", get(sockets::control))
        .route("/views", get(sockets::views))
        .route("/sound", get(sockets::sound))
        .layer(Extension(Arc::clone(session)))
}

async fn diagram(State(shared): State<Arc<Shared>>) -> Response {
    match shared.session.diagrams.diagram() {
        Some(diagram) => json(&*diagram),
        None => StatusCode::NO_CONTENT.into_response(),
    }
}

/// A value as JSON.
fn json(value: &impl serde::Serialize) -> Response {
    let text = serde_json::to_string(value).unwrap_or_default();
    ([(header::CONTENT_TYPE, "application/json")], text).into_response()
}

async fn tour(State(shared): State<Arc<Shared>>) -> Response {
    let tour = &shared.session.options.tour;
    json(&serde_json::json!({ "tour": tour, "bookmarks": Tour::bookmarks() }))
}

async fn bookmark(Extension(session): Extension<Arc<Session>>) -> Response {
    json(&session.bookmark())
}

async fn lesson(Extension(session): Extension<Arc<Session>>) -> Response {
    json(&session.views.lesson())
}

/// A complete recording of this session, for a download.
async fn recording(State(shared): State<Arc<Shared>>, Path(name): Path<String>) -> Response {
    let Some(path) = shared.session.recording.complete(&name) else {
        return StatusCode::NOT_FOUND.into_response();
    };
    let saved = (header::CONTENT_DISPOSITION, "attachment");
    ([saved], recording::streamed(&path).await).into_response()
}

async fn favicon() -> Response {
    match viewer() {
        Ok(viewer) => ([(header::CONTENT_TYPE, "image/x-icon")], viewer.favicon()).into_response(),
        Err(_) => StatusCode::NOT_FOUND.into_response(),
    }
}
