//! A headless browser, controlled through its debugging protocol.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use base64::Engine;
use serde_json::{Value, json};
use tungstenite::Message;

use super::{DEADLINE, Socket};

/// Possible names of the Chromium executable.
const NAMES: [&str; 4] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
];

/// Path of the browser: `SQUEAKSCOPE_CHROMIUM`, else from the `PATH`.
pub fn chromium() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("SQUEAKSCOPE_CHROMIUM") {
        return Some(named.into());
    }
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders)
        .flat_map(|folder| NAMES.map(|name| folder.join(name)))
        .find(|program| program.is_file())
}

/// State of the page, for the message of a timeout.
const STATE: &str = "({ seen: window.squeakscope?.host.seen(), bytes: window.squeakscope?.host.bytes, \
     panicked: window.squeakscope?.host.handle?.has_panicked(), loading: \
     document.getElementById('loading')?.textContent, panel: window.squeakscope?.state.panel })";

/// A browser that is stopped at the end of its test.
pub struct Browser {
    child: Child,
    socket: Socket,
    calls: u64,
    /// Addresses requested by the pages.
    pub requested: Vec<String>,
    _profile: tempfile::TempDir,
}

/// A page, by its session.
#[derive(Clone, Debug)]
pub struct Tab(String);

impl Browser {
    pub fn start(program: &PathBuf) -> Self {
        let profile = tempfile::tempdir().expect("temporary folder");
        let mut child = Command::new(program)
            .args([
                "--headless=new",
                "--no-sandbox",
                "--remote-debugging-port=0",
                "--enable-unsafe-swiftshader",
                "--use-angle=swiftshader",
                "--autoplay-policy=no-user-gesture-required",
                "--disable-background-networking",
                "--no-first-run",
                "--window-size=1600,900",
                "about:blank",
            ])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("started");
        let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines();
        let address = lines
            .by_ref()
            .map_while(Result::ok)
            .find_map(|line| {
                line.strip_prefix("DevTools listening on ws://")
                    .map(str::to_owned)
            })
            .expect("the browser prints its address");
        // Drains later output, which must not fill the pipe.
        std::thread::spawn(move || lines.map_while(Result::ok).for_each(drop));
        let (host, path) = address.split_once('/').expect("a path");
        Self {
            child,
            socket: Socket::open(host, &format!("/{path}")),
            calls: 0,
            requested: Vec::new(),
            _profile: profile,
        }
    }

    fn call(&mut self, tab: Option<&Tab>, method: &str, params: &Value) -> Value {
        self.calls += 1;
        let mut call = json!({ "id": self.calls, "method": method, "params": params });
        if let Some(Tab(session)) = tab {
            call["sessionId"] = json!(session);
        }
        self.socket.send(&call);
        let began = Instant::now();
        loop {
            assert!(began.elapsed() < DEADLINE, "no response to {method}");
            let Message::Text(text) = self.socket.next() else {
                continue;
            };
            let mut said: Value = serde_json::from_str(&text).expect("JSON");
            if said["method"] == "Network.requestWillBeSent" {
                let url = said["params"]["request"]["url"]
                    .as_str()
                    .unwrap_or_default();
                self.requested.push(url.to_owned());
            }
            if said["method"] == "Network.webSocketCreated" {
                let url = said["params"]["url"].as_str().unwrap_or_default();
                self.requested.push(url.to_owned());
            }
            if said["id"] == self.calls {
                assert!(said.get("error").is_none(), "{method}: {said:#}");
                return said["result"].take();
            }
        }
    }

    /// Opens a page.
    pub fn open(&mut self, url: &str) -> Tab {
        let target = self.call(
            None,
            "Target.createTarget",
            &json!({ "url": "about:blank" }),
        );
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let attached = self.call(None, "Target.attachToTarget", &attach);
        let tab = Tab(attached["sessionId"]
            .as_str()
            .expect("a session")
            .to_owned());
        self.call(Some(&tab), "Network.enable", &json!({}));
        self.call(Some(&tab), "Page.enable", &json!({}));
        // A dark colour scheme, as on most presentation machines.
        let dark = json!({ "features": [{ "name": "prefers-color-scheme", "value": "dark" }] });
        self.call(Some(&tab), "Emulation.setEmulatedMedia", &dark);
        self.call(Some(&tab), "Page.navigate", &json!({ "url": url }));
        tab
    }

    /// Value of a JavaScript expression.
    pub fn run(&mut self, tab: &Tab, script: &str) -> Value {
        let params = json!({
            "expression": script,
            "awaitPromise": true,
            "returnByValue": true,
            "userGesture": true,
        });
        let mut done = self.call(Some(tab), "Runtime.evaluate", &params);
        assert!(done.get("exceptionDetails").is_none(), "{script}: {done:#}");
        done["result"]["value"].take()
    }

    /// Waits until a JavaScript expression is truthy, and returns its value.
    pub fn until(&mut self, tab: &Tab, script: &str) -> Value {
        let began = Instant::now();
        loop {
            let value = self.run(tab, script);
            let holds = match &value {
                Value::Bool(holds) => *holds,
                Value::Null => false,
                Value::Number(number) => number.as_f64() != Some(0.0),
                _ => true,
            };
            if holds {
                return value;
            }
            if began.elapsed() > DEADLINE {
                let state = self.run(tab, STATE);
                panic!("timeout: {script}, but {value}; {state:#}");
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Presses a key.
    pub fn press(&mut self, tab: &Tab, key: &str) {
        for kind in ["keyDown", "keyUp"] {
            let params =
                json!({ "type": kind, "key": key, "text": if key.len() == 1 { key } else { "" } });
            self.call(Some(tab), "Input.dispatchKeyEvent", &params);
        }
    }

    /// Screenshot of the page as PNG.
    pub fn screenshot(&mut self, tab: &Tab) -> Vec<u8> {
        let taken = self.call(
            Some(tab),
            "Page.captureScreenshot",
            &json!({ "format": "png" }),
        );
        let text = taken["data"].as_str().expect("a picture");
        base64::engine::general_purpose::STANDARD
            .decode(text)
            .expect("base64")
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // It may have stopped already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
