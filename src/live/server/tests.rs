//! A real server on its own port, and hand-written clients.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::stream::MaybeTlsStream;

use super::*;
use crate::live::bind;
use crate::live::session::SessionOptions;
use crate::pipeline::MAX_KICKS_PER_FRAME;
use crate::scene::Scene;
use crate::sound::Source;

/// Timeout for everything in these tests, on a busy machine too.
const DEADLINE: Duration = Duration::from_secs(90);
/// Connections of the server.
const SLOTS: usize = 6;

/// A server of a session that does not start: its commands stay pending.
struct Served {
    page: Option<Page>,
    session: Arc<Session>,
    host: String,
}

impl Served {
    fn new() -> Self {
        Self::with(Limits {
            connections: SLOTS,
            ..Limits::default()
        })
    }

    fn with(limits: Limits) -> Self {
        let session = Arc::new(Session::new(SessionOptions {
            scene: Scene::load("doubled-torus-3deg").unwrap(),
            command: "squeakscope live".to_owned(),
            speed: 0.02,
            lyapunov: true,
            viewer: None,
            computes_diagram: true,
            folder: PathBuf::from("absent"),
            save: None,
            wav: None,
            source: Source::default(),
            tour: None,
        }));
        let listener = bind(Ipv4Addr::LOCALHOST.into(), 0).unwrap();
        let host = listener.local_addr().unwrap().to_string();
        let page = Page::open(listener, Arc::clone(&session), None, limits).unwrap();
        Self {
            page: Some(page),
            session,
            host,
        }
    }

    /// A connection on which a text was sent.
    fn said(&self, words: &str) -> TcpStream {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(DEADLINE)).unwrap();
        stream.write_all(words.as_bytes()).unwrap();
        stream
    }

    /// The response to a request, in lower case.
    fn asked(&self, words: &str) -> String {
        rest(self.said(words))
    }

    /// The page as an ordinary client receives it.
    fn home(&self) -> String {
        self.asked(&request("/", &[("host", &self.host)]))
    }

    fn socket(&self, path: &str) -> tungstenite::Result<Socket> {
        let (mut socket, _) = tungstenite::connect(format!("ws://{}{path}", self.host))?;
        if let MaybeTlsStream::Plain(stream) = socket.get_mut() {
            stream.set_read_timeout(Some(DEADLINE)).unwrap();
        }
        Ok(socket)
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        if let Some(page) = self.page.take() {
            page.close().unwrap();
        }
    }
}

/// A request with the given headers.
fn request(path: &str, headers: &[(&str, &str)]) -> String {
    let mut text = format!("GET {path} HTTP/1.1\r\n");
    for (name, value) in headers {
        text += &format!("{name}: {value}\r\n");
    }
    text + "\r\n"
}

type Socket = tungstenite::WebSocket<MaybeTlsStream<TcpStream>>;

/// The remaining bytes in lower case; a reset connection counts as closed.
fn rest(mut stream: TcpStream) -> String {
    let mut answer = Vec::new();
    if let Err(fault) = stream.read_to_end(&mut answer) {
        assert_eq!(fault.kind(), std::io::ErrorKind::ConnectionReset);
    }
    String::from_utf8_lossy(&answer).to_lowercase()
}

/// The reason for the rejection of a command, or `None` if it was applied.
fn ask(socket: &mut Socket, command: &Value) -> Option<String> {
    socket
        .send(tungstenite::Message::text(command.to_string()))
        .unwrap();
    answer(socket)
}

/// The next response to a command.
fn answer(socket: &mut Socket) -> Option<String> {
    loop {
        let tungstenite::Message::Text(text) = socket.read().unwrap() else {
            continue;
        };
        let said: Value = serde_json::from_str(&text).unwrap();
        if said.get("done").is_some() {
            return None;
        }
        if let Some(why) = said["refused"].as_str() {
            return Some(why.to_owned());
        }
    }
}

const UPGRADE: [(&str, &str); 4] = [
    ("connection", "upgrade"),
    ("upgrade", "websocket"),
    ("sec-websocket-version", "13"),
    ("sec-websocket-key", "AAAAAAAAAAAAAAAAAAAAAA=="),
];

