//! Web server of the page: a control panel next to the web viewer.
//!
//! | path | content |
//! |---|---|
//! | `/` | the page |
//! | `/control` | web socket: commands to the server, panel and rejections to the client, as JSON |
//! | `/stream` | web socket: the recording in complete messages, binary |
//! | `/sound` | web socket: sound at 48 kHz, 32-bit floats, binary |
//! | `/diagram.json` | branch diagram of the scene over the tilt, [`TiltDiagram`](crate::study::branch::TiltDiagram); 404 without or before one |
//! | `/viewer.js`, `/viewer.wasm` | Rerun's web viewer, embedded in the binary |
//!
//! Requests for another host name and requests from other pages are rejected ([`guard`]). The number of
//! connections is limited ([`accept`]), and so is the rate of messages of each client ([`client`]).

mod accept;
mod client;
mod guard;
mod shared;
mod sockets;
#[cfg(test)]
mod tests;

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;

use axum::Router;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::middleware;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use re_web_viewer_server::WebViewerData;
use tokio::net::TcpListener;
use tokio::sync::watch;

use self::accept::Limits;
use self::shared::{PANEL_EVERY, Shared};
use super::bands::RegimeBands;
use super::session::Session;

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

/// The running server.
#[derive(Debug)]
pub struct Page {
    stop: watch::Sender<bool>,
    serving: JoinHandle<std::io::Result<()>>,
    url: String,
}

impl Page {
    /// Serves the page of a session. The bands below the tilt slider are `swept`, or else those of linear
    /// stability, which are recomputed for each scene.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn open(
        serving: BoundListener,
        session: Arc<Session>,
        swept: Option<RegimeBands>,
    ) -> std::io::Result<Self> {
        Self::limited(serving, session, swept, Limits::default())
    }

    fn limited(
        serving: BoundListener,
        session: Arc<Session>,
        swept: Option<RegimeBands>,
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
        let shared = Arc::new(Shared {
            session: Arc::clone(&session),
            viewer,
            address: serving.address,
            bands,
        });
        let bands_stopped = stopped.clone();
        std::thread::Builder::new()
            .name("bands".to_owned())
            .spawn(move || update_bands(&session, swept, &sender, &bands_stopped))?;
        let url = format!("http://{}/", reachable(serving.address));
        let serving = std::thread::Builder::new()
            .name("page".to_owned())
            .spawn(move || serve(serving.listener, shared, limits, stopped))?;
        Ok(Self { stop, serving, url })
    }

    /// Address of the page; if it is served on all interfaces, the address for other machines.
    pub fn url(&self) -> String {
        self.url.clone()
    }

    /// Whether the server has stopped.
    pub fn is_finished(&self) -> bool {
        self.serving.is_finished()
    }

    /// Stops the server and closes open connections.
    ///
    /// # Errors
    /// The error that stopped the server earlier.
    pub fn close(self) -> std::io::Result<()> {
        self.stop.send_replace(true);
        let served = self.serving.join();
        served.unwrap_or_else(|_| Err(std::io::Error::other("the thread of the page panicked")))
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
            let bands = panel.tilt_range_deg.map(|reach| match &swept {
                Some(swept) => swept.clone(),
                None => RegimeBands::from_stability(&session.scene(), reach),
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
    macro_rules! file {
        ($type:literal, $path:literal) => {
            get(|| async { ([(header::CONTENT_TYPE, $type)], include_str!($path)) })
        };
    }
    Router::new()
        .route("/", file!("text/html; charset=utf-8", "page/index.html"))
        .route(
            "/page.css",
            file!("text/css; charset=utf-8", "page/page.css"),
        )
        .route(
            "/page.js",
            file!("text/javascript; charset=utf-8", "page/page.js"),
        )
        .route(
            "/viewer-host.js",
            file!("text/javascript; charset=utf-8", "page/viewer-host.js"),
        )
        .route(
            "/listen.js",
            file!("text/javascript; charset=utf-8", "page/listen.js"),
        )
        .route("/viewer.js", get(viewer_js))
        .route("/viewer.wasm", get(viewer_wasm))
        .route("/favicon.ico", get(favicon))
        .route("/diagram.json", get(diagram))
        .route("/control", get(sockets::control))
        .route("/stream", get(sockets::stream))
        .route("/sound", get(sockets::sound))
        .layer(middleware::from_fn_with_state(
            Arc::clone(&shared),
            guard::guard,
        ))
        .with_state(shared)
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
        None => StatusCode::NOT_FOUND.into_response(),
    }
}

async fn favicon(State(shared): State<Arc<Shared>>) -> Response {
    let body = Bytes::from_static(shared.viewer.favicon());
    ([(header::CONTENT_TYPE, "image/x-icon")], body).into_response()
}
