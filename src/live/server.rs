//! Web server of the page: controls, views, and the web viewer on request.
//!
//! | path | content |
//! |---|---|
//! | `/` | the page |
//! | `/control` | web socket: commands to the server, panel and rejections to the client, as JSON |
//! | `/views` | web socket: data of the page's own views, binary, see [`ViewStore`](super::ViewStore) |
//! | `/b/control`, `/b/views`, `/b/sound` | the same for a second run, which starts with its first client |
//! | `/stream` | web socket: the recording in complete messages, binary |
//! | `/sound` | web socket: sound at 48 kHz, 32-bit floats, binary |
//! | `/diagram.json` | branch diagram of the scene over the tilt, [`TiltDiagram`](crate::study::branch::TiltDiagram); 204 without one; the panel says when it is complete |
//! | `/tour.json` | the guided tour |
//! | `/recordings/NAME` | a complete recording of this session |
//! | `/viewer.js`, `/viewer.wasm` | Rerun's web viewer, embedded in the binary |
//!
//! If other machines can reach the page, its address contains a key that decides whether a client controls the run
//! or only watches ([`roles`]). Requests for another host name and requests from other pages are rejected ([`guard`]). The number of
//! connections is limited ([`accept`]), and so is the rate of messages of each client ([`client`]).

mod accept;
mod client;
mod files;
mod guard;
mod roles;
mod second;
mod shared;
mod sockets;
#[cfg(test)]
mod tests;

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;

use axum::body::Bytes;
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::middleware;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Extension, Router};
use re_web_viewer_server::WebViewerData;
use tokio::net::TcpListener;
use tokio::sync::watch;

use self::accept::Limits;
use self::roles::Keys;
use self::second::SecondRun;
use self::shared::{PANEL_EVERY, Shared};
use super::bands::RegimeBands;
use super::session::Session;
use super::tour::Tour;

/// Maximum size of a recording for a download, bytes: it is read into memory.
const MAX_DOWNLOAD: u64 = 1 << 29;

/// Rerun's web viewer, 42 MB, embedded in the binary.
static VIEWER: OnceLock<WebViewerData> = OnceLock::new();

/// A listener bound to an address: a listening socket.
#[derive(Debug)]
pub struct BoundListener {
    listener: std::net::TcpListener,
    /// Its address.
    pub address: SocketAddr,
}

/// Opens a port; 0 selects a free one.
///
/// # Errors
/// Errors of the operating system, for example if the port is in use.
pub fn bind(host: IpAddr, port: u16) -> std::io::Result<BoundListener> {
    let listener = std::net::TcpListener::bind((host, port))?;
    listener.set_nonblocking(true)?;
    let address = listener.local_addr()?;
    Ok(BoundListener { listener, address })
}

/// An address that a browser can open: the unspecified address is replaced by one of this machine.
fn reachable(address: SocketAddr) -> SocketAddr {
    if !address.ip().is_unspecified() {
        return address;
    }
    // Addresses reserved for documentation. Nothing is sent; the socket only selects the outgoing interface.
    let (far, here): (IpAddr, IpAddr) = match address {
        SocketAddr::V4(_) => (
            Ipv4Addr::new(192, 0, 2, 1).into(),
            Ipv4Addr::LOCALHOST.into(),
        ),
        SocketAddr::V6(_) => (
            Ipv6Addr::new(0x2001, 0xdb8, 0, 0, 0, 0, 0, 1).into(),
            Ipv6Addr::LOCALHOST.into(),
        ),
    };
    let way = UdpSocket::bind((address.ip(), 0)).and_then(|socket| {
        socket.connect((far, 9))?;
        socket.local_addr()
    });
    SocketAddr::new(way.map_or(here, |way| way.ip()), address.port())
}

/// Content of a page besides the run.
#[derive(Clone, Default)]
pub struct PageContent {
    /// Type of motion versus tilt of a scene, for the strip below the tilt slider. Other scenes show their branch diagrams,
    /// or linear stability.
    pub swept: Option<RegimeBands>,
    /// The tour.
    pub tour: Option<Tour>,
    /// Whether the page starts the tour when it opens.
    pub starts_tour: bool,
    /// A session for a second run next to the first one; it must not run yet.
    pub second: Option<Arc<Session>>,
}

