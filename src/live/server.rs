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
//! Whatever comes under a name that is not this server's, or from a page that it has not served, is refused: a
//! page from elsewhere that is open in the same browser can neither read nor steer.

use std::collections::HashSet;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use axum::Router;
use axum::body::Bytes;
use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocket, WebSocketUpgrade};
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use re_web_viewer_server::WebViewerData;
use serde::{Deserialize, Serialize};
use tokio::net::TcpListener;
use tokio::sync::broadcast::error::{RecvError, TryRecvError};
use tokio::sync::watch;

use super::bands::Bands;
use super::flow::Flow;
use super::hub::{Name, News, Ticket};
use super::session::{Command, HARD, KICKS, PACES, Session};

/// How often the panel is sent, if it has changed.
const PANEL_EVERY: Duration = Duration::from_millis(50);
/// Bytes of a message to a viewer, about.
const MESSAGE: usize = 1 << 20;
/// Bytes of a command, at most.
const LONGEST_COMMAND: usize = 1 << 12;
/// Why a connection is closed that lags too far behind: the page connects anew.
const TOO_SLOW: u16 = 4000;

/// What may be loaded and reached from the page: nothing but this server.
const CONTENT_POLICY: &str = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; \
    style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; connect-src 'self'; \
    worker-src 'self' blob:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

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

struct Shared {
    session: Arc<Session>,
    viewer: &'static WebViewerData,
    address: SocketAddr,
    bands: watch::Receiver<Bands>,
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
            .spawn(move || serve(serving.listener, shared, ending))?;
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
    mut over: watch::Receiver<bool>,
) -> std::io::Result<()> {
    // On this thread alone: where there are no more, workers would end in a panic.
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?;
    let served = runtime.block_on(async {
        let listener = TcpListener::from_std(listener)?;
        let serving = axum::serve(listener, router(shared));
        tokio::select! {
            served = serving => served,
            // Whoever holds the other end and lets go of it has ended, too.
            _ = over.wait_for(|over| *over) => Ok(()),
        }
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
        .route("/control", get(control))
        .route("/stream", get(stream))
        .route("/sound", get(sound))
        .layer(middleware::from_fn_with_state(Arc::clone(&shared), guard))
        .with_state(shared)
}

/// Refuses what is meant for, or comes from, somewhere else.
async fn guard(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    if let Err(why) = admitted(request.headers(), shared.address) {
        return (StatusCode::FORBIDDEN, why).into_response();
    }
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    let mut set = |name, value| headers.insert(name, HeaderValue::from_static(value));
    set(header::CONTENT_SECURITY_POLICY, CONTENT_POLICY);
    set(header::X_CONTENT_TYPE_OPTIONS, "nosniff");
    set(header::REFERRER_POLICY, "no-referrer");
    set(header::CACHE_CONTROL, "no-store");
    response
}

/// Whether a request names this server, and comes from its page or from no page at all.
fn admitted(headers: &HeaderMap, address: SocketAddr) -> Result<(), &'static str> {
    let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or(""));
    let host = text(header::HOST).ok_or("a request must say which host it is for")?;
    if !is_own(host, address) {
        return Err("this server does not go by that name: open it by its address");
    }
    match text(header::ORIGIN) {
        Some(origin) if origin.strip_prefix("http://") != Some(host) => {
            Err("a page from elsewhere may neither read nor steer this run")
        }
        _ => Ok(()),
    }
}

