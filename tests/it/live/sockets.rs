//! The protocol of the page's server.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use serde_json::json;
use squeakscope::record::{paths, read_series};
use tungstenite::Message;
use tungstenite::client::IntoClientRequest;

use super::views::header;
use super::{DEADLINE, Live, Socket, tilt};

fn is(expected: f64) -> impl Fn(f64) -> bool {
    move |value| (value - expected).abs() < 1e-9
}

/// A client of `/views` that draws at once.
struct Views {
    socket: Socket,
    drawn: u64,
}

impl Views {
    fn of(live: &Live) -> Self {
        let socket = live.socket("/views");
        Self { socket, drawn: 0 }
    }

    /// Waits for data at a tilt, degrees.
    fn until_tilt(&mut self, deg: f64) {
        let began = Instant::now();
        loop {
            assert!(began.elapsed() < DEADLINE, "no data at {deg} degrees");
            let (data, _) = header(&mut self.socket);
            self.drawn += 1;
            self.socket.send(&json!({ "drawn": self.drawn }));
            if data["tilt_deg"].as_f64().is_some_and(is(deg)) {
                return;
            }
        }
    }
}

#[test]
fn a_tilt_command_changes_the_tilt_in_the_views() {
    let mut live = Live::start("doubled-torus-3deg", &[]);
    let (mut control, mut views) = (live.socket("/control"), Views::of(&live));
    views.until_tilt(3.0);
    assert_eq!(control.ask(&tilt(4.5)), None);
    views.until_tilt(4.5);
    let panel = control.panel(|panel| panel["tilt_deg"] == 4.5);
    let events = panel["events"].as_array().unwrap();
    assert!(events.iter().any(|event| event["text"] == "tilt 4.5 deg"));
    assert_eq!(live.interrupt(), Some(0));
}

#[test]
fn a_pause_stops_simulated_time_and_a_step_is_one_frame() {
    let live = Live::start("doubled-torus-3deg", &[]);
    let mut control = live.socket("/control");
    control.panel(|panel| panel["time_s"].as_f64() > Some(0.0));
    assert_eq!(control.ask(&json!({ "do": "pause" })), None);
    let stopped = control.panel(|panel| panel["paused"] == true);
    std::thread::sleep(Duration::from_millis(300));
    control.send(&json!({ "do": "pause" }));
    let time = |panel: &serde_json::Value| panel["time_s"].as_f64().unwrap();
    // Messages sent before the pause have arrived by now.
    let mut late = live.socket("/control");
    let resting = late.panel(|_| true);
    assert!(time(&resting) - time(&stopped) < 2e-3);
    assert_eq!(late.ask(&json!({ "do": "step" })), None);
    let stepped = late.panel(|panel| time(panel) > time(&resting));
    assert!(time(&stepped) - time(&resting) < 1e-3, "1/60 of 20 ms");
    assert_eq!(stepped["paused"], true);
}

#[test]
fn invalid_commands_are_rejected() {
    let live = Live::start("doubled-torus-3deg", &[]);
    let mut control = live.socket("/control");
    for (command, part) in [
        (tilt(10.01), "the tilt must be between 0 and 10 deg"),
        (tilt(-0.01), "the tilt must be"),
        (
            json!({ "do": "speed", "ms_per_s": 1001 }),
            "the playback speed must be",
        ),
        (
            json!({ "do": "speed", "ms_per_s": 0 }),
            "the playback speed must be",
        ),
        (json!({ "do": "kick", "mm_per_s": 1e9 }), "a kick must be"),
        (
            json!({ "do": "scene", "name": "/etc/passwd" }),
            "unknown scene",
        ),
        (json!({ "do": "set" }), "invalid command"),
        (json!({ "do": "fly" }), "invalid command"),
        (
            json!({ "do": "set", "key": "tilt_deg", "value": 3, "really": true }),
            "invalid command",
        ),
        (json!("tilt"), "invalid command"),
    ] {
        let why = control.ask(&command).expect("rejected");
        assert!(why.contains(part), "{command}: {why}");
    }
    let panel = control.panel(|panel| panel["time_s"].as_f64() > Some(0.0));
    assert!(is(3.0)(panel["tilt_deg"].as_f64().unwrap()), "{panel:#}");
    assert_eq!(panel["speed"], 0.02);
}

