//! A run that is steered while it goes on: through the sockets of its page, and through the page itself in a
//! real browser.

mod browser;
mod files;
mod floods;
mod leaks;
mod page;
// What a process takes is read from where Linux keeps it.
#[cfg(target_os = "linux")]
mod soak;
mod sockets;

use std::io::{BufRead, BufReader, Read};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// Long after anything here should have happened, on a busy machine too.
pub const DEADLINE: Duration = Duration::from_secs(90);

/// A live run with its page, which does not outlive its test.
pub struct Live {
    child: Child,
    /// Where the page is, such as `127.0.0.1:40123`.
    pub host: String,
    folder: tempfile::TempDir,
}

impl Live {
    pub fn start(scene: &str, more: &[&str]) -> Self {
        Self::start_by(&[], scene, more)
    }

    /// Started by another program, which becomes it.
    fn start_by(launcher: &[&str], scene: &str, more: &[&str]) -> Self {
        let words = launcher.iter().copied();
        let mut words = words.chain([env!("CARGO_BIN_EXE_squeakscope")]);
        let mut program = Command::new(words.next().expect("a program"));
        program.args(words);
        Self::of(program, scene, more)
    }

    /// Started by a command that the arguments are added to.
    fn of(mut program: Command, scene: &str, more: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        let mut child = program
            .current_dir(folder.path())
            .args(["live", scene, "--serve", "--port", "0", "--no-keys"])
            .args(more)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("started");
        let mut line = String::new();
        let stdout = child.stdout.as_mut().expect("piped");
        BufReader::new(stdout).read_line(&mut line).expect("a line");
        let host = line.trim().strip_prefix("the page: http://");
        let host = host.unwrap_or_else(|| panic!("no address in `{line}`"));
        Self {
            host: host.trim_end_matches('/').to_owned(),
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

    /// Ends it as Ctrl-C does; the exit code, and what it said on the standard output and error.
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

    /// Ends it as Ctrl-C does; the exit code.
    fn interrupt(&mut self) -> Option<i32> {
        let id = self.child.id().to_string();
        let sent = Command::new("kill").args(["-INT", &id]).status();
        assert!(sent.expect("kill").success());
        let began = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("status") {
                return status.code();
            }
            assert!(began.elapsed() < DEADLINE, "it hangs");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        // It may have ended by itself.
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
        patient(&mut socket);
        Self(socket)
    }

    fn tell(&mut self, value: &Value) {
        let text = Message::text(value.to_string());
        self.0.send(text).expect("sent");
    }

    /// What comes next.
    fn next(&mut self) -> Message {
        self.0.read().expect("a message in time")
    }

    /// The next object with this key, and what is under it.
    fn hear(&mut self, key: &str) -> Value {
        let began = Instant::now();
        loop {
            assert!(began.elapsed() < DEADLINE, "no `{key}`");
            let Message::Text(text) = self.next() else {
                continue;
            };
            let mut object: Value = serde_json::from_str(&text).expect("JSON");
            if let Some(value) = object.get_mut(key) {
                return value.take();
            }
        }
    }

    /// The next panel of which something holds.
    pub fn panel(&mut self, holds: impl Fn(&Value) -> bool) -> Value {
        let began = Instant::now();
        loop {
            let panel = self.hear("panel");
            if holds(&panel) {
                return panel;
            }
            assert!(began.elapsed() < DEADLINE, "{panel:#}");
        }
    }

    /// Asks for something, and gives the answer: nothing if it was done, else why not.
    fn ask(&mut self, command: &Value) -> Option<String> {
        self.tell(command);
        let began = Instant::now();
        loop {
            assert!(began.elapsed() < DEADLINE, "no answer to {command}");
            let Message::Text(text) = self.next() else {
                continue;
            };
            let object: Value = serde_json::from_str(&text).expect("JSON");
            if object.get("done").is_some() {
                return None;
            }
            if let Some(why) = object.get("refused") {
                return Some(why.as_str().expect("words").to_owned());
            }
        }
    }
}

/// Nothing that is waited for takes longer.
fn patient(socket: &mut WebSocket<MaybeTlsStream<TcpStream>>) {
    if let MaybeTlsStream::Plain(stream) = socket.get_mut() {
        stream.set_read_timeout(Some(DEADLINE)).expect("set");
    }
}

fn tilt(deg: f64) -> Value {
    json!({ "do": "tilt", "deg": deg })
}