#[test]
fn every_path_rejects_requests_from_other_pages() {
    let served = Served::with(Limits::default());
    let host = ("host", served.host.as_str());
    let own = format!("http://{}", served.host);
    for path in [
        "/",
        "/page.js",
        "/favicon.ico",
        "/control",
        "/views",
        "/sound",
        "/absent",
    ] {
        let status = |more: &[(&str, &str)]| {
            let headers: Vec<_> = [host].iter().chain(&UPGRADE).chain(more).copied().collect();
            let mut stream = served.said(&request(path, &headers));
            // A web socket stays open.
            let mut answer = String::new();
            while !answer.contains("\r\n\r\n") {
                let mut byte = [0];
                stream.read_exact(&mut byte).unwrap();
                answer.push(byte[0].to_ascii_lowercase().into());
            }
            assert!(
                answer.contains("cross-origin-resource-policy: same-origin\r\n"),
                "{path}: {answer}"
            );
            answer.split(' ').nth(1).unwrap().parse::<u16>().unwrap()
        };
        for foreign in [
            &[("origin", "http://evil.example")][..],
            &[("sec-fetch-site", "cross-site")],
            &[("sec-fetch-site", "same-site"), ("origin", &own)],
        ] {
            assert_eq!(status(foreign), 403, "{path} {foreign:?}");
        }
        assert_eq!(status(&[host]), 400, "{path}: two hosts");
        for admitted in [
            &[][..],
            &[("sec-fetch-site", "none")],
            &[("sec-fetch-site", "same-origin"), ("origin", &own)],
        ] {
            let expected = match path {
                "/absent" => 404,
                "/control" | "/views" | "/sound" => 101,
                _ => 200,
            };
            assert_eq!(status(admitted), expected, "{path} {admitted:?}");
        }
    }
}

#[test]
fn only_http_1_1_of_limited_length_is_served() {
    let served = Served::new();
    let host = &served.host;
    let old = served.asked(&format!("GET / HTTP/1.0\r\nhost: {host}\r\n\r\n"));
    assert!(old.contains(" 505 "), "{old}");
    let second = served.asked("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\x04\0\0\0\0\0");
    assert!(
        !second.contains(" 200 ") && !second.contains("<html"),
        "{second}"
    );
    let long = "x".repeat(1 << 15);
    let long = served.asked(&request("/", &[("host", host), ("x", &long)]));
    assert!(!long.contains(" 200 "), "{long}");
    let fine = served.home();
    assert!(
        fine.starts_with("http/1.1 200") && fine.contains("connection: close"),
        "{fine}"
    );
}

#[test]
fn new_connections_are_served_despite_incomplete_requests() {
    let served = Served::with(Limits {
        connections: SLOTS,
        header_timeout: Duration::from_millis(50),
        ..Limits::default()
    });
    let begun = format!("GET / HTTP/1.1\r\nhost: {}\r\n", served.host);
    let slow: Vec<TcpStream> = (0..4 * SLOTS).map(|_| served.said(&begun)).collect();
    let answer = served.home();
    assert!(answer.starts_with("http/1.1 200"), "{answer}");
    for stream in slow {
        assert!(!rest(stream).contains("200"));
    }
}

#[test]
fn headers_have_a_timeout() {
    let served = Served::with(Limits {
        header_timeout: Duration::from_millis(50),
        ..Limits::default()
    });
    let answers = ["", "GET /", "GET / HTTP/1.1\r\nhost: "].map(|begun| rest(served.said(begun)));
    assert!(
        answers.iter().all(|answer| !answer.contains("200")),
        "{answers:?}"
    );
}

#[test]
fn the_number_of_connections_is_limited() {
    let served = Served::new();
    let mut open: Vec<Socket> = (0..SLOTS)
        .map(|_| served.socket("/control").unwrap())
        .collect();
    let waiting = served.said(&request("/", &[("host", &served.host)]));
    let short = Some(Duration::from_millis(100));
    waiting.set_read_timeout(short).unwrap();
    assert!(
        waiting.peek(&mut [0]).is_err(),
        "served beyond the limit of connections"
    );
    let refused = ask(
        &mut open[0],
        &json!({ "do": "set", "key": "tilt_deg", "value": 99 }),
    );
    assert!(
        refused.unwrap().contains("the tilt must be"),
        "existing connections continue"
    );
    drop(open);
    waiting.set_read_timeout(Some(DEADLINE)).unwrap();
    assert!(rest(waiting).starts_with("http/1.1 200"));
}