/// Whether `host` (with a port, if it is not 80) is an address of this server, or the name of this machine to
/// itself.
fn is_own(host: &str, address: SocketAddr) -> bool {
    let (name, port) = match host.rsplit_once(':') {
        // An IPv6 address without a port ends in a bracket.
        Some((name, port)) if !host.ends_with(']') => (name, port.parse().ok()),
        _ => (host, Some(80)),
    };
    if port != Some(address.port()) {
        return false;
    }
    let bare = name.trim_start_matches('[').trim_end_matches(']');
    match bare.parse::<IpAddr>() {
        // Bound to all addresses, any number may be this machine's: names are what is forged.
        Ok(ip) => ip == address.ip() || address.ip().is_unspecified(),
        Err(_) => {
            bare.eq_ignore_ascii_case("localhost")
                && (address.ip().is_loopback() || address.ip().is_unspecified())
        }
    }
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

/// What the page is told once.
#[derive(Serialize)]
struct Welcome {
    version: &'static str,
    scenes: Vec<[String; 2]>,
    paces: [f64; 2],
    kicks: [f64; 2],
    hard_kick: f64,
    sound_rate: u32,
}

async fn control(State(shared): State<Arc<Shared>>, upgrade: WebSocketUpgrade) -> Response {
    upgrade
        .max_message_size(LONGEST_COMMAND)
        .on_upgrade(move |socket| controlled(socket, shared))
}

/// A message to the page: an object with one key.
fn message(key: &str, value: &impl Serialize) -> Message {
    let value = serde_json::to_value(value).unwrap_or_default();
    let text = serde_json::json!({ key: value }).to_string();
    Message::Text(Utf8Bytes::from(text))
}

/// Talks with a control panel until it goes.
async fn controlled(mut socket: WebSocket, shared: Arc<Shared>) {
    let session = &shared.session;
    let welcome = Welcome {
        version: crate::VERSION,
        scenes: session.scenes(),
        paces: PACES,
        kicks: KICKS,
        hard_kick: HARD,
        sound_rate: crate::sound::RATE,
    };
    let mut bands = shared.bands.clone();
    let first = [
        message("welcome", &welcome),
        message("bands", &*bands.borrow_and_update()),
    ];
    for message in first {
        if socket.send(message).await.is_err() {
            return;
        }
    }
    let mut tick = tokio::time::interval(PANEL_EVERY);
    let mut told = None;
    loop {
        let answer = tokio::select! {
            asked = socket.recv() => match asked {
                Some(Ok(Message::Text(text))) => Some(carried_out(session, text.as_str()).await),
                Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                Some(Ok(_)) => None,
            },
            Ok(()) = bands.changed() => {
                Some(message("bands", &*bands.borrow_and_update()))
            }
            _ = tick.tick() => {
                let panel = session.panel();
                let changed = told.as_ref() != Some(&panel);
                let news = changed.then(|| message("panel", &panel));
                told = Some(panel);
                news
            }
        };
        if let Some(answer) = answer
            && socket.send(answer).await.is_err()
        {
            return;
        }
    }
}

/// Does what a text asks for; the answer says whether it was done.
async fn carried_out(session: &Arc<Session>, text: &str) -> Message {
    let command: Command = match serde_json::from_str(text) {
        Ok(command) => command,
        Err(fault) => return message("refused", &format!("not a command: {fault}")),
    };
    let session = Arc::clone(session);
    // Reading a scene takes a moment.
    let obeyed = tokio::task::spawn_blocking(move || session.obey(&command)).await;
    match obeyed {
        Ok(Ok(())) => message("done", &text),
        Ok(Err(refused)) => message("refused", &refused.to_string()),
        Err(fault) => message("refused", &fault.to_string()),
    }
}

async fn stream(State(shared): State<Arc<Shared>>, upgrade: WebSocketUpgrade) -> Response {
    upgrade.on_upgrade(move |socket| streamed(socket, shared))
}

/// Sends the recording to a viewer until it goes. One that takes it in too slowly misses some.
async fn streamed(mut socket: WebSocket, shared: Arc<Shared>) {
    let session = &shared.session;
    let Ticket { past, mut news } = session.hub.enter();
    let mut flow = Flow::default();
    let mut missed: HashSet<Name> = HashSet::new();
    let mut waiting: Vec<u8> = Vec::new();
    for piece in past {
        waiting.extend_from_slice(&piece);
        if waiting.len() >= MESSAGE {
            let full = std::mem::take(&mut waiting);
            if socket.send(Message::Binary(full.into())).await.is_err() {
                return;
            }
        }
    }
    loop {
        if !waiting.is_empty() {
            let full = std::mem::take(&mut waiting);
            if socket.send(Message::Binary(full.into())).await.is_err() {
                return;
            }
            flow.sent(Instant::now());
        }
        let mut take = |news: News, waiting: &mut Vec<u8>| {
            if news.begins {
                flow.begin();
            }
            if news.lasting {
                waiting.extend_from_slice(&news.bytes);
            } else if flow.is_behind(Instant::now()) {
                missed.insert(news.name);
            } else {
                // What has been left out holds on until something else is told of the same.
                if !missed.is_empty() {
                    missed.remove(&news.name);
                    for piece in session.hub.last(&std::mem::take(&mut missed)) {
                        waiting.extend_from_slice(&piece);
                    }
                }
                waiting.extend_from_slice(&news.bytes);
                flow.tells(news.until);
            }
        };
        let mut lost = false;
        tokio::select! {
            piece = news.recv() => match piece {
                Ok(piece) => take(piece, &mut waiting),
                Err(RecvError::Lagged(_)) => lost = true,
                Err(RecvError::Closed) => return,
            },
            told = socket.recv() => match told {
                Some(Ok(Message::Text(text))) => {
                    if let Ok(Seen { seen }) = serde_json::from_str(text.as_str()) {
                        flow.saw(Instant::now(), seen);
                    }
                    continue;
                }
                Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                Some(Ok(_)) => {}
            },
        };
        // What has come meanwhile goes along.
        while waiting.len() < MESSAGE && !lost {
            match news.try_recv() {
                Ok(piece) => take(piece, &mut waiting),
                Err(TryRecvError::Lagged(_)) => lost = true,
                Err(_) => break,
            }
        }
        if lost {
            return part(socket).await;
        }
    }
}

/// What a viewer says of itself.
#[derive(Deserialize)]
struct Seen {
    /// Simulated time up to which it shows the run, s.
    seen: f64,
}

async fn sound(State(shared): State<Arc<Shared>>, upgrade: WebSocketUpgrade) -> Response {
    upgrade.on_upgrade(move |socket| played(socket, shared))
}

/// What a listener hears.
#[derive(Debug, Default, Serialize)]
struct Heard {
    /// In a few words.
    what: String,
    /// How many times slower, and so lower, than life.
    slower: f32,
}

impl Heard {
    /// Whether it is worth telling again.
    fn differs_from(&self, told: &Self) -> bool {
        self.what != told.what || (self.slower - told.slower).abs() > 0.02 * told.slower
    }
}

/// Plays to a listener until it goes. One that lags misses some.
async fn played(mut socket: WebSocket, shared: Arc<Shared>) {
    let ear = &shared.session.ear;
    let mut news = ear.listen();
    let mut told = Heard::default();
    loop {
        let sound = tokio::select! {
            sound = news.recv() => match sound {
                Ok(sound) => sound,
                Err(RecvError::Lagged(_)) => continue,
                Err(RecvError::Closed) => return,
            },
            asked = socket.recv() => match asked {
                Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                Some(Ok(_)) => continue,
            },
        };
        let heard = Heard {
            what: ear.words(),
            slower: ear.slower(),
        };
        if heard.differs_from(&told) {
            if socket.send(message("heard", &heard)).await.is_err() {
                return;
            }
            told = heard;
        }
        let bytes: Vec<u8> = sound.iter().flat_map(|x| x.to_le_bytes()).collect();
        if socket.send(Message::Binary(bytes.into())).await.is_err() {
            return;
        }
    }
}

async fn part(mut socket: WebSocket) {
    let frame = CloseFrame {
        code: TOO_SLOW,
        reason: "too slow".into(),
    };
    // It may be gone already.
    let _ = socket.send(Message::Close(Some(frame))).await;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(host: Option<&str>, origin: Option<&str>) -> HeaderMap {
        let mut headers = HeaderMap::new();
        for (name, value) in [(header::HOST, host), (header::ORIGIN, origin)] {
            if let Some(value) = value {
                headers.insert(name, HeaderValue::from_str(value).unwrap());
            }
        }
        headers
    }

    #[test]
    fn only_its_own_page_is_admitted() {
        let address = "127.0.0.1:9000".parse().unwrap();
        let ask = |host: Option<&str>, origin: Option<&str>| {
            admitted(&headers(host, origin), address).is_ok()
        };
        for host in ["127.0.0.1:9000", "localhost:9000", "LOCALHOST:9000"] {
            assert!(ask(Some(host), None), "{host}");
            assert!(ask(Some(host), Some(&format!("http://{host}"))), "{host}");
        }
        for host in [
            "evil.example:9000",
            "127.0.0.1",
            "127.0.0.1:9001",
            "127.0.0.1.evil.example:9000",
            "127.0.0.2:9000",
            "localhost.:9000",
            "",
        ] {
            assert!(!ask(Some(host), None), "{host}");
        }
        assert!(!ask(None, None));
        for origin in [
            "http://evil.example",
            "https://127.0.0.1:9000",
            "http://127.0.0.1:9001",
            "http://localhost:9000",
            "null",
        ] {
            assert!(!ask(Some("127.0.0.1:9000"), Some(origin)), "{origin}");
        }
    }

    #[test]
    fn all_addresses_are_none_to_open() {
        for all in ["0.0.0.0:9000", "[::]:9000"] {
            let found = reachable(all.parse().unwrap());
            assert!(
                !found.ip().is_unspecified() && found.port() == 9000,
                "{found}"
            );
        }
        let one = "127.0.0.1:9000".parse().unwrap();
        assert_eq!(reachable(one), one);
    }

    #[test]
    fn on_all_addresses_numbers_are_admitted_and_names_are_not() {
        let address = "0.0.0.0:9000".parse().unwrap();
        assert!(is_own("192.168.1.5:9000", address));
        assert!(is_own("[::1]:9000", address));
        assert!(!is_own("evil.example:9000", address));
        let six = "[::1]:9000".parse().unwrap();
        assert!(is_own("[::1]:9000", six) && !is_own("[::1]", six));
    }
}
