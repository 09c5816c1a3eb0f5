//! `squeakscope view`: a recording in the browser.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use super::browser::{Browser, chromium};
use super::{DEADLINE, interrupted};

/// A server of a recording, stopped at the end of its test.
struct Viewed {
    child: Child,
    host: String,
}

impl Viewed {
    fn start(recording: &Path) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_squeakscope"))
            .arg("view")
            .arg(recording)
            .arg("--no-browser")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("started");
        let mut line = String::new();
        let stdout = child.stdout.as_mut().expect("piped");
        BufReader::new(stdout).read_line(&mut line).expect("a line");
        let (_, rest) = line.split_once("http://").expect("an address");
        let (host, _) = rest.split_once('/').expect("a path");
        Self {
            host: host.to_owned(),
            child,
        }
    }

    /// Status and body of the response to a request for a host.
    fn asked(&self, path: &str, host: &str) -> (u16, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.host).expect("connected");
        stream.set_read_timeout(Some(DEADLINE)).expect("set");
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").expect("sent");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("a response");
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n");
        let body = answer.split_off(end.expect("headers") + 4);
        let head = String::from_utf8(answer).expect("text");
        let status = head.split(' ').nth(1).expect("a status");
        (status.parse().expect("a number"), body)
    }
}

impl Drop for Viewed {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A folder with a short recording `run.rrd`.
fn recorded(scene: &str, duration: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("temporary folder");
    let ran = Command::new(env!("CARGO_BIN_EXE_squeakscope"))
        .current_dir(folder.path())
        .args(["run", scene, "--duration", duration, "--save", "run.rrd"])
        .output()
        .expect("started");
    assert!(ran.status.success(), "{ran:?}");
    let said = String::from_utf8_lossy(&ran.stdout);
    let last = said.lines().last().expect("a line");
    assert!(
        last.starts_with("open with: squeakscope view ") && last.contains("rerun-sdk==0.36.3"),
        "{last}"
    );
    folder
}

#[test]
fn a_recording_is_served_to_this_machine_only() {
    let folder = recorded("mass-on-belt", "200");
    let recording = folder.path().join("run.rrd");
    let mut viewed = Viewed::start(&recording);
    let host = viewed.host.clone();
    assert!(host.starts_with("127.0.0.1:"), "{host}");
    let (status, page) = viewed.asked("/", &host);
    let page = String::from_utf8(page).expect("text");
    assert!(status == 200 && page.contains("/viewer.js"), "{page}");
    let (status, bytes) = viewed.asked("/recording.rrd", &host);
    assert_eq!(status, 200);
    assert!(bytes == std::fs::read(&recording).expect("readable"));
    let (status, viewer) = viewed.asked("/viewer.wasm", &host);
    assert!(status == 200 && viewer.starts_with(b"\0asm"));
    for path in ["/", "/recording.rrd", "/viewer.wasm"] {
        assert_eq!(viewed.asked(path, "evil.example").0, 403, "{path}");
    }
    assert_eq!(viewed.asked("/run.rrd", &host).0, 404);
    assert_eq!(interrupted(&mut viewed.child), Some(0));
}

#[test]
fn a_file_that_is_no_recording_is_refused() {
    let folder = tempfile::tempdir().expect("temporary folder");
    std::fs::write(folder.path().join("text.rrd"), "no recording").expect("written");
    for (file, words) in [
        ("absent.rrd", "cannot open the recording"),
        ("text.rrd", "is not a recording"),
        (".", "cannot open the recording"),
    ] {
        let ended = Command::new(env!("CARGO_BIN_EXE_squeakscope"))
            .current_dir(folder.path())
            .args(["view", file])
            .output()
            .expect("started");
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "{said}");
        assert!(said.contains(words) && said.lines().count() == 1, "{said}");
    }
}

/// `SQUEAKSCOPE_SCREENSHOTS` names a folder for a picture of the viewer.
#[test]
fn the_viewer_shows_the_recording() {
    let Some(program) = chromium() else {
        eprintln!("skipped: no Chromium (apt-get install chromium, or set SQUEAKSCOPE_CHROMIUM)");
        return;
    };
    let folder = recorded("doubled-torus-3deg", "60");
    let viewed = Viewed::start(&folder.path().join("run.rrd"));
    let mut browser = Browser::start(&program);
    let tab = browser.open(&format!("http://{}/", viewed.host));
    // The end of the recording, ns of simulated time.
    let end = "(() => { const id = window.handle?.get_active_recording_id(); \
         return id && handle.get_timeline_time_range(id, 'sim_time')?.max >= 59e6; })()";
    browser.until(&tab, end);
    if let Some(pictures) = std::env::var_os("SQUEAKSCOPE_SCREENSHOTS") {
        // Without a graphics card the viewer paints seconds later.
        std::thread::sleep(std::time::Duration::from_secs(25));
        let picture = browser.screenshot(&tab);
        std::fs::write(Path::new(&pictures).join("view.png"), picture).expect("written");
    }
    // No other server was contacted: the viewer tries to, which its console reports as errors.
    let own = format!("http://{}/", viewed.host);
    for url in &browser.requested {
        let local = ["data:", "blob:"].iter().any(|kind| url.starts_with(kind));
        assert!(local || url.starts_with(&own), "{url}");
    }
}