#[test]
fn a_flood_of_kicks_is_limited_and_every_kick_is_answered() {
    const SENT: usize = 500;
    let served = Served::new();
    let mut floods: Vec<_> = (0..4)
        .map(|_| {
            let mut socket = served.socket("/control").unwrap();
            std::thread::spawn(move || {
                let kick = json!({ "do": "kick" }).to_string();
                for _ in 0..SENT {
                    socket.write(tungstenite::Message::text(&kick)).unwrap();
                }
                socket.flush().unwrap();
                let answers = (0..SENT).filter_map(|_| answer(&mut socket));
                answers
                    .filter(|why| why.contains("at most 4 kicks"))
                    .count()
            })
        })
        .collect();
    let refused: usize = floods.drain(..).map(|flood| flood.join().unwrap()).sum();
    assert_eq!(refused, 4 * SENT - MAX_KICKS_PER_FRAME);
    // Other clients are not affected.
    let mut other = served.socket("/control").unwrap();
    assert_eq!(
        ask(
            &mut other,
            &json!({ "do": "set", "key": "tilt_deg", "value": 4 })
        ),
        None
    );
}

#[test]
fn unknown_fields_of_a_command_are_rejected() {
    let served = Served::new();
    let mut socket = served.socket("/control").unwrap();
    for command in [
        "pause",
        "resume",
        "step",
        "reset",
        "record",
        "stop-recording",
        "kick",
    ] {
        let refused = ask(&mut socket, &json!({ "do": command, "file": "x" }));
        assert!(
            refused.unwrap().contains("unknown field `file`"),
            "{command}"
        );
    }
}

#[test]
fn a_client_that_never_reads_is_disconnected() {
    let served = Served::with(Limits {
        message_timeout: Duration::from_millis(50),
        ..Limits::default()
    });
    let upgrade = [("host", served.host.as_str())].into_iter().chain(UPGRADE);
    let mut silent = served.said(&request("/control", &upgrade.collect::<Vec<_>>()));
    let began = std::time::Instant::now();
    // Each is repeated in its answer: soon more than the buffers of the system hold.
    let mut frame = vec![0x81, 0x80 | 126, 0x0f, 0xa0, 0, 0, 0, 0];
    frame.extend(format!("{:4000}", r#"{ "do": "pause" }"#).bytes());
    // After the server has closed the connection, writing fails.
    while silent.write_all(&frame).is_ok() {
        assert!(began.elapsed() < DEADLINE, "the connection is still open");
    }
}

#[test]
fn a_client_that_does_not_answer_pings_is_disconnected() {
    let served = Served::with(Limits {
        ping_after: Duration::from_millis(20),
        ..Limits::default()
    });
    for path in ["/control", "/views", "/sound"] {
        let upgrade = [("host", served.host.as_str())].into_iter().chain(UPGRADE);
        let silent = served.said(&request(path, &upgrade.collect::<Vec<_>>()));
        assert!(rest(silent).starts_with("http/1.1 101"), "{path}");
    }
}

#[test]
fn the_unspecified_address_is_replaced() {
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
fn the_diagram_of_the_scene_is_served_during_its_run() {
    let served = Served::new();
    let diagram = request("/diagram.json", &[("host", &served.host)]);
    let missing = served.asked(&diagram);
    assert!(missing.starts_with("http/1.1 204"), "{missing}");
    assert!(missing.ends_with("\r\n\r\n"), "{missing}");
    let session = Arc::clone(&served.session);
    let runner = std::thread::spawn(move || session.run().map(drop));
    let began = std::time::Instant::now();
    let answer = loop {
        let answer = served.asked(&diagram);
        if answer.starts_with("http/1.1 200") {
            break answer;
        }
        assert!(began.elapsed() < DEADLINE, "{answer}");
    };
    served.session.end();
    runner.join().unwrap().unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    assert!(head.contains("content-type: application/json"), "{head}");
    let body: Value = serde_json::from_str(body).unwrap();
    assert!(!body["bifurcations"].as_array().unwrap().is_empty());
}