/// The status line of the response to a request.
fn asked(host: &str, path: &str, headers: &[(&str, &str)]) -> String {
    let mut stream = TcpStream::connect(host).unwrap();
    stream.set_read_timeout(Some(DEADLINE)).unwrap();
    let headers: String = headers
        .iter()
        .map(|(name, value)| format!("{name}: {value}\r\n"))
        .collect();
    write!(
        stream,
        "GET {path} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n"
    )
    .unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    String::from_utf8_lossy(&answer).into_owned()
}

#[test]
fn requests_for_other_hosts_or_from_other_pages_are_rejected() {
    let live = Live::start("mass-on-belt", &[]);
    let host = live.host.as_str();
    let own = asked(host, "/", &[("Host", host)]);
    assert!(own.starts_with("HTTP/1.1 200"), "{own}");
    for header in ["content-security-policy: default-src 'self'", "nosniff"] {
        assert!(own.to_lowercase().contains(header), "{own}");
    }
    let upgrade = [
        ("Connection", "Upgrade"),
        ("Upgrade", "websocket"),
        ("Sec-WebSocket-Version", "13"),
        ("Sec-WebSocket-Key", "AAAAAAAAAAAAAAAAAAAAAA=="),
    ];
    for path in ["/", "/page.js", "/control", "/views", "/sound"] {
        for foreign in [
            [("Host", "evil.example"), ("Accept", "*/*")],
            [("Host", host), ("Origin", "http://evil.example")],
            [("Host", host), ("Origin", "null")],
        ] {
            let headers: Vec<_> = foreign.into_iter().chain(upgrade).collect();
            let answer = asked(host, path, &headers);
            assert!(
                answer.starts_with("HTTP/1.1 403"),
                "{path} {foreign:?}: {answer}"
            );
        }
    }
    // A request without an origin does not come from a page; one with the own origin comes from the page
    // itself.
    for origin in [None, Some(format!("http://{host}"))] {
        let mut request = format!("ws://{host}/control")
            .into_client_request()
            .unwrap();
        if let Some(origin) = &origin {
            request
                .headers_mut()
                .insert("Origin", origin.parse().unwrap());
        }
        assert!(tungstenite::connect(request).is_ok(), "{origin:?}");
    }
    assert!(asked(host, "/../Cargo.toml", &[("Host", host)]).starts_with("HTTP/1.1 404"));
}

/// Clients that do not read, that disconnect and that connect late: none affects the run.
#[test]
fn no_client_delays_the_run() {
    let live = Live::start("doubled-torus-3deg", &["--speed", "200"]);
    let mut control = live.socket("/control");
    let silent: Vec<Socket> = (0..8).map(|_| live.socket("/views")).collect();
    for _ in 0..8 {
        drop(live.socket("/views"));
    }
    let time = |panel: &serde_json::Value| panel["time_s"].as_f64().unwrap();
    let begun = time(&control.panel(|panel| time(panel) > 0.0));
    control.panel(|panel| time(panel) > begun + 0.3);
    let mut late = Views::of(&live);
    late.until_tilt(3.0);
    let mut second = live.socket("/control");
    assert_eq!(second.ask(&tilt(2.0)), None);
    let seen = control.panel(|panel| panel["tilt_deg"] == 2.0);
    assert!(seen["watching"].as_u64().unwrap() >= 9, "{seen:#}");
    late.until_tilt(2.0);
    drop(silent);
}