/// The running server.
pub struct Page {
    stop: watch::Sender<bool>,
    serving: JoinHandle<std::io::Result<()>>,
    shared: Arc<Shared>,
    url: String,
}

impl Page {
    /// Serves the page of a session.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn open(
        serving: BoundListener,
        session: Arc<Session>,
        content: PageContent,
    ) -> std::io::Result<Self> {
        Self::limited(serving, session, content, Limits::default())
    }

    fn limited(
        serving: BoundListener,
        session: Arc<Session>,
        content: PageContent,
        limits: Limits,
    ) -> std::io::Result<Self> {
        let viewer = match VIEWER.get() {
            Some(viewer) => viewer,
            None => {
                let viewer = WebViewerData::load(None).map_err(std::io::Error::other)?;
                VIEWER.get_or_init(|| viewer)
            }
        };
        let (stop, stopped) = watch::channel(false);
        let (sender, bands) = watch::channel(RegimeBands::default());
        let PageContent {
            swept,
            tour,
            starts_tour,
            second,
        } = content;
        let keys = (!serving.address.ip().is_loopback()).then(Keys::new);
        let plain = format!("http://{}/", reachable(serving.address));
        let key = keys.as_ref().map(|keys| format!("?key={}", keys.presenter));
        let url = format!("{plain}{}", key.unwrap_or_default());
        let tour = serde_json::json!({ "tour": tour, "starts": starts_tour });
        let shared = Arc::new(Shared {
            session: Arc::clone(&session),
            viewer,
            address: serving.address,
            bands,
            keys,
            url: plain,
            second: second.map(SecondRun::new),
            tour: tour.to_string(),
        });
        let bands_stopped = stopped.clone();
        std::thread::Builder::new()
            .name("bands".to_owned())
            .spawn(move || update_bands(&session, swept, &sender, &bands_stopped))?;
        let serving = std::thread::Builder::new().name("page".to_owned()).spawn({
            let shared = Arc::clone(&shared);
            move || serve(serving.listener, shared, limits, stopped)
        })?;
        Ok(Self {
            stop,
            serving,
            shared,
            url,
        })
    }

    /// Address of the page for the presenter; if it is served on all interfaces, the address for other machines.
    pub fn url(&self) -> String {
        self.url.clone()
    }

    /// Whether the server has stopped.
    pub fn is_finished(&self) -> bool {
        self.serving.is_finished()
    }

    /// Stops the server and the second run, and closes open connections.
    ///
    /// # Errors
    /// The error that stopped the server or the second run earlier.
    pub fn close(self) -> std::io::Result<()> {
        self.stop.send_replace(true);
        let served = self.serving.join();
        let ended = self.shared.second.as_ref().map_or(Ok(()), SecondRun::end);
        let panicked = |_| Err(std::io::Error::other("the thread of the page panicked"));
        served.unwrap_or_else(panicked).and(ended)
    }
}

/// Updates the bands for each run.
fn update_bands(
    session: &Session,
    swept: Option<RegimeBands>,
    sender: &watch::Sender<RegimeBands>,
    stopped: &watch::Receiver<bool>,
) {
    let mut drawn = 0;
    while !*stopped.borrow() {
        let panel = session.panel();
        if panel.run > drawn {
            drawn = panel.run;
            let scene = session.scene();
            let own = swept.as_ref().filter(|swept| swept.scene == scene.name);
            let bands = panel.tilt_range_deg.map(|reach| match own {
                Some(swept) => swept.clone(),
                None => RegimeBands::from_stability(&scene, reach),
            });
            sender.send_replace(bands.unwrap_or_default());
        }
        std::thread::sleep(PANEL_EVERY);
    }
}

