//! Floods of requests neither delay the end of a run nor lock out new clients.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::Command;
use std::time::Instant;

use serde_json::json;
use tungstenite::Message;

use super::{DEADLINE, Live};

#[test]
fn a_paused_run_under_a_flood_stops_on_interrupt() {
    let mut live = Live::start("doubled-torus-3deg", &[]);
    let mut control = live.socket("/control");
    assert_eq!(control.ask(&json!({ "do": "pause" })), None);
    let paused = control.panel(|panel| panel["paused"] == true);
    let kick = json!({ "do": "kick" });
    let floods: Vec<_> = (0..4)
        .map(|_| {
            let mut flood = live.socket("/control");
            let kick = Message::text(kick.to_string());
            // The responses are not read.
            std::thread::spawn(move || while flood.0.send(kick.clone()).is_ok() {})
        })
        .collect();
    let began = Instant::now();
    while control.ask(&kick).is_none() {
        assert!(
            began.elapsed() < DEADLINE,
            "the number of kicks per frame is not limited"
        );
    }
    let flooded = live.socket("/control").panel(|_| true);
    assert_eq!(flooded["time_s"], paused["time_s"]);
    let asked = Instant::now();
    assert_eq!(live.interrupt(), Some(0));
    println!("ended {:.0} ms after", 1e3 * asked.elapsed().as_secs_f64());
    for flood in floods {
        flood.join().expect("the flood ends with the run");
    }
}

/// Incomplete requests end after some seconds: a client that comes when no file descriptors are left is then served.
#[test]
fn new_clients_are_served_without_free_descriptors() {
    let mut limited = Command::new("sh");
    let program = env!("CARGO_BIN_EXE_squeakscope");
    limited.args(["-c", "ulimit -n 24; exec \"$@\"", "sh", program]);
    let live = Live::of(limited, "mass-on-belt", &[]);
    let waiting: Vec<TcpStream> = (0..40)
        .map(|_| {
            let mut stream = TcpStream::connect(&live.host).expect("connected");
            write!(stream, "GET / HTTP/1.1\r\nHost: ").expect("sent");
            stream
        })
        .collect();
    let mut stream = TcpStream::connect(&live.host).expect("connected");
    stream.set_read_timeout(Some(DEADLINE)).expect("set");
    write!(stream, "GET / HTTP/1.1\r\nHost: {}\r\n\r\n", live.host).expect("sent");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("a response");
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    live.socket("/control")
        .panel(|panel| panel["time_s"].as_f64() > Some(0.0));
    drop(waiting);
}
