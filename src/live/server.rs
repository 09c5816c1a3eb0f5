//! The page: a control panel beside the web viewer.
//!
//! | path | what |
//! |---|---|
//! | `/` | the page |
//! | `/control` | web socket: commands in, the panel and refusals out, as JSON |
//! | `/stream` | web socket: the recording, whole streams of messages, binary |
//! | `/sound` | web socket: sound at 48 kHz, 32-bit floats, binary |
//! | `/viewer.js`, `/viewer.wasm` | Rerun's web viewer, from the binary |
//!
//! Whatever comes under a name that is not this server's, or from a page that it has not served, is refused
//! ([`guard`]). Connections are limited ([`accept`]), and so is what each client may send ([`client`]).

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
use axum::http::header;
use axum::middleware;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use re_web_viewer_server::WebViewerData;
use tokio::net::TcpListener;
use tokio::sync::watch;

use self::accept::Limits;
use self::shared::{PANEL_EVERY, Shared};
use super::bands::Bands;
use super::session::Session;

/// Rerun's web viewer, 42 MB, from the binary.
static VIEWER: OnceLock<WebViewerData> = OnceLock::new();

/// A server that has a port.
#[derive(Debug)]
pub struct Serving {
    listener: std::net::TcpListener,
    /// Where it listens.
    pub address: SocketAddr,
}

/// Takes a port; 0 for any that is free.
///
/// # Errors
/// What the system says, such as that the port is taken.
pub fn bind(host: IpAddr, port: u16) -> std::io::Result<Serving> {
    let listener = std::net::TcpListener::bind((host, port))?;
    listener.set_nonblocking(true)?;
    let address = listener.local_addr()?;
    Ok(Serving { listener, address })
}

/// An address that can be opened: one that stands for all of a machine's cannot.
fn reachable(address: SocketAddr) -> SocketAddr {
    if !address.ip().is_unspecified() {
        return address;
    }
    // Addresses for documentation. Nothing is sent; it is only asked which way it would leave.
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

/// The page while it is served.
#[derive(Debug)]
pub struct Page {
    over: watch::Sender<bool>,
    serving: JoinHandle<std::io::Result<()>>,
    url: String,
}

impl Page {
    /// Serves the page of a session. Under the slider of the tilt are the bands of `swept`, else those of
    /// linear stability, which are computed anew for each scene.
    ///
    /// # Errors
    /// What the system says.
    pub fn open(
        serving: Serving,
        session: Arc<Session>,
        swept: Option<Bands>,
    ) -> std::io::Result<Self> {
        Self::limited(serving, session, swept, Limits::default())
    }

    fn limited(
        serving: Serving,
        session: Arc<Session>,
        swept: Option<Bands>,
        limits: Limits,
    ) -> std::io::Result<Self> {
        let viewer = match VIEWER.get() {
            Some(viewer) => viewer,
            None => {
                let viewer = WebViewerData::load(None).map_err(std::io::Error::other)?;
                VIEWER.get_or_init(|| viewer)
            }
        };
        let (over, ending) = watch::channel(false);
        let (tell, bands) = watch::channel(Bands::default());
        let shared = Arc::new(Shared {
            session: Arc::clone(&session),
            viewer,
            address: serving.address,
            bands,
        });
        let still = ending.clone();
        std::thread::Builder::new()
            .name("bands".to_owned())
            .spawn(move || draw_bands(&session, swept, &tell, &still))?;
        let url = format!("http://{}/", reachable(serving.address));
        let serving = std::thread::Builder::new()
            .name("page".to_owned())
            .spawn(move || serve(serving.listener, shared, limits, ending))?;
        Ok(Self { over, serving, url })
    }

    /// Where it is; if it is served on all addresses, where other machines find it.
    pub fn url(&self) -> String {
        self.url.clone()
    }

    /// Whether it is served no longer.
    pub fn is_over(&self) -> bool {
        self.serving.is_finished()
    }

    /// Ends it; connections that are open are cut.
    ///
    /// # Errors
    /// Why it had ended before.
    pub fn close(self) -> std::io::Result<()> {
        self.over.send_replace(true);
        let served = self.serving.join();
        served.unwrap_or_else(|_| Err(std::io::Error::other("the thread of the page panicked")))
    }
}

/// Follows the scenes with the bands of each.
fn draw_bands(
    session: &Session,
    swept: Option<Bands>,
    tell: &watch::Sender<Bands>,
    over: &watch::Receiver<bool>,
) {
    let mut drawn = 0;
    while !*over.borrow() {
        let panel = session.panel();
        if panel.run > drawn {
            drawn = panel.run;
            let bands = panel.reach_deg.map(|reach| match &swept {
                Some(swept) => swept.clone(),
                None => Bands::by_stability(&session.scene(), reach),
            });
            tell.send_replace(bands.unwrap_or_default());
        }
        std::thread::sleep(PANEL_EVERY);
    }
}

/// Serves until it is over.
fn serve(
    listener: std::net::TcpListener,
    shared: Arc<Shared>,
    limits: Limits,
    mut over: watch::Receiver<bool>,
) -> std::io::Result<()> {
    // On this thread: where there are no more, workers would end in a panic.
    let runtime = tokio::runtime::Builder::new_current_thread()
        .max_blocking_threads(4)
        .enable_all()
        .build()?;
    let served = runtime.block_on(async {
        let listener = TcpListener::from_std(listener)?;
        tokio::select! {
            () = accept::accept(listener, router(shared), limits) => {}
            // Whoever holds the other end and lets go of it has ended, too.
            _ = over.wait_for(|over| *over) => {}
        }
        Ok(())
    });
    // Connections that are still open are cut.
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

async fn favicon(State(shared): State<Arc<Shared>>) -> Response {
    let body = Bytes::from_static(shared.viewer.favicon());
    ([(header::CONTENT_TYPE, "image/x-icon")], body).into_response()
}