#[test]
fn audio_arrives_and_is_not_silent() {
    let live = Live::start("doubled-torus-3deg", &["--speed", "100"]);
    let mut sound = live.socket("/sound");
    let (mut samples, mut loud, mut time_stretch) = (0, 0.0_f32, None);
    let began = Instant::now();
    // After the first 40 ms the squeak has its full amplitude. Where the machine stalls, the sound is silent for a while.
    while samples < 48_000 || loud <= 0.5 {
        assert!(began.elapsed() < DEADLINE, "{samples} samples, {loud}");
        match sound.next() {
            Message::Binary(piece) => {
                assert_eq!(piece.len() % 4, 0);
                for bytes in piece.as_chunks().0 {
                    let x = f32::from_le_bytes(*bytes);
                    assert!(x.abs() <= 1.0, "{x}");
                    loud = loud.max(x.abs());
                }
                samples += piece.len() / 4;
            }
            Message::Text(text) => {
                let message: serde_json::Value = serde_json::from_str(&text).unwrap();
                time_stretch = message["audio"]["time_stretch"].as_f64();
                assert_eq!(message["audio"]["what"], "velocity of the contact centre");
            }
            _ => {}
        }
    }
    // A factor of ten, or more on a machine that does not keep up.
    assert!(time_stretch.expect("received") > 9.0, "{time_stretch:?}");
}

#[test]
fn the_wav_file_of_a_live_run_is_written_at_the_end() {
    let mut live = Live::start(
        "doubled-torus-3deg",
        &["--speed", "200", "--wav", "squeak.wav"],
    );
    let wav = live.folder().join("squeak.wav");
    let mut control = live.socket("/control");
    control.panel(|panel| panel["time_s"].as_f64() > Some(0.05));
    assert!(!wav.exists(), "the file gets its name at the end");
    assert_eq!(live.interrupt(), Some(0));
    let sound = hound::WavReader::open(&wav).expect("a WAV file");
    assert!(sound.duration() > 2400, "{}", sound.duration());
}

#[test]
fn a_recording_contains_its_events() {
    let live = Live::start("doubled-torus-3deg", &[]);
    let mut control = live.socket("/control");
    control.panel(|panel| panel["time_s"].as_f64() > Some(0.0));
    assert_eq!(control.ask(&json!({ "do": "record" })), None);
    control.panel(|panel| panel["recording"].is_string());
    assert_eq!(control.ask(&tilt(5.0)), None);
    control.panel(|panel| panel["tilt_deg"] == 5.0);
    assert_eq!(control.ask(&json!({ "do": "stop-recording" })), None);
    control.panel(|panel| panel["recording"].is_null());
    let file = live.folder().join("live-1.rrd");
    let tilts = read_series(&file, Some(paths::TILT)).unwrap().values;
    assert!(
        is(3.0)(tilts[0]) && is(5.0)(tilts[tilts.len() - 1]),
        "{tilts:?}"
    );
}

/// The prediction made before the run must not be presented as that of another tilt.
#[test]
fn a_lesson_states_that_the_tilt_has_changed() {
    let live = Live::start("mode-shift-3.5deg", &["--speed", "200"]);
    let mut control = live.socket("/control");
    let says = |panel: &serde_json::Value, words: &str| {
        let lesson = panel["lesson"].as_str();
        lesson.is_some_and(|lesson| lesson.contains(words))
    };
    let first = control.panel(|panel| says(panel, "predicted"));
    assert!(!says(&first, "tilted by"), "{first}");
    assert_eq!(control.ask(&tilt(5.0)), None);
    control.panel(|panel| says(panel, "now tilted by **5.0°**; the lesson is for 3.5°"));
}

