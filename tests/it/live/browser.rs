//! A headless browser, controlled through its debugging protocol.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
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
const STATE: &str = "(({ stage, run, state } = {}) => ({ drawn: stage?.drawn, received: run?.data.received, \
     panel: state?.panel }))(window.squeakscope)";

/// The browser of all tests, with the windows of one of them, which are closed at its end.
pub struct Browser {
    socket: Socket,
    calls: u64,
    /// Its windows have cookies and stored values of their own.
    context: Value,
    /// Addresses requested by the pages.
    pub requested: Vec<String>,
    /// Errors that the pages reported on their consoles.
    pub errors: Vec<String>,
}

/// A page, by its session.
#[derive(Clone, Debug)]
pub struct Tab(String);

/// Ends the browser and deletes its profile when the standard input is closed, as at the end of the tests.
const SCRIPT: &str = "profile=$(mktemp -d); \"$@\" --user-data-dir=\"$profile\" < /dev/null & \
     cat > /dev/null; kill $!; wait $!; rm -rf \"$profile\"";

/// Starts the browser for all tests. Returns it with its address.
fn launch(program: &PathBuf) -> (Child, String) {
    let mut child = Command::new("sh")
        .args(["-c", SCRIPT, "sh"])
        .arg(program)
        .args([
            "--headless=new",
            "--no-sandbox",
            "--remote-debugging-port=0",
            // As on a machine without a graphics card: the page is drawn by the processor, and only Rerun's viewer
            // of `view` needs an emulated card.
            "--disable-gpu",
            "--enable-unsafe-swiftshader",
            "--autoplay-policy=no-user-gesture-required",
            "--disable-background-networking",
            "--disable-backgrounding-occluded-windows",
            "--no-first-run",
            "--window-size=1280,720",
            "about:blank",
        ])
        .stdin(Stdio::piped())
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
    (child, address)
}

impl Browser {
    pub fn start(program: &PathBuf) -> Self {
        // Its standard input is open as long as this process.
        static RUNNING: OnceLock<(Child, String)> = OnceLock::new();
        let (_, address) = RUNNING.get_or_init(|| launch(program));
        let (host, path) = address.split_once('/').expect("a path");
        let mut browser = Self {
            socket: Socket::open(host, &format!("/{path}")),
            calls: 0,
            context: Value::Null,
            requested: Vec::new(),
            errors: Vec::new(),
        };
        let closed_at_the_end = json!({ "disposeOnDetach": true });
        let mut created = browser.call(None, "Target.createBrowserContext", &closed_at_the_end);
        browser.context = created["browserContextId"].take();
        browser
    }

    pub fn call(&mut self, tab: Option<&Tab>, method: &str, params: &Value) -> Value {
        let mut said = self.response(tab, method, params);
        assert!(said.get("error").is_none(), "{method}: {said:#}");
        said["result"].take()
    }

