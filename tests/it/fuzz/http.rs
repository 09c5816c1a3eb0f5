//! Malformed requests: the server of a live run responds or closes the connection, and serves the next
//! request.

use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::Instant;

use super::targets::Kind;
use super::{Counts, Search, in_turn, keep};
use crate::live::{DEADLINE, Live};

/// Number of mutants in the standard tests.
const USUAL: u64 = 1500;

/// Number of mutants between two valid requests that must be served.
const BETWEEN: u64 = 200;

/// Start of every response.
const ANSWER: &[u8] = b"HTTP/1.";

pub fn search(search: Search) -> Counts {
    let live = Live::start("mass-on-belt", &[]);
    let originals = requests(&live.host);
    let (began, mut counts) = (Instant::now(), Counts::default());
    for mutant in in_turn(&originals, Kind::Text, search.seed) {
        if search.is_finished(began, counts.all(), USUAL) {
            break;
        }
        match answer(&live.host, &mutant.bytes) {
            Ok(true) => counts.read += 1,
            Ok(false) => counts.refused += 1,
            Err(why) => {
                let kept = keep("HTTP", "txt", &mutant.bytes);
                let kept = kept.display();
                panic!("HTTP: {why}: {}: the input is in {kept}", mutant.damage);
            }
        }
        if counts.all().is_multiple_of(BETWEEN) {
            serves(&live.host);
        }
    }
    serves(&live.host);
    let mut control = live.socket("/control");
    control.panel(|panel| panel["time_s"].as_f64() > Some(0.0));
    counts
}

/// Requests of the page, one of them with a message to a web socket.
fn requests(host: &str) -> Vec<Vec<u8>> {
    let get = |path: &str, more: &str| {
        let request = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n");
        request.into_bytes()
    };
    let upgrade = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
        Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
    let browser = format!("Origin: http://{host}\r\nSec-Fetch-Site: same-origin\r\n");
    let post = format!(
        "POST / HTTP/1.1\r\nHost: {host}\r\nTransfer-Encoding: chunked\r\n\r\n4\r\nkick\r\n0\r\n\r\n"
    );
    let mut with_command = get("/control", upgrade);
    with_command.extend(frame(br#"{"do": "kick", "mm_per_s": 1}"#));
    vec![
        get("/", &browser),
        get("/favicon.ico", "Accept: */*\r\nContent-Length: 0\r\n"),
        get("/views", upgrade),
        post.into_bytes(),
        with_command,
    ]
}

/// A text message of a client, under 126 bytes, masked with zeros.
fn frame(text: &[u8]) -> Vec<u8> {
    let mut frame = vec![0x81, 0x80 | text.len() as u8, 0, 0, 0, 0];
    frame.extend(text);
    frame
}

/// Whether there is a response; an error if the connection stays open without one.
fn answer(host: &str, request: &[u8]) -> Result<bool, String> {
    let mut stream = TcpStream::connect(host).map_err(|error| error.to_string())?;
    stream.set_read_timeout(Some(DEADLINE)).expect("set");
    stream.set_write_timeout(Some(DEADLINE)).expect("set");
    // The server may respond before it has read everything.
    let sent = stream.write_all(request);
    let is_complete = request
        .trim_ascii_start()
        .windows(4)
        .any(|end| end == b"\r\n\r\n");
    if sent.is_ok() && !is_complete {
        // The server waits for the rest of an incomplete request.
        let _ = stream.shutdown(Shutdown::Write);
    }
    let mut start = Vec::new();
    match stream.take(ANSWER.len() as u64).read_to_end(&mut start) {
        Err(error) if [ErrorKind::WouldBlock, ErrorKind::TimedOut].contains(&error.kind()) => {
            Err("no answer, and the connection stays open".to_owned())
        }
        // Closed, with or without a response.
        _ if start.is_empty() => Ok(false),
        _ if start == ANSWER => Ok(true),
        _ => Err(format!("it answers {:?}", String::from_utf8_lossy(&start))),
    }
}

/// Waits until a valid request is served; closed connections may count for a moment.
fn serves(host: &str) {
    let request = format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n");
    let began = Instant::now();
    while status(host, &request).as_deref() != Some("200") {
        assert!(began.elapsed() < DEADLINE, "a valid request is not served");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
}

/// Status line of the response to a request.
fn status(host: &str, request: &str) -> Option<String> {
    let mut stream = TcpStream::connect(host).ok()?;
    stream.set_read_timeout(Some(DEADLINE)).expect("set");
    stream.write_all(request.as_bytes()).ok()?;
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).ok()?;
    let answer = String::from_utf8_lossy(&answer);
    answer.split(' ').nth(1).map(str::to_owned)
}
