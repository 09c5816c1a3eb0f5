//! Interactive runs, controlled through the sockets of their page and through the page in a real browser.

mod browser;
mod clip;
mod contradictions;
mod files;
mod firefox;
mod floods;
mod hall;
mod keyboard;
mod leaks;
mod lecture;
mod page;
mod recording;
// Reads the resources of a process from /proc on Linux.
#[cfg(target_os = "linux")]
mod soak;
mod sockets;
mod views;

use std::io::{BufRead, BufReader, Read};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// Timeout for everything in these tests, on a busy machine too.
pub const DEADLINE: Duration = Duration::from_secs(90);

/// A live run with its page, stopped at the end of its test.
pub struct Live {
    child: Child,
    /// Address of the page, such as `127.0.0.1:40123`.
    pub host: String,
    /// Query of the printed address, with the key of the presenter; empty for a page of this machine only.
    pub query: String,
    folder: tempfile::TempDir,
}

impl Live {
    pub fn start(scene: &str, more: &[&str]) -> Self {
        Self::start_by(&[], scene, more)
    }

    /// Starts the run through a launcher that replaces itself by the program.
    fn start_by(launcher: &[&str], scene: &str, more: &[&str]) -> Self {
        let words = launcher.iter().copied();
        let mut words = words.chain([env!("CARGO_BIN_EXE_squeakscope")]);
        let mut program = Command::new(words.next().expect("a program"));
        program.args(words);
        Self::of(program, scene, more)
    }

    /// Starts the run with a command and additional arguments.
    fn of(mut program: Command, scene: &str, more: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        let mut child = program
            .current_dir(folder.path())
            .args(["live", scene, "--port", "0", "--no-browser"])
            .args(more)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("started");
        let mut line = String::new();
        let stdout = child.stdout.as_mut().expect("piped");
        BufReader::new(stdout).read_line(&mut line).expect("a line");
        let host = line.trim().strip_prefix("live page: http://");
        let host = host.unwrap_or_else(|| panic!("no address in `{line}`"));
        let (host, query) = host.split_once('/').expect("a path");
        Self {
            host: host.to_owned(),
            query: query.to_owned(),
            child,
            folder,
        }
    }

    fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub fn socket(&self, path: &str) -> Socket {
        Socket::open(&self.host, path)
    }

    /// Stops the run as Ctrl-C does. Returns the exit code, the standard output and the standard error.
    fn end(mut self) -> (Option<i32>, String, String) {
        let code = self.interrupt();
        let text = |stream: Option<&mut dyn Read>| {
            let mut text = String::new();
            stream
                .expect("piped")
                .read_to_string(&mut text)
                .expect("text");
            text
        };
        let stdout = text(self.child.stdout.as_mut().map(|stream| stream as _));
        let stderr = text(self.child.stderr.as_mut().map(|stream| stream as _));
        (code, stdout, stderr)
    }

    /// Stops the run as Ctrl-C does. Returns the exit code.
    fn interrupt(&mut self) -> Option<i32> {
        interrupted(&mut self.child)
    }
}

/// Stops a program as Ctrl-C does. Returns the exit code.
fn interrupted(child: &mut Child) -> Option<i32> {
    let id = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &id]).status();
    assert!(sent.expect("kill").success());
    let began = Instant::now();
    loop {
        if let Some(status) = child.try_wait().expect("status") {
            return status.code();
        }
        assert!(began.elapsed() < DEADLINE, "the program hangs");
        std::thread::sleep(Duration::from_millis(5));
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A web socket to the page's server.
pub struct Socket(WebSocket<MaybeTlsStream<TcpStream>>);

impl Socket {
    fn open(host: &str, path: &str) -> Self {
        let (mut socket, _) =
            tungstenite::connect(format!("ws://{host}{path}")).expect("connected");
        set_read_timeout(&mut socket, DEADLINE);
        Self(socket)
    }

    fn send(&mut self, value: &Value) {
        let text = Message::text(value.to_string());
        self.0.send(text).expect("sent");
    }

    /// The next message.
    fn next(&mut self) -> Message {
        self.0.read().expect("a message in time")
    }

    /// The value of the next message with this key.
    fn value_of(&mut self, key: &str) -> Value {
        let began = Instant::now();
        loop {
            assert!(began.elapsed() < DEADLINE, "no message with `{key}`");
            let Message::Text(text) = self.next() else {
                continue;
            };
            let mut object: Value = serde_json::from_str(&text).expect("JSON");
            if let Some(value) = object.get_mut(key) {
                return value.take();
            }
        }
    }

    /// The next panel that fulfils a condition.
    pub fn panel(&mut self, holds: impl Fn(&Value) -> bool) -> Value {
        let began = Instant::now();
        loop {
            let panel = self.value_of("panel");
            if holds(&panel) {
                return panel;
            }
            assert!(began.elapsed() < DEADLINE, "{panel:#}");
        }
    }

    /// Sends a command. Returns `None` if it was applied, else the reason for its rejection.
    fn ask(&mut self, command: &Value) -> Option<String> {
        self.send(command);
        let began = Instant::now();
        loop {
            assert!(began.elapsed() < DEADLINE, "no response to {command}");
            let Message::Text(text) = self.next() else {
                continue;
            };
            let object: Value = serde_json::from_str(&text).expect("JSON");
            if object.get("done").is_some() {
                return None;
            }
            if let Some(why) = object.get("refused") {
                return Some(why.as_str().expect("text").to_owned());
            }
        }
    }
}

fn set_read_timeout(socket: &mut WebSocket<MaybeTlsStream<TcpStream>>, timeout: Duration) {
    if let MaybeTlsStream::Plain(stream) = socket.get_mut() {
        stream.set_read_timeout(Some(timeout)).expect("set");
    }
}

fn tilt(deg: f64) -> Value {
    json!({ "do": "set", "key": "tilt_deg", "value": deg })
}