/// A recording is complete without resuming a paused run.
#[test]
fn a_recording_can_be_stopped_while_paused() {
    let live = Live::start("doubled-torus-3deg", &[]);
    let mut control = live.socket("/control");
    assert_eq!(control.ask(&json!({ "do": "record" })), None);
    control.panel(|panel| panel["time_s"].as_f64() > Some(0.002));
    assert_eq!(control.ask(&json!({ "do": "pause" })), None);
    control.panel(|panel| panel["paused"] == true);
    assert_eq!(control.ask(&json!({ "do": "stop-recording" })), None);
    control.panel(|panel| panel["recording"].is_null());
    let file = live.folder().join("live-1.rrd");
    let times = read_series(&file, Some(paths::DISPLACEMENT)).unwrap().times;
    assert!(times.len() > 100, "{}", times.len());
    // Another recording can start, and contains the static data.
    assert_eq!(control.ask(&json!({ "do": "record" })), None);
    control.panel(|panel| panel["recording"].is_string());
    assert_eq!(control.ask(&json!({ "do": "step" })), None);
    assert_eq!(control.ask(&json!({ "do": "stop-recording" })), None);
    control.panel(|panel| panel["recording"].is_null());
    assert!(live.folder().join("live-2.rrd").exists());
}

#[test]
fn configuration_errors_are_reported_before_any_work() {
    let live = Live::start("mass-on-belt", &[]);
    let port = live.host.rsplit_once(':').unwrap().1;
    for (more, code, part) in [
        (vec!["--port", port], 1, "choose another --port"),
        (
            vec!["--speed", "5000"],
            2,
            "--speed 5000 is out of range; give 0.01 to 1000",
        ),
        (vec!["--record-dir", "absent/folder"], 2, "--record-dir"),
        (vec!["--spawn", "--connect"], 2, "cannot be used with"),
    ] {
        let ended = std::process::Command::new(env!("CARGO_BIN_EXE_squeakscope"))
            .args(["live", "mass-on-belt"])
            .args(&more)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(code), "{more:?}: {said}");
        assert!(said.contains(part), "{more:?}: {said}");
    }
}

/// Latency from the slider to changed data of the views, at the default playback speed.
#[test]
#[ignore = "a measurement: cargo test --release --test it live::sockets::latency -- --ignored --nocapture"]
fn latency() {
    let live = Live::start("doubled-torus-3deg", &[]);
    let (mut control, mut views) = (live.socket("/control"), Views::of(&live));
    views.until_tilt(3.0);
    let mut took: Vec<f64> = (0..40)
        .map(|k| {
            let deg = 2.0 + 0.05 * f64::from(k);
            let asked = Instant::now();
            control.send(&tilt(deg));
            views.until_tilt(deg);
            1e3 * asked.elapsed().as_secs_f64()
        })
        .collect();
    took.sort_by(f64::total_cmp);
    println!(
        "median {:.0} ms, maximum {:.0} ms",
        took[took.len() / 2],
        took[took.len() - 1]
    );
}

/// Texts of a scene file are escaped on the page and cannot change the display of other text.
#[test]
fn the_texts_of_a_scene_are_escaped() {
    const NAME: &str = "a\u{1b}[2J\u{9b}1m\u{202e}b\u{2066}\n<img src=x>c";
    const SHOWN: &str = "a\\u001b[2J\\u009b1m\\u202eb\\u2066\\n<img src=x>c";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("evil.toml");
    let text = squeakscope::scene::preset("impact-oscillator")
        .unwrap()
        .text;
    // The name, title and description come first, and then the tables.
    let body = &text[text.find("\n[").unwrap()..];
    let texts = ["title", "about"].map(|key| format!("{key} = {}\n", json!(NAME)));
    std::fs::write(&path, texts.concat() + body).unwrap();
    let live = Live::start(path.to_str().unwrap(), &[]);
    let mut control = live.socket("/control");
    let welcome = control.value_of("welcome");
    assert_eq!(welcome["scenes"][0], json!(["evil", SHOWN]));
    let panel = control.panel(|panel| panel["scene"] == "evil");
    assert_eq!(panel["title"], SHOWN);
    // The description may have lines.
    assert_eq!(panel["about"], SHOWN.replace("\\n", "\n"));
}