    /// The response to a command: its result or an error.
    fn response(&mut self, tab: Option<&Tab>, method: &str, params: &Value) -> Value {
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
            let said: Value = serde_json::from_str(&text).expect("JSON");
            self.note(&said);
            if said["id"] == self.calls {
                return said;
            }
        }
    }

    /// Notes a request of a page, or an error on its console.
    fn note(&mut self, said: &Value) {
        let params = &said["params"];
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        match said["method"].as_str() {
            Some("Network.requestWillBeSent") => {
                self.requested.push(text(&params["request"]["url"]));
            }
            Some("Network.webSocketCreated") => self.requested.push(text(&params["url"])),
            Some("Runtime.exceptionThrown") => {
                self.errors.push(params["exceptionDetails"].to_string());
            }
            Some("Log.entryAdded") if params["entry"]["level"] == "error" => {
                self.errors.push(params["entry"].to_string());
            }
            Some("Runtime.consoleAPICalled") if params["type"] == "error" => {
                self.errors.push(params["args"].to_string());
            }
            _ => {}
        }
    }

    /// Opens a page.
    pub fn open(&mut self, url: &str) -> Tab {
        let target = self.call(
            None,
            "Target.createTarget",
            &json!({ "url": "about:blank", "browserContextId": self.context }),
        );
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let attached = self.call(None, "Target.attachToTarget", &attach);
        let tab = Tab(attached["sessionId"]
            .as_str()
            .expect("a session")
            .to_owned());
        self.call(Some(&tab), "Network.enable", &json!({}));
        self.call(Some(&tab), "Page.enable", &json!({}));
        self.call(Some(&tab), "Runtime.enable", &json!({}));
        self.call(Some(&tab), "Log.enable", &json!({}));
        // A dark colour scheme, as on most presentation machines. A headless browser prefers reduced motion.
        self.emulate(&tab, "no-preference");
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

    /// Loads the page again, and waits until the old one is gone: until then it would answer the next question.
    pub fn reload(&mut self, tab: &Tab) {
        self.run(tab, "window.isOld = true; location.reload()");
        let is_new = json!({ "expression": "!window.isOld", "returnByValue": true });
        let began = Instant::now();
        // A question during the change of pages is answered by an error.
        while self.response(Some(tab), "Runtime.evaluate", &is_new)["result"]["result"]["value"]
            != true
        {
            assert!(began.elapsed() < DEADLINE, "the page was not loaded again");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Presses a key.
    pub fn press(&mut self, tab: &Tab, key: &str) {
        // A browser acts on some keys by their code only.
        let code = match key {
            "Tab" => 9,
            "Enter" => 13,
            "Escape" => 27,
            " " => 32,
            _ => 0,
        };
        let text = match key {
            "Enter" => "\r",
            key if key.len() == 1 => key,
            _ => "",
        };
        for kind in ["keyDown", "keyUp"] {
            let params =
                json!({ "type": kind, "key": key, "text": text, "windowsVirtualKeyCode": code });
            self.call(Some(tab), "Input.dispatchKeyEvent", &params);
        }
    }

    /// Touches the middle of an element with a finger.
    pub fn touch(&mut self, tab: &Tab, id: &str) {
        let [x, y] = self.middle(tab, id);
        for (kind, points) in [
            ("touchStart", json!([{ "x": x, "y": y }])),
            ("touchEnd", json!([])),
        ] {
            let params = json!({ "type": kind, "touchPoints": points });
            self.call(Some(tab), "Input.dispatchTouchEvent", &params);
        }
    }

    /// Clicks the middle of an element with the mouse.
    pub fn click(&mut self, tab: &Tab, id: &str) {
        let [x, y] = self.middle(tab, id);
        for kind in ["mousePressed", "mouseReleased"] {
            let params = json!({ "type": kind, "x": x, "y": y, "button": "left", "clickCount": 1 });
            self.call(Some(tab), "Input.dispatchMouseEvent", &params);
        }
    }

    /// Middle of an element, pixels.
    fn middle(&mut self, tab: &Tab, id: &str) -> [f64; 2] {
        let script = format!(
            "{{ const r = document.getElementById('{id}').getBoundingClientRect(); \
             [r.x + r.width / 2, r.y + r.height / 2] }}"
        );
        let middle = self.run(tab, &script);
        [0, 1].map(|k| middle[k].as_f64().expect("a position"))
    }

    /// Sets the size of the page, pixels.
    pub fn resize(&mut self, tab: &Tab, [width, height]: [u32; 2]) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 1000 });
        self.call(Some(tab), "Emulation.setDeviceMetricsOverride", &size);
    }

    /// Emulates a system with dark colours and a preference about motion: `reduce` or `no-preference`.
    pub fn emulate(&mut self, tab: &Tab, motion: &str) {
        let features = [
            ("prefers-color-scheme", "dark"),
            ("prefers-reduced-motion", motion),
        ];
        let features = features.map(|(name, value)| json!({ "name": name, "value": value }));
        let media = json!({ "features": features });
        self.call(Some(tab), "Emulation.setEmulatedMedia", &media);
    }

    /// Screenshot of the page as PNG.
    pub fn screenshot(&mut self, tab: &Tab) -> Vec<u8> {
        self.picture(tab, &json!({ "format": "png" }))
    }

    /// Screenshot of the page as lossy WebP, reduced in size.
    pub fn webp(
        &mut self,
        tab: &Tab,
        [width, height]: [u32; 2],
        [reduced, _]: [u32; 2],
    ) -> Vec<u8> {
        let scale = f64::from(reduced) / f64::from(width);
        let clip = json!({ "x": 0, "y": 0, "width": width, "height": height, "scale": scale });
        self.picture(
            tab,
            &json!({ "format": "webp", "quality": 30, "clip": clip }),
        )
    }

    fn picture(&mut self, tab: &Tab, params: &Value) -> Vec<u8> {
        let taken = self.call(Some(tab), "Page.captureScreenshot", params);
        let text = taken["data"].as_str().expect("a picture");
        base64::engine::general_purpose::STANDARD
            .decode(text)
            .expect("base64")
    }
}