/// Serves until stopped.
fn serve(
    listener: std::net::TcpListener,
    shared: Arc<Shared>,
    limits: Limits,
    mut stopped: watch::Receiver<bool>,
) -> std::io::Result<()> {
    // Single-threaded: starting worker threads panics if the system provides no more threads.
    let runtime = tokio::runtime::Builder::new_current_thread()
        .max_blocking_threads(4)
        .enable_all()
        .build()?;
    let served = runtime.block_on(async {
        let listener = TcpListener::from_std(listener)?;
        tokio::select! {
            () = accept::accept(listener, router(shared), limits) => {}
            // A dropped sender also stops the server.
            _ = stopped.wait_for(|stopped| *stopped) => {}
        }
        Ok(())
    });
    // Closes connections that are still open.
    runtime.shutdown_background();
    served
}

fn router(shared: Arc<Shared>) -> Router {
    let mut router = files::routes(Router::new());
    if let Some(second) = &shared.second {
        router = router.nest("/b", run_routes(&second.session));
    }
    router
        .route("/viewer.js", get(viewer_js))
        .route("/viewer.wasm", get(viewer_wasm))
        .route("/favicon.ico", get(favicon))
        .route("/diagram.json", get(diagram))
        .route("/tour.json", get(tour))
        .route("/recordings/{name}", get(recording))
        .merge(run_routes(&shared.session))
        .route("/stream", get(sockets::stream))
        .layer(middleware::from_fn_with_state(
            Arc::clone(&shared),
            guard::guard,
        ))
        .with_state(shared)
}

/// Web sockets of one run.
fn run_routes(session: &Arc<Session>) -> Router<Arc<Shared>> {
    Router::new()
        .route("/control", get(sockets::control))
        .route("/views", get(sockets::views))
        .route("/sound", get(sockets::sound))
        .layer(Extension(Arc::clone(session)))
}

async fn viewer_js(State(shared): State<Arc<Shared>>) -> Response {
    let body = Bytes::from_static(shared.viewer.viewer_js());
    let kind = (header::CONTENT_TYPE, "text/javascript; charset=utf-8");
    ([kind], body).into_response()
}

async fn viewer_wasm(State(shared): State<Arc<Shared>>) -> Response {
    let body = Bytes::from_static(shared.viewer.viewer_wasm());
    ([(header::CONTENT_TYPE, "application/wasm")], body).into_response()
}

async fn diagram(State(shared): State<Arc<Shared>>) -> Response {
    let kind = (header::CONTENT_TYPE, "application/json");
    match shared.session.diagram() {
        Some(text) => ([kind], text.to_string()).into_response(),
        None => StatusCode::NO_CONTENT.into_response(),
    }
}

async fn tour(State(shared): State<Arc<Shared>>) -> Response {
    let kind = (header::CONTENT_TYPE, "application/json");
    ([kind], shared.tour.clone()).into_response()
}

/// A complete recording of this session.
async fn recording(State(shared): State<Arc<Shared>>, Path(name): Path<String>) -> Response {
    let Some(path) = shared.session.complete_recording(&name) else {
        return StatusCode::NOT_FOUND.into_response();
    };
    let read = tokio::task::spawn_blocking(move || match path.metadata()?.len() {
        ..=MAX_DOWNLOAD => std::fs::read(path).map(Some),
        _ => Ok(None),
    });
    match read.await {
        Ok(Ok(Some(bytes))) => {
            let kind = (header::CONTENT_TYPE, "application/octet-stream");
            let saved = (header::CONTENT_DISPOSITION, "attachment");
            ([kind, saved], bytes).into_response()
        }
        Ok(Ok(None)) => {
            let why = "the recording is too large for a download; copy the file";
            (StatusCode::PAYLOAD_TOO_LARGE, why).into_response()
        }
        Ok(Err(_)) | Err(_) => StatusCode::NOT_FOUND.into_response(),
    }
}

async fn favicon(State(shared): State<Arc<Shared>>) -> Response {
    let body = Bytes::from_static(shared.viewer.favicon());
    ([(header::CONTENT_TYPE, "image/x-icon")], body).into_response()
}
